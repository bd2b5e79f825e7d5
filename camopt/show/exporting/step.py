"""STEP files (ISO 10303-21, AP214) for CAD: the solid of a cam with true arcs, cylinders and B-splines, in mm.

The time stamp is constant, so that the same cam gives the same file.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.IFSelect import IFSelect_RetDone
from OCP.Interface import Interface_Static
from OCP.Message import Message
from OCP.StepBasic import StepBasic_Product
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TCollection import TCollection_HAsciiString

from camopt.core.storage.files import atomically_written_file
from camopt.core.storage.version import VERSION
from camopt.show.exporting.solid import solid_of
from camopt.show.exporting.workpiece import Export, Workpiece
from camopt.solve.contour.path_fitting import DEFAULT_CHORD

SURFACE_CURVE_MODE = "write.surfacecurve.mode"  # edges also in surface parameters: would double the file
EPOCH = "1970-01-01T00:00:00"


def write(work: Workpiece, path: Path, chord: float = DEFAULT_CHORD, curves: str = "arcs") -> Export:
    """Write the solid of a cam with a thickness. Walls of a groove are B-splines for all ``curves``."""
    solid, name = solid_of(work, chord, curves), work.title
    with atomically_written_file(path) as partial, silence_output():
        writer = STEPControl_Writer()
        Interface_Static.SetIVal_s(SURFACE_CURVE_MODE, 0)
        writer.Transfer(solid.shape, STEPControl_AsIs)
        model = writer.Model()
        header = APIHeaderSection_MakeHeader(model)
        header.SetName(iso_10303_text(name))
        header.SetTimeStamp(iso_10303_text(EPOCH))
        header.SetAuthorValue(1, iso_10303_text(work.part.designer or ""))
        header.SetOrganizationValue(1, iso_10303_text(""))
        header.SetOriginatingSystem(iso_10303_text(f"camopt {VERSION}"))
        header.SetAuthorisation(iso_10303_text(""))
        entities = (model.Value(k) for k in range(1, model.NbEntities() + 1))
        for product in (entity for entity in entities if isinstance(entity, StepBasic_Product)):
            product.SetName(iso_10303_text(name))
            product.SetId(iso_10303_text(work.part.number or name))
        if writer.Write(str(partial)) != IFSelect_RetDone:
            raise OSError(f"{path}: Open CASCADE could not write the file")
    return Export(path, solid.curves, solid.about)


def iso_10303_text(text: str) -> TCollection_HAsciiString:
    """A text in the encoding of ISO 10303-21: characters outside of ASCII as Unicode numbers."""
    numbers = (f"\\X2\\{ord(c):04X}\\X0\\" if ord(c) < 0x10000 else f"\\X4\\{ord(c):08X}\\X0\\" for c in text)
    return TCollection_HAsciiString("".join(c if c.isascii() else n for c, n in zip(text, numbers, strict=True)))


@contextmanager
def silence_output() -> Iterator[None]:
    """Keep Open CASCADE from writing to standard output."""
    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    for printer in printers:
        messenger.RemovePrinter(printer)
    try:
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)
