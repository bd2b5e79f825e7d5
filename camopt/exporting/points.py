"""Points of the cam's curves as a table: CSV, Parquet or an Excel workbook."""

from pathlib import Path

import numpy as np

from camopt.contour.curve import curves_of
from camopt.contour.deviation import deviation
from camopt.contour.fit import through
from camopt.contour.follow import CHORD, MARGIN, Followed, check
from camopt.exporting.exported import Exported, told
from camopt.points.points import cam_points, write_columns
from camopt.problem.problem import Problem


def write(
    problem: Problem,
    path: Path,
    chord: float | None = None,
    step: float | None = None,
    cutter_radius: float | None = None,
) -> Exported:
    """Write what ``cam_points`` gives, as close as ``chord`` (mm) or in steps (deg) of the cam angle.

    How far straight lines from point to point are from the curves is proved.
    """
    spacing = {"step": step} if step is not None else {"chord": MARGIN * (CHORD if chord is None else chord)}
    if chord is not None:
        check("polyline", chord)
        spacing |= {"chord": MARGIN * chord}
    columns = cam_points(problem.scene, None, cutter_radius, **spacing)
    angles = np.radians(columns["cam_angle_deg"])
    followed = {}
    for name, curve in curves_of(problem, cutter_radius).items():
        lines = through(curve, angles)
        followed[name] = Followed(lines, deviation(curve, lines, chord or 0.0))
    write_columns(columns, problem.scene, path, path.suffix.lower())
    return Exported(path, told(followed), {"points": angles.size})
