"""``camopt scenes``."""

import click

from camopt import cli
from camopt.cli.options import Command, output_options


@click.command(cls=Command)
@click.argument("name", required=False)
@output_options
def scenes(name: str | None, as_json: bool, quiet: bool) -> int:
    """List the scenes that come with camopt; with a NAME, print that one as TOML."""
    cli.show_scenes(name, as_json)
    return 0
