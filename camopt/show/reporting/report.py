"""A report: any result as one page, chosen by what the result is."""

import json
import os
from collections.abc import Iterable
from dataclasses import replace
from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.core.mistakes import BadInput, Mistake, printable
from camopt.core.quantities.unit_systems import shown_system
from camopt.core.storage.files import (
    check_writable,
    checked_path,
    checked_suffix,
    path_of,
    read_bytes,
    text_of,
    write_text,
)
from camopt.core.storage.manifest import Manifest, manifest_of, result_paths, whole_result_file
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import RESULT_WORDS, Scene, scene_named
from camopt.show.reporting.cams import ShownCam, cams_page
from camopt.show.reporting.results import ResultRows, result_rows, results_page
from camopt.solve.front.result import DESIGNS_TABLE, Sweep
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.synthesis.files import FRONTIER, KNOWN_FILE, SCENE_FILE, SENTENCE_KEYS, SUMMARY_FILE
from camopt.solve.synthesis.known_law_cams import known_laws_of
from camopt.solve.synthesis.result_sentences import bound_in_words
from camopt.solve.synthesis.synthesis_result import Synthesis
from camopt.solve.tables.designs import DESIGNS, OPTIMUM, PARETO, Design, joined_laws, scene_of
from camopt.solve.tables.result import Result
from camopt.solve.tables.table import frame_of
from camopt.solve.verdicts.evaluation import Evaluation

if TYPE_CHECKING:
    import pandas as pd

MOST_PAGE_CAMS = 4  # side by side


def report(what: Any, path: str | os.PathLike[str]) -> Path:
    """Write a result as one HTML file.

    Parameters
    ----------
    what : Scene, Design, Result, str, os.PathLike or list
        A scene, a design, any result of a scene, the folder or table (Parquet) that a command wrote, or a list of
        such: up to four cams side by side, or several tables of designs. Of a result other than a sweep, an optimum
        or a synthesis the page shows the cam, and the result in a chapter of its own.
    path : str or os.PathLike
        The file, which ends in .html.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    BadInput
        For anything else, a scene that lacks a size, or cams beside tables.
    OSError
        If a file cannot be read or written.

    Examples
    --------
    >>> page = camopt.report(camopt.find_scene("two-pauses"), "cam.html")
    """
    checked_suffix(path, "path", (".html",))
    place = path_of(path)
    check_writable(place)
    found = [each for one in (what if isinstance(what, (list, tuple)) else [what]) for each in page_items(one)]
    write_text(place, _page_html(found))
    return place


def _page_html(found: list[ShownCam | ResultRows]) -> str:
    cams, results = [x for x in found if isinstance(x, ShownCam)], [x for x in found if isinstance(x, ResultRows)]
    if bool(cams) == bool(results):
        raise BadInput(
            [Mistake("camopt", "what", None, "cams, or tables of designs: a page shows one or the other")]
        )
    if len(cams) > MOST_PAGE_CAMS:
        raise BadInput([Mistake("camopt", "what", len(cams), f"at most {MOST_PAGE_CAMS} cams side by side")])
    if results:
        return results_page(_with_distinct_names(results))
    first, *others = dict.fromkeys(cam.scene.name for cam in cams)
    title = first + (f" beside {others[0]}" if len(others) == 1 else f" and {len(others)} others" if others else "")
    return cams_page(_with_distinct_names(cams), title, [cam.summary for cam in cams if cam.summary])


def _with_distinct_names(found: list[Any]) -> list[Any]:
    """Those of one name with a number; cams with their laws before, if they have others."""
    cams = isinstance(found[0], ShownCam)
    field = "label" if cams else "name"
    if cams and len({each.label for each in found}) < len(found):
        laws = [_scene_laws(each.scene) for each in found]
        if len({*laws}) > 1:
            found = [replace(each, label=f"{each.label}, {law}") for each, law in zip(found, laws, strict=True)]
    names = [getattr(each, field) for each in found]
    return [
        each if names.count(name) == 1 else replace(each, **{field: f"{name} ({place})"})
        for place, (each, name) in enumerate(zip(found, names, strict=True), start=1)
    ]


def _scene_laws(scene: Scene) -> str:
    """The laws of its rises and returns; of moves alone, that."""
    programme = resolve_design(scene).programme
    return joined_laws(programme.law_names(RISE), programme.law_names(RETURN)) or "moves"


@singledispatch
def page_items(what: Any) -> Iterable[ShownCam | ResultRows]:
    """What a page shows of a result."""
    scene = getattr(what, "scene", None)
    if isinstance(what, Result) and isinstance(scene, Scene):
        return [ShownCam(scene.name, scene, result=what)]
    frame = getattr(what, "attrs", None)
    if frame is None:
        raise BadInput([Mistake("camopt", "what", type(what).__name__, "a result of camopt, a scene, or a path")])
    if getattr(what, "ndim", 2) == 1:  # a row of a table
        return _scene_items(scene_of(what))
    return [result_rows("table", what)]


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
    return _smallest_shown_cams(
        [ShownCam(law or what.scene.name, design.scene) for law, design in what.by_law.items()]
    )


def _smallest_shown_cams(cams: list[ShownCam]) -> list[ShownCam]:
    """The smallest of several cams, as many as a page has room for, and a word on the others."""
    if len(cams) <= MOST_PAGE_CAMS:
        return cams
    kept = sorted(cams, key=lambda cam: cam.scene.cam.base_radius or cam.scene.cam.mean_radius or 0.0)[
        :MOST_PAGE_CAMS
    ]
    told = f"The {MOST_PAGE_CAMS} smallest of {len(cams)} cams; the others are larger."
    return [replace(kept[0], summary=told), *kept[1:]]


@page_items.register
def _synthesis_items(what: Synthesis) -> Iterable[ShownCam]:
    known = known_laws_of(what.asked)
    before = [ShownCam(f"known law: {known.best}", known.rows[known.best].scene)] if known.best else []
    return [*before, ShownCam("new laws", what.scene, bound_in_words(what))]


@page_items.register
def _sweep_items(what: Sweep) -> Iterable[ShownCam | ResultRows]:
    name = printable(what.files[0].parent.name if what.files else what.scene.name)
    front, designs = what.to_pandas(), DESIGNS_TABLE in what.kept_tables
    return _table_items(name, what.to_pandas(DESIGNS_TABLE), front) if designs else _table_items(name, front)


@page_items.register(str)
@page_items.register(os.PathLike)
def _path_items(what: str | os.PathLike[str]) -> Iterable[ShownCam | ResultRows]:
    path = checked_path(what, "what")
    if path.is_dir():
        return _folder_items(path)
    if path.suffix == ".parquet":
        return _table_items(printable(path.name), frame_of(path))
    if path.suffix not in ("", ".toml") and path.exists():
        raise BadInput([Mistake("camopt", "what", str(what), RESULT_WORDS)])
    return _scene_items(scene_named(str(what), "what", RESULT_WORDS))


def _table_items(
    name: str, frame: "pd.DataFrame", front: "pd.DataFrame | None" = None
) -> Iterable[ShownCam | ResultRows]:
    """Rows of designs, beside their Pareto front if there is one; of one design its cam."""
    if frame.empty:
        why = "a table with a design in it; no design was feasible, and others were not kept"
        raise BadInput([Mistake("camopt", "table", name, why)])
    if len(frame) == 1:
        return _scene_items(scene_of(frame, frame.index[0]))
    return [result_rows(name, frame, front)]


def _folder_items(folder: Path) -> Iterable[ShownCam | ResultRows]:
    """The result that a command left in a folder: files that its manifest names, if there is one."""
    manifest = manifest_of(folder)
    there = {path.name for path in result_paths(folder, "*", manifest)}
    if {PARETO, DESIGNS} <= there:
        frames = [frame_of(folder / name, manifest) for name in (DESIGNS, PARETO)]
        return _table_items(printable(folder.name), *frames)
    for table in (PARETO, FRONTIER):
        if table in there:
            return _table_items(printable(table), frame_of(folder / table, manifest))
    if SCENE_FILE in there:
        summary = _synthesis_summary(folder / SUMMARY_FILE)
        told = str(summary.get(SENTENCE_KEYS[shown_system()], ""))
        cams = [ShownCam("new laws", _result_scene(folder / SCENE_FILE, manifest), told)]
        if KNOWN_FILE in there:
            known = ShownCam(f"known law: {summary.get('known_law')}", _result_scene(folder / KNOWN_FILE, manifest))
            cams.insert(0, known)
        return cams
    if optima := result_paths(folder, OPTIMUM, manifest):
        return _smallest_shown_cams(
            [ShownCam(path.stem.removeprefix("optimum-"), _result_scene(path, manifest)) for path in optima]
        )
    why = f"a folder that a command wrote: with {PARETO}, {FRONTIER}, {SCENE_FILE} or {OPTIMUM}"
    raise BadInput([Mistake("camopt", "what", str(folder), why)])


def _result_scene(path: Path, manifest: Manifest | None) -> Scene:
    """A scene of a result, as its manifest names it."""
    with whole_result_file(path, manifest):
        return Scene.from_toml(path)


def _synthesis_summary(path: Path) -> dict[str, Any]:
    """What a synthesis says of itself; nothing if it does not."""
    if not path.exists():
        return {}
    try:
        found = json.loads(text_of(read_bytes(path)))
    except ValueError as trouble:
        raise BadInput([Mistake(path.name, "file", None, f"the JSON that synthesise wrote ({trouble})")]) from None
    return found if isinstance(found, dict) else {}
