"""Random machines of cheap scenes with outlines, and their distances by shapely."""

from typing import Any

import numpy as np
import shapely

from camopt.scene.machine import Machine

KNIFE: dict[str, Any] = {
    "cam": {"form": "disc", "base_radius": 40, "rpm": 90.0},
    "follower": {"motion": "translating", "contact": "knife"},
    "motion": [
        {"segment": "rise", "angle": 120, "lift": 20, "law": "cycloidal"},
        {"segment": "return", "angle": 120, "lift": 20, "law": "cycloidal"},
        {"segment": "dwell", "angle": 120},
    ],
}
"""The least scene of a station: it has a speed and no forces."""
LAWS = ("cycloidal", "poly345", "harmonic", "modified-sine", "constant-velocity")


def random_moves(rng: np.random.Generator, lift: float, laws=LAWS[:4]) -> list[dict[str, Any]]:
    """A rise, a dwell, a return and a dwell."""
    rise, high, back = (float(x) for x in rng.uniform(30.0, 100.0, 3))
    first, second = (str(x) for x in rng.choice(laws, 2))
    return [
        {"segment": "rise", "angle": rise, "lift": lift, "law": first},
        {"segment": "dwell", "angle": high},
        {"segment": "return", "angle": back, "lift": lift, "law": second},
        {"segment": "dwell", "angle": 360.0 - rise - high - back},
    ]


def sliding_scene(moves: list[dict[str, Any]]) -> dict[str, Any]:
    """A translating knife follower without dynamics."""
    follower = {"motion": "translating", "contact": "knife"}
    return {"cam": {"form": "disc", "base_radius": 40.0}, "follower": follower, "motion": moves}


def turning_scene(moves: list[dict[str, Any]]) -> dict[str, Any]:
    """An oscillating roller follower without dynamics."""
    follower = {"motion": "oscillating", "contact": "roller", "roller_radius": 8.0}
    follower |= {"arm_length": 80.0, "centre_distance": 100.0}
    return {"cam": {"form": "disc", "base_radius": 40.0}, "follower": follower, "motion": moves}


def random_outline(rng: np.random.Generator, centre: complex, most_points: int = 7) -> list[list[float]]:
    """A point, a line or a star-shaped polygon, most often not convex, about a centre."""
    count = int(rng.integers(1, most_points))
    directions = np.sort(rng.uniform(0.0, 2.0 * np.pi, count))
    if count > 2:  # no gap of half a turn, so that the polygon has its centre inside
        directions = 2.0 * np.pi * (np.arange(count) + rng.uniform(0.0, 0.45, count)) / count
    points = centre + rng.uniform(3.0, 12.0, count) * np.exp(1j * directions)
    return [[float(p.real), float(p.imag)] for p in points]


def random_station(rng: np.random.Generator, name: str, centre: complex) -> dict[str, Any]:
    """A station whose tool slides or turns."""
    turns = bool(rng.integers(2))
    moves = random_moves(rng, float(rng.uniform(5.0, 20.0)))
    how = (
        {"pivot": [float(x) for x in rng.uniform(-60.0, 60.0, 2)], "sense": str(rng.choice(["ccw", "cw"]))}
        if turns
        else {"direction": float(rng.uniform(0.0, 360.0))}
    )
    return how | {
        "name": name,
        "scene": (turning_scene if turns else sliding_scene)(moves),
        "phase": float(rng.uniform(-180.0, 180.0)),
        "ratio": int(rng.integers(1, 3)),
        "outline": random_outline(rng, centre),
        "outline_radius": float(rng.choice([0.0, 2.0])),
    }


def random_machine(rng: np.random.Generator, widest: float = 360.0) -> Machine:
    """Two tools, or a tool and a fixed body, with one clearance between them over a part of the turn."""
    apart = rng.uniform(15.0, 45.0) * np.exp(1j * rng.uniform(0.0, 6.28))
    start = float(rng.integers(-180, 180))
    width = float(rng.choice([widest, rng.uniform(20.0, widest)]))
    tables: dict[str, Any] = {
        "station": [random_station(rng, "a", 0.0)],
        "clear": [{"between": ["a", "b"], "at_least": 1.0, "angles": [start, start + width]}],
    }
    if rng.integers(3):
        tables["station"].append(random_station(rng, "b", apart))
    else:
        tables["body"] = [{"name": "b", "outline": random_outline(rng, apart), "outline_radius": 1.0}]
    return Machine.from_dict(tables)


def shapes(table: Any, lifts: np.ndarray) -> np.ndarray:
    """The outlines of a tool at lifts, or of a body, as shapes of shapely without their radius."""
    points = np.array([complex(*point) for point in table.outline])[None, :]
    if getattr(table, "pivot", None) is not None:
        sense, pivot = {"ccw": 1.0, "cw": -1.0}[table.sense], complex(*table.pivot)
        points = pivot + (points - pivot) * np.exp(1j * sense * np.radians(lifts))[:, None]
    else:
        direction = getattr(table, "direction", None)
        way = 0.0 if direction is None else np.exp(1j * np.radians(direction))
        points = points + way * lifts[:, None]
    places = np.stack([points.real, points.imag], axis=-1)
    make = {1: lambda p: shapely.points(p[:, 0]), 2: shapely.linestrings}.get(places.shape[1], shapely.polygons)
    return make(places)


def shapely_distances(first: Any, second: Any, lifts: np.ndarray, other_lifts: np.ndarray) -> np.ndarray:
    """Distances of two outlines at lifts."""
    between = shapely.distance(shapes(first, lifts), shapes(second, other_lifts))
    return np.maximum(between - first.outline_radius - second.outline_radius, 0.0)


def random_linear_machine(rng: np.random.Generator) -> Machine:
    """Up to three stations, and a clearance that is a sum of their lifts over a part of the turn."""
    names = "abc"[: int(rng.integers(1, 4))]
    tables = {
        "station": [
            {
                "name": name,
                "scene": sliding_scene(random_moves(rng, float(rng.uniform(5.0, 20.0)), LAWS)),
                "phase": float(rng.uniform(-180.0, 180.0)),
            }
            for name in names
        ]
    }
    start, width = float(rng.integers(-180, 180)), float(rng.uniform(5.0, 90.0))
    clearance = {
        "between": [*names],
        "along": [float(x) for x in rng.uniform(-2.0, 2.0, len(names))],
        "at_least": -1e3,
        "angles": [start, start + width],
    }
    return Machine.from_dict({**tables, "clear": [clearance]})


def with_required(machine: Machine, at_least: float) -> Machine:
    """The machine whose one clearance must be at least something else."""
    tables = machine.to_dict()
    return Machine.from_dict({**tables, "clear": [{**tables["clear"][0], "at_least": float(at_least)}]})


def machine_with_circles_on_lines(
    gap: float, first_radius: float, second_radius: float
) -> tuple[Machine, float, float]:
    """Two circles that slide on parallel lines and pass each other; the gap of the lines and the sum of radii."""
    moves = [
        {"segment": "rise", "angle": 90, "lift": 30, "law": "cycloidal"},
        {"segment": "return", "angle": 90, "lift": 30, "law": "poly345"},
        {"segment": "dwell", "angle": 180},
    ]
    station = {"scene": sliding_scene(moves), "direction": 90}
    tables = {
        "station": [
            {**station, "name": "a", "outline": [[0, 0]], "outline_radius": first_radius},
            {**station, "name": "b", "outline": [[gap, 0]], "outline_radius": second_radius, "phase": 50},
        ],
        "clear": [{"between": ["a", "b"], "at_least": 10.0}],
    }
    return Machine.from_dict(tables), gap, first_radius + second_radius
