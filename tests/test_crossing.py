"""Self-crossing of disc cams: proof against polygons, enclosures against points, witnesses against roots."""

from dataclasses import replace
from math import degrees, inf, radians

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import fsolve, minimize_scalar
from shapely import LinearRing

from camopt import Scene, certify, evaluate
from camopt.effects import Case, Subject, crossing, curvature
from camopt.effects.crossing import find_crossing
from camopt.effects.parts import cover, first_parts
from camopt.geometry import profile_points
from camopt.mechanisms import MECHANISMS, Designs
from camopt.motion import LAWS
from camopt.motion.programme import Programme
from camopt.question import resolve

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
def cases(draw, keys=DISC, slimmest=0.3) -> Case:
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
    }
    design = Designs(**{n: np.array([v]) for n, v in sizes.items()}, sense=draw(st.sampled_from([1.0, -1.0])))
    assume(MECHANISMS[key].exists(design, turn)[0])
    return Case(Subject(MECHANISMS[key], angular, radius == 0.0 and not flat, None, None), turn, design)


def points_of(case: Case, angles) -> np.ndarray:
    return profile_points(case.subject.mechanism, case.designs, case.programme, np.asarray(angles, dtype=float))


def polygon_crosses(case: Case) -> bool:
    """The slow, obvious rival: the profile as a polygon of some thousand sides."""
    strokes = [s.start + s.angle * np.linspace(0, 1, 3000, endpoint=False) for s in case.programme.strokes]
    points = points_of(case, np.concatenate(strokes))
    return not LinearRing(np.column_stack([points.real, points.imag])).is_simple


def undercut(case: Case) -> bool:
    return bool(curvature.run(case, frozenset())["undercut"][0])


def self_crossing(case: Case) -> bool:
    return bool(crossing.run(case, frozenset())["self_crossing"][0])


@settings(max_examples=150, deadline=None)
@given(case=cases(slimmest=2))
def test_the_proof_agrees_with_a_polygon(case):
    """An undercut may be too small for a polygon to show; all else agrees."""
    if undercut(case):
        assert self_crossing(case)
    else:
        assert self_crossing(case) == polygon_crosses(case)


@settings(max_examples=100, deadline=None)
@given(case=cases(keys=ROUND, slimmest=2), share=st.lists(st.floats(-0.999999, 0.999999), min_size=20, max_size=20))
def test_parts_enclose_the_profile(case, share):
    """Inside of them: at an end, a corner of the motion may already have turned the normal."""
    assume(not undercut(case))
    parts = first_parts(case.programme)
    found = cover(case.subject, case.designs, case.programme, parts)
    starts, ends = parts.middle - parts.half, parts.middle + parts.half
    assert starts[0] == pytest.approx(0.0, abs=1e-15)
    assert ends[-1] == pytest.approx(2 * np.pi, rel=1e-15)
    assert ends[:-1] == pytest.approx(starts[1:], rel=1e-14)
    for x in share:
        angles = parts.middle + x * parts.half
        away = points_of(case, angles) - found.point
        travel = case.subject.mechanism.travel(case.designs, case.programme, angles)
        normal = np.exp(-1j * case.designs.sense * angles) * travel.normal
        assert np.all(np.abs(away) <= found.radius)
        assert np.all(np.abs((found.tangent.conj() * away).imag) <= found.bulge)
        assert np.all(np.abs(np.angle(normal / found.normal)) <= found.spread)


@settings(max_examples=60, deadline=None)
@given(case=cases(keys=ROUND, slimmest=2), exponent=st.sampled_from([-9, 5]))
def test_mirrored_and_scaled_cams_have_the_same_verdict(case, exponent):
    """Mirrored: the cam turns the other way, with the offset on the other side. Scaled: by a power of two.

    An oscillating follower, whose pivot stays to the right, has no mirror image here.
    """
    assume(not undercut(case))
    found = find_crossing(case.subject, case.designs, case.programme)
    if not case.subject.angular:
        other = replace(case.designs, sense=-case.designs.sense, offset=-case.designs.offset)
        assert find_crossing(case.subject, other, case.programme) == found
    scale, strokes = 2.0**exponent, case.programme.strokes
    if not case.subject.angular:
        strokes = tuple(replace(s, low=s.low * scale, high=s.high * scale) for s in strokes)
    larger = Designs(**{n: v * scale for n, v in case.designs.sizes.items()}, sense=case.designs.sense)
    assert find_crossing(case.subject, larger, Programme(strokes)) == found


def slim_cams(count: int, key) -> list[Case]:
    """Cams with a large roller and a lobe that may be narrower at its neck than at its top."""
    random, made, angular = np.random.default_rng(11), [], key[1] == "oscillating"
    while len(made) < count:
        rise, fall, lift = random.uniform(15, 60), random.uniform(15, 60), random.uniform(40, 85)
        laws = random.choice(["parabolic", "cycloidal", "modified-sine"], 2)
        turn = turn_of(rise, random.uniform(2, 30), fall, lift * (1 if angular else 2), laws, angular=angular)
        radius, arm = random.uniform(2, 15), random.uniform(120, 160) * angular
        sizes = (radius * random.uniform(0.05, 0.6), radius, 0.0, arm, arm * random.uniform(0.95, 1.05), 0.0)
        design = Designs(*(np.array([size]) for size in sizes), sense=1.0)
        case = Case(Subject(MECHANISMS[key], angular, False, None, None), turn, design)
        if MECHANISMS[key].exists(design, turn)[0] and not undercut(case):
            made.append(case)
    return made


@pytest.mark.parametrize("key", ROUND)
def test_a_crossing_shown_is_a_root(key):
    """The two angles lead Newton's method to one point of the profile at two cam angles, along two directions."""
    shown = 0
    for case in slim_cams(60, key):
        found = find_crossing(case.subject, case.designs, case.programme)
        assert found.shown is polygon_crosses(case)
        if not found.shown:
            continue

        def gap(angles, case=case):
            first, second = points_of(case, angles)
            return [(first - second).real, (first - second).imag]

        roots, report, _, _ = fsolve(gap, found.at, full_output=True, xtol=1e-14)
        size = float(case.designs.prime_radius[0])
        assert np.hypot(*report["fvec"]) < 1e-11 * size
        assert np.abs(roots - found.at).max() <= found.within + 1e-12
        shown += 1
    assert shown > 10


@settings(max_examples=60, deadline=None)
@given(case=cases(keys=ROUND))
def test_a_knife_edge_draws_no_crossing(case):
    """Where the distance from the centre is the same, so are displacement and cam angle."""
    designs = replace(case.designs, roller_radius=np.zeros(1))
    edge = replace(case, subject=replace(case.subject, pointed=True), designs=designs)
    assume(edge.subject.mechanism.exists(edge.designs, edge.programme)[0])
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
    question = resolve(lobe(1.0, law=law))

    def reaching(angle):
        y, y1 = question.programme.at(np.atleast_1d(angle))[:2]
        turn, s = np.exp(1j * (radians(43) - angle)), 8.0 + y
        sideways = (turn * (-y1 + 1j * s)).real / np.hypot(s, y1)
        return np.where(sideways < 0.0, (1j * turn * s).real / np.minimum(sideways, -1e-300), inf)

    angles = np.linspace(0.0, radians(40), 20001)
    near = int(np.argmin(reaching(angles)))
    best = minimize_scalar(
        lambda angle: float(reaching(angle)[0]), bounds=angles[[near - 1, near + 1]], method="bounded",
        options={"xatol": 1e-12},
    )  # fmt: skip
    return float(best.fun), degrees(best.x)


@pytest.mark.parametrize("k", range(1, 11))
@pytest.mark.parametrize("law", ["parabolic", "modified-sine", "cycloidal"])
def test_the_verdict_flips_where_the_flanks_touch(law, k):
    critical, angle = touching_roller(law)
    for side, crosses in ((1, True), (-1, False)):
        scene = lobe(critical * (1.0 + side * 10.0**-k), law=law)
        assert evaluate(scene)["undercut"] is False
        assert evaluate(scene)["self_crossing"] is crosses
        assert certify(scene) == {"undercut": "held", "self_crossing": "broken" if crosses else "held"}
        question = resolve(scene)
        found = find_crossing(question.subject, question.design, question.programme)
        if crosses and k > 2:
            assert np.degrees(found.at) == pytest.approx([angle, 86 - angle], abs=3 * 10 ** (-k / 2))


def test_touching_flanks_are_undecided_and_count_as_crossing():
    scene = lobe(touching_roller("parabolic")[0])
    assert certify(scene)["self_crossing"] == "undecided"
    assert evaluate(scene)["self_crossing"] is True


def test_verdicts_of_a_block_are_those_of_its_designs():
    question = resolve(lobe(5.0))
    radii = np.linspace(0.0, 7.9, 600)
    design = replace(
        Designs(**{n: np.resize(v, 600) for n, v in question.design.sizes.items()}, sense=1.0),
        size=8.0 - radii, roller_radius=radii,
    )  # fmt: skip
    case = Case(question.subject, question.programme, design)
    found = crossing.run(case, frozenset())["self_crossing"]
    assert np.array_equal(found, radii >= touching_roller("parabolic")[0])
    for i in (0, 300, 599):
        assert found[i] == self_crossing(replace(case, designs=design.take([i])))


def test_undercut_is_a_crossing_in_proofs_too():
    scene = lobe(5.0).replace(**{"cam.base_radius": 0.5, "follower.roller_radius": 60.0})
    assert certify(scene) == {"undercut": "broken", "self_crossing": "broken"}
    assert evaluate(scene)["self_crossing"] is True
