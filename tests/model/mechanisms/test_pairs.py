"""Pairs of discs and yokes, against both contacts of one rigid follower on the profiles as they are cut."""

from dataclasses import replace

import numpy as np
import pytest
from support.depth import times
from support.pairs import centres, nearest_points, pair, profiles, yoke

import camopt
from camopt.core.mistakes import BadInput
from camopt.core.numerics.budget import UNLIMITED
from camopt.core.numerics.curves import value_and_slope
from camopt.model.effects import EvaluationBlock
from camopt.model.mechanisms.pairs import largest_half_turn_misfit
from camopt.scene.problem.problem import resolve, resolve_design
from camopt.scene.problem.space import search_boxes
from camopt.scene.scene import Scene
from camopt.solve.smallest.smallest import smallest_pair_of_equal_discs
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_boxes import limit_verdict_over_box

ANGLES = np.radians(np.arange(360.0) + 0.37)
SOUND = ("undercut", "self_crossing")


def random_problems(make, kind, count):
    """Problems of random pairs that are neither undercut nor cross themselves."""
    rng, found = np.random.default_rng(39), []
    while len(found) < count:
        problem = resolve_design(Scene.from_dict(make(rng, kind)))
        if not problem.setup.mechanism.can_assemble(problem.design, problem.programme)[0]:
            continue
        rows = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), SOUND)
        if not any(np.any(rows.column(name)) for name in SOUND):
            found.append(problem)
    return found


def quantities(problem, *names):
    rows = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), names)
    return [float(np.broadcast_to(rows.column(name), 1)[0]) for name in names]


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["translating", "oscillating"])
def test_both_rollers_of_a_rigid_follower_touch_both_discs_all_the_turn(motion):
    """And what is told of each disc is what its profile and its roller have there."""
    for problem in random_problems(pair, motion, times(4, 100)):
        second = problem.setup.mechanism.further_contacts[0].local_designs(problem.design)
        one, other = centres(problem, ANGLES)
        assert np.ptp(np.abs(one - other)) < 1e-12 * np.abs(one - other).max()
        for which, (place, design) in enumerate((("first", problem.design), ("second", second))):
            points, distance = nearest_points(problem, which, ANGLES)
            assert np.abs(distance - design.roller_radius[0]).max() < 1e-8
            names = (
                f"{place}_pressure_angle_max_deg",
                f"{place}_profile_radius_min_mm",
                f"{place}_outer_radius_mm",
            )
            angle, radius, outer = quantities(problem, *names)
            normal = (centres(problem, ANGLES)[which] - points) / distance
            # along the way of the roller: of one that swings, square to its arm
            arm = centres(problem, ANGLES)[which] - design.centre_distance[0]
            way = 1j * arm / np.abs(arm) if problem.setup.angular else 1j * np.ones_like(arm)
            seen = np.degrees(np.arctan(np.abs((normal * way.conj()).imag / (normal * way.conj()).real))).max()
            assert seen == pytest.approx(angle, rel=3e-3)
            assert seen <= angle + 1e-4  # the place of a nearest point is known to the root of rounding
            drawn = profiles(problem, np.linspace(0.0, 2.0 * np.pi, 7201)[:-1])[which]
            steps = np.diff(np.append(drawn, drawn[0]))
            bent = np.abs(np.angle(np.roll(steps, -1) / steps)) / np.abs(steps)
            assert np.abs(drawn).max() == pytest.approx(outer, rel=1e-5)
            assert 1.0 / bent.max() == pytest.approx(radius, rel=2e-2)


@pytest.mark.parametrize("motion", ["translating", "oscillating"])
def test_the_distance_of_both_rollers_and_the_angle_between_their_arms_are_told(motion):
    (problem,) = random_problems(pair, motion, 1)
    one, other = (each[0] for each in centres(problem, ANGLES[:1]))
    if motion == "translating":
        assert quantities(problem, "roller_distance_mm") == pytest.approx([abs(one - other)], rel=1e-13)
    else:
        pivot = problem.design.centre_distance[0]
        between = np.degrees(abs(np.angle((one - pivot) / (other - pivot))))
        assert quantities(problem, "subtending_angle_deg") == pytest.approx([between], rel=1e-12)


def test_the_breadth_of_a_disc_in_a_yoke_is_constant_and_its_length_is_that_of_barbier():
    for problem in random_problems(yoke, "breadth", times(4, 60)):
        (breadth,), lift = quantities(problem, "breadth_mm"), problem.programme.lift
        assert breadth == pytest.approx(2 * problem.design.size[0] + lift, rel=1e-14)
        drawn = profiles(problem, np.linspace(0.0, 2.0 * np.pi, 14401))[0]
        for angle in ANGLES[::30]:
            across = (drawn * np.exp(1j * angle)).imag
            assert np.ptp(across) == pytest.approx(breadth, rel=1e-6)
        assert quantities(problem, "profile_length_mm") == pytest.approx([np.pi * breadth], rel=1e-9)
        mechanism = problem.setup.mechanism
        radius = mechanism.profile_radius(problem.design, problem.programme)
        rho = [np.asarray(_curve_values(radius, problem, a)) for a in (ANGLES[:180], ANGLES[180:])]
        assert np.abs(rho[0] + rho[1] - breadth).max() < 1e-10 * breadth


def _curve_values(made, problem, angles):
    return value_and_slope(made, ..., problem.programme.state(angles))[0]


@pytest.mark.parametrize("kind", ["breadth", "diameter"])
def test_a_yoke_has_one_disc(kind):
    """Seen from its second contact, half a turn later, it is the same."""
    for problem in random_problems(yoke, kind, times(3, 40)):
        one, other = profiles(problem, ANGLES)
        assert np.abs(np.roll(one, 180) - other).max() < 1e-9


@pytest.mark.parametrize("kind", ["conjugate", "diameter"])
def test_a_second_disc_is_an_ordinary_cam_that_turns_the_other_way(kind):
    """Its quantities are those of a scene of its own, of the reversed motion."""
    make = {"conjugate": pair, "diameter": yoke}[kind]
    (problem,) = random_problems(make, "translating" if kind == "conjugate" else kind, 1)
    second, programme = problem.setup.mechanism.further_contacts[0].local_designs(problem.design), problem.programme
    turned = [
        (
            {"rise": "return", "return": "rise"}.get(each.segment, each.segment),
            each.angle,
            each.signed_lift,
            each.law,
        )
        for each in problem.segments
    ]
    first = [kind for kind, *_ in turned].index("rise")  # a turn starts where the follower is lowest
    turned = turned[first:] + turned[:first]
    alone = {
        "cam": {
            "form": "disc",
            "base_radius": float(second.size[0]),
            "rotation": "ccw" if second.sense > 0.0 else "cw",
        },
        "follower": {
            "motion": "translating",
            "contact": "roller",
            "roller_radius": float(second.roller_radius[0]),
            "offset": float(second.offset[0]),
        },
        "motion": [
            {"segment": s, "angle": a, **({} if s == "dwell" else {"lift": programme.lift, "law": law})}
            for s, a, _, law in turned
        ],
        "outputs": ["pressure", "curvature", "outline"],
    }
    ordinary = camopt.evaluate(Scene.from_dict(alone))
    only = replace(problem.setup, mechanism=problem.setup.mechanism.further_contacts[0].mechanism)
    rows = run_effects(
        EvaluationBlock(only, programme, second),
        ("pressure_angle_max_deg", "profile_radius_min_mm", "outer_radius_mm"),
    )
    for name in rows.columns:
        assert float(rows.column(name)[0]) == pytest.approx(ordinary[name], rel=1e-8)


def test_a_motion_that_no_yoke_can_make_is_refused_with_the_angle():
    rng = np.random.default_rng(1)
    scene = yoke(rng, "breadth")
    scene["motion"] = [
        {"segment": "rise", "angle": 120, "lift": 10, "law": "cycloidal"},
        {"segment": "return", "angle": 240, "lift": 10, "law": "cycloidal"},
    ]
    with pytest.raises(
        BadInput,
        match=r"y\(θ\) \+ y\(θ \+ 180°\) has to be the lift at every cam angle; the error is .* at",
    ):
        resolve_design(Scene.from_dict(scene))
    assert largest_half_turn_misfit(resolve_design(Scene.from_dict(yoke(rng, "breadth"))).programme).off < 1e-12


def test_a_second_size_that_only_a_search_has_is_that_of_the_first():
    scene = pair(np.random.default_rng(4), "translating")
    del scene["drive"]["offset"]
    plain, searched = (
        Scene.from_dict({**scene, "search": search}) for search in ({}, {"drive.offset": {"start": -9, "stop": 9}})
    )
    assert camopt.evaluate(plain).quantities == camopt.evaluate(searched).quantities
    found = camopt.sensitivities(searched)
    assert found["second_pressure_angle_max_deg", "drive.offset"].derivative != 0.0


BAD = {
    "second arm without a triangle": (
        "oscillating",
        {"drive.arm_length": 20.0},
        r"drive\.arm_length = 20.*: of the second disc: no triangle",
    ),
    "second offset beyond its prime circle": (
        "translating",
        {"drive.offset": 90.0},
        r"drive\.offset = 90.*: of the second disc: must be smaller than the prime radius",
    ),
    "second base circle within the shaft": (
        "translating",
        {"cam.base_radius": 80.0, "cam.shaft_diameter": 120.0},
        r"cam\.shaft_diameter = 120.*: must be at most twice the base radius of the second disc",
    ),
    "an arm that does not swing": ("translating", {"drive.arm_length": 60.0}, r"drive\.arm_length = 60.*has none"),
    "a guide": (
        "translating",
        {"follower.dynamics": {"mass": 1, "guide_length": 80}},
        r"guide_length = 80.*: camopt does not compute the guide of a conjugate pair",
    ),
    "an interference that is no small one": (
        "translating",
        {"drive.interference": 5.0, "drive.stiffness": 9e3},
        r"drive\.interference = 5\.0: must be at most a tenth of the roller's radius \([01]\.\d+\)",
    ),
    "the same of arms": (
        "oscillating",
        {"search": {"drive.interference": {"start": 0.01, "stop": 5.0}}, "drive.stiffness": 9e3},
        r"search\.drive\.interference = .*: must be .* at the end of the arm \(0\.\d+ deg\)$",
    ),
    "a clearance": (
        "translating",
        {"drive.clearance": 0.02, "drive.interference": 0.01, "drive.stiffness": 9e3},
        r"^[^\n]*drive\.clearance = 0\.02: a conjugate pair has none$",
    ),
    "friction of a guide that it has not": (
        "oscillating",
        {"follower.dynamics": {"inertia": 0.01, "friction": 0.1}},
        r"^[^\n]*dynamics\.friction = 0\.1: a disc cam .* has none; it has [^\n]*$",
    ),
    "mass of a cam": (
        "translating",
        {"limits": {"area": 9e3}},
        r"limits\.area = 9000.*: this mechanism has no area_mm2",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_pair_that_cannot_be_gets_one_clear_message(name):
    motion, changes, message = BAD[name]
    scene = Scene.from_dict(pair(np.random.default_rng(3), motion))
    with pytest.raises(BadInput, match=message):
        resolve_design(scene.replace(**changes))


@pytest.mark.slow
def test_a_second_disc_with_a_range_of_its_own_is_made_as_small_as_it_can_be():
    """Two equal discs with one base radius for both have the same answer."""
    scene = pair(np.random.default_rng(8), "translating")
    for table, keys in {"cam": ("base_radius",), "drive": ("base_radius", "roller_radius", "offset")}.items():
        for key in keys:
            del scene[table][key]
    scene |= {"limits": {"pressure_angle": 25}}
    together = camopt.optimise(Scene.from_dict(scene)).best
    apart = camopt.optimise(Scene.from_dict(scene | {"search": {"drive.base_radius": {"start": 10, "stop": 300}}}))
    found = max(apart.best["base_radius_mm"], apart.best["second_base_radius_mm"])
    assert found == pytest.approx(together["base_radius_mm"], rel=1e-8)
    assert apart.best["proved"]
    problem = resolve(apart.scene)
    alike = smallest_pair_of_equal_discs(problem, search_boxes(problem)[0], UNLIMITED)
    assert alike.size == alike.second["second_size"] == pytest.approx(together["base_radius_mm"], rel=1e-8)


@pytest.mark.parametrize(("base", "said"), [(40.0, "held"), (25.0, "undecided")])
def test_that_no_cam_of_a_box_crosses_itself_is_said_of_both_discs(base, said):
    """The first disc is as round as before; of a small second one its largest pressure angle shows nothing."""
    scene = pair(np.random.default_rng(12), "oscillating")
    scene["drive"]["base_radius"] = base
    problem = resolve_design(Scene.from_dict(scene))
    (limit,) = (each for each in problem.limits if each.name == "self_crossing")
    roller = float(problem.design.roller_radius[0])
    box = {"roller_radius": (roller - 0.01, roller + 0.01)}
    assert limit_verdict_over_box(problem, limit, problem.design, box).verdict == said


def test_what_is_found_at_a_contact_is_not_sought_again(monkeypatch):
    """A pair takes twice the searches of one disc, with limits that read each other and some designs of a block."""
    from camopt.solve.verdicts.limit_verdicts import quantities_with_excess_bounds

    asked, extremes = [], EvaluationBlock.extremes
    monkeypatch.setattr(
        EvaluationBlock, "extremes", lambda *each, **more: asked.append(each) or extremes(*each, **more)
    )
    feed = camopt.find_scene("press-feed-by-pair").replace(part=None, **{"limits.pressure_angle": 30})
    counts = []
    for scene in (feed.replace(drive=None), feed):
        problem = resolve(scene)
        sizes = problem.design.take([0, 0, 0]).with_values({"size": np.array([40.0, 50.0, 62.0])})
        outer = quantities_with_excess_bounds(problem, sizes, frozenset()).outer
        counts.append(len(asked))
        assert 0 < np.count_nonzero(np.all(outer <= 0.0, axis=0)) < 3
        alone = [quantities_with_excess_bounds(problem, sizes.take([k]), frozenset()).outer[:, 0] for k in range(3)]
        assert np.array_equal(outer, np.transpose(alone))
        asked.clear()
    assert counts[1] == 2 * counts[0]
