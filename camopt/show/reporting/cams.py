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
from camopt.scene.unusual_values import missing_wall_notes
from camopt.show.drawing.figures import geometry_results_line, mechanism_and_sizes_line
from camopt.show.drawing.picture import Picture
from camopt.show.exporting.export import export
from camopt.show.reporting.cam_data import cam_data
from camopt.show.reporting.page import data_url, render_page
from camopt.show.reporting.sections import (
    effects_table,
    inputs_table,
    limits_table,
    motion_table,
    quantities_table,
    train_tables,
    verdict_line,
)
from camopt.show.reporting.tolerances import YIELD_CAMS, errors_image_url, has_tolerances
from camopt.solve.tables.result import Cell, Result, Table
from camopt.solve.tolerances.batch import sample_cams
from camopt.solve.tolerances.tolerance import tolerance
from camopt.solve.verdicts.evaluation import Evaluation, evaluate_design

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
    head = [*([] if several else words[0]), *summaries]
    lines = [
        *_verdict_cells(cams, limits, labels),
        *_warning_cells(evaluations, labels),
        *(Cell(text) for text in head),
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
    thin = [f"{text[0].upper()}{text[1:]}." for text in missing_wall_notes(picture.scene)]
    return [
        mechanism_and_sizes_line(picture),
        *([geometry_results_line(picture)] if picture.can_assemble else []),
        *thin,
    ]


def cam_chapters(
    shown: ShownCam, problem: Problem, *, with_cam_label: bool = False, pictures: bool = True
) -> list[Chapter]:
    """The chapters of a cam: result, inputs, effects, tolerances (with a picture of the errors), scene."""
    prefix = f"{shown.label}: " if with_cam_label else ""
    return [
        *_result_chapters(shown.result, prefix),
        Chapter(
            _prefixed_title(prefix, "Sizes, materials and motion"),
            [inputs_table(shown.scene), motion_table(shown.scene), *train_tables(shown.scene)],
        ),
        Chapter(_prefixed_title(prefix, "Effects"), [effects_table(problem)], detail=True),
        *_tolerance_chapters(shown.scene, problem, prefix, pictures),
        Chapter(_prefixed_title(prefix, "Scene (TOML)"), text=shown.scene.to_toml(), detail=True),
    ]


def _result_chapters(result: Result | None, prefix: str) -> list[Chapter]:
    """A chapter with the tables of a result, then its sentences."""
    if result is None:
        return []
    sentences = [each for each in result.sections() if isinstance(each, str) and each]
    tables = [*result.tables(), Table.from_texts("In words", [""], [[sentence] for sentence in sentences])]
    return [Chapter(_prefixed_title(prefix, "Result"), tables if sentences else tables[:-1], open=True)]


def _tolerance_chapters(scene: Scene, problem: Problem, prefix: str, pictures: bool) -> list[Chapter]:
    """Motion errors, margins of limits and yield of a real cam; no chapter without tolerances."""
    if not has_tolerances(scene, problem):
        return []
    result = tolerance(scene)
    picture = errors_image_url(result) if pictures and result.errors else ""
    tables = [*result.tables(), *sample_cams(scene, YIELD_CAMS).tables()]
    return [Chapter(_prefixed_title(prefix, "Tolerances"), tables, picture=picture)]


def _prefixed_title(prefix: str, title: str) -> str:
    return f"{prefix}{title[0].lower()}{title[1:]}" if prefix else title


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
