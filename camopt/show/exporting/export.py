"""One command for all files: the ending says what is written."""

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from importlib import import_module
from inspect import signature
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.files import check_writable, checked_suffix, path_of
from camopt.model.effects import EvaluationBlock, available_quantities
from camopt.model.effects.rib import RIB_THICKNESS
from camopt.model.mechanisms.elements import WHICH_DISC
from camopt.scene.arguments import SceneSource, options_by_keyword, scene_from
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.unusual_values import thin_walls
from camopt.show.exporting.file_types import FILE_TYPES
from camopt.show.exporting.workpiece import Export, Workpiece
from camopt.solve.contour.curve import SECOND_DISC, disc_curves
from camopt.solve.tables.cells import with_unit
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.evaluation import evaluate

GAP_MM = 1e-9  # mm
LARGEST_TOLERANCE_SHARE = 0.25  # of the tolerance of the profile: no curve in a file should take more of it


@options_by_keyword
def export(scene: SceneSource, path: str | os.PathLike[str], *, disc: int | None = None, **settings: Any) -> Export:
    """Write the cam of a scene to a file for a machine, a person or another program, as its ending says.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A validated scene whose sizes are given.
    path : str or os.PathLike
        The file; the table of endings and their settings is in docs/how-to/write-files.md.
    disc : int, optional
        1 or 2: the disc of a conjugate pair that is in the file alone. Without it both are; a program for a machine
        is of one.
    **settings : float, int or str
        Of the kind of file, such as ``chord=0.001`` (mm) and ``curves="arcs"``, ``"spline"`` or ``"polyline"``.

    Returns
    -------
    Export
        The curves in the file, each with its proved deviation from the true curve: no point of one is further from
        the other, in mm.

    Raises
    ------
    BadInput
        For another ending, a setting that it has not, a cam that cannot be made (undercut, crossing itself, without
        a rib between its rollers, with a profile that a jump of the velocity tears), or a library that is not
        installed.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> found = camopt.export(camopt.find_scene("roller-1000rpm"), "cam.dxf")
    >>> found.curves["profile"].deviation_mm <= 0.001
    True
    """
    scene = scene_from(scene)
    suffix = checked_suffix(path, "file", tuple(FILE_TYPES))
    write = file_writer(suffix)
    mistakes = [*_unknown_settings(suffix, write, settings), *_disc_mistakes(scene, suffix, disc)]
    if mistakes:
        raise BadInput(mistakes)
    place = path_of(path)
    check_writable(place)
    problem = resolve_design(scene)
    mechanism = problem.setup.mechanism
    if mechanism.has_rib and not mechanism.body.developed and suffix == ".p":
        why = f"a {suffix} file of a rib on a disc is not written yet"
        raise BadInput([Mistake(problem.file, "drive.kind", None, why, bare=True)])
    if FILE_TYPES[suffix].of_cam:
        check_makable(problem)
    work = Workpiece(scene, problem, disc)
    found: Export = write(work, place, **settings)
    tolerance = work.part.profile_tolerance if "chord" in signature(write).parameters else None
    notes = _file_notes(work, found, tolerance, of_plane=FILE_TYPES[suffix].of_plane)
    return replace(found, notes=(*found.notes, *notes))


def _file_notes(work: Workpiece, found: Export, tolerance: float | None, *, of_plane: bool) -> Iterator[str]:
    """What to know of a file: curves that take much of a tolerance, a mirrored development, thin walls, limits."""
    furthest = max((each.deviation_mm for each in found.curves.values()), default=0.0)
    if tolerance is not None and furthest > LARGEST_TOLERANCE_SHARE * tolerance:
        asked = f"a quarter of part.profile_tolerance ({with_unit(tolerance, 'mm')})"
        closer = "a smaller chord or step, or more decimals, brings them closer"
        yield f"curves in the file are within {with_unit(furthest, 'mm')}, more than {asked}: {closer}"
    if of_plane and work.problem.setup.mechanism.body.developed and work.problem.design.sense > 0.0:
        yield "the development is as seen from inside, for the cam turns ccw: mirror it to wrap it round a cylinder"
    yield from thin_walls(work.scene)
    row = evaluate(work.scene)
    if not row["feasible"]:
        broken = f"breaks limits of the scene: {row['violated']}"
        yield f"the cam {broken if row['violated'] else 'is not proved to meet the limits of the scene'}"


def file_writer(suffix: str) -> Callable[..., Export]:
    """The function that writes files of an ending; BadInput names the extra if its library is missing."""
    ending = FILE_TYPES[suffix]
    try:
        module = import_module(f"camopt.show.exporting.{ending.module}")
    except ModuleNotFoundError as missing:
        if not ending.extra:
            raise
        why = f'a kind of file that this installation can write; pip install "camopt[{ending.extra}]" adds it'
        raise BadInput([Mistake("camopt", "file", f"…{suffix}", f"{why} ({missing.name} is missing)")]) from None
    written: Callable[..., Export] = module.write
    return written


def _unknown_settings(suffix: str, write: Callable[..., Export], settings: Mapping[str, Any]) -> list[Mistake]:
    """A mistake for each setting that files with an ending do not have."""
    known = [name for name in signature(write).parameters if name not in ("work", "path")]
    taken = ", ".join(name.replace("_", " ") for name in known)
    why = f"has no meaning in a {suffix} file" + (f"; that takes: {taken}" if known else "")
    return [Mistake("camopt", name, settings[name], why, bare=True) for name in settings if name not in known]


def _disc_mistakes(scene: Scene, suffix: str, disc: int | None) -> Iterator[Mistake]:
    """A mistake where a file cannot be of this disc of a cam, or, without one, of both discs of a pair."""
    ending, of_two = FILE_TYPES[suffix], bool(scene.mechanism.second_keys)
    if disc is None and of_two and not ending.of_pair:
        why = f"a {suffix} file is of one disc, and a conjugate pair has two: give 1 or 2"
        yield Mistake("camopt", WHICH_DISC, None, why, bare=True)
    elif disc is not None and not (ending.of_disc and of_two):
        why = f"in a {suffix} file" if of_two else "for a cam of one disc"
        yield Mistake("camopt", WHICH_DISC, disc, f"has no meaning {why}", bare=True)
    elif disc not in (None, 1, SECOND_DISC):
        yield Mistake("camopt", WHICH_DISC, disc, f"1 or {SECOND_DISC}")


def check_makable(problem: Problem) -> None:
    """BadInput for a cam that no machine can make: undercut, crossing itself, without a rib, or torn."""
    asked = CAM_FAULTS.keys() & {*available_quantities(problem.setup)} | {"undercut"}
    found = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), asked)
    faults = [why for name, (bad, why) in CAM_FAULTS.items() if name in asked and bad(found.column(name)[0])]
    faults += [
        f"torn: the velocity jumps at {degrees:.6g}°, and the {name} with it"
        for name, degrees in _curve_gaps(problem)
    ]
    if faults:
        raise BadInput([Mistake(problem.file, "cam", None, f"cannot be made: {faults[0]}", bare=True)])


CAM_FAULTS: dict[str, tuple[Callable[[Any], Any], str]] = {
    "undercut": (bool, "it is undercut (the follower would cut away a part of the profile)"),
    "self_crossing": (bool, "its profile crosses itself"),
    RIB_THICKNESS: (lambda thickness: thickness <= 0.0, "its rollers leave no rib between them"),
}
"""Quantities of a cam: which values of them no machine can make, and why."""


def _curve_gaps(problem: Problem) -> Iterator[tuple[str, float]]:
    """The curves that have a gap, each with its cam angle, deg."""
    for name, curve in disc_curves(problem).items():
        after = [*curve.spans[1:], *(curve.spans[:1] if curve.is_closed else ())]
        for one, other in zip(curve.spans, after, strict=False):
            ends = curve.points(one, np.array([one.end])), curve.points(other, np.array([other.start]))
            if np.abs(ends[1] - ends[0])[0] > GAP_MM:
                yield name, np.degrees(one.end)
