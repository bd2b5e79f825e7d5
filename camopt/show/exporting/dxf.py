"""DXF, for CAD and machines that cut from drawings: layers of polylines with arcs, or splines; written by ezdxf."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

import numpy as np
from ezdxf import units
from ezdxf.filemanagement import new
from ezdxf.layouts.layout import Modelspace

from camopt.core.quantities.unit_systems import MM, shown, system_shown
from camopt.core.storage.files import whole_file
from camopt.core.storage.version import VERSION
from camopt.show.exporting.exported import Export, Workpiece, told
from camopt.show.exporting.layers import CHAIN_LINE, DASHED, THIN_LINE, VISIBLE, Layer, layout_of, plan_of
from camopt.solve.contour.follow import CHORD
from camopt.solve.contour.path import ArcPath, CubicPath

LINE_TYPES = {
    VISIBLE: ("CONTINUOUS", 50),
    THIN_LINE: ("CONTINUOUS", 25),
    CHAIN_LINE: ("CENTER", 25),
    DASHED: ("DASHED", 25),
}
"""Line type and width, in hundredths of a millimetre."""
ACI = {VISIBLE: 7, THIN_LINE: 8, CHAIN_LINE: 5, DASHED: 3}


def write(
    work: Workpiece,
    path: Path,
    chord: float = CHORD,
    curves: str = "arcs",
    cutter_radius: float | None = None,
) -> Export:
    """Write the plan of a cam in mm, or in inch where results are shown so, each kind of curve on its own layer."""
    plan = plan_of(work, chord, curves, cutter_radius)
    one = shown(1.0, "mm")
    with _same_each_time():
        document = new("R2010", setup=["linetypes"], units=units.MM if system_shown() == MM else units.IN)
        document.header.custom_vars.append("camopt", VERSION)
        document.header.custom_vars.append("cam", work.scene.name)
        for layer in (*plan.layers, *layout_of(work.problem)):
            kind, width = LINE_TYPES[layer.line]
            document.layers.add(layer.name.upper(), color=ACI[layer.line], linetype=kind, lineweight=width)
            _draw(document.modelspace(), layer.times(one))
        for kind in sorted(document.entitydb.dxf_types_in_use()):  # ezdxf would add them in the order of a set
            document.classes.add_class(kind)
        with (
            whole_file(path) as partial,
            partial.open("w", encoding=document.output_encoding, newline="\n") as file,
        ):
            document.write(file)
    return Export(path, told(plan.followed))


@contextmanager
def _same_each_time() -> Iterator[None]:
    """The same cam gives the same file: ezdxf writes no clock and no random number."""
    options = import_module("ezdxf").options  # not among what ezdxf exports by name
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def _draw(space: Modelspace, layer: Layer) -> None:
    about = {"layer": layer.name.upper()}
    for path in layer.paths:
        if isinstance(path, ArcPath):
            _polyline(space, path, about)
        else:
            _spline(space, path, about)
    for radius, centre in layer.circles:
        space.add_circle((centre.real, centre.imag), radius, dxfattribs=about)
    for start, end in layer.lines:
        space.add_line((start.real, start.imag), (end.real, end.imag), dxfattribs=about)


def _polyline(space: Modelspace, path: ArcPath, about: dict[str, str]) -> None:
    bulges = path.bulges if path.closed else np.append(path.bulges, 0.0)
    corners = zip(path.vertices.real.tolist(), path.vertices.imag.tolist(), bulges.tolist(), strict=False)
    space.add_lwpolyline(list(corners), format="xyb", close=path.closed, dxfattribs=about)


def _spline(space: Modelspace, path: CubicPath, about: dict[str, str]) -> None:
    """One cubic B-spline over the cam angle in deg."""
    controls, knots = path.bspline
    points = np.column_stack([controls.real, controls.imag, np.zeros(controls.size)])
    spline = space.add_open_spline(points.tolist(), degree=3, knots=knots.tolist(), dxfattribs=about)
    spline.dxf.flags = 8  # planar
