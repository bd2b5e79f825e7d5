"""The table of the profile, at even cam angles: lift, polar coordinates of the profile and of the roller's centre.

Polar angles φ of a disc cam count from the timing mark, against the sense of rotation, as the cam angle does. A
groove in the face of a disc has the roller's centre alone, which is that of a cutter as wide. A cylindrical cam has
the roller's centre on the developed cylinder, whose y is the lift of a translating follower.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.core.quantities.unit_systems import shown, shown_unit, system_shown
from camopt.show.sheet.cam import TrueCam
from camopt.show.sheet.marks import FINER, MEDIUM, THICK, Mark, Marks, Words, line, rectangle, width_of

ROW_HEIGHT = 4.0  # mm
PADDING = 1.2  # mm: of a number on either side
BLOCKS_APART = 4.0  # mm: one block of rows from the next


@dataclass(frozen=True)
class Printed:
    """A column of the table: three lines of heading, and its numbers.

    The first line is also that of the columns after it which have none.
    """

    head: tuple[str, str, str]
    cells: tuple[str, ...]

    @property
    def width(self) -> float:
        return max(width_of(text, MEDIUM) for text in (*self.head[1:], *self.cells)) + 2 * PADDING


def printed(cam: TrueCam, step: float) -> list[Printed]:
    """The table at cam angles with a step in deg that divides the turn."""
    problem = cam.problem
    degrees = np.arange(0.0, 360.0 - step / 2, step)
    angles = np.radians(degrees)
    lift = problem.programme.at(angles)[0]
    unit = shown_unit("mm")
    lifts = _written(np.degrees(lift)) if problem.setup.angular else _lengths(lift)
    curves = cam.curves_at(angles)
    columns = [Printed(("", "θ", "°"), tuple(f"{each:g}" for each in degrees))]
    if problem.setup.angular or cam.ribbed or not problem.setup.mechanism.body.developed:
        columns.append(Printed(("", "s", "°" if problem.setup.angular else unit), lifts))
    if cam.ribbed:
        return [*columns, *_beside_rib(cam, angles)]
    if problem.setup.mechanism.body.developed:
        y = "y" if problem.setup.angular else "y = s"
        return [
            *columns,
            Printed((cam.say(cam.scene.tip.trace), "x", unit), _lengths(curves.pitch.real)),
            Printed(("", y, unit), _lengths(curves.pitch.imag)),
        ]
    centred = not (problem.setup.is_knife or problem.setup.mechanism.flat_faced)
    if problem.setup.mechanism.body.bounded:
        columns += _polar(cam.say("profile"), curves.profile[0], cam.sense)
    return [*columns, *(_polar(cam.say("centre"), curves.pitch, cam.sense) if centred else ())]


def _beside_rib(cam: TrueCam, angles: FloatArray) -> Iterator[Printed]:
    """The centres of both rollers, which are at one place round a cylinder if they translate."""
    unit, developed = shown_unit("mm"), cam.problem.setup.mechanism.body.developed
    for place in (0, 1):
        name, points = cam.say("roller {}").format(place + 1), replace(cam, place=place).curves_at(angles).pitch
        if not developed:
            yield from _polar(name, points, cam.sense)
            continue
        if not place or cam.problem.setup.angular:
            yield Printed((name, "x", unit), _lengths(points.real))
            name = ""
        yield Printed((name, "y", unit), _lengths(points.imag))


def _polar(name: str, points: ComplexArray, sense: float) -> Iterator[Printed]:
    turns = np.degrees(-sense * np.angle(points / 1j))
    turns = np.round(turns, 3) % 360.0  # what rounds to 360 is 0
    yield Printed((name, "φ", "°"), _written(np.asarray(turns)))
    yield Printed(("", "r", shown_unit("mm")), _lengths(np.abs(points)))


def _written(values: FloatArray, digits: int = 3) -> tuple[str, ...]:
    return tuple(f"{np.round(value, digits) + 0.0:.{digits}f}".replace("-", "−") for value in values)


def _lengths(values: FloatArray) -> tuple[str, ...]:
    """Lengths, mm, in the unit that is shown."""
    return _written(shown(np.asarray(values), "mm"), 3 + FINER[system_shown()])


def table(columns: list[Printed], blocks: int) -> Marks:
    """The columns in so many blocks side by side, from their lower left corner."""
    high = ceil(len(columns[0].cells) / blocks)
    widths = _widths(columns)
    wide = sum(widths)
    marks: Marks = []
    for k in range(blocks):
        chosen = [Printed(column.head, column.cells[k * high : (k + 1) * high]) for column in columns]
        marks += _block(chosen, widths, k * (wide + BLOCKS_APART), high)
    return marks


def _groups(columns: list[Printed]) -> Iterator[range]:
    """The columns that have a first line of heading together."""
    starts = [k for k, column in enumerate(columns) if column.head[0]]
    return (range(first, after) for first, after in pairwise([*starts, len(columns)]))


def _widths(columns: list[Printed]) -> list[float]:
    """The widths of the columns, which have room for the heading that they share."""
    widths = [column.width for column in columns]
    for group in _groups(columns):
        asked = width_of(columns[group[0]].head[0], MEDIUM) + 2 * PADDING
        more = max(0.0, asked - sum(widths[k] for k in group)) / len(group)
        widths = [width + more * (k in group) for k, width in enumerate(widths)]
    return widths


def _block(columns: list[Printed], widths: list[float], left: float, rows: int) -> Iterator[Mark]:
    lines = len(columns[0].head)
    top, edge = (rows + lines) * ROW_HEIGHT, rows * ROW_HEIGHT
    right = left + sum(widths)
    yield rectangle(complex(left, 0), complex(right, top), THICK)
    yield line(complex(left, edge), complex(right, edge), pen=THICK)
    for group in _groups(columns):
        middle = left + sum(widths[: group.start]) + sum(widths[k] for k in group) / 2
        yield Words(complex(middle, top - ROW_HEIGHT + 0.95), columns[group[0]].head[0], MEDIUM, 0.5)
    x = left
    for k, (column, width) in enumerate(zip(columns, widths, strict=True)):
        if k:
            inside = column.head[0] or not columns[k - 1].head[0]
            yield line(complex(x, 0), complex(x, top if inside else top - ROW_HEIGHT))
        for row, text in ((row, text) for row, text in enumerate(column.head) if row and text):
            yield Words(complex(x + width / 2, top - (row + 1) * ROW_HEIGHT + 0.95), text, MEDIUM, 0.5)
        for row, text in enumerate(column.cells):
            yield Words(complex(x + width - PADDING, edge - (row + 1) * ROW_HEIGHT + 0.95), text, MEDIUM, 1.0)
        x += width
    for row in range(5, rows, 5):
        yield line(complex(left, edge - row * ROW_HEIGHT), complex(right, edge - row * ROW_HEIGHT))
