"""Columns of a table and their units: angle and lift, or the points of a profile."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import tau
from numbers import Real
from re import Pattern
from typing import NamedTuple

from camopt.core.mistakes import BadInput, Mistake, join_words
from camopt.solve.measured.number_table import NumberTable, file_mistake

TURN_IN_UNIT = {"deg": 360.0, "rad": tau}
"""Angle of a turn in each unit."""
MM_PER_UNIT = {"mm": 1.0, "inch": 25.4}
"""Size of each unit of length [mm]."""
ANGLE_UNITS, LIFT_UNITS = tuple(TURN_IN_UNIT), (*MM_PER_UNIT, "deg")
LARGEST_MEASURED = 1e6  # largest magnitude of any number
UNIT_SPELLINGS = {
    **dict.fromkeys(("mm", "millimetre", "millimeter", "millimetres", "millimeters"), "mm"),
    **dict.fromkeys(("inch", "inches", "in", "zoll", '"'), "inch"),
    **dict.fromkeys(("deg", "degree", "degrees", "grad", "°"), "deg"),
    **dict.fromkeys(("rad", "radian", "radians"), "rad"),
    **dict.fromkeys(("µm", "μm", "um", "micron", "microns"), "µm"),
    **dict.fromkeys(("mil", "mils", "thou"), "mil"),
}
"""Units by their spellings in column headings."""


class TableKind(NamedTuple):
    """A kind of table: the meaning of its two columns, and the words of headings that show it."""

    first: str
    second: str
    first_words: Pattern[str]
    second_words: Pattern[str]


def _heading_pattern(pattern: str) -> Pattern[str]:
    return re.compile(pattern, re.IGNORECASE)


ANGLE_WORDS = _heading_pattern(r"angle|winkel|deg|°|grad|rad|theta|θ|phi|φ|rotation")
LIFT_TABLE = TableKind(
    "angle",
    "lift",
    ANGLE_WORDS,
    _heading_pattern(r"lift|hub|displacement|travel|rise|stroke|weg|height|\by\b|\bs\b"),
)
POLAR_TABLE = TableKind(
    "angle", "distance", ANGLE_WORDS, _heading_pattern(r"radius|radii|distance|abstand|polar|rho|ρ|\br\b")
)
XY_TABLE = TableKind("x", "y", _heading_pattern(r"\bx\b"), _heading_pattern(r"\by\b"))
PROFILE_KINDS = {"polar": POLAR_TABLE, "xy": XY_TABLE}
"""Forms of profile points."""


@dataclass(frozen=True)
class TableReadingOptions:
    """The columns of a table: their names or numbers (from 1), units, and the angle of a whole turn.

    None means what the table itself says. ``turn`` is in the unit of the angles, such as 720 deg for a crankshaft.
    """

    chosen: Sequence[str | int] | None = None
    angle_unit: str = "deg"
    lift_unit: str | None = None
    turn: float | None = None
    kind: TableKind = LIFT_TABLE
    layer: str | None = None
    """Layer of the profile in a drawing."""

    def check_options(self) -> None:
        """BadInput for a unit or a turn that is not allowed."""
        mistakes = [
            Mistake("camopt", key, value, f"one of {', '.join(filter(None, allowed))}")
            for key, value, allowed in (
                ("angle_unit", self.angle_unit, ANGLE_UNITS),
                ("lift_unit", self.lift_unit, (*LIFT_UNITS, None)),
            )
            if value not in allowed
        ]
        if self.turn is not None and self.kind is XY_TABLE:
            mistakes.append(Mistake("camopt", "turn", self.turn, "left out: points x, y have no angles"))
        elif self.turn is not None and not (isinstance(self.turn, Real) and 0.0 < self.turn <= LARGEST_MEASURED):
            mistakes.append(
                Mistake(
                    "camopt",
                    "turn",
                    self.turn,
                    "above 0: the angle of a whole turn in the unit of the table, such as 360",
                )
            )
        if mistakes:
            raise BadInput(mistakes)


def find_columns_and_unit(
    file: str, table: NumberTable, reading_options: TableReadingOptions, default_unit: str
) -> tuple[int | None, int, str]:
    """Places of the two columns, and the unit of the second; the first is None if a table has only lifts.

    Raises
    ------
    BadInput
        If the columns are unknown, or if their headings name another meaning or unit.
    """
    first, second = _choose_column_indices(file, table, reading_options)
    kind, headings = reading_options.kind, table.names
    if first is None and kind is XY_TABLE:
        raise file_mistake(file, "columns", None, "has one column, and points need both x and y")
    lift_unit = reading_options.lift_unit or next(
        (unit for unit in units_in_heading(headings[second]) & {*MM_PER_UNIT}), default_unit
    )
    lengths = lift_unit, "unit of the lifts", LIFT_UNITS if kind is LIFT_TABLE else tuple(MM_PER_UNIT)
    places = [(second, *lengths)]
    if first is not None:
        angles = reading_options.angle_unit, "unit of the angles", ANGLE_UNITS
        places.insert(0, (first, *(lengths if kind is XY_TABLE else angles)))
    for place, unit, option, allowed in places:
        units = units_in_heading(headings[place])
        if units and unit not in units:
            (other, *_) = sorted(units)
            remedy = (
                f"give the {option} as {other}" if other in allowed else f"only {', '.join(allowed)} can be read"
            )
            what = f"is in {other}, and {unit} is taken; {remedy}"
            raise file_mistake(file, f"column {headings[place]!r}", None, what)
    return first, second, lift_unit


def _choose_column_indices(
    file: str, table: NumberTable, reading_options: TableReadingOptions
) -> tuple[int | None, int]:
    """Places of the two columns, by choice, by headings, or by order."""
    kind, width = reading_options.kind, len(table.names)
    if reading_options.chosen is not None:
        if len(reading_options.chosen) not in (1, 2):
            what = f"those of {kind.first} and {kind.second}, or of {kind.second}"
            raise BadInput([Mistake("camopt", "columns", list(reading_options.chosen), what)])
        places = [_column_index(file, table.names, column) for column in reading_options.chosen]
        return (None, places[0]) if len(places) == 1 else (places[0], places[1])
    if kind is LIFT_TABLE:
        _check_not_profile_headings(file, table.names)
    if width == 1:
        return None, 0
    first, second = _column_indices_by_headings(kind, table.names)
    if first is not None and second is not None:
        return first, second
    if width == 2:
        return (0, 1) if second is None else (1 - second, second)
    named = ", ".join(words or str(k) for k, words in enumerate(table.names, start=1))
    raise file_mistake(
        file, "columns", named, f"which are {kind.first} and {kind.second}? Give their columns, such as 1,2"
    )


def _column_indices_by_headings(kind: TableKind, headings: Sequence[str]) -> tuple[int | None, int | None]:
    """Places of the columns whose headings say what they are."""
    second = next((k for k, words in enumerate(headings) if kind.second_words.search(words)), None)
    first = next((k for k, words in enumerate(headings) if kind.first_words.search(words) and k != second), None)
    return first, second


def _check_not_profile_headings(file: str, headings: Sequence[str]) -> None:
    """BadInput if headings are those of a profile and no other column has lifts."""
    for form, kind in PROFILE_KINDS.items():
        first, second = _column_indices_by_headings(kind, headings)
        if first is not None and second is not None:
            others = (words for k, words in enumerate(headings) if k != second)
            if not any(LIFT_TABLE.second_words.search(words) for words in others):
                what = (
                    f"are points of a profile? Then say so (profile {form}); if not, give the columns, such as 1,2"
                )
                raise file_mistake(file, "columns", f"{headings[first]}, {headings[second]}", what)


def _column_index(file: str, headings: Sequence[str], chosen: str | int) -> int:
    """Place of a column, by its name or number."""
    word = str(chosen).strip()
    if word in headings:
        return headings.index(word)
    if word.isdecimal() and 1 <= int(word) <= len(headings):
        return int(word) - 1
    known = join_words([words for words in headings if words])
    numbers = f"a number from 1 to {len(headings)}" + (f", or one of: {known}" if known else "")
    raise BadInput([Mistake(file, "columns", chosen, numbers)])


def units_in_heading(heading: str) -> set[str]:
    """Units that the heading of a column names."""
    words = (match[0] for match in re.finditer(r"[a-zµμ]+|°|\"", heading.lower()))
    return {UNIT_SPELLINGS[word] for word in words if word in UNIT_SPELLINGS}
