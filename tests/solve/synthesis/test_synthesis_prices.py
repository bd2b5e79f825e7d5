"""Prices of what holds free laws: against the least objectives of two programmes, and against other syntheses."""

import json
from contextlib import suppress
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support.depth import times
from test_synthesis import DYNAMICS, VALVE, changed_scene, free

from camopt import Unmet, Unsolved, find_scene, prices, synthesise
from camopt.cli.main import main
from camopt.scene.problem.problem import resolve
from camopt.solve.synthesis.convex_model import build_convex_model
from camopt.solve.synthesis.problem_from_scene import (
    build_synthesis_problem,
    default_peak_factors,
    split_by_listed_offset_or_arm,
)
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import tighten_limits

COARSE = find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
CASES = {
    "size": COARSE,
    "jerk": COARSE.replace(**{"synthesis.minimise": "jerk", "search.base_radius": {"start": 20, "stop": 42}}),
    "mean square": COARSE.replace(
        **{"synthesis.minimise": "acceleration_rms", "search.base_radius": {"start": 20, "stop": 38}}
    ),
    "lift area": COARSE.replace(
        **{"synthesis.minimise": "lost_lift_area", "search.base_radius": {"start": 20, "stop": 42}}
    ),
    "two terms": COARSE.replace(
        **{"synthesis.minimise": {"size": 1, "jerk": 1e-3}, "limits.acceleration": 4000, "synthesis.rest": 2}
    ),
    "a range of the peak": COARSE.replace(
        **{"synthesis.peak_acceleration": [-6, 7], "synthesis.peak_velocity": 2.0}
    ),
    "the peak of a law": COARSE.replace(**{"synthesis.peak_acceleration": "cycloidal"}),
    "an end of the offset": COARSE.replace(**{"search.offset": {"start": 0, "stop": 3}}),
    "listed offsets": COARSE.replace(**{"search.offset": [0, 4, 8]}),
    "an acceleration": COARSE.replace(**{"limits.acceleration": 1500}),
    "the least radius": COARSE.replace(**{"limits.jerk": 2e6}),
    "a shaft": COARSE.replace(**{"cam.shaft_diameter": 90, "search.base_radius": None}),
    "a flat face": find_scene("bucket-valve").replace(**{"synthesis.pieces": 12}),
    "moves": find_scene("belt-matching").replace(**{"synthesis.pieces": 12}),
    "a dwell and a stop": find_scene("feeder-with-stop").replace(**{"synthesis.pieces": 12}),
}


def prices_of(result):
    (found,) = prices(result).values()
    return found


@cache
def prices_of_case(name):
    """The prices of a case: tests share its synthesis."""
    return prices_of(free(CASES[name]))


def with_bound(case, key, value):
    """A scene with another value of a bound; what it takes by default does not change."""
    *names, last = key.split(".")
    if last.isdecimal():
        pair = list(getattr(case.synthesis, names[-1]))
        pair[int(last) - 1] = value
        return case.replace(**{".".join(names): pair})
    kept = {f"synthesis.{name}": peak for name, peak in default_peak_factors(case).items()}
    return case.replace(**{**(kept if key in kept else {}), key: value})


@cache
def least_objective(case):
    """The least objective of the convex programmes of a scene."""
    return min(
        build_convex_model(tighten_limits(d, 1e-7), SplineMotion).solve()
        for d in split_by_listed_offset_or_arm(build_synthesis_problem(case))
    )


@pytest.mark.slow
@pytest.mark.one_in(16)
@pytest.mark.parametrize("name", CASES)
def test_a_price_is_the_derivative_of_the_least_objective(name):
    case = CASES[name]
    found = prices_of_case(name)
    assert found
    for price in found:
        assert price.price == price.tightened
        step = 5e-4 * abs(price.bound)
        below, above = (least_objective(with_bound(case, price.key, price.bound + k * step)) for k in (-1, 1))
        by_differences = (above - below) / (2.0 * step)
        assert price.price == pytest.approx(by_differences, rel=1e-2), price.key


@pytest.mark.slow
@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", CASES)
def test_what_has_no_price_may_change_a_little(name):
    """Of the limits on pressure angles and motions: with another bound the objective is the same."""
    case = CASES[name]
    costly = {price.key for price in prices_of_case(name)}
    limits = {limit.key for limit in resolve(case).limits if limit.set_by_scene and limit.constraints} - costly
    for key in limits - {"limits.curvature_radius"}:
        eased = case.replace(**{key: 1.001 * case.numbers([key])[key]})
        assert least_objective(eased) == pytest.approx(least_objective(case), rel=1e-6)


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("key", ["limits.pressure_angle", "limits.pressure_angle_return", "synthesis.peak_jerk"])
def test_so_much_smaller_is_the_cam_of_another_synthesis(key):
    """The cam itself, proved, not the optimum of a programme; other laws, a bound eased and tightened by 2 %."""
    price = next(each for each in prices_of_case("size") if each.key == key)
    step = 0.02 * price.bound
    sizes = [synthesise(with_bound(COARSE, key, price.bound + k * step)).objective for k in (-1, 1)]
    assert (sizes[1] - sizes[0]) / (2.0 * step) == pytest.approx(price.price, rel=0.02)


@pytest.mark.long
def test_a_larger_cam_costs_more_per_degree_and_as_much_per_mm():
    case = CASES["an end of the offset"].replace(**{"cam.rpm": None, "search.minimise": None})
    data = case.to_dict()
    data["cam"]["base_radius"] *= 3.0
    data["follower"]["roller_radius"] *= 3.0
    data["limits"]["curvature_radius"] *= 3.0
    for key in ("offset", "base_radius"):
        data["search"][key] = {name: 3.0 * end for name, end in data["search"][key].items() if name != "step"}
    for segment in data["motion"]:
        segment.update({"lift": segment["lift"] * 3.0} if "lift" in segment else {})
    own, scaled = (
        {p.key: p.price for p in prices_of(free(type(case).from_dict(d)))} for d in (case.to_dict(), data)
    )
    assert own.keys() == scaled.keys()
    assert "search.offset.stop" in own
    for key, price in own.items():
        assert scaled[key] == pytest.approx(price if key.startswith("search.") else 3.0 * price, rel=1e-3)


@pytest.mark.slow
def test_bounds_at_the_end_of_what_they_may_be_have_prices_too():
    """An offset that may not change, a jamming margin of 1, a shaft as large as the scene's own cam."""
    fixed = COARSE.replace(**{"search.offset": {"start": 3, "stop": 3}})
    found = {price.key: price.price for price in prices_of(synthesise(fixed))}
    step = 1e-3
    sizes = [
        least_objective(COARSE.replace(**{"search.offset": {"start": e, "stop": e}})) for e in (3 - step, 3 + step)
    ]
    both = sum(found.get(f"search.offset.{end}", 0.0) for end in ("start", "stop"))
    assert both == pytest.approx((sizes[1] - sizes[0]) / (2.0 * step), rel=1e-3)
    shaft = COARSE.replace(**{"cam.shaft_diameter": 90, "cam.base_radius": 45, "search.base_radius": None})
    (price,) = prices_of(synthesise(shaft))
    assert (price.key, price.price) == ("cam.shaft_diameter", pytest.approx(0.5, rel=1e-6))


PEAKS = st.one_of(st.none(), st.floats(3.0, 20.0), st.tuples(st.sampled_from([-9.0, -4.0, 0.0]), st.floats(3, 20)))


@pytest.mark.slow
@given(
    peaks=st.tuples(
        st.one_of(st.none(), st.floats(1.3, 3.0), st.just([0, 2])), PEAKS, st.none() | st.floats(40, 300)
    ),
    limits=st.tuples(st.floats(1, 89.9), st.none() | st.floats(5, 89), st.none() | st.floats(0.1, 1e6)),
    offset=st.sampled_from([None, {"start": -5, "stop": -5}, {"start": -9, "stop": 0}, [0, 3]]),
    minimise=st.sampled_from(["size", "jerk", "acceleration_rms", {"size": 1.0, "velocity": 2.0}]),
)
@settings(max_examples=times(2, deep=150))
def test_whatever_is_asked_prices_are_finite(peaks, limits, offset, minimise):
    names = ("peak_velocity", "peak_acceleration", "peak_jerk")
    asked = {**{f"synthesis.{name}": peak for name, peak in zip(names, peaks, strict=True)}, "synthesis.pieces": 6}
    bounds = dict(zip(("pressure_angle", "pressure_angle_return", "acceleration"), limits, strict=True))
    bounds = {name: bound for name, bound in bounds.items() if bound is not None}
    case = COARSE.replace(**asked, limits=bounds, **{"search.offset": offset, "synthesis.minimise": minimise})
    result = None
    with suppress(Unmet, Unsolved):
        result = synthesise(case)
    assume(result)
    for price in prices_of(result):
        assert np.isfinite(price.price)
        assert price.price * {"≤": -1.0, "±": -1.0, "≥": 1.0}[price.relation] > 0.0


CURVED = changed_scene(VALVE, limits__pressure_angle=None, synthesis__pieces=12)
LOCAL = {
    "curvature and pressure": (changed_scene(VALVE, synthesis__pieces=12), "limits.pressure_angle"),
    "curvature alone": (CURVED, "limits.curvature_radius"),
    "undercut": (find_scene("exhaust-valve").replace(**{"synthesis.pieces": 12}), "synthesis.peak_jerk"),
    "torque": (
        changed_scene(follower__dynamics=DYNAMICS, limits__torque=205, synthesis__pieces=12),
        "limits.pressure_angle",
    ),
}
"""Scenes, and a bound of each that other syntheses change."""


@pytest.mark.long
@pytest.mark.parametrize("name", LOCAL)
def test_a_local_optimum_has_prices_within_a_few_per_cent(name):
    case, key = LOCAL[name]
    result = synthesise(case)
    assert not result.convex
    found = {price.key: price for price in prices_of(result)}
    step = 0.02 * found[key].bound
    sizes = [synthesise(with_bound(case, key, found[key].bound + k * step)).objective for k in (-1, 1)]
    assert (sizes[1] - sizes[0]) / (2.0 * step) == pytest.approx(found[key].price, rel=0.05)


@pytest.mark.slow
def test_a_list_of_offsets_has_no_prices_where_the_optimum_is_local():
    listed = changed_scene(VALVE, synthesis__pieces=12).replace(**{"search.offset": [5, 7]})
    assert prices_of(synthesise(listed)) == []


@pytest.mark.slow
def test_the_command_prints_prices(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "coarse.toml").write_text(COARSE.to_toml(), encoding="utf-8")
    assert main(["synthesise", "coarse.toml", "--quiet"]) == 0
    text = capsys.readouterr().out
    assert "What each limit costs" in text
    assert "mm per deg" in text
    assert "mm per unit" in text
    assert main(["synthesise", "coarse.toml", "--quiet", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["prices"]
    expected = prices_of_case("size")
    assert [price["key"] for price in found] == [price.key for price in expected]
    assert [price["price"] for price in found] == pytest.approx([price.price for price in expected], rel=1e-6)
