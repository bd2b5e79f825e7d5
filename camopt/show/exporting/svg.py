"""SVG at scale 1:1, for laser cutters and pages: arcs stay arcs, and cubics are cubics."""

from math import pi
from pathlib import Path
from xml.etree import ElementTree as Xml

from camopt.core.storage.files import whole_file
from camopt.core.storage.version import VERSION
from camopt.show.exporting.exported import Export, Workpiece, told
from camopt.show.exporting.layers import CHAIN_LINE, DASHED, THIN_LINE, VISIBLE, Layer, plan_of
from camopt.solve.contour.follow import CHORD
from camopt.solve.contour.path import ArcPath, CubicPath

VIEW_MARGIN = 5.0  # mm
PATTERNS = {CHAIN_LINE: "8 1.5 1 1.5", DASHED: "3 1.5"}
WIDTHS = {VISIBLE: 0.35}  # mm
THINNER = 0.18
LAST_DIGIT = 1e-9  # mm: the last digit of a number in the file
INKS = {VISIBLE: "#000000", THIN_LINE: "#606060", CHAIN_LINE: "#3050a0", DASHED: "#208020"}


def write(
    work: Workpiece,
    path: Path,
    chord: float = CHORD,
    curves: str = "arcs",
    cutter_radius: float | None = None,
) -> Export:
    """Write the plan of a cam at scale 1:1, a group of its own for each kind of curve."""
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
        _draw(plane, layer)
    Xml.indent(root)
    with whole_file(path) as partial:
        Xml.ElementTree(root).write(partial, encoding="utf-8", xml_declaration=True)
    return Export(path, told(plan.followed))


def _draw(plane: Xml.Element, layer: Layer) -> None:
    dashes = {"stroke-dasharray": PATTERNS[layer.line]} if layer.line in PATTERNS else {}
    width = {"stroke-width": str(WIDTHS.get(layer.line, THINNER))}
    group = Xml.SubElement(plane, "g", {"id": layer.name, "stroke": INKS[layer.line], **width, **dashes})
    for path in layer.paths:
        Xml.SubElement(group, "path", d=_arcs(path) if isinstance(path, ArcPath) else _cubics(path))
    for radius, centre in layer.circles:
        about = {"cx": _number(centre.real), "cy": _number(centre.imag)} if centre else {}
        Xml.SubElement(group, "circle", about, r=_number(radius))
    for start, end in layer.lines:
        Xml.SubElement(group, "path", d=f"M {_point(start)} L {_point(end)}")


def _arcs(path: ArcPath) -> str:
    parts = [f"M {_point(path.vertices[0])}"]
    radii = [1.0 / abs(k) if k else 0.0 for k in path.curvatures.tolist()]
    for end, sweep, radius in zip(path.vertices[1:].tolist(), path.sweeps.tolist(), radii, strict=True):
        flags = f"{int(abs(sweep) > pi)} {int(sweep > 0)}"
        parts.append(
            f"A {_number(radius)} {_number(radius)} 0 {flags} {_point(end)}" if sweep else f"L {_point(end)}"
        )
    return " ".join([*parts, *(["Z"] if path.closed else [])])


def _cubics(path: CubicPath) -> str:
    parts = [f"C {' '.join(map(_point, each[1:].tolist()))}" for each in path.controls]
    closing = ["Z"] if abs(path.controls[0, 0] - path.controls[-1, 3]) < LAST_DIGIT else []
    return " ".join([f"M {_point(path.controls[0, 0])}", *parts, *closing])


def _number(value: float) -> str:
    """A number in mm with picometre digits, far below any chord."""
    return f"{value:.9f}".rstrip("0").rstrip(".")


def _point(z: complex) -> str:
    return f"{_number(z.real)} {_number(z.imag)}"
