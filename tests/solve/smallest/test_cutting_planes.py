"""Oscillating followers by cutting planes: against curves drawn at 50 digits, boxes, samples and identities."""

from math import cos, degrees, inf, pi, radians, sin, sqrt
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support import naive
from support.depth import times

from camopt import Scene
from camopt.model.mechanisms import Designs, cylindrical_oscillating, oscillating, oscillating_flat
from camopt.model.motion.programme import JUMP_SIDE, Programme
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.scene.problem.space import search_boxes
from camopt.solve.smallest import cutting_planes
from camopt.solve.smallest.branch_and_bound import BoxSearch, branch_and_bound
from camopt.solve.smallest.closed_form import size_lower_bound
from camopt.solve.smallest.cutting_planes import cutting_plane_optimum
from camopt.solve.smallest.linear_forms import ARM_FORM, FACE_FORM
from camopt.solve.smallest.result import RELATIVE_GAP, allowed_proof_gap
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.verdicts.feasible_filter import feasible_designs

SYMMETRIC = ("cycloidal", "poly345", "modified-sine", "harmonic", "parabolic")
LENGTHS = {"base_radius", "mean_radius", "roller_radius", "arm_length", "centre_distance", "face_offset"}


def turn(lift, rise=120.0, fall=110.0, law="cycloidal", rest=30.0):
    up, down = ({"segment": kind, "lift": lift, "law": law} for kind in ("rise", "return"))
    return [
        {**up, "angle": rise},
        {"segment": "dwell", "angle": rest},
        {**down, "angle": fall},
        {"segment": "dwell", "angle": 360.0 - rise - fall - rest},
    ]


def arm(share):
    centre, length, first = 60 + 100 * share[0], 50 + 90 * share[1], radians(20 + 100 * share[2])
    base = sqrt(centre**2 + length**2 - 2 * centre * length * cos(first)) - 3.0
    sizes = {"arm_length": length, "centre_distance": centre, "roller_radius": 3.0}
    return {
        "cam": {"form": "disc", "base_radius": max(base, 1.0)},
        "follower": {"motion": "oscillating", "contact": "roller", **sizes},
    }


def face(share):
    centre, offset, first = 60 + 100 * share[0], -10 + 30 * share[1], radians(1 + 49 * share[2])
    base = offset + centre * sin(first)
    sizes = {"face_offset": offset, "centre_distance": centre}
    return {
        "cam": {"form": "disc", "base_radius": max(base, 1.0)},
        "follower": {"motion": "oscillating", "contact": "flat", **sizes},
    }


def groove(share):
    sizes = {"arm_length": 40 + 100 * share[0], "roller_radius": 3.0}
    return {
        "cam": {"form": "cylindrical", "mean_radius": 30 + 70 * share[1]},
        "follower": {"motion": "oscillating", "contact": "roller", **sizes},
    }


MADE = {
    oscillating.MECHANISM.name: arm,
    oscillating_flat.MECHANISM.name: face,
    cylindrical_oscillating.MECHANISM.name: groove,
}
FORMS = {
    each.name: cutting_planes.LINEAR_FORMS[each.pressure]
    for each in (oscillating.MECHANISM, oscillating_flat.MECHANISM, cylindrical_oscillating.MECHANISM)
}
"""By mechanism: the cam and follower of a scene, from shares of the ranges of its sizes."""


def problem_and_bounds(raw):
    """The question of a scene, and its one box of sizes."""
    problem = with_rounding_relative_error(resolve(Scene.from_dict(raw)))
    bounds = search_boxes(problem)[0]
    return problem, {**bounds, "size": (size_lower_bound(problem, bounds), bounds["size"][1])}


def random_scene(name, seed):
    """A scene with limits that bind, some sizes free."""
    rng = np.random.default_rng([seed, sorted(FORMS).index(name)])
    lift = float(rng.uniform(5, 22))
    raw = MADE[name](rng.random(3))
    raw["motion"] = turn(lift, *map(float, rng.uniform(80, 140, 2)), law=str(rng.choice(SYMMETRIC)))
    raw["cam"]["rotation"] = str(rng.choice(["cw", "ccw"]))
    limits = {"pressure_angle": float(rng.uniform(28, 50)), "pressure_angle_return": float(rng.uniform(28, 50))}
    if raw["follower"]["contact"] == "flat":
        limits |= {"curvature_radius": float(rng.uniform(1, 10)), "face_reach": float(rng.uniform(80, 200))}
    kept = rng.choice(sorted(limits), size=rng.integers(1, len(limits) + 1), replace=False)
    raw["limits"] = {str(key): limits[key] for key in kept}
    raw["search"] = {}
    for key in {"arm_length", "centre_distance", "face_offset"} & raw["follower"].keys():
        start, width = raw["follower"][key], rng.choice([0.0, 1e-6, 5.0, 40.0])
        if rng.random() < 0.5:
            raw["search"][key] = {"start": start, "stop": start + float(width)}
    return raw


def sample_designs(problem, bounds, top, near, rng, count=4000):
    """Designs of the bounds below a size, half of them near to a design."""
    low = bounds["size"][0]
    sizes = {"size": top - (top - low) * 10.0 ** rng.uniform(-9, 0, count)}
    for key, (a, b) in bounds.items():
        if key == "size":
            continue
        values = rng.uniform(a, b, count)
        if near is not None:
            steps = (b - a) * 10.0 ** rng.uniform(-8, 0, count // 2) * rng.standard_normal(count // 2)
            values[::2] = np.clip(near.sizes[key] + steps, a, b)
        sizes[key] = values
    return Designs(**sizes, sense=problem.design.sense)


# What the planes are


def point_of(raw):
    """(u, v, w) of a scene, from its triangle at 50 digits."""
    follower = raw["follower"]
    if raw["cam"]["form"] == "cylindrical":
        return np.array([raw["cam"]["mean_radius"], 0.0, follower["arm_length"]])
    start = naive.psi_start(raw)
    centre = follower["centre_distance"] * np.array([float(mpmath.cos(start)), float(mpmath.sin(start))])
    return np.array([*centre, follower.get("arm_length", follower.get("face_offset"))])


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", sorted(FORMS))
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@settings(max_examples=times(13, deep=250))
@given(share=st.lists(st.floats(0.0, 1.0), min_size=7, max_size=7))
@mpmath.workdps(50)
def test_a_limit_at_the_value_of_a_design_is_a_plane_through_its_point(name, rotation, share):
    """β, ρ and the reach of the drawn curve at any y, y' and y'', as limits; a little beside, exceeded and held."""
    lift = 5.0 + 30.0 * share[3]
    raw = {**MADE[name](share), "motion": turn(lift, law="harmonic")}
    raw["cam"]["rotation"] = rotation
    jet = np.array([radians(lift) * share[4], 1.6 * share[5] - 0.8, 6.0 * share[6] - 3.0])
    state = {key: float(v) for key, v in naive.geometry(raw)(mpmath.mpf(1), (*map(mpmath.mpf, jet), 0)).items()}
    steepest, point = abs(degrees(state["beta"])), point_of(raw)
    values = {
        "pressure_angle": steepest if 0.1 < steepest < 85.0 else None,
        "curvature_radius": state["rho"] if state.get("rho", 0.0) > 0.1 else None,
        "face_reach": state.get("reach"),
    }
    values = {key: value for key, value in values.items() if value is not None}
    assume(values and abs(jet[1]) > 1e-3)  # at rest a groove's limit is no plane, whatever its size
    for key, value in values.items():
        rooms = []
        for change in (-0.01, 0.0, 0.01):
            problem, _ = problem_and_bounds({**raw, "limits": {key: value * (1.0 + change)}})
            mechanism, form = problem.setup.mechanism, FORMS[name]
            curve = {"face_reach": mechanism.reach, "curvature_radius": mechanism.profile_radius}.get(key)
            limits = form.limits(problem)
            side = int(key == "pressure_angle" and state["beta"] < 0.0)
            planes = [
                limit.planes(jet[:, None])[side] for limit in limits if limit.curve is (curve or mechanism.pressure)
            ]
            rooms.append(np.min(np.concatenate(planes) @ [*point, -1.0]) / np.linalg.norm(point))
        assert rooms[1] == pytest.approx(0.0, abs=1e-12)
        assert rooms[0] * rooms[2] < 0.0
        assert (rooms[2] > 0.0) == (key != "curvature_radius")


@pytest.mark.parametrize("name", sorted(FORMS))
@settings(max_examples=times(13, deep=250))
@given(share=st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4))
@mpmath.workdps(50)
def test_a_point_gives_its_sizes_back_and_lies_in_their_ranges(name, share):
    raw = {**MADE[name](share), "motion": turn(5.0 + 30.0 * share[3]), "limits": {"pressure_angle": 30.0}}
    problem, bounds = problem_and_bounds(raw)
    form, point, design = FORMS[name], point_of(raw), problem.design
    for key, value in form.sizes(point, design.roller_radius[0]).items():
        assert value == pytest.approx(design.sizes[key][0], rel=1e-12, abs=1e-12 * np.linalg.norm(point))
    bounds["size"] = (design.size[0], inf)
    assert np.min(form.range_planes(problem.programme, bounds) @ [*point, -1.0]) >= -1e-12 * np.linalg.norm(point)


SPANS = st.tuples(st.floats(0.5, 2.0), st.sampled_from([0.0, 1e-6, 1e-3, 0.3, 1.5]))


@pytest.mark.parametrize("form", [ARM_FORM, FACE_FORM], ids=["arm", "face"])
@settings(max_examples=times(10, deep=600))
@given(
    spans=st.tuples(SPANS, SPANS),
    least=st.sampled_from([0.0, 0.6]),
    count=st.integers(0, 6),
    seed=st.integers(0, 9999),
)
def test_no_sampled_point_within_some_planes_is_smaller_than_the_least(form, spans, least, count, seed):
    """Random planes, rings from a circle to wide; where there is said to be no point, no sample is one."""
    rng = np.random.default_rng(seed)
    (length, width), (near, depth) = spans
    length -= 1.0 if form is FACE_FORM else 0.0
    lengths, ring = (length, length + width), (near, near + depth)
    bounds = {"arm_length": lengths, "face_offset": lengths, "centre_distance": ring, "size": (least, inf)}
    planes = rng.standard_normal((count, 4))
    planes[:, 3] *= 0.0 if form is ARM_FORM else rng.choice([0.0, 0.4])
    planes[: count // 3, 2] *= rng.choice([0.0, 1.0])
    planes /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    planes = np.concatenate(
        [form.range_planes(SimpleNamespace(lift=float(rng.uniform(0.05, 1.0))), bounds), planes]
    )
    point = form.least_point(planes, bounds)
    angle, far, long = (rng.uniform(*ends, 20000) for ends in ((-pi / 2, pi), ring, lengths))
    far[::3], far[1::6], long[::4], long[1::8] = ring[0], ring[1], lengths[0], lengths[1]
    if point is not None:
        assert np.min(planes @ [*point, -1.0]) > -1e-10
        assert ring[0] - 1e-10 <= np.hypot(point[0], point[1]) <= ring[1] + 1e-10
        assert lengths[0] - 1e-10 <= point[2] <= lengths[1] + 1e-10
        angle[::2] = np.arctan2(point[1], point[0]) + 10.0 ** rng.uniform(-7, 0, 10000) * rng.choice([-1, 1], 10000)
    points = np.stack([far * np.cos(angle), far * np.sin(angle), long], axis=1)
    points = points[np.all(points @ planes[:, :3].T >= planes[:, 3], axis=1)]
    floor = inf if point is None else form.sizes(point, 0.0)["size"]
    assert min([form.sizes(each, 0.0)["size"] for each in points], default=inf) >= floor - 1e-10


# What the search answers


@pytest.mark.one_in(9)
@pytest.mark.parametrize("name", sorted(FORMS))
@pytest.mark.parametrize("seed", range(16))
def test_no_sampled_design_undercuts_the_floor(name, seed):
    """The cam holds its limits and lies in its ranges; where none is said to exist, no sampled one does."""
    problem, bounds = problem_and_bounds(random_scene(name, seed))
    cut, rng = cutting_plane_optimum(problem, bounds), np.random.default_rng(seed)
    design = cut.design
    if design is not None:
        assert feasible_designs(problem, design)[0]
        assert all(low <= design.sizes[key][0] <= high for key, (low, high) in bounds.items())
        assert design.size[0] <= cut.floor + allowed_proof_gap(design)
    top = min(
        cut.floor * (1.0 - RELATIVE_GAP),
        2.0 * sum(bounds[key][1] for key in ("centre_distance", "arm_length", "face_offset")),
    )
    designs = sample_designs(problem, bounds, top, design, rng)
    assert not feasible_designs(problem, designs).any()


@pytest.mark.slow
def test_the_drawn_scenes_have_cams_and_have_none():
    cuts = {name: [cutting_plane_optimum(q, b) for q, b in random_questions(name)] for name in FORMS}
    for name, found in cuts.items():
        assert sum(cut.design is not None for cut in found) >= 4, name
    assert sum(cut.floor == inf for found in cuts.values() for cut in found) >= 4


def random_questions(name):
    return [problem_and_bounds(random_scene(name, seed)) for seed in range(16)]


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(FORMS))
def test_boxes_find_the_same_cam_with_and_without_the_floor(name, monkeypatch):
    monkeypatch.setattr(BoxSearch, "most_boxes", 5000)
    compared = 0
    for problem, bounds in random_questions(name):
        cut = cutting_plane_optimum(problem, bounds)
        if cut.design is None or compared == times(2, deep=16):
            continue
        alone = branch_and_bound(problem, bounds)
        helped = branch_and_bound(problem, bounds, cut.floor)
        assert alone.design.size[0] >= cut.floor
        assert helped.is_proved
        assert helped.design.size[0] == pytest.approx(cut.design.size[0], abs=2 * allowed_proof_gap(cut.design))
        if alone.is_proved:
            assert alone.design.size[0] == pytest.approx(cut.design.size[0], abs=2 * allowed_proof_gap(cut.design))
            compared += 1
    assert compared >= 2


# Identities


def scale_lengths(raw, factor):
    """A scene with all its lengths longer by a factor."""
    if isinstance(raw, dict):
        longer = LENGTHS | {"curvature_radius", "face_reach"}
        return {key: longer_by(v, factor) if key in longer else scale_lengths(v, factor) for key, v in raw.items()}
    return raw


def longer_by(value, factor):
    return {key: v * factor for key, v in value.items()} if isinstance(value, dict) else value * factor


@pytest.mark.slow
@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", sorted(FORMS))
@pytest.mark.parametrize("factor", [1 / 16, 10.0])
def test_a_scene_with_longer_lengths_has_a_larger_cam(name, factor):
    for seed in range(16):
        raw = random_scene(name, seed)
        one, other = (
            cutting_plane_optimum(q, b)
            for q, b in (problem_and_bounds(raw), problem_and_bounds(scale_lengths(raw, factor)))
        )
        assert (one.design is None) == (other.design is None)
        assert other.floor == pytest.approx(factor * one.floor, rel=1e-7)


def reverse_turn(raw):
    """The turn run backwards under a cam that turns the other way."""
    flipped = {"rise": "return", "return": "rise", "dwell": "dwell"}
    first, rest, second, last = ({**s, "segment": flipped[s["segment"]]} for s in raw["motion"])
    other = "ccw" if raw["cam"]["rotation"] == "cw" else "cw"
    return {**raw, "cam": {**raw["cam"], "rotation": other}, "motion": [second, rest, first, last]}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", sorted(FORMS))
def test_a_turn_run_backwards_has_the_same_cam(name):
    """q = 1 ± ψ' is the same; with symmetric laws, and one limit on the pressure angle of both strokes."""
    for seed in range(times(4, deep=16)):
        raw = random_scene(name, seed)
        raw["limits"].pop("pressure_angle_return", None)
        raw["limits"].setdefault("pressure_angle", 40.0)
        one, other = (
            cutting_plane_optimum(q, b) for q, b in (problem_and_bounds(raw), problem_and_bounds(reverse_turn(raw)))
        )
        assert (one.design is None) == (other.design is None)
        assert other.floor == pytest.approx(one.floor, rel=2 * RELATIVE_GAP)


# Corners of the motion, and ends of ranges


@pytest.mark.parametrize("rotation", ["cw", "ccw"])
@pytest.mark.parametrize("rest", [0.0, 30.0])
@pytest.mark.parametrize(
    "limits",
    [
        {"pressure_angle": 60, "pressure_angle_return": 25},
        {"pressure_angle": 25, "pressure_angle_return": 60},
        {"pressure_angle_return": 20},
    ],
    ids=["return", "rise", "return-alone"],
)
def test_a_limit_of_one_stroke_says_nothing_about_the_next_one(limits, rest, rotation):
    """At a corner the next stroke has another speed: 47.75 mm was given for a knife edge where 25.48 mm will do."""
    motion = turn(20.0, 180.0 - rest, 180.0 - rest, "uniform", rest)
    raw = {
        "cam": {"form": "disc", "base_radius": 50.0, "rotation": rotation},
        "follower": {"motion": "oscillating", "contact": "knife", "arm_length": 100.0, "centre_distance": 120.0},
        "motion": [segment for segment in motion if segment["angle"]],
        "limits": limits,
    }
    problem, bounds = problem_and_bounds(raw)
    sizes = np.arange(20.5, 70.0, 0.01)
    fixed = {key: np.full(sizes.size, low) for key, (low, _) in bounds.items()}
    scan = Designs(**{**fixed, "size": sizes}, sense=problem.design.sense)
    least = sizes[feasible_designs(problem, scan)][0]
    assert least > sizes[0]
    for answer in (
        solve_smallest_cam(problem, bounds),
        branch_and_bound(problem, bounds),
    ):
        assert answer.is_proved
        assert least - 0.01 <= answer.design.size[0] <= least


@pytest.mark.parametrize("kinds", [RISE, RETURN, DWELL, ALL_STROKES])
@pytest.mark.parametrize("rest", [0.0, 40.0, 1e-13])
def test_angles_beside_a_jump_stay_in_strokes_of_their_kinds(kinds, rest):
    segments = [("rise", 180.0 - rest, 5.0, "uniform"), ("dwell", rest, 0.0, None)]
    programme = Programme.from_segments([*segments, ("return", 180.0, 5.0, "uniform")], angular=True)
    allowed = [s for s in programme.strokes if s.kind & kinds]
    ends = [end for s in allowed for end in (s.start, s.end)] or [1.0]
    beside = programme.one_sided_angles(np.array([*ends, *np.linspace(0.1, 6.0, 9)]), kinds)
    assert beside.shape == (2 if allowed else 0, len(ends) + 9)
    for angle in beside.ravel():
        assert any(s.start <= angle <= s.end for s in allowed)
    if allowed and rest != 1e-13:
        away = np.abs(beside[:, : len(ends)] - ends)
        assert np.all(np.minimum(away, 2 * pi - away) <= 1.1 * JUMP_SIDE)


@pytest.mark.slow
@pytest.mark.one_in(15)
@pytest.mark.parametrize("name", sorted(FORMS))
@pytest.mark.parametrize("seed", range(4))
def test_a_range_of_the_cam_itself_holds_to_the_last_digit(name, seed):
    """It ends where the smallest cam lies, or next to it: no answer lies outside by rounding, and none fails."""
    raw = {
        **MADE[name]([0.5, 0.4, 0.3 + 0.1 * seed]),
        "motion": turn(8.0 + 3 * seed),
        "limits": {"pressure_angle": 40.0},
    }
    key = "mean_radius" if raw["cam"]["form"] == "cylindrical" else "base_radius"

    def smallest_between(start, stop):
        problem, bounds = problem_and_bounds({**raw, "search": {key: {"start": start, "stop": stop}}})
        answer = solve_smallest_cam(problem, bounds)
        assert answer.design is None or start <= answer.design.size[0] <= stop
        return answer.design

    smallest_cam = smallest_between(1.0, 500.0)
    size = float(smallest_cam.size[0])
    for less in (1e-15, 1e-14, 1e-13, 1e-12, 1e-10):
        smallest_between(1.0, size * (1.0 - less))
    for more in (0.0, 1e-15, 1e-13, 1e-12, 0.1, 0.3):
        assert smallest_between(size * (1.0 + more), 500.0).size[0] <= size * (1.0 + more) + allowed_proof_gap(
            smallest_cam
        )
    assert smallest_between(1.0, size).size[0] == pytest.approx(size, abs=allowed_proof_gap(smallest_cam))
    assert smallest_between(1.0, size - 1e-6) is None


@pytest.mark.parametrize("half", [*range(5, 46, 5)])
@pytest.mark.parametrize("rotation", ["cw", "ccw"])
def test_an_arm_that_leans_by_the_limit_at_rest_has_no_groove(half, rotation):
    """tan β = tan ½h in the dwells whatever the radius, and more beside them; no warning of 0/0."""
    raw = {**MADE[cylindrical_oscillating.MECHANISM.name]([0.5, 0.5]), "motion": turn(2.0 * half)}
    raw["cam"]["rotation"] = rotation
    problem, bounds = problem_and_bounds({**raw, "limits": {"pressure_angle": float(half)}})
    cut = cutting_plane_optimum(problem, bounds)
    assert cut.design is None
    assert cut.floor > 1e5
    problem, bounds = problem_and_bounds({**raw, "limits": {"pressure_angle": half + 1.0}})
    cut = cutting_plane_optimum(problem, bounds)
    assert feasible_designs(problem, cut.design)[0]
