"""``camopt schema``."""

import click

from camopt.cli.options import Command, output_options


@click.command(cls=Command)
@output_options
def schema(as_json: bool, quiet: bool) -> int:
    """Print the JSON Schema of scenes, by which editors complete keys and mark mistakes."""
    from camopt.cli import terminal
    from camopt.scene.schema import scene_schema

    terminal.print_json(scene_schema())
    return 0
