"""How far solids are from the true cams: STEP files that Open CASCADE reads back, and the triangles of STL files.

    python benchmarks/solids.py [random cams of each mechanism, 10]

The cams of ``export.py``, as parts. The volume is held against the mass that camopt integrates over the turn, and
the lower edges of a disc against 40,001 points of its true profile, both ways. Of a groove the distance is that
told.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np
import shapely
from export import CHORD, POINTS, scenes
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.STEPControl import STEPControl_Reader
from OCP.TopoDS import TopoDS

from camopt import Scene, cam_points, evaluate, export
from camopt.show.exporting import shapes
from camopt.show.exporting.step import silence_output
from camopt.show.exporting.stl import enclosed_volume, is_watertight, read_triangles

PLATE = {"thickness": 20, "bore": 16, "keyway_width": 5, "keyway_depth": 2.3, "hub_diameter": 24, "hub_length": 35}
CYLINDER = {"thickness": 100, "bore": 10, "groove_depth": 8}
BORE = 12.5  # mm: what is further from the axis is the profile
DENSE = 60_000  # points on the edges read back
DENSITY = 7800  # kg/m³


def as_part(scene: Scene) -> Scene:
    sizes = PLATE if scene.cam.form == "disc" else CYLINDER
    return scene.replace(part={**sizes, "density": DENSITY}, outputs=["cam_mass_kg"])


def read_back(file: Path) -> shapes.CadShape:
    reader = STEPControl_Reader()
    with silence_output():
        reader.ReadFile(str(file))
        reader.TransferRoots()
    return reader.OneShape()


def lower_edges(solid: shapes.CadShape) -> Iterator[np.ndarray]:
    """Dense points (n, 2) of each edge of the profile of a disc cam at z = 0."""
    curves = [BRepAdaptor_Curve(TopoDS.Edge(edge)) for edge in shapes.subshapes(solid, shapes.EDGE)]
    ends = [[curve.Value(u) for u in (curve.FirstParameter(), curve.LastParameter())] for curve in curves]
    pairs = zip(curves, ends, strict=True)
    lower = [curve for curve, (a, b) in pairs if a.Z() == b.Z() == 0.0 and np.hypot(a.X(), a.Y()) > BORE]
    for curve in lower:
        places = np.linspace(curve.FirstParameter(), curve.LastParameter(), DENSE // len(lower)).tolist()
        yield np.array([[p.X(), p.Y()] for p in map(curve.Value, places)])


def furthest(points: np.ndarray, lines: list[np.ndarray]) -> float:
    """The largest distance of points from lines."""
    sides = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    tree = shapely.STRtree(shapely.linestrings(sides))
    return float(tree.query_nearest(shapely.points(points), return_distance=True, all_matches=False)[1].max())


def off_profile(scene: Scene, solid: shapes.CadShape) -> float:
    """The largest distance between the edges read back and the true profile, both ways, mm."""
    angles = np.unique(np.append(np.linspace(0.0, 360.0, POINTS), np.cumsum([s.angle for s in scene.motion])))
    points = cam_points(scene, angles[angles <= 360.0])
    true = np.column_stack([points["profile_x_mm"], points["profile_y_mm"]])
    edges = list(lower_edges(solid))
    return max(furthest(true[::8], edges), furthest(np.concatenate(edges)[::12], [true]))


def step_row(scene: Scene, file: Path, curves: str, expected: float) -> tuple[str, float, float]:
    """What is shown of a STEP file, its error of volume, and its distance measured over that proved."""
    start = perf_counter()
    told = export(scene, file, curves=curves, chord=CHORD)
    seconds, solid = perf_counter() - start, read_back(file)
    assert shapes.has_valid_solids(solid)
    off = abs(shapes.shape_volume(solid) / expected - 1.0)
    proved = told.curves["profile"].deviation_mm if told.curves else told.about["wall_deviation_measured_mm"]
    found = off_profile(scene, solid) if told.curves else proved
    faces, size = len(shapes.subshapes(solid, shapes.FACE)), file.stat().st_size // 1000
    return f"{faces:4d} faces {size:4d} kB {off:.1e} {proved:.6f} {found:.6f} {seconds:5.2f}", off, found / proved


def stl_row(scene: Scene, file: Path, expected: float) -> tuple[str, float]:
    """What is shown of an STL file, and its error of volume."""
    start = perf_counter()
    export(scene, file, chord=CHORD)
    seconds, triangles = perf_counter() - start, read_triangles(file)
    assert is_watertight(triangles)
    off = abs(enclosed_volume(triangles) / expected - 1.0)
    return f"{len(triangles):6d} triangles {off:.1e} {seconds:5.2f}", off


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    volumes, shares = [], []
    print(f"deviation asked for: {CHORD} mm; error of volume, mm proved (of a groove: told), mm measured, seconds")
    with TemporaryDirectory() as folder:
        for name, plain in scenes(count):
            scene = as_part(plain)
            expected = evaluate(scene)["cam_mass_kg"] / DENSITY * 1e9
            rows = [step_row(scene, Path(folder) / "cam.step", curves, expected) for curves in ("arcs", "spline")]
            last = stl_row(scene, Path(folder) / "cam.stl", expected)
            volumes += [rows[0][1], rows[1][1], last[1]]
            shares += [row[2] for row in rows if scene.cam.form == "disc"]
            print(f"{name:24s} arcs {rows[0][0]}   spline {rows[1][0]}   {last[0]}", flush=True)
    print(f"largest error of volume: {max(volumes):.1e}; largest measured ÷ proved: {max(shares):.4f}")


if __name__ == "__main__":
    main()
