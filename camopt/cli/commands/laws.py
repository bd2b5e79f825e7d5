"""``camopt laws``."""

import click

from camopt import cli
from camopt.cli.options import Command, output_options


@click.command(cls=Command)
@output_options
def laws(as_json: bool, quiet: bool) -> int:
    """List the motion laws with their peak velocity, acceleration and jerk."""
    with cli.progress(quiet, ""):
        cli.show_laws(as_json)
    return 0
