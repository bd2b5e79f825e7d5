"""Self-crossing of disc cams: proof against polygons, enclosures against points, witnesses against roots."""

from dataclasses import replace
from itertools import product
from math import degrees, inf, radians

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import fsolve, minimize_scalar
from shapely import LinearRing
from support.depth import times

from camopt import Scene, certify, evaluate, find_scene, load, optimise, sweep
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.core.numerics.curves import value_and_slope
from camopt.core.numerics.interval import Interval, as_interval
from camopt.model.effects import EvaluationBlock, Setup
from camopt.model.effects.profile_parts import enclose_profile, initial_turn_parts
from camopt.model.effects.self_crossing import pressure_angle_proves_no_crossing, self_crossing_verdict
from camopt.model.effects.self_crossing_boxes import (
    KnownCrossings,
    box_overlap,
    largest_overlap_angles,
    profile_overlaps,
    refine_overlap_angles,
)
from camopt.model.mechanisms import MECHANISMS, Designs
from camopt.model.mechanisms.elements import FLAT, KNIFE, ROLLER
from camopt.model.mechanisms.geometry import cam_curves, profile_points
from camopt.model.motion import LAWS
from camopt.model.motion.programme import Programme
from camopt.scene.problem import limits
from camopt.scene.problem.problem import Problem, resolve, with_rounding_relative_error
from camopt.scene.problem.space import search_boxes
from camopt.solve.smallest.branch_and_bound import branch_and_bound
from camopt.solve.smallest.grid_search import shrink_on_grids
from camopt.solve.smallest.optimise import _size_above_which_cams_are_feasible
from camopt.solve.smallest.result import SmallestCam, empty_known_crossings, first_feasible_design
from camopt.solve.smallest.smallest import _solve_without_deferred_limits as least_of_others
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_verdicts import quantities_with_excess_bounds

DISC = [key for key in MECHANISMS if key[0] == "disc"]
ROUND = [key for key in DISC if not key[2]]


def turn_of(rise, top, fall, lift, laws, *, angular=False) -> Programme:
    segments = [
        ("rise", rise, lift, laws[0]),
        ("dwell", top, 0.0, None),
        ("return", fall, lift, laws[1]),
        ("dwell", 360.0 - rise - top - fall, 0.0, None),
    ]
    return Programme.from_segments(segments, angular=angular)


@st.composite
def cases(draw, keys=DISC, slimmest=0.3) -> EvaluationBlock:
    """A disc cam, from stout to so slim that opposite flanks cross."""
    key = draw(st.sampled_from(keys))
    angular, flat = key[1] == "oscillating", key[2]
    rise, fall = draw(st.floats(15, 150)), draw(st.floats(15, 150))
    lift = draw(st.floats(2, 80) if angular else st.floats(1, 160))
    laws = [draw(st.sampled_from(list(LAWS))) for _ in range(2)]
    turn = turn_of(rise, draw(st.floats(0.01, 1)) * (360 - rise - fall) / 2, fall, lift, laws, angular=angular)
    radius = 0.0 if flat else draw(st.sampled_from([0.0, 1.0])) * draw(st.floats(0.5, 20))
    size = max(radius, 5.0) * 10 ** draw(st.floats(-slimmest, 1))
    sizes = {
        "size": size,
        "roller_radius": radius,
        "offset": 0.0 if angular else draw(st.floats(-0.95, 0.95)) * (size + radius),
        "arm_length": draw(st.floats(60, 200)) if angular and not flat else 0.0,
        "centre_distance": draw(st.floats(60, 200)) if angular else 0.0,
        "face_offset": draw(st.floats(-5, 15)),
        "roller_spacing": 0.0,
    }
    design = Designs(**{n: np.array([v]) for n, v in sizes.items()}, sense=draw(st.sampled_from([1.0, -1.0])))
    assume(MECHANISMS[key].can_assemble(design, turn)[0])
    tip = FLAT if flat else ROLLER if radius else KNIFE
    return EvaluationBlock(Setup(MECHANISMS[key], tip), turn, design)


def points_of(case: EvaluationBlock, angles) -> np.ndarray:
    return profile_points(case.setup.mechanism, case.designs, case.programme, np.asarray(angles, dtype=float))


def polygon_crosses(case: EvaluationBlock) -> bool:
    """The slow, obvious rival: the profile as a polygon of some thousand sides."""
    strokes = [s.start + s.angle * np.linspace(0, 1, 3000, endpoint=False) for s in case.programme.strokes]
    points = points_of(case, np.concatenate(strokes))
    return not LinearRing(np.column_stack([points.real, points.imag])).is_simple


def undercut(case: EvaluationBlock) -> bool:
    return bool(run_effects(case, ["undercut"]).column("undercut")[0])


def self_crossing(case: EvaluationBlock) -> bool:
    return bool(run_effects(case, ["self_crossing"]).column("self_crossing")[0])


@pytest.mark.slow
@settings(max_examples=times(75, deep=1500))
@given(case=cases(slimmest=2))
def test_the_proof_agrees_with_a_polygon(case):
    """An undercut may be too small for a polygon to show; all else agrees."""
    if undercut(case):
        assert self_crossing(case)
    else:
        assert self_crossing(case) == polygon_crosses(case)


@settings(max_examples=times(20, deep=1000))
@given(case=cases(keys=ROUND, slimmest=2), share=st.lists(st.floats(-0.999999, 0.999999), min_size=20, max_size=20))
def test_parts_enclose_the_profile(case, share):
    """Inside of them: at an end, a corner of the motion may already have turned the normal."""
    assume(not undercut(case))
    parts = initial_turn_parts(case.programme)
    found = enclose_profile(case.setup, case.designs, case.programme, parts)
    starts, ends = parts.middle - parts.half, parts.middle + parts.half
    assert starts[0] == pytest.approx(0.0, abs=1e-15)
    assert ends[-1] == pytest.approx(2 * np.pi, rel=1e-15)
    assert ends[:-1] == pytest.approx(starts[1:], rel=1e-14)
    angles = parts.middle + np.array(share)[:, None] * parts.half
    away = points_of(case, angles) - found.point
    travel = case.setup.mechanism.trace_and_normal(case.designs, case.programme, angles)
    normal = np.exp(-1j * case.designs.sense * angles) * travel.normal
    assert np.all(np.abs(away) <= found.radius)
    assert np.all(np.abs((found.tangent.conj() * away).imag) <= found.bulge)
    assert np.all(np.abs(np.angle(normal / found.normal)) <= found.spread)


@settings(max_examples=times(30, deep=600))
@given(case=cases(keys=ROUND, slimmest=2), exponent=st.sampled_from([-9, 5]))
def test_mirrored_and_scaled_cams_have_the_same_verdict(case, exponent):
    """Mirrored: the cam turns the other way, with the offset on the other side. Scaled: by a power of two.

    An oscillating follower, whose pivot stays to the right, has no mirror image here.
    """
    assume(not undercut(case))
    found = self_crossing_verdict(case.setup, case.designs, case.programme)
    if not case.setup.angular:
        other = replace(case.designs, sense=-case.designs.sense, offset=-case.designs.offset)
        assert self_crossing_verdict(case.setup, other, case.programme) == found
    scale, strokes = 2.0**exponent, case.programme.strokes
    if not case.setup.angular:
        strokes = tuple(replace(s, low=s.low * scale, high=s.high * scale) for s in strokes)
    larger = Designs(**{n: v * scale for n, v in case.designs.sizes.items()}, sense=case.designs.sense)
    assert self_crossing_verdict(case.setup, larger, Programme(strokes)) == found


def slim_cams(count: int, key) -> list[EvaluationBlock]:
    """Cams with a large roller and a lobe that may be narrower at its neck than at its top."""
    random, made, angular = np.random.default_rng(11), [], key[1] == "oscillating"
    while len(made) < count:
        rise, fall, lift = random.uniform(15, 60), random.uniform(15, 60), random.uniform(40, 85)
        laws = random.choice(["parabolic", "cycloidal", "modified-sine"], 2)
        turn = turn_of(rise, random.uniform(2, 30), fall, lift * (1 if angular else 2), laws, angular=angular)
        radius, arm = random.uniform(2, 15), random.uniform(120, 160) * angular
        sizes = (radius * random.uniform(0.05, 0.6), radius, 0.0, arm, arm * random.uniform(0.95, 1.05), 0.0)
        design = Designs(*(np.array([size]) for size in sizes), np.zeros(1), sense=1.0)
        case = EvaluationBlock(Setup(MECHANISMS[key], ROLLER), turn, design)
        if MECHANISMS[key].can_assemble(design, turn)[0] and not undercut(case):
            made.append(case)
    return made


@pytest.mark.one_in(2)
@pytest.mark.parametrize("key", ROUND)
def test_a_crossing_shown_is_a_root(key):
    """The two angles lead Newton's method to one point of the profile at two cam angles, along two directions."""
    shown = 0
    for case in slim_cams(60, key):
        found = self_crossing_verdict(case.setup, case.designs, case.programme)
        assert found.crosses is polygon_crosses(case)
        if not found.crosses:
            continue

        def gap(angles, case=case):
            first, second = points_of(case, angles)
            return [(first - second).real, (first - second).imag]

        roots, report, _, _ = fsolve(gap, found.angles, full_output=True, xtol=1e-14)
        size = float(case.designs.prime_radius[0])
        assert np.hypot(*report["fvec"]) < 1e-11 * size
        assert np.abs(roots - found.angles).max() <= found.within + 1e-12
        shown += 1
    assert shown > 10


@settings(max_examples=times(30, deep=600))
@given(case=cases(keys=ROUND))
def test_a_knife_edge_draws_no_crossing(case):
    """Where the distance from the centre is the same, so are displacement and cam angle."""
    designs = replace(case.designs, roller_radius=np.zeros(1))
    edge = replace(case, setup=replace(case.setup, tip=KNIFE), designs=designs)
    assume(edge.setup.mechanism.can_assemble(edge.designs, edge.programme)[0])
    assert not self_crossing(edge)
    assert not polygon_crosses(edge)


def lobe(roller: float, prime: float = 8.0, law: str = "parabolic") -> Scene:
    """A lobe with flanks so steep that rollers at their feet come near to each other. Mirror symmetric."""
    rise, fall = ({"segment": kind, "angle": 40, "lift": 160, "law": law} for kind in ("rise", "return"))
    return Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": prime - roller},
            "follower": {"motion": "translating", "contact": "roller", "roller_radius": roller},
            "motion": [rise, {"segment": "dwell", "angle": 6}, fall, {"segment": "dwell", "angle": 274}],
        }
    )


def touching_roller(law: str) -> tuple[float, float]:
    """The roller whose flanks just touch on the axis of the lobe, and the cam angle where they do.

    In the axis' frame the profile is p − R·n, so it reaches the axis where R = Re p/Re n; at the least such R.
    """
    problem = resolve(lobe(1.0, law=law))

    def reach_ratio(angle):
        y, y1 = problem.programme.motion_at(np.atleast_1d(angle))[:2]
        turn, s = np.exp(1j * (radians(43) - angle)), 8.0 + y
        sideways = (turn * (-y1 + 1j * s)).real / np.hypot(s, y1)
        return np.where(sideways < 0.0, (1j * turn * s).real / np.minimum(sideways, -1e-300), inf)

    angles = np.linspace(0.0, radians(40), 20001)
    near = int(np.argmin(reach_ratio(angles)))
    best = minimize_scalar(
        lambda angle: float(reach_ratio(angle)[0]), bounds=angles[[near - 1, near + 1]], method="bounded",
        options={"xatol": 1e-12},
    )  # fmt: skip
    return float(best.fun), degrees(best.x)


@pytest.mark.one_in(7)
@pytest.mark.parametrize("k", range(1, 11))
@pytest.mark.parametrize("law", ["parabolic", "modified-sine", "cycloidal"])
def test_the_verdict_flips_where_the_flanks_touch(law, k):
    critical, angle = touching_roller(law)
    for side, crosses in ((1, True), (-1, False)):
        scene = lobe(critical * (1.0 + side * 10.0**-k), law=law)
        assert evaluate(scene)["undercut"] is False
        assert evaluate(scene)["self_crossing"] is crosses
        assert certify(scene) == {"undercut": "held", "self_crossing": "broken" if crosses else "held"}
        problem = resolve(scene)
        found = self_crossing_verdict(problem.setup, problem.design, problem.programme)
        if crosses and k > 2:
            assert np.degrees(found.angles) == pytest.approx([angle, 86 - angle], abs=3 * 10 ** (-k / 2))


def test_touching_flanks_are_undecided_and_count_as_crossing():
    scene = lobe(touching_roller("parabolic")[0])
    assert certify(scene)["self_crossing"] == "undecided"
    assert evaluate(scene)["self_crossing"] is True


def test_verdicts_of_a_block_are_those_of_its_designs():
    problem = resolve(lobe(5.0))
    radii = np.linspace(0.0, 7.9, 600)
    design = replace(
        Designs(**{n: np.resize(v, 600) for n, v in problem.design.sizes.items()}, sense=1.0),
        size=8.0 - radii, roller_radius=radii,
    )  # fmt: skip
    case = EvaluationBlock(problem.setup, problem.programme, design)
    found = run_effects(case, ["self_crossing"]).column("self_crossing")
    assert np.array_equal(found, radii >= touching_roller("parabolic")[0])
    for i in (0, 300, 599):
        assert found[i] == self_crossing(replace(case, designs=design.take([i])))


def test_undercut_is_a_crossing_in_proofs_too():
    scene = lobe(5.0).replace(**{"cam.base_radius": 0.5, "follower.roller_radius": 60.0})
    assert certify(scene) == {"undercut": "broken", "self_crossing": "broken"}
    assert evaluate(scene)["self_crossing"] is True


def dense_polygon_crosses(case: EvaluationBlock) -> bool:
    """The profile as a polygon of 36,000 sides."""
    points = points_of(case, np.linspace(0.0, 2 * np.pi, 36_000, endpoint=False))
    return not LinearRing(np.column_stack([points.real, points.imag])).is_simple


def case_of(scene: Scene) -> EvaluationBlock:
    problem = resolve(scene)
    return EvaluationBlock(problem.setup, problem.programme, problem.design)


@pytest.mark.parametrize("law", ["parabolic", "modified-sine", "cycloidal"])
@pytest.mark.parametrize("share", [0.5, 0.9, 1.1, 1.3])
def test_a_steep_narrow_lobe_is_feasible_if_it_does_not_cross_itself(law, share):
    scene = lobe(touching_roller(law)[0] * share, law=law)
    crosses = dense_polygon_crosses(case_of(scene))
    found = evaluate(scene)
    assert crosses is (share > 1.0)
    assert found["feasible"] is not crosses
    assert found["violated"] == ("self_crossing" if crosses else "")
    assert (certify(scene)["self_crossing"] == "broken") is crosses


def test_what_is_undecided_is_not_feasible():
    found = evaluate(lobe(touching_roller("parabolic")[0]))
    assert (found["feasible"], found["status"], found["violated"]) == (False, "undecided", "self_crossing")


def test_self_crossing_is_named_only_where_all_other_limits_hold():
    scene = lobe(touching_roller("parabolic")[0] * 1.1)
    assert evaluate(scene.replace(**{"limits.pressure_angle": 30}))["violated"] == (
        "pressure_angle,pressure_angle_return"
    )


def swinging_lobe(
    law: str, turn: tuple[float, float, float], lift: float, sizes: tuple[float, float, float], sense: str
):
    """A lobe for an oscillating roller; ``sizes`` are the roller radius, the arm and the centre distance."""
    rise, fall = ({"segment": kind, "lift": lift, "law": law} for kind in ("rise", "return"))
    motion = [rise | {"angle": turn[0]}, {"segment": "dwell", "angle": turn[1]}, fall | {"angle": turn[2]}]
    follower = {
        "motion": "oscillating",
        "roller_radius": sizes[0],
        "arm_length": sizes[1],
        "centre_distance": sizes[2],
    }
    return Scene.from_dict(
        {
            "cam": {"form": "disc", "rotation": sense},
            "follower": {"contact": "roller"} | follower,
            "motion": [*motion, {"segment": "dwell", "angle": 360 - sum(turn)}],
        }
    )


LOBES = {
    "any smaller base radius holds all other limits": lambda: swinging_lobe(
        "cycloidal", (37, 2.5, 51.5), 57, (8.55, 116, 111), "ccw"
    ),
    **{
        f"{law}-{share}": lambda law=law, share=share: lobe(touching_roller(law)[0] * share, law=law)
        for law, share in product(("parabolic", "cycloidal"), (1.01, 1.05))
    },
    "the least base radius that can be assembled": lambda: swinging_lobe(
        "cycloidal", (48, 7, 46), 54.3, (6.8, 115.8, 124.7), "cw"
    ),
}


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", LOBES)
def test_the_smallest_cam_is_the_least_that_does_not_cross_itself(name):
    """Down from a large cam, bisection on polygons ends where it does."""
    scene = LOBES[name]()
    best = optimise(scene).best
    size, prime = best["base_radius_mm"], best["prime_radius_mm"]
    assert best["feasible"]
    assert best["proved"]
    assert best["binding"] == ["self_crossing"]
    assert certify(scene.replace(**{"cam.base_radius": size}))["self_crossing"] == "held"
    assert not dense_polygon_crosses(case_of(scene.replace(**{"cam.base_radius": size + 1e-4 * prime})))
    least = 0.3 * size
    if scene.follower.motion == "oscillating":
        shortest = abs(scene.follower.centre_distance - scene.follower.arm_length) - scene.follower.roller_radius
        least = max(least, shortest + 1e-3 * prime)
    for radius in np.linspace(least, size - 1e-4 * prime, 8):
        less = scene.replace(**{"cam.base_radius": radius})
        assert evaluate(less)["feasible"] is False
        assert dense_polygon_crosses(case_of(less)) or evaluate(less)["undercut"]


@pytest.mark.slow
def test_a_lobe_whose_small_cams_cross_themselves_and_larger_ones_reach_the_pivot_has_no_smallest_cam():
    scene = swinging_lobe("cycloidal", (37, 2.5, 51.5), 60, (8.55, 116, 111), "ccw")
    found = optimise(scene)
    assert found.best is None
    assert found.obstacles == {"cycloidal": "pivot_in_cam and self_crossing together"}
    kinds = set()
    for radius in (0.005, 0.015, 0.025, 1.0, 3.0, 5.0, 30.0, 90.0):
        case = case_of(scene.replace(**{"cam.base_radius": radius}))
        reach = np.abs(points_of(case, np.linspace(0.0, 2 * np.pi, 5000))).max()
        kinds.add((dense_polygon_crosses(case), bool(reach > scene.follower.centre_distance)))
    assert kinds == {(True, False), (True, True), (False, True)}


def test_a_sweep_leaves_out_cams_that_cross_themselves(tmp_path):
    radius = touching_roller("parabolic")[0]
    rollers = [radius * share for share in (0.8, 0.95, 1.05, 1.2)]
    scene = lobe(radius).replace(
        **{"search.roller_radius": rollers, "search.base_radius": {"start": 1, "stop": 3, "step": 0.25}}
    )
    result = sweep(scene, tmp_path, keep="all")
    rows = load(tmp_path / "designs.parquet")
    assert "self_crossing" not in rows.columns
    for row in rows.to_dict("records"):
        sizes = {"cam.base_radius": row["base_radius_mm"], "follower.roller_radius": row["roller_radius_mm"]}
        one = scene.replace(search=None, **sizes)
        crosses = dense_polygon_crosses(case_of(one))
        assert row["feasible"] is not (crosses or row["violated"] == "undercut")
        assert evaluate(one)["violated"] == row["violated"]
    assert 0 < result.feasible < len(rows)
    assert (rows.violated == "self_crossing").any()
    asked = sweep(scene.replace(outputs=["crossing"]), tmp_path / "asked", keep="all")
    assert asked.feasible == result.feasible
    assert load(tmp_path / "asked" / "designs.parquet").self_crossing.sum() == len(rows) - result.feasible
    kept = sweep(scene, tmp_path / "kept")
    assert kept.feasible == len(load(tmp_path / "kept" / "designs.parquet")) == result.feasible


@pytest.mark.long
def test_what_crosses_itself_in_all_of_a_space_is_named():
    radius = touching_roller("parabolic")[0]
    scene = lobe(1.2 * radius).replace(**{"search.base_radius": {"start": 1.0, "stop": 2.0, "step": 0.5}})
    assert sweep(scene).nearest_miss["violated"] == "self_crossing"
    found = optimise(scene)
    obstacle = found.obstacles["parabolic"]
    assert obstacle.startswith("self_crossing, for base_radius = 1 to 2 mm (the smallest feasible")
    assert found.nearest_miss["violated"] == "self_crossing"


def with_pressure_angle(case: EvaluationBlock) -> EvaluationBlock:
    found = run_effects(case, ["pressure_angle_max_deg"])
    return replace(case, columns=found.columns, outward=found.outward)


@settings(max_examples=times(30, deep=1500))
@given(case=cases(keys=ROUND, slimmest=2))
def test_the_largest_pressure_angle_tells_that_the_normal_points_outwards(case):
    """A bound: where it tells so, it is so at each of some thousand points."""
    assume(case.designs.roller_radius[0] > 0.0)
    angles = np.linspace(0.0, 2 * np.pi, 5000, endpoint=False)
    travel = case.setup.mechanism.trace_and_normal(case.designs, case.programme, angles)
    outwards = np.min((travel.trace * travel.normal.conj()).real) > case.designs.roller_radius[0]
    assert outwards or not pressure_angle_proves_no_crossing(with_pressure_angle(case))[0]


def test_of_the_main_job_the_largest_pressure_angle_decides_all_but_a_few():
    problem = resolve(find_scene("roller-1000rpm"))
    base, roller, offset = np.meshgrid(np.arange(20.0, 151, 5), [4, 12, 20], np.arange(-40, 41, 8), indexing="ij")
    sizes = {"size": base.ravel(), "roller_radius": roller.ravel() + 0.0, "offset": offset.ravel()}
    fixed = {n: np.resize(v, base.size) for n, v in problem.design.sizes.items()}
    designs = Designs(**{**fixed, **sizes}, sense=1.0)
    designs = designs.take(problem.setup.mechanism.can_assemble(designs, problem.programme))
    case = with_pressure_angle(EvaluationBlock(problem.setup, problem.programme, designs))
    held = case.outer_end_of_column_enclosure("pressure_angle_max_deg") <= 30.0
    assert held.sum() > 200
    assert pressure_angle_proves_no_crossing(case)[held].mean() > 0.99


@pytest.mark.long
@pytest.mark.parametrize(
    ("scene", "free", "ends", "boxes"),
    [
        (
            lambda: swinging_lobe("modified-sine", (41.7, 3.8, 57.4), 68.6, (9.8, 152.9, 143.0), "ccw"),
            "roller_radius", (9.74, 13.78), 1000,
        ),
        pytest.param(
            lambda: swinging_lobe("cycloidal", (48, 7, 46), 54.3, (6.8, 115.8, 124.7), "cw"),
            "roller_radius", (6.0, 9.0), 3000, marks=pytest.mark.long,
        ),
        pytest.param(
            lambda: swinging_lobe("modified-sine", (31.4, 5.1, 45.9), 64.4, (6.58, 110.1, 120.6), "ccw"),
            "roller_radius", (5.37, 7.79), 8000, marks=pytest.mark.long,
        ),
        (lambda: lobe(touching_roller("parabolic")[0] * 1.05), "offset", (-2.0, 2.0), 4000),
    ],
)  # fmt: skip
def test_two_free_sizes_are_proved_in_so_many_boxes(monkeypatch, scene, free, ends, boxes):
    """From a roller at which the cam can only just be assembled, to one at which the flanks cross sooner.

    The cams of arms would run through the pivot: here it stands beside the plane of the cam.
    """
    implied = limits._limits_of_every_cam
    monkeypatch.setattr(
        limits, "_limits_of_every_cam", lambda setup: [x for x in implied(setup) if x.name != "pivot_in_cam"]
    )
    monkeypatch.setattr("camopt.solve.smallest.branch_and_bound.BoxSearch.most_boxes", boxes)
    scene = scene()
    best = optimise(
        scene.replace(**{f"search.{free}": dict(zip(("start", "stop"), ends, strict=True))}), seconds=600
    ).best
    assert (best["proved"], best["binding"]) == (True, ["self_crossing"])
    alone = optimise(scene.replace(**{f"follower.{free}": best[f"{free}_mm"]})).best
    assert alone["base_radius_mm"] == pytest.approx(best["base_radius_mm"], abs=3e-8)


def squared_depths(case: EvaluationBlock, a, b) -> np.ndarray:
    """R_r² − |P(a) − C(b)|² of all pairs of two lists of cam angles, by the points that are drawn."""
    at_a, at_b = (cam_curves(case.setup.mechanism, case.designs, case.programme, x) for x in (a, b))
    return case.designs.roller_radius[0] ** 2 - np.abs(at_a.profile[0][:, None] - at_b.pitch) ** 2


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("key", ROUND)
def test_a_cam_crosses_itself_if_and_only_if_the_roller_cuts_into_it(key):
    """Of cams that are not undercut, all pairs of 720 cam angles against the proof by parts."""
    angles, found = np.linspace(0.0, 2 * np.pi, 720, endpoint=False), {True: 0, False: 0}
    for case in slim_cams(60, key):
        cuts = squared_depths(case, angles, angles).max() > 1e-9 * case.designs.roller_radius[0] ** 2
        crossing = self_crossing_verdict(case.setup, case.designs, case.programme)
        assert not cuts or crossing.crosses
        if crossing.crosses:
            pair = largest_overlap_angles(case.setup, case.designs, case.programme, crossing.angles)
            assert squared_depths(case, *pair[:, None])[0, 0] > 0.0
        found[crossing.crosses] += 1
    assert min(found.values()) > 10


@pytest.mark.slow
@pytest.mark.parametrize("key", ROUND)
def test_where_a_cam_overlaps_the_most_is_found_again_from_near_by(key):
    """By Newton's method, to rounding, what a search without derivatives finds to its tolerance."""
    met = 0
    for case in slim_cams(20, key):
        crossing = self_crossing_verdict(case.setup, case.designs, case.programme)
        if crossing.crosses:
            met += 1
            best = largest_overlap_angles(case.setup, case.designs, case.programme, crossing.angles)
            for away in ([1e-3, -1e-3], [-1e-3, 2e-3]):
                pair = refine_overlap_angles(case.setup, case.designs, case.programme, np.array([best + away]))
                least, most = (
                    squared_depths(case, *x[:, None])[0, 0] * speed_at(case, x[:1]) for x in (best, pair[0])
                )
                assert most >= least * (1.0 - 1e-10)
                assert np.abs(pair[0] - best).max() < 1e-3
    assert met >= 5


@pytest.mark.slow
@settings(max_examples=times(50, deep=1000))
@given(
    case=cases(keys=ROUND, slimmest=2),
    pair=st.tuples(st.floats(0, 6.28), st.floats(0, 6.28)),
    width=st.floats(1e-9, 1),
)
def test_the_overlap_over_a_box_holds_that_of_its_designs(case, pair, width):
    assume(case.designs.roller_radius[0] > 0.0)
    angles, random = np.array([pair]), np.random.default_rng(7)
    speed, prime = speed_at(case, angles[0, :1]), case.designs.prime_radius[0]
    assert profile_overlaps(case.setup, case.designs, case.programme, angles[None])[0, 0] == pytest.approx(
        squared_depths(case, *angles.T)[0, 0] * speed, rel=1e-9, abs=1e-9 * prime**2 * (speed + prime)
    )
    free = ("size", "roller_radius", *(("arm_length", "centre_distance") if case.setup.angular else ("offset",)))
    sides = {n: Interval(v - width * (n in free), v + width * (n in free)) for n, v in case.designs.sizes.items()}
    over = box_overlap(
        case.setup, Designs(**sides, sense=case.designs.sense), case.designs, free, case.programme, angles
    )
    for share in random.uniform(-1.0, 1.0, (5, len(free))):
        moved = {n: case.designs.sizes[n] + x * width for n, x in zip(free, share, strict=True)}
        other = replace(case, designs=replace(case.designs, **moved))
        if case.setup.mechanism.can_assemble(other.designs, case.programme)[0]:
            turned = squared_depths(other, *angles.T)[0, 0] * speed_at(other, angles[0, :1])
            assert over.value.low[0] - 1e-12 <= turned <= over.value.high[0] + 1e-12
            moved = over.slopes * as_interval(width * share[:, None])
            by_slopes = over.at + Interval(moved.low.sum(axis=0), moved.high.sum(axis=0))
            assert by_slopes.low[0] - 1e-9 <= turned <= by_slopes.high[0] + 1e-9


def speed_at(case: EvaluationBlock, angles) -> float:
    """|C'| in mm/rad."""
    record = case.setup.mechanism.sliding(case.designs, case.programme)
    return float(value_and_slope(record, ..., case.programme.state(angles))[0][0])


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("key", ROUND)
def test_all_cams_of_an_excluded_box_cross_themselves(key):
    """Random designs of boxes, and the corners, against polygons; all boxes round a crossing are, once narrow."""
    random, excluded = np.random.default_rng(5), 0
    for case in slim_cams(times(12, deep=30), key):
        if self_crossing_verdict(case.setup, case.designs, case.programme).crosses is not True:
            continue
        others = ("arm_length", "centre_distance") if case.setup.angular else ("offset",)
        free = ("size", "roller_radius", *others)
        for width in (1.0, 0.3, 0.03, 1e-9):
            half = {n: width * (n in free) + 0.0 * v for n, v in case.designs.sizes.items()}
            sides = {n: Interval(v - half[n], v + half[n]) for n, v in case.designs.sizes.items()}
            box = Designs(**sides, sense=1.0)
            shown = (
                KnownCrossings(case.setup, case.programme).crossing_excess(box, case.designs, free).value.low[0]
                > 0.0
            )
            assert shown or width > 1e-9
            excluded += int(shown)
            for share in random.choice([-1.0, 1.0, 0.3, -0.7], (3, len(free))) if shown else ():
                moved = {n: case.designs.sizes[n] + x * width for n, x in zip(free, share, strict=True)}
                other = replace(case, designs=replace(case.designs, **moved))
                assert not case.setup.mechanism.can_assemble(other.designs, case.programme)[0] or polygon_crosses(
                    other
                )
    assert excluded >= times(8, deep=20)  # the test has met boxes to check


def a_row_of_lobes(count: int = 60) -> tuple[Problem, Designs]:
    """The same lobe at prime radii from 7.6 up: the small ones cross themselves, the large ones do not."""
    problem = with_rounding_relative_error(resolve(lobe(touching_roller("parabolic")[0], prime=8.0)))
    designs = problem.design.take(np.zeros(count, dtype=int))
    return problem, replace(designs, size=designs.size + np.linspace(-0.4, 2.0, count))


def test_when_the_budget_is_spent_nothing_more_is_asked_of_crossings():
    problem, designs = a_row_of_lobes()
    whole, cut = (
        quantities_with_excess_bounds(problem, designs, frozenset(), budget) for budget in (UNLIMITED, Budget(0.0))
    )
    crossing = np.array(
        [evaluate(lobe(designs.roller_radius[0], p))["self_crossing"] for p in designs.prime_radius]
    )
    assert np.array_equal(whole.outer[-1] > 0.0, crossing)
    assert np.array_equal(whole.inner[-1] > 0.0, crossing)
    assert np.all(cut.outer[-1] == np.inf)
    assert np.all(cut.inner[-1] == -np.inf)
    for budget, first in ((UNLIMITED, designs.take([np.argmin(crossing)])), (Budget(0.0), None)):
        found = first_feasible_design(problem, designs, empty_known_crossings(problem), budget)
        assert (found and found.size) == (first and first.size)


def test_when_the_budget_is_spent_a_feasible_design_is_kept():
    problem, designs = a_row_of_lobes()
    bounds = {**search_boxes(problem)[0], "size": (1.0, 100.0)}
    large = designs.take([-1])
    assert shrink_on_grids(problem, bounds, large).size < large.size
    assert shrink_on_grids(problem, bounds, large, budget=Budget(0.0)).size == large.size
    whole, cut = (
        _size_above_which_cams_are_feasible(problem, SmallestCam(large, 0.0), budget)
        for budget in (UNLIMITED, Budget(0.0))
    )
    assert whole == large.size
    assert cut == pytest.approx(large.size + 10.0 * large.prime_radius)


def test_half_of_the_budget_is_kept_for_crossings(monkeypatch):
    problem, ends = a_row_of_lobes()[0], []

    def record_budget(search):
        return lambda *given, **more: ends.append(given[-1].end - given[-1].meter.read()) or search(*given, **more)

    for search in (least_of_others, branch_and_bound):
        monkeypatch.setattr(f"camopt.solve.smallest.smallest.{search.__name__}", record_budget(search))
    solve_smallest_cam(problem, {**search_boxes(problem)[0], "size": (1.0, 100.0)}, Budget(1e9))
    assert ends == [pytest.approx(5e8, rel=0.1), pytest.approx(1e9, rel=0.1)]
