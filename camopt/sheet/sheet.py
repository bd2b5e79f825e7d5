"""The workshop drawing, at the largest standard scale and on the smallest paper that hold it."""

import os
from itertools import islice
from math import inf, pi
from typing import NamedTuple

from camopt.drawing.canvas import pages
from camopt.mistakes import BadInput, Mistake
from camopt.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.sheet.cam import TrueCam
from camopt.sheet.layout import Desk, Views, forms, together
from camopt.sheet.marks import Marks, draw_marks
from camopt.sheet.notes import texts_of
from camopt.sheet.paper import A2, Paper, scales

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
    sheets = [_sheet(cam, step) for cam in TrueCam(scene, problem).sheets]
    least = min(sheet.scale for sheet in sheets)
    return [sheet if sheet.scale == least else _sheet(sheet.cam, step, least) for sheet in sheets]


def sheet_of(scene: Scene, problem: Problem, step: float | None = None) -> Sheet:
    """The sheet of a cam, of a pair that of the first disc, at its own scale."""
    return _sheet(TrueCam(scene, problem), step)


def _sheet(cam: TrueCam, step: float | None, most: float = inf) -> Sheet:
    """The sheet at the first scale, of those up to ``most``, and layout, the best first, that hold the drawing."""
    problem = cam.problem
    body = problem.setup.mechanism.body
    width = 2.0 * cam.size * (pi if body.developed else 1.0)
    texts = tuple(texts_of(cam))
    desks = [desk for form in forms(body, _whole(step)) if (desk := Desk(cam, form, texts)).has_room]
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


def _whole(step: float | None) -> float | None:
    """A step of the table; BadInput if it does not divide the turn."""
    if step is not None and not (step >= LEAST_STEP and (360.0 / step).is_integer()):
        raise BadInput([Mistake("camopt", "step", step, f"a step of at least {LEAST_STEP:g} deg that divides 360")])
    return step
