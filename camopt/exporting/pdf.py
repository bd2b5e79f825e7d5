"""PDF: the workshop drawing, one sheet at its true size."""

from pathlib import Path

from camopt.exporting.exported import CurveInFile, Export
from camopt.exporting.workpiece import Workpiece
from camopt.sheet.paper import scale_name
from camopt.sheet.sheet import write_sheet


def write(work: Workpiece, path: Path, step: float | None = None) -> Export:
    """Draw the sheet of a cam, with a table in steps (deg); its curves are lines in its own mm at any scale."""
    sheet = write_sheet(work.scene, work.problem, path, step)
    curves = {
        name: CurveInFile(found.points.size - 1, "lines", found.deviation)
        for name, found in sheet.cam.curves.items()
    }
    return Export(path, curves, {"paper": sheet.paper.name, "scale": scale_name(sheet.scale)})
