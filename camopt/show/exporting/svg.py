"""SVG at scale 1:1, for laser cutters and pages. Arcs stay arcs, and cubics stay cubics."""

from math import pi
from pathlib import Path
from xml.etree import ElementTree as Xml

from camopt.core.storage.files import atomically_written_file
from camopt.core.storage.version import VERSION
from camopt.show.exporting.layers import CHAIN_LINE, DASHED, THIN_LINE, VISIBLE, Layer, plan_of
from camopt.show.exporting.workpiece import Export, Workpiece, curves_in_file
from camopt.solve.contour.path import ArcPath, CubicPath
from camopt.solve.contour.path_fitting import DEFAULT_CHORD

VIEW_MARGIN = 5.0  # mm
LINE_PATTERNS = {CHAIN_LINE: "8 1.5 1 1.5", DASHED: "3 1.5"}
LINE_WIDTHS = {VISIBLE: 0.35}  # mm
THIN_WIDTH = 0.18
LAST_DIGIT = 1e-9  # mm: the last digit of a number in the file
LINE_COLOURS = {VISIBLE: "#000000", THIN_LINE: "#606060", CHAIN_LINE: "#3050a0", DASHED: "#208020"}


def write(
    work: Workpiece,
    path: Path,
    chord: float = DEFAULT_CHORD,
    curves: str = "arcs",
    cutter_radius: float | None = None,
) -> Export:
    """Write the plan of a cam at scale 1:1, with a group for each kind of curve."""
    plan = plan_of(work, chord, curves, cutter_radius)
    low, high = plan.reach
    size = high - low + 2 * complex(VIEW_MARGIN, VIEW_MARGIN)
    left, top = low.real - VIEW_MARGIN, -high.imag - VIEW_MARGIN
    root = Xml.Element(
        "svg",
        xmlns="http://www.w3.org/2000/svg",
        width=f"{size.real:.6f}mm",
        height=f"{size.imag:.6f}mm",
        viewBox=f"{left:.6f} {top:.6f} {size.real:.6f} {size.imag:.6f}",
    )
    Xml.SubElement(root, "title").text = f"{work.part.name} (camopt {VERSION})"
    Xml.SubElement(root, "desc").text = "Scale 1:1, lengths in mm"
    plane = Xml.SubElement(root, "g", transform="scale(1 -1)", fill="none")
    for layer in plan.layers:
        _add_group(plane, layer)
    Xml.indent(root)
    with atomically_written_file(path) as partial:
        Xml.ElementTree(root).write(partial, encoding="utf-8", xml_declaration=True)
    return Export(path, curves_in_file(plan.followed))


def _add_group(parent: Xml.Element, layer: Layer) -> None:
    dashes = {"stroke-dasharray": LINE_PATTERNS[layer.line]} if layer.line in LINE_PATTERNS else {}
    width = {"stroke-width": str(LINE_WIDTHS.get(layer.line, THIN_WIDTH))}
    group = Xml.SubElement(parent, "g", {"id": layer.name, "stroke": LINE_COLOURS[layer.line], **width, **dashes})
    for path in layer.paths:
        Xml.SubElement(
            group, "path", d=_arc_path_data(path) if isinstance(path, ArcPath) else _cubic_path_data(path)
        )
    for radius, centre in layer.circles:
        about = {"cx": _svg_number(centre.real), "cy": _svg_number(centre.imag)} if centre else {}
        Xml.SubElement(group, "circle", about, r=_svg_number(radius))
    for start, end in layer.lines:
        Xml.SubElement(group, "path", d=f"M {_svg_point(start)} L {_svg_point(end)}")


def _arc_path_data(path: ArcPath) -> str:
    parts = [f"M {_svg_point(path.vertices[0])}"]
    radii = [1.0 / abs(k) if k else 0.0 for k in path.curvatures.tolist()]
    for end, sweep, radius in zip(path.vertices[1:].tolist(), path.sweeps.tolist(), radii, strict=True):
        flags = f"{int(abs(sweep) > pi)} {int(sweep > 0)}"
        parts.append(
            f"A {_svg_number(radius)} {_svg_number(radius)} 0 {flags} {_svg_point(end)}"
            if sweep
            else f"L {_svg_point(end)}"
        )
    return " ".join([*parts, *(["Z"] if path.is_closed else [])])


def _cubic_path_data(path: CubicPath) -> str:
    parts = [f"C {' '.join(map(_svg_point, each[1:].tolist()))}" for each in path.controls]
    closing = ["Z"] if abs(path.controls[0, 0] - path.controls[-1, 3]) < LAST_DIGIT else []
    return " ".join([f"M {_svg_point(path.controls[0, 0])}", *parts, *closing])


def _svg_number(value: float) -> str:
    """A number in mm with digits down to 1e-9 mm, far below any chord."""
    return f"{value:.9f}".rstrip("0").rstrip(".")


def _svg_point(z: complex) -> str:
    return f"{_svg_number(z.real)} {_svg_number(z.imag)}"
