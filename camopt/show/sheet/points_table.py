"""The table of the profile by cam angle: lift, polar coordinates of the profile and of the roller's centre.

Polar angles φ of a disc cam count from the timing mark, against the sense of rotation, like the cam angle. A groove
in the face of a disc has only the roller's centre, which is the centre of a cutter as wide as the groove. A
cylindrical cam has the roller's centre on the developed cylinder; its y is the lift of a translating follower.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise
from math import ceil, floor

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.core.quantities.unit_systems import INCH_MM, unit_in_shown_system
from camopt.show.sheet.marks import (
    MEDIUM,
    THICK,
    Marks,
    Words,
    line_mark,
    rectangle_line,
    text_width,
)
from camopt.show.sheet.standards import length_text, sheet_standard
from camopt.show.sheet.true_cam import TrueCam

ROW_HEIGHT = 4.0  # mm
CELL_PADDING = 1.2  # mm on both sides of a number
BLOCK_GAP = 4.0  # mm between blocks of rows


@dataclass(frozen=True)
class TableColumn:
    """A column of the table: three lines of heading, and its numbers.

    Following columns with an empty first line share the first line of this column.
    """

    head: tuple[str, str, str]
    cells: tuple[str, ...]

    @property
    def width(self) -> float:
        return max(text_width(text, MEDIUM) for text in (*self.head[1:], *self.cells)) + 2 * CELL_PADDING


def table_columns(cam: TrueCam, step: float | None) -> list[TableColumn]:
    """Columns of the table, with a step of the cam angle that divides the turn [deg].

    Without a step the rows are so close that values between them can be interpolated.
    """
    problem = cam.problem
    degrees = dense_angles(cam) if step is None else np.arange(0.0, 360.0 - step / 2, step)
    angles = np.radians(degrees)
    lift = problem.programme.motion_at(angles)[0]
    unit = unit_in_shown_system("mm")
    lifts = _decimal_texts(np.degrees(lift)) if problem.setup.angular else _length_texts(lift)
    curves = cam.curves_at(angles)
    developed, lifted = problem.setup.mechanism.body.developed, "°" if problem.setup.angular else unit
    columns = [
        TableColumn(("", "θ", "°"), tuple(f"{each:.6g}" for each in degrees)),
        *(
            [TableColumn(("", "s", lifted), lifts)]
            if problem.setup.angular or cam.is_ribbed or not developed
            else []
        ),
    ]
    if cam.is_ribbed:
        return [*columns, *_rib_columns(cam, angles)]
    if developed:
        return [
            *columns,
            TableColumn((cam.translate(cam.scene.tip.trace), "x", unit), _length_texts(curves.pitch.real)),
            TableColumn(("", "y" if problem.setup.angular else "y = s", unit), _length_texts(curves.pitch.imag)),
        ]
    bounded = problem.setup.mechanism.body.bounded
    centred = not (problem.setup.is_knife or problem.setup.mechanism.flat_faced)
    return [
        *columns,
        *(_polar_columns(cam.translate("profile"), curves.profile[0], cam.sense) if bounded else ()),
        *(_polar_columns(cam.translate("centre"), curves.pitch, cam.sense) if centred else ()),
    ]


DENSE_STEPS, INTERPOLATION_ERROR = (10.0, 1.0, 0.5), 0.0005 * INCH_MM  # deg, and mm


def dense_angles(cam: TrueCam) -> FloatArray:
    """Cam angles [deg] between which values are interpolated with a small error.

    A segment has a row at its start and then its own step: 10° in a dwell, 1° in a stroke, or 0.5° in a steep one.
    """
    rows = []
    for _, begin, end in cam.segments:
        for step in np.radians(DENSE_STEPS):
            inside = step * np.arange(floor(begin / step + 1e-6) + 1, ceil(end / step - 1e-6))
            angles = np.concatenate([[begin], inside, [end]])
            if _interpolation_error(cam, angles) <= INTERPOLATION_ERROR:
                break
        rows.append(angles[:-1])
    return np.unique(np.round(np.degrees(np.concatenate(rows)) % 360.0, 6))


def _interpolation_error(cam: TrueCam, angles: FloatArray) -> float:
    """Largest error of the profile in the middle between cam angles [rad], across it [mm]."""
    points, true = cam.curves_at(angles).profile[0], cam.curves_at((angles[1:] + angles[:-1]) / 2)
    first, last, is_flat = points[:-1], points[1:], cam.problem.setup.mechanism.body.developed
    means = (
        (first + last) / 2 if is_flat else first * np.sqrt(last / first)
    )  # of polar coordinates, unless it is flat
    return float(np.abs(((means - true.profile[0]) * true.normal.conj()).real).max())


def _rib_columns(cam: TrueCam, angles: FloatArray) -> Iterator[TableColumn]:
    """Columns of the centres of both rollers; if they translate, both have the same x round a cylinder."""
    unit, developed = unit_in_shown_system("mm"), cam.problem.setup.mechanism.body.developed
    for place in (0, 1):
        name, points = (
            cam.translate("roller {}").format(place + 1),
            replace(cam, place=place).curves_at(angles).pitch,
        )
        if not developed:
            yield from _polar_columns(name, points, cam.sense)
            continue
        if not place or cam.problem.setup.angular:
            yield TableColumn((name, "x", unit), _length_texts(points.real))
            name = ""
        yield TableColumn((name, "y", unit), _length_texts(points.imag))


def _polar_columns(name: str, points: ComplexArray, sense: float) -> Iterator[TableColumn]:
    turns = np.degrees(-sense * np.angle(points / 1j))
    turns = np.round(turns, 3) % 360.0  # 360 becomes 0
    yield TableColumn((name, "φ", "°"), _decimal_texts(np.asarray(turns)))
    yield TableColumn(("", "r", unit_in_shown_system("mm")), _length_texts(np.abs(points)))


def _decimal_texts(values: FloatArray) -> tuple[str, ...]:
    return tuple(f"{np.round(value, 3) + 0.0:.3f}".replace("-", "−") for value in values)


def _length_texts(values: FloatArray) -> tuple[str, ...]:
    """Lengths given in mm, as texts in the shown unit."""
    return tuple(map(length_text, values)) if sheet_standard().has_fixed_decimals else _decimal_texts(values)


def points_table(columns: list[TableColumn], blocks: int) -> Marks:
    """The table in blocks of rows side by side, from its lower left corner."""
    rows = ceil(len(columns[0].cells) / blocks)
    starts = [k for k, column in enumerate(columns) if column.head[0]]
    groups = [range(first, after) for first, after in pairwise([*starts, len(columns)])]  # share a first line
    widths = [column.width for column in columns]
    for group in groups:
        needed = text_width(columns[group[0]].head[0], MEDIUM) + 2 * CELL_PADDING
        more = max(0.0, needed - sum(widths[k] for k in group)) / len(group)
        widths = [width + more * (k in group) for k, width in enumerate(widths)]
    top, edge = (rows + len(columns[0].head)) * ROW_HEIGHT, rows * ROW_HEIGHT
    marks: Marks = []
    for block in range(blocks):
        left = block * (sum(widths) + BLOCK_GAP)
        right = left + sum(widths)
        marks += [
            rectangle_line(complex(left, 0), complex(right, top), THICK),
            line_mark(complex(left, edge), complex(right, edge), pen=THICK),
        ]
        for group in groups:
            middle = left + sum(widths[: group.start]) + sum(widths[k] for k in group) / 2
            head = columns[group[0]].head[0]
            marks.append(Words(complex(middle, top - ROW_HEIGHT + 0.95), head, MEDIUM, 0.5))
        for k, (column, width, x) in enumerate(
            zip(columns, widths, accumulate(widths, initial=left), strict=False)
        ):
            if k:
                inside = column.head[0] or not columns[k - 1].head[0]
                marks.append(line_mark(complex(x, 0), complex(x, top if inside else top - ROW_HEIGHT)))
            marks += [
                Words(complex(x + width / 2, top - row * ROW_HEIGHT + 0.95), text, MEDIUM, 0.5)
                for row, text in enumerate(column.head[1:], start=2)
                if text
            ]
            marks += [
                Words(complex(x + width - CELL_PADDING, edge - row * ROW_HEIGHT + 0.95), text, MEDIUM, 1.0)
                for row, text in enumerate(column.cells[block * rows : (block + 1) * rows], start=1)
            ]
        levels = [edge - row * ROW_HEIGHT for row in range(5, rows, 5)]
        marks += [line_mark(complex(left, level), complex(right, level)) for level in levels]
    return marks
