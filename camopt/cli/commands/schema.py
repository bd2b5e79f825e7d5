"""``camopt schema``."""

import click

from camopt import cli
from camopt.cli.options import Command, output_options


@click.command(cls=Command)
@output_options
def schema(as_json: bool, quiet: bool) -> int:
    """Print the JSON Schema of scenes, by which editors complete keys and mark mistakes."""
    cli.show_schema()
    return 0
