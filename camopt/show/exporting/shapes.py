"""Solids in the boundary representation of Open CASCADE: edges, faces, extrusions and measurements.

Lengths are in mm. Open CASCADE merges points closer than 1e-7 mm.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeSolid,
    BRepBuilderAPI_MakeVertex,
    BRepBuilderAPI_MakeWire,
    BRepBuilderAPI_Sewing,
)
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepLib import BRepLib
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.collections import (
    Array1_double,
    Array1_gp_Pnt,
    Array1_int,
    Array2_gp_Pnt,
    IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher,
)
from OCP.Geom import Geom_BSplineCurve, Geom_BSplineSurface, Geom_CylindricalSurface
from OCP.gp import gp, gp_Ax2, gp_Ax3, gp_Circ, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.ShapeFix import ShapeFix_Face
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Face

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.solve.contour.path import ArcPath, CubicPath

CadShape = Any
"""A shape of Open CASCADE, whose classes mypy does not know."""
EDGE, FACE, SOLID = TopAbs_EDGE, TopAbs_FACE, TopAbs_SOLID
TOUCHING_MM = 1e-7  # closer points are equal
FLAT_ARC = 1e-8  # mm: a lower arc is a line, since rounding of its centre would be as large


def gp_point(x: float, y: float, z: float) -> CadShape:
    return gp_Pnt(float(x), float(y), float(z))


def circle_wire(radius: float) -> CadShape:
    """A circle about the z axis, in the plane z = 0."""
    return make_wire([BRepBuilderAPI_MakeEdge(gp_Circ(gp.XOY_s(), radius)).Edge()])


def make_wire(edges: Iterable[CadShape]) -> CadShape:
    """A wire of consecutive edges."""
    builder = BRepBuilderAPI_MakeWire()
    for edge in edges:
        builder.Add(edge)
    return builder.Wire()


def closed_wire(path: ArcPath | CubicPath) -> CadShape:
    """A wire along a closed path in the plane z = 0."""
    return make_wire(_arc_edges(path) if isinstance(path, ArcPath) else _spline_edges(path))


def _path_vertices(points: ComplexArray) -> list[CadShape]:
    """Vertices at points x + iy, with the first one repeated at the end."""
    vertices = [make_vertex((p.real, p.imag, 0.0)) for p in points]
    return [*vertices, vertices[0]]


def _arc_edges(path: ArcPath) -> Iterator[CadShape]:
    """Edges of a path: true arcs of circles, and lines."""
    corners = _path_vertices(path.vertices[:-1])
    heights = np.abs(path.bulges * path.chords) / 2
    with np.errstate(divide="ignore"):
        radii = 1.0 / np.abs(path.curvatures)
    for k, (centre, height) in enumerate(zip(path.centres, heights, strict=True)):
        if height <= FLAT_ARC:
            yield line_edge(*corners[k : k + 2])
        else:
            yield arc_edge(gp_point(centre.real, centre.imag, 0.0), radii[k], path.bulges[k], *corners[k : k + 2])


def _spline_edges(path: CubicPath) -> Iterator[CadShape]:
    """Edges of a path: a B-spline over the cam angle [rad] for each span, with a continuous tangent."""
    spans = np.array(path.spans)
    pieces = [np.flatnonzero(spans == span) for span in dict.fromkeys(path.spans)]
    corners = _path_vertices(np.array([path.controls[each[0], 0] for each in pieces]))
    for k, piece in enumerate(pieces):
        controls = path.controls[piece]
        poles = np.concatenate([controls[0, :1], controls[:, 1:3].ravel(), controls[-1, 3:]])
        poles[-1] = path.controls[pieces[(k + 1) % len(pieces)][0], 0]
        knots = np.repeat(np.append(path.angles[piece, 0], path.angles[piece[-1], 1]), 2)
        ends = np.repeat(knots[[0, -1]], 2)
        places = np.column_stack([poles.real, poles.imag, np.zeros(poles.size)])
        yield spline_edge(places, np.concatenate([ends[:2], knots, ends[2:]]), corners[k : k + 2])


def spline_edge(poles: FloatArray, knots: FloatArray, ends: Sequence[CadShape]) -> CadShape:
    """An edge along a B-spline with poles (n, 3 or more: x, y, z), between two vertices.

    Knots are repeated by their multiplicity.
    """
    places = Array1_gp_Pnt(1, len(poles))
    for k, pole in enumerate(poles, 1):
        places.SetValue(k, gp_point(*pole[:3]))
    each, times = np.unique(knots, return_counts=True)
    degree = len(knots) - len(poles) - 1
    curve = Geom_BSplineCurve(places, _cad_array(Array1_double, each), _cad_array(Array1_int, times), degree)
    return BRepBuilderAPI_MakeEdge(curve, *ends, float(knots[0]), float(knots[-1])).Edge()


def spline_surface(poles: FloatArray, first_knots: FloatArray, second_knots: FloatArray) -> CadShape:
    """A B-spline surface with poles (n, m, 3 or more); knots are repeated by their multiplicity."""
    count, across = poles.shape[:2]
    places = Array2_gp_Pnt(1, count, 1, across)
    for k, m in np.ndindex(count, across):
        places.SetValue(k + 1, m + 1, gp_point(*poles[k, m, :3]))
    knots, times = zip(*(np.unique(each, return_counts=True) for each in (first_knots, second_knots)), strict=True)
    degrees = len(first_knots) - count - 1, len(second_knots) - across - 1
    reals, integers = (
        [_cad_array(kind, each) for each in both] for kind, both in ((Array1_double, knots), (Array1_int, times))
    )
    return Geom_BSplineSurface(places, *reals, *integers, *degrees)


def cylinder_surface(radius: float, seam_angle: float) -> CadShape:
    """A cylinder about the z axis, with its seam at an angle from the x axis [rad]."""
    start = gp_Dir(float(np.cos(seam_angle)), float(np.sin(seam_angle)), 0.0)
    return Geom_CylindricalSurface(gp_Ax3(gp.Origin_s(), gp.DZ_s(), start), radius)


def make_vertex(place: Iterable[float]) -> CadShape:
    return BRepBuilderAPI_MakeVertex(gp_point(*list(place)[:3])).Vertex()


def line_edge(first: CadShape, last: CadShape) -> CadShape:
    return BRepBuilderAPI_MakeEdge(first, last).Edge()


def arc_edge(centre: CadShape, radius: float, sense: float, first: CadShape, last: CadShape) -> CadShape:
    """An arc of a circle normal to the z axis, between two vertices; anticlockwise for ``sense`` above 0."""
    axes = gp_Ax2(centre, gp_Dir(0.0, 0.0, float(np.sign(sense))))
    return BRepBuilderAPI_MakeEdge(gp_Circ(axes, float(radius)), first, last).Edge()


def surface_face(surface: CadShape, edges: Iterable[CadShape], is_clockwise: bool = False) -> CadShape:
    """The face on a surface bounded by a closed chain of edges; ``is_clockwise`` if the chain is clockwise."""
    made = TopoDS_Face()
    builder = BRep_Builder()
    builder.MakeFace(made, surface, TOUCHING_MM)
    loop = make_wire(edges)
    builder.Add(made, loop.Reversed() if is_clockwise else loop)
    fixed = ShapeFix_Face(made)
    fixed.Perform()
    return fixed.Face()


def plane_face(wire: CadShape) -> CadShape:
    """The plane face within a wire."""
    return BRepBuilderAPI_MakeFace(wire, True).Face()


def sew_faces(faces: Iterable[CadShape]) -> CadShape:
    """The solid that faces enclose."""
    sewing = BRepBuilderAPI_Sewing(TOUCHING_MM)
    for each in faces:
        sewing.Add(each)
    sewing.Perform()
    shell = TopoDS.Shell(subshapes(sewing.SewedShape(), TopAbs_SHELL)[0])
    solid = BRepBuilderAPI_MakeSolid(shell).Solid()
    BRepLib.OrientClosedSolid_s(solid)
    return solid


def _cad_array(array_type: Any, values: np.ndarray) -> CadShape:
    """Numbers as an array of Open CASCADE."""
    array = array_type(1, len(values))
    for k, value in enumerate(values.tolist(), 1):
        array.SetValue(k, value)
    return array


def extrude_wire(wire: CadShape, low: float, high: float) -> CadShape:
    """The prism between two heights with a wire in the plane z = 0 as outline."""
    along = gp_Trsf()
    along.SetTranslation(gp_Vec(0.0, 0.0, low))
    body = BRepPrimAPI_MakePrism(plane_face(wire), gp_Vec(0.0, 0.0, high - low)).Shape()
    return body.Moved(TopLoc_Location(along))


def fuse_solids(first: CadShape, second: CadShape) -> CadShape:
    return BRepAlgoAPI_Fuse(first, second).Shape()


def subtract_solid(first: CadShape, second: CadShape) -> CadShape:
    """The first solid without the second."""
    return BRepAlgoAPI_Cut(first, second).Shape()


def subshapes(shape: CadShape, kind: CadShape) -> list[CadShape]:
    """The distinct faces (``FACE``), edges or solids of a shape."""
    shapes = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    TopExp.MapShapes_s(shape, kind, shapes)
    return [shapes.FindKey(k) for k in range(1, shapes.Extent() + 1)]


def shape_counts_and_volume(shape: CadShape) -> dict[str, float]:
    """Numbers of solids, faces and edges of a shape, and its volume [mm³]."""
    return {
        "solids": len(subshapes(shape, SOLID)),
        "faces": len(subshapes(shape, FACE)),
        "edges": len(subshapes(shape, EDGE)),
        "volume_mm3": shape_volume(shape),
    }


def shape_volume(shape: CadShape) -> float:
    """Volume of a shape [mm³]; negative if faces look inwards."""
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, True)
    return float(properties.Mass())


def has_valid_solids(shape: CadShape, solid_count: int = 1) -> bool:
    """Whether a shape has ``solid_count`` closed, valid solids whose faces look outwards."""
    solids = subshapes(shape, SOLID)
    valid = len(solids) == solid_count and bool(BRepCheck_Analyzer(shape).IsValid())
    return valid and all(shape_volume(each) > 0.0 for each in solids)
