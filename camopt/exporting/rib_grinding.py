"""A table for a grinder of ribs: where a wheel stands on either flank, for each angle of the workpiece.

The wheel is a finger whose axis is square to that of the cam. In the place of a roller, and as large, it grinds the
flank that this roller touches, at every depth (``exporting.groove_program``): its centre is along the axis of the
cam where the roller's is, and beside it by what an arm has swung away. A smaller one leaves as much on the flank as
its radius is less.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 14 (cam grinding).
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from camopt.contour.curve import cylinder_ends
from camopt.exporting.cam_points import check_cutter
from camopt.exporting.exported import Export
from camopt.exporting.groove_program import left_on_walls
from camopt.exporting.spacing import in_steps
from camopt.exporting.workpiece import Workpiece
from camopt.numerics import FloatArray
from camopt.quantities.unit_systems import shown, shown_unit
from camopt.storage.files import write_text
from camopt.storage.version import VERSION

NO_SIDE = 1e-9  # mm: what is no further beside the axis is in its plane


def write_rib(work: Workpiece, path: Path, cutter_radius: float, step: float, decimals: int) -> Export:
    """Write cam angles (deg) in even steps, and the places of the wheel's centre at both flanks (mm)."""
    check_cutter(work.problem, cutter_radius)
    angles = in_steps(step)
    columns = dict(_places(work, angles))
    wheel, unit, turned = (
        shown(cutter_radius, "mm"),
        shown_unit("mm"),
        "ccw" if work.problem.design.sense > 0.0 else "cw",
    )
    zero = "lower end of the cylinder" if work.part.thickness else "middle of the first roller at cam angle 0"
    swings = len(columns) > len(work.discs)
    aside = [
        f"# beside_{unit}: from the plane through the axis of the cam, against the way of the surface"
    ] * swings
    lines = [
        f"# {work.title}",
        f"# camopt {VERSION}; finger wheel of radius {wheel:.9g} {unit}, its axis square to that of the cam",
        f"# angle_deg: by which the cam is turned, {turned} as seen from above",
        f"# along_{unit}: of the wheel's centre at each flank, upwards; zero: {zero}",
        *aside,
        " ".join(["# angle_deg", *(f"{name}_{unit}" for name in columns)]),
    ]
    rows = [shown(values, "mm") for values in columns.values()]
    lines += [
        " ".join([f"{angle:.10g}", *(f"{value + 0.0:.{decimals}f}" for value in row)])
        for angle, *row in zip(angles, *rows, strict=True)
    ]
    write_text(path, "\n".join(lines) + "\n")
    return Export(path, about={"lines": angles.size}, notes=tuple(left_on_walls(work, cutter_radius)))


def _places(work: Workpiece, degrees: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Places along the axis of the cam, and beside it of rollers that swing."""
    problem, angles = work.problem, np.radians(degrees)
    pitch = {
        name: curve.at(angles, curve.points) for name, curve in work.curves().items() if name.endswith("pitch")
    }
    first = float(pitch["pitch"].imag[0])
    low = cylinder_ends(problem, work.part.thickness)[0] if work.part.thickness else first
    for name, points in pitch.items():
        which = "second" if name.startswith("second_") else "first"
        beside = points.real - problem.design.size * angles
        yield f"{which}_along", points.imag - low
        if np.abs(beside).max() > NO_SIDE:
            yield f"{which}_beside", beside
