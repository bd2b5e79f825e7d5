"""Layout of the workshop drawing: views, table, notes and title block at the largest standard scale that fits.

The paper is the smallest one that holds them.
"""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property, partial
from itertools import islice
from math import inf, pi
from typing import NamedTuple

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.quantities.unit_systems import INCH_MM, shown_in, shown_system
from camopt.model.mechanisms.elements import Body
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.show.drawing.style import figure_pages
from camopt.show.sheet.callouts import front_view_with_callouts
from camopt.show.sheet.developed import DevelopedView
from camopt.show.sheet.front_view import FrontView, is_keyway_section_vertical
from camopt.show.sheet.marks import LARGE, MarkBox, Marks, Words, add_paper_axes, draw_marks, marks_box, shift_marks
from camopt.show.sheet.notes import note_texts, numbered_notes
from camopt.show.sheet.paper import Paper, paper_scales, scale_name, title_block
from camopt.show.sheet.points_table import points_table, table_columns
from camopt.show.sheet.section import section_marks
from camopt.show.sheet.standards import SYSTEM_OF_STANDARD, sheet_standard
from camopt.show.sheet.true_cam import TrueCam

FRAME_MARGIN, VIEW_DISTANCE = 4.0, 8.0  # mm: from the frame to the contents, and between views
FIT_SLACK = 1e-9  # mm

PlacedMarks = Iterator[tuple[MarkBox, Marks]]
"""Areas of the paper with their marks: notes and table are placed already, views are centred later."""


class Arrangement(NamedTuple):
    """A layout to try: paper, step of the table (deg), number of its blocks, and the function that places all.

    Without a step the rows of the table are so close that values between them can be interpolated.
    """

    paper: Paper
    step: float | None
    blocks: int
    place: "Callable[[SheetMargins, SheetViews], PlacedMarks]"


@dataclass(frozen=True)
class SheetMargins:
    """The contents of a sheet without the views, for one arrangement."""

    cam: TrueCam
    arrangement: Arrangement
    table: Marks
    table_box: MarkBox
    texts: tuple[str, ...]

    @property
    def frame_less_margin(self) -> MarkBox:
        """The frame less a margin."""
        low, high = self.arrangement.paper.frame
        return MarkBox(low + complex(FRAME_MARGIN, FRAME_MARGIN), high - complex(FRAME_MARGIN, FRAME_MARGIN))

    @property
    def level_above_block(self) -> float:
        """The level above the title block."""
        return self.arrangement.paper.frame.low.imag + sheet_standard().block_size.imag + FRAME_MARGIN

    @property
    def has_room_for_table(self) -> bool:
        """Whether the table fits on the sheet."""
        spare = self.frame_less_margin.size - self.table_box.size
        return min(spare.real, spare.imag) >= 0.0

    def frame_marks(self, scale: float) -> Marks:
        """The frame, and the title block in its corner."""
        paper, standard = self.arrangement.paper, sheet_standard()
        sheet_number = f"{self.cam.disc.number}/{len(self.cam.cam_of_each_sheet)}"
        fields = standard.title_fields(self.cam.part, self.cam.title, scale_name(scale), paper.name, sheet_number)
        block = title_block(fields, self.cam.language)
        low, high = paper.frame
        return [*paper.marks(), *shift_marks(block, complex(high.real - standard.block_size.real, low.imag))]


@dataclass(frozen=True)
class SheetViews:
    """The views of a cam at one scale."""

    cam: TrueCam
    scale: float

    @cached_property
    def disc_views(self) -> Marks:
        """The front view of a disc cam, with the section beside it if the thickness is known."""
        part, front = self.cam.part, FrontView(self.cam, self.scale)
        marks = front_view_with_callouts(front)
        if not part.thickness:
            return marks
        beside = section_marks(
            front.profiles, part, self.scale, front.walls if part.groove_depth or part.rib_height else ()
        )
        beside = shift_marks(beside, marks_box(marks).high.real + VIEW_DISTANCE - marks_box(beside).low.real)
        if not is_keyway_section_vertical(part):
            box = marks_box(beside)
            above = complex((box.low.real + box.high.real) / 2, box.high.imag + 3.0)
            beside.append(Words(above, sheet_standard().section_name, LARGE, 0.5))
        return [*marks, *beside]

    @cached_property
    def developed_view_and_section(self) -> tuple[Marks, Marks]:
        """The developed groove, and its section with hole."""
        view = DevelopedView(self.cam, self.scale)
        return view.developed_cylinder_marks(), view.section_and_bore_marks()

    @cached_property
    def cylinder_views_in_column(self) -> Marks:
        """Views of a cylinder: the developed groove, with section and hole centred below it."""
        groove, body = self.developed_view_and_section
        if not body:
            return groove
        above, below = marks_box(groove), marks_box(body)
        middle = (above.low.real + above.high.real - below.low.real - below.high.real) / 2
        return [*groove, *shift_marks(body, complex(middle, above.low.imag - VIEW_DISTANCE - below.high.imag))]


def views_above_table(margins: SheetMargins, views: SheetViews) -> PlacedMarks:
    """From top to bottom: views, table, notes, title block."""
    inner, width = margins.frame_less_margin, margins.frame_less_margin.size.real
    notes = shift_marks(numbered_notes(margins.texts, width), complex(inner.low.real, margins.level_above_block))
    yield inner, notes
    spare = (width - margins.table_box.size.real) / 2
    rows = shift_marks(margins.table, complex(inner.low.real + spare, marks_box(notes).high.imag + FRAME_MARGIN))
    yield inner, rows
    yield MarkBox(complex(inner.low.real, marks_box(rows).high.imag + FRAME_MARGIN), inner.high), views.disc_views


def views_beside_table(margins: SheetMargins, views: SheetViews) -> PlacedMarks:
    """Views on the left with notes below, table on the right above the title block."""
    inner = margins.frame_less_margin
    beside_block = inner.size.real + FRAME_MARGIN - sheet_standard().block_size.real - VIEW_DISTANCE
    notes = shift_marks(numbered_notes(margins.texts, beside_block), inner.low)
    yield inner, notes
    rows = shift_marks(margins.table, inner.high - margins.table_box.high)
    yield MarkBox(complex(inner.low.real, margins.level_above_block), inner.high), rows
    floor = max(margins.level_above_block, marks_box(notes).high.imag + FRAME_MARGIN)
    room = MarkBox(
        complex(inner.low.real, floor), complex(marks_box(rows).low.real - VIEW_DISTANCE, inner.high.imag)
    )
    yield (
        room,
        views.cylinder_views_in_column if margins.cam.problem.setup.mechanism.body.developed else views.disc_views,
    )


def developed_view_above_section(margins: SheetMargins, views: SheetViews) -> PlacedMarks:
    """The developed groove on top; below it the body on the left, and table, notes and title block on the right."""
    inner, wide = margins.frame_less_margin, sheet_standard().block_size.real
    right = inner.high.real + FRAME_MARGIN - wide
    groove, body = views.developed_view_and_section
    floor = inner.high.imag - marks_box(groove).size.imag
    notes = shift_marks(
        numbered_notes(margins.texts, wide - FRAME_MARGIN), complex(right, margins.level_above_block)
    )
    yield inner, notes
    rows = shift_marks(margins.table, complex(right, floor - VIEW_DISTANCE) - 1j * margins.table_box.high.imag)
    yield MarkBox(complex(right, marks_box(notes).high.imag + FRAME_MARGIN), inner.high), rows
    yield MarkBox(complex(inner.low.real, floor), inner.high), groove
    if body:
        yield MarkBox(inner.low, complex(right - VIEW_DISTANCE, floor - VIEW_DISTANCE)), body


def fit_marks_in_areas(placed: PlacedMarks) -> Marks:
    """Marks placed in their areas, or an empty list if some marks do not fit.

    Marks from the third area on are centred. After marks that do not fit, no more are made.
    """
    arranged: Marks = []
    for place, (room, marks) in enumerate(placed):
        box = marks_box(marks)
        spare = room.size - box.size
        gaps = [spare, *((box.low - room.low, room.high - box.high) if place < 2 else ())]
        if any(gap.real < -FIT_SLACK or gap.imag < -FIT_SLACK for gap in gaps):
            return []
        arranged += marks if place < 2 else shift_marks(marks, room.low + spare / 2 - box.low)
    return arranged


MOST_BLOCKS = 12


def sheet_arrangements(body: Body, step: float | None = None) -> Iterator[Arrangement]:
    """Arrangements to try at each scale, the best first.

    With a step of the table [deg], or with its dense rows, larger papers are tried too.
    """
    small, middle, *large = sheet_standard().papers
    cylinder_forms = (
        Arrangement(middle, 5.0, 4, developed_view_above_section),
        *(Arrangement(middle, 10.0, blocks, developed_view_above_section) for blocks in (4, 3, 2)),
        Arrangement(middle, 10.0, 1, views_beside_table),
    )
    disc_forms = (
        *(Arrangement(small, 10.0, blocks, views_above_table) for blocks in (3, 2)),
        Arrangement(middle, 5.0, 2, views_beside_table),
        Arrangement(middle, 10.0, 1, views_beside_table),
    )
    defaults = cylinder_forms if body.developed else disc_forms
    if step is None and not sheet_standard().has_dense_table:
        yield from defaults
        return
    for paper, place in dict.fromkeys(
        [
            *((form.paper, form.place) for form in defaults),
            *((paper, views_beside_table) for paper in (middle, *large)),
        ]
    ):
        yield from (Arrangement(paper, step, blocks, place) for blocks in range(1, MOST_BLOCKS + 1))


LEAST_STEP = 0.5  # deg: smallest step of the table
MOST_SCALES = 40  # scales to try, down to 1 : 10¹³


class Sheet(NamedTuple):
    """A paper with all marks, in mm from its lower left corner, and its scale."""

    cam: TrueCam
    paper: Paper
    scale: float
    marks: Marks


def write_sheets(
    scene: Scene,
    problem: Problem,
    path: str | os.PathLike[str],
    step: float | None = None,
    only_disc: int | None = None,
) -> list[Sheet]:
    """Write the workshop drawing of a cam as a PDF at true size.

    If no step is given, rows of its table are 5 or 10 deg apart; by ASME they are 1 deg apart in strokes.
    A sheet is A4 or A3, or A2 for a table with many rows; by ASME it is A to D. It shows the front view of a disc
    cam with the angles of its motion and its section, or the developed groove of a cylindrical cam with its section
    and hole. It has the table of the profile, notes and the title block. The scale is 1:1 if that fits, else the
    nearest standard scale.

    A pair of discs has a sheet for each disc (``only_disc``: number of a single one), with the other disc dashed,
    and the section of both. The same scene gives the same file.

    Raises
    ------
    BadInput
        If the name does not end in .pdf (or .png, .svg for one sheet), or the table does not fit on a sheet.
    OSError
        If the file cannot be written.
    """
    sheets = [each for each in sheets_of(scene, problem, step) if only_disc in (None, each.cam.disc.number)]
    sizes = [(sheet.paper.width / INCH_MM, sheet.paper.height / INCH_MM) for sheet in sheets]
    with figure_pages(path, sizes) as figures:
        for sheet, figure in zip(sheets, figures, strict=True):
            draw_marks(add_paper_axes(figure, sheet.paper.width, sheet.paper.height), sheet.marks)
    return sheets


def sheets_of(scene: Scene, problem: Problem, step: float | None = None) -> list[Sheet]:
    """The sheets of all discs, at the same scale."""
    sheets = [sheet_of(cam, step) for cam in TrueCam(scene, problem).cam_of_each_sheet]
    least = min(sheet.scale for sheet in sheets)
    return [sheet if sheet.scale == least else sheet_of(sheet.cam, step, least) for sheet in sheets]


def sheet_of(cam: TrueCam, step: float | None = None, largest_scale: float = inf) -> Sheet:
    """The sheet with the first scale, up to ``largest_scale``, and arrangement that hold the drawing."""
    with shown_in(SYSTEM_OF_STANDARD.get(cam.part.standard or "", shown_system())):
        return _fitting_sheet(cam, step, largest_scale)


def _fitting_sheet(cam: TrueCam, step: float | None, largest_scale: float) -> Sheet:
    if step is not None and not (step >= LEAST_STEP and (360.0 / step).is_integer()):
        raise BadInput([Mistake("camopt", "step", step, f"a step of at least {LEAST_STEP:g} deg that divides 360")])
    body = cam.problem.setup.mechanism.body
    width = 2.0 * cam.base_or_mean_radius * (pi if body.developed else 1.0)
    texts = tuple(note_texts(cam))
    columns = cache(partial(table_columns, cam))

    @cache  # arrangements share few tables
    def table_and_box(step: float | None, blocks: int) -> tuple[Marks, MarkBox]:
        marks = points_table(columns(step), blocks)
        return marks, marks_box(marks)

    trials = [
        trial
        for form in sheet_arrangements(body, step)
        if (trial := SheetMargins(cam, form, *table_and_box(form.step, form.blocks), texts)).has_room_for_table
    ]
    largest = sheet_standard().papers[-1]
    for scale in (
        scale
        for scale in islice(paper_scales(2.0 * cam.base_or_mean_radius, sheet_standard().scale_series), MOST_SCALES)
        if width * scale < largest.width and scale <= largest_scale
    ):
        views = SheetViews(cam, scale)
        for trial in trials:
            if marks := fit_marks_in_areas(trial.arrangement.place(trial, views)):
                return Sheet(
                    cam,
                    trial.arrangement.paper,
                    scale,
                    [*trial.frame_marks(scale), *map(cam.localise_mark, marks)],
                )
    if step is not None:
        why = f"larger: a table with this step does not fit on {largest.name}; a .csv file has any step"
        raise BadInput([Mistake("camopt", "step", step, why)])
    raise BadInput(
        [Mistake(cam.scene.file, "scene", cam.scene.name, f"a cam that fits on a sheet of {largest.name}")]
    )
