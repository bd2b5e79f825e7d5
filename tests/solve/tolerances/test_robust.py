"""Robust smallest cams, for which every cam within the tolerances holds the limits, against scans."""

import itertools

import numpy as np
import pytest
from support.cams import cam_with
from support.depth import is_deep

import camopt
from camopt.core.mistakes import BadInput
from camopt.model.effects import EvaluationBlock
from camopt.scene.problem.problem import resolve, resolve_design, with_rounding_relative_error
from camopt.scene.problem.tolerance_zones import design_copies_with_errors
from camopt.scene.scene import Scene
from camopt.solve.front.table_certificate import certify_table
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_verdicts import relative_excesses_by_limit

GIVEN = {
    "roller": ({"offset": 0.2, "roller_radius": 0.1}, {"pressure_angle": 30, "curvature_radius": 2}),
    "offset-roller": ({"offset": {"plus": 0.3, "minus": 0.1}, "roller_radius": 0.05}, {"pressure_angle": 28}),
    "loaded": ({"offset": 0.3, "roller_radius": 0.2}, {"pressure_angle": 35, "contact_stress": 900}),
    "arm": ({"arm_length": 0.2, "centre_distance": 0.2}, {"pressure_angle": 40, "curvature_radius": 3}),
    "flat": ({"offset": 0.4}, {"face_reach": 30, "curvature_radius": 3}),
    "groove-arm": ({"arm_length": 0.5}, {"pressure_angle": 45}),
}
STEPS = 5
"""Of each size in a scan."""


def scene_of(contact, tolerances=None, **more):
    given, limits = GIVEN[contact]
    tolerances = given if tolerances is None else tolerances
    found = cam_with("roller" if contact == "loaded" else contact, "cycloidal", outputs=[])
    search = {"robust": True, **more.pop("search", {})}
    return Scene.from_dict(
        {"name": contact, **found, "limits": limits, "tolerances": {"follower": tolerances}, "search": search}
    )


def worst_excess(scene):
    """Of a dense scan of all cams within the tolerances: corners, sides and insides."""
    problem = with_rounding_relative_error(resolve_design(scene))
    spans = {field: np.linspace(zone.lower, zone.upper, STEPS) for field, zone in problem.zones.items()}
    offs = [dict(zip(spans, values, strict=True)) for values in itertools.product(*spans.values())]
    cams = design_copies_with_errors(problem.design, offs)
    limits = problem.without_deferred_limits.limits
    needs = frozenset(name for limit in limits for name in limit.required_quantities)
    return relative_excesses_by_limit(
        limits, run_effects(EvaluationBlock(problem.setup, problem.programme, cams), needs).columns, cams
    ).max()


def assert_smallest(scene):
    """A robust cam is proved, holds its limits in a scan of all cams, and a little smaller one does not."""
    best = camopt.optimise(scene).best
    assert (best["proved"], best["every_cam"]) == (True, "held")
    assert worst_excess(best.scene) <= 0.0
    size = next(name for name in ("base_radius_mm", "mean_radius_mm") if name in best)
    key = f"cam.{size.removesuffix('_mm')}"
    assert worst_excess(best.scene.replace(**{key: best[size] * (1.0 - 1e-6)})) > 0.0
    return best, size


@pytest.mark.one_in(2)
@pytest.mark.parametrize("contact", GIVEN)
def test_a_robust_cam_is_the_smallest_of_which_no_cam_within_the_tolerances_breaks_a_limit(contact):
    scene = scene_of(contact)
    best, size = assert_smallest(scene)
    assert set(camopt.certify(best.scene).values()) == {"held"}
    nominal = camopt.optimise(scene.replace(**{"search.robust": False})).best
    assert best["nominal_mm"] == nominal[size] <= best[size]
    assert best["safety_mm"] == pytest.approx(best[size] - nominal[size], abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("contact", GIVEN)
def test_random_robust_cams_are_the_smallest(contact, seed):
    rng = np.random.default_rng(seed)
    own = list(GIVEN[contact][0]) + (["roller_radius"] if contact == "arm" else [])
    zones = {key: dict(zip(("plus", "minus"), rng.uniform(0.0, 0.4, 2), strict=True)) for key in own}
    assert_smallest(scene_of(contact, zones))


def test_a_limit_that_only_a_cam_within_the_tolerances_breaks_is_named():
    search = {"robust": True, "base_radius": {"start": 20.0, "stop": 20.0}}
    asked = {"tolerances.follower.arm_length": 0.5, "limits.pressure_angle": 26.379}  # 26.3783 of the nominal cam
    miss = camopt.optimise(camopt.find_scene("rocker-valve").replace(search=search, **asked)).nearest_miss
    assert (miss["violated"], miss["pressure_angle_max_deg"] < 26.379) == ("pressure_angle", True)


@pytest.mark.parametrize("contact", ["roller", "arm"])
def test_zero_tolerances_give_the_nominal_answer_to_the_last_bit(contact):
    scene = scene_of(contact).replace(tolerances={"follower": dict.fromkeys(GIVEN[contact][0], 0.0)})
    robust, nominal = (camopt.optimise(each).best for each in (scene, scene.replace(**{"search.robust": False})))
    assert dict(robust) == dict(nominal)


def test_no_robust_cam_is_smaller_at_any_offset():
    """The closed form of free offsets, against the smallest cam of each of many."""
    scene = scene_of("roller", search={"offset": {"start": -8, "stop": 12}})
    best = camopt.optimise(scene).best
    assert (best["proved"], best["every_cam"]) == (True, "held")
    sizes = {}
    for offset in np.linspace(best["offset_mm"] - 0.02, best["offset_mm"] + 0.02, 5):
        fixed = scene.replace(**{"search.offset": None, "follower.offset": float(offset)})
        sizes[offset] = camopt.optimise(fixed).best["base_radius_mm"]
    assert best["base_radius_mm"] <= min(sizes.values()) * (1.0 + 1e-10)


def test_a_cam_is_refuted_if_some_cam_within_the_tolerances_breaks_a_limit():
    scene = scene_of("arm")
    nominal = camopt.optimise(scene.replace(**{"search.robust": False})).best.scene
    assert set(camopt.certify(nominal).values()) == {"held"}
    assert "broken" in camopt.certify(nominal.replace(**{"search.robust": True})).values()


def price_by_differences(scene, key, value, step):
    """mm of size per unit of a number of the scene."""
    ends = [camopt.optimise(scene.replace(**{key: value + by})).best["base_radius_mm"] for by in (-step, step)]
    return (ends[1] - ends[0]) / (2.0 * step)


def prices_of(scene, seconds=1e-3):
    return {price.key: price for price in next(iter(camopt.prices(camopt.optimise(scene), seconds).values()))}


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("contact", "toleranced"), [("arm", ["arm_length"]), ("roller", ["offset", "roller_radius"])]
)
def test_a_price_is_what_robust_cams_of_two_bounds_or_tolerances_differ_by(contact, toleranced):
    scene = scene_of(contact)
    costs, bound = prices_of(scene), scene.limits.pressure_angle
    of_limit = price_by_differences(scene, "limits.pressure_angle", bound, 0.01)
    assert costs["limits.pressure_angle"].price == pytest.approx(of_limit, rel=1e-3)
    for key in toleranced:
        price, zone = costs[f"tolerances.follower.{key}"], GIVEN[contact][0][key]
        assert (price.bound, price.unit) == (pytest.approx(1e3 * zone), "µm")
        of_mm = price_by_differences(scene, f"tolerances.follower.{key}", zone, 2e-4)
        assert price.price == price.tightened == pytest.approx(1e-3 * of_mm, rel=1e-4)


@pytest.mark.slow
def test_without_a_tolerance_the_smallest_cam_is_that_with_a_tolerance_of_0():
    scene = scene_of("roller")
    price = prices_of(scene, 20.0)["tolerances.follower.offset"]
    exact = camopt.optimise(scene.replace(**{"tolerances.follower.offset": 0.0})).best
    assert price.size_without == pytest.approx(exact["base_radius_mm"], rel=1e-9)
    assert price.next == ("limits.pressure_angle",)


@pytest.mark.slow
def test_a_tolerance_has_a_price_where_a_limit_on_errors_holds_the_cam():
    scene = Scene.from_dict({
        **{key: cam_with("roller", "cycloidal")[key] for key in ("cam", "follower", "motion")},
        "tolerances": {"profile": 0.02, "phase": 0.01},
        "limits": {"position_error": 0.026},
        "search": {"base_radius": [20, 200]},
    })  # fmt: skip
    costs = prices_of(scene)
    for key, value, unit in (("profile", 0.02, 1e-3), ("phase", 0.01, 1.0)):
        exact = unit * price_by_differences(scene, f"tolerances.{key}", value, 1e-5)
        assert costs[f"tolerances.{key}"].price == pytest.approx(exact, rel=1e-3)


@pytest.mark.long
def test_free_angles_are_proved_of_every_cam_with_its_own_train():
    """R_p = max (y'/tan α - y) of y = z/i, at the least ratio and with the longest strokes: a closed form."""
    ranges = {
        "base_radius": [10, 120], "angle_rise": [90, 130], "angle_dwell": [10, 100], "angle_return": [90, 130]
    }  # fmt: skip
    search = {key: {"start": low, "stop": high} for key, (low, high) in ranges.items()}
    scene = camopt.find_scene("pusher-by-lever").replace(
        part={},
        limits={"pressure_angle": 25},
        tolerances={"train.1.ratio": 0.02},
        search={**search, "robust": True},
    )
    best = camopt.optimise(scene).best
    longest = scene.replace(search={}, tolerances={}, motion=[
        {"segment": "rise", "angle": 130, "lift": 60, "law": "modified-sine"},
        {"segment": "dwell", "angle": 50},
        {"segment": "return", "angle": 130, "lift": 60, "law": "modified-sine"},
        {"segment": "dwell", "angle": 50},
    ])  # fmt: skip
    z, z1, *_ = resolve_design(longest).programme.tool.motion_at(np.linspace(0.0, np.pi, 400_001))
    exact = ((z1 / np.tan(np.radians(25.0)) - z) / 1.98).max() - 13.0
    assert best["base_radius_mm"] == pytest.approx(exact, rel=1e-8)
    assert (best["proved"], best["every_cam"]) == (True, "held")
    assert best["gap_mm"] < 1e-6


SECOND = {"drive.roller_radius": 0.02, "disc_phase": 0.02, "phase": 0.02, "profile": 0.01, "waves": 9}
SECOND |= {"follower.arm_length": 0.02}
LINKED = {"train.1.coupler": 0.05, "follower.arm_length": 0.03, "phase": 0.02, "profile": 0.01}


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "given", "limit", "keys"),
    [
        ("press-feed-by-pair", SECOND, {"velocity_error": 0.05}, ("drive.roller_radius", "disc_phase")),
        ("slide-by-bell-crank", LINKED, {"position_error": 0.0695}, ("train.1.coupler",)),
    ],
)
def test_tolerances_of_a_second_contact_and_of_links_have_prices_too(name, given, limit, keys):
    scene = camopt.find_scene(name).replace(
        part={}, limits=limit, tolerances=given, search={"base_radius": [40, 60]}
    )
    costs = prices_of(scene)
    for key in keys if is_deep() else keys[:1]:
        price = costs[f"tolerances.{key}"]
        unit = 1e-3 if price.unit == "µm" else 1.0
        exact = unit * price_by_differences(scene, f"tolerances.{key}", given[key], 2e-4 * given[key])
        assert price.price == pytest.approx(exact, rel=2e-3)


def test_an_error_that_is_infinite_whatever_the_size_stops_a_search_at_once():
    scene = Scene.from_dict({
        **{key: cam_with("roller", "parabolic")[key] for key in ("cam", "follower", "motion")},
        "tolerances": {"follower": {"offset": 0.02}},
        "limits": {"acceleration_error": 1.0},
        "search": {"base_radius": [20, 200]},
    })  # fmt: skip
    assert camopt.optimise(scene).obstacles == {"parabolic": "acceleration_error"}


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("order", ["position", "velocity"])
def test_limits_on_errors_are_those_of_the_nominal_cam_at_its_speed(order):
    """The table of errors, margins, certify and robust searches agree."""
    scene = Scene.from_dict(
        {
            **{key: cam_with("roller", "cycloidal")[key] for key in ("cam", "follower", "motion")},
            "tolerances": {"follower": {"offset": 0.02, "roller_radius": 0.01}, "cam": {"rpm": 30}},
            "search": {"base_radius": [20, 200], "robust": True},
        }
    )
    place = ("position", "velocity").index(order)
    free = scene.replace(**{f"limits.{order}_error": 0.016 if order == "position" else 0.0009})
    best = camopt.optimise(free).best
    assert best["every_cam"] == "held"
    assert best["binding"] == [f"{order}_error"]
    assert best["safety_mm"] == pytest.approx(0.0, abs=1e-9)
    bound, name = getattr(free.limits, f"{order}_error"), f"limits.{order}_error"
    found = camopt.tolerance(best.scene)
    assert found.errors[place].worst == pytest.approx(bound, rel=1e-6)
    assert all("cam.rpm" not in each.moving for each in found.margins)  # it is in the boxes, and moves none of them
    margin = next(each for each in found.margins if each.limit == f"{order}_error")
    assert (margin.nominal, margin.worst, margin.verdict) == (
        pytest.approx(bound, rel=1e-6),
        margin.nominal,
        "held",
    )
    for share, verdict in ((1.0, "held"), (1.0 - 1e-6, "broken")):
        assert camopt.certify(best.scene.replace(**{name: bound * share}))[f"{order}_error"] == verdict


@pytest.mark.slow
def test_a_sweep_keeps_designs_that_hold_the_limits_at_all_corners(tmp_path):
    search = {"base_radius": {"start": 20, "stop": 60, "step": 0.5}, "offset": [0, 4]}
    scene = scene_of("roller", search=search)
    swept, nominal = camopt.sweep(scene, tmp_path), camopt.sweep(scene.replace(**{"search.robust": False}))
    assert 0 < swept.feasible < nominal.feasible
    assert (swept.every_cam, nominal.every_cam) == ({"held": swept.pareto}, None)
    assert set(camopt.load(tmp_path / "pareto.parquet")["proof"]) == {"held"}
    assert certify_table(tmp_path / "pareto.parquet") == {"held": swept.pareto}
    assert camopt.sweep(scene, tmp_path).every_cam == swept.every_cam
    least = min(each["base_radius_mm"] for each in swept.best.values())
    found = {offset: scene.replace(**{"search": {"robust": True}, "follower.offset": offset}) for offset in (0, 4)}
    proved = min(camopt.optimise(each).best["base_radius_mm"] for each in found.values())
    assert least - 0.5 < proved <= least


def test_a_robust_search_names_what_it_lacks():
    with pytest.raises(BadInput, match="needs a tolerance of a size, such as"):
        resolve(scene_of("roller").replace(tolerances={"profile": 0.01}))
    of_class = {"search.roller_radius": [10, 12], "tolerances.follower.roller_radius": "h6"}
    with pytest.raises(BadInput, match=r"must be ± mm with .* or leave search\.roller_radius out"):
        resolve(scene_of("roller").replace(**of_class))
    search = {"base_radius": [60, 70]}
    with pytest.raises(BadInput, match=r"with search\.robust must be feasible or pareto"):
        camopt.sweep(scene_of("roller", search=search), keep="all")
    with pytest.raises(BadInput, match=r"omit it with search\.robust"):
        camopt.sweep(scene_of("roller", search={**search, "refine": True}))


@pytest.mark.slow
def test_free_laws_of_a_robust_cam_hold_its_limits_where_those_of_a_nominal_one_do_not():
    """The least acceleration within a radius: every cam within the tolerances is proved, and scanned."""
    asked = {"synthesis.pieces": 8, "synthesis.minimise": "acceleration", "cam.base_radius": 26}
    scene = scene_of("roller").replace(
        **asked, **{"limits.curvature_radius": None, "tolerances.follower.offset": 2.0}
    )
    found, nominal = camopt.synthesise(scene), camopt.synthesise(scene.replace(**{"search.robust": False}))
    assert found.bound <= nominal.objective < found.objective < 1.1 * nominal.objective
    assert (found.design["every_cam"], found.design["base_radius_mm"] <= 26.0, found.convex) == ("held", True, True)
    assert set(camopt.certify(found.scene).values()) == {"held"}
    assert worst_excess(found.scene) <= 0.0
    assert camopt.optimise(nominal.scene.replace(**{"search.robust": True})).best["base_radius_mm"] > 28.0


@pytest.mark.slow
def test_prices_of_robust_free_laws_are_what_those_of_two_bounds_differ_by():
    scene = scene_of("roller").replace(
        **{"synthesis.pieces": 8, "limits.curvature_radius": None, "tolerances.follower.offset": 1.0}
    )
    price = next(iter(camopt.prices(camopt.synthesise(scene)).values()))[0]
    sizes = [
        camopt.synthesise(scene.replace(**{"limits.pressure_angle": 30 + by})).design["base_radius_mm"]
        for by in (-0.05, 0.05)
    ]
    assert price.key == "limits.pressure_angle"
    assert price.price == pytest.approx((sizes[1] - sizes[0]) / 0.1, rel=1e-3)
