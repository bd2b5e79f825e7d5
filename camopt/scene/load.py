"""The external loads of a scene: constant, or tables over the turn from rows or a CSV file."""

from collections.abc import Iterator
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.model.motion.load import ExternalLoad
from camopt.scene.csv_columns import MOST_SPANS, read_csv_columns
from camopt.scene.law_forms import LEAST_GAP, VALUE_IN_SCENE, Fault
from camopt.scene.mapping import tables_in_list, value_at_key
from camopt.scene.own_laws import LARGEST_NUMBER

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

FILE_COLUMNS = ("angle", "load")
ROW_MESSAGE = "must be a row [cam angle in deg, load]"


def split_constant_and_changing_load(load: Any, unit_in_N_or_N_mm: float) -> tuple[float, ExternalLoad | None]:
    """The constant part of a faultless load [N or N·mm], and the part that changes over the turn.

    ``unit_in_N_or_N_mm`` is that of the load in N (N·mm). A table with a single value is a constant.
    """
    if not isinstance(load, tuple):
        return (0.0 if load is None else load) * unit_in_N_or_N_mm, None
    values = {value for _, value in load}
    if len(values) == 1:
        return values.pop() * unit_in_N_or_N_mm, None
    return 0.0, ExternalLoad(load, unit_in_N_or_N_mm)


def replace_load_files(data: dict[str, Any], folder: Path | None) -> Iterator[Fault]:
    """Replace each file that a load names by its rows, in ``data`` itself.

    Paths are relative to ``folder``; None if the scene may not name files.
    """
    tables = {"follower.dynamics.load": value_at_key(data, "follower.dynamics")}
    tables |= {f"train.{k}.load": stage for k, stage in enumerate(tables_in_list(data.get("train")), start=1)}
    for key, table in tables.items():
        load = table.get("load") if isinstance(table, dict) else None
        if isinstance(load, str):
            try:
                columns = read_csv_columns(folder, load, FILE_COLUMNS)
            except ValueError as trouble:
                yield key, load, str(trouble)
            else:
                table["load"] = [list(row) for row in zip(*columns.values(), strict=True)]


def check_load(scene: "Scene") -> Iterator[Fault]:
    """The first fault of the rows of each load."""
    loads = {"follower.dynamics.load": scene.follower.dynamics and scene.follower.dynamics.load}
    loads |= {f"train.{number}.load": stage.load for number, stage in enumerate(scene.train, start=1)}
    for key, rows in loads.items():
        if isinstance(rows, tuple):
            yield from _check_load_rows(key, rows)


def _check_load_rows(key: str, rows: tuple[Any, ...]) -> Iterator[Fault]:
    """The first fault of the rows of a load."""
    if not 1 <= len(rows) <= MOST_SPANS:
        yield key, None, f"has {len(rows)} rows; it must have 1 to {MOST_SPANS}"
        return
    for number, row in enumerate(rows, start=1):
        is_pair = isinstance(row, tuple) and len(row) == 2 and bool not in map(type, row)
        if not is_pair or not all(isinstance(value, (int, float)) and abs(value) < inf for value in row):
            yield f"{key}.{number}", VALUE_IN_SCENE, ROW_MESSAGE
            return
        angle, load = row
        if not 0.0 <= angle <= 360.0:
            yield f"{key}.{number}", angle, "must have a cam angle from 0 to 360 deg"
            return
        if abs(load) > LARGEST_NUMBER:
            yield f"{key}.{number}", load, f"must have a load from {-LARGEST_NUMBER:g} to {LARGEST_NUMBER:g}"
            return
    yield from _check_angle_order(key, [row[0] for row in rows])


def _check_angle_order(key: str, angles: list[float]) -> Iterator[Fault]:
    """Check that cam angles increase; two rows may share one (0 and 360 deg too), where the load jumps."""
    for number, (before, after) in enumerate(pairwise(angles), start=2):
        if before != after and not after - before >= LEAST_GAP:
            why = f"must have a cam angle equal to the {before:g} deg before it, or at least {LEAST_GAP:g} more"
            yield f"{key}.{number}", after, why
            return
    if 0.0 < angles[0] + 360.0 - angles[-1] < LEAST_GAP:
        yield (
            f"{key}.{len(angles)}",
            angles[-1],
            f"must be the first cam angle + 360 deg exactly, or at least {LEAST_GAP:g} deg less than that",
        )
        return
    wrapped = [angle % 360.0 for angle in angles]
    for number, angle in enumerate(wrapped, start=1):
        if wrapped.count(angle) > 2:
            yield f"{key}.{number}", angle, "more than two rows have this cam angle; a jump has two"
            return
