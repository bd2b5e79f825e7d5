"""The price of a bound, against differences of the smallest cam for all kinds of limit; what holds the cam next."""

from functools import partial
from math import isclose

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support.depth import times
from support.part_cams import quantity_of, scene_of
from support.smallest_cams import ANGLES, BASE, CASES, FREE, scene, size_of
from test_optimise import FREED

from camopt import BadInput, Scene, evaluate, find_scene, optimise, prices, shipped_scenes
from camopt.core.quantities import motion_peak_name
from camopt.scene.problem.limits import LOAD_LIMITS, limited_quantity_name
from camopt.scene.problem.problem import resolve
from camopt.solve.smallest.multipliers import _least_price_within_residual, _multipliers_and_residual

STEP = 2e-4  # relative, of a bound: its square is far below what prices are held to
QUICK = 1e-3  # seconds: no cam is sought without a limit


def smallest_size_at(case, key, value):
    """The size of the smallest cam with another bound."""
    table, name, *end = key.split(".")
    if end:
        value = {**getattr(case.search, name).model_dump(exclude_none=True), end[0]: value}
    return size_of(optimise(case.replace(**{f"{table}.{name}": value})).best)


def price_by_differences(case, key, bound, weights=(-1.0, 0.0, 1.0)):
    """dR/db by differences of the smallest cam, central if no other weights are given."""
    step, places = STEP * (abs(bound) or 1.0), np.arange(len(weights)) - len(weights) // 2
    sizes = [
        smallest_size_at(case, key, bound + k * step) if weight else 0.0
        for k, weight in zip(places, weights, strict=True)
    ]
    return float(np.dot(weights, sizes)) / (float(np.dot(weights, places)) * step)


def prices_by_key(case, seconds=QUICK):
    """The prices of the best law's cam, by key."""
    optimum = optimise(case)
    law = next(iter(optimum.by_law))
    return {price.key: price for price in prices(optimum, seconds)[law]}


def unconfirmed_prices(case, found):
    """The keys of prices that differences of the smallest cam do not confirm."""
    exact = {key: price_by_differences(case, key, price.bound) for key, price in found.items()}
    return {
        key: (price.price, exact[key])
        for key, price in found.items()
        if not (price.price == price.tightened and isclose(price.price, exact[key], rel_tol=2e-5, abs_tol=1e-9))
    }


SIZED = {
    **CASES,
    **{
        name: CASES[case].replace(**{f"search.{key}": {"start": a, "stop": b} for key, (a, b) in ranges.items()})
        for name, (case, ranges) in FREED.items()
    },
}
UNASKED = {"undercut binds", "cylindrical, undercut"}
RISE_BINDS = find_scene("valve-with-rocker").replace(**{"search.law": ["poly4567"]})


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", sorted({*SIZED} - UNASKED))
def test_a_price_is_the_derivative_of_the_smallest_size(name):
    found = prices_by_key(SIZED[name])
    assert found
    assert unconfirmed_prices(SIZED[name], found) == {}


ALIKE = ("oscillating", "cylindrical", "offset free, limits apart")  # seconds each, to the same end as the others


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.long) if n in ALIKE else n for n in FREE])
def test_prices_are_derivatives_where_angles_are_free(name):
    found = prices_by_key(FREE[name])
    assert found
    assert unconfirmed_prices(FREE[name], found) == {}


HELD = ("roller-1000rpm", "two-pauses", "belt-matching", "bucket-valve", "feeder-with-stop", "indexing-overlap")
HELD += (
    "barrel-traverse",
    "bottle-filler-by-rib",
    "clamp-by-wedge",
    "face-groove-shutter",
    "press-with-drift",
    "press-ram-by-four-bar",
    "press-feed-by-pair",
    "pusher-by-lever",
    "rocker-valve",
    "slide-by-bell-crank",
    "valve-rod-offset",
    "valve-rod-radial",
    "valve-with-rocker",
)


@pytest.mark.slow
@pytest.mark.one_in(21)
@pytest.mark.parametrize("name", HELD)
def test_prices_are_derivatives_in_the_shipped_scenes(name):
    case = find_scene(name)
    own = case.replace(**{"search.law": None, "motion": optimise(case).best.scene.to_dict()["motion"]})
    found = prices_by_key(own)
    assert found
    assert unconfirmed_prices(own, found) == {}


REFUSED = {
    **dict.fromkeys(
        ("eccentric-rocker", "tangent-cam", "three-arc-valve"),
        "profile: the base radius cannot change, since the scene gives the profile of the cam",
    ),
    **dict.fromkeys(
        ("harmonic-240rpm-radial", "knife-300rpm-radial", "knife-900rpm-radial", "uniform-knife-radial"),
        "limits: nothing limits the size: add a limit that small cams break",
    ),
}


@pytest.mark.parametrize("name", sorted({*shipped_scenes()} - {*HELD} - {*REFUSED}))
def test_the_others_have_no_bounds_that_hold_them(name):
    assert not any(prices(optimise(find_scene(name))).values())


@pytest.mark.parametrize("name", REFUSED)
def test_a_scene_that_has_no_smallest_cam_is_refused(name):
    with pytest.raises(BadInput, match=f"^{name}: {REFUSED[name]}"):
        optimise(find_scene(name))


DYNAMICS = {
    "mass": 0.4, "spring_rate": 12, "preload": 250, "damping": 0.02, "load": 40, "guide_length": 90,
    "overhang": 80, "friction": 0.1, "stem_diameter": 16, "natural_frequency": 123, "damping_ratio": 0.05,
}  # fmt: skip
MATERIALS = {"cam": "steel", "follower": "steel", "face_width": 10, "viscosity": 0.02, "pressure_viscosity": 18}
LOADED = {"follower.dynamics": DYNAMICS, "materials": {**MATERIALS, "roughness": 0.3}, "cam.rpm": 300}
ROLLER = scene(**LOADED, **{"follower.roller_radius": 12, "limits": {"pressure_angle": 50}})
TURNED = scene(**LOADED, **ANGLES, **{"follower.roller_radius": 12, "limits.pressure_angle_return": 45})
MOST = ("side_thrust", "guide_reaction", "stem_bending_stress")
SLOWER = {
    **dict.fromkeys(MOST, (ROLLER, 0.9)),
    **dict.fromkeys(("torque", "power"), (ROLLER, 0.99)),
    "jamming_margin": (ROLLER, 1.02),
}
"""Limits on loads that may hold the size of a cam: a scene, and what is allowed of what its cam has."""
SLOWEST = {
    "contact_stress": (ROLLER, 0.9),
    "normal_force": (ROLLER, 0.99),
    "film_ratio": (ROLLER, 1.02),
    **dict.fromkeys(("acceleration", "velocity", "jerk", "residual_vibration"), (TURNED, 0.97)),
    "jump_speed": (TURNED, 1.02),
}
"""And those, on motions among them, whose search is long."""


def with_binding_limit(name, case, share):
    """A scene whose cam a limit holds."""
    in_time = partial(motion_peak_name, stroke="", angular=False, timed=True)
    quantity = limited_quantity_name(name, resolve(case).setup) if name in LOAD_LIMITS else in_time(name)
    cam = optimise(case).best.scene.replace(outputs=["all"])
    return case.replace(**{f"limits.{name}": share * evaluate(cam)[quantity]})


@pytest.mark.slow
@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", SLOWER)
def test_prices_of_limits_on_loads_are_derivatives(name):
    case = with_binding_limit(name, *SLOWER[name])
    found = prices_by_key(case)
    assert f"limits.{name}" in found
    assert unconfirmed_prices(case, found) == {}


@pytest.mark.long
@pytest.mark.parametrize("name", SLOWEST)
def test_prices_of_limits_with_a_long_search_are_derivatives(name):
    case = with_binding_limit(name, *SLOWEST[name])
    found = prices_by_key(case)
    assert unconfirmed_prices(case, {f"limits.{name}": found[f"limits.{name}"]}) == {}


def test_two_limits_of_which_one_would_do_cost_nothing_eased_and_all_tightened():
    """Rise and return alike, and no offset: both limits hold the same size."""
    motion = [{**each, "angle": 90} for each in BASE["motion"]]
    both = scene(motion=motion, limits={"pressure_angle": 30, "pressure_angle_return": 30})
    one, apart = prices_by_key(both.replace(**{"limits.pressure_angle_return": None})), prices_by_key(both)
    (price,) = one.values()
    for key in ("limits.pressure_angle", "limits.pressure_angle_return"):
        assert apart[key].price == pytest.approx(0.0, abs=1e-9)
        assert apart[key].tightened == pytest.approx(price.price, rel=1e-3)
        assert price_by_differences(both, key, 30.0, (0.0, -1.0, 1.0)) == 0.0


def test_one_limit_that_holds_the_cam_at_two_angles_has_one_price():
    """Its pressure angle at a rise and, on the other side, at a return pull at the offset from both sides."""
    half = {"segment": "rise", "law": "cycloidal"}
    rises = [
        {**half, "angle": 90, "lift": 30},
        {"segment": "dwell", "angle": 20},
        {**half, "angle": 70, "lift": 20},
    ]
    motion = [*rises, {**half, "segment": "return", "angle": 120, "lift": 50}, {"segment": "dwell", "angle": 60}]
    limits = {"pressure_angle": 30, "pressure_angle_return": 55}
    case = scene(motion=motion, limits=limits, **{"search.offset": {"start": -60, "stop": 60}})
    (price,) = prices_by_key(case).values()
    assert price.tightened == price.price
    assert price.price == pytest.approx(price_by_differences(case, price.key, 30.0), rel=1e-4)


@pytest.mark.slow
@given(bound=st.floats(10, 50), other=st.floats(10, 50), law=st.sampled_from(["cycloidal", "harmonic", "poly345"]))
@example(bound=22.0, other=10.0, law="cycloidal")  # the first limit decides no more above 22.0438°
@example(bound=30.0, other=30.0, law="cycloidal")
@settings(max_examples=times(8, deep=200))
def test_a_little_easing_saves_its_price_but_for_the_second_order(bound, other, law):
    limits = {"pressure_angle": bound, "pressure_angle_return": other}
    case = scene(limits=limits, **{"search.law": [law], "search.offset": {"start": -40, "stop": 40}})
    best = optimise(case).best
    for key, price in prices_by_key(case).items():
        if key.startswith("limits."):
            step = 1e-3 * price.bound
            eased = [optimise(case.replace(**{key: price.bound + k * step})).best for k in (1, 2)]
            if eased[1]["binding"] != best["binding"]:
                continue  # the price ends between the two
            errors = [size_of(cam) - size_of(best) - price.price * k * step for k, cam in enumerate(eased, 1)]
            assert abs(errors[0]) <= 0.3 * abs(errors[1]) + 1e-7
            assert abs(errors[1]) <= 1e-2 * abs(price.price) * step + 1e-7


@pytest.mark.parametrize("scale", [0.01, 3.0, 100.0])
def test_a_cam_that_is_larger_costs_more_per_degree_and_the_same_per_mm(scale):
    case = CASES["offset bound"].replace(**{"cam.rpm": None})
    data = case.to_dict()
    data["cam"]["base_radius"] *= scale
    data["follower"]["roller_radius"] *= scale
    data["search"]["offset"] = {key: scale * end for key, end in data["search"]["offset"].items()}
    for segment in data["motion"]:
        segment.update({"lift": segment["lift"] * scale} if "lift" in segment else {})
    own, scaled = prices_by_key(case), prices_by_key(Scene.from_dict(data))
    assert own.keys() == scaled.keys() == {"limits.pressure_angle_return", "search.offset.stop"}
    for key, per in (("limits.pressure_angle_return", scale), ("search.offset.stop", 1.0)):
        assert scaled[key].price == pytest.approx(per * own[key].price, rel=1e-6)


def test_the_price_of_a_shaft_is_half_a_mm_per_mm():
    (price,) = prices_by_key(CASES["shaft binds"]).values()
    assert (price.key, price.relation, price.unit) == ("cam.shaft_diameter", "≥", "mm")
    assert price.price == pytest.approx(0.5, rel=1e-9)


def test_an_end_of_a_range_that_holds_nothing_has_no_price():
    """The shaft holds the cam, and any roller of 15 to 16.17 mm will do: the search ended at the largest."""
    search = {"offset": {"start": -1.92, "stop": 2.51}, "roller_radius": {"start": 7.99, "stop": 16.17}}
    limits = {"pressure_angle": 40.0, "curvature_radius": 7.6}
    scene = find_scene("belt-matching").replace(search=search, limits=limits)
    best = optimise(scene)
    smaller = optimise(scene.replace(**{"search.roller_radius": {"start": 7.99, "stop": 15.5}}))
    assert best.best["roller_radius_mm"] == 16.17
    assert smaller.best["base_radius_mm"] == best.best["base_radius_mm"]  # what another value shows
    assert [price.key for price in prices(best)[""]] == ["cam.shaft_diameter"]


@pytest.mark.slow
@pytest.mark.parametrize(("contact", "key"), [("roller", "cutter_radius"), ("groove-arm", "hub_wall")])
def test_limits_on_the_part_have_prices(contact, key):
    case = scene_of(contact).replace(limits={"pressure_angle": 25})
    had = optimise(case).best[quantity_of(key, contact)[0]]
    held = case.replace(**{f"limits.{key}": 1.03 * had})
    found = prices_by_key(held)
    assert [*found] == [f"limits.{key}"]
    assert unconfirmed_prices(held, found) == {}


def test_a_cam_that_is_held_by_the_part_in_its_scene_has_prices():
    """Nothing limits the wall, and the smallest cam leaves none: its price is that of no bound that is set."""
    case = scene_of("groove-arm").replace(limits={"pressure_angle": 60})
    best = optimise(case).best
    assert (best["binding"], best.scene.cam.mean_radius) == (["keyway"], best["mean_radius_mm"])
    assert unconfirmed_prices(case, prices_by_key(case)) == {}


@pytest.mark.parametrize("angle", [10.0, 30.0, 45.0])
def test_a_closed_form(angle):
    """A radial roller: R_p = max (y'/tan β − y), so dR/dβ = −y'/sin² β there."""
    x, rise, beta = np.linspace(0.0, 1.0, 1_000_001), np.radians(90), np.radians(angle)
    y = 50.0 * (x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi))
    slope = 50.0 / rise * (1.0 - np.cos(2.0 * np.pi * x))
    there = np.argmax(slope / np.tan(beta) - y)
    case = scene(limits={"pressure_angle_return": angle}, **{"follower.roller_radius": 0.1})
    (price,) = prices_by_key(case).values()
    assert price.price == pytest.approx(-slope[there] / np.sin(beta) ** 2 * np.pi / 180.0, rel=1e-5)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "case",
    [
        *(
            pytest.param(SIZED[name], id=name)
            for name in ("pressure binds, offset free", "shaft binds", "curvature binds", "arm of a groove")
        ),
        pytest.param(RISE_BINDS, id="pressure of the rise binds, of the return it is far"),
    ],
)
def test_without_a_limit_the_cam_is_that_of_another_search_and_a_bound_there_saves_no_more(case):
    for key, price in prices_by_key(case, 30.0).items():
        if key.startswith("search."):
            assert (price.size_without, price.holds_to, price.next) == (None, None, None)
            continue
        assert price.size_without < size_of(optimise(case).best)
        assert price.next
        assert key not in price.next
        if price.holds_to > 1e-6:
            there = smallest_size_at(case, key, price.holds_to)
            assert there == pytest.approx(price.size_without, rel=1e-7)
            ease = 0.99 if price.price > 0.0 else 1.01
            assert smallest_size_at(case, key, price.holds_to * ease) == pytest.approx(price.size_without, rel=1e-7)


def test_where_nothing_else_limits_the_size_it_is_0_without():
    (price,) = prices_by_key(CASES["knife"].replace(limits={"pressure_angle": 30}), 30.0).values()
    assert (price.size_without, price.holds_to, price.next) == (0.0, None, ())


def test_a_condition_without_a_value_has_no_price():
    for name in UNASKED:
        assert prices_by_key(SIZED[name]) == {}


def test_no_cam_has_no_prices():
    assert prices(optimise(scene(**{"limits.acceleration": 10}))) == {}


def test_what_has_no_prices_is_told():
    with pytest.raises(
        BadInput, match=r"what = 'Scene': must be a result of optimise or synthesise; .*optimise its scene"
    ):
        prices(CASES["knife"])


@pytest.mark.parametrize("seconds", [0, -1.0, "a", float("nan")])
def test_seconds_are_a_number_above_0(seconds):
    with pytest.raises(BadInput, match="seconds"):
        prices(optimise(CASES["knife"]), seconds)


@pytest.mark.parametrize("slope", [2.0, -2.0])
@pytest.mark.parametrize("column", [-1.0, 1.0])
@pytest.mark.parametrize("room", [0.25, 0.75])
def test_one_limit_on_the_size_alone_is_as_scipy_has_it(slope, column, room):
    one, goal, by = np.array([[column]]), np.array([0.5]), np.array([slope])
    twice = np.hstack([one, one])  # any other shape is scipy's
    (weight,), left = _multipliers_and_residual(one, goal)
    weights, also = _multipliers_and_residual(twice, goal)
    assert (weight, left) == (pytest.approx(weights.sum()), pytest.approx(also))
    if left <= room:
        assert _least_price_within_residual(by, one, goal, room) == pytest.approx(
            _least_price_within_residual(np.repeat(by, 2), twice, goal, room)
        )


def test_prices_are_a_mapping_and_a_result():
    optimum = optimise(find_scene("roller-1000rpm").replace(search={"law": ["cycloidal", "harmonic"]}))
    found = prices(optimum, QUICK)
    frame = found.to_pandas()
    assert {*found} == {*frame["law"]} == {*optimum.by_law}
    assert [*zip(frame["key"], frame["price"], strict=True)] == [
        (each.key, each.price) for law in found for each in found[law]
    ]
    assert len(found.table().rows) == len(frame)
    assert found == dict(found)
    assert found.to_dict()["prices"][0]["key"] == frame["key"][0]
