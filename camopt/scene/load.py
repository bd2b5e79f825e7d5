"""The external load of a scene: a constant, or a table over the turn, given as rows or as a CSV file.

The checks work on the plain mapping of a scene, as those of ``scene.checks`` do.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import Any

from camopt.motion.load import ExternalLoad
from camopt.scene.csv_columns import MOST_SPANS, read_columns
from camopt.scene.law_forms import LEAST_GAP, Fault
from camopt.scene.own_laws import LARGEST_NUMBER

KEY = "follower.dynamics.load"
FILE_COLUMNS = ("angle", "load")
ROW_MESSAGE = "must be a row [cam angle in deg, load]"


def constant_and_changing(load: Any, unit: float) -> tuple[float, ExternalLoad | None]:
    """The constant part of a faultless load, in N (N·mm), and the part that changes over the turn.

    ``unit`` of the load in N (N·mm). A table of one value is that constant.
    """
    if not isinstance(load, tuple):
        return (load or 0.0) * unit, None
    values = {value for _, value in load}
    if len(values) == 1:
        return values.pop() * unit, None
    return 0.0, ExternalLoad(load, unit)


def _given(data: Mapping[str, Any]) -> tuple[Any, Any]:
    """The table ``follower.dynamics`` and its load; None where there is none."""
    follower = data.get("follower")
    dynamics = follower.get("dynamics") if isinstance(follower, Mapping) else None
    return (dynamics, dynamics.get("load")) if isinstance(dynamics, Mapping) else (None, None)


def read_load(data: dict[str, Any], folder: Path | None) -> Iterator[Fault]:
    """Put the rows of a load that names a file in place of the name, in ``data`` itself.

    ``folder`` is where files are looked for; None if none may be named.
    """
    dynamics, load = _given(data)
    if isinstance(load, str):
        try:
            columns = read_columns(folder, load, FILE_COLUMNS)
        except ValueError as trouble:
            yield KEY, load, str(trouble)
        else:
            dynamics["load"] = [list(row) for row in zip(*columns.values(), strict=True)]


def check_load(data: Mapping[str, Any]) -> Iterator[Fault]:
    """The first fault of the rows of a load."""
    _, rows = _given(data)
    if not isinstance(rows, list):
        return
    if not 1 <= len(rows) <= MOST_SPANS:
        yield KEY, None, f"has {len(rows)} rows; it must have 1 to {MOST_SPANS}"
        return
    for number, row in enumerate(rows, start=1):
        if not isinstance(row, list) or len(row) != 2 or not all(map(_is_number, row)):
            yield f"{KEY}.{number}", row, ROW_MESSAGE
            return
        angle, load = row
        if not 0.0 <= angle <= 360.0:
            yield f"{KEY}.{number}", angle, "must have a cam angle from 0 to 360 deg"
            return
        if abs(load) > LARGEST_NUMBER:
            yield f"{KEY}.{number}", load, f"must have a load from {-LARGEST_NUMBER:g} to {LARGEST_NUMBER:g}"
            return
    yield from _order([row[0] for row in rows])


def _order(angles: list[float]) -> Iterator[Fault]:
    """Cam angles go up; two are the same where the load jumps, 0 and 360 deg too."""
    for number, (before, after) in enumerate(pairwise(angles), start=2):
        if before != after and not after - before >= LEAST_GAP:
            why = (
                f"must have a cam angle above the {before:g} deg before it, by {LEAST_GAP:g} at least, or the same"
            )
            yield f"{KEY}.{number}", after, why
            return
    if 0.0 < angles[0] + 360.0 - angles[-1] < LEAST_GAP:
        yield (
            f"{KEY}.{len(angles)}",
            angles[-1],
            f"must be one turn after the first cam angle, or at least {LEAST_GAP:g} deg less",
        )
        return
    turned = [angle % 360.0 for angle in angles]
    for number, angle in enumerate(turned, start=1):
        if turned.count(angle) > 2:
            yield f"{KEY}.{number}", angle, "is a cam angle of more than two rows; a jump has two"
            return


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < inf
