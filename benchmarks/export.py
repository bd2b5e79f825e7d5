"""How far files are from the true cams: deviation asked for, proved, and measured on the DXF that ezdxf reads back.

    python benchmarks/export.py [random cams of each mechanism, 10]

The shipped scenes, then random cams of each mechanism that can be made. Measured is the largest distance, both
ways, between dense points on the curve in the file, as ezdxf flattens it, and 40,001 points of the true curve.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import ezdxf
import numpy as np
from scipy.spatial import cKDTree

from camopt import BadInput, Scene, cam_points, export, find_scene, shipped_scenes

CHORD, POINTS, FLAT = 0.001, 40_001, 1e-7
LONG = 0.05  # mm: each point is held against every longer side
NEAREST = 24  # shorter ones: arcs as short as a few µm come in several pieces
DRAWN = ("arcs", "spline", "polyline")
FOLLOWERS: dict[str, dict[str, Any]] = {
    "knife": {"motion": "translating", "contact": "knife"},
    "roller": {"motion": "translating", "contact": "roller", "roller_radius": (5, 20), "offset": (-15, 15)},
    "flat": {"motion": "translating", "contact": "flat"},
    "spherical": {"motion": "translating", "contact": "spherical", "face_radius": (20, 120)},
    "arm": {"motion": "oscillating", "contact": "roller", "roller_radius": (5, 15), "arm_length": (80, 120),
            "centre_distance": (110, 150)},
    "swinging face": {"motion": "oscillating", "contact": "flat", "face_offset": (-10, 15),
                      "centre_distance": (110, 150)},
    "groove": {"motion": "translating", "contact": "roller", "roller_radius": (3, 8)},
    "swinging groove": {"motion": "oscillating", "contact": "roller", "roller_radius": (3, 8),
                        "arm_length": (80, 120)},
}  # fmt: skip
LAWS = ("cycloidal", "harmonic", "modified-sine", "poly345", "poly4567", "modified-trapezoid", "parabolic")


def random_scene(name: str, random: np.random.Generator) -> Scene:
    """A cam of a mechanism with random sizes, angles and laws."""
    ranges = FOLLOWERS[name].items()
    follower = {key: float(random.uniform(*value)) if isinstance(value, tuple) else value for key, value in ranges}
    angles = random.uniform(50, 110, 4)
    angles *= 360 / angles.sum()
    lift = random.uniform(5, 25)
    size = float(random.uniform(30, 90))
    moves = [{"segment": kind, "lift": float(lift), "law": str(random.choice(LAWS))} for kind in ("rise", "return")]
    order = (moves[0], {"segment": "dwell"}, moves[1], {"segment": "dwell"})
    groove, disc = {"form": "cylindrical", "mean_radius": size}, {"form": "disc", "base_radius": size}
    motion = [{**each, "angle": float(angle)} for each, angle in zip(order, angles, strict=True)]
    return Scene.from_dict({"cam": groove if "groove" in name else disc, "follower": follower, "motion": motion})


def scenes(count: int) -> Iterator[tuple[str, Scene]]:
    yield from ((name, find_scene(name)) for name in shipped_scenes())
    random = np.random.default_rng(15)
    for name in FOLLOWERS:
        found = 0
        while found < count:
            try:
                scene = random_scene(name, random)
                with TemporaryDirectory() as folder:
                    export(scene, Path(folder) / "cam.dxf", chord=0.1)
            except BadInput:
                continue  # it cannot be made
            found += 1
            yield f"{name} {found}", scene


def read_back(file: Path, layer: str) -> np.ndarray:
    """Dense points of the curve on a layer, element by element."""
    (entity,) = ezdxf.readfile(file).modelspace().query(f'*[layer=="{layer}"]')
    if entity.dxftype() != "LWPOLYLINE":
        return np.array([complex(p.x, p.y) for p in entity.flattening(FLAT)])
    found = [np.array([complex(*entity.get_points()[0][:2])])]
    for part in entity.virtual_entities():
        if part.dxftype() == "LINE":
            found.append(np.array([complex(*part.dxf.start.vec2), complex(*part.dxf.end.vec2)]))
        else:  # an arc runs anticlockwise, whichever way the polyline does
            arc = np.array([complex(p.x, p.y) for p in part.flattening(FLAT)])
            onwards = np.abs(arc[0] - found[-1][-1]) < np.abs(arc[-1] - found[-1][-1])
            found.append(arc if onwards else arc[::-1])
    return np.concatenate(found)


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """The largest distance of points from the chain through others: from all of its sides that may be near."""
    middles, halves = (other[:-1] + other[1:]) / 2, np.abs(np.diff(other)) / 2
    long = halves > LONG
    found = np.full(one.size, np.inf)
    near = np.flatnonzero(~long)
    if near.size:
        tree = cKDTree(np.column_stack([middles[near].real, middles[near].imag]))
        sides = near[
            tree.query(np.column_stack([one.real, one.imag]), k=min(NEAREST, near.size))[1].reshape(one.size, -1)
        ]
        found = np.minimum(found, to_sides(one[:, None], other[sides], other[sides + 1]).min(axis=1))
    for k in np.flatnonzero(long):
        found = np.minimum(found, to_sides(one, other[k], other[k + 1]))
    return float(found.max())


def to_sides(points: np.ndarray, a: Any, b: Any) -> np.ndarray:
    along = b - a
    square = np.square(np.abs(along)) + 1e-30
    share = np.clip(((points - a) * along.conjugate()).real / square, 0.0, 1.0)
    return np.abs(points - a - share * along)


def measured(scene: Scene, file: Path, curve: str) -> float:
    drawn = read_back(file, curve.upper())
    angles = np.unique(np.append(np.linspace(0.0, 360.0, POINTS), np.cumsum([s.angle for s in scene.motion])))
    points = cam_points(scene, angles[angles <= 360.0])
    true = points[f"{curve}_x_mm"] + 1j * points[f"{curve}_y_mm"]
    return max(apart(drawn, true), apart(true, drawn))


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    worst = dict.fromkeys(DRAWN, 0.0)
    print(f"deviation asked for: {CHORD} mm; elements, mm proved, mm measured, seconds of CPU of the export")
    with TemporaryDirectory() as folder:
        for name, scene in scenes(count):
            cells = []
            for kind in DRAWN:
                file, start = Path(folder) / "cam.dxf", process_time()
                found = export(scene, file, curves=kind, chord=CHORD)
                seconds = process_time() - start
                curve = next(each for each in found.curves if each.startswith("profile"))
                elements, _, proved = found.curves[curve]
                off = measured(scene, file, curve)
                worst[kind] = max(worst[kind], off / proved)
                cells.append(f"{kind} {elements:4d} {proved:.6f} {off:.6f} {seconds:5.2f}")
            print(f"{name:24s} {'   '.join(cells)}", flush=True)
    print("largest measured ÷ proved:", ", ".join(f"{kind} {value:.4f}" for kind, value in worst.items()))


if __name__ == "__main__":
    main()
