"""``camopt report``."""

from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli
from camopt.cli.options import (
    Command,
    OutputPlace,
    check_file,
    given_overrides,
    output_options,
    outputs_option,
    override_options,
    row_option,
)


@click.command(cls=Command)
@click.argument("what", nargs=-1, required=True, metavar="WHAT...")
@row_option
@outputs_option
@override_options
@output_options
@click.option("--out", type=OutputPlace(".html"), default="camopt-report.html", show_default=True, help="The page.")
def report(what: tuple[str, ...], row: int | None, as_json: bool, quiet: bool, out: Path, **overrides: Any) -> int:
    """Write one HTML page that shows a result to others: no network, no server, nothing to install.

    WHAT is a scene, or the folder or table that a command wrote. A cam turns under its follower, with diagrams,
    limits, proofs and files; up to four are shown side by side. Tables of designs can be filtered, sorted and
    clicked on.
    """
    changes = given_overrides(overrides)
    shown = [cli.shown_at(target, row, changes) for target in what]
    for each in shown:
        if hasattr(each, "file"):
            check_file(each.file, out)
    with cli.progress(quiet, ""):
        camopt.report(shown, out)
    if as_json:
        cli.print_json({"file": str(out)})
    elif not quiet:
        cli.say_written([out])
    return 0
