"""Sheets of paper: size, frame, centring marks and zones by ISO 5457, the scales of ISO 5455, and the title block.

The title block is that of ISO 7200, 180 mm wide, in the lower right corner. Fields that are not given stay empty.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import floor, log10
from typing import NamedTuple

from camopt.core.storage.version import VERSION
from camopt.scene.part import Part
from camopt.show.sheet import symbols
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
    fitted_words,
    line_mark,
    rectangle_line,
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

    @property
    def frame(self) -> MarkBox:
        """The frame of the drawing area."""
        return MarkBox(
            complex(BINDING_EDGE, OTHER_EDGE), complex(self.width - OTHER_EDGE, self.height - OTHER_EDGE)
        )

    @property
    def is_a4(self) -> bool:
        """Whether the sheet is A4: its title block is as wide as the frame, and zones are named on two sides."""
        return self.name == "A4"

    def marks(self) -> Marks:
        """Frame, zones, centring marks and the name of the size."""
        low, high = self.frame
        outer = complex(ZONES, ZONES)
        marks: Marks = [rectangle_line(low, high, BORDER), rectangle_line(low - outer, high + outer, THIN)]
        middle = complex(self.width / 2, self.height / 2)
        down = (complex(middle.real, low.imag), 1j), (complex(middle.real, high.imag), -1j)
        across = (complex(low.real, middle.imag), 1.0), (complex(high.real, middle.imag), -1.0)
        marks += [
            line_mark(end - ZONES * into, end + CENTRING_LENGTH * into, pen=BORDER)
            for end, into in (*down, *across)
        ]
        marks += self._zones(middle)
        name = complex(high.real, low.imag - ZONES - 3.6)
        return [*marks, Words(name, self.name, MEDIUM, 1.0)]

    def _zones(self, middle: complex) -> Iterator[Mark]:
        """Names of zones: numbers along, letters down; on a small sheet only on top and right."""
        (left, bottom), (right, top) = ((c.real, c.imag) for c in self.frame)
        across = [x + middle.real for x in _zone_borders(left - middle.real, right - middle.real)]
        down = [y + middle.imag for y in _zone_borders(bottom - middle.imag, top - middle.imag)]
        rows = (top,) if self.is_a4 else (bottom - ZONES, top)
        columns = (right,) if self.is_a4 else (left - ZONES, right)
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


A4, A3, A2 = Paper("A4", 210.0, 297.0), Paper("A3", 420.0, 297.0), Paper("A2", 594.0, 420.0)
LEAST_VIEW = 40.0  # mm on the paper; smaller cams are enlarged


def paper_scales(size: float) -> Iterator[float]:
    """Scales of ISO 5455 for a part of a size [mm], downwards from 1:1, or from an enlargement."""
    series = (1.0, 2.0, 5.0)
    place = 0
    if size < LEAST_VIEW:
        decade = max(0, floor(log10(LEAST_VIEW / size)))
        place = next(
            k for k in range(3 * decade, 3 * decade + 4) if _preferred_scale_factor(series, k) * size >= LEAST_VIEW
        )
    while True:
        yield _preferred_scale_factor(series, place)
        place -= 1


def _preferred_scale_factor(series: tuple[float, ...], place: int) -> float:
    """1, 2, 5, 10, … for places from 0; ½, ⅕, ⅒, … for negative places."""
    decade, within = divmod(abs(place), 3)
    factor = series[within] * 10.0**decade
    return factor if place >= 0 else 1.0 / factor


def scale_name(scale: float) -> str:
    return f"{scale:.0f}:1" if scale >= 1.0 else f"1:{1.0 / scale:.0f}"


BLOCK_WIDTH, BLOCK_HEIGHT, BLOCK_ROW = 180.0, 36.0, 9.0  # mm
FIELD_PAD = 0.9  # mm from the edges of a field
LEADING = 1.4  # distance of lines in letter heights
TITLE_HEIGHT = 5.0  # mm: height of the letters of a short title
PROJECTION_FIELD = "projection"


class Field(NamedTuple):
    """A field of the title block: lower left corner and size [mm], name and value."""

    x: float
    y: float
    width: float
    height: float
    name: str
    value: str = ""


def block_fields(part: Part, title: str, scale: str, paper: str, sheet: str) -> list[Field]:
    """The fields of the title block."""
    hardness = ", ".join(filter(None, (part.hardness, part.case_depth and f"CHD {part.case_depth}")))
    return [
        Field(0, 27, 75, BLOCK_ROW, "Material", part.material or ""),
        Field(75, 27, 55, BLOCK_ROW, "Hardness", hardness),
        Field(130, 27, 22, BLOCK_ROW, "Scale", scale),
        Field(152, 27, 28, BLOCK_ROW, PROJECTION_FIELD),
        Field(0, 18, 45, BLOCK_ROW, "Created by", part.designer or ""),
        Field(45, 18, 45, BLOCK_ROW, "Approved by", part.approved_by or ""),
        Field(90, 18, 40, BLOCK_ROW, "Document type", LANGUAGES[part.language]("Part drawing")),
        Field(130, 18, 32, BLOCK_ROW, "Source", f"camopt {VERSION}"),
        Field(162, 18, 18, BLOCK_ROW, "Format", paper),
        Field(0, 0, 45, 2 * BLOCK_ROW, "Legal owner", part.legal_owner or ""),
        Field(45, 0, 85, 2 * BLOCK_ROW, "Title", title),
        Field(130, 9, 50, BLOCK_ROW, "Identification number", part.number or ""),
        Field(130, 0, 10, BLOCK_ROW, "Rev.", part.revision or ""),
        Field(140, 0, 20, BLOCK_ROW, "Date of issue", part.date_of_issue or ""),
        Field(160, 0, 8, BLOCK_ROW, "Lang.", part.language),
        Field(168, 0, 12, BLOCK_ROW, "Sheet", sheet),
    ]


def title_block(part: Part, title: str, scale: str, paper: str, sheet: str) -> Marks:
    """The title block from its lower left corner."""
    say = LANGUAGES[part.language]
    marks: Marks = [rectangle_line(0j, complex(BLOCK_WIDTH, BLOCK_HEIGHT), BORDER)]
    for field in block_fields(part, title, scale, paper, sheet):
        marks.append(
            rectangle_line(complex(field.x, field.y), complex(field.x + field.width, field.y + field.height), THIN)
        )
        if field.name == PROJECTION_FIELD:
            marks += symbols.projection_symbol(complex(field.x + field.width / 2, field.y + field.height / 2))
            continue
        top = field.y + field.height - FIELD_PAD - SMALL
        marks.append(Words(complex(field.x + FIELD_PAD, top), say(field.name), SMALL))
        marks += _field_value(field, top - FIELD_PAD)
    return marks


def _field_value(field: Field, top: float) -> Marks:
    """The value of a field, in the largest letters that fit."""
    if not field.value:
        return []
    tall = field.height > BLOCK_ROW
    heights = (TITLE_HEIGHT, LARGE, MEDIUM, SMALL) if tall else (LARGE, MEDIUM, SMALL)
    room = field.width - 2 * FIELD_PAD
    texts, height = fitted_words(field.value, room, 1, heights[:-2] if tall else heights[:-1])
    if texts[0] != " ".join(field.value.split()):
        texts, height = fitted_words(field.value, room, 2, (MEDIUM, SMALL) if tall else (SMALL,))
    step = height * LEADING
    foot = field.y + FIELD_PAD + (len(texts) - 1) * step
    foot += max(0.0, (top - height - foot) / 2)
    return [Words(complex(field.x + FIELD_PAD, foot - k * step), text, height) for k, text in enumerate(texts)]
