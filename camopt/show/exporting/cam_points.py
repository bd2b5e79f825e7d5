"""Points of a cam for a machine or another program: displacement, pitch curve, profile, cutter path, loads."""

import os
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import ArrayLike
from pyarrow import csv

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import ComplexArray, FloatArray, IntArray
from camopt.core.quantities import (
    AT_FOLLOWER,
    DERIVATIVE_UNITS,
    QUANTITIES,
    displacement_unit,
    motion_peak_name,
)
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.core.storage.files import atomically_written_file, checked_suffix
from camopt.core.storage.tables import write_table
from camopt.core.storage.version import VERSION
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.contacts import CONTACT_NAMES
from camopt.model.effects.curvature import CUTTER_RADIUS
from camopt.model.effects.force import CONTACT_FORCES
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.mechanisms.elements import WHICH_DISC
from camopt.scene.arguments import SceneSource, allow_positional_options, scene_from
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.problem.rows import DesignRows
from camopt.scene.scene import Scene
from camopt.show.drawing.loads import load_panels
from camopt.show.drawing.picture import Picture
from camopt.show.exporting.spacing import angles_in_steps, angles_within_chord
from camopt.show.exporting.workpiece import CurveInFile, Export, Workpiece
from camopt.solve.contour.curve import CamCurve, cam_discs, disc_curves
from camopt.solve.contour.deviation import deviation_upper_bound
from camopt.solve.contour.path_fitting import CHORD_AIM, DEFAULT_CHORD, check_path_options, polyline_through_angles
from camopt.solve.tables.cells import name_in_shown_unit
from camopt.solve.tables.result import Columns
from camopt.solve.tables.table import to_arrow_table
from camopt.solve.tables.workbook import write_workbook
from camopt.solve.verdicts.effect_runs import run_effects

PIECE_END_ANGLE = 1e-12  # rad: a closer angle counts as the end of a piece
PIECE_OFFSET = 1e-13  # rad: distance of samples from an angle between two pieces
LEAST_JUMP_SHARE = 1e-9  # share of the largest load: a smaller difference is no jump

COLUMN_NOTES = {
    "cam_angle_deg": ("deg", "Cam angle."),
    "displacement_mm": ("mm", "Displacement of the follower."),
    "displacement_deg": ("deg", "Swing of the follower."),
    "tool_displacement_mm": ("mm", "Displacement of the tool that the follower drives."),
    "tool_displacement_deg": ("deg", "Swing of the tool that the follower drives."),
    "pitch": ("mm", "Pitch curve: the trace point."),
    "profile": ("mm", "Profile."),
    "profile_left": ("mm", "Flank of the groove to the left, seen along the motion of the roller in it."),
    "profile_right": ("mm", "Flank of the groove to the right."),
    "profile_inner": ("mm", "Inner wall of a groove in the face of a disc."),
    "profile_outer": ("mm", "Its outer wall."),
    "cutter": ("mm", "Path of the cutter's centre."),
    "cutter_left": ("mm", "Path of the cutter's centre for the left flank."),
    "cutter_right": ("mm", "Path of the cutter's centre for the right flank."),
    "cutter_inner": ("mm", "Path of the cutter's centre for the inner wall."),
    "cutter_outer": ("mm", "Path of the cutter's centre for the outer wall."),
    "second_pitch": ("mm", "Pitch curve of the second disc of a pair, or of the second roller of a rib."),
    "second_profile": ("mm", "Profile of the second disc of a pair, or the second flank of a rib."),
    "second_cutter": ("mm", "Path of the cutter's centre for the second profile."),
}

FORM_COLUMNS = {
    "x_mm": ("mm", ""),
    "y_mm": ("mm", ""),
    "normal_x": ("", "Unit normal, out of the steel."),
    "normal_y": ("", "Unit normal, out of the steel."),
    "curvature_per_mm": ("1/mm", "Curvature, above 0 where the steel is convex; at a jump the value after it."),
    "radius_mm": ("mm", "Distance from the axis (polar radius, not the radius of curvature)."),
    "angle_deg": ("deg", "Direction from the axis, anticlockwise from the x axis."),
}
"""Columns of a curve by the end of their name: unit, and the end of their description."""


@allow_positional_options
def cam_points(
    scene: SceneSource,
    angles: ArrayLike | None = None,
    *,
    cutter_radius: float | None = None,
    step: float | None = None,
    chord: float | None = None,
    disc: int | None = None,
) -> Columns:
    """Points of a cam: columns by name, each an array (n,) with a value for each cam angle.

    Motion: ``cam_angle_deg``; ``displacement_mm`` of the follower (``displacement_deg`` if it oscillates); with a
    train ``tool_displacement_mm`` (``tool_displacement_deg``). Velocity, acceleration and jerk are
    ``velocity_m_s``, ``acceleration_m_s2``, ``jerk_m_s3``, or by the cam angle without a speed
    (``velocity_mm_per_rad``). Their names are those of ``evaluate``: with a train they are of the tool, and
    ``velocity_follower_m_s`` is of the follower. At a jump they have the value after it.

    Curves: x and y of each curve [mm], such as ``profile_x_mm`` and ``profile_y_mm``. The curves are ``pitch`` (not
    for a flat face, which has no trace point), ``profile``, and ``cutter`` with a cutter radius. The groove of a
    cylindrical cam has ``profile_left`` and ``profile_right``, a groove in the face of a disc ``profile_inner`` and
    ``profile_outer``, and both have two cutter paths. A conjugate pair has both discs in one frame; the columns of
    the second disc are ``second_profile_x_mm`` and so on.

    Curves of disc cams also have polar coordinates: ``profile_radius_mm``, the distance from the axis, and
    ``profile_angle_deg`` from the x axis; ``pitch_radius_mm`` of the roller's centre. Each profile has the unit
    normal out of the steel (``profile_normal_x``, ``profile_normal_y``) and the curvature
    (``profile_curvature_per_mm``, positive where convex).

    Loads: all loads of the effects that the scene needs, such as ``contact_force_N``, ``torque_N_m`` and
    ``contact_stress_MPa``. If friction allows several values, the column has the largest. Where a load jumps, as
    friction does at the end of a stroke, the column has the side with the larger magnitude; for a film and the
    force of an elastic train, the smaller value. A load that is infinite somewhere has no column. Two contacts have
    a column each, such as ``first_contact_force_N`` and ``second_contact_force_N``, which share the preload.

    Frames: a disc cam is in its own frame, which is the ground frame at cam angle 0: cam centre at the origin,
    follower above it. A cylindrical cam is developed: x runs round it at the mean radius, like the cam angle, and y
    along its axis. Where the velocity of the follower jumps, the normal is the one after the jump.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A validated scene.
    angles : array_like, optional
        Cam angles from 0 to 360 [deg], in any order. Default, without a step or chord: 0, 1, … 360.
    cutter_radius : float, optional
        Radius of a cutter or grinding wheel [mm], at most the quantity ``cutter_radius_max_mm``: a larger one
        cannot reach the concave flanks.
    step : float, optional
        Even steps of the cam angle [deg].
    chord : float, optional
        Largest deviation of straight lines between points from the curves [mm].
    disc : int, optional
        1 or 2: give only this disc of a conjugate pair.

    Returns
    -------
    Columns
        A mapping of column names to numpy arrays; ``to_pandas`` gives a DataFrame.

    Raises
    ------
    BadInput
        For a cutter radius that is not above 0 or too large; for cam angles outside 0 to 360; for a step or chord
        that is not above 0; for more than one of angles, step and chord; for a disc that the cam does not have.

    Examples
    --------
    >>> points = camopt.cam_points(camopt.find_scene("roller-1000rpm"), [0, 90, 180])
    >>> points["displacement_mm"].round(3).tolist()
    [0.0, 43.75, 50.0]
    """
    scene = scene_from(scene)
    problem = resolve_design(scene)
    curves = disc_curves(problem, cutter_radius, disc)
    if not curves:
        raise BadInput([Mistake("camopt", WHICH_DISC, disc, "the number of a disc of the cam")])
    for each in cam_discs(problem):
        if disc in (None, each.number):
            check_cutter(each.problem, cutter_radius)
    degrees = _point_angles(problem, curves, angles, step, chord)
    radians = np.radians(degrees)
    displacement = problem.programme.motion_at(radians)[0]
    unit = displacement_unit(angular=problem.setup.angular)
    columns = {"cam_angle_deg": degrees}
    columns[f"displacement_{unit}"] = np.degrees(displacement) if unit == "deg" else displacement
    if problem.setup.train is not None:
        moved, turns = problem.programme.tool.motion_at(radians)[0], problem.setup.tool_turns
        columns[f"tool_displacement_{'deg' if turns else 'mm'}"] = np.degrees(moved) if turns else moved
    columns |= _tool_and_follower_derivatives(problem, radians)
    at = {name: curve.evaluate_by_span(radians, curve.points) for name, curve in curves.items()}
    for name, points in at.items():
        columns |= {f"{name}_x_mm": points.real.copy(), f"{name}_y_mm": points.imag.copy()}
        if curves[name].is_closed:
            polar = np.abs(points), np.degrees(np.angle(points)) % 360.0
            columns |= dict(zip((f"{name}_radius_mm", f"{name}_angle_deg"), polar, strict=True))
    for name in (name for name in curves if name.removeprefix("second_").startswith("profile")):
        curve = curves[name]
        # the steel is on the other side of the pitch curve's normal
        outwards = -1.0 if curve.distance > 0.0 else 1.0
        normal = outwards * curve.evaluate_by_span(radians, curve.normals)
        columns |= {f"{name}_normal_x": normal.real.copy(), f"{name}_normal_y": normal.imag.copy()}
        bend = -outwards * (curve.frame_rotation_sense or curve.mirror)
        columns[f"{name}_curvature_per_mm"] = bend * curve.evaluate_by_span(radians, curve.curvatures)
    columns |= loads_at(Picture(scene, problem), degrees)
    return Columns(columns, {name: _column_metadata(name)["unit"] for name in columns})


def _tool_and_follower_derivatives(problem: Problem, angles: FloatArray) -> dict[str, FloatArray]:
    """Velocity, acceleration and jerk of the tool at cam angles [rad], and with a train of the follower too."""
    setup, found = problem.setup, dict[str, FloatArray]()
    sides = [(problem.programme.tool, "", setup.tool_turns)]
    sides += [(problem.programme, AT_FOLLOWER, setup.angular)] if setup.train is not None else []
    for programme, whose, turns in sides:
        rows = programme.motion_at(angles)
        for order, name in enumerate(DERIVATIVE_UNITS, start=1):
            quantity = motion_peak_name(name, whose, angular=turns, timed=setup.omega is not None)
            found[load_column_name(quantity)] = rows[order] * motion_unit_factor(
                setup, order, at_follower=bool(whose)
            )
    return found


def _point_angles(
    problem: Problem,
    curves: dict[str, CamCurve],
    angles: ArrayLike | None,
    step: float | None,
    chord: float | None,
) -> FloatArray:
    """The cam angles of the points: given ones, even steps, or steps as small as the chord needs."""
    given = {"angles": angles, "step": step, "chord": chord}
    if len(names := [name for name, value in given.items() if value is not None]) > 1:
        why = f"give one of {', '.join(names)}, not several"
        raise BadInput([Mistake("camopt", names[-1], given[names[-1]], why, bare=True)])
    if angles is not None:
        try:
            degrees = np.array(angles, dtype=float).reshape(-1)
        except (TypeError, ValueError):
            degrees = np.empty(0)
        if not degrees.size:
            raise BadInput([Mistake("camopt", "angles", angles, "one or more cam angles, deg")])
        outside = degrees[~((degrees >= 0.0) & (degrees <= 360.0))]
        if outside.size:
            raise BadInput([Mistake("camopt", "angles", float(outside[0]), "from 0 to 360 deg")])
        return degrees
    if chord is None:
        return angles_in_steps(1.0 if step is None else step)
    starts = np.degrees([stroke.start for stroke in problem.programme.strokes])

    def points_at(degrees: FloatArray) -> list[ComplexArray]:
        return [curve.evaluate_by_span(np.radians(degrees), curve.points) for curve in curves.values()]

    return angles_within_chord(chord, starts, points_at)


@dataclass(frozen=True)
class _PictureAtAngles(Picture):
    """A picture with samples at given cam angles [deg], and in the middle of pieces without any."""

    degrees: FloatArray

    @cached_property
    def piece_boundaries(self) -> FloatArray:
        """Starts of the pieces, and the end of the turn [rad]."""
        table = self.problem.programme.table
        first = table.first_panel[:-1]
        return np.append(table.centre[first] - table.half_width[first], 2.0 * np.pi)

    @cached_property
    def sample_numbers_and_angles_by_piece(self) -> list[tuple[IntArray, FloatArray]]:
        """Samples of each piece: their numbers and cam angles [rad].

        An angle between two pieces, such as 0 and 360 deg, has a sample before it, at it and after it.
        """
        numbers, angles = np.tile(np.arange(self.degrees.size), 3), np.radians(self.degrees)
        repeated = np.concatenate([angles, angles + 2.0 * np.pi, angles - 2.0 * np.pi])
        pieces = []
        for start, end in pairwise(self.piece_boundaries):
            here = (repeated >= start - PIECE_END_ANGLE) & (repeated <= end + PIECE_END_ANGLE)
            first = here & (repeated <= start + PIECE_END_ANGLE)
            inside = np.clip(repeated[here], start + PIECE_OFFSET, end - PIECE_OFFSET)
            pieces.append(
                (
                    np.append(numbers[here], numbers[first]),
                    np.append(inside, np.full(np.count_nonzero(first), start)),
                )
            )
        return pieces

    @cached_property
    def angles_of_pieces(self) -> list[FloatArray]:
        pieces = zip(self.sample_numbers_and_angles_by_piece, pairwise(self.piece_boundaries), strict=True)
        return [angles if angles.size else np.array([(start + end) / 2]) for (_, angles), (start, end) in pieces]


def loads_at(picture: Picture, degrees: FloatArray) -> dict[str, FloatArray]:
    """Loads by column, named as the quantity without "max" or "min": ``contact_force_N``, ``torque_N_m``, …

    A load that is infinite somewhere has no column. Columns of two contacts are ``first_…`` and ``second_…``. At a
    jump, the column has the side with the larger magnitude; the smaller value if the quantity is a minimum.
    """
    sampled = _PictureAtAngles(picture.scene, picture.problem, degrees)
    columns = dict[str, FloatArray]()
    for panel in load_panels(sampled, with_unusual_forces=True):
        # no quantity is the extreme of a force at one of two contacts
        quantity = panel.quantity or CONTACT_FORCES[0]
        name = load_column_name(quantity)
        rank = np.negative if "_min" in quantity else np.abs
        values = {name: panel.values}
        if panel.other is not None:
            names = [f"{place}_{name}" for place in CONTACT_NAMES]
            values = dict(zip(names, (panel.values, panel.other), strict=True))
        columns |= {name: _values_at_angles(sampled, each, rank) for name, each in values.items()}
    return columns


def _values_at_angles(
    sampled: _PictureAtAngles, values_by_piece: list[FloatArray], rank_function: np.ufunc
) -> FloatArray:
    """Values of pieces in the order of the given cam angles; the highest rank if an angle has several values."""
    samples = sampled.sample_numbers_and_angles_by_piece
    numbers = np.concatenate([numbers for numbers, _ in samples])
    loads = np.concatenate([v for v, (kept, _) in zip(values_by_piece, samples, strict=True) if kept.size])
    spans = zip(samples, pairwise(sampled.piece_boundaries), strict=True)
    beside_boundary = np.concatenate(
        [(a == start + PIECE_OFFSET) | (a == end - PIECE_OFFSET) for (_, a), (start, end) in spans]
    )
    ranks = rank_function(loads) - LEAST_JUMP_SHARE * np.abs(loads).max(initial=0.0) * beside_boundary
    order, values = np.argsort(ranks, kind="stable"), np.empty(sampled.degrees.size)
    values[numbers[order]] = loads[order]
    return values


def load_column_name(quantity: str) -> str:
    """The column of a load over the turn, by the quantity that is its extreme."""
    return quantity.replace("_max", "").replace("_min", "")


LOAD_COLUMNS = {load_column_name(name): quantity for name, quantity in QUANTITIES.items()}
"""Quantity of each column of loads."""


def write_points(
    scene: Scene,
    path: str | os.PathLike[str],
    cutter_radius: float | None = None,
    *,
    step: float | None = None,
    chord: float | None = None,
) -> None:
    """Write ``cam_points`` to a CSV, Parquet or Excel file, as its suffix says.

    The file appears only when whole. Parquet carries units, descriptions, the scene and the version in its
    metadata (``camopt.load`` reads it); CSV has a line of column names, and every digit. An Excel workbook has the
    units in its second row, and the scene on a sheet of its own; it takes ``pip install "camopt[excel]"``.

    Raises
    ------
    BadInput
        For another suffix, a library that is missing, or as ``cam_points``.
    OSError
        If the file cannot be written.
    """
    checked_suffix(path, "path", POINT_SUFFIXES)
    write_columns(cam_points(scene, None, cutter_radius=cutter_radius, step=step, chord=chord), scene, path)


def write(
    work: Workpiece,
    path: Path,
    chord: float | None = None,
    step: float | None = None,
    cutter_radius: float | None = None,
) -> Export:
    """Write the columns of ``cam_points``, within a ``chord`` [mm] or in steps of the cam angle [deg].

    The bound of the deviation of straight lines between points from the curves is proved.
    """
    if step is not None and chord is not None:
        raise BadInput([Mistake("camopt", "step", step, "cannot be used with chord", bare=True)])
    check_path_options("polyline", DEFAULT_CHORD if chord is None else chord)
    spacing = {"chord": CHORD_AIM * (chord or DEFAULT_CHORD)} if step is None else {"step": step}
    columns = cam_points(work.scene, None, cutter_radius=cutter_radius, disc=work.disc, **spacing)
    angles = np.radians(columns["cam_angle_deg"])
    curves = {
        name: CurveInFile(
            angles.size - 1,
            "lines",
            deviation_upper_bound(curve, polyline_through_angles(curve, angles), chord or DEFAULT_CHORD),
        )
        for name, curve in work.curves(cutter_radius).items()
    }
    write_columns(columns, work.scene, path)
    return Export(path, curves, {"points": angles.size})


POINT_SUFFIXES = (".csv", ".parquet", ".xlsx")


def write_columns(columns: dict[str, FloatArray], scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write the columns of ``cam_points``, as the suffix says. CSV and Excel have shown units, also in names."""
    suffix, count = Path(path).suffix.lower(), columns["cam_angle_deg"].size
    metadata = {name: _column_metadata(name) for name in columns}
    if suffix == ".parquet":
        fields = [pa.field(name, pa.float64(), nullable=False, metadata=each) for name, each in metadata.items()]
        layout = pa.schema(fields, metadata={"camopt_version": VERSION, "camopt_scene": scene.to_toml()})
        write_table(to_arrow_table(DesignRows({**columns}, count), layout), path)
        return
    units = {name: each["unit"] for name, each in metadata.items()}
    shown = {name_in_shown_unit(name, unit): to_shown_unit(columns[name], unit) for name, unit in units.items()}
    if suffix == ".xlsx":
        shown_units = [unit_in_shown_system(unit) for unit in units.values()]
        write_workbook(path, {"points": (list(shown), shown_units, list(shown.values()))}, scene)
        return
    layout = pa.schema([pa.field(name, pa.float64(), nullable=False) for name in shown])
    with atomically_written_file(path) as partial, partial.open("wb") as file:
        options = csv.WriteOptions(quoting_style="none")
        csv.write_csv(to_arrow_table(DesignRows(shown, count), layout), file, options)


def check_cutter(problem: Problem, radius: float | None) -> None:
    """Raise BadInput for a cutter that is too large for a concave flank."""
    if radius is None:
        return
    mechanism, widest = problem.setup.mechanism, np.inf  # a flat face leaves no concave flank
    if mechanism.is_cut_by_roller_sized_cutter:
        widest = problem.wall_distance_from_pitch_curve
    elif not mechanism.flat_faced:
        case = EvaluationBlock(problem.setup, problem.programme, problem.design)
        widest = float(run_effects(case, [CUTTER_RADIUS]).column(CUTTER_RADIUS)[0])
    if widest <= 0.0:
        why = "is impossible: no cutter reaches the hollow corner of the profile, where the velocity jumps"
        raise BadInput([Mistake("camopt", "cutter_radius", radius, why, bare=True)])
    at_most = f"above 0 and at most {widest:g} mm; a larger cutter cuts into the profile"
    allowed = "above 0 mm" if np.isinf(widest) else at_most
    if not (0.0 < radius <= widest and np.isfinite(radius)):
        raise BadInput([Mistake("camopt", "cutter_radius", radius, allowed)])


def _column_metadata(column: str) -> dict[str, str]:
    if quantity := LOAD_COLUMNS.get(column) or LOAD_COLUMNS.get(column.partition("_")[2]):  # at either contact
        unit, description = quantity.unit, f"Along the turn: {quantity.sentence}"
    elif column in COLUMN_NOTES:
        unit, description = COLUMN_NOTES[column]
    else:
        form = next(form for form in FORM_COLUMNS if column.endswith(f"_{form}"))
        unit, words = FORM_COLUMNS[form]
        description = f"{COLUMN_NOTES[column.removesuffix(f'_{form}')][1]} {words}".rstrip()
    return {"unit": unit, "symbol": "", "description": description}
