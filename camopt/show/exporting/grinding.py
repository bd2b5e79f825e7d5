"""A table for a cam grinder: the distance of the wheel's centre from the axis, for each angle of the workpiece.

The workpiece turns, and the wheel moves straight towards its axis. It grinds the profile if its centre is at the
polar radius of its path, at the polar angle of the workpiece. The lift is this radius less its smallest value: the
lift of a radial roller with the radius of the wheel.

A rib of a cylinder is ground by a finger wheel with its axis square to that of the cam. A wheel in the place of a
roller, with the same radius, grinds the flank of this roller at every depth (``exporting.groove_program``). Its
centre is at the height of the roller along the axis of the cam, and beside the axis by the swing of an arm. A
smaller wheel leaves the difference of both radii on the flank.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 14 (cam grinding).
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import BISECTIONS, FloatArray
from camopt.core.quantities.unit_systems import INCH, MM, shown_system, to_shown_unit, unit_in_shown_system
from camopt.core.storage.files import write_text
from camopt.core.storage.version import VERSION
from camopt.show.exporting.cam_points import check_cutter
from camopt.show.exporting.groove_program import notes_on_metal_left_by_cutter
from camopt.show.exporting.spacing import angles_in_steps
from camopt.show.exporting.workpiece import Export, Workpiece
from camopt.solve.contour.curve import CamCurve, SmoothSpan, centred_cylinder_ends

DECIMALS_BY_SYSTEM = {MM: 6, INCH: 7}
"""Decimals of lengths, by unit system."""
CHECKED_ANGLES = 20_001  # cam angles at which the direction of the path is checked
NO_SIDE = 1e-9  # mm: a smaller distance from the plane of the axis counts as 0


def write(work: Workpiece, path: Path, cutter_radius: float | None = None, step: float = 1.0) -> Export:
    """Write angles [deg], lifts and distances of the wheel's centre [mm], in even steps of the workpiece's angle.

    The angle is the direction from the axis to the wheel's centre, from the y axis of the cam's drawing, growing
    with the cam angle. ``cutter_radius`` [mm] is that of the wheel. For a rib, positions along the axis of the cam.
    """
    problem = work.problem
    if problem.setup.mechanism.has_flanks_on_both_sides:
        raise BadInput(
            [
                Mistake(
                    "camopt",
                    "file",
                    path.name,
                    "another kind of file: this one is only for open disc cams and ribs",
                )
            ]
        )
    if cutter_radius is None:
        raise BadInput(
            [Mistake("camopt", "cutter_radius", None, "missing: set the radius of the wheel", bare=True)]
        )
    if problem.setup.mechanism.body.developed:
        return _write_rib_table(work, path, cutter_radius, step)
    check_cutter(work.only_disc.problem, cutter_radius)
    angles = angles_in_steps(step)
    radii = _radii_in_directions(work, work.only_disc.curves(cutter_radius)["cutter"], angles)
    lift_max = float(np.ptp(radii))
    unit, decimals = unit_in_shown_system("mm"), DECIMALS_BY_SYSTEM[shown_system()]
    centres, wheel = to_shown_unit(radii, "mm"), to_shown_unit(cutter_radius, "mm")
    lifts = centres - centres.min()
    lines = [
        f"# {work.title}",
        f"# camopt {VERSION}; wheel or roller of radius {wheel:.9g} {unit}, moving straight towards the axis",
        "# angle_deg: direction of the wheel's centre from the axis, from the y axis of the drawing, as the "
        "cam angle grows",
        f"# (in the drawing {'clockwise' if problem.design.sense > 0.0 else 'anticlockwise'})",
        f"# lift_{unit}: distance of the centre from the axis less its minimum, "
        f"{centres.min():.{decimals}f} {unit}",
        f"# angle_deg lift_{unit} centre_{unit}",
        *(f"{a:.10g} {y:.{decimals}f} {r:.{decimals}f}" for a, y, r in zip(angles, lifts, centres, strict=True)),
    ]
    write_text(path, "\n".join(lines) + "\n")
    return Export(path, about={"lines": angles.size, "lift_max_mm": lift_max})


def _radii_in_directions(work: Workpiece, curve: CamCurve, directions_deg: FloatArray) -> FloatArray:
    """Distance of the curve from the axis in directions [deg]; cam angles by bisection."""

    def direction_minus_cam_angle(span: SmoothSpan, angles: FloatArray) -> FloatArray:
        """In rad, within π of 0 (of π if mirrored)."""
        points = curve.points(span, angles) / (1j * curve.mirror) * np.exp(1j * curve.frame_rotation_sense * angles)
        return np.asarray((0.0 if curve.mirror > 0.0 else np.pi) - curve.frame_rotation_sense * np.angle(points))

    samples = np.linspace(0.0, 2.0 * np.pi, CHECKED_ANGLES)
    directions = samples + curve.evaluate_by_span(samples, direction_minus_cam_angle)
    if np.any(np.diff(directions) <= 0.0):
        why = "cannot be ground with this wheel: the direction of its centre runs back; choose a smaller wheel"
        raise BadInput([Mistake(work.scene.file, "cam", None, why, bare=True)])
    targets = np.radians(directions_deg)
    targets = directions[0] + (targets - directions[0]) % (2.0 * np.pi)
    place = np.clip(np.searchsorted(directions, targets, side="right") - 1, 0, CHECKED_ANGLES - 2)
    low, high = samples[place], samples[place + 1]
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        past = middle + curve.evaluate_by_span(middle, direction_minus_cam_angle) > targets
        low, high = np.where(past, low, middle), np.where(past, middle, high)
    return np.asarray(np.abs(curve.evaluate_by_span(low, curve.points)))


def _write_rib_table(work: Workpiece, path: Path, cutter_radius: float, step: float) -> Export:
    """Write cam angles in even steps [deg], and positions of the wheel's centre at both flanks [mm]."""
    check_cutter(work.problem, cutter_radius)
    angles = angles_in_steps(step)
    columns = dict(_wheel_positions(work, angles))
    wheel, unit, decimals = (
        to_shown_unit(cutter_radius, "mm"),
        unit_in_shown_system("mm"),
        DECIMALS_BY_SYSTEM[shown_system()],
    )
    turned = "ccw" if work.problem.design.sense > 0.0 else "cw"
    zero = "lower end of the cylinder" if work.part.thickness else "middle of the first roller at cam angle 0"
    aside = [
        f"# beside_{unit}: distance from the plane through the axis of the cam, against the motion of the surface"
    ] * (len(columns) > len(work.discs))  # for rollers on arms
    lines = [
        f"# {work.title}",
        f"# camopt {VERSION}; finger wheel of radius {wheel:.9g} {unit}, its axis square to that of the cam",
        f"# angle_deg: angle of the cam, {turned} as seen from above",
        f"# along_{unit}: height of the wheel's centre at each flank, upwards; zero: {zero}",
        *aside,
        " ".join(["# angle_deg", *(f"{name}_{unit}" for name in columns)]),
    ]
    rows = [to_shown_unit(values, "mm") for values in columns.values()]
    lines += [
        " ".join([f"{angle:.10g}", *(f"{value + 0.0:.{decimals}f}" for value in row)])
        for angle, *row in zip(angles, *rows, strict=True)
    ]
    write_text(path, "\n".join(lines) + "\n")
    return Export(
        path, about={"lines": angles.size}, notes=tuple(notes_on_metal_left_by_cutter(work, cutter_radius))
    )


def _wheel_positions(work: Workpiece, cam_angles_deg: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Positions along the axis of the cam, and beside it for rollers on arms, by name of the column."""
    problem, angles = work.problem, np.radians(cam_angles_deg)
    pitch = {
        name: curve.evaluate_by_span(angles, curve.points)
        for name, curve in work.curves().items()
        if name.endswith("pitch")
    }
    first = float(pitch["pitch"].imag[0])
    low = centred_cylinder_ends(problem, work.part.thickness)[0] if work.part.thickness else first
    for name, points in pitch.items():
        which = "second" if name.startswith("second_") else "first"
        beside = points.real - problem.design.size * angles
        yield f"{which}_along", points.imag - low
        if np.abs(beside).max() > NO_SIDE:
            yield f"{which}_beside", beside
