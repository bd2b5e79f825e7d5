"""Marks of a sheet: lines and words, in mm on the paper, with points x + iy.

Line types and widths are those of ISO 128-2 in the group 0.5, lettering has the heights of ISO 3098.
"""

import warnings
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from shapely import LineString, Polygon, STRtree

from camopt.core.numerics import ComplexArray, FloatArray

POINTS_PER_MM = 72 / 25.4  # points
CAPITAL_HEIGHT = 0.729  # height of capitals over the font size of DejaVu Sans; lettering is measured by it
LARGE, MEDIUM, SMALL = 3.5, 2.5, 1.8  # mm
WORDS_PADDING = 0.6  # mm around words
FONT = "DejaVu Sans"  # shipped with matplotlib, so that all machines write the same file


class Pen(NamedTuple):
    """A pen: width [mm]; dashes and gaps in widths, empty for a continuous line."""

    width: float
    dashes: tuple[float, ...] = ()


THICK, THIN, BORDER = Pen(0.5), Pen(0.25), Pen(0.7)
HIDDEN = Pen(0.25, (12, 3))
CHAIN = Pen(0.25, (24, 3, 1, 3))
DOUBLE_CHAIN = Pen(0.25, (24, 3, 1, 3, 1, 3))


class Line(NamedTuple):
    """A line through points, or a filled area such as an arrowhead."""

    points: ComplexArray
    pen: Pen = THIN
    filled: bool = False


class Words(NamedTuple):
    """One line of text with capitals of a height (mm), its baseline turned by an angle (rad, ccw).

    ``place`` says where along the baseline ``at`` is: 0 at the start, 0.5 in the middle, 1 at the end. Words that
    are ``backed`` interrupt the lines that they stand on.
    """

    at: complex
    text: str
    height: float = MEDIUM
    place: float = 0.0
    turn: float = 0.0
    backed: bool = False

    @property
    def corners(self) -> ComplexArray:
        """Corners of the box of the text, from the foot of a g to the top of a capital."""
        wide = text_width(self.text, self.height)
        left, foot, right, top = (
            -self.place * wide,
            -0.33 * self.height,
            wide - self.place * wide,
            1.05 * self.height,
        )
        box = np.array([complex(left, foot), complex(right, foot), complex(right, top), complex(left, top)])
        return self.at + (box * np.exp(1j * self.turn) if self.turn else box)


Mark = Line | Words
Marks = list[Mark]


class MarkBox(NamedTuple):
    """A box from corner to corner [mm]."""

    low: complex
    high: complex

    @property
    def size(self) -> complex:
        return self.high - self.low


@cache
def text_width(text: str, height: float) -> float:
    """Width of a line of text [mm]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(family=FONT, size=height / CAPITAL_HEIGHT)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")
        return float(text_to_path.get_text_width_height_descent(text, font, ismath=False)[0])


def line_mark(*points: complex, pen: Pen = THIN) -> Line:
    return Line(np.array(points, dtype=complex), pen)


def closed_line(*points: complex, pen: Pen = THIN) -> Line:
    """A closed line."""
    return line_mark(*points, points[0], pen=pen)


def rectangle_line(low: complex, high: complex, pen: Pen = THIN) -> Line:
    return closed_line(low, complex(high.real, low.imag), high, complex(low.real, high.imag), pen=pen)


def arc_points(radius: float, start: float = 0.0, end: float = 2 * np.pi, centre: complex = 0.0) -> ComplexArray:
    """Points of an arc between two directions [rad]; chords deviate by 10⁻⁵ of the radius."""
    count = max(2, int(np.ceil(abs(end - start) / np.radians(0.5))) + 1)
    return np.asarray(centre + radius * np.exp(1j * np.linspace(start, end, count)))


def circle_mark(radius: float, pen: Pen = THIN, centre: complex = 0.0) -> Line:
    return Line(arc_points(radius, centre=centre), pen)


def readable_direction(direction_angle: float) -> float:
    """A direction of text or its opposite [rad], so that it is readable from below or from the right."""
    direction_angle = (direction_angle + np.pi) % (2 * np.pi) - np.pi
    return (
        direction_angle
        if -np.pi / 2 + 1e-6 < direction_angle <= np.pi / 2 + 1e-6
        else direction_angle - np.copysign(np.pi, direction_angle)
    )


def marks_box(marks: Iterable[Mark]) -> MarkBox:
    """The smallest upright box around marks."""
    every = np.concatenate([mark.points if isinstance(mark, Line) else mark.corners for mark in marks])
    return MarkBox(complex(every.real.min(), every.imag.min()), complex(every.real.max(), every.imag.max()))


def shift_marks(marks: Iterable[Mark], shift: complex) -> Marks:
    """Marks shifted on the paper."""
    return [
        mark._replace(points=mark.points + shift) if isinstance(mark, Line) else mark._replace(at=mark.at + shift)
        for mark in marks
    ]


def mirror_marks(marks: Iterable[Mark], text_distance: float) -> Marks:
    """Marks mirrored at the vertical through 0; upright texts stay on the left of their dimension lines.

    ``text_distance`` is the distance of a text from its dimension line [mm].
    """
    return [
        mark._replace(points=-mark.points.conj())
        if isinstance(mark, Line)
        else mark._replace(at=-mark.at.conjugate() - 2 * text_distance)
        if mark.turn
        else mark._replace(at=-mark.at.conjugate(), place=1.0 - mark.place)
        for mark in marks
    ]


def first_free_marks(candidates: Iterable[Marks], taken: Marks) -> Marks:
    """The first of several marks that is free, or the last one.

    Free marks do not overlap taken words or frames, and their words do not overlap taken lines.
    """
    words = STRtree([_mark_shape(mark) for mark in taken if isinstance(mark, Words) or _is_frame(mark)])
    lines = STRtree([_mark_shape(mark) for mark in taken if isinstance(mark, Line)])
    marks: Marks = []
    for marks in candidates:
        shapes = [_mark_shape(mark) for mark in marks]
        texts = [shape for mark, shape in zip(marks, shapes, strict=True) if isinstance(mark, Words)]
        pairs = [*((words, shape) for shape in shapes), *((lines, shape) for shape in texts)]
        if not any(tree.query(shape, predicate="intersects").size for tree, shape in pairs):
            break
    return marks


def _is_frame(line: Line) -> bool:
    """Whether a line is the frame of a letter or tolerance."""
    return len(line.points) == 5 and line.points[0] == line.points[-1] and not line.filled


def _mark_shape(mark: Mark) -> LineString | Polygon:
    """A mark as a shapely shape: a line, the padded box of words, or the area of a frame."""
    if isinstance(mark, Words):
        return Polygon(_coordinate_rows(mark.corners)).buffer(WORDS_PADDING)
    if _is_frame(mark):
        return Polygon(_coordinate_rows(mark.points))
    return LineString(_coordinate_rows(mark.points))


def decimal_text(value: float, digits: int = 3) -> str:
    """A number with at most ``digits`` decimals and a real minus sign."""
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return ("0" if text == "-0" else text).replace("-", "−")


def fitted_lines_and_height(
    text: str, width: float, most_lines: int, heights: Sequence[float]
) -> tuple[list[str], float]:
    """Lines of a text within a width [mm], in the largest fitting height; cut off with … if none fits."""
    for height in heights:
        found = wrap_text(text, width, height)
        if len(found) <= most_lines:
            return found, height
    return truncate_lines_with_ellipsis(found, most_lines, width, height), height


def wrap_text(text: str, width: float, height: float) -> list[str]:
    """Lines of a text within a width [mm]; a wider word is divided."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if text_width(longer, height) <= width:
            lines[-1] = longer
            continue
        lines += [word] if lines[-1] else []
        lines[-1] = lines[-1] or word
        while text_width(lines[-1], height) > width and len(lines[-1]) > 1:
            whole = lines[-1]
            keep = max(1, fitting_letter_count(whole, width, height))
            lines[-1:] = [whole[:keep], whole[keep:]]
    return lines


def truncate_lines_with_ellipsis(lines: list[str], count: int, width: float, height: float) -> list[str]:
    """The first lines of a text; the last ends in … if more follow."""
    if len(lines) <= count:
        return lines
    last = lines[count - 1]
    return [*lines[: count - 1], f"{last[: fitting_letter_count(last, width, height, '…')]}…"]


def fitting_letter_count(text: str, width: float, height: float, ending: str = "") -> int:
    """Number of letters of a text that fit in a width together with an ending [mm]."""
    return bisect_right(range(len(text)), width, key=lambda k: text_width(f"{text[: k + 1]}{ending}", height))


def add_paper_axes(figure: Any, width: float, height: float) -> Any:
    """Axes over a whole figure, in mm."""
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set(xlim=(0.0, width), ylim=(0.0, height))
    return axes


def draw_marks(axes: Any, marks: Iterable[Mark]) -> None:
    """Draw marks on axes in mm."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    for order, mark in enumerate(marks):
        if isinstance(mark, Words):
            _draw_words(axes, mark)
            continue
        path = Path(_coordinate_rows(mark.points))
        path.should_simplify = False  # people measure on a drawing
        style = "solid" if not mark.pen.dashes else (0, mark.pen.dashes)
        axes.add_artist(  # not as a patch: the limits of the axes are those of the paper
            PathPatch(
                path,
                fill=mark.filled,
                facecolor="black",
                edgecolor="black",
                linewidth=0.0 if mark.filled else mark.pen.width * POINTS_PER_MM,
                linestyle=style,
                capstyle="butt",
                joinstyle="miter",
                zorder=1 + order * 1e-6,
            )
        )


def _coordinate_rows(points: ComplexArray) -> FloatArray:
    return np.column_stack([points.real, points.imag])


def _draw_words(axes: Any, words: Words) -> None:
    shift = -words.place * text_width(words.text, words.height) * np.exp(1j * words.turn)
    at = words.at + shift
    axes.text(
        at.real,
        at.imag,
        words.text,
        fontsize=words.height / CAPITAL_HEIGHT * POINTS_PER_MM,
        family=FONT,
        color="black",
        ha="left",
        va="baseline",
        rotation=np.degrees(words.turn),
        rotation_mode="anchor",
        zorder=3,
    )
    if words.backed:
        axes.fill(words.corners.real, words.corners.imag, facecolor="white", edgecolor="none", zorder=2)
