"""Paths of arcs, cubics and lines against the curves that they follow: dense points, exact arcs, identities."""

from functools import cache
from math import hypot, inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.cams import CONTACTS, cam_with
from support.curves import largest_distance, true_points
from support.depth import covering_cases, times

from camopt import BadInput, Scene, cam_points, find_scene, shipped_scenes
from camopt.scene.problem.problem import resolve_design
from camopt.solve.contour.curve import disc_curves, pitch_or_face_curve
from camopt.solve.contour.deviation import deviation_upper_bound
from camopt.solve.contour.path import ArcPath
from camopt.solve.contour.path_fitting import FITTERS, biarcs, check_path_options, fit_path, fit_unproved_path

SCENES = [*shipped_scenes(), *CONTACTS]


def scene_of(name):
    return Scene.from_dict(cam_with(name)) if name in CONTACTS else find_scene(name)


def problem_of(name, **changes):
    return resolve_design(scene_of(name).replace(**changes))


@cache
def kind_of(name):
    """What makes the curve of a scene what it is: its mechanism, and whether its profile is given."""
    problem = problem_of(name)
    return problem.setup.mechanism.name, bool(problem.profile)


def profile_of(problem):
    return next(curve for name, curve in disc_curves(problem).items() if name.startswith("profile"))


def dense(path, count):
    """Points on a path, element by element, from the elements' own formulas."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    if isinstance(path, ArcPath):
        sweep = path.sweeps
        straight = np.abs(sweep) < 1e-9
        safe = np.where(straight, 1.0, sweep)
        along = np.where(straight, share, (np.exp(1j * safe * share) - 1.0) / (np.exp(1j * safe) - 1.0))
        return (path.vertices[:-1] + path.chords * along).T.ravel()
    p0, p1, p2, p3 = path.controls.T
    rest = 1.0 - share
    found = rest**3 * p0 + 3 * rest**2 * share * p1 + 3 * rest * share**2 * p2 + share**3 * p3
    return found.T.ravel()


def largest_distance_at_equal_angles(curve, path, count):
    """The largest distance of points of a spline from those of the curve at the same cam angles."""
    angles = path.angles[:, :1] + np.diff(path.angles) * np.linspace(0.0, 1.0, count)
    points = [curve.points(curve.spans[span], at) for span, at in zip(path.spans, angles, strict=True)]
    return np.abs(dense(path, count) - np.ravel(points)).max()


SLIDING_SPLINE = ("pump-of-constant-breadth", "spline")  # twice as far from its curve at equal angles as beside it
CASES = dict.fromkeys([SLIDING_SPLINE, *((name, kind) for kind in FITTERS for name in SCENES)])


@pytest.mark.one_in(15)
@pytest.mark.parametrize(
    ("name", "kind"), covering_cases(CASES, lambda case: [case[0], (kind_of(case[0]), case[1])])
)
def test_the_path_is_within_its_proved_deviation(name, kind):
    """Both ways, measured on dense points; and the bound is hardly more than what it bounds.

    ``fit_path`` stops as soon as the bound is small enough; the bound that is as small as it gets is compared. That
    of a spline bounds the distance at equal cam angles.
    """
    problem = problem_of(name)
    curve = profile_of(problem)
    path, proved = fit_path(curve, kind, 0.005)
    assert proved <= 0.005
    count = 2 + 60_000 // len(path)
    true, made = true_points(problem, curve.distance), dense(path, count)
    chord = 1e-5  # what straight lines between so many points leave out
    measured = max(largest_distance(true, made), largest_distance(made, true))
    least = deviation_upper_bound(curve, path)
    assert measured - chord <= least <= proved
    bounded = largest_distance_at_equal_angles(curve, path, count) if kind == "spline" else measured
    assert bounded >= 0.99 * least - chord


@pytest.mark.parametrize(("kind", "order"), [(kind, fit.order) for kind, fit in FITTERS.items()])
def test_elements_grow_with_the_root_of_the_deviation(kind, order):
    curve = profile_of(problem_of("roller"))
    few, many = (len(fit_unproved_path(curve, kind, tolerance)) for tolerance in (1e-2, 1e-5))
    assert many / few == pytest.approx(10 ** (3 / order), rel=0.25)


@pytest.mark.parametrize("name", ["three-arc-valve", "tangent-cam", "eccentric-rocker"])
def test_a_profile_of_arcs_and_lines_comes_back_as_those(name):
    problem = problem_of(name)
    path, _ = fit_path(profile_of(problem), "arcs", 1e-4)
    radii = {float(f"{1 / k:.6g}") if abs(k) > 1e-9 else inf for k in -problem.design.sense * path.curvatures}
    given_radii = {*problem.profile}
    assert given_radii <= radii


@pytest.mark.parametrize("name", ["roller", "flat", "spherical"])
def test_the_mirrored_cam_has_the_mirrored_path(name):
    paths = [fit_path(profile_of(problem_of(name, **{"cam.rotation": way}))).path for way in ("ccw", "cw")]
    one, other = (path.vertices for path in paths)
    np.testing.assert_allclose(other, -one.conjugate(), atol=1e-9)
    np.testing.assert_allclose(paths[1].bulges, -paths[0].bulges, atol=1e-9)


@pytest.mark.parametrize("name", ["roller", "arm", "swinging-face"])
def test_arcs_join_with_one_tangent(name):
    path, _ = fit_path(profile_of(problem_of(name)))
    starts, ends = path.tangents
    assert np.abs(np.append(starts[1:], starts[0]) - ends).max() < 1e-9


def test_the_bound_of_a_shifted_path_is_at_least_the_shift():
    """A path moved by a known distance is off by that, at least where it moves across."""
    problem = problem_of("roller")
    curve = profile_of(problem)
    path, proved = fit_path(curve)
    for shift in (0.01, 0.01j):
        moved = ArcPath(path.vertices + shift, path.bulges, path.angles, path.spans)
        assert 0.01 - proved <= deviation_upper_bound(curve, moved) <= 0.03


def test_the_rotating_arc_of_a_dwell_is_one_arc():
    path, _ = fit_path(pitch_or_face_curve(problem_of("roller")))
    dwells = [k for k, stroke in enumerate(problem_of("roller").programme.strokes) if stroke.law is None]
    assert len(dwells) == 2
    curve = pitch_or_face_curve(problem_of("roller"))
    for k, span in enumerate(curve.spans):
        if span.stroke.law is None:
            assert path.spans.count(k) == 1


@given(
    heading=st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
    end=st.tuples(st.floats(0.5, 2.0), st.floats(-0.4, 0.4)),
)
def test_biarcs_have_the_points_and_tangents_given(heading, end):
    p0, p1 = np.array([0j]), np.array([complex(*end)])
    t0, t1 = (np.exp(1j * np.array([angle])) for angle in heading)
    pair = biarcs(p0, t0, p1, t1)
    path = ArcPath(np.concatenate([p0, pair.joint, p1]), np.concatenate(pair.bulges), np.zeros((2, 2)), (0, 0))
    starts, ends = path.tangents
    assert np.abs([starts[0] - t0[0], ends[1] - t1[0], starts[1] - ends[0]]).max() < 1e-9


@pytest.mark.parametrize(
    ("kind", "chord"), [("bezier", 0.001), ("arcs", 0.0), ("arcs", float("nan")), ("arcs", 1e-7), ("arcs", 11.0)]
)
def test_invalid_path_options_are_refused(kind, chord):
    with pytest.raises(BadInput, match=r"one of arcs, spline, polyline|from 1e-06 to 10 mm"):
        check_path_options(kind, chord)


@settings(max_examples=times(6, deep=300))
@given(
    contact=st.sampled_from(sorted(CONTACTS)),
    law=st.sampled_from(["cycloidal", "harmonic", "poly345", "modified-sine", "parabolic"]),
    rotation=st.sampled_from(["ccw", "cw"]),
    kind=st.sampled_from(sorted(FITTERS)),
    chord=st.floats(1e-4, 0.05),
)
def test_random_cams_are_followed(contact, law, rotation, kind, chord):
    problem = resolve_design(Scene.from_dict(cam_with(contact, law, rotation=rotation)))
    for curve in disc_curves(problem).values():
        path, proved = fit_path(curve, kind, chord)
        assert proved <= chord
        points = dense(path, 3)
        sample = true_points(problem, curve.distance, 4001)
        assert largest_distance(points, sample) <= proved + 1e-3


def test_series_give_the_points_that_the_library_gives():
    """Cam points at both ends and in the middle of short stretches, against the expansion about the middle."""
    for name in CONTACTS:
        scene = scene_of(name)
        problem = resolve_design(scene)
        curve = profile_of(problem)
        points = cam_points(scene, step=360.0)
        first = curve.points(curve.spans[0], np.array([0.0]))[0]
        stem = "profile_left" if problem.setup.mechanism.has_flanks_on_both_sides else "profile"
        assert hypot(first.real - points[f"{stem}_x_mm"][0], first.imag - points[f"{stem}_y_mm"][0]) < 1e-9
        span = curve.spans[0]
        middle = (span.start + span.end) / 2
        expansion = curve.taylor_expansion([span], np.array([middle - 1e-3]), np.array([middle + 1e-3]))
        for t in (-1e-3, 0.0, 1e-3):
            x, y = (sum(c * t**k for k, c in enumerate(terms.terms)) for terms in expansion.at_middles)
            true = curve.points(span, np.array([middle + t]))
            assert np.abs(x + 1j * y - true).max() < 1e-9
            low, high = expansion.over_stretches[0].terms[3].low, expansion.over_stretches[0].terms[3].high
            assert low <= expansion.at_middles[0].terms[3] <= high
