"""``camopt report``."""

from pathlib import Path
from typing import Any

import click

from camopt.cli.options import (
    Changes,
    Command,
    OutputPlace,
    check_file,
    given_overrides,
    output_options,
    outputs_option,
    override_options,
    row_option,
    scene_at,
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
    from camopt.cli import terminal
    from camopt.reporting.report import report as run

    changes = given_overrides(overrides)
    shown = [_target_at(target, row, changes) for target in what]
    for each in shown:
        if hasattr(each, "file"):
            check_file(each.file, out)
    with terminal.progress(quiet, ""):
        run(shown, out)
    if as_json:
        terminal.print_json({"file": str(out)})
    elif not quiet:
        terminal.say_written([out])
    return 0


def _target_at(target: str, row: int | None, changes: Changes) -> Any:
    """What a page shows: a scene, changed as asked; a folder or a whole table as it is."""
    from camopt.mistakes import BadInput, Mistake
    from camopt.scene.scene import RESULTS

    if row is not None and Path(target).is_dir():
        why = f"belongs to a table; {target} is a folder: name one of the tables in it"
        raise BadInput([Mistake("camopt", "--row", row, why, bare=True)])
    if row is None and Path(target).exists() and Path(target).suffix not in ("", ".toml", ".parquet"):
        return target  # which says what it takes
    if row is not None or not (Path(target).is_dir() or target.endswith(".parquet")):
        return scene_at(target, row, changes, "what", RESULTS)
    for option, value in changes.values():
        why = f"belongs to a scene; {target} is a result, whose numbers stay as they are"
        raise BadInput([Mistake("camopt", option, value, why, bare=True)])
    return target
