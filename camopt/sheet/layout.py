"""Layout of a sheet: places of views, table, notes and title block, if they fit at a scale."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from camopt.mechanisms.body import Body
from camopt.sheet.callouts import with_callouts
from camopt.sheet.cam import TrueCam
from camopt.sheet.developed import groove_and_body
from camopt.sheet.front_view import FrontView, is_upright
from camopt.sheet.marks import LARGE, Box, Marks, Words, box_of, moved
from camopt.sheet.notes import notes
from camopt.sheet.paper import A2, A3, A4, Paper, scale_name
from camopt.sheet.points_table import printed, table
from camopt.sheet.section import section
from camopt.sheet.title_block import BLOCK_HEIGHT, BLOCK_WIDTH, title_block

FROM_FRAME, VIEWS_APART = 4.0, 8.0  # mm: of what is on the sheet from the frame, and of one view from the next
FIT_SLACK = 1e-9  # mm

Placed = Iterator[tuple[Box, Marks]]
"""Rooms on the paper, each with what goes there: notes and table where they are, views in the middle of theirs."""


class Arrangement(NamedTuple):
    """A layout to try: paper, step of the table (deg), number of its blocks, and the function that places all."""

    paper: Paper
    step: float
    blocks: int
    place: "Callable[[Desk, Views], Placed]"


@dataclass(frozen=True)
class Desk:
    """The contents of a sheet apart from the views."""

    cam: TrueCam
    form: Arrangement
    texts: tuple[str, ...]

    @property
    def inner(self) -> Box:
        """The frame less a margin."""
        low, high = self.form.paper.frame
        return Box(low + complex(FROM_FRAME, FROM_FRAME), high - complex(FROM_FRAME, FROM_FRAME))

    @property
    def over(self) -> float:
        """The level above the title block."""
        return self.form.paper.frame.low.imag + BLOCK_HEIGHT + FROM_FRAME

    @property
    def beside(self) -> float:
        """The width left beside the title block."""
        return self.inner.high.real + FROM_FRAME - BLOCK_WIDTH - VIEWS_APART - self.inner.low.real

    @cached_property
    def table(self) -> Marks:
        return table(printed(self.cam, self.form.step), self.form.blocks)

    @property
    def has_room(self) -> bool:
        """Whether the sheet is larger than the table."""
        spare = self.inner.size - box_of(self.table).size
        return min(spare.real, spare.imag) >= 0.0

    def notes(self, width: float) -> Marks:
        return notes(self.texts, width)

    def standing(self, scale: float) -> Marks:
        """The frame, and the title block in its corner."""
        paper = self.form.paper
        block = title_block(self.cam.part, self.cam.title, scale_name(scale), paper.name, self.cam.sheet)
        low, high = paper.frame
        return [*paper.marks(), *moved(block, complex(high.real - BLOCK_WIDTH, low.imag))]


@dataclass(frozen=True)
class Views:
    """The views of a cam at a scale."""

    cam: TrueCam
    scale: float

    @cached_property
    def disc(self) -> Marks:
        """The front view of a disc cam, and the section beside it if the thickness is known."""
        part, front = self.cam.part, FrontView(self.cam, self.scale)
        marks = with_callouts(front)
        if not part.thickness:
            return marks
        beside = section(
            front.profiles, part, self.scale, front.walls if part.groove_depth or part.rib_height else ()
        )
        beside = moved(beside, box_of(marks).high.real + VIEWS_APART - box_of(beside).low.real)
        if not is_upright(part):
            box = box_of(beside)
            above = complex((box.low.real + box.high.real) / 2, box.high.imag + 3.0)
            beside.append(Words(above, "A–A", LARGE, 0.5))
        return [*marks, *beside]

    @cached_property
    def cylinder(self) -> tuple[Marks, Marks]:
        """The developed groove; its section and hole."""
        return groove_and_body(self.cam, self.scale)

    @cached_property
    def column(self) -> Marks:
        """Of a cylinder: the developed groove, with section and hole in the middle below it."""
        groove, body = self.cylinder
        if not body:
            return groove
        above, below = box_of(groove), box_of(body)
        middle = (above.low.real + above.high.real - below.low.real - below.high.real) / 2
        return [*groove, *moved(body, complex(middle, above.low.imag - VIEWS_APART - below.high.imag))]


def disc_above(desk: Desk, views: Views) -> Placed:
    """From above: views, table, notes, title block."""
    inner, width = desk.inner, desk.inner.size.real
    said = moved(desk.notes(width), complex(inner.low.real, desk.over))
    yield inner, said
    spare = (width - box_of(desk.table).size.real) / 2
    rows = moved(desk.table, complex(inner.low.real + spare, box_of(said).high.imag + FROM_FRAME))
    yield inner, rows
    yield Box(complex(inner.low.real, box_of(rows).high.imag + FROM_FRAME), inner.high), views.disc


def disc_beside(desk: Desk, views: Views) -> Placed:
    """The views of a disc cam beside its table."""
    return _beside(desk, lambda: views.disc)


def cylinder_beside(desk: Desk, views: Views) -> Placed:
    """The views of a cylindrical cam beside its table."""
    return _beside(desk, lambda: views.column)


def _beside(desk: Desk, views: Callable[[], Marks]) -> Placed:
    """Views on the left with the notes below them, the table on the right above the title block."""
    inner = desk.inner
    said = moved(desk.notes(desk.beside), inner.low)
    yield inner, said
    rows = moved(desk.table, inner.high - box_of(desk.table).high)
    yield Box(complex(inner.low.real, desk.over), inner.high), rows
    floor = max(desk.over, box_of(said).high.imag + FROM_FRAME)
    room = Box(complex(inner.low.real, floor), complex(box_of(rows).low.real - VIEWS_APART, inner.high.imag))
    yield room, views()


def cylindrical(desk: Desk, views: Views) -> Placed:
    """The developed groove above; below it the body on the left, on the right the table, notes and title block."""
    inner, right = desk.inner, desk.inner.high.real + FROM_FRAME - BLOCK_WIDTH
    groove, body = views.cylinder
    floor = inner.high.imag - box_of(groove).size.imag
    said = moved(desk.notes(BLOCK_WIDTH - FROM_FRAME), complex(right, desk.over))
    yield inner, said
    rows = moved(desk.table, complex(right, floor - VIEWS_APART) - 1j * box_of(desk.table).high.imag)
    yield Box(complex(right, box_of(said).high.imag + FROM_FRAME), inner.high), rows
    yield Box(complex(inner.low.real, floor), inner.high), groove
    if body:
        yield Box(inner.low, complex(right - VIEWS_APART, floor - VIEWS_APART)), body


def together(placed: Placed) -> Marks:
    """Marks placed in their rooms, from the third on centred; nothing if one is larger than its room.

    What comes after that one is not made.
    """
    found: Marks = []
    for place, (room, marks) in enumerate(placed):
        box = box_of(marks)
        spare = room.size - box.size
        if spare.real < -FIT_SLACK or spare.imag < -FIT_SLACK:
            return []
        if place < 2 and not _within(box, room):
            return []
        found += marks if place < 2 else moved(marks, room.low + spare / 2 - box.low)
    return found


def _within(box: Box, room: Box) -> bool:
    ends = box.low - room.low, room.high - box.high
    return all(gap.real >= -FIT_SLACK and gap.imag >= -FIT_SLACK for gap in ends)


MOST_BLOCKS = 12


def forms(body: Body, step: float | None = None) -> Iterator[Arrangement]:
    """The layouts to try at each scale, the best first; for a step of the table (deg) that is given, A2 too."""
    usual, beside = (CYLINDER_FORMS, cylinder_beside) if body.developed else (DISC_FORMS, disc_beside)
    if step is None:
        yield from usual
        return
    for paper, place in dict.fromkeys([*((form.paper, form.place) for form in usual), (A3, beside), (A2, beside)]):
        yield from (Arrangement(paper, step, blocks, place) for blocks in range(1, MOST_BLOCKS + 1))


CYLINDER_FORMS = (
    Arrangement(A3, 5.0, 4, cylindrical),
    *(Arrangement(A3, 10.0, blocks, cylindrical) for blocks in (4, 3, 2)),
    Arrangement(A3, 10.0, 1, cylinder_beside),
)
DISC_FORMS = (
    *(Arrangement(A4, 10.0, blocks, disc_above) for blocks in (3, 2)),
    Arrangement(A3, 5.0, 2, disc_beside),
    Arrangement(A3, 10.0, 1, disc_beside),
)
