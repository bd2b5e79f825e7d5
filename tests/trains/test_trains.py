"""The kinematics of trains: against loops closed by root finding at 50 digits, and printed examples."""

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from camopt.numerics.taylor import Taylor
from camopt.trains import TRAIN_STAGES
from camopt.trains.four_bar import four_bar
from camopt.trains.link import Unassembled
from camopt.trains.train import StageFault, Train, train_of

Keys = dict[str, Any]
Stages = list[tuple[str, Keys]]
STEPS = 60


def radian(keys: Keys, name: str) -> Any:
    return mpf(keys.get(name, 0.0)) * mpmath.pi / 180


def turned_by(keys: Keys, turns: bool, x: Any) -> Any:
    """The angle of a rocker or bell crank that a roller on its first arm turns: l·(sin(α + φ) − sin α) = x."""
    if turns:
        return x
    length, start = mpf(keys["input_arm"]), radian(keys, "input_angle")
    return mpmath.findroot(lambda phi: length * (mpmath.sin(start + phi) - mpmath.sin(start)) - x, x / length)


def rocker(keys: Keys, turns: bool, x: Any) -> Any:
    phi, length, start = turned_by(keys, turns, x), mpf(keys["output_arm"]), radian(keys, "output_angle")
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
    return followed(lambda phi, slide: pin(keys, phi, slide), start, first, x) - start


def followed(gap: Callable[[Any, Any], Any], start: Any, first: Any, x: Any) -> Any:
    """The root that grows from the start as the input goes to x, in steps."""
    found = start
    with mpmath.workdps(15):
        for k in range(1, STEPS + 1):
            here = first + x * (mpf(k) / STEPS) ** 2
            found = mpmath.findroot(lambda phi, here=here: gap(phi, here), (found, found + 1e-5))
    return mpmath.findroot(lambda phi: gap(phi, first + x), (found, found + 1e-5))


def bell_crank(keys: Keys, turns: bool, x: Any) -> Any:
    return slider_crank(keys, True, turned_by(keys, turns, x))


def four_bar_loop(keys: Keys, turns: bool, x: Any) -> Any:
    a, b, c, d = (mpf(keys[name]) for name in ("crank", "coupler", "rocker", "ground"))
    start = radian(keys, "angle")

    def gap(psi: Any, phi: Any) -> Any:
        return abs(d + c * mpmath.expj(psi) - a * mpmath.expj(phi)) ** 2 - b * b

    known = four_bar(*(keys[n] for n in ("crank", "coupler", "rocker", "ground", "angle")), crossed=keys["crossed"])
    first = mpmath.findroot(lambda psi: gap(psi, start), known.asked_start)
    return followed(gap, first, start, x) - first


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
ANGLE_OUT: dict[str, Callable[[bool], bool]] = {
    "rocker": lambda turns: False,
    "bell-crank": lambda turns: False,
    "slider-crank": lambda turns: not turns,
    "four-bar": lambda turns: True,
    "incline": lambda turns: False,
}


def drawn(rng: np.random.Generator, name: str, turns: bool) -> Keys:
    """Keys of a stage, which need not go together."""

    def of(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    driven = {} if turns else {"input_arm": of(20, 60), "input_angle": of(-40, 40)}
    crank = {"crank": of(20, 60), "coupler": of(70, 200), "offset": of(-20, 20), "angle": of(-170, 170)}
    return {
        "rocker": {**driven, "output_arm": of(20, 80), "output_angle": of(-40, 40)},
        "bell-crank": {**driven, **crank},
        "slider-crank": crank,
        "four-bar": {
            **{key: of(30, 120) for key in ("crank", "coupler", "rocker", "ground")},
            "angle": of(-170, 170),
            "crossed": bool(rng.integers(2)),
        },
        "ratio": [{"ratio": of(-3, 3)}, {"radius": of(10, 60)}][rng.integers(2)],
        "incline": {"angle": of(5, 60), "guide": of(60, 110)},
    }[name]


def random_train(rng: np.random.Generator) -> tuple[Stages, Train, bool]:
    """A train of one to three stages that can be put together."""
    while True:
        angular = turns = bool(rng.integers(2))
        stages: Stages = []
        for _ in range(rng.integers(1, 4)):
            fits = [n for n in LOOPS if not (n == "four-bar" and not turns) and not (n == "incline" and turns)]
            name = fits[rng.integers(len(fits))]
            keys = drawn(rng, name, turns)
            stages.append((name, keys))
            turns = ANGLE_OUT[name](turns) if name in ANGLE_OUT else turns != ("radius" in keys)
        try:
            train = train_of(stages, angular=angular)
        except StageFault:
            continue
        low, high = train.reach
        if high.at - low.at > (0.05 if train.angular else 2.0):
            return stages, train, angular


def exact(stages: Stages, angular: bool, x: Any) -> Any:
    turns = angular
    for name, keys in stages:
        x = LOOPS[name](keys, turns, x)
        turns = ANGLE_OUT[name](turns) if name in ANGLE_OUT else turns != ("radius" in keys)
    return x


@pytest.mark.parametrize("seed", range(200))
def test_trains_are_those_of_closed_loops(seed):
    rng = np.random.default_rng(seed)
    stages, train, angular = random_train(rng)
    low, high = (float(np.clip(end.at, -20.0, 20.0)) for end in train.reach)
    tool = low + (high - low) * rng.uniform(0.15, 0.85)
    follower = float(train.follower(Taylor([tool])).terms[0])
    with mpmath.workdps(50):
        terms = mpmath.taylor(lambda x: exact(stages, angular, x), mpf(follower), 3)
    found = train.tool(Taylor([follower, 1.0, 0.0, 0.0]))
    back = train.follower(Taylor([float(each) for each in terms]))
    scale = max(map(abs, terms))
    assert [float(abs(a - b) / scale) for a, b in zip(found.terms, terms, strict=True)] == pytest.approx(
        [0.0] * 4, abs=1e-11
    )
    assert found.terms[0] == pytest.approx(tool, abs=1e-11 * max(abs(tool), 1.0))
    curl = max(1.0, *(float(abs(each / terms[1])) for each in terms)) ** 3
    assert back.terms == pytest.approx((follower, 1.0, 0.0, 0.0), abs=1e-12 * curl * max(1.0, abs(follower)))


@pytest.mark.parametrize("seed", range(40))
def test_up_to_its_dead_points_a_train_goes_one_way(seed):
    """And at them it stands still, or its follower does."""
    _, train, _ = random_train(np.random.default_rng(1000 + seed))
    low, high = (float(np.clip(end.at, -1e3, 1e3)) for end in train.reach)
    near = 1e-6 * (high - low)
    tool = np.linspace(low + near, high - near, 400)
    slope = train.follower(Taylor([tool, 0.0 * tool + 1.0])).terms[1]
    assert np.isfinite(slope).all()
    assert (slope > 0.0).all() or (slope < 0.0).all()
    middle = np.median(np.abs(slope))
    for end, there in zip(train.reach, (slope[0], slope[-1]), strict=True):
        turned = "half a turn" in end.why or not np.isfinite(end.at)
        assert turned or not 1e-2 < abs(there) / middle < 1e2


def test_a_four_bar_of_norton():
    """Norton, Design of Machinery, example 4-1: links of 100, 40, 120 and 80 mm, the crank at 40 deg."""
    found = [four_bar(40.0, 120.0, 80.0, 100.0, 40.0, crossed=crossed).asked_start for crossed in (False, True)]
    assert np.degrees(found) == pytest.approx([57.33, -98.01 + 360.0], abs=0.006)


def test_a_slider_crank_of_norton():
    """Norton, Design of Machinery, example 4-2: crank 40, coupler 120, offset −20 mm, the crank at 60 deg."""
    train = train_of(
        [("slider-crank", {"crank": 40.0, "coupler": 120.0, "offset": -20.0, "angle": 60.0})], angular=True
    )
    assert train.links[0].place == pytest.approx(126.84, abs=0.005)  # type: ignore[attr-defined]


def test_a_slider_crank_is_driven_from_either_end():
    keys = {"crank": 40.0, "coupler": 120.0, "offset": 10.0, "angle": 60.0}
    forth, back = (train_of([("slider-crank", keys)], angular=angular) for angular in (True, False))
    turned = np.linspace(-0.4, 0.4, 9)
    slide = forth.tool(Taylor([turned, 1.0, 0.0, 0.0]))
    assert back.tool(slide).terms[0] == pytest.approx(turned, abs=1e-14)


def test_the_ratio_of_a_rocker_is_that_of_its_arms_at_the_start():
    keys = {"input_arm": 25.0, "input_angle": -10.0, "output_arm": 40.0, "output_angle": -15.0}
    slope = train_of([("rocker", keys)], angular=False).tool(Taylor([0.0, 1.0])).terms[1]
    assert slope == pytest.approx(40.0 * np.cos(np.radians(15.0)) / (25.0 * np.cos(np.radians(10.0))), rel=1e-15)


WRONG = {
    "a length for a four-bar": (
        [("four-bar", {"crank": 30, "coupler": 90, "rocker": 60, "ground": 80, "angle": 50})],
        False,
    ),
    "an angle for a wedge": ([("incline", {"angle": 30})], True),
    "a ratio of nothing": ([("ratio", {})], False),
    "a ratio of 0": ([("ratio", {"ratio": 0.0})], False),
    "both a ratio and a radius": ([("ratio", {"ratio": 2.0, "radius": 3.0})], False),
    "a key missing": ([("slider-crank", {"crank": 30, "angle": 60})], True),
    "a key of another": ([("slider-crank", {"crank": 30, "coupler": 90, "angle": 60, "ground": 3})], True),
    "a coupler too short": ([("slider-crank", {"crank": 60, "coupler": 30, "angle": 60})], True),
    "links that do not meet": (
        [("four-bar", {"crank": 30, "coupler": 20, "rocker": 20, "ground": 90, "angle": 50})],
        True,
    ),
    "a start at a dead point": ([("slider-crank", {"crank": 30, "coupler": 90, "angle": 0})], True),
    "an arm along the motion": ([("rocker", {"output_arm": 30, "output_angle": 90})], True),
    "no arm for a length": ([("rocker", {"output_arm": 30})], False),
    "an arm for an angle": ([("rocker", {"output_arm": 30, "input_arm": 20})], True),
    "a wedge along its guide": ([("incline", {"angle": 80, "guide": 120})], False),
}


@pytest.mark.parametrize(("stages", "angular"), WRONG.values(), ids=WRONG)
def test_what_cannot_be_put_together_is_told(stages, angular):
    with pytest.raises(StageFault) as told:
        train_of([("ratio", {"ratio": 1.0}), *stages], angular=angular)
    assert isinstance(told.value, Unassembled)
    assert told.value.number == 2
    assert "\n" not in str(told.value)


def test_each_stage_has_a_loop():
    assert TRAIN_STAGES.keys() == LOOPS.keys()
