"""``camopt certify``."""

from typing import Any

import click

from camopt.cli.exits import NOT_REACHED, NOTHING_FEASIBLE
from camopt.cli.options import (
    Command,
    given_overrides,
    output_options,
    override_options,
    row_option,
    scene_at,
)


@click.command(cls=Command)
@click.argument("target")
@override_options
@row_option
@output_options
def certify(target: str, as_json: bool, quiet: bool, row: int | None, **overrides: Any) -> int:
    """Prove that the limits are met at every cam angle, in ball arithmetic.

    TARGET is a scene, or a table written by a sweep. The verdict on a limit is "held" (it is proved to be met),
    "broken" (it is proved not to be met) or "undecided". To a table, the verdict on each row is added as a column;
    with --row, only that row is checked, and nothing is written.
    """
    from camopt.cli import terminal
    from camopt.cli.commands.certify_report import show_counts, show_verdicts

    changes = given_overrides(overrides)
    if target.endswith(".parquet") and row is None:
        from camopt.front.certified import certify_table
        from camopt.mistakes import BadInput, Mistake

        if changes:
            allowed = "is not possible with a table, which has the limits of its sweep"
            given = dict(reversed([*changes.values()]))  # of what an option changes, the first is its value
            raise BadInput([Mistake("camopt", name, value, allowed, bare=True) for name, value in given.items()])
        with terminal.progress(quiet, "rows") as advance:
            counts = certify_table(target, advance)
        show_counts(counts, as_json)
        verdicts = set(counts)
    else:
        from camopt.verdicts.certify import certify as prove

        allowed = "a TOML file, a shipped scene or a table of designs (.parquet)"
        scene = scene_at(target, row, changes, "target", allowed)
        found = prove(scene)
        show_verdicts(found, as_json, scene.search.robust)
        verdicts = set(found.values())
    return NOTHING_FEASIBLE if "broken" in verdicts else NOT_REACHED if "undecided" in verdicts else 0
