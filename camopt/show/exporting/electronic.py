"""A table for an electronic cam: a drive that performs the follower's motion without a cam.

Each line of the text has the angle of the master, the position of the slave, and its first two derivatives by this
angle, as an interpolation of fifth degree needs them. Lines with # are comments.
"""

from pathlib import Path

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.quantities.unit_systems import from_shown_unit, unit_in_shown_system
from camopt.core.storage.files import write_text
from camopt.core.storage.version import VERSION
from camopt.show.exporting.workpiece import Export, Workpiece

FEWEST_CAM_POINTS, POINT_LIMIT = 2, 1_000_000


def write(work: Workpiece, path: Path, points: int = 361) -> Export:
    """Write points at even steps of the master's angle, from 0 to 360 deg, both included.

    At a jump, the acceleration is the one after it.
    """
    if not FEWEST_CAM_POINTS <= points <= POINT_LIMIT:
        raise BadInput([Mistake("camopt", "points", points, f"from {FEWEST_CAM_POINTS} to {POINT_LIMIT:,}")])
    degrees = np.linspace(0.0, 360.0, points)
    y, y1, y2, _ = work.problem.programme.motion_at(np.radians(degrees))
    unit, per = (
        ("deg", np.radians(1.0))
        if work.problem.setup.angular
        else (unit_in_shown_system("mm"), from_shown_unit(1.0, "mm"))
    )
    rate = np.radians(1.0)  # of the master, rad per deg
    columns = degrees, y / per, y1 * rate / per, y2 * rate**2 / per
    rpm = work.scene.cam.rpm
    lines = [
        f"# {work.scene.name}",
        f"# camopt {VERSION}; {points} points"
        + ("" if rpm is None else f"; designed for {rpm:g} rev/min of the master"),
        "# the slave is the follower" + (", which drives the tool through the train" if work.scene.train else ""),
        f"# master_deg position_{unit} velocity_{unit}_per_deg acceleration_{unit}_per_deg2",
        *(" ".join(f"{value + 0.0:.10g}" for value in row) for row in zip(*columns, strict=True)),
    ]
    write_text(path, "\n".join(lines) + "\n")
    return Export(path, about={"points": points})
