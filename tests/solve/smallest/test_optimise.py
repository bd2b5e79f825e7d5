"""The smallest cam against closed forms, brute force, scipy's optimisers and a peer package."""

import warnings
from math import radians, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize
from support import own
from support.depth import times
from support.smallest_cams import CASES, VALVE, scene, size_of

from camopt import BadInput, Scene, evaluate, find_scene, optimise
from camopt.model.mechanisms import Designs
from camopt.model.motion import LAWS
from camopt.model.motion.programme import weighted_derivative_range
from camopt.model.motion.stroke import DWELL, RETURN, RISE
from camopt.scene.problem.limits import keys_of_unset_build_limits
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.solve.verdicts.feasible_filter import feasible_designs
from camopt.solve.verdicts.limit_verdicts import evaluate_with_verdicts


@pytest.mark.parametrize(("law", "radius"), [("cycloidal", 82.5472265), ("harmonic", 60.1387819)])
def test_the_radius_of_a_radial_roller_cam(law, radius):
    """Known values; the peer package ``mechanism`` finds them by a root of its sampled pressure angle."""
    best = optimise(scene(**{"search.law": [law]})).best
    assert best["base_radius_mm"] == pytest.approx(radius, abs=1e-6)
    assert best["binding"] == ["pressure_angle_return"]
    from mechanism import Cam

    peer = Cam(
        [("Rise", 50, 120), ("Dwell", 60), ("Fall", 50, 90), ("Dwell", 90)],
        degrees=True,
        omega=1000 * np.pi / 30,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = peer.get_base_circle(kind=law, follower="roller", roller_radius=5, max_pressure_angle=30)
    assert best["base_radius_mm"] == pytest.approx(found["Rb"], abs=2e-3)


def test_limits_that_are_not_set_and_can_hold_the_cam_are_named():
    """Nothing sets the pressure angle of a flat face that translates, which is 0."""
    yoke = find_scene("pump-of-constant-breadth")
    asked = [yoke, yoke.replace(limits={"hub_wall": 5}), find_scene("two-pauses").replace(limits={})]
    problems = map(resolve, asked)
    assert [keys_of_unset_build_limits(each.limits, each.setup) for each in problems] == [
        ["hub_wall"],
        ["curvature_radius", "contact_stress"],
        ["pressure_angle", "curvature_radius", "hub_wall"],
    ]


def test_free_offset_gives_the_vertex_of_the_pressure_lines():
    """Issue tables of the field: prime radii 68.9 (3-4-5), 74.5 (cycloidal), 83.4 (4-5-6-7) at β ≤ 30°."""
    free = scene(
        **{"search.offset": {"start": -40, "stop": 40}, "search.law": ["poly345", "cycloidal", "poly4567"]}
    )
    by_law = optimise(free).by_law
    found = {law: row["prime_radius_mm"] for law, row in by_law.items()}
    assert found == {
        "poly345": pytest.approx(68.88469, abs=1e-4),
        "cycloidal": pytest.approx(74.53949, abs=1e-4),
        "poly4567": pytest.approx(83.35462, abs=1e-4),
    }
    for row in by_law.values():
        assert row["binding"] == ["pressure_angle", "pressure_angle_return"]
        assert row["proved"]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", CASES)
def test_no_grid_finds_a_smaller_cam(name):
    """The optimum is feasible, and a fine grid of smaller sizes (and free sizes) holds no feasible design."""
    problem = with_rounding_relative_error(resolve(CASES[name]))
    result = optimise(CASES[name])
    best = result.best
    assert best is not None, result.obstacles
    assert best["proved"]
    assert best["feasible"]
    size = size_of(best)
    rng = np.random.default_rng(0)
    count = 20000
    sizes = {n: np.full(count, v[0]) for n, v in problem.design.sizes.items()}
    sizes["size"] = np.linspace(1e-6, size - 1e-6, count)
    for key, field in (("offset", "offset"), ("roller_radius", "roller_radius")):
        choice = getattr(CASES[name].search, key)
        if choice is not None:
            sizes[field] = rng.uniform(choice.start, choice.stop, count)
    grid = Designs(**sizes, sense=problem.design.sense)
    smaller = feasible_designs(problem, grid)
    assert not smaller.any(), grid.size[smaller].min()


@pytest.mark.parametrize("name", ["pressure binds, offset given", "curvature binds", "flat", "oscillating"])
@pytest.mark.parametrize("scale", [1e-6, 1e-2, 1e3])
def test_a_scene_in_other_units_of_length_has_the_same_cam_and_proof(name, scale):
    """All lengths times a factor: the least size too, and what it may be smaller by is 1e-9 of the prime radius."""
    data = CASES[name].replace(**{"cam.rpm": None}).to_dict()
    data["cam"]["base_radius"] *= scale
    for key in ("roller_radius", "offset", "arm_length", "centre_distance"):
        data["follower"].update({key: data["follower"][key] * scale} if key in data["follower"] else {})
    for segment in data["motion"] if CASES[name].follower.motion == "translating" else ():
        segment.update({"lift": segment["lift"] * scale} if "lift" in segment else {})
    data["limits"].update({"curvature_radius": scale * data["limits"].get("curvature_radius", 0.0)})
    data["limits"] = {key: bound for key, bound in data["limits"].items() if bound}
    best, scaled = optimise(CASES[name]).best, optimise(Scene.from_dict(data)).best
    assert size_of(scaled) == pytest.approx(scale * size_of(best), rel=3e-9)
    assert scaled["proved"]
    assert 0.0 <= scaled["gap_mm"] <= 1e-9 * scaled.get("prime_radius_mm", size_of(scaled))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pressure binds, offset free", "curvature binds, offset free", "roller free"])
def test_never_larger_than_scipy_finds(name):
    """Differential evolution on size with a penalty; feasibility by the same limits."""
    problem, case = with_rounding_relative_error(resolve(CASES[name])), CASES[name]
    best = size_of(optimise(case).best)
    free = [key for key in ("offset", "roller_radius") if getattr(case.search, key) is not None]

    def cost(x):
        sizes = {n: np.full(x.shape[1], v[0]) for n, v in problem.design.sizes.items()}
        sizes |= {"size": x[0]} | dict(zip(free, x[1:], strict=True))
        held = feasible_designs(problem, Designs(**sizes, sense=problem.design.sense))
        return np.where(held, 0.0, 1e3) + x[0]

    bounds = [(1.0, 200.0)] + [(getattr(case.search, k).start, getattr(case.search, k).stop) for k in free]
    rival = optimize.differential_evolution(
        cost, bounds, seed=1, maxiter=120, popsize=12, tol=1e-10, polish=False, updating="deferred", vectorized=True
    )
    assert best <= rival.fun + 1e-6
    assert rival.fun == pytest.approx(best, rel=0.02)  # scipy saw the same problem


def test_the_least_feasible_radius_may_lie_below_an_infeasible_gap():
    """Where large cams fail, as with an oscillating follower, nothing is clear above the optimum."""
    best = optimise(CASES["oscillating"]).best
    assert best["clear_above_mm"] > best["base_radius_mm"]


@pytest.mark.one_in(5)
@pytest.mark.parametrize("law", ["parabolic", "cycloidal", "poly4567"])
@pytest.mark.parametrize("lift", [10, 25, 40])
@pytest.mark.parametrize("radius", [4, 10, 30])
def test_a_dense_scan_of_sizes_finds_the_same_least_radius(law, lift, radius):
    """Under a curvature limit a bisection could miss a feasible island; a scan of 6000 sizes cannot."""
    motion = [{**s, **({"lift": lift, "law": law} if "lift" in s else {})} for s in VALVE]
    sizes = {"follower.roller_radius": 10, "follower.offset": 4}
    case = scene(motion=motion, **sizes, limits={"curvature_radius": radius})
    problem = with_rounding_relative_error(resolve(case))
    fixed = {n: np.full(6000, v[0]) for n, v in problem.design.sizes.items()}
    radii = np.linspace(0.05, 300, 6000)
    held = feasible_designs(problem, Designs(**{**fixed, "size": radii}, sense=problem.design.sense))
    scanned = radii[np.argmax(held)]
    assert scanned - 0.051 < size_of(optimise(case).best) <= scanned + 1e-9


@pytest.mark.parametrize("name", CASES)
def test_the_optimum_evaluates_to_itself(name):
    """Put back into its scene, the optimum is feasible and one part in a million smaller is not."""
    case, best = CASES[name], optimise(CASES[name]).best
    key = "cam.base_radius" if "base_radius_mm" in best else "cam.mean_radius"
    sizes = {f"follower.{n}": best[f"{n}_mm"] for n in ("roller_radius", "offset") if case.search.__dict__.get(n)}
    again = evaluate(case.replace(**{key: size_of(best), **sizes}))
    assert again["feasible"]
    shrunk = case.replace(**{key: size_of(best) - 3e-6, **sizes, "cam.shaft_diameter": None, "part": None})
    if not {"shaft_diameter", "hub_diameter"} & {*best["binding"]}:
        assert not evaluate(shrunk)["feasible"]


@given(
    law=st.sampled_from([law for law in own.STILL if law in LAWS]),
    limit=st.floats(15, 60),
    other=st.floats(15, 60),
    rise=st.floats(40, 150),
    fall=st.floats(40, 150),
    lift=st.floats(1, 60),
    offset=st.floats(0, 30),
)
@settings(max_examples=times(13, deep=250))
def test_the_closed_form_holds_its_limits_and_touches_one(law, limit, other, rise, fall, lift, offset):
    segments = [
        {"segment": "rise", "angle": rise, "lift": lift, "law": law},
        {"segment": "return", "angle": fall, "lift": lift, "law": law},
        {"segment": "dwell", "angle": 360 - rise - fall},
    ]
    case = scene(
        motion=segments,
        **{
            "limits": {"pressure_angle": limit, "pressure_angle_return": other},
            "search.offset": {"start": -offset, "stop": offset},
            "follower.contact": "knife",
            "follower.roller_radius": None,
        },
    )
    best = optimise(case).best
    assert best["pressure_angle_max_rise_deg"] <= limit
    assert best["pressure_angle_max_return_deg"] <= other
    assert best["binding"]
    lead = -best["offset_mm"]  # cw
    s0 = np.sqrt(best["prime_radius_mm"] ** 2 - lead**2)
    problem = with_rounding_relative_error(resolve(case))
    for tangent, kinds in ((tan(radians(limit)), RISE | DWELL), (tan(radians(other)), RETURN)):
        rises = weighted_derivative_range(problem.programme, (-tangent, 1.0), kinds)[1]
        falls = -weighted_derivative_range(problem.programme, (tangent, 1.0), kinds)[0]
        assert lead + tangent * s0 >= rises - 1e-9 * lift
        assert -lead + tangent * s0 >= falls - 1e-9 * lift


def test_nothing_that_limits_the_size_is_a_mistake():
    knife = scene(**{"follower.contact": "knife", "follower.roller_radius": None, "limits": None})
    with pytest.raises(BadInput, match="limits"):
        optimise(knife)


def test_an_impossible_limit_is_named():
    result = optimise(scene(**{"limits.acceleration": 10, "search.law": ["cycloidal", "harmonic"]}))
    assert result.best is None
    assert result.obstacles == {"cycloidal": "acceleration", "harmonic": "acceleration"}


def test_uniform_velocity_stops_a_roller():
    result = optimise(scene(**{"search.law": ["uniform"]}))
    assert result.best is None
    assert "undercut" in result.obstacles["uniform"]


def test_default_scene_names_its_laws_best_first():
    by_law = optimise(find_scene("roller-1000rpm")).by_law
    sizes = [row["base_radius_mm"] for row in by_law.values()]
    assert sizes == sorted(sizes)
    assert len(by_law) == 7


def test_limits_are_judged_on_every_row_the_same_way():
    problem = with_rounding_relative_error(resolve(CASES["pressure binds, offset free"]))
    rows = evaluate_with_verdicts(problem, problem.design, frozenset())
    assert rows.records()[0]["feasible"] is False


FREED = {
    "arm and centre": ("oscillating", {"arm_length": (80, 140), "centre_distance": (100, 160)}),
    "arm, centre and roller": (
        "oscillating",
        {"arm_length": (80, 140), "centre_distance": (100, 160), "roller_radius": (5, 15)},
    ),
    "offset of the face": ("oscillating flat", {"face_offset": (-5, 15)}),
    "centre of the face": ("oscillating flat", {"centre_distance": (80, 150)}),
    "arm of a groove": ("cylindrical oscillating", {"arm_length": (60, 150)}),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", FREED)
def test_the_lengths_of_followers_that_swing_are_searched_whole(name):
    """No design of a cloud that closes in on its best one is smaller, and the cloud comes near."""
    case, ranges = FREED[name]
    ends = {f"search.{key}": {"start": a, "stop": b} for key, (a, b) in ranges.items()}
    freed = CASES[case].replace(**ends)
    best, problem = optimise(freed).best, with_rounding_relative_error(resolve(freed))
    assert best["proved"]
    rng, count, least, centre = np.random.default_rng(0), 20000, np.inf, None
    spans = {**ranges, "size": (0.0, 1.5 * size_of(best))}
    for width in (1.0, 1.0, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3):
        sizes = {n: np.full(count, v[0]) for n, v in problem.design.sizes.items()}
        for field, (a, b) in spans.items():
            near = rng.uniform(a, b, count) if centre is None else rng.normal(centre[field], width * (b - a), count)
            sizes[field] = np.clip(near, a, b)
        cloud = Designs(**sizes, sense=problem.design.sense)
        cloud = cloud.take(feasible_designs(problem, cloud))
        if len(cloud) and cloud.size.min() < least:
            least = cloud.size.min()
            centre = {n: v[cloud.size.argmin()] for n, v in cloud.sizes.items()}
    assert size_of(best) <= least + 1e-7
    assert least == pytest.approx(size_of(best), rel=2e-3)


@pytest.mark.slow
def test_when_time_is_over_nobody_looks_for_reasons(monkeypatch):
    """What the nearest misses break is told: a reason for each law and roller takes ten times the time given."""

    def fail_if_called(*arguments):
        raise AssertionError("a reason is looked for")

    monkeypatch.setattr("camopt.solve.smallest.optimise.find_infeasibility", fail_if_called)
    found = optimise(find_scene("roller-1000rpm").replace(**{"limits.pressure_angle": 3}), seconds=1e-9)
    assert all(
        why.startswith("pressure_angle") and why.endswith("(not proved)") for why in found.obstacles.values()
    )
