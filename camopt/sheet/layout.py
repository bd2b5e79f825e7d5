"""Where things are on a sheet: views, table, notes and title block, if they fit on it at a scale."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from camopt.sheet.callouts import with_callouts
from camopt.sheet.cam import Cam
from camopt.sheet.developed import groove_and_body
from camopt.sheet.front_view import FrontView, is_upright
from camopt.sheet.marks import LARGE, Box, Marks, Words, box_of, moved
from camopt.sheet.notes import notes
from camopt.sheet.paper import A3, A4, Paper, scale_name
from camopt.sheet.points_table import columns_of, table
from camopt.sheet.section import section
from camopt.sheet.title_block import HEIGHT, WIDTH, title_block

MARGIN, APART = 4.0, 8.0  # mm: of what is on the sheet from the frame, and of one view from the next
HAIR = 1e-9  # mm


class Form(NamedTuple):
    """A paper, the step of its table (deg), the blocks that the rows are in, and how all is placed."""

    paper: Paper
    step: float
    blocks: int
    place: "Callable[[Desk, float], Marks]"


@dataclass(frozen=True)
class Desk:
    """What goes on a sheet, but for the views."""

    cam: Cam
    form: Form

    @property
    def inner(self) -> Box:
        """The frame less a margin."""
        low, high = self.form.paper.frame
        return Box(low + complex(MARGIN, MARGIN), high - complex(MARGIN, MARGIN))

    @property
    def over(self) -> float:
        """The level above the title block."""
        return self.form.paper.frame.low.imag + HEIGHT + MARGIN

    @property
    def beside(self) -> float:
        """The width that the title block leaves."""
        return self.inner.high.real + MARGIN - WIDTH - APART - self.inner.low.real

    def table(self) -> Marks:
        return table(columns_of(self.cam, self.form.step), self.form.blocks)

    def notes(self, width: float) -> Marks:
        return notes(self.cam, width)

    def standing(self, scale: float) -> Marks:
        """The frame, and the title block in its corner."""
        paper = self.form.paper
        block = title_block(self.cam.part, scale_name(scale), paper.name)
        low, high = paper.frame
        return [*paper.marks(), *moved(block, complex(high.real - WIDTH, low.imag))]


def disc_views(cam: Cam, scale: float) -> Marks:
    """The front view of a disc cam, and the section beside it if the thickness is known."""
    part, front = cam.part, FrontView(cam, scale)
    marks = with_callouts(front)
    if not part.thickness:
        return marks
    beside = section(front.outline, part, scale)
    beside = moved(beside, box_of(marks).high.real + APART - box_of(beside).low.real)
    if not is_upright(part):
        box = box_of(beside)
        above = complex((box.low.real + box.high.real) / 2, box.high.imag + 3.0)
        beside.append(Words(above, "A–A", LARGE, 0.5))
    return [*marks, *beside]


def disc_above(desk: Desk, scale: float) -> Marks:
    """From above: views, table, notes, title block."""
    inner, width = desk.inner, desk.inner.size.real
    said = moved(desk.notes(width), complex(inner.low.real, desk.over))
    rows = desk.table()
    spare = (width - box_of(rows).size.real) / 2
    rows = moved(rows, complex(inner.low.real + spare, box_of(said).high.imag + MARGIN))
    room = Box(complex(inner.low.real, box_of(rows).high.imag + MARGIN), inner.high)
    return together([inner, inner, room], [said, rows, disc_views(desk.cam, scale)])


def disc_beside(desk: Desk, scale: float) -> Marks:
    """Views on the left with the notes below them, the table on the right above the title block."""
    inner = desk.inner
    said = moved(desk.notes(desk.beside), inner.low)
    rows = desk.table()
    rows = moved(rows, inner.high - box_of(rows).high)
    floor = max(desk.over, box_of(said).high.imag + MARGIN)
    room = Box(complex(inner.low.real, floor), complex(box_of(rows).low.real - APART, inner.high.imag))
    right = Box(complex(inner.low.real, desk.over), inner.high)
    return together([inner, right, room], [said, rows, disc_views(desk.cam, scale)])


def cylinder(desk: Desk, scale: float) -> Marks:
    """The developed groove above; below it the body on the left, on the right the table, notes and title block."""
    inner, right = desk.inner, desk.inner.high.real + MARGIN - WIDTH
    groove, body = groove_and_body(desk.cam, scale)
    floor = inner.high.imag - box_of(groove).size.imag
    said = moved(desk.notes(WIDTH - MARGIN), complex(right, desk.over))
    rows = desk.table()
    rows = moved(rows, complex(right, floor - APART) - 1j * box_of(rows).high.imag)
    column = Box(complex(right, box_of(said).high.imag + MARGIN), inner.high)
    above = Box(complex(inner.low.real, floor), inner.high)
    below = Box(inner.low, complex(right - APART, floor - APART))
    rooms, things = [inner, column, above], [said, rows, groove]
    return together([*rooms, below], [*things, body]) if body else together(rooms, things)


def together(rooms: list[Box], things: list[Marks]) -> Marks:
    """Things in their rooms, the last two in the middle of theirs; nothing if one is larger than its room."""
    found: Marks = []
    for place, (room, marks) in enumerate(zip(rooms, things, strict=True)):
        box = box_of(marks)
        spare = room.size - box.size
        if spare.real < -HAIR or spare.imag < -HAIR:
            return []
        if place < 2 and not _within(box, room):
            return []
        found += marks if place < 2 else moved(marks, room.low + spare / 2 - box.low)
    return found


def _within(box: Box, room: Box) -> bool:
    ends = box.low - room.low, room.high - box.high
    return all(gap.real >= -HAIR and gap.imag >= -HAIR for gap in ends)


def forms(grooved: bool) -> Iterator[Form]:
    """What is tried at each scale, the best first."""
    if grooved:
        yield from (Form(A3, 5.0, 4, cylinder), Form(A3, 10.0, 3, cylinder), Form(A3, 10.0, 2, cylinder))
        return
    yield from (Form(A4, 10.0, blocks, disc_above) for blocks in (3, 2))
    yield from (Form(A3, 5.0, 2, disc_beside), Form(A3, 10.0, 1, disc_beside))
