"""``camopt merge``."""

from pathlib import Path

import click

import camopt
from camopt import cli
from camopt.cli.options import Command, OutputPlace, again_option, output_options


@click.command(cls=Command)
@click.argument("parts", nargs=-1, required=True, metavar="FOLDER...")
@output_options
@click.option("--out", type=OutputPlace(), default="camopt-out", show_default=True, help="Folder for the tables.")
@again_option
def merge(parts: tuple[str, ...], as_json: bool, quiet: bool, out: Path, again: bool) -> int:
    """Put the parts of a sweep together: the tables that one run would have written.

    FOLDERs hold what `camopt sweep --part` wrote, in them or in folders inside them.
    """
    with cli.progress(quiet, "designs") as advance:
        result = camopt.merge(
            parts, out, progress=advance, tell=cli.say_lost if quiet else cli.say_note, again=again
        )
    return cli.print_result(result, as_json, quiet, [] if result.already_done else result.files)
