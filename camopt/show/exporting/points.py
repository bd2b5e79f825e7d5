"""Points of the cam's curves as a table: CSV, Parquet or an Excel workbook."""

from pathlib import Path

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.show.exporting.cam_points import POINT_WRITERS, cam_points
from camopt.show.exporting.workpiece import CurveInFile, Export, Workpiece
from camopt.solve.contour.deviation import deviation_upper_bound
from camopt.solve.contour.path_fitting import CHORD_AIM, DEFAULT_CHORD, check_path_options, polyline_through_angles


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
    POINT_WRITERS[path.suffix.lower()](columns, work.scene, path)
    return Export(path, curves, {"points": angles.size})
