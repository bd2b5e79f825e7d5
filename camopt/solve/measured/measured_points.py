"""Points of a measured cam from a file or an array, and their angles on the turn."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import narwhals.stable.v2 as nw
import numpy as np
from numpy.typing import ArrayLike

from camopt.core.mistakes import BadInput
from camopt.core.numerics import ComplexArray, FloatArray, IntArray
from camopt.core.quantities.unit_systems import MM, shown_system
from camopt.core.storage.files import read_bytes
from camopt.solve.measured.columns import (
    LARGEST_MEASURED,
    MM_PER_UNIT,
    TURN_IN_UNIT,
    XY_TABLE,
    TableReadingOptions,
    find_columns_and_unit,
    units_in_heading,
)
from camopt.solve.measured.delimited_text import decode_text, text_rows
from camopt.solve.measured.drawing_points import is_drawing, read_drawing
from camopt.solve.measured.number_table import NumberTable, file_mistake, number_table
from camopt.solve.measured.s96 import S96_SUFFIX, lifts_of_s96_turn
from camopt.solve.measured.workbook import WORKBOOK_STARTS, workbook_rows

TURN_DEG = 360.0
SHOWN_ITEMS = 6  # items of a list that a message shows
FEWEST_MEASURED = 12  # least number of points
ROWS_ALLOWED = "must be a path, or rows of an angle and a lift"
CLOSED_COUNTS = (361, 721, 1441, 3601)
"""Numbers of lifts in one column whose last lift repeats the first, a turn later."""


@dataclass(frozen=True)
class MeasuredPoints:
    """Measured points of one turn in the order of their cam angles.

    ``angles`` are in deg from 0 to 360 (each an exact number), ``lifts`` in mm (deg when oscillating), and ``rows``
    are those of the file. ``step`` is the rounding of the lifts, or 0 if none shows. Points are missing in a gap of
    more than ``widest`` deg.
    """

    file: str
    angles: FloatArray
    lifts: FloatArray
    rows: IntArray
    step: float
    widest: float = 10.0
    unit_said: bool = True
    """Whether the unit of the lifts was given, or is in their heading."""

    def pick_places(self, places: Sequence[int]) -> "MeasuredPoints":
        """The points at some places."""
        chosen = np.sort(np.array(places, dtype=np.intp))
        return replace(self, angles=self.angles[chosen], lifts=self.lifts[chosen], rows=self.rows[chosen])

    def drop_places(self, places: Sequence[int]) -> "MeasuredPoints":
        """The points without those at some places."""
        return self.pick_places(np.setdiff1d(np.arange(self.rows.size), places).tolist())

    def drop_copies(self) -> "MeasuredPoints":
        """The points without copies of others, which have no errors of their own.

        If some lifts at one angle differ, all points are measurements: rounding makes some of these equal.
        """
        _, places = np.unique(np.column_stack([self.angles, self.lifts]), axis=0, return_index=True)
        return self.pick_places(places.tolist()) if places.size == np.unique(self.angles).size else self


def forward_angle_deg(start: FloatArray | float, end: FloatArray | float) -> FloatArray:
    """Angle forward from one cam angle to another, from 0 to less than a turn [deg]."""
    # twice, because a tiny negative angle becomes a whole turn by rounding
    return np.mod(np.mod(np.asarray(end) - start, TURN_DEG), TURN_DEG)


def read_points(source: str | os.PathLike[str] | ArrayLike, reading_options: TableReadingOptions) -> MeasuredPoints:
    """The points of a file (text or a workbook), or of an array of rows (angle, lift) or lifts.

    Points of a profile have distances from the cam's axis in place of lifts. The angle of a point x, y is the one
    at which a radial follower above the axis meets it, if the cam turns ccw.

    Raises
    ------
    BadInput
        With the row that is no point of a turn, and what is allowed there.
    OSError
        If the file cannot be read.
    """
    reading_options.check_options()
    default_unit = MM
    if isinstance(source, (str, os.PathLike)):
        name, default_unit = os.fsdecode(source), shown_system()
        table, reading_options = _table_of_file(name, reading_options)
    else:
        name = "points"
        table = _table_of_array(name, source)
    place, second_place, unit = find_columns_and_unit(name, table, reading_options, default_unit)
    lifts = table.numbers[:, second_place]
    turn_angle = reading_options.turn or TURN_IN_UNIT[reading_options.angle_unit]
    if place is None:
        count = lifts.size - (lifts.size in CLOSED_COUNTS)
        angles = np.arange(lifts.size, dtype=np.float64) * (turn_angle / count)
    else:
        angles = table.numbers[:, place]
    _check_numbers(name, table, {reading_options.kind.first: angles, reading_options.kind.second: lifts})
    step, unit_size = _rounding_step(lifts), MM_PER_UNIT.get(unit, 1.0)
    if reading_options.kind is XY_TABLE:
        angles, lifts = _polar_coordinates(name, table, angles + 1j * lifts)
        turn_angle = TURN_DEG
    _check_within_one_turn(name, table, angles, turn_angle)
    if lifts.max() == lifts.min():
        what = "distance" if reading_options.kind is XY_TABLE else reading_options.kind.second
        raise file_mistake(
            name, f"row {table.rows[0]}", float(lifts[0]), f"all rows have this {what}: the follower does not move"
        )
    angles_deg = forward_angle_deg(0.0, angles * (TURN_DEG / turn_angle))
    order = np.argsort(angles_deg, kind="stable")
    return MeasuredPoints(
        name,
        angles_deg[order],
        lifts[order] * unit_size,
        table.rows[order],
        step * unit_size,
        unit_said=bool(units_in_heading(table.names[second_place])),
    ).drop_copies()


def _table_of_file(file: str, reading_options: TableReadingOptions) -> tuple[NumberTable, TableReadingOptions]:
    """The numbers of a file, and its columns, of which some kinds of files leave nothing to say."""
    try:
        data = read_bytes(file)
    except BadInput as error:
        raise file_mistake(file, "file", None, f"must be {error.mistakes[0].allowed}") from None
    try:
        if is_drawing(file):
            return read_drawing(Path(file), reading_options)
        rows = workbook_rows(data) if data.startswith(WORKBOOK_STARTS) else text_rows(decode_text(data))
    except ValueError as trouble:
        raise file_mistake(file, "file", None, str(trouble)) from None
    table = number_table(file, rows)
    return (
        lifts_of_s96_turn(file, table, reading_options)
        if Path(file).suffix.lower() == S96_SUFFIX
        else (table, reading_options)
    )


def _table_of_array(file: str, source: Any) -> NumberTable:
    try:
        columns = _named_columns(source)
        numbers = np.array(
            source if columns is None else [np.array(values_, dtype=float) for _, values_ in columns]
        )
        numbers = numbers.astype(float) if columns is None else numbers.T
    except (TypeError, ValueError):
        raise file_mistake(file, "rows", None, ROWS_ALLOWED) from None
    numbers = numbers[:, None] if numbers.ndim == 1 else numbers
    if numbers.ndim != 2 or not numbers.size:
        raise file_mistake(file, "rows", None, ROWS_ALLOWED)
    names = [""] * numbers.shape[1] if columns is None else [values_ for values_, _ in columns]
    return NumberTable(numbers, np.arange(1, len(numbers) + 1), tuple(names))


def _named_columns(source: Any) -> list[tuple[str, Any]] | None:
    """The columns of a mapping, a series or a table, with their names; None for an array.

    A pandas index is a column too, unless it only counts rows. It is the first column beside a single one, else the
    last.
    """
    if isinstance(source, Mapping):
        return [(str(name), values) for name, values in source.items()]
    table = nw.from_native(source, pass_through=True, allow_series=True, eager_only=True)
    if not isinstance(table, (nw.Series, nw.DataFrame)):
        return None
    series = [table] if isinstance(table, nw.Series) else [*table.iter_columns()]
    named_columns = [(column.name if isinstance(column.name, str) else "", column.to_numpy()) for column in series]
    index = nw.maybe_get_index(table)
    if index is None:
        return named_columns
    # pandas gives rows without an index the numbers 0, 1, 2, …
    only_counts = type(index).__name__ == "RangeIndex" and (index.start, index.step) == (0, 1)
    if index.name is None and (len(named_columns) > 1 or only_counts):
        return named_columns
    index_column = (index.name if isinstance(index.name, str) else "", index)
    return [index_column, *named_columns] if len(named_columns) == 1 else [*named_columns, index_column]


# ----------------------------------------------------------------------------------------------------- points


def _check_numbers(file: str, table: NumberTable, columns: Mapping[str, FloatArray]) -> None:
    """BadInput for too few numbers, or for one that is too large."""
    for what, values in columns.items():
        far = np.flatnonzero(~(np.abs(values) <= LARGEST_MEASURED))
        if far.size:
            raise file_mistake(
                file,
                f"row {table.rows[far[0]]}",
                float(values[far[0]]),
                f"the {what} must be within ±{LARGEST_MEASURED:g}",
            )
    if len(table.rows) < FEWEST_MEASURED:
        raise file_mistake(file, "rows", len(table.rows), f"must be at least {FEWEST_MEASURED} points")


def _check_within_one_turn(file: str, table: NumberTable, angles: FloatArray, turn: float) -> None:
    """BadInput if angles are not those of one turn, or too few of them differ."""
    low, high = int(angles.argmin()), int(angles.argmax())
    if angles[high] - angles[low] > turn * (1.0 + 1e-9):
        problem_text = (
            f"the angles go from {angles[low]:g} (row {table.rows[low]}) to {angles[high]:g}, more than a turn"
        )
        hint = "give 720 as the turn if they are of a crankshaft" if turn == TURN_DEG else f"a turn is {turn:g}"
        raise file_mistake(file, f"row {table.rows[high]}", float(angles[high]), f"{problem_text}; {hint}")
    if (count := np.unique(angles).size) < FEWEST_MEASURED:
        raise file_mistake(file, "angles", count, f"must be at least {FEWEST_MEASURED} different ones")


def _polar_coordinates(file: str, table: NumberTable, points: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Angles [deg, from 0 to a turn] and distances of points x + iy, which must surround the axis at 0, 0."""
    for place in np.flatnonzero(points == 0.0):
        raise file_mistake(
            file, f"row {table.rows[place]}", None, "is on the axis of the cam, which is at x = 0, y = 0"
        )
    angles = np.mod(TURN_DEG / 4.0 - np.degrees(np.angle(points)), TURN_DEG)
    steps = np.diff(np.sort(angles), append=angles.min() + TURN_DEG)
    if steps.max() >= TURN_DEG / 2.0:
        what = f"do not go round the axis of the cam, which is at x = 0, y = 0: none over {steps.max():.4g} deg"
        raise file_mistake(file, "points", None, what)
    return angles, np.abs(points)


def _rounding_step(lifts: FloatArray) -> float:
    """Rounding of lifts: the largest power of ten that divides all of them; 0 if it is less than 1e-6."""
    for digits in range(7):
        if np.abs(lifts - np.round(lifts, digits)).max() <= 1e-12 * np.abs(lifts).max():
            return float(10.0**-digits)
    return 0.0


def shortened_list(items: Sequence[Any] | IntArray) -> str:
    """The first items of a list, in words."""
    return ", ".join(map(str, items[:SHOWN_ITEMS])) + (" and others" if len(items) > SHOWN_ITEMS else "")
