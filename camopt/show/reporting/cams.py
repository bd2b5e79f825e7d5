"""The page of one cam, or of a few side by side: turning cams, diagrams, limits, sizes, effects and files."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from camopt.core.mistakes import BadInput
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.tolerances import Tolerances
from camopt.scene.unusual_values import missing_wall_notes
from camopt.show.drawing.figures import geometry_results_line, mechanism_and_sizes_line
from camopt.show.drawing.picture import Picture
from camopt.show.exporting.export import export
from camopt.show.pictures.tolerances import draw as draw_tolerances
from camopt.show.reporting.cam_data import cam_data
from camopt.show.reporting.page import data_url, figure_url, render_page
from camopt.show.reporting.sections import (
    effects_table,
    inputs_table,
    limits_table,
    motion_table,
    quantities_table,
    train_tables,
    verdict_line,
)
from camopt.solve.tables.result import Cell, Result, Table
from camopt.solve.tolerances.batch import sample_cams
from camopt.solve.tolerances.tolerance import tolerance
from camopt.solve.verdicts.evaluation import Evaluation, evaluate_design

YIELD_CAMS = 1024
"""Cams drawn for the yield on a page."""
MEDIA_TYPES = {".toml": "application/toml", ".csv": "text/csv", ".dxf": "image/vnd.dxf"}


@dataclass(frozen=True)
class ShownCam:
    """One cam on a page, with its label, and a sentence for the head of the page."""

    label: str
    scene: Scene
    summary: str = ""
    result: Result | None = None
    """A result that gets its own chapter."""


@dataclass(frozen=True)
class Chapter:
    """A section of a page that unfolds: tables or a text."""

    title: str
    tables: list[Table] = field(default_factory=list)
    text: str = ""
    open: bool = False
    picture: str = ""
    """A picture as a data URL."""
    detail: bool = False
    """Whether only a full page prints it."""


def cams_page(
    cams: Sequence[ShownCam],
    title: str = "",
    summaries: Sequence[str] = (),
    *,
    full: bool = False,
    align_noses: bool = False,
    turn: float = 0.0,
) -> str:
    """The HTML page of cams, side by side at one scale. The default title is the name of the first cam.

    ``summaries`` are sentences for the head of the page. A ``full`` page prints effects and scenes too. Cams after
    the first are drawn so that their noses are at that of the first (``align_noses``), and then later by ``turn``
    [deg].
    """
    problems = [resolve_design(shown.scene) for shown in cams]
    evaluations = [evaluate_design(shown.scene, problem) for shown, problem in zip(cams, problems, strict=True)]
    labels = [shown.label for shown in cams]
    limits = [limits_table(each, problem) for each, problem in zip(evaluations, problems, strict=True)]
    several = len(cams) > 1
    pictures = [Picture(shown.scene, problem) for shown, problem in zip(cams, problems, strict=True)]
    words = [cam_sentences(picture) for picture in pictures]
    lines = [
        *_verdict_cells(cams, limits, labels),
        *_warning_cells(evaluations, labels),
        *(Cell(text) for text in [*([] if several else words[0]), *summaries]),
    ]
    if any(picture.undercut for picture in pictures):
        lines.append(Cell(UNDERCUT_NOTE))
    noses = [problem.programme.nose_angle_deg if align_noses else 0.0 for problem in problems]
    shifts = [0.0, *((noses[0] - nose + turn + 180.0) % 360.0 - 180.0 for nose in noses[1:])]
    for label, picture, shift in zip(labels, pictures, shifts, strict=True):
        faults = [words for name, words in FAULTS.items() if picture.quantity_values.get(name)]
        unmade = Cell(f"{label} — cannot be made: {' and '.join(faults)}.", "alarm")
        late = Cell(f"{label} — drawn {abs(shift):.4g}° {'later' if shift > 0.0 else 'earlier'} in the turn.")
        lines += [*([unmade] if several and picture.undercut else []), *([late] if shift else [])]
    titled = [replace(s, title=f"{label}: limits") for label, s in zip(labels, limits, strict=True)]
    sections = [
        Chapter(
            "Quantities", [quantities_table(evaluations, problems, labels if several else ["value"])], open=several
        ),
        *(
            each
            for shown, p in zip(cams, problems, strict=True)
            for each in cam_chapters(shown, p, with_cam_label=several)
        ),
    ]
    files, why = _downloads_and_missing_reasons(cams, several)
    return render_page(
        "cams",
        title or cams[0].scene.name,
        {
            "cams": [cam_data(picture) | {"shift": each} for picture, each in zip(pictures, shifts, strict=True)],
            "labels": labels,
            "words": words,
        },
        lines=[*lines, *([Cell(f"No files for machines: {why}.", "alarm")] if why else [])],
        tables=titled if several else limits,
        sections=sections,
        downloads=files,
        several=several,
        full=full,
    )


FAULTS = {"undercut": "it is undercut", "self_crossing": "its profile crosses itself"}
"""Quantities of cams that cannot be made, with words for each."""
UNDERCUT_NOTE = "The follower is drawn on the theoretical profile; the thin parts of this profile are cut away."


def _verdict_cells(cams: Sequence[ShownCam], limits: list[Table], labels: list[str]) -> list[Cell]:
    lines = [verdict_line(sheet, shown.scene) for shown, sheet in zip(cams, limits, strict=True)]
    if len(lines) == 1:
        return lines
    return [Cell(f"{label} — {line.text}", line.kind) for label, line in zip(labels, lines, strict=True)]


def _warning_cells(evaluations: Sequence[Evaluation], labels: list[str]) -> list[Cell]:
    """The warnings about cams; with the label of the cam if there are several."""
    warnings = [(label, text) for label, each in zip(labels, evaluations, strict=True) for text in each.warnings]
    return [
        Cell(f"{label} — {text}." if len(labels) > 1 else f"{text[0].upper()}{text[1:]}.", "alarm")
        for label, text in warnings
    ]


def cam_sentences(picture: Picture) -> list[str]:
    """Sentences on the sizes and first results of a cam, and a warning if its bore leaves no wall."""
    return [
        mechanism_and_sizes_line(picture),
        *([geometry_results_line(picture)] if picture.can_assemble else []),
        *(f"{text[0].upper()}{text[1:]}." for text in missing_wall_notes(picture.scene)),
    ]


def has_tolerances(scene: Scene, problem: Problem) -> bool:
    """Whether a scene has tolerances and its cam can be assembled."""
    exists = problem.setup.mechanism.can_assemble(problem.design, problem.programme)[0]
    return bool(scene.tolerances != Tolerances() and exists)


def cam_chapters(
    shown: ShownCam, problem: Problem, *, with_cam_label: bool = False, pictures: bool = True
) -> list[Chapter]:
    """The chapters of a cam: result (tables, then sentences), inputs, effects, tolerances, scene.

    That on tolerances has motion errors (with a picture), margins of limits and yield of a real cam.
    """
    scene, result = shown.scene, shown.result
    chapters = [
        Chapter("Sizes, materials and motion", [inputs_table(scene), motion_table(scene), *train_tables(scene)]),
        Chapter("Effects", [effects_table(problem)], detail=True),
        Chapter("Scene (TOML)", text=scene.to_toml(), detail=True),
    ]
    if result is not None:
        sentences = [[each] for each in result.sections() if isinstance(each, str) and each]
        in_words = [Table.from_texts("In words", [""], sentences)] if sentences else []
        chapters.insert(0, Chapter("Result", [*result.tables(), *in_words], open=True))
    if has_tolerances(scene, problem):
        real_cam = tolerance(scene)
        picture = figure_url(draw_tolerances(real_cam)) if pictures and real_cam.errors else ""
        tables = [*real_cam.tables(), *sample_cams(scene, YIELD_CAMS).tables()]
        chapters.insert(-1, Chapter("Tolerances", tables, picture=picture))
    if with_cam_label:
        titles = [f"{shown.label}: {each.title[0].lower()}{each.title[1:]}" for each in chapters]
        return [replace(each, title=title) for each, title in zip(chapters, titles, strict=True)]
    return chapters


def _downloads_and_missing_reasons(cams: Sequence[ShownCam], several: bool) -> tuple[list[Any], str]:
    files, reasons = [], []
    for place, cam in enumerate(cams, start=1):
        stem = re.sub(r"[^\w-]+", "-", cam.scene.name).strip("-")[:40] or "cam"
        downloads, why = cam_downloads_and_missing_reason(cam.scene, f"{stem}-{place}" if several else stem)
        files += downloads
        reasons += [f"{cam.label if several else 'the cam'} {why}"] if why else []
    return files, "; ".join(dict.fromkeys(reasons))


class Download(NamedTuple):
    """A file inside the page: its name, data URL and accuracy."""

    name: str
    address: str
    about: str


def cam_downloads_and_missing_reason(scene: Scene, stem: str) -> tuple[list[Download], str]:
    """The files of a cam, and why files for machines are missing (empty if none are)."""
    downloads, why = [], ""
    with TemporaryDirectory() as folder:
        for suffix, kind in MEDIA_TYPES.items():
            path = Path(folder) / f"{stem}{suffix}"
            try:
                written = export(scene, path)
            except BadInput as refused:
                why = "; ".join(mistake.allowed for mistake in refused.mistakes)
                continue
            unit, curves = unit_in_shown_system("mm"), written.curves.items()
            deviations = ((name, to_shown_unit(curve.deviation_mm, "mm")) for name, curve in curves)
            within = [f"{name} within {deviation:.2g} {unit} (proved)" for name, deviation in deviations]
            downloads.append(Download(path.name, data_url(path.read_bytes(), kind), "; ".join(within)))
    return downloads, why
