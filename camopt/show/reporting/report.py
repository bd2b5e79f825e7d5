"""A report: any result as one page, chosen by what the result is."""

import json
import os
from collections.abc import Iterable
from dataclasses import replace
from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.core.mistakes import BadInput, Mistake, printable
from camopt.core.quantities.unit_systems import system_shown
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
from camopt.scene.scene import RESULTS, Scene, scene_named
from camopt.show.reporting.cams import ShownCam, cams_page
from camopt.show.reporting.results import ResultRows, of_frame, results_page
from camopt.solve.front.result import KEPT, Sweep
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.synthesis.compare import known_laws_of
from camopt.solve.synthesis.files import FRONTIER, KNOWN_FILE, SCENE_FILE, SUMMARY_FILE, TOLD
from camopt.solve.synthesis.synthesised import Synthesis
from camopt.solve.synthesis.told import bound_in_words
from camopt.solve.tables.designs import DESIGNS, OPTIMUM, PARETO, Design, joined_laws, scene_of
from camopt.solve.tables.result import Result
from camopt.solve.tables.table import frame_of
from camopt.solve.verdicts.evaluation import Evaluation

if TYPE_CHECKING:
    import pandas as pd

MOST_CAMS = 4  # side by side


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
    found = [each for one in (what if isinstance(what, (list, tuple)) else [what]) for each in shown_of(one)]
    write_text(place, _page(found))
    return place


def _page(found: list[ShownCam | ResultRows]) -> str:
    cams, results = [x for x in found if isinstance(x, ShownCam)], [x for x in found if isinstance(x, ResultRows)]
    if bool(cams) == bool(results):
        raise BadInput(
            [Mistake("camopt", "what", None, "cams, or tables of designs: a page shows one or the other")]
        )
    if len(cams) > MOST_CAMS:
        raise BadInput([Mistake("camopt", "what", len(cams), f"at most {MOST_CAMS} cams side by side")])
    if results:
        return results_page(_told_apart(results))
    first, *others = dict.fromkeys(cam.scene.name for cam in cams)
    title = first + (f" beside {others[0]}" if len(others) == 1 else f" and {len(others)} others" if others else "")
    return cams_page(_told_apart(cams), title, [cam.told for cam in cams if cam.told])


def _told_apart(found: list[Any]) -> list[Any]:
    """Those of one name with a number; cams with their laws before, if they have others."""
    cams = isinstance(found[0], ShownCam)
    field = "label" if cams else "name"
    if cams and len({each.label for each in found}) < len(found):
        laws = [_laws(each.scene) for each in found]
        if len({*laws}) > 1:
            found = [replace(each, label=f"{each.label}, {law}") for each, law in zip(found, laws, strict=True)]
    names = [getattr(each, field) for each in found]
    return [
        each if names.count(name) == 1 else replace(each, **{field: f"{name} ({place})"})
        for place, (each, name) in enumerate(zip(found, names, strict=True), start=1)
    ]


def _laws(scene: Scene) -> str:
    """The laws of its rises and returns; of moves alone, that."""
    programme = resolve_design(scene).programme
    return joined_laws(programme.law_names(RISE), programme.law_names(RETURN)) or "moves"


@singledispatch
def shown_of(what: Any) -> Iterable[ShownCam | ResultRows]:
    """What a page shows of a result."""
    scene = getattr(what, "scene", None)
    if isinstance(what, Result) and isinstance(scene, Scene):
        return [ShownCam(scene.name, scene, result=what)]
    frame = getattr(what, "attrs", None)
    if frame is None:
        raise BadInput([Mistake("camopt", "what", type(what).__name__, "a result of camopt, a scene, or a path")])
    if getattr(what, "ndim", 2) == 1:  # a row of a table
        return _of_a_scene(scene_of(what))
    return [of_frame("table", what)]


@shown_of.register
def _of_a_scene(what: Scene) -> Iterable[ShownCam]:
    return [ShownCam(what.name, what)]


@shown_of.register(Evaluation)
@shown_of.register(Design)
def _of_a_design(what: Evaluation | Design) -> Iterable[ShownCam]:
    return [ShownCam(what.scene.name, what.scene)]


@shown_of.register
def _of_an_optimum(what: Optimum) -> Iterable[ShownCam]:
    if not what.by_law:
        raise BadInput([Mistake("camopt", "what", what, "an optimum with a design; none was feasible")])
    return _smallest([ShownCam(law or what.scene.name, design.scene) for law, design in what.by_law.items()])


def _smallest(cams: list[ShownCam]) -> list[ShownCam]:
    """The smallest of several cams, as many as a page has room for, and a word on the others."""
    if len(cams) <= MOST_CAMS:
        return cams
    kept = sorted(cams, key=lambda cam: cam.scene.cam.base_radius or cam.scene.cam.mean_radius or 0.0)[:MOST_CAMS]
    told = f"The {MOST_CAMS} smallest of {len(cams)} cams; the others are larger."
    return [replace(kept[0], told=told), *kept[1:]]


@shown_of.register
def _of_new_laws(what: Synthesis) -> Iterable[ShownCam]:
    known = known_laws_of(what.asked)
    before = [ShownCam(f"known law: {known.best}", known.rows[known.best].scene)] if known.best else []
    return [*before, ShownCam("new laws", what.scene, bound_in_words(what))]


@shown_of.register
def _of_a_sweep(what: Sweep) -> Iterable[ShownCam | ResultRows]:
    name = printable(what.files[0].parent.name if what.files else what.scene.name)
    front, designs = what.to_pandas(), KEPT in what.kept_tables
    return _of_rows(name, what.to_pandas(KEPT), front) if designs else _of_rows(name, front)


@shown_of.register(str)
@shown_of.register(os.PathLike)
def _of_a_path(what: str | os.PathLike[str]) -> Iterable[ShownCam | ResultRows]:
    path = checked_path(what, "what")
    if path.is_dir():
        return _of_a_folder(path)
    if path.suffix == ".parquet":
        return _of_rows(printable(path.name), frame_of(path))
    if path.suffix not in ("", ".toml") and path.exists():
        raise BadInput([Mistake("camopt", "what", str(what), RESULTS)])
    return _of_a_scene(scene_named(str(what), "what", RESULTS))


def _of_rows(
    name: str, frame: "pd.DataFrame", front: "pd.DataFrame | None" = None
) -> Iterable[ShownCam | ResultRows]:
    """Rows of designs, beside their Pareto front if there is one; of one design its cam."""
    if frame.empty:
        why = "a table with a design in it; no design was feasible, and others were not kept"
        raise BadInput([Mistake("camopt", "table", name, why)])
    if len(frame) == 1:
        return _of_a_scene(scene_of(frame, frame.index[0]))
    return [of_frame(name, frame, front)]


def _of_a_folder(folder: Path) -> Iterable[ShownCam | ResultRows]:
    """The result that a command left in a folder: files that its manifest names, if there is one."""
    manifest = manifest_of(folder)
    there = {path.name for path in result_paths(folder, "*", manifest)}
    if {PARETO, DESIGNS} <= there:
        frames = [frame_of(folder / name, manifest) for name in (DESIGNS, PARETO)]
        return _of_rows(printable(folder.name), *frames)
    for table in (PARETO, FRONTIER):
        if table in there:
            return _of_rows(printable(table), frame_of(folder / table, manifest))
    if SCENE_FILE in there:
        summary = _summary(folder / SUMMARY_FILE)
        told = str(summary.get(TOLD[system_shown()], ""))
        cams = [ShownCam("new laws", _scene_in(folder / SCENE_FILE, manifest), told)]
        if KNOWN_FILE in there:
            known = ShownCam(f"known law: {summary.get('known_law')}", _scene_in(folder / KNOWN_FILE, manifest))
            cams.insert(0, known)
        return cams
    if optima := result_paths(folder, OPTIMUM, manifest):
        return _smallest(
            [ShownCam(path.stem.removeprefix("optimum-"), _scene_in(path, manifest)) for path in optima]
        )
    why = f"a folder that a command wrote: with {PARETO}, {FRONTIER}, {SCENE_FILE} or {OPTIMUM}"
    raise BadInput([Mistake("camopt", "what", str(folder), why)])


def _scene_in(path: Path, manifest: Manifest | None) -> Scene:
    """A scene of a result, as its manifest names it."""
    with whole_result_file(path, manifest):
        return Scene.from_toml(path)


def _summary(path: Path) -> dict[str, Any]:
    """What a synthesis says of itself; nothing if it does not."""
    if not path.exists():
        return {}
    try:
        found = json.loads(text_of(read_bytes(path)))
    except ValueError as trouble:
        raise BadInput([Mistake(path.name, "file", None, f"the JSON that synthesise wrote ({trouble})")]) from None
    return found if isinstance(found, dict) else {}
