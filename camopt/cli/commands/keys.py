"""``camopt keys``."""

import click

from camopt import cli, library
from camopt.cli.options import Command, output_options


@click.command(cls=Command)
@click.argument("table", required=False)
@output_options
def keys(table: str | None, as_json: bool, quiet: bool) -> int:
    """List the keys of a scene: what each is, its unit, what it allows, and what it is if not given.

    TABLE is a table, such as cam or follower.dynamics, or a key, such as rpm or cam.rpm; all without one.
    """
    return cli.print_result(library.list_keys(table), as_json, quiet)
