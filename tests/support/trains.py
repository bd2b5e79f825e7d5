"""Trains of follower and tool, random ones, and their loops closed by root finding in 50 digits."""

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

from camopt.core.numerics.taylor import Taylor
from camopt.model.trains import TRAIN_STAGES
from camopt.model.trains.carried_load import CarriedLoad
from camopt.model.trains.four_bar import assemble_four_bar
from camopt.model.trains.train import StageFault, Train, assemble_train

Keys = dict[str, Any]
Stages = list[tuple[str, Keys]]
STEPS = 60
WALKED: dict[tuple[Any, ...], Any] = {}


def radian(keys: Keys, name: str) -> Any:
    return mpf(keys.get(name, 0.0)) * mpmath.pi / 180


def arm_angle(keys: Keys, turns: bool, x: Any) -> Any:
    """The angle of a rocker or bell crank that a roller on its first arm turns: l·(sin(α + φ) − sin α) = x."""
    if turns:
        return x
    length, start = mpf(keys["input_arm"]), radian(keys, "input_angle")
    return mpmath.findroot(lambda phi: length * (mpmath.sin(start + phi) - mpmath.sin(start)) - x, x / length)


def rocker(keys: Keys, turns: bool, x: Any) -> Any:
    phi, length, start = arm_angle(keys, turns, x), mpf(keys["output_arm"]), radian(keys, "output_angle")
    return length * (mpmath.sin(start + phi) - mpmath.sin(start))


def pin(keys: Keys, phi: Any, slide: Any) -> Any:
    """How much further apart crank pin and slide are than the coupler is long, squared."""
    a, b, e = (mpf(keys.get(name, 0.0)) for name in ("crank", "coupler", "offset"))
    return (slide - a * mpmath.cos(phi)) ** 2 + (e - a * mpmath.sin(phi)) ** 2 - b * b


def slide_at(keys: Keys, phi: Any) -> Any:
    a, b = mpf(keys["crank"]), mpf(keys["coupler"])
    return mpmath.findroot(lambda slide: pin(keys, phi, slide), a * mpmath.cos(phi) + b)


def slider_crank(keys: Keys, turns: bool, x: Any) -> Any:
    start = radian(keys, "angle")
    first = slide_at(keys, start)
    if turns:
        return slide_at(keys, start + x) - first
    return follow_root(lambda phi, slide: pin(keys, phi, slide), keys, start, first, x) - start


def follow_root(gap: Callable[[Any, Any], Any], keys: Keys, start: Any, first: Any, x: Any) -> Any:
    """The root that grows from the start as the input goes to x, in steps; those next to x share the steps."""
    path = (*keys.items(), start, first, round(float(x), 9))
    if path not in WALKED:
        WALKED[path] = walk_root(gap, start, first, x)
    return mpmath.findroot(lambda phi: gap(phi, first + x), (WALKED[path], WALKED[path] + 1e-5))


def walk_root(gap: Callable[[Any, Any], Any], start: Any, first: Any, x: Any) -> Any:
    found = start
    with mpmath.workdps(15):
        for k in range(1, STEPS + 1):
            here = first + x * (mpf(k) / STEPS) ** 2
            found = mpmath.findroot(lambda phi, here=here: gap(phi, here), (found, found + 1e-5))
    return found


def bell_crank(keys: Keys, turns: bool, x: Any) -> Any:
    return slider_crank(keys, True, arm_angle(keys, turns, x))


def four_bar_loop(keys: Keys, turns: bool, x: Any) -> Any:
    a, b, c, d = (mpf(keys[name]) for name in ("crank", "coupler", "rocker", "ground"))
    start = radian(keys, "angle")

    def gap(psi: Any, phi: Any) -> Any:
        return abs(d + c * mpmath.expj(psi) - a * mpmath.expj(phi)) ** 2 - b * b

    known = assemble_four_bar(
        *(float(keys[n]) for n in ("crank", "coupler", "rocker", "ground", "angle")), crossed=keys["crossed"]
    )
    first = mpmath.findroot(lambda psi: gap(psi, start), known.rocker_start)
    return follow_root(gap, keys, first, start, x) - first


def ratio(keys: Keys, turns: bool, x: Any) -> Any:
    if "ratio" in keys:
        return mpf(keys["ratio"]) * x
    return mpf(keys["radius"]) * x if turns else x / mpf(keys["radius"])


def incline(keys: Keys, turns: bool, x: Any) -> Any:
    """The lifted point on the line through the moved foot of the incline, and on its guide."""
    slope, guide = radian(keys, "angle"), mpf(keys.get("guide", 90.0)) * mpmath.pi / 180
    along, across = mpmath.cos(guide), mpmath.sin(guide)
    moved = mpmath.lu_solve([[along, mpmath.cos(slope)], [across, -mpmath.sin(slope)]], [x, 0])
    return moved[0]


LOOPS = {
    "rocker": rocker,
    "bell-crank": bell_crank,
    "slider-crank": slider_crank,
    "four-bar": four_bar_loop,
    "ratio": ratio,
    "incline": incline,
}


def random_stage_keys(rng: np.random.Generator, name: str, turns: bool) -> Keys:
    """Keys of a stage, which need not go together."""

    def uniform_number(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    driven = {} if turns else {"input_arm": uniform_number(20, 60), "input_angle": uniform_number(-40, 40)}
    crank = {
        "crank": uniform_number(20, 60),
        "coupler": uniform_number(70, 200),
        "offset": uniform_number(-20, 20),
        "angle": uniform_number(-170, 170),
    }
    return {
        "rocker": {**driven, "output_arm": uniform_number(20, 80), "output_angle": uniform_number(-40, 40)},
        "bell-crank": {**driven, **crank},
        "slider-crank": crank,
        "four-bar": {
            **{key: uniform_number(30, 120) for key in ("crank", "coupler", "rocker", "ground")},
            "angle": uniform_number(-170, 170),
            "crossed": bool(rng.integers(2)),
        },
        "ratio": [{"ratio": uniform_number(-3, 3)}, {"radius": uniform_number(10, 60)}][rng.integers(2)],
        "incline": {"angle": uniform_number(5, 60), "guide": uniform_number(60, 110)},
    }[name]


def random_train(rng: np.random.Generator) -> tuple[Stages, Train, bool]:
    """A train of one to three stages that can be put together."""
    while True:
        angular = turns = bool(rng.integers(2))
        stages: Stages = []
        for _ in range(rng.integers(1, 4)):
            fits = [n for n in LOOPS if not (n == "four-bar" and not turns) and not (n == "incline" and turns)]
            name = fits[rng.integers(len(fits))]
            keys = random_stage_keys(rng, name, turns)
            stages.append((name, keys))
            turns = TRAIN_STAGES[name].turns(keys, turns)
        try:
            train = assemble_train(stages, angular=angular)
        except StageFault:
            continue
        low, high = train.tool_travel_ends
        if high.at - low.at > (0.05 if train.angular else 2.0):
            return stages, train, angular


def drawn_loads(rng: np.random.Generator, joints: int) -> tuple[tuple[CarriedLoad, ...], dict[int, Taylor]]:
    """Masses, springs and forces at each joint, and a load that changes at the last."""
    carried = tuple(CarriedLoad(k, *rng.uniform(0.0, 2.0, 4)) for k in range(1, joints + 1))
    return carried, {joints: Taylor([float(rng.uniform(-5, 5)), 0.0, 0.0, 0.0])}


def exact(stages: Stages, angular: bool, x: Any) -> Any:
    turns = angular
    for name, keys in stages:
        x = LOOPS[name](keys, turns, x)
        turns = TRAIN_STAGES[name].turns(keys, turns)
    return x
