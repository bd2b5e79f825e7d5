"""The sheet of a construction: problem, diagrams, profile, answers and table on A3; or a page for each step."""

from collections.abc import Sequence
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np

from camopt.core.quantities.unit_systems import INCH_MM
from camopt.core.storage.files import checked_suffix
from camopt.model.motion.stroke import RETURN, RISE
from camopt.show.drawing import diagrams
from camopt.show.drawing.cam import draw_rotation_arrow
from camopt.show.drawing.construction.answers import cam_speed_and_peak_lines, motion_in_words
from camopt.show.drawing.construction.construct import Construction
from camopt.show.drawing.construction.displacement import DiagramScale, displacement_steps
from camopt.show.drawing.construction.inversion import Inversion
from camopt.show.drawing.construction.shapes import Step
from camopt.show.drawing.figures import geometry_results_line, mechanism_and_sizes_line
from camopt.show.drawing.frames import write_still_gif
from camopt.show.drawing.labels import Label, label_place_candidates, place_labels
from camopt.show.drawing.panels import motion_panels
from camopt.show.drawing.picture import Picture, round_down_to_1_2_5
from camopt.show.drawing.style import (
    ALARM,
    COLOURS,
    FAINT,
    FILL,
    HEADING_SIZE,
    INK,
    MUTED,
    PITCH_COLOUR,
    REFERENCE_COLOUR,
    SMALL_SIZE,
    TEXT_SIZE,
    TITLE_SIZE,
    Figure,
    Target,
    figure_pages,
)

A3, A4 = (420.0, 297.0), (297.0, 210.0)  # mm, landscape
TURN_WIDTH, STROKE_HEIGHT = 140.0, 42.0  # mm on the paper for 360° and for the stroke of the displacement diagram
MOST_ROWS = 30  # rows of a table that fit on the sheet
COLUMN_ENDS = (4.0, 10.0, 36.0, 62.0, 90.0, 118.0, 148.0, 180.0)  # mm: right ends of the columns of the table
DASHED, DOTTED = (0, (5, 2.5)), (0, (1.2, 1.6))
PEN_STYLES: dict[str, dict[str, Any]] = {
    "thin": {"ec": FAINT, "lw": 0.6, "zorder": 1.5},
    "axis": {"ec": INK, "lw": 1.0, "zorder": 2},
    "angle": {"ec": FAINT, "lw": 0.7, "zorder": 1.5},
    "reference": {"ec": MUTED, "lw": 0.8, "ls": DASHED, "zorder": 2},
    "guide": {"ec": MUTED, "lw": 0.6, "zorder": 2},
    "construction": {"ec": REFERENCE_COLOUR, "lw": 0.9, "zorder": 2.2},
    "projection": {"ec": REFERENCE_COLOUR, "lw": 0.6, "ls": DOTTED, "zorder": 2.1},
    "ordinate": {"ec": COLOURS[RETURN], "lw": 1.5, "zorder": 3},
    "body": {"ec": COLOURS[RISE], "lw": 0.6, "zorder": 2.4},
    "pitch": {"ec": PITCH_COLOUR, "lw": 1.0, "ls": (0, (9, 2.5, 1.5, 2.5)), "zorder": 3},
    "curve": {"ec": INK, "lw": 1.8, "zorder": 4},
    "arrow": {"ec": MUTED, "lw": 1.1, "zorder": 2.5},
    "left": {"fill": True, "fc": FILL, "ec": ALARM, "lw": 1.0, "zorder": 3.5},
}
MARK_STYLES: dict[str, dict[str, Any]] = {
    "point": {"marker": "o", "ms": 1.8, "color": MUTED, "zorder": 5},
    "station": {"marker": "o", "ms": 3.0, "color": INK, "zorder": 5},
}
LETTER_STYLES: dict[str, dict[str, Any]] = {
    "letter": {"fontsize": TEXT_SIZE, "color": INK, "fontweight": "bold", "zorder": 6},
    "number": {"fontsize": SMALL_SIZE - 1.0, "color": MUTED, "zorder": 6},
    "note": {"fontsize": SMALL_SIZE - 1.0, "color": REFERENCE_COLOUR, "zorder": 6},
}
LETTER_DISTANCES = (3.0, 6.0, 10.0, 15.0, 21.0, 28.0)  # points from a point to its letter
STEPWISE_SUFFIXES = (".pdf", ".gif")
"""Files with a page or a frame for each step."""
NEW_STEP_COLOUR = ALARM
"""Colour of the additions of a step, on its own page."""


class PaperArea(NamedTuple):
    """A rectangle on the paper [mm from the lower left corner]."""

    left: float
    bottom: float
    width: float
    height: float


Layout = dict[str, PaperArea]
LAYOUT_BESIDE: Layout = {
    "diagram": PaperArea(14.0, 205.0, TURN_WIDTH + 46.0, STROKE_HEIGHT + 24.0),
    "velocity": PaperArea(44.0, 170.0, TURN_WIDTH, 26.0),
    "acceleration": PaperArea(44.0, 132.0, TURN_WIDTH, 26.0),
    "answers": PaperArea(14.0, 90.0, 186.0, 30.0),
    "table": PaperArea(14.0, 6.0, 180.0, 70.0),
    "profile": PaperArea(206.0, 74.0, 204.0, 196.0),
    "steps": PaperArea(206.0, 8.0, 204.0, 58.0),
}
"""Places for a disc cam, with the profile on the right."""
LAYOUT_BELOW: Layout = {
    "diagram": PaperArea(14.0, 205.0, TURN_WIDTH + 46.0, STROKE_HEIGHT + 24.0),
    "velocity": PaperArea(222.0, 236.0, TURN_WIDTH, 26.0),
    "acceleration": PaperArea(222.0, 196.0, TURN_WIDTH, 26.0),
    "answers": PaperArea(14.0, 68.0, 190.0, 30.0),
    "table": PaperArea(222.0, 6.0, 186.0, 92.0),
    "profile": PaperArea(14.0, 104.0, 392.0, 84.0),
    "steps": PaperArea(14.0, 6.0, 196.0, 60.0),
}
"""Places for a cylinder, with the development below the diagrams."""
HEADING_PLACE, STEP_PLACE = PaperArea(14.0, 278.0, 392.0, 12.0), PaperArea(12.0, 185.0, 273.0, 18.0)
DIAGRAM_PAGE, PROFILE_PAGE = PaperArea(4.0, 30.0, 285.0, 120.0), PaperArea(12.0, 8.0, 273.0, 172.0)
"""Places on pages of single steps."""


class PaperPage(NamedTuple):
    """A figure on a paper with a size in mm."""

    figure: Any
    paper: tuple[float, float]

    def axes_at(self, area: PaperArea) -> Any:
        """Axes at a place."""
        width, height = self.paper
        return self.figure.add_axes(
            (area.left / width, area.bottom / height, area.width / width, area.height / height)
        )

    def scaled_axes(self, area: PaperArea, corner: complex, scale: float = 1.0) -> Any:
        """Axes without a frame, with ``scale`` mm of paper per unit, from a corner."""
        axes, reach = self.axes_at(area), corner + complex(area.width, area.height) / scale
        axes.set(xlim=(corner.real, reach.real), ylim=(corner.imag, reach.imag))
        axes.set_axis_off()
        return axes

    def write_title_and_lines(self, area: PaperArea, title: str, lines: Sequence[str], font_size: float) -> None:
        """Write a title with lines below, wrapped at the width of the place."""
        letters = int(area.width / (0.19 * font_size))
        text = "\n".join(part for each in lines for part in wrap(each, letters, subsequent_indent="   "))
        self.write_at(area.left, area.bottom + area.height, title, fontsize=HEADING_SIZE, fontweight="bold")
        self.write_at(area.left, area.bottom + area.height - 5.0, text, fontsize=font_size, linespacing=1.3)

    def write_at(self, left: float, top: float, text: str, **style: Any) -> None:
        """Write a text below a point of the paper [mm]."""
        self.figure.text(left / self.paper[0], top / self.paper[1], text, va="top", **style)


def draw(construction: Construction, path: Target = None, steps: bool = False) -> "Figure":
    """Draw a construction on one sheet; with ``steps`` a page (PDF) or frame (GIF) for each step."""
    inversion = construction.inversion
    if steps:
        return _draw_step_pages(inversion, path)
    picture, layout = inversion.picture, LAYOUT_BELOW if inversion.is_developed else LAYOUT_BESIDE
    with figure_pages(path, [(A3[0] / INCH_MM, A3[1] / INCH_MM)]) as (figure,):
        page = PaperPage(figure, A3)
        given = f"Given:  {motion_in_words(inversion)};  {mechanism_and_sizes_line(picture)}"
        page.write_title_and_lines(HEADING_PLACE, picture.scene.name, [given], TEXT_SIZE)
        diagram, profile = displacement_steps(inversion.plan, _diagram_scale(picture)), inversion.steps()
        labels = draw_steps(page.scaled_axes(layout["diagram"], -30.0 - 15.0j), diagram)
        rates = [page.axes_at(layout[name]) for name in ("velocity", "acceleration")]
        shown = [panel.in_shown_units() for panel in motion_panels(picture)[1:3]]
        labels += diagrams.draw_diagrams(rates, picture, shown, (), (1,))
        labels += _draw_profile_steps(page, inversion, profile, layout["profile"])
        page.write_title_and_lines(
            layout["answers"],
            "Answers",
            [*cam_speed_and_peak_lines(inversion), geometry_results_line(picture)],
            TEXT_SIZE,
        )
        lines = [f"{number}. {step.sentence}" for number, step in enumerate([*diagram, *profile], start=1)]
        page.write_title_and_lines(layout["steps"], "Steps", lines, SMALL_SIZE - 0.5)
        table, area = construction.table(), layout["table"]
        rows = [table.heads, *(table.rows if len(table.rows) <= MOST_ROWS else [])]  # the command prints it too
        height = min(4.2, area.height / len(rows))
        for number, row in enumerate(rows):
            style = {"fontsize": min(SMALL_SIZE, height * 1.75), "color": INK if number else MUTED}
            for cell, right in zip(row, COLUMN_ENDS, strict=True):
                top = area.bottom + area.height - height * number
                page.write_at(area.left + right, top, cell.text, ha="right", **style)
        place_labels(figure, labels)
    return figure


def _diagram_scale(picture: Picture, factor: float = 1.0) -> DiagramScale:
    return DiagramScale(
        factor * TURN_WIDTH / (2.0 * np.pi), factor * STROKE_HEIGHT / picture.problem.programme.lift
    )


def draw_steps(axes: Any, steps: Sequence[Step], highlighted_step: int | None = None) -> list[Label]:
    """Draw the lines of steps, and return their letters; the step ``highlighted_step`` has another colour."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    labels = []
    for place, step in enumerate(steps):
        new = place == highlighted_step
        for shape in step.shapes:
            if shape.pen in MARK_STYLES:
                style = MARK_STYLES[shape.pen] | ({"color": NEW_STEP_COLOUR} if new else {})
                axes.plot(shape.points.real, shape.points.imag, ls="none", gid=shape.name, mew=0.0, **style)
                continue
            path = Path(np.column_stack([shape.points.real, shape.points.imag]))
            path.should_simplify = False  # simplifying shifts points of a file by a tenth of a pixel
            style = {"fill": False} | PEN_STYLES[shape.pen] | ({"ec": NEW_STEP_COLOUR} if new else {})
            axes.add_artist(PathPatch(path, gid=shape.name, **style))  # add_patch computes limits point by point
        for letter in step.letters:
            point, style = (letter.point.real, letter.point.imag), dict(LETTER_STYLES[letter.pen])
            places = label_place_candidates(LETTER_DISTANCES, letter.direction)
            labels.append(Label(axes, letter.text, point, places, style, 1.0))
    return sorted(labels, key=lambda label: len(label.text))


def _draw_profile_steps(
    page: PaperPage, inversion: Inversion, steps: list[Step], area: PaperArea, newest_step: int | None = None
) -> list[Label]:
    """Draw the profile at a round scale, with an arrow for the cam.

    Steps after ``newest_step`` only reserve their room.
    """
    points = np.concatenate([shape.points for step in steps for shape in step.shapes])
    low, high = complex(points.real.min(), points.imag.min()), complex(points.real.max(), points.imag.max())
    extent, room = high - low, 8.0
    scale = round_scale(min((area.width - room) / extent.real, (area.height - room) / extent.imag))
    corner = (low + high) / 2 - complex(area.width, area.height) / 2 / scale
    axes = page.scaled_axes(area, corner, scale)
    sense = [] if inversion.is_developed else [draw_rotation_arrow(axes, inversion.picture)]
    ratio = f"{scale:g}:1" if scale >= 1.0 else f"1:{1.0 / scale:g}"
    page.write_at(area.left, area.bottom + area.height, f"Scale {ratio}", fontsize=TEXT_SIZE)
    return [*sense, *draw_steps(axes, steps if newest_step is None else steps[: newest_step + 1], newest_step)]


def round_scale(largest: float) -> float:
    """The largest scale 1:1, 1:2, 1:2.5, 1:4, 1:5, 1:10, … or 2:1, 5:1, 10:1, … that is not above a value."""
    if largest >= 1.0:
        return round_down_to_1_2_5(largest)
    power = 10.0 ** np.floor(np.log10(1.0 / largest))
    return 1.0 / float(
        min(step * power for step in (1.0, 2.0, 2.5, 4.0, 5.0, 10.0) if step * power * largest >= 1.0)
    )


def _draw_step_pages(inversion: Inversion, path: Target) -> "Figure":
    """Draw a page for each step, with the lines of the step in red."""
    animated = path is not None and checked_suffix(path, "path", STEPWISE_SUFFIXES) == ".gif"
    diagram, profile = displacement_steps(inversion.plan, _diagram_scale(inversion.picture, 1.5)), inversion.steps()
    every = [*diagram, *profile]
    with figure_pages(None if animated else path, [(A4[0] / INCH_MM, A4[1] / INCH_MM)] * len(every)) as figures:
        for number, (figure, step) in enumerate(zip(figures, every, strict=True)):
            page, new = PaperPage(figure, A4), number - len(diagram)
            page.write_title_and_lines(
                STEP_PLACE,
                f"{number + 1}/{len(every)}  {inversion.picture.scene.name}",
                [step.sentence],
                TITLE_SIZE,
            )
            if new < 0:
                labels = draw_steps(page.scaled_axes(DIAGRAM_PAGE, -46.0 - 30.0j), every[: number + 1], number)
            else:
                labels = _draw_profile_steps(page, inversion, profile, PROFILE_PAGE, new)
            place_labels(figure, labels)
        if animated and path is not None:
            write_still_gif(figures, path)
    return figures[-1]
