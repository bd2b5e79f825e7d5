"""Free laws of a tool: scaled scenes at a constant ratio, and local optima through a linkage."""

import numpy as np
import pytest
from support.depth import times

from camopt import BadInput, Scene, evaluate, find_scene, optimise, plot, shipped_scenes, synthesise
from camopt.core.quantities import DERIVATIVE_UNITS
from camopt.model.effects.motion import motion_table_unit
from camopt.scene.problem.problem import resolve
from camopt.solve.synthesis import term_units as objective_units
from camopt.solve.synthesis.cams import motion_holds_limits, programme_with_laws, smallest_cam_for_laws
from camopt.solve.synthesis.iterate import spline_and_fixed_motions
from camopt.solve.synthesis.nonconvex_constraints import SampledConstraints, nonconvex_constraints_of
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.relaxed_optimum import relaxation_bound
from camopt.solve.synthesis.sequential_convex import SequentialConvex
from camopt.solve.synthesis.synthesise import solve_free_laws, starting_laws

BASE = find_scene("roller-1000rpm").replace(
    **{
        "synthesis.pieces": 8,
        "search.roller_radius": None,
        "limits.pressure_angle_return": 36,
        "search.minimise": ["base_radius_mm"],
    }
)
SLIDE = find_scene("slide-by-bell-crank").replace(
    **{"synthesis.pieces": 6, "search.roller_radius": None, "search.base_radius": None}
)
TRAINS = {
    "as it is": ([{"stage": "ratio", "ratio": 1.0}], 1.0),
    "a lever": ([{"stage": "ratio", "ratio": 2.5}], 2.5),
    "a pinion": ([{"stage": "ratio", "radius": 20.0}], np.degrees(1.0 / 20.0)),
    "a wedge": ([{"stage": "incline", "angle": 30.0}], np.tan(np.radians(30.0))),
    "a chain": ([{"stage": "ratio", "ratio": -2.0}, {"stage": "ratio", "ratio": -0.5}], 1.0),
}


def scale_lifts(scene: Scene, factor: float) -> list[dict]:
    """The motion of a scene with other lifts."""
    motion = scene.to_dict()["motion"]
    return [each | ({"lift": each["lift"] * factor} if "lift" in each else {}) for each in motion]


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", TRAINS)
def test_at_a_constant_ratio_laws_are_those_of_the_scaled_scene(name):
    train, ratio = TRAINS[name]
    plain = synthesise(BASE)
    driven = synthesise(BASE.replace(train=train, motion=scale_lifts(BASE, ratio)))
    assert driven.objective == pytest.approx(plain.objective, rel=1e-7)
    assert driven.bound == pytest.approx(plain.bound, rel=1e-4)
    assert driven.bound <= driven.objective
    assert driven.convex == plain.convex
    assert evaluate(driven.scene)["feasible"]
    assert driven.design["offset_mm"] == pytest.approx(plain.design["offset_mm"], abs=1e-4)


@pytest.mark.slow
def test_a_contact_force_counts_what_a_lever_carries():
    """Masses and springs of the tool as those of the follower, times the square of the ratio; forces times it."""
    limit, ratio = {"limits.contact_force_min": 75.0}, 2.5
    own, less = ({"mass": m, "spring_rate": k, "preload": f} for m, k, f in ((0.3, 5.0, 200.0), (0.1, 2.0, 100.0)))
    tool = {"mass": 0.2 / ratio**2, "spring_rate": 3.0 / ratio**2, "preload": 100.0 / ratio}
    plain = synthesise(BASE.replace(**limit, **{"follower.dynamics": own}))
    lever = {"train": [{"stage": "ratio", "ratio": ratio, **tool}], "motion": scale_lifts(BASE, ratio)}
    driven = synthesise(BASE.replace(**limit, **lever, **{"follower.dynamics": less}))
    assert driven.objective == pytest.approx(plain.objective, rel=1e-6)
    assert driven.bound == pytest.approx(plain.bound, rel=1e-4)
    assert evaluate(driven.scene)["feasible"]
    assert plain.objective > 1.01 * synthesise(BASE).objective  # the limit counts


@pytest.mark.slow
def test_a_follower_that_goes_the_other_way_has_the_tools_rise_as_its_return():
    """Its cam is that of the other half turn; tables name laws by the strokes of the tool."""
    rise, high, fall, low = BASE.to_dict()["motion"]
    plain = BASE.replace(motion=[fall | {"segment": "rise"}, low, rise | {"segment": "return"}, high])
    driven = BASE.replace(train=[{"stage": "ratio", "ratio": -1.0}])
    smallest = [optimise(each.replace(**{"search.law": None})).best for each in (plain, driven)]
    assert smallest[1]["base_radius_mm"] == pytest.approx(smallest[0]["base_radius_mm"], rel=1e-9)
    laws = {"search.law_rise": ["cycloidal"], "search.law_return": ["poly345"], "search.law": None}
    best = optimise(driven.replace(**laws)).best
    assert (best["law_rise"], best["law_return"]) == ("cycloidal", "poly345")
    assert evaluate(best.scene)["feasible"]
    free = synthesise(driven)
    assert evaluate(free.scene)["feasible"]
    assert free.objective == pytest.approx(synthesise(plain).objective, rel=1e-6)


def test_planes_through_a_linkage_are_those_of_the_curves():
    """A small change of motion and sizes changes the curves, as planes say."""
    problem = build_synthesis_problem(SLIDE)
    model, start, _ = solve_free_laws(problem)
    constraints, rng = nonconvex_constraints_of(problem), np.random.default_rng(1)
    assert constraints
    for stroke, motion in zip(problem.strokes, spline_and_fixed_motions(model), strict=True):
        sampled = SampledConstraints(problem, stroke)
        if not any(map(sampled.is_limited_by, constraints)) or not stroke.is_law_replaceable:
            continue
        x = (np.arange(288) + 0.5) / 288
        state = problem.motion_unit * np.array(
            [by @ motion.coefficients.value + rest for by, rest in motion.derivative_matrices_at(x)]
        )
        sizes = 0.0, problem.size_unit * start.height + 40.0
        planes = sampled.tangent_planes(constraints, state, sizes)
        by = 1e-7 * problem.motion_unit * rng.uniform(-1.0, 1.0, (4, 1)) / stroke.angle ** np.arange(4)[:, None]
        moved = sampled.ratios_to_bounds(constraints, state + by, sizes) - sampled.ratios_to_bounds(
            constraints, state, sizes
        )
        told = (planes.motion * by[:, None]).sum(axis=0) / problem.motion_unit
        assert moved == pytest.approx(told, abs=1e-3 * np.abs(told).max() + 1e-9)


@pytest.mark.slow
def test_convex_steps_through_a_linkage_end_at_a_smaller_cam():
    """From the scene's own laws alone; there is no bound on the size."""
    problem = build_synthesis_problem(SLIDE)
    model, start, _ = solve_free_laws(problem)
    constraints, starts = nonconvex_constraints_of(problem), starting_laws(problem, start, ["size"])
    cam = smallest_cam_for_laws(
        SLIDE, problem, SequentialConvex(model, constraints).find_local_optimum(starts[1], constraints)
    )
    own = optimise(SLIDE.replace(search=None)).best
    assert evaluate(cam.scene)["feasible"]
    assert cam.objective < 0.9 * own["base_radius_mm"]
    assert relaxation_bound(problem) is None


@pytest.mark.parametrize("name", [each for each in shipped_scenes() if find_scene(each).train])
def test_what_free_laws_minimise_has_the_unit_of_the_tool(name):
    setup = resolve(find_scene(name)).setup
    units = [objective_units.term_unit(each, find_scene(name)) for each in DERIVATIVE_UNITS]
    assert units == [motion_table_unit(setup, order) for order, _ in enumerate(DERIVATIVE_UNITS, start=1)]


@pytest.mark.long
def test_laws_through_a_linkage_are_a_local_optimum():
    """No random laws near them have a smaller cam; its own laws have a larger one."""
    found = synthesise(SLIDE)
    own, row = optimise(SLIDE.replace(search=None)).best, evaluate(found.scene)
    diagrams = {ax.get_title("left"): ax.lines[-1].get_ydata() for ax in plot(found, known=[]).axes}
    assert np.nanmax(np.abs(diagrams["Acceleration, m/s²"])) == pytest.approx(
        row["acceleration_max_m_s2"], rel=1e-3
    )
    assert np.nanmax(diagrams["Displacement, mm"]) == pytest.approx(70.0)
    assert found.bound is None
    assert evaluate(found.scene)["feasible"]
    assert found.objective < 0.9 * own["base_radius_mm"]
    rng = np.random.default_rng(2)
    for _ in range(times(4, deep=60)):
        data = found.scene.to_dict()
        for law in data["laws"].values():
            values = np.array(law["coefficients"])
            values[3:-3] += 10.0 ** rng.uniform(-5.0, -2.0) * rng.uniform(-1.0, 1.0, values.size - 6)
            law["coefficients"] = values.tolist()
        near = optimise(Scene.from_dict(data).replace(search=None)).best
        assert near is None or near["base_radius_mm"] >= found.objective * (1.0 - 2e-3)


@pytest.mark.slow
def test_limits_at_the_follower_are_known_at_a_constant_ratio():
    train = {"train": [{"stage": "ratio", "ratio": 2.0}], "motion": scale_lifts(BASE, 2.0)}
    asked = {"limits.acceleration_max_follower_m_s2": 2200.0}
    found = synthesise(BASE.replace(**train, **asked))
    plain = synthesise(BASE.replace(**{"limits.acceleration": 2200.0}))
    assert found.objective == pytest.approx(plain.objective, rel=1e-6)
    problem = build_synthesis_problem(BASE.replace(**train, **asked))
    assert motion_holds_limits(problem, programme_with_laws(problem, solve_free_laws(problem)[1]))


def test_moves_through_a_train_need_a_lowest_position():
    motion = [{"segment": "move", "angle": 180, "to": 10}, {"segment": "move", "angle": 180, "to": 0}]
    with pytest.raises(BadInput, match="need a lowest position of the follower that the motion gives"):
        synthesise(BASE.replace(motion=motion, train=[{"stage": "ratio", "ratio": -2.0}]))


@pytest.mark.slow
def test_convex_steps_reach_the_local_optimum_behind_a_train():
    """With a penalty far above the price of the limit, 60 steps from each of 13 starts ended at 27.09 mm."""
    assert synthesise("slide-by-bell-crank").design["base_radius_mm"] < 26.886
