"""The workshop drawing: places of views, table, notes and title block, at the largest standard scale that fits.

The paper is the smallest that holds them.
"""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from math import inf, pi
from typing import NamedTuple

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.mechanisms.elements import Body
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.show.drawing.style import pages
from camopt.show.sheet.callouts import with_callouts
from camopt.show.sheet.cam import TrueCam
from camopt.show.sheet.developed import DevelopedView
from camopt.show.sheet.front_view import FrontView, is_upright
from camopt.show.sheet.marks import LARGE, Box, Marks, Words, box_of, draw_marks, moved
from camopt.show.sheet.notes import notes, texts_of
from camopt.show.sheet.paper import A2, A3, A4, BLOCK_HEIGHT, BLOCK_WIDTH, Paper, scale_name, scales, title_block
from camopt.show.sheet.points_table import printed, table
from camopt.show.sheet.section import section

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
        view = DevelopedView(self.cam, self.scale)
        return view.groove(), view.body()

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
    said = moved(notes(desk.texts, width), complex(inner.low.real, desk.over))
    yield inner, said
    spare = (width - box_of(desk.table).size.real) / 2
    rows = moved(desk.table, complex(inner.low.real + spare, box_of(said).high.imag + FROM_FRAME))
    yield inner, rows
    yield Box(complex(inner.low.real, box_of(rows).high.imag + FROM_FRAME), inner.high), views.disc


def views_beside_table(desk: Desk, views: Views) -> Placed:
    """Views on the left with the notes below them, the table on the right above the title block."""
    inner = desk.inner
    said = moved(notes(desk.texts, desk.beside), inner.low)
    yield inner, said
    rows = moved(desk.table, inner.high - box_of(desk.table).high)
    yield Box(complex(inner.low.real, desk.over), inner.high), rows
    floor = max(desk.over, box_of(said).high.imag + FROM_FRAME)
    room = Box(complex(inner.low.real, floor), complex(box_of(rows).low.real - VIEWS_APART, inner.high.imag))
    yield room, views.column if desk.cam.problem.setup.mechanism.body.developed else views.disc


def cylindrical(desk: Desk, views: Views) -> Placed:
    """The developed groove above; below it the body on the left, on the right the table, notes and title block."""
    inner, right = desk.inner, desk.inner.high.real + FROM_FRAME - BLOCK_WIDTH
    groove, body = views.cylinder
    floor = inner.high.imag - box_of(groove).size.imag
    said = moved(notes(desk.texts, BLOCK_WIDTH - FROM_FRAME), complex(right, desk.over))
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
        ends = (box.low - room.low, room.high - box.high) if place < 2 else ()
        if any(gap.real < -FIT_SLACK or gap.imag < -FIT_SLACK for gap in ends):
            return []
        found += marks if place < 2 else moved(marks, room.low + spare / 2 - box.low)
    return found


MOST_BLOCKS = 12


def forms(body: Body, step: float | None = None) -> Iterator[Arrangement]:
    """The layouts to try at each scale, the best first; for a step of the table (deg) that is given, A2 too."""
    usual = CYLINDER_FORMS if body.developed else DISC_FORMS
    if step is None:
        yield from usual
        return
    for paper, place in dict.fromkeys(
        [*((form.paper, form.place) for form in usual), (A3, views_beside_table), (A2, views_beside_table)]
    ):
        yield from (Arrangement(paper, step, blocks, place) for blocks in range(1, MOST_BLOCKS + 1))


CYLINDER_FORMS = (
    Arrangement(A3, 5.0, 4, cylindrical),
    *(Arrangement(A3, 10.0, blocks, cylindrical) for blocks in (4, 3, 2)),
    Arrangement(A3, 10.0, 1, views_beside_table),
)
DISC_FORMS = (
    *(Arrangement(A4, 10.0, blocks, disc_above) for blocks in (3, 2)),
    Arrangement(A3, 5.0, 2, views_beside_table),
    Arrangement(A3, 10.0, 1, views_beside_table),
)


INCH = 25.4  # mm
LEAST_STEP = 0.5  # deg
TRIED = 40  # scales, down to 1 : 10¹³


class Sheet(NamedTuple):
    """A paper with all its marks, in mm from its lower left corner, at a scale."""

    cam: TrueCam
    paper: Paper
    scale: float
    marks: Marks


def write_sheets(
    scene: Scene,
    problem: Problem,
    path: str | os.PathLike[str],
    step: float | None = None,
    only: int | None = None,
) -> list[Sheet]:
    """The workshop drawing of a scene's cam as a PDF at true size, its table in steps of 5 or 10 deg if not given.

    One sheet, A4 or A3 (A2 for a table of many rows): the front view of a disc cam with the angles of its motion,
    and its section; or the developed groove of a cylindrical cam, its section and its hole; the table of the
    profile; notes; the title block. At 1:1 where that fits, or else at the nearest standard scale. Of a pair of
    discs one sheet each (``only`` that of the disc with a number), with the other disc dashed, and the section of
    both. The same scene gives the same file.

    Raises
    ------
    BadInput
        If the name does not end in .pdf (.png or .svg of one sheet), or the table does not fit on a sheet.
    OSError
        If the file cannot be written.
    """
    sheets = [each for each in sheets_of(scene, problem, step) if only in (None, each.cam.disc.number)]
    sizes = [(sheet.paper.width / INCH, sheet.paper.height / INCH) for sheet in sheets]
    with pages(path, sizes) as figures:
        for sheet, figure in zip(sheets, figures, strict=True):
            axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
            axes.set_axis_off()
            axes.set_xlim(0.0, sheet.paper.width)
            axes.set_ylim(0.0, sheet.paper.height)
            draw_marks(axes, sheet.marks)
    return sheets


def sheets_of(scene: Scene, problem: Problem, step: float | None = None) -> list[Sheet]:
    """The sheets of all discs, at one scale."""
    sheets = [sheet_of(cam, step) for cam in TrueCam(scene, problem).sheets]
    least = min(sheet.scale for sheet in sheets)
    return [sheet if sheet.scale == least else sheet_of(sheet.cam, step, least) for sheet in sheets]


def sheet_of(cam: TrueCam, step: float | None = None, most: float = inf) -> Sheet:
    """The sheet at the first scale, of those up to ``most``, and layout, the best first, that hold the drawing."""
    if step is not None and not (step >= LEAST_STEP and (360.0 / step).is_integer()):
        raise BadInput([Mistake("camopt", "step", step, f"a step of at least {LEAST_STEP:g} deg that divides 360")])
    body = cam.problem.setup.mechanism.body
    width = 2.0 * cam.size * (pi if body.developed else 1.0)
    texts = tuple(texts_of(cam))
    desks = [desk for form in forms(body, step) if (desk := Desk(cam, form, texts)).has_room]
    for scale in (
        each for each in islice(scales(2.0 * cam.size), TRIED) if width * each < A2.width and each <= most
    ):
        views = Views(cam, scale)
        for desk in desks:
            if marks := together(desk.form.place(desk, views)):
                return Sheet(cam, desk.form.paper, scale, [*desk.standing(scale), *map(cam.numbered, marks)])
    if step is not None:
        why = "larger: a table of so many rows has no room on a sheet of A2; a .csv file has any step"
        raise BadInput([Mistake("camopt", "step", step, why)])
    raise BadInput([Mistake(cam.scene.file, "scene", cam.scene.name, "a cam that fits on a sheet of A3")])
