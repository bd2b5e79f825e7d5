"""``camopt merge``."""

from pathlib import Path

import click

from camopt.cli.exits import NOTHING_FEASIBLE, reached
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
    from camopt.cli import terminal
    from camopt.cli.commands.sweep_report import show_sweep
    from camopt.front.parts import merge as run

    with terminal.progress(quiet, "designs") as advance:
        result = run(parts, out, advance, terminal.say_lost if quiet else terminal.say_note, again)
    show_sweep(result, as_json)
    if not quiet:
        terminal.say_written([] if result.already_done else result.files)
    return reached(result.scene, result.reached) if result.pareto else NOTHING_FEASIBLE
