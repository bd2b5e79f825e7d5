"""``camopt schema``."""

import click

from camopt import cli, library
from camopt.cli.options import Command, output_options


@click.command(cls=Command)
@output_options
def schema(as_json: bool, quiet: bool) -> int:
    """Print the JSON Schema of scenes, by which editors complete keys and mark mistakes."""
    cli.print_json(library.scene_schema())
    return 0
