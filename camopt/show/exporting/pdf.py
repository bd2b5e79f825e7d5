"""PDF: the workshop drawing at its true size, a sheet for each disc."""

from collections.abc import Iterator
from pathlib import Path

from camopt.show.exporting.workpiece import CurveInFile, Export, Workpiece
from camopt.show.sheet.paper import scale_name
from camopt.show.sheet.sheet import write_sheets
from camopt.show.sheet.sizes import Clearance, clearance_of
from camopt.solve.tables.cells import with_unit


def write(work: Workpiece, path: Path, step: float | None = None) -> Export:
    """Draw the sheets of a cam, with a table in steps (deg); its curves are lines in its own mm at any scale."""
    sheets = write_sheets(work.scene, work.problem, path, step, work.disc)
    curves = {
        name: CurveInFile(found.points.size - 1, "lines", found.deviation)
        for name, found in sheets[0].cam.curves.items()
        if name in work.curves()
    }
    about = {"paper": [each.paper.name for each in sheets], "scale": [scale_name(each.scale) for each in sheets]}
    told = {name: ", ".join(dict.fromkeys(each)) for name, each in about.items()}
    return Export(path, curves, told, tuple(_clearance_notes(work, clearance_of(sheets[0].cam))))


def _clearance_notes(work: Workpiece, room: Clearance) -> Iterator[str]:
    """A note on a clearance that the fit of the groove does not have, or that its tolerance may take away."""
    if room.given is None or room.ends is None:
        return
    least, most = room.ends
    if 0.0 <= least <= room.given <= most:
        return
    low, high = (with_unit(end, "mm") for end in room.ends)
    given, what = with_unit(room.given, "mm"), work.part.groove_fit or "the tolerance of both walls"
    yield f"drive.clearance is {given}, and {what} leaves the roller from {low} to {high}"
