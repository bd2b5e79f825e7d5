"""``export``: writes a cam to a file; the ending decides the kind of file."""

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module
from inspect import signature
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.files import check_writable, checked_suffix, expand_user_path
from camopt.model.effects import EvaluationBlock, available_quantities
from camopt.model.effects.rib import RIB_THICKNESS
from camopt.model.mechanisms.elements import WHICH_DISC
from camopt.scene.arguments import SceneSource, allow_positional_options, scene_from
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.unusual_values import thin_wall_notes
from camopt.show.exporting.file_types import FILE_TYPES
from camopt.show.exporting.workpiece import Export, Workpiece
from camopt.solve.contour.curve import SECOND_DISC, disc_curves
from camopt.solve.tables.cells import with_unit
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.evaluation import evaluate

GAP_MM = 1e-9  # mm; a smaller gap is none
LARGEST_TOLERANCE_SHARE = 0.25  # share of the profile tolerance that curves in a file may take without a note


@allow_positional_options
def export(scene: SceneSource, path: str | os.PathLike[str], *, disc: int | None = None, **settings: Any) -> Export:
    """Write the cam of a scene to a file; the ending decides the kind of file.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with all sizes.
    path : str or os.PathLike
        The file; the table of endings and their settings is in docs/how-to/write-files.md.
    disc : int, optional
        1 or 2: write only this disc of a conjugate pair; by default both. A program for a machine needs it.
    **settings : float, int or str
        Settings of the kind of file, such as ``chord=0.001`` (mm) and ``curves="arcs"``, ``"spline"`` or
        ``"polyline"``.

    Returns
    -------
    Export
        The curves in the file, each with a proven bound of its deviation from the true curve [mm].

    Raises
    ------
    BadInput
        For an unknown ending, a setting that the kind of file does not have, or a library that is not installed.
        For a cam that cannot be made: it is undercut, its profile crosses itself or has a gap at a jump of the
        velocity, or its rollers leave no rib between them.
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
    parameters = [name for name in signature(write).parameters if name not in ("work", "path")]
    names = ", ".join(name.replace("_", " ") for name in parameters)
    why = f"has no meaning in a {suffix} file" + (f"; allowed: {names}" if names else "")
    mistakes = [Mistake("camopt", n, settings[n], why, bare=True) for n in settings if n not in parameters]
    mistakes += _disc_mistakes(scene, suffix, disc)
    if mistakes:
        raise BadInput(mistakes)
    place = expand_user_path(path)
    check_writable(place)
    problem = resolve_design(scene)
    mechanism = problem.setup.mechanism
    if mechanism.has_rib and not mechanism.body.developed and suffix == ".p":
        why = f"camopt cannot write a {suffix} file of a rib on a disc yet"
        raise BadInput([Mistake(problem.file, "drive.kind", None, why, bare=True)])
    if FILE_TYPES[suffix].of_cam:
        check_makable(problem)
    work = Workpiece(scene, problem, disc)
    written: Export = write(work, place, **settings)
    tolerance = work.part.profile_tolerance if "chord" in parameters else None
    notes = _file_warnings(work, written, tolerance, of_plane=FILE_TYPES[suffix].of_plane)
    return replace(written, notes=(*written.notes, *notes))


def _file_warnings(work: Workpiece, written: Export, tolerance: float | None, *, of_plane: bool) -> Iterator[str]:
    """Warnings about a file: large deviations of curves, a mirrored development, thin walls, broken limits."""
    deviation = max((each.deviation_mm for each in written.curves.values()), default=0.0)
    if tolerance is not None and deviation > LARGEST_TOLERANCE_SHARE * tolerance:
        limit = f"a quarter of part.profile_tolerance ({with_unit(tolerance, 'mm')})"
        remedy = "use a smaller chord or step, or more decimals"
        yield f"curves in the file deviate by up to {with_unit(deviation, 'mm')}, more than {limit}: {remedy}"
    if of_plane and work.problem.setup.mechanism.body.developed and work.problem.design.sense > 0.0:
        yield "the development is seen from inside, as the cam turns ccw: mirror it to wrap it round the cylinder"
    yield from thin_wall_notes(work.scene)
    row = evaluate(work.scene)
    if not row["feasible"]:
        broken = f"breaks limits of the scene: {row['violated']}"
        yield f"the cam {broken if row['violated'] else 'is not proved to meet the limits of the scene'}"


def file_writer(suffix: str) -> Callable[..., Export]:
    """The function that writes files with an ending. Raises BadInput if its optional library is missing."""
    ending = FILE_TYPES[suffix]
    try:
        module = import_module(f"camopt.show.exporting.{ending.module}")
    except ModuleNotFoundError as missing:
        if not ending.extra:
            raise
        why = f'needs an optional library: pip install "camopt[{ending.extra}]" ({missing.name} is missing)'
        raise BadInput([Mistake("camopt", "file", f"…{suffix}", why, bare=True)]) from None
    write: Callable[..., Export] = module.write
    return write


def _disc_mistakes(scene: Scene, suffix: str, disc: int | None) -> Iterator[Mistake]:
    """A mistake if the file cannot have this disc, or, without ``disc``, both discs of a pair."""
    ending, of_two = FILE_TYPES[suffix], bool(scene.mechanism.second_contact_size_keys)
    if disc is None and of_two and not ending.of_pair:
        why = f"missing: a {suffix} file has one disc of a conjugate pair; give 1 or 2"
        yield Mistake("camopt", WHICH_DISC, None, why, bare=True)
    elif disc is not None and not (ending.of_disc and of_two):
        why = f"in a {suffix} file" if of_two else "for a cam of one disc"
        yield Mistake("camopt", WHICH_DISC, disc, f"has no meaning {why}", bare=True)
    elif disc not in (None, 1, SECOND_DISC):
        yield Mistake("camopt", WHICH_DISC, disc, f"1 or {SECOND_DISC}")


def check_makable(problem: Problem) -> None:
    """Raise BadInput for a cam that cannot be made: undercut, crossing itself, without a rib, or with a gap."""
    names = CAM_FAULTS.keys() & {*available_quantities(problem.setup)} | {"undercut"}
    rows = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), names)
    faults = [why for name, (bad, why) in CAM_FAULTS.items() if name in names and bad(rows.column(name)[0])]
    for name, curve in disc_curves(problem).items():
        after = [*curve.spans[1:], *(curve.spans[:1] if curve.is_closed else ())]
        for one, other in zip(curve.spans, after, strict=False):
            ends = curve.points(one, np.array([one.end])), curve.points(other, np.array([other.start]))
            if np.abs(ends[1] - ends[0])[0] > GAP_MM:
                faults.append(f"the velocity jumps at {np.degrees(one.end):.6g}°, and the {name} has a gap there")
    if faults:
        raise BadInput([Mistake(problem.file, "cam", None, f"cannot be made: {faults[0]}", bare=True)])


CAM_FAULTS: dict[str, tuple[Callable[[Any], Any], str]] = {
    "undercut": (bool, "it is undercut (the follower would cut away a part of the profile)"),
    "self_crossing": (bool, "its profile crosses itself"),
    RIB_THICKNESS: (lambda thickness: thickness <= 0.0, "its rollers leave no rib between them"),
}
"""Faults by quantity of a cam: a test of its value, and the sentence on the fault."""
