"""Points of a measured cam from a file: which columns they are, in which units, and how they lie on the turn."""

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camopt.files import read_bytes
from camopt.measured.delimited import decoded, text_rows
from camopt.measured.number_table import NumberTable, bad, number_table
from camopt.measured.workbook import WORKBOOKS, workbook_rows
from camopt.mistakes import BadInput, Mistake
from camopt.numerics import FloatArray

INCH = 25.4  # mm
TURN = 360.0
FEWEST = 12  # points
FAR = 1e6  # that an angle or a lift may be from 0
CLOSED = (361, 721, 1441, 3601)
"""Numbers of lifts in one column of which the last is the first of the next turn."""
ANGLE_UNITS, LIFT_UNITS = ("deg", "rad"), ("mm", "inch", "deg")
SPELLED = {
    **dict.fromkeys(("mm", "millimetre", "millimeter", "millimetres", "millimeters"), "mm"),
    **dict.fromkeys(("inch", "inches", "in", "zoll", '"'), "inch"),
    **dict.fromkeys(("deg", "degree", "degrees", "grad", "°"), "deg"),
    **dict.fromkeys(("rad", "radian", "radians"), "rad"),
    **dict.fromkeys(("µm", "μm", "um", "micron", "microns"), "µm"),
    **dict.fromkeys(("mil", "mils", "thou"), "mil"),
}
"""Units in the words above a column."""
ANGLES = re.compile(r"angle|winkel|deg|°|grad|rad|theta|θ|phi|φ|rotation", re.IGNORECASE)
LIFTS = re.compile(r"lift|hub|displacement|travel|rise|stroke|weg|height|\by\b|\bs\b", re.IGNORECASE)


@dataclass(frozen=True)
class Points:
    """Measured points of one turn in the order of their cam angles.

    ``angles`` in deg from 0 to 360 (each an exact number), ``lifts`` in mm (deg when oscillating), ``rows`` of the
    file; ``step`` is what the lifts are rounded to, 0 if nothing shows that they are.
    """

    file: str
    angles: FloatArray
    lifts: FloatArray
    rows: NDArray[np.int64]
    step: float

    def only(self, places: Sequence[int]) -> "Points":
        """Some of the points, by their places."""
        chosen = np.sort(np.array(places, dtype=np.intp))
        return Points(self.file, self.angles[chosen], self.lifts[chosen], self.rows[chosen], self.step)

    def without(self, places: Sequence[int]) -> "Points":
        """The points but for some."""
        return self.only(np.setdiff1d(np.arange(self.rows.size), places).tolist())


@dataclass(frozen=True)
class Columns:
    """What the columns of a table are: their names or numbers (from 1), units, and the angle of a whole turn.

    None stands for what the table itself says. ``turn`` is in the unit of the angles: 720 deg of a crankshaft.
    """

    chosen: Sequence[str | int] | None = None
    angle_unit: str = "deg"
    lift_unit: str = "mm"
    turn: float | None = None


def apart(start: float, end: FloatArray | float) -> FloatArray:
    """How far it is from one cam angle on to another, from 0 to a turn, deg."""
    return np.mod(np.asarray(end) - start, TURN)


def read_points(source: str | os.PathLike[str] | ArrayLike, columns: Columns) -> Points:
    """The points of a file (text or a workbook), or of an array of rows (angle, lift) or lifts.

    Raises
    ------
    BadInput
        With the row that is no point of a turn, and what is allowed there.
    OSError
        If the file cannot be read.
    """
    _check(columns)
    if isinstance(source, (str, os.PathLike)):
        name = os.fsdecode(source)
        table = _table_of(name, _bytes_of(name))
    else:
        name = "points"
        table = _table_of_array(name, source)
    angle, lift = _chosen(name, table, columns)
    _check_units(name, table.names, angle, lift, columns)
    lifts = table.numbers[:, lift]
    full = TURN if columns.angle_unit == "deg" else 2.0 * np.pi
    turn = columns.turn or full
    if angle is None:
        count = lifts.size - (lifts.size in CLOSED)
        angles = np.arange(lifts.size, dtype=np.float64) * (turn / count)
    else:
        angles = table.numbers[:, angle]
    _check_points(name, table, angles, lifts, turn)
    step, size = _step(lifts), INCH if columns.lift_unit == "inch" else 1.0
    turned = np.mod(angles * (TURN / turn), TURN)
    turned[turned == TURN] = 0.0  # what rounding makes of a little less than 0
    order = np.argsort(turned, kind="stable")
    return Points(name, turned[order], lifts[order] * size, table.rows[order], step * size)


def _bytes_of(name: str) -> bytes:
    try:
        return read_bytes(name)
    except BadInput as error:
        raise bad(name, "file", None, f"must be {error.mistakes[0].allowed}") from None


def _table_of(name: str, data: bytes) -> NumberTable:
    if Path(name).suffix.lower() == ".s96":
        raise bad(name, "file", None, "no description of .s96 is public; save the lifts as CSV, a row for each")
    try:
        rows = workbook_rows(data) if data.startswith(WORKBOOKS) else text_rows(decoded(data))
    except ValueError as trouble:
        raise bad(name, "file", None, str(trouble)) from None
    return number_table(name, rows)


def _table_of_array(name: str, source: Any) -> NumberTable:
    try:
        numbers = np.array(source, dtype=float)
    except (TypeError, ValueError):
        raise bad(name, "rows", None, "must be a path, or rows of an angle and a lift") from None
    numbers = numbers[:, None] if numbers.ndim == 1 else numbers
    if numbers.ndim != 2 or not numbers.size:
        raise bad(name, "rows", None, "must be a path, or rows of an angle and a lift")
    return NumberTable(numbers, np.arange(1, len(numbers) + 1), ("",) * numbers.shape[1])


def _check(columns: Columns) -> None:
    """Whether units and turn are what they can be."""
    mistakes = [
        Mistake("camopt", key, value, f"one of {', '.join(known)}")
        for key, value, known in (
            ("angle_unit", columns.angle_unit, ANGLE_UNITS),
            ("lift_unit", columns.lift_unit, LIFT_UNITS),
        )
        if value not in known
    ]
    if columns.turn is not None and not (isinstance(columns.turn, Real) and 0.0 < columns.turn <= FAR):
        mistakes.append(Mistake("camopt", "turn", columns.turn, "the angle of a whole turn, above 0"))
    if mistakes:
        raise BadInput(mistakes)


# ---------------------------------------------------------------------------------------------------- columns


def _chosen(name: str, table: NumberTable, columns: Columns) -> tuple[int | None, int]:
    """The places of angle and lift; no angle where a table has lifts alone."""
    width = len(table.names)
    if columns.chosen is not None:
        if len(columns.chosen) not in (1, 2):
            raise BadInput(
                [Mistake("camopt", "columns", list(columns.chosen), "those of angle and lift, or of lift")]
            )
        places = [_place(name, table.names, each) for each in columns.chosen]
        return (None, places[0]) if len(places) == 1 else (places[0], places[1])
    if width == 1:
        return None, 0
    lift = next((k for k, words in enumerate(table.names) if LIFTS.search(words)), None)
    angle = next((k for k, words in enumerate(table.names) if ANGLES.search(words) and k != lift), None)
    if angle is not None and lift is not None:
        return angle, lift
    if width == 2:
        return (0, 1) if lift is None else (1 - lift, lift)
    named = ", ".join(words or str(k) for k, words in enumerate(table.names, start=1))
    raise bad(name, "columns", named, "which are angle and lift? Give their columns, such as 1,2")


def _place(name: str, names: Sequence[str], chosen: str | int) -> int:
    """The place of a column from its name or number."""
    word = str(chosen).strip()
    if word in names:
        return names.index(word)
    if word.isdecimal() and 1 <= int(word) <= len(names):
        return int(word) - 1
    known = ", ".join(words for words in names if words)
    numbers = f"a number from 1 to {len(names)}" + (f", or one of: {known}" if known else "")
    raise BadInput([Mistake(name, "columns", chosen, numbers)])


def _check_units(name: str, names: Sequence[str], angle: int | None, lift: int, columns: Columns) -> None:
    """Whether the words above a column name another unit than the one that is taken."""
    places: list[tuple[int, str, str, tuple[str, ...]]] = [
        (lift, columns.lift_unit, "unit of the lifts", LIFT_UNITS)
    ]
    if angle is not None:
        places.insert(0, (angle, columns.angle_unit, "unit of the angles", ANGLE_UNITS))
    for place, unit, option, known in places:
        units = {SPELLED[word] for word in _words(names[place]) if word in SPELLED}
        if units and unit not in units:
            (other, *_) = sorted(units)
            way = f"give the {option} as {other}" if other in known else f"only {', '.join(known)} can be read"
            raise bad(name, f"column {names[place]!r}", None, f"is in {other}, and {unit} is taken; {way}")


def _words(heading: str) -> Iterator[str]:
    return (match[0] for match in re.finditer(r"[a-zµμ]+|°|\"", heading.lower()))


# ----------------------------------------------------------------------------------------------------- points


def _check_points(name: str, table: NumberTable, angles: FloatArray, lifts: FloatArray, turn: float) -> None:
    """Whether they are the points of one turn."""
    for what, values in (("angle", angles), ("lift", lifts)):
        far = np.flatnonzero(~(np.abs(values) <= FAR))
        if far.size:
            raise bad(
                name, f"row {table.rows[far[0]]}", float(values[far[0]]), f"the {what} must be within ±{FAR:g}"
            )
    if angles.size < FEWEST:
        raise bad(name, "rows", int(angles.size), f"must be at least {FEWEST} points")
    low, high = int(angles.argmin()), int(angles.argmax())
    if angles[high] - angles[low] > turn * (1.0 + 1e-9):
        across = f"the angles go from {angles[low]:g} (row {table.rows[low]}) to {angles[high]:g}, more than a turn"
        hint = "give 720 as the turn if they are of a crankshaft" if turn == TURN else f"a turn is {turn:g}"
        raise bad(name, f"row {table.rows[high]}", float(angles[high]), f"{across}; {hint}")
    if angles[high] == angles[low]:
        raise bad(name, f"row {table.rows[0]}", float(angles[0]), "all rows have this angle")
    if lifts.max() == lifts.min():
        raise bad(name, f"row {table.rows[0]}", float(lifts[0]), "all rows have this lift: nothing moves")


def _step(lifts: FloatArray) -> float:
    """What lifts are rounded to: the largest power of ten that all are multiples of; 0 if it is less than 1e-6."""
    for digits in range(7):
        if np.abs(lifts - np.round(lifts, digits)).max() <= 1e-12 * np.abs(lifts).max():
            return float(10.0**-digits)
    return 0.0
