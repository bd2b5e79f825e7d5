"""PDF: the workshop drawing at true size, with a sheet for each disc."""

from pathlib import Path

from camopt.show.exporting.workpiece import CurveInFile, Export, Workpiece
from camopt.show.sheet.paper import scale_name
from camopt.show.sheet.sheet import write_sheets
from camopt.show.sheet.sizes import groove_clearance
from camopt.solve.tables.cells import with_unit


def write(work: Workpiece, path: Path, step: float | None = None) -> Export:
    """Draw the sheets of a cam, with a table in steps [deg]. Deviations of curves are in mm of the cam."""
    sheets = write_sheets(work.scene, work.problem, path, step, work.disc)
    curves = {
        name: CurveInFile(curve.points.size - 1, "lines", curve.deviation)
        for name, curve in sheets[0].cam.curves.items()
        if name in work.curves()
    }
    about = {"paper": [each.paper.name for each in sheets], "scale": [scale_name(each.scale) for each in sheets]}
    texts = {name: ", ".join(dict.fromkeys(values)) for name, values in about.items()}
    # a clearance may differ from the fit of the groove, or the tolerance may take it away
    given, ends = groove_clearance(sheets[0].cam)
    notes: tuple[str, ...] = ()
    if given is not None and ends is not None and not 0.0 <= ends[0] <= given <= ends[1]:
        low, high = (with_unit(end, "mm") for end in ends)
        clearance, fit = with_unit(given, "mm"), work.part.groove_fit or "the tolerance of both walls"
        notes = (f"drive.clearance is {clearance}, but {fit} gives the roller a clearance from {low} to {high}",)
    return Export(path, curves, texts, notes)
