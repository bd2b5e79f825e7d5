"""S96: the lift of a lobe at each degree, as grinders of camshafts exchange it (``measured.s96``).

The opening flank comes first, and the nose is at 180 deg, in row 181.
"""

from pathlib import Path

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.files import write_text
from camopt.show.exporting.workpiece import Export, Workpiece
from camopt.solve.measured.columns import MM_PER_UNIT
from camopt.solve.measured.s96 import S96_DECIMALS, S96_REPEATED, S96_ROWS, S96_UNIT

NOSE_DEG = 180.0


def write(work: Workpiece, path: Path) -> Export:
    """Write the lift of the follower at each degree [inch]; the last 36 rows repeat the first."""
    programme = work.problem.programme
    if work.problem.setup.angular:
        what = "another kind of file: this one has lifts of a translating follower"
        raise BadInput([Mistake("camopt", "file", path.name, what)])
    degrees = np.arange(S96_ROWS - S96_REPEATED) + (programme.nose_angle_deg - NOSE_DEG)
    lifts = programme.motion_at(np.radians(degrees % 360.0))[0] / MM_PER_UNIT[S96_UNIT]
    rows = [*lifts, *lifts[:S96_REPEATED]]
    write_text(path, "".join(f"{max(lift, 0.0):.{S96_DECIMALS}f}\n" for lift in rows))
    notes = (
        [f"the first and last {S96_REPEATED} rows are not all on the base circle, as grinders expect"]
        if lifts[:S96_REPEATED].max() > 0.5 * 10.0**-S96_DECIMALS
        else []
    )
    return Export(path, about={"lines": len(rows), "lift_max_mm": programme.lift}, notes=tuple(notes))
