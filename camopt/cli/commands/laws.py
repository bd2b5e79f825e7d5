"""``camopt laws``."""

import click

from camopt.cli.options import Command, output_options


@click.command(cls=Command)
@output_options
def laws(as_json: bool, quiet: bool) -> int:
    """List the motion laws with their peak velocity, acceleration and jerk."""
    from camopt.cli import terminal
    from camopt.cli.commands.laws_report import show_laws

    with terminal.progress(quiet, ""):
        show_laws(as_json)
    return 0
