"""``camopt certify``."""

from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.cli.options import (
    Command,
    given_overrides,
    output_options,
    override_options,
    row_option,
)
from camopt.mistakes import BadInput, Mistake


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
    changes = given_overrides(overrides)
    if not target.endswith(".parquet") or row is not None:
        allowed = "a TOML file, a shipped scene or a table of designs (.parquet)"
        scene = cli.scene_at(target, row, changes, "target", allowed)
        return cli.print_result(camopt.certify(scene), as_json, quiet)
    if changes:
        allowed = "is not possible with a table, which has the limits of its sweep"
        given = dict(reversed([*changes.values()]))  # of what an option changes, the first is its value
        raise BadInput([Mistake("camopt", name, value, allowed, bare=True) for name, value in given.items()])
    with cli.progress(quiet, "rows") as advance:
        result = library.certify_table(target, advance)
    return cli.print_result(result, as_json, quiet)
