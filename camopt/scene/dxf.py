"""Closed outlines in a DXF file, such as the profile of a cam, read by ezdxf."""

from collections.abc import Iterable, Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, join_words
from camopt.core.numerics import ComplexArray, FloatArray
from camopt.core.storage.files import read_bytes
from camopt.core.storage.home import ensure_home_folder

PROFILE_LAYER = "PROFILE"
JOINING_GAP = 1e-3  # mm: ends at most this far apart are joined
MOST_ENTITIES = 100_000  # entities of a drawing with its blocks expanded, and vertices of polylines
MOST_EDGE_PAIRS = 10_000_000  # comparisons of lines that end at the same point
ELLIPSE_SAGITTA = 5e-4  # mm: largest distance of an ellipse from the chords between its points
SPLINE_POINTS = 16  # points of a spline between two knots
REMEDY = "export the profile as DXF with lines, arcs{} that close, and the axis at 0, 0"


class DrawnOutline(NamedTuple):
    """A closed line through vertices, x + iy in mm; the last vertex joins the first.

    ``bulges`` are tan(α/4) for an arc of angle α, positive anticlockwise, and 0 for a line.
    """

    vertices: ComplexArray
    bulges: FloatArray

    @property
    def chords(self) -> ComplexArray:
        return np.roll(self.vertices, -1) - self.vertices

    @property
    def arc_middles(self) -> ComplexArray:
        """The middle of each arc."""
        return self.vertices + self.chords * (0.5 - 0.5j * self.bulges)

    @property
    def corner_angles(self) -> FloatArray:
        """Change of direction at each vertex [rad]."""
        half = np.exp(2j * np.arctan(self.bulges))
        leaving, arriving = self.chords / half, np.roll(self.chords * half, 1)
        return np.abs(np.angle(leaving / arriving))

    @property
    def signed_area(self) -> float:
        """Area of the polygon through vertices and middles [mm²], positive if it runs anticlockwise."""
        points = np.column_stack([self.vertices, self.arc_middles]).ravel()
        return float((points.conjugate() * np.roll(points, -1)).imag.sum() / 2)

    @property
    def reversed_outline(self) -> "DrawnOutline":
        """The outline in the other direction, from the same vertex."""
        return DrawnOutline(np.roll(self.vertices[::-1], 1), -self.bulges[::-1])


class LayerOutline(NamedTuple):
    """A closed outline, and the layer of its first part."""

    layer: str
    outline: DrawnOutline


def read_dxf_profile(path: Path) -> DrawnOutline:
    """The profile in a DXF file: the outline on the layer PROFILE, or else the one that reaches farthest.

    Raises
    ------
    ValueError
        With a message on what is wrong with the file.
    OSError
        If the file cannot be read.
    """
    try:
        read_bytes(path)  # refuses pipes and huge files
    except BadInput as trouble:
        raise ValueError(f"it must be {trouble.mistakes[0].allowed}") from None
    drawn, unit_mm = read_dxf_outlines(path, with_splines=False)
    largest = max(
        (each.outline for each in drawn), key=lambda each: float(np.abs([each.vertices, each.arc_middles]).max())
    )
    return largest._replace(vertices=largest.vertices * (unit_mm or 1.0))


def read_dxf_outlines(
    path: Path, layer: str | None = None, *, with_splines: bool
) -> tuple[list[LayerOutline], float | None]:
    """Closed outlines in a DXF file, and its unit [mm], None if it names none. Lengths are in that unit.

    They are the outlines on a layer. Without one, they are those on the layer PROFILE, or all if it has none.
    Splines and ellipses become lines between points on them.

    Raises
    ------
    ValueError
        With a message on what is wrong with the file.
    OSError
        If the file cannot be read.
    """
    ensure_home_folder()
    from ezdxf import disassemble, units, upright
    from ezdxf.enums import InsertUnits
    from ezdxf.filemanagement import readfile
    from ezdxf.lldxf.const import DXFError

    try:
        document = readfile(path)
        _check_block_nesting(document)
        entities: list[Any] = [*disassemble.recursive_decompose(document.modelspace())]
        upright.upright_all(entities)
        drawn, unit_mm = _entities_on_layer(entities, layer), None
        if document.units:
            factor = units.conversion_factor(InsertUnits(document.units), InsertUnits.Millimeters)
            unit_mm = float(f"{factor:.9g}")
        outlines = [
            each
            for each in _closed_outlines(drawn, with_splines, unit_mm or 1.0)
            if each.outline.bulges.any() or each.outline.vertices.size > 2
        ]
    except RecursionError:
        raise ValueError("its blocks are nested too deep") from None
    except (DXFError, UnicodeError, LookupError, TypeError, ArithmeticError, OSError) as trouble:
        if isinstance(trouble, OSError) and trouble.errno is not None:
            raise
        remedy = REMEDY.format(", polylines or splines" if with_splines else " or polylines")
        raise ValueError(f"it is damaged, or not a DXF file ({trouble}); {remedy}") from None
    if not outlines:
        kinds = ", ".join(sorted({each.dxftype() for each in drawn})) or "nothing"
        curves = "lines, arcs, polylines or splines" if with_splines else "arcs, lines or polylines"
        raise ValueError(f"it has no closed outline of {curves}; it has {kinds}")
    return outlines, unit_mm


def _entities_on_layer(entities: list[Any], layer: str | None) -> list[Any]:
    """Entities on a layer; without one, those on the layer PROFILE, or all."""
    found = [each for each in entities if each.dxf.layer.upper() == (layer or PROFILE_LAYER).upper()]
    if layer is not None and not found:
        layers = join_words(sorted({each.dxf.layer for each in entities}))
        raise ValueError(f"it has nothing on the layer {layer!r}, but on {layers}")
    return found or entities


def _check_block_nesting(document: Any) -> None:
    """Raise ValueError if a block contains itself, or the expanded blocks have too many entities.

    Blocks are counted after the blocks they insert, since nesting multiplies the entities.
    """
    blocks = {block.block_record_handle: block for block in document.blocks}
    inserted = {key: [_inserted_block_handles(entity) for entity in block] for key, block in blocks.items()}
    order = TopologicalSorter({key: sorted(set().union(*inner)) for key, inner in inserted.items()})
    counts: dict[str, int] = {}
    try:
        for key in order.static_order():
            pairs = zip(blocks.get(key, ()), inserted.get(key, ()), strict=True)
            counts[key] = sum(
                _count_entities_vertices_and_points(entity) * (1 + sum(counts[k] for k in inner))
                for entity, inner in pairs
            )
    except CycleError as cycle:
        raise ValueError(f'its block "{blocks[cycle.args[1][0]].name}" contains itself') from None
    if counts[document.modelspace().block_record_handle] > MOST_ENTITIES:
        raise ValueError(f"it has more than {MOST_ENTITIES:,} entities and vertices, counting inserted blocks")


def _inserted_block_handles(entity: Any) -> set[str]:
    """The handles of the blocks that an entity inserts; a table has only the name of its block."""
    from ezdxf.protocols import referenced_blocks

    handles = set(referenced_blocks(entity))
    if entity.dxf.hasattr("geometry") and entity.dxf.geometry in entity.doc.blocks:
        handles.add(entity.doc.blocks.get(entity.dxf.geometry).block_record_handle)
    return handles


def _count_entities_vertices_and_points(entity: Any) -> int:
    """Number of entities, or of vertices of a polyline or points of a spline, in an entity."""
    if entity.dxftype() == "INSERT":
        return max(1, int(entity.dxf.row_count * entity.dxf.column_count)) * (1 + len(entity.attribs))
    if entity.dxftype() == "SPLINE":
        return max(1, int(entity.control_point_count()), int(entity.fit_point_count()))
    return len(entity) if "POLYLINE" in entity.dxftype() else 1


def _closed_outlines(entities: Iterable[Any], with_splines: bool, unit_mm: float) -> Iterator[LayerOutline]:
    """Closed outlines: circles, closed polylines and splines, and chains of open ones, arcs and lines."""
    from ezdxf import edgeminer, edgesmith

    loose, gap = [], JOINING_GAP / unit_mm
    for each in entities:
        if each.dxftype() == "CIRCLE":
            centre, radius = complex(*each.dxf.center.vec2), each.dxf.radius
            outline = DrawnOutline(np.array([centre + radius, centre - radius]), np.ones(2))
            yield LayerOutline(each.dxf.layer, outline)
        elif each.dxftype() in ("LWPOLYLINE", "POLYLINE"):
            corners = _polyline_vertices_and_bulges(each)
            if each.is_closed or abs(corners[0, 0] - corners[-1, 0]) <= gap:
                yield LayerOutline(each.dxf.layer, _outline_without_repeated_vertices(corners, gap))
            else:
                loose.append(each)
        elif with_splines and each.dxftype() in ("SPLINE", "ELLIPSE"):
            points = _ellipse_or_spline_points(each, unit_mm)
            if abs(points[0] - points[-1]) <= gap:
                outline = _outline_without_repeated_vertices(np.column_stack([points, np.zeros(points.size)]), gap)
                yield LayerOutline(each.dxf.layer, outline)
            else:
                loose.append(each)
        elif each.dxftype() in ("LINE", "ARC"):
            loose.append(each)
    edges = list(edgesmith.edges_from_entities_2d(loose, gap_tol=gap))
    if not edges:
        return
    ends = np.array([end.vec2 for edge in edges for end in (edge.start, edge.end)])
    _, meeting = np.unique(np.round(ends / gap), axis=0, return_counts=True)
    if (meeting**2).sum() > MOST_EDGE_PAIRS:
        raise ValueError(f"{meeting.max():,} of its arcs and lines end at the same point")
    for chain in edgeminer.find_all_simple_chains(edgeminer.Deposit(edges, gap_tol=gap)):
        if edgeminer.is_loop(chain, gap_tol=gap):
            polyline = edgesmith.lwpolyline_from_chain(chain, max_sagitta=ELLIPSE_SAGITTA / unit_mm)
            corners = _polyline_vertices_and_bulges(polyline)
            yield LayerOutline(chain[0].payload.dxf.layer, _outline_without_repeated_vertices(corners, gap))


def _ellipse_or_spline_points(curve: Any, unit_mm: float) -> ComplexArray:
    """Points on an ellipse, or on a spline within the range of its parameter, which unclamped knots exceed."""
    if curve.dxftype() == "ELLIPSE":
        return np.array([complex(*point.vec2) for point in curve.flattening(ELLIPSE_SAGITTA / unit_mm)])
    spline = curve.construction_tool()
    knots, degree = np.array(spline.knots()), spline.degree
    breaks = np.unique(knots[degree : knots.size - degree])
    shares = np.arange(SPLINE_POINTS) / SPLINE_POINTS
    places = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * shares).ravel(), breaks[-1])
    return np.array([complex(*point.vec2) for point in spline.points(places.tolist())])


def _polyline_vertices_and_bulges(polyline: Any) -> ComplexArray:
    """Vertices of a polyline, each with the bulge after it, (n, 2)."""
    if polyline.dxftype() == "LWPOLYLINE":
        rows = [(complex(x, y), bulge) for x, y, bulge in polyline.get_points("xyb")]
    else:
        rows = [(complex(*each.dxf.location.vec2), each.dxf.bulge) for each in polyline.vertices]
    return np.array(rows, dtype=complex).reshape(-1, 2)


def _outline_without_repeated_vertices(
    vertices_and_bulges: ComplexArray, least_vertex_distance: float
) -> DrawnOutline:
    """The outline through corners; of corners at the same point the last counts."""
    distinct = np.abs(np.roll(vertices_and_bulges[:, 0], -1) - vertices_and_bulges[:, 0]) > least_vertex_distance
    return DrawnOutline(vertices_and_bulges[distinct, 0], vertices_and_bulges[distinct, 1].real)
