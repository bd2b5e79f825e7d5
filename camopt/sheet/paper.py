"""Sheets of paper: size, frame, centring marks and zones by ISO 5457, and the scales of ISO 5455."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import floor, log10

from camopt.sheet.marks import BORDER, MEDIUM, THIN, Box, Mark, Marks, Words, line, rectangle

BINDING_EDGE, OTHER_EDGE = 20.0, 10.0  # mm: the margin where sheets are bound, and elsewhere
ZONES, ZONE = 5.0, 50.0  # mm: width of the border with the zones, length of one
CENTRING = 3.0  # mm: centring marks past the frame; their form is free
LETTERS = "ABCDEFGHJKLMNP"  # no I, no O


@dataclass(frozen=True)
class Paper:
    """A trimmed sheet, mm."""

    name: str
    width: float
    height: float

    @property
    def frame(self) -> Box:
        """The frame of the space for the drawing."""
        return Box(complex(BINDING_EDGE, OTHER_EDGE), complex(self.width - OTHER_EDGE, self.height - OTHER_EDGE))

    @property
    def small(self) -> bool:
        """Whether its title block is as wide as its frame, and its zones are named on two sides only."""
        return self.name == "A4"

    def marks(self) -> Marks:
        """Frame, zones, centring marks and the name of the size."""
        low, high = self.frame
        outer = complex(ZONES, ZONES)
        marks: Marks = [rectangle(low, high, BORDER), rectangle(low - outer, high + outer, THIN)]
        middle = complex(self.width / 2, self.height / 2)
        for edge, into in ((low.imag, 1j), (high.imag, -1j)):
            end = complex(middle.real, edge)
            marks.append(line(end - ZONES * into, end + CENTRING * into, pen=BORDER))
        for edge, into in ((low.real, 1.0), (high.real, -1.0)):
            end = complex(edge, middle.imag)
            marks.append(line(end - ZONES * into, end + CENTRING * into, pen=BORDER))
        marks += self._zones(middle)
        name = complex(high.real, low.imag - ZONES - 3.6)
        return [*marks, Words(name, self.name, MEDIUM, 1.0)]

    def _zones(self, middle: complex) -> Iterator[Mark]:
        """Numbers along, letters down, from the centring marks on; of a small sheet above and on the right only."""
        (left, bottom), (right, top) = ((c.real, c.imag) for c in self.frame)
        across = [x + middle.real for x in _steps(left - middle.real, right - middle.real)]
        down = [y + middle.imag for y in _steps(bottom - middle.imag, top - middle.imag)]
        rows = (top,) if self.small else (bottom - ZONES, top)
        columns = (right,) if self.small else (left - ZONES, right)
        for y in rows:
            yield from (line(complex(x, y), complex(x, y + ZONES)) for x in across)
            for k, (a, b) in enumerate(zip([left, *across], [*across, right], strict=True), 1):
                yield Words(complex((a + b) / 2, y + (ZONES - MEDIUM) / 2), f"{k}", MEDIUM, 0.5)
        for x in columns:
            yield from (line(complex(x, y), complex(x + ZONES, y)) for y in down)
            spans = list(zip([bottom, *down], [*down, top], strict=True))[::-1]
            for letter, (a, b) in zip(LETTERS, spans, strict=False):
                yield Words(complex(x + ZONES / 2, (a + b - MEDIUM) / 2), letter, MEDIUM, 0.5)


def _steps(low: float, high: float) -> list[float]:
    """The borders of zones, from the middle outwards."""
    first, last = int(low / ZONE), int(high / ZONE)
    return [k * ZONE for k in range(first, last + 1) if low + 1.0 < k * ZONE < high - 1.0]


A4, A3, A2 = Paper("A4", 210.0, 297.0), Paper("A3", 420.0, 297.0), Paper("A2", 594.0, 420.0)
LEAST_VIEW = 40.0  # mm on the paper: smaller cams are enlarged


def scales(size: float) -> Iterator[float]:
    """Scales of ISO 5455 for a part of a size (mm): 1:1 or, if it is small, an enlargement; then ever smaller."""
    series = (1.0, 2.0, 5.0)
    place = 0
    if size < LEAST_VIEW:
        decade = max(0, floor(log10(LEAST_VIEW / size)))
        place = next(k for k in range(3 * decade, 3 * decade + 4) if _at(series, k) * size >= LEAST_VIEW)
    while True:
        yield _at(series, place)
        place -= 1


def _at(series: tuple[float, ...], place: int) -> float:
    """1, 2, 5, 10, … from place 0 up; ½, ⅕, ⅒, … below."""
    decade, within = divmod(abs(place), 3)
    factor = series[within] * 10.0**decade
    return factor if place >= 0 else 1.0 / factor


def scale_name(scale: float) -> str:
    return f"{scale:.0f}:1" if scale >= 1.0 else f"1:{1.0 / scale:.0f}"
