"""``camopt laws``."""

import click

from camopt import cli, library
from camopt.cli.options import Command, output_options


@click.command(cls=Command)
@output_options
def laws(as_json: bool, quiet: bool) -> int:
    """List the motion laws with their peak velocity, acceleration and jerk."""
    with cli.progress(quiet, ""):
        result = library.list_laws()
    return cli.print_result(result, as_json, quiet)
