"""Sheets of paper: size, frame, centring marks and zones by ISO 5457, the scales of ISO 5455, and the title block.

The title block is that of ISO 7200, 180 mm wide, in the lower right corner. Fields that are not given stay empty.
Sheets of ASME Y14.1 have zones and marks of their own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, product
from typing import NamedTuple

from camopt.core.quantities.unit_systems import INCH_MM
from camopt.show.sheet import symbols
from camopt.show.sheet.dimensions import arrowhead
from camopt.show.sheet.languages import LANGUAGES
from camopt.show.sheet.marks import (
    BORDER,
    LARGE,
    MEDIUM,
    SMALL,
    THIN,
    Mark,
    MarkBox,
    Marks,
    Words,
    fitted_lines_and_height,
    line_mark,
    marks_box,
    rectangle_line,
    truncate_lines_with_ellipsis,
    wrap_text,
)

BINDING_EDGE, OTHER_EDGE = 20.0, 10.0  # mm: margin at the binding edge, and at the others
ZONES, ZONE = 5.0, 50.0  # mm: width of the border of zones, and length of a zone
CENTRING_LENGTH = 3.0  # mm of centring marks inside the frame
BORDER_LETTERS = "ABCDEFGHJKLMNP"  # no I, no O


@dataclass(frozen=True)
class Paper:
    """A trimmed sheet [mm]."""

    name: str
    width: float
    height: float
    margins: tuple[float, float, float] = (BINDING_EDGE, OTHER_EDGE, OTHER_EDGE)  # left, right, top and bottom

    @property
    def frame(self) -> MarkBox:
        """The frame of the drawing area."""
        left, right, level = self.margins
        return MarkBox(complex(left, level), complex(self.width - right, self.height - level))

    def marks(self) -> Marks:
        """Frame, zones, centring marks and the name of the size."""
        low, high = self.frame
        outer = complex(ZONES, ZONES)
        middle = complex(self.width / 2, self.height / 2)
        down = (complex(middle.real, low.imag), 1j), (complex(middle.real, high.imag), -1j)
        across = (complex(low.real, middle.imag), 1.0), (complex(high.real, middle.imag), -1.0)
        return [
            rectangle_line(low, high, BORDER),
            rectangle_line(low - outer, high + outer, THIN),
            *(
                line_mark(end - ZONES * into, end + CENTRING_LENGTH * into, pen=BORDER)
                for end, into in (*down, *across)
            ),
            *self._zone_marks(middle),
            Words(complex(high.real, low.imag - ZONES - 3.6), self.name, MEDIUM, 1.0),
        ]

    def _zone_marks(self, middle: complex) -> Iterator[Mark]:
        """Names of zones: numbers along, letters down; on a small sheet only on top and right."""
        (left, bottom), (right, top) = ((c.real, c.imag) for c in self.frame)
        across = [x + middle.real for x in _zone_borders(left - middle.real, right - middle.real)]
        down = [y + middle.imag for y in _zone_borders(bottom - middle.imag, top - middle.imag)]
        rows, columns = ((top,), (right,)) if self.name == "A4" else ((bottom - ZONES, top), (left - ZONES, right))
        for y in rows:
            yield from (line_mark(complex(x, y), complex(x, y + ZONES)) for x in across)
            for k, (a, b) in enumerate(zip([left, *across], [*across, right], strict=True), 1):
                yield Words(complex((a + b) / 2, y + (ZONES - MEDIUM) / 2), f"{k}", MEDIUM, 0.5)
        for x in columns:
            yield from (line_mark(complex(x, y), complex(x + ZONES, y)) for y in down)
            spans = list(zip([bottom, *down], [*down, top], strict=True))[::-1]
            for letter, (a, b) in zip(BORDER_LETTERS, spans, strict=False):
                yield Words(complex(x + ZONES / 2, (a + b - MEDIUM) / 2), letter, MEDIUM, 0.5)


def _zone_borders(low: float, high: float) -> list[float]:
    """The borders of zones, from the middle outwards."""
    first, last = int(low / ZONE), int(high / ZONE)
    return [k * ZONE for k in range(first, last + 1) if low + 1.0 < k * ZONE < high - 1.0]


@dataclass(frozen=True)
class AnsiPaper(Paper):
    """A sheet of ASME Y14.1, with the number of its zones across and upwards; size A has none.

    Zones have numbers from right to left and letters upwards. Arrows point to the middles of the frame.
    """

    zones: tuple[int, int] = (0, 0)

    def marks(self) -> Marks:
        """Frame, zones and alignment arrows."""
        middle, half = (self.frame.low + self.frame.high) / 2, self.frame.size / 2
        tips = {half.real + 0j: 1.0, -half.real + 0j: -1.0, 1j * half.imag: 1j, -1j * half.imag: -1j}
        arrows = (arrowhead(middle + tip, -outwards) for tip, outwards in tips.items())
        return [rectangle_line(*self.frame, BORDER), *arrows, *self._zone_marks(middle)]

    def _zone_marks(self, middle: complex) -> Iterator[Mark]:
        """Names of zones on all sides from the lower right corner, and ticks between them."""
        half = self.frame.high - middle
        for zones, names, along, away in (
            (self.zones[0], "12345678", -half.real, 1j * half.imag),
            (self.zones[1], BORDER_LETTERS, 1j * half.imag, half.real),
        ):
            for side, (k, name) in product((-away, away), enumerate(names[:zones])):
                outwards, foot = side / abs(side), middle + side - along + 2 * k / zones * along
                yield line_mark(foot, foot + ZONES * outwards * (k > 0))
                at = foot + along / zones + (ZONES / 2 + 1.0) * outwards - 0.5j * MEDIUM
                yield Words(at, name, MEDIUM, 0.5)


ANSI_PAPERS = (
    AnsiPaper("A", 8.5 * INCH_MM, 11.0 * INCH_MM, (0.38 * INCH_MM, 0.38 * INCH_MM, 0.25 * INCH_MM)),
    AnsiPaper("B", 17.0 * INCH_MM, 11.0 * INCH_MM, (0.62 * INCH_MM, 0.62 * INCH_MM, 0.38 * INCH_MM), (4, 2)),
    AnsiPaper("C", 22.0 * INCH_MM, 17.0 * INCH_MM, (0.5 * INCH_MM, 0.5 * INCH_MM, 0.75 * INCH_MM), (4, 4)),
    AnsiPaper("D", 34.0 * INCH_MM, 22.0 * INCH_MM, (INCH_MM, INCH_MM, 0.5 * INCH_MM), (8, 4)),
)
A4, A3, A2 = Paper("A4", 210.0, 297.0), Paper("A3", 420.0, 297.0), Paper("A2", 594.0, 420.0)
LEAST_VIEW = 40.0  # mm on the paper; smaller cams are enlarged


def paper_scales(size: float, series: tuple[float, ...] = (1.0, 2.0, 5.0)) -> Iterator[float]:
    """Scales for a part of a size [mm], downwards from 1:1, or from an enlargement; by default of ISO 5455."""
    first = next(k for k in count() if _preferred_scale_factor(series, k) * size >= LEAST_VIEW)
    yield from (_preferred_scale_factor(series, k) for k in count(first, -1))


def _preferred_scale_factor(series: tuple[float, ...], index: int) -> float:
    """1, 2, 5, 10, … for places from 0; ½, ⅕, ⅒, … for negative places."""
    decade, within = divmod(abs(index), len(series))
    factor = series[within] * 10.0**decade
    return factor if index >= 0 else 1.0 / factor


def scale_name(scale: float) -> str:
    return f"{scale:.0f}:1" if scale >= 1.0 else f"1:{1.0 / scale:.0f}"


BLOCK_WIDTH, BLOCK_HEIGHT, BLOCK_ROW, TALL_ROW = 180.0, 36.0, 9.0, 12.0  # mm; a taller field may have a title
FIELD_PAD = 0.9  # mm from the edges of a field
LEADING = 1.4  # distance of lines in letter heights
TITLE_HEIGHT, LINES_HEIGHT = 5.0, 2.2  # mm: height of the letters of a short title, and of lines in a field
PROJECTION_FIELD, LINES_FIELD = "projection", "lines"


class Field(NamedTuple):
    """A field of the title block: lower left corner and size [mm], name and value."""

    x: float
    y: float
    width: float
    height: float
    name: str
    value: str = ""


def title_block(fields: Sequence[Field], language: str = "en") -> Marks:
    """The title block with fields whose names are in a language, from its lower left corner."""
    translate, right = LANGUAGES[language], max(field.x + field.width for field in fields)
    marks: Marks = [rectangle_line(0j, complex(right, max(field.y + field.height for field in fields)), BORDER)]
    for field in fields:
        low = complex(field.x, field.y)
        marks.append(rectangle_line(low, complex(field.x + field.width, field.y + field.height), THIN))
        if field.name in (PROJECTION_FIELD, LINES_FIELD):
            marks += _field_lines(field) if field.value else []
            aside = marks_box(marks[-2:]).size.real if field.value else 0.0
            middle = complex(field.x + (field.width + aside) / 2, field.y + field.height / 2)
            marks += symbols.projection_symbol(middle, bool(field.value)) if field.name == PROJECTION_FIELD else []
            continue
        top = field.y + field.height - FIELD_PAD - SMALL
        marks.append(Words(complex(field.x + FIELD_PAD, top), translate(field.name), SMALL))
        marks += _field_value(field, top - FIELD_PAD)
    return marks


def _field_lines(field: Field) -> Marks:
    """The lines of a field without its name, centred between its lower and upper edge."""
    step, width = LINES_HEIGHT * LEADING, field.width - 2 * FIELD_PAD
    lines = [line for text in field.value.split("\n") for line in wrap_text(text, width, LINES_HEIGHT)]
    lines = truncate_lines_with_ellipsis(lines, int(field.height / step), width, LINES_HEIGHT)
    top = field.y + (field.height + (len(lines) - 1) * step - LINES_HEIGHT) / 2
    return [Words(complex(field.x + FIELD_PAD, top - k * step), text, LINES_HEIGHT) for k, text in enumerate(lines)]


def _field_value(field: Field, top: float) -> Marks:
    """The value of a field, in the largest letters that fit."""
    if not field.value:
        return []
    tall = field.height > TALL_ROW
    heights = (TITLE_HEIGHT, LARGE, MEDIUM, SMALL) if tall else (LARGE, MEDIUM, SMALL)
    room = field.width - 2 * FIELD_PAD
    texts, height = fitted_lines_and_height(field.value, room, 1, heights[:-2] if tall else heights[:-1])
    if texts[0] != " ".join(field.value.split()):
        texts, height = fitted_lines_and_height(field.value, room, 2, (MEDIUM, SMALL) if tall else (SMALL,))
    step = height * LEADING
    foot = field.y + FIELD_PAD + (len(texts) - 1) * step
    foot += max(0.0, (top - height - foot) / 2)
    return [Words(complex(field.x + FIELD_PAD, foot - k * step), text, height) for k, text in enumerate(texts)]
