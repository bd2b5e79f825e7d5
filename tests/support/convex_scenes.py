"""Random scenes whose free laws are the solution of a convex problem."""

import math
from typing import Any

import numpy as np

from camopt import Scene

LAWS = ("poly345", "poly4567", "cycloidal", "modified-sine", "modified-trapezoid", "cycloidal-constant-velocity")
"""Laws of finite jerk, whose peaks limit the free laws."""
SHAPES = ("roller", "offset roller", "free offset", "flat face", "grooved cylinder")


def random_convex_scene(seed: int) -> Scene:
    """A scene with strokes and dwells, or with free moves, on a cam of any shape; sometimes with a train."""
    rng = np.random.default_rng(seed)
    shape, has_moves = SHAPES[seed % len(SHAPES)], seed % 3 == 2
    lift, rpm = float(rng.uniform(5.0, 70.0)), float(rng.uniform(30.0, 400.0))
    motion = _free_moves(rng, lift) if has_moves else _strokes_and_dwells(rng, lift)
    pressure = {key: float(rng.uniform(20.0, 40.0)) for key in ("pressure_angle", "pressure_angle_return")}
    roller = {"motion": "translating", "contact": "roller", "roller_radius": float(rng.uniform(4.0, 15.0))}
    tables: dict[str, Any] = {"name": f"{shape} {seed}", "motion": motion, "limits": pressure, "follower": roller}
    tables["cam"] = {"form": "disc", "rpm": rpm, "base_radius": 60.0}
    if shape == "offset roller":
        roller["offset"] = float(rng.uniform(-15.0, 15.0))
    elif shape == "free offset":
        start, stop = rng.uniform(10.0, 60.0, 2).tolist()
        tables["search"] = {"offset": {"start": -start, "stop": stop}}
    elif shape == "grooved cylinder":
        tables["cam"] = {"form": "cylindrical", "rpm": rpm, "mean_radius": 100.0}
    elif shape == "flat face":
        tables["follower"] = {"motion": "translating", "contact": "flat"}
        tables["limits"] = {"curvature_radius": float(rng.uniform(1.0, 10.0))}
        tables["limits"]["face_reach"] = float(rng.uniform(1.5, 2.5)) * lift
    if seed % 7 == 3:
        tables["train"] = [{"stage": "ratio", "ratio": float(rng.uniform(0.4, 2.5))}]
    if has_moves:
        shortest = math.radians(min(each["angle"] for each in motion if each["segment"] == "move"))
        per_second = math.radians(6.0 * rpm) / shortest
        tables["limits"]["acceleration"] = float(rng.uniform(3.5, 9.0)) * lift / 1e3 * per_second**2
        tables["limits"]["jerk"] = float(rng.uniform(40.0, 150.0)) * lift / 1e3 * per_second**3
    else:
        law = str(rng.choice(LAWS))
        peaks = {"peak_acceleration": float(rng.uniform(5.5, 9.0)), "peak_jerk": float(rng.uniform(60.0, 150.0))}
        tables["synthesis"] = peaks if rng.random() < 0.5 else dict.fromkeys(peaks, law)
    return Scene.from_dict(tables)


def _strokes_and_dwells(rng: np.random.Generator, lift: float) -> list[dict[str, Any]]:
    rise, fall = rng.uniform(50.0, 140.0, 2).tolist()
    rest = 360.0 - rise - fall
    top = float(rng.choice([0.0, rng.uniform(0.1, 0.9) * rest]))
    segments = [("rise", rise), ("dwell", top), ("return", fall), ("dwell", rest - top)]
    return [
        {"segment": kind, "angle": angle, **({} if kind == "dwell" else {"lift": lift, "law": "poly345"})}
        for kind, angle in segments
        if angle
    ]


def _free_moves(rng: np.random.Generator, lift: float) -> list[dict[str, Any]]:
    """Up with a stretch of constant velocity on the way, and back."""
    up, steady, fall = rng.uniform(45.0, 80.0), rng.uniform(10.0, 40.0), rng.uniform(70.0, 130.0)
    share = steady / (up + steady)
    places = (0.5 * (1.0 - share) * lift, 0.5 * (1.0 + share) * lift, lift, 0.0)
    kinds = (("move", up), ("constant-velocity", steady), ("move", up), ("move", fall))
    moves = [
        {"segment": kind, "angle": float(angle), "to": float(place)}
        for (kind, angle), place in zip(kinds, places, strict=True)
    ]
    return [*moves, {"segment": "dwell", "angle": float(360.0 - 2.0 * up - steady - fall)}]
