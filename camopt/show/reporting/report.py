"""Reports: a scene, a result, a machine or a folder as one HTML page, of cams, tables of designs or a machine."""

import json
import os
from collections.abc import Iterable
from dataclasses import replace
from functools import singledispatch
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.core.mistakes import BadInput, Mistake, escape_unprintable
from camopt.core.quantities.unit_systems import shown_system
from camopt.core.storage.files import (
    check_writable,
    checked_path,
    checked_suffix,
    decode_user_text,
    expand_user_path,
    read_bytes,
    write_text,
)
from camopt.core.storage.manifest import Manifest, open_checked_result_file, read_manifest, result_paths
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.machine import Machine, is_machine
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import RESULT_WORDS, Scene, scene_named
from camopt.show.reporting.cams import ShownCam, cams_page
from camopt.show.reporting.machine import machine_page
from camopt.show.reporting.results import ResultRows, results_page, thinned_result_rows
from camopt.solve.front.result import DESIGNS_TABLE, Sweep
from camopt.solve.machine.evaluation import MachineEvaluation, evaluate_machine
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.synthesis.files import FRONTIER, KNOWN_FILE, SCENE_FILE, SENTENCE_KEYS, SUMMARY_FILE
from camopt.solve.synthesis.known_law_cams import build_known_law_cams
from camopt.solve.synthesis.result_sentences import bound_in_words
from camopt.solve.synthesis.synthesis_result import Synthesis
from camopt.solve.tables.designs import DESIGNS, OPTIMUM, PARETO, Design, joined_laws, scene_of
from camopt.solve.tables.result import Result
from camopt.solve.tables.table import read_data_frame
from camopt.solve.verdicts.evaluation import Evaluation

if TYPE_CHECKING:
    import pandas as pd

MOST_PAGE_CAMS = 4  # side by side
PageItem = ShownCam | ResultRows | MachineEvaluation
"""What a page shows: cams, tables of designs, or one machine."""


def report(
    what: Any,
    path: str | os.PathLike[str],
    *,
    full: bool = False,
    align_noses: bool = False,
    turn: float = 0.0,
) -> Path:
    """Write a result as one HTML file.

    Parameters
    ----------
    what : Scene, Machine, Design, Result, str, os.PathLike or list
        A scene, a design, any result of a scene, the folder or table (Parquet) that a command wrote, or a list of
        these: up to four cams side by side, or several tables of designs. For a result other than a sweep, an
        optimum or a synthesis, the page shows the cam and adds a chapter with the result. The page of a machine has
        all its cams, its timing diagram with one cursor, the tables of its evaluation and a section per station.
    path : str or os.PathLike
        The file, which ends in .html.
    full : bool, optional
        Also print the effects and the scene (TOML). The page has both in any case, folded.
    align_noses : bool, optional
        Draw the other cams later or earlier in the turn, so that their noses are at that of the first. The nose is
        the highest point of the motion, or the middle of the dwell there.
    turn : float, optional
        Draw the other cams later in the turn by this cam angle [deg]; with ``align_noses`` after the alignment.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    BadInput
        If ``what`` is something else, if a scene lacks a size, or if cams, tables and machines are mixed.
    OSError
        If a file cannot be read or written.

    Examples
    --------
    >>> page = camopt.report(camopt.find_scene("two-pauses"), "cam.html")
    """
    checked_suffix(path, "path", (".html",))
    place = expand_user_path(path)
    check_writable(place)
    targets = what if isinstance(what, (list, tuple)) else [what]
    items = [item for target in targets for item in page_items(target)]
    write_text(place, _page_html(items, full, align_noses, turn))
    return place


def _page_html(items: list[PageItem], full: bool, align_noses: bool, turn: float) -> str:
    if machines := [item for item in items if isinstance(item, MachineEvaluation)]:
        if len(items) > 1 or align_noses or turn:
            raise BadInput(
                [Mistake("camopt", "what", len(items), "one machine by itself, without align_noses or turn")]
            )
        return machine_page(machines[0], full=full)
    cams, results = [x for x in items if isinstance(x, ShownCam)], [x for x in items if isinstance(x, ResultRows)]
    if bool(cams) == bool(results):
        raise BadInput([Mistake("camopt", "what", None, "either cams or tables of designs, not both")])
    if len(cams) > MOST_PAGE_CAMS:
        raise BadInput([Mistake("camopt", "what", len(cams), f"at most {MOST_PAGE_CAMS} cams side by side")])
    if (align_noses or turn) and len(cams) < 2:
        raise BadInput([Mistake("camopt", "what", None, "at least two cams, for align_noses or turn")])
    if not isfinite(turn or 0.0):
        raise BadInput([Mistake("camopt", "turn", turn, "a finite angle, in deg")])
    if results:
        return results_page(_with_distinct_names(results), full)
    first, *others = dict.fromkeys(cam.scene.name for cam in cams)
    title = first + (f" beside {others[0]}" if len(others) == 1 else f" and {len(others)} others" if others else "")
    summaries = [cam.summary for cam in cams if cam.summary]
    return cams_page(_with_distinct_names(cams), title, summaries, full=full, align_noses=align_noses, turn=turn)


def _with_distinct_names(items: list[Any]) -> list[Any]:
    """Items with distinct names: the laws are added to labels of cams if they differ, then numbers."""
    cams = isinstance(items[0], ShownCam)
    field = "label" if cams else "name"
    if cams and len({cam.label for cam in items}) < len(items):
        programmes = [resolve_design(cam.scene).programme for cam in items]
        # "moves" for a cam that has only moves
        laws = [joined_laws(each.law_names(RISE), each.law_names(RETURN)) or "moves" for each in programmes]
        if len({*laws}) > 1:
            items = [replace(cam, label=f"{cam.label}, {law}") for cam, law in zip(items, laws, strict=True)]
    names = [getattr(item, field) for item in items]
    return [
        item if names.count(name) == 1 else replace(item, **{field: f"{name} ({place})"})
        for place, (item, name) in enumerate(zip(items, names, strict=True), start=1)
    ]


@singledispatch
def page_items(what: Any) -> Iterable[PageItem]:
    """The cams, tables of designs or machine that a page shows for a scene, result or path."""
    scene = getattr(what, "scene", None)
    if isinstance(what, Result) and isinstance(scene, Scene):
        return [ShownCam(scene.name, scene, result=what)]
    if getattr(what, "attrs", None) is None:
        raise BadInput([Mistake("camopt", "what", type(what).__name__, "a result of camopt, a scene, or a path")])
    if getattr(what, "ndim", 2) == 1:  # a row of a table
        return _scene_items(scene_of(what))
    return [thinned_result_rows("table", what)]


@page_items.register(Machine)
@page_items.register(MachineEvaluation)
def _machine_items(what: Machine | MachineEvaluation) -> Iterable[MachineEvaluation]:
    return [evaluate_machine(what) if isinstance(what, Machine) else what]


@page_items.register
def _scene_items(what: Scene) -> Iterable[ShownCam]:
    return [ShownCam(what.name, what)]


@page_items.register(Evaluation)
@page_items.register(Design)
def _design_items(what: Evaluation | Design) -> Iterable[ShownCam]:
    return [ShownCam(what.scene.name, what.scene)]


@page_items.register
def _optimum_items(what: Optimum) -> Iterable[ShownCam]:
    if not what.by_law:
        raise BadInput([Mistake("camopt", "what", what, "an optimum with a design; none was feasible")])
    return _smallest_cams_for_page(
        [ShownCam(law or what.scene.name, design.scene) for law, design in what.by_law.items()]
    )


def _smallest_cams_for_page(cams: list[ShownCam]) -> list[ShownCam]:
    """The smallest cams, at most ``MOST_PAGE_CAMS``, with a sentence on the others."""
    if len(cams) <= MOST_PAGE_CAMS:
        return cams
    kept = sorted(cams, key=lambda cam: cam.scene.cam.base_radius or cam.scene.cam.mean_radius or 0.0)[
        :MOST_PAGE_CAMS
    ]
    summary = f"The {MOST_PAGE_CAMS} smallest of {len(cams)} cams; the others are larger."
    return [replace(kept[0], summary=summary), *kept[1:]]


@page_items.register
def _synthesis_items(what: Synthesis) -> Iterable[ShownCam]:
    known = build_known_law_cams(what.asked)
    before = [ShownCam(f"known law: {known.best}", known.rows[known.best].scene)] if known.best else []
    return [*before, ShownCam("new laws", what.scene, bound_in_words(what))]


@page_items.register
def _sweep_items(what: Sweep) -> Iterable[ShownCam | ResultRows]:
    name = escape_unprintable(what.files[0].parent.name if what.files else what.scene.name)
    front, designs = what.to_pandas(), DESIGNS_TABLE in what.kept_tables
    return _table_items(name, what.to_pandas(DESIGNS_TABLE), front) if designs else _table_items(name, front)


@page_items.register(str)
@page_items.register(os.PathLike)
def _path_items(what: str | os.PathLike[str]) -> Iterable[PageItem]:
    path = checked_path(what, "what")
    if is_machine(str(path)):
        return [evaluate_machine(str(path))]
    if path.is_dir():
        return _folder_items(path)
    if path.suffix == ".parquet":
        return _table_items(escape_unprintable(path.name), read_data_frame(path))
    if path.suffix not in ("", ".toml") and path.exists():
        raise BadInput([Mistake("camopt", "what", str(what), RESULT_WORDS)])
    return _scene_items(scene_named(str(what), "what", RESULT_WORDS))


def _table_items(
    name: str, frame: "pd.DataFrame", front: "pd.DataFrame | None" = None
) -> Iterable[ShownCam | ResultRows]:
    """The rows of a table, with the Pareto front if there is one; the cam if it has one row."""
    if frame.empty:
        why = "a table with at least one design; no design was feasible, and others were not kept"
        raise BadInput([Mistake("camopt", "table", name, why)])
    if len(frame) == 1:
        return _scene_items(scene_of(frame, frame.index[0]))
    return [thinned_result_rows(name, frame, front)]


def _folder_items(folder: Path) -> Iterable[ShownCam | ResultRows]:
    """The result that a command wrote into a folder: the files in its manifest, if it has one."""
    manifest = read_manifest(folder)
    names = {path.name for path in result_paths(folder, "*", manifest)}
    if {PARETO, DESIGNS} <= names:
        frames = [read_data_frame(folder / name, manifest) for name in (DESIGNS, PARETO)]
        return _table_items(escape_unprintable(folder.name), *frames)
    for table in (PARETO, FRONTIER):
        if table in names:
            return _table_items(escape_unprintable(table), read_data_frame(folder / table, manifest))
    if SCENE_FILE in names:
        summary = _read_synthesis_summary(folder / SUMMARY_FILE)
        sentence = str(summary.get(SENTENCE_KEYS[shown_system()], ""))
        cams = [ShownCam("new laws", _read_result_scene(folder / SCENE_FILE, manifest), sentence)]
        if KNOWN_FILE in names:
            known = _read_result_scene(folder / KNOWN_FILE, manifest)
            cams.insert(0, ShownCam(f"known law: {summary.get('known_law')}", known))
        return cams
    if optima := result_paths(folder, OPTIMUM, manifest):
        return _smallest_cams_for_page(
            [ShownCam(path.stem.removeprefix("optimum-"), _read_result_scene(path, manifest)) for path in optima]
        )
    why = f"a folder that a command wrote: with {PARETO}, {FRONTIER}, {SCENE_FILE} or {OPTIMUM}"
    raise BadInput([Mistake("camopt", "what", str(folder), why)])


def _read_result_scene(path: Path, manifest: Manifest | None) -> Scene:
    """A scene of a result, checked against its manifest."""
    with open_checked_result_file(path, manifest):
        return Scene.from_toml(path)


def _read_synthesis_summary(path: Path) -> dict[str, Any]:
    """The summary that a synthesis wrote; empty if there is none."""
    if not path.exists():
        return {}
    try:
        summary = json.loads(decode_user_text(read_bytes(path)))
    except ValueError as trouble:
        raise BadInput([Mistake(path.name, "file", None, f"the JSON that synthesise wrote ({trouble})")]) from None
    return summary if isinstance(summary, dict) else {}
