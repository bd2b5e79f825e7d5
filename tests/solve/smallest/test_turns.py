"""The smallest cam over the angles of a turn, against dense grids of angles, bisection and identities."""

from math import radians, tan

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import optimize
from support.depth import times
from support.smallest_cams import ANGLES, BASE, CASES, FREE, OFFSET, scene, size_of

from camopt import BadInput, Scene, evaluate, find_scene, optimise, sweep
from camopt.model.mechanisms import SIZE_FIELDS, Designs
from camopt.model.motion.programme import weighted_derivative_range
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.solve.smallest.boxes import DesignBoxes
from camopt.solve.smallest.closed_form import size_lower_bound
from camopt.solve.smallest.nelder_mead import NelderMead
from camopt.solve.smallest.optimise import search_boxes
from camopt.solve.smallest.result import SmallestCam
from camopt.solve.smallest.smallest import solve_small_cam_unproved, solve_smallest_cam
from camopt.solve.smallest.smallest_turn import convex_lower_bound
from camopt.solve.smallest.turn_boxes import TurnBoxSearch
from camopt.solve.smallest.turns import SegmentAngles, TurnOptimum
from camopt.solve.verdicts.feasible_filter import feasible_designs


def scene_of_optimum(case, best):
    """The scene without a search, with the angles and sizes of its optimum."""
    data = case.replace(search=None).to_dict()
    for segment, angle in zip(data["motion"], best["angles_deg"], strict=True):
        segment["angle"] = angle
    data["cam"]["base_radius" if "base_radius_mm" in best else "mean_radius"] = size_of(best)
    if best.get("offset_mm"):
        data["follower"]["offset"] = best["offset_mm"]
    return Scene.from_dict(data)


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", FREE)
def test_no_turn_of_a_grid_has_a_smaller_cam(name):
    """Every turn of a grid by the search at given angles, which knows nothing of other turns."""
    case = FREE[name]
    best, problem = optimise(case).best, with_rounding_relative_error(resolve(case))
    turns = SegmentAngles(problem, (None, None))
    box, total = turns.angle_box, turns.scene_angles.sum()
    assert best["proved"]
    assert sum(best["angles_deg"]) == pytest.approx(360.0, rel=1e-14)
    near = best["angles_deg"][turns.freed_segments[0]] + np.array([-0.1, -1e-3, 1e-3, 0.1])
    sizes = []
    for angle in np.clip(
        [*np.linspace(box.low[0], box.high[0], times(3, deep=40)), *near], box.low[0], box.high[0]
    ):
        answer = solve_smallest_cam(
            turns.problem_with_angles(np.array([angle, total - angle])), search_boxes(problem)[0]
        )
        sizes.append(np.inf if answer.design is None else answer.design.size[0])
    assert size_of(best) <= min(sizes) + 1e-7
    assert size_of(best) - best["gap_mm"] <= min(sizes)
    assert min(sizes) == pytest.approx(size_of(best), abs=1e-2)
    assert evaluate(scene_of_optimum(case, best))["feasible"]


@pytest.mark.long
@pytest.mark.parametrize("law", ["harmonic", pytest.param("parabolic", marks=pytest.mark.long)])
def test_the_rest_at_the_lowest_may_vanish(law):
    """However short, it is an arc of the base circle, and has its curvature; only without it is the cam smaller."""
    motion = [{**each, **({"law": law, "lift": 20} if "law" in each else {})} for each in BASE["motion"]]
    ranges = {**ANGLES, "search.angle_dwell": {"start": 0, "stop": 160}}
    case = scene(motion=motion, **ranges, limits={"pressure_angle": 40, "curvature_radius": 30})
    best, problem = optimise(case).best, with_rounding_relative_error(resolve(case))
    turns = SegmentAngles(problem, (None, None))
    assert best["angles_deg"][3] == 0.0
    sizes = []
    for rise, fall in ((160, 160), (140, 150)):
        turn = turns.programme_with_angles(np.array([rise, 360.0 - rise - fall, fall, 0.0]))
        sizes.append(solve_smallest_cam(problem.with_programme(turn), search_boxes(problem)[0]).size)
    assert size_of(best) <= min(sizes) * (1.0 + 1e-8)
    assert size_of(best) < 29.0
    rests = turns.programme_with_angles(np.array([159.9, 40.0, 159.9, 0.2]))
    assert size_lower_bound(problem.with_programme(rests), search_boxes(problem)[0]) == 30.0


@pytest.mark.slow
def test_rise_against_return_is_where_two_monotone_functions_cross():
    """A radial cam: each stroke needs the larger radius the shorter it is, so the optimum is a root."""
    case = scene(**ANGLES, **{"limits.pressure_angle": 38})
    turns = SegmentAngles(with_rounding_relative_error(resolve(case)), (None, None))

    def needed_radius(rise, kinds, limit, sign):
        weights = (-tan(radians(limit)), sign)
        return weighted_derivative_range(
            turns.programme_with_angles(np.array([rise, 210.0 - rise])), weights, kinds
        )[1] / tan(radians(limit))

    def difference(rise):
        return needed_radius(rise, RISE, 38, 1.0) - needed_radius(rise, RETURN, 30, -1.0)

    rise = optimize.brentq(difference, 60, 150, xtol=1e-13)
    best = optimise(case).best
    assert best["angles_deg"][0] == pytest.approx(rise, abs=1e-6)
    assert best["prime_radius_mm"] == pytest.approx(needed_radius(rise, RISE, 38, 1.0), abs=1e-7)


@pytest.mark.slow
def test_a_turn_run_backwards_has_the_same_cam():
    """Rise and return change places with their limits and ranges, and the rotation turns."""
    apart = {"limits.pressure_angle": 35, "limits.pressure_angle_return": 28}
    case = scene(**{**ANGLES, **OFFSET, **apart, "search.angle_rise": {"start": 60, "stop": 100}})
    back = {
        "limits.pressure_angle": 28, "limits.pressure_angle_return": 35, "cam.rotation": "ccw",
        "search.angle_rise": case.search.angle_return, "search.angle_return": case.search.angle_rise,
        "motion": [BASE["motion"][i] for i in (0, 1, 2, 3)],
    }  # fmt: skip
    there, again = optimise(case).best, optimise(case.replace(**back)).best
    assert there["base_radius_mm"] == pytest.approx(again["base_radius_mm"], abs=1e-7)
    assert there["angles_deg"][0] == pytest.approx(again["angles_deg"][2], abs=1e-5)
    assert there["offset_mm"] == pytest.approx(again["offset_mm"], abs=1e-5)


@pytest.mark.long
def test_more_freedom_never_makes_a_larger_cam_and_none_is_the_scene_itself():
    plain, free = scene(**OFFSET), scene(**OFFSET, **ANGLES)
    tied = {f"search.angle_{kind}": {"start": a, "stop": a} for kind, a in (("rise", 120), ("return", 90))}
    dwells = {"search.angle_dwell": {"start": 55, "stop": 95}}
    sizes = [size_of(optimise(s).best) for s in (plain, plain.replace(**tied), free, free.replace(**dwells))]
    assert sizes[0] == pytest.approx(sizes[1], abs=1e-9)
    assert sizes[1] > sizes[2] > sizes[3]


def four_segment_scene(case, law, angles, lift, limits, **ranges):
    """A case with the strokes of a turn of four segments and the ranges of their angles, without those of dwells."""
    kinds = ("rise", "dwell", "return", "dwell")
    moves = [{"lift": lift, "law": law[kind]} if kind in law else {} for kind in kinds]
    motion = [{"segment": k, "angle": a, **m} for k, a, m in zip(kinds, angles, moves, strict=True)]
    ends = {f"search.angle_{kind}": {"start": a, "stop": b} for kind, (a, b) in ranges.items()}
    return CASES[case].replace(motion=motion, limits=limits, **ends)


MANY = {
    "no rest at the lowest": four_segment_scene(
        "flat", {"rise": "parabolic", "return": "cycloidal"}, (67, 101, 52, 140), 40,
        {"curvature_radius": 4}, rise=(54, 84), **{"return": (32, 73)}, dwell=(0, 210),
    ),
    "curvature in two valleys": four_segment_scene(
        "pressure binds, offset given", {"rise": "modified-sine", "return": "poly345"}, (73, 47, 81, 159), 22.5,
        {"pressure_angle": 46, "curvature_radius": 36.7}, rise=(36, 85), **{"return": (68, 110)}, dwell=(23, 238),
    ),
    "corner": four_segment_scene(
        "pressure binds, offset given", {"rise": "parabolic", "return": "cubic"}, (88, 24, 122, 126), 23,
        {"pressure_angle": 35}, rise=(78, 134), **{"return": (77, 170)},
    ),
    "corner of curvature": four_segment_scene(
        "knife", {"rise": "cycloidal", "return": "parabolic"}, (80, 84, 125, 71), 24,
        {"pressure_angle": 38, "curvature_radius": 26}, rise=(58, 118), **{"return": (66, 178)},
    ),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("name", MANY)
def test_no_turn_of_a_few_has_a_smaller_cam(name):
    """Turns drawn at random and turns near the best one, each with a small cam of its own."""
    problem, best = with_rounding_relative_error(resolve(MANY[name])), optimise(MANY[name]).best
    assert best["proved"]
    assert sum(best["angles_deg"]) == pytest.approx(360.0, rel=1e-14)
    turns, rng = SegmentAngles(problem, (None, None)), np.random.default_rng(1)
    own, box = np.array(best["angles_deg"])[list(turns.freed_segments)], turns.angle_box
    shares = rng.uniform(size=(times(4, deep=100), own.size))
    near = (own - box.low) / (box.high - box.low) + rng.normal(size=shares.shape) * 1e-3
    for share in (*shares, *np.clip(near, 0.0, 1.0)):
        turn = turns.programme_with_angles(turns.turn_near_angles(box.low + share * (box.high - box.low), box))
        assert (
            solve_small_cam_unproved(problem.with_programme(turn), search_boxes(problem)[0]).size
            >= size_of(best) - best["gap_mm"]
        )
    assert evaluate(scene_of_optimum(MANY[name], best))["feasible"]


def feasible_cams(turns, ends, count=400):
    """Sizes and angles (by name, arrays) of random feasible cams: some turns, each with random sizes."""
    problem, rng, found = turns.problem, np.random.default_rng(2), []
    for _ in range(times(4, deep=25)):
        freed = turns.turn_near_angles(rng.uniform(turns.angle_box.low, turns.angle_box.high), turns.angle_box)
        sizes = {name: low + (high - low) * rng.uniform(size=count) for name, (low, high) in ends.items()}
        designs = Designs(**{name: sizes[name] for name in SIZE_FIELDS}, sense=problem.design.sense)
        designs = designs.take(feasible_designs(turns.problem_with_angles(freed), designs))
        angles = {f"angle {i}": np.full(len(designs), a) for i, a in zip(turns.freed_segments, freed, strict=True)}
        found.append({**designs.sizes, **angles})
    return {name: np.concatenate([each[name] for each in found]) for name in found[0]}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", [*FREE, *MANY])
def test_no_box_loses_a_feasible_cam(name):
    """Random boxes around random feasible cams: what is left of each still holds its cam."""
    problem = with_rounding_relative_error(resolve((FREE | MANY)[name]))
    turns, rng = SegmentAngles(problem, (None, None)), np.random.default_rng(3)
    search = TurnBoxSearch(turns, search_boxes(problem)[0], TurnOptimum(SmallestCam(None, 0.0), turns.scene_angles))
    ends = search.search_ranges()
    low, high = ends["size"]
    cams = feasible_cams(turns, {**ends, "size": (low, min(high, 10.0 * (low + 30.0)))})
    boxes = DesignBoxes.single_box({**ends, "size": (low, min(high, 1e4))}, 10.0, {})
    cams = {name: cams[name] for name in boxes.free}
    count = cams["size"].size
    assert count > 50
    widths = {n: (boxes.high[n] - boxes.low[n]) * 10.0 ** rng.uniform(-4, 0, count) for n in boxes.free}
    shares = {n: rng.uniform(size=count) for n in boxes.free}
    below = {n: np.maximum(cams[n] - shares[n] * widths[n], boxes.low[n]) for n in boxes.free}
    above = {n: np.minimum(cams[n] + (1.0 - shares[n]) * widths[n], boxes.high[n]) for n in boxes.free}
    for number in range(0, count, max(1, count // times(6, deep=200))):
        one = boxes.with_ends_and_cut_side(
            *({n: end[n][[number]] for n in boxes.free} for end in (below, above)), boxes.side
        )
        left, _ = search.contract_by_limits(search.boxes_with_possible_motion(one))
        assert len(left) == 1
        for n in boxes.free:
            assert left.low[n][0] <= cams[n][number] <= left.high[n][0]


@given(
    places=st.lists(st.floats(-10, 10), min_size=5, max_size=9, unique=True),
    bend=st.floats(0.1, 5),
    lowest=st.floats(-15, 15),
)
@settings(max_examples=times(50, deep=1000))
def test_lines_through_neighbours_bound_a_convex_function(places, bend, lowest):
    places = sorted(round(p, 3) for p in places)
    assume(np.diff(places).min() >= 1e-2)

    def convex(x):
        return bend * (x - lowest) ** 2 + np.maximum(3.0 * (x - 1.0), 0.0)

    floor = convex_lower_bound(places, [convex(x) for x in places[1:-1]])
    least = convex(np.linspace(places[0], places[-1], 4001)).min()
    assert floor <= least + 1e-9


MISTAKES = [
    ({"search.angle_rise": {"start": 60, "stop": 100}}, "search.angle_rise: no other segment can exchange"),
    ({**ANGLES, "search.angle_rise": 5}, "search.angle_rise = 5: must be a table"),
    (
        {**ANGLES, "search.angle_rise": {"start": 0, "stop": 90}},
        "search.angle_rise.start = 0: must be at least 1e-06",
    ),
    (
        {**ANGLES, "search.angle_dwell": {"start": -1, "stop": 90}},
        "search.angle_dwell.start = -1: must be at least 0",
    ),
    (
        {**ANGLES, "search.angle_rise": {"start": 9, "stop": 361}},
        "search.angle_rise.stop = 361: must be at most 360",
    ),
    ({**ANGLES, "search.angle_rise": {"start": 90, "stop": 80}}, "search.angle_rise = "),
    (
        {
            **ANGLES,
            "search.angle_rise": {"start": 60, "stop": 70},
            "search.angle_return": {"start": 60, "stop": 70},
        },
        "search.angle_rise: the segments with a range share 210 deg, but their ranges allow 120 to 140",
    ),
    ({**ANGLES, "search.angle_fall": {"start": 60, "stop": 70}}, "search.angle_fall = "),
]


@pytest.mark.parametrize(("changes", "line"), MISTAKES)
def test_a_mistaken_angle_is_told_in_one_line(changes, line):
    with pytest.raises(BadInput) as caught:
        scene(**changes)
    assert len(caught.value.mistakes) == 1
    assert line in str(caught.value)


def test_a_kind_that_the_motion_has_not_is_a_mistake():
    motion = [{**BASE["motion"][0], "angle": 180}, {**BASE["motion"][2], "angle": 180}]
    with pytest.raises(BadInput, match=r"search\.angle_dwell: the motion has no dwell"):
        scene(motion=motion, **ANGLES, **{"search.angle_dwell": {"start": 0, "stop": 9}})


number = st.one_of(st.floats(allow_nan=True, allow_infinity=True), st.integers(-500, 500), st.text(max_size=3))
ordered = st.tuples(st.floats(1e-6, 360.0), st.floats(1e-6, 360.0)).map(sorted)


@given(
    st.one_of(
        st.dictionaries(st.sampled_from(["rise", "return", "dwell"]), ends, min_size=1)
        for ends in (ordered, st.tuples(number, number))
    )
)
@settings(max_examples=times(30, deep=600))
def test_whatever_the_ranges_they_are_right_or_told(ranges):
    given_ = {f"search.angle_{kind}": {"start": a, "stop": b} for kind, (a, b) in ranges.items()}
    told, turns = set(), None
    try:
        turns = SegmentAngles(resolve(scene(**given_)), (None, None))
    except BadInput as mistakes:
        told = {mistake.key.removesuffix(".start").removesuffix(".stop") for mistake in mistakes.mistakes}
    assert told <= {*given_}
    if turns is None:
        assert told
    else:
        middle = turns.turn_near_angles(sum(turns.angle_box) / 2.0, turns.angle_box)
        assert np.all(middle >= turns.angle_box.low - 1e-9)
        assert np.all(middle <= turns.angle_box.high + 1e-9)
        assert sum(turns.all_segment_angles(middle)) == pytest.approx(360.0, rel=1e-12)


def test_a_sweep_leaves_angles_to_optimise():
    with pytest.raises(BadInput, match=r"search\.angle_rise: a sweep takes the angles of the scene"):
        sweep(scene(**ANGLES))


STRESSED = {
    "the optimum is at an end of a range": (
        {"contact": "roller", "roller_radius": 12},
        770,
        {"offset": {"start": -10, "stop": 10}, "roller_radius": {"start": 8, "stop": 16}},
    ),
    "doubles do not decide cams near an undercut": ({"contact": "flat"}, 600, {}),
}


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", STRESSED)
def test_boxes_prove_a_cam_under_a_stress_without_descents(name):
    follower, stress, search = STRESSED[name]
    strokes = {"lift": 20, "law": "cycloidal"}
    angles = (("rise", 110), ("dwell", 60), ("return", 110), ("dwell", 80))
    problem = with_rounding_relative_error(
        resolve(
            Scene.from_dict(
                {
                    "cam": {"form": "disc", "rotation": "cw", "rpm": 1000, "base_radius": 40},
                    "follower": {
                        "motion": "translating",
                        **follower,
                        "dynamics": {"mass": 4, "spring_rate": 6, "preload": 900},
                    },
                    "materials": {"cam": "steel", "follower": "steel", "face_width": 12},
                    "motion": [
                        {"segment": kind, "angle": angle, **({} if kind == "dwell" else strokes)}
                        for kind, angle in angles
                    ],
                    "limits": {"contact_stress": stress},
                    "search": {
                        **search,
                        **{f"angle_{kind}": {"start": 80, "stop": 140} for kind in ("rise", "return")},
                    },
                }
            )
        )
    )
    turns, bounds = SegmentAngles(problem, (None, None)), search_boxes(problem)[0]
    boxes = TurnBoxSearch(turns, bounds, NelderMead(turns, bounds).best_of_few_turns())
    assert boxes.find_smallest_cam().is_proved
    assert boxes.trial_count < 60


def test_a_load_over_the_turn_stays_at_its_cam_angles():
    """The answer's stress is that of its cam evaluated by itself."""
    scene = find_scene("roller-1000rpm").replace(
        **{
            "cam.rpm": 300,
            "follower.dynamics": {"mass": 1.0, "spring_rate": 10.0, "preload": 250.0, "load": [[0, 0], [100, 900]]},
            "materials": {"cam": "steel", "follower": "steel", "face_width": 10.0},
            "limits": {"pressure_angle": 40, "contact_stress": 3000},
            "search": {
                "law": ["cycloidal"],
                **{f"angle_{s}": {"start": 95, "stop": 115} for s in ("rise", "return")},
            },
        }
    )
    best = optimise(scene).best
    motion = [
        {**s.model_dump(exclude_none=True), "angle": angle, **({"law": "cycloidal"} if s.law else {})}
        for s, angle in zip(scene.motion, best["angles_deg"], strict=True)
    ]
    sizes = {"cam.base_radius": best["base_radius_mm"], "follower.roller_radius": best["roller_radius_mm"]}
    cam = evaluate(
        scene.replace(**{**sizes, "search": None, "motion": motion, "follower.offset": best["offset_mm"]})
    )
    assert cam["contact_stress_max_MPa"] == pytest.approx(best["contact_stress_max_MPa"], rel=1e-8)
