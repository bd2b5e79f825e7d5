"""DXF for CAD and for machines that cut from drawings: layers of polylines with arcs, or splines; by ezdxf."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

import numpy as np
from ezdxf import units
from ezdxf.filemanagement import new
from ezdxf.layouts.layout import Modelspace

from camopt.core.quantities.unit_systems import MM, shown_system, to_shown_unit
from camopt.core.storage.files import atomically_written_file
from camopt.core.storage.version import VERSION
from camopt.show.exporting.layers import CHAIN_LINE, DASHED, THIN_LINE, VISIBLE, Layer, plan_of, train_layers
from camopt.show.exporting.workpiece import Export, Workpiece, curves_in_file
from camopt.solve.contour.path import ArcPath
from camopt.solve.contour.path_fitting import DEFAULT_CHORD

LINE_TYPES = {
    VISIBLE: ("CONTINUOUS", 50),
    THIN_LINE: ("CONTINUOUS", 25),
    CHAIN_LINE: ("CENTER", 25),
    DASHED: ("DASHED", 25),
}
"""Line type and width, in hundredths of a millimetre."""
COLOUR_NUMBERS = {VISIBLE: 7, THIN_LINE: 8, CHAIN_LINE: 5, DASHED: 3}


def write(
    work: Workpiece,
    path: Path,
    chord: float = DEFAULT_CHORD,
    curves: str = "arcs",
    cutter_radius: float | None = None,
) -> Export:
    """Write the plan of a cam in the shown unit (mm or inch), with a layer for each kind of curve."""
    plan = plan_of(work, chord, curves, cutter_radius)
    factor = to_shown_unit(1.0, "mm")
    with _reproducible_output():
        document = new("R2010", setup=["linetypes"], units=units.MM if shown_system() == MM else units.IN)
        document.header.custom_vars.append("camopt", VERSION)
        document.header.custom_vars.append("cam", work.scene.name)
        for layer in (*plan.layers, *train_layers(work.problem)):
            kind, width = LINE_TYPES[layer.line]
            document.layers.add(
                layer.name.upper(), color=COLOUR_NUMBERS[layer.line], linetype=kind, lineweight=width
            )
            _add_layer(document.modelspace(), layer.with_factor(factor))
        for kind in sorted(
            document.entitydb.dxf_types_in_use()
        ):  # sorted: ezdxf would add them in the order of a set
            document.classes.add_class(kind)
        with (
            atomically_written_file(path) as partial,
            partial.open("w", encoding=document.output_encoding, newline="\n") as file,
        ):
            document.write(file)
    return Export(path, curves_in_file(plan.followed))


@contextmanager
def _reproducible_output() -> Iterator[None]:
    """Within the block, ezdxf writes no time and no random number: the same cam gives the same file."""
    options = import_module("ezdxf").options  # ezdxf does not export this name
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def _add_layer(space: Modelspace, layer: Layer) -> None:
    about = {"layer": layer.name.upper()}
    for path in layer.paths:
        if isinstance(path, ArcPath):
            bulges = path.bulges if path.is_closed else np.append(path.bulges, 0.0)
            corners = zip(path.vertices.real.tolist(), path.vertices.imag.tolist(), bulges.tolist(), strict=False)
            space.add_lwpolyline(list(corners), format="xyb", close=path.is_closed, dxfattribs=about)
        else:  # a cubic B-spline over the cam angle [deg]
            controls, knots = path.bspline_controls_and_knots_deg
            points = np.column_stack([controls.real, controls.imag, np.zeros(controls.size)])
            spline = space.add_open_spline(points.tolist(), degree=3, knots=knots.tolist(), dxfattribs=about)
            spline.dxf.flags = 8  # planar
    for radius, centre in layer.circles:
        space.add_circle((centre.real, centre.imag), radius, dxfattribs=about)
    for start, end in layer.lines:
        space.add_line((start.real, start.imag), (end.real, end.imag), dxfattribs=about)
