"""The profile of a cam in a DXF file: its closed outlines of arcs, lines and polylines, read by ezdxf."""

from collections.abc import Iterable, Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput
from camopt.core.numerics import ComplexArray, FloatArray
from camopt.core.storage.files import read_bytes
from camopt.core.storage.home import ensure_home_folder

PROFILE_LAYER = "PROFILE"
JOINING_GAP = 1e-3  # mm: ends at most this far apart are joined
MOST_ENTITIES = 100_000  # entities of a drawing with its blocks expanded, and vertices of polylines
MOST_EDGE_PAIRS = 10_000_000  # comparisons of lines that end at the same point


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
    def middles(self) -> ComplexArray:
        """The middle of each arc."""
        return self.vertices + self.chords * (0.5 - 0.5j * self.bulges)

    @property
    def corner_angles(self) -> FloatArray:
        """Change of direction at each vertex [rad]."""
        half = np.exp(2j * np.arctan(self.bulges))
        leaving, arriving = self.chords / half, np.roll(self.chords * half, 1)
        return np.abs(np.angle(leaving / arriving))

    @property
    def area(self) -> float:
        """Area of the polygon through vertices and middles [mm²], positive if it runs anticlockwise."""
        points = np.column_stack([self.vertices, self.middles]).ravel()
        return float((points.conjugate() * np.roll(points, -1)).imag.sum() / 2)

    @property
    def reversed_outline(self) -> "DrawnOutline":
        """The outline in the other direction, from the same vertex."""
        return DrawnOutline(np.roll(self.vertices[::-1], 1), -self.bulges[::-1])


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
    ensure_home_folder()
    from ezdxf import disassemble, upright
    from ezdxf.filemanagement import readfile
    from ezdxf.lldxf.const import DXFError

    try:
        document = readfile(path)
        _check_block_nesting(document)
        entities: list[Any] = [*disassemble.recursive_decompose(document.modelspace())]
        upright.upright_all(entities)
        drawn = [each for each in entities if each.dxf.layer.upper() == PROFILE_LAYER] or entities
        outlines = [each for each in _closed_outlines(drawn) if each.bulges.any() or each.vertices.size > 2]
    except RecursionError:
        raise ValueError("its blocks are nested too deep") from None
    except (DXFError, UnicodeError, LookupError, TypeError, ArithmeticError) as trouble:
        raise ValueError(f"it is damaged, or not a DXF file ({trouble})") from None
    if not outlines:
        kinds = ", ".join(sorted({each.dxftype() for each in drawn})) or "nothing"
        raise ValueError(f"it has no closed outline of arcs, lines or polylines; it has {kinds}")
    largest = max(outlines, key=lambda each: float(np.abs([each.vertices, each.middles]).max()))
    return largest._replace(vertices=largest.vertices * _unit_in_mm(document.units))


def _check_block_nesting(document: Any) -> None:
    """Raise ValueError if a block contains itself, or the expanded blocks have too many entities.

    Blocks are counted after the blocks they insert, since nesting multiplies the entities.
    """
    blocks = {block.block_record_handle: block for block in document.blocks}
    inserted = {key: [_inserted_blocks(entity) for entity in block] for key, block in blocks.items()}
    order = TopologicalSorter({key: sorted(set().union(*inner)) for key, inner in inserted.items()})
    counts: dict[str, int] = {}
    try:
        for key in order.static_order():
            pairs = zip(blocks.get(key, ()), inserted.get(key, ()), strict=True)
            counts[key] = sum(
                _entity_count(entity) * (1 + sum(counts[k] for k in inner)) for entity, inner in pairs
            )
    except CycleError as cycle:
        raise ValueError(f'its block "{blocks[cycle.args[1][0]].name}" contains itself') from None
    if counts[document.modelspace().block_record_handle] > MOST_ENTITIES:
        raise ValueError(f"it has more than {MOST_ENTITIES:,} entities and vertices, counting inserted blocks")


def _inserted_blocks(entity: Any) -> set[str]:
    """The handles of the blocks that an entity inserts; a table has only the name of its block."""
    from ezdxf.protocols import referenced_blocks

    handles = set(referenced_blocks(entity))
    if entity.dxf.hasattr("geometry") and entity.dxf.geometry in entity.doc.blocks:
        handles.add(entity.doc.blocks.get(entity.dxf.geometry).block_record_handle)
    return handles


def _entity_count(entity: Any) -> int:
    """Number of entities, or of vertices of a polyline, in an entity."""
    if entity.dxftype() == "INSERT":
        return max(1, int(entity.dxf.row_count * entity.dxf.column_count)) * (1 + len(entity.attribs))
    return len(entity) if "POLYLINE" in entity.dxftype() else 1


def _unit_in_mm(unit: int) -> float:
    """Length of the drawing's unit [mm]; 1 if it has none."""
    from ezdxf import units
    from ezdxf.enums import InsertUnits

    named = InsertUnits(unit), InsertUnits(units.MM)
    return float(f"{units.conversion_factor(*named):.9g}") if unit else 1.0


def _closed_outlines(entities: Iterable[Any]) -> Iterator[DrawnOutline]:
    """Closed outlines: circles, closed polylines, and chains of arcs and lines."""
    from ezdxf import edgeminer, edgesmith

    loose = []
    for each in entities:
        if each.dxftype() == "CIRCLE":
            centre, radius = complex(*each.dxf.center.vec2), each.dxf.radius
            yield DrawnOutline(np.array([centre + radius, centre - radius]), np.ones(2))
        elif each.dxftype() in ("LWPOLYLINE", "POLYLINE"):
            corners = _polyline_corners(each)
            if each.is_closed or abs(corners[0, 0] - corners[-1, 0]) <= JOINING_GAP:
                yield _outline_through(corners)
            else:
                loose.append(each)
        elif each.dxftype() in ("LINE", "ARC"):
            loose.append(each)
    edges = list(edgesmith.edges_from_entities_2d(loose, gap_tol=JOINING_GAP))
    if not edges:
        return
    ends = np.array([end.vec2 for edge in edges for end in (edge.start, edge.end)])
    _, meeting = np.unique(np.round(ends / JOINING_GAP), axis=0, return_counts=True)
    if (meeting**2).sum() > MOST_EDGE_PAIRS:
        raise ValueError(f"{meeting.max():,} of its arcs and lines end at the same point")
    for chain in edgeminer.find_all_simple_chains(edgeminer.Deposit(edges, gap_tol=JOINING_GAP)):
        if edgeminer.is_loop(chain, gap_tol=JOINING_GAP):
            yield _outline_through(_polyline_corners(edgesmith.lwpolyline_from_chain(chain)))


def _polyline_corners(polyline: Any) -> ComplexArray:
    """Vertices of a polyline, each with the bulge after it, (n, 2)."""
    if polyline.dxftype() == "LWPOLYLINE":
        rows = [(complex(x, y), bulge) for x, y, bulge in polyline.get_points("xyb")]
    else:
        rows = [(complex(*each.dxf.location.vec2), each.dxf.bulge) for each in polyline.vertices]
    return np.array(rows, dtype=complex).reshape(-1, 2)


def _outline_through(corners: ComplexArray) -> DrawnOutline:
    """The outline through corners; of corners at the same point the last counts."""
    distinct = np.abs(np.roll(corners[:, 0], -1) - corners[:, 0]) > JOINING_GAP
    return DrawnOutline(corners[distinct, 0], corners[distinct, 1].real)
