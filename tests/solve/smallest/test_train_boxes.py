"""The smallest cam with its linkage, proved: against dense scans, and no box loses a feasible cam."""

from itertools import product

import numpy as np
import pytest
from support.depth import times

from camopt import BadInput, Scene, certify, evaluate, find_scene, optimise, prices
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.scene.problem.settings import problem_with_searched_numbers_per_design
from camopt.scene.problem.space import search_boxes
from camopt.solve.smallest.boxes import DesignBoxes
from camopt.solve.smallest.result import SmallestCam
from camopt.solve.smallest.smallest_train import TrainBoxSearch, TrainOptimum
from camopt.solve.verdicts.feasible_filter import feasible_designs

SLIDE, VALVE, PRESS = (
    find_scene(name) for name in ("slide-by-bell-crank", "valve-with-rocker", "press-ram-by-four-bar")
)


def train_ranges(**ranges: tuple[float, float]) -> dict:
    """A search of numbers of the train, as ``1_crank``."""
    found: dict = {}
    for name, (low, high) in ranges.items():
        number, key = name.removeprefix("of_").split("_", 1)
        found.setdefault(number, {})[key] = {"start": low, "stop": high}
    return {"train": found}


LOADED = {
    "follower.dynamics.mass": 0.08,
    "train.1.arm_inertia": 6e-5,
    "train.1.mass": 0.1,
    "train.1.spring_rate": 30.0,
    "train.1.preload": 250.0,
    "train.1.friction_force": 4.0,
    "limits.contact_force_max_N": 900.0,
    "limits.contact_force_min_N": 60.0,
}
JOINTS = {"limits.joint_force_max_N": 870.0, "limits.pivot_force_max_N": 1400.0}
HEAVY = {
    **LOADED,
    "follower.dynamics.mass": 1.0,
    "limits.contact_force_max_N": None,
    "limits.contact_force_min_N": None,
    "limits.joint_force_max_N": 895.0,
    "limits.torque_rms_N_m": 2.69,
}
QUESTIONS = {
    "bell crank": SLIDE.replace(search=train_ranges(of_1_coupler=(200.0, 240.0), of_1_angle=(-115.0, -100.0))),
    "rocker": VALVE.replace(search=train_ranges(of_1_input_arm=(24.0, 30.0), of_1_output_angle=(-25.0, -5.0))),
    "and a roller": SLIDE.replace(
        search={**train_ranges(of_1_crank=(130.0, 160.0)), "roller_radius": {"start": 8, "stop": 15}}
    ),
    "a length that may be too short": SLIDE.replace(search=train_ranges(of_1_coupler=(100.0, 220.0))),
    "four-bar": PRESS.replace(search=train_ranges(of_1_coupler=(195.0, 205.0))),
    "loads": VALVE.replace(**LOADED, search=train_ranges(of_1_input_arm=(24.0, 30.0), of_1_mass=(0.05, 0.2))),
    "forces in joints": VALVE.replace(
        **LOADED, **JOINTS, search=train_ranges(of_1_input_arm=(22.0, 30.0), of_1_mass=(0.05, 0.2))
    ),
    "a mean": VALVE.replace(**HEAVY, search=train_ranges(of_1_input_arm=(25.1, 26.5))),
    "follower": VALVE.replace(
        **{"limits.acceleration_max_follower_m_s2": 800.0}, search=train_ranges(of_1_input_arm=(22.0, 34.0))
    ),
    "jerk of the follower": VALVE.replace(
        **{"limits.jerk_max_follower_m_s3": 2.223e5}, search=train_ranges(of_1_output_angle=(-27.0, -9.0))
    ),
    "transmission angle": PRESS.replace(
        **{"limits.transmission_angle_min_deg": 53.5}, search=train_ranges(of_1_crank=(99.0, 121.0))
    ),
}
PROVED = [name for name in QUESTIONS if name != "four-bar"]


def search_of(scene: Scene) -> TrainBoxSearch:
    problem = problem_with_searched_numbers_per_design(with_rounding_relative_error(resolve(scene)))
    return TrainBoxSearch(problem, search_boxes(problem)[0], TrainOptimum(problem, SmallestCam(None, 0.0)), np.inf)


def feasible_cams(search: TrainBoxSearch, count: int) -> list[dict[str, float]]:
    """Feasible cams of random trains: their free numbers by field."""
    rng, found = np.random.default_rng(5), []
    ends = search.search_ranges()
    for _ in range(count):
        numbers = {key: float(rng.uniform(*ends[key])) for key in search.motion_fields}
        problem = search.problem.with_numbers(numbers)
        if problem.setup.mechanism.has_no_assembly:
            continue
        sizes = 10.0 ** rng.uniform(0.7, 2.4, 60)
        free = {
            name: rng.uniform(*ends[name], 60)
            for name in ends
            if name != "size" and name not in search.motion_fields
        }
        designs: Designs = problem.design.with_values({**free, "size": sizes})
        held = np.flatnonzero(feasible_designs(problem.without_deferred_limits, designs))
        for k in held[np.argsort(sizes[held])][:2]:
            found.append({**numbers, **{n: float(v[k]) for n, v in free.items()}, "size": float(sizes[k])})
    return found


@pytest.mark.slow
@pytest.mark.one_in(13)
@pytest.mark.parametrize("name", QUESTIONS)
def test_no_box_loses_a_feasible_cam(name):
    """Random boxes around random feasible cams, small ones most: what is left of each still holds its cam."""
    search, rng = search_of(QUESTIONS[name]), np.random.default_rng(3)
    cams = feasible_cams(search, times(4, deep=100))
    assert len(cams) > 3
    for cam in cams:
        search.limits.added_angles = rng.uniform(0.0, 2 * np.pi, 9).tolist()
        for _ in range(4):
            ends = {}
            for key, (low, high) in search.search_ranges().items():
                low, high = (low, min(high, 300.0)) if key == "size" else (low, high)
                width = (high - low) * 10.0 ** rng.uniform(-4.0, 0.0)
                start = cam[key] - rng.uniform() * width
                ends[key] = (max(start, low), min(start + width, high)) if high > low else (low, high)
            boxes = DesignBoxes.single_box(ends, 10.0, search.problem.search_space.variables)
            left, _ = search.contract_by_limits(boxes)
            assert len(left) == 1
            for key in boxes.free:
                assert left.low[key][0] <= cam[key] <= left.high[key][0]


def smallest_size_of_train(scene: Scene, numbers: dict[str, float]) -> float:
    """The size of the smallest cam of one train."""
    try:
        best = optimise(scene.replace(**numbers)).best
    except BadInput:
        return np.inf
    return np.inf if best is None else best[resolve(scene).size_quantity_name]


@pytest.mark.long
@pytest.mark.parametrize("name", PROVED[::-1])
def test_no_linkage_of_a_dense_scan_has_a_smaller_cam(name):
    """Every linkage of a grid, and near the best, by the search for one linkage, which knows nothing of others."""
    scene = QUESTIONS[name]
    best, search = optimise(scene, seconds=300.0).best, search_of(scene)
    size, ends = best[search.problem.size_quantity_name], search.search_ranges()
    assert best["proved"]
    assert best["gap_mm"] <= 1e-9 * (size + best.get("roller_radius_mm", 0.0))
    assert evaluate(best.scene)["feasible"]
    keys = list(search.motion_fields)
    own = dict(zip(keys, (best.scene.numbers([key])[key] for key in keys), strict=True))
    count = times(2, deep=21)
    grid = product(*(np.linspace(*ends[key], count) for key in keys))
    near = product(
        *(np.clip(own[key] + 1e-3 * np.ptp(ends[key]) * np.array([-1, 0, 1]), *ends[key]) for key in keys)
    )
    fixed = scene.replace(**{f"search.{key}": None for key in keys})
    sizes = [
        smallest_size_of_train(fixed, dict(zip(keys, map(float, each), strict=True))) for each in (*grid, *near)
    ]
    assert min(sizes) >= size - best["gap_mm"]
    assert min(sizes) == pytest.approx(size, rel=1e-4)


PRICED = {
    "limits.transmission_angle_min_deg": QUESTIONS["transmission angle"],
    "search.train.1.crank.stop": SLIDE.replace(search=train_ranges(of_1_crank=(150.0, 170.0))),
}


@pytest.mark.long
@pytest.mark.parametrize("key", [*PRICED][::-1])
def test_a_bound_costs_what_the_smallest_cam_with_its_linkage_changes_by(key):
    """By multipliers, and by the smallest cam at another bound, whose linkage is another too."""
    found = optimise(PRICED[key])
    (each,) = prices(found, seconds=1e-3).values()
    assert key in {price.key for price in each}
    for price in each:
        step = 1e-3 * price.bound
        other = optimise(PRICED[key].replace(**{price.key: price.bound + step})).best
        change = (other["base_radius_mm"] - found.best["base_radius_mm"]) / step
        assert price.price == pytest.approx(change, rel=0.02)


@pytest.mark.long
def test_the_smallest_cam_with_three_free_numbers_is_certified():
    ranges = train_ranges(
        of_1_input_arm=(24.0, 25.0), of_1_output_angle=(-22.0, -18.0), of_1_input_angle=(-5.0, 0.0)
    )
    best = optimise(VALVE.replace(search=ranges), seconds=200.0).best
    assert best["proved"]
    assert set(certify(best.scene).values()) == {"held"}


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("scene", "bound"),
    [
        (SLIDE.replace(search=train_ranges(of_1_crank=(150.0, 165.0))), {"limits.pressure_angle": 12}),
        (QUESTIONS["a mean"], {"limits.joint_force_max_N": 845.0}),
    ],
    ids=["pressure", "a mean and forces in joints"],
)
def test_what_no_linkage_holds_is_proved_to_be_held_by_none(scene, bound):
    found = optimise(scene.replace(**bound), seconds=300.0)
    assert found.best is None
    assert not found.out_of_time
    (why,) = found.obstacles.values()
    assert "not proved" not in why
