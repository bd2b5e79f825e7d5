"""Binary STL for 3D printers and viewers: the solid of a cam in triangles, in mm, in single precision.

Lines along the profile of a disc cam are proved to be within ``chord``. Open CASCADE divides round bores and hubs,
and the walls of a groove, within the same chord.
"""

from pathlib import Path

import numpy as np
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.StlAPI import StlAPI_Writer

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.storage.files import atomically_written_file
from camopt.core.storage.version import VERSION
from camopt.show.exporting.solid import solid_of
from camopt.show.exporting.workpiece import Export, Workpiece
from camopt.solve.contour.path_fitting import DEFAULT_CHORD, SHORTEST_CHORD, check_path_options

TITLE_BYTES, HEADER_BYTES = 80, 84  # bytes of the title, and before the first triangle
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
MESH_SHARE = 0.9  # share of the chord for the mesh; the rest is for approximate walls and rounding
SIZE_ANGLES = 361  # cam angles for the size of a cam
MESH_ANGLE = 0.35  # rad between neighbours, for round parts that are small beside the chord
FLOAT32_ERROR = 2.0**-24 * 2.0**0.5  # shift of a point by single precision, relative to the largest coordinate


def write(work: Workpiece, path: Path, chord: float = DEFAULT_CHORD) -> Export:
    """Write the solid of a cam with a thickness. Deviations include the rounding of the file."""
    check_path_options("polyline", chord)
    angles = np.linspace(0.0, 2.0 * np.pi, SIZE_ANGLES)
    points = [curve.evaluate_by_span(angles, curve.points) for curve in work.curves().values()]
    aim = max(MESH_SHARE * chord - FLOAT32_ERROR * float(np.abs(points).max()), SHORTEST_CHORD)
    solid = solid_of(work, aim, "polyline")
    BRepMesh_IncrementalMesh(solid.shape, aim, False, MESH_ANGLE)
    with atomically_written_file(path) as partial:
        writer = StlAPI_Writer()
        writer.ASCIIMode = False
        if not writer.Write(solid.shape, str(partial)):
            raise OSError(f"{path}: Open CASCADE could not write the file")
        with partial.open("r+b") as file:
            file.write(f"camopt {VERSION}, lengths in mm".encode("ascii").ljust(TITLE_BYTES))
        triangles = read_triangles(partial)
        if not is_watertight(triangles):
            why = "larger: STL has single precision, in which such close corners are equal"
            raise BadInput([Mistake("camopt", "chord", chord, why)])
    off = float(np.abs(triangles[..., :2]).max()) * FLOAT32_ERROR
    curves = {name: each._replace(deviation_mm=each.deviation_mm + off) for name, each in solid.curves.items()}
    return Export(
        path, curves, solid.about | {"triangles": len(triangles), "volume_mm3": enclosed_volume(triangles)}
    )


def read_triangles(path: Path) -> FloatArray:
    """Corners of the triangles of a binary file [mm], (n, 3, 3)."""
    return np.asarray(np.fromfile(path, dtype=TRIANGLE, offset=HEADER_BYTES)["corners"], dtype=float)


def is_watertight(triangles: FloatArray) -> bool:
    """Whether each edge of a triangle belongs to exactly one other triangle, in the opposite direction."""
    _, corners = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    corners = corners.reshape(-1, 3)
    edges = np.concatenate([corners[:, [k, (k + 1) % 3]] for k in range(3)])
    there, back = (np.unique(ends, axis=0, return_counts=True) for ends in (edges, edges[:, ::-1]))
    return bool(np.array_equal(there[0], back[0]) and np.array_equal(there[1], back[1]) and (there[1] == 1).all())


def enclosed_volume(triangles: FloatArray) -> float:
    """Volume within closed triangles [mm³], by the divergence theorem."""
    a, b, c = triangles.swapaxes(0, 1)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
