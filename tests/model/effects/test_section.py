"""Area, length, centroid and moments of profiles: against polygons, circles, Steiner's formulas and 50 digits."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from shapely.geometry import Polygon
from support.cams import CONTACTS, cam_with
from support.depth import times

from camopt import Scene, evaluate, evaluate_designs, find_scene, shipped_scenes
from camopt.core.numerics.quadrature import GAUSS_ORDERS, gauss_rule
from camopt.model.effects import EvaluationBlock, section
from camopt.model.effects.solid import keyway_moments
from camopt.model.mechanisms.geometry import profile_points
from camopt.scene.problem.problem import resolve_design

NAMES = (section.PROFILE_LENGTH, section.AREA, *section.CENTROID, section.POLAR_MOMENT)
OPEN = [contact for contact in CONTACTS if not contact.startswith("groove")]
DISCS = [n for n in shipped_scenes() if find_scene(n).mechanism.body.bounded and n != "press-feed-by-pair"]


def scene_of(contact, law="cycloidal", **more):
    """A cam without loads that shows its section."""
    return Scene.from_dict(cam_with(contact, law, outputs=["section"], **more))


def polygon_moments(scene, count):
    """Length, area, centroid and polar moment of the polygon through points of the profile, by its triangles."""
    problem = resolve_design(scene)
    angles = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    z = profile_points(problem.setup.mechanism, problem.design, problem.programme, angles)
    after = np.roll(z, -1)
    twice = -problem.design.sense * (np.conj(z) * after).imag
    area = twice.sum() / 2
    centroid = ((z + after) * twice).sum() / (6 * area)
    polar = (twice * (np.abs(z) ** 2 + np.abs(after) ** 2 + (np.conj(z) * after).real)).sum() / 12
    return np.array([np.abs(after - z).sum(), area, centroid.real, centroid.imag, polar]), z


def agree(found, expected, rel):
    size = np.sqrt(expected[1] / np.pi)
    scale = np.array([expected[0], expected[1], size, size, expected[4]])
    assert np.max(np.abs([found[name] for name in NAMES] - np.asarray(expected)) / scale) < rel


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", DISCS)
def test_a_section_is_that_of_a_polygon_of_many_points(name):
    """The polygon's error falls with the square of its sides: two of them give the limit."""
    scene = find_scene(name).replace(outputs=["section"])
    (coarse, _), (fine, points) = polygon_moments(scene, 50_000), polygon_moments(scene, 100_000)
    expected = fine + (fine - coarse) / 3
    rounded = 1e-6 if resolve_design(scene).programme.corners else 2e-9  # a corner lies between two points
    found = evaluate(scene)
    agree(found, expected, rounded)
    polygon = Polygon(np.column_stack([points.real, points.imag]))
    if polygon.is_valid:
        assert found["area_mm2"] == pytest.approx(polygon.area, rel=1e-6)
        assert found["profile_length_mm"] == pytest.approx(polygon.length, rel=1e-6)
        assert (found["centroid_x_mm"], found["centroid_y_mm"]) == pytest.approx(
            polygon.centroid.coords[0], abs=1e-5
        )


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", OPEN)
def test_the_sections_of_all_mechanisms(contact, rotation):
    scene = scene_of(contact, "modified-sine", rotation=rotation)
    (coarse, _), (fine, _) = polygon_moments(scene, 20_000), polygon_moments(scene, 40_000)
    agree(evaluate(scene), fine + (fine - coarse) / 3, 1e-9)


@pytest.mark.parametrize("contact", ["knife", "flat", "offset-roller"])
def test_a_mirrored_cam_has_the_mirrored_section(contact):
    scene = scene_of(contact, "poly345")
    other = scene.replace(**{"cam.rotation": "cw", "follower.offset": -scene.follower.offset})
    one, two = evaluate(scene), evaluate(other)
    assert two["centroid_x_mm"] == pytest.approx(-one["centroid_x_mm"], rel=1e-12)
    for name in (*NAMES[:2], "centroid_y_mm", section.POLAR_MOMENT):
        assert two[name] == pytest.approx(one[name], rel=1e-13)


@pytest.mark.parametrize("contact", [c for c in OPEN if c != "spherical"])
def test_a_cam_of_twice_the_size(contact):
    scene = scene_of(contact)
    sizes = {"cam.base_radius", *(f"follower.{k}" for k in ("roller_radius", "offset"))}
    sizes |= {f"follower.{k}" for k in ("arm_length", "centre_distance", "face_offset")}
    given = {key: value for key, value in scene.numbers(sizes).items() if value}
    double = scene.replace(**{key: 2 * value for key, value in given.items()})
    if scene.follower.motion == "translating":
        motion = [
            s | ({"lift": 2 * s["lift"]} if "lift" in s else {}) for s in cam_with(contact, "cycloidal")["motion"]
        ]
        double = double.replace(motion=motion)
    one, two = evaluate(scene), evaluate(double)
    for name, factor in zip(NAMES, (2, 4, 2, 2, 16), strict=True):
        assert two[name] == pytest.approx(factor * one[name], rel=1e-12)


@pytest.mark.parametrize(("radius", "x", "y"), [(40.0, 12.0, 0.0), (25.0, 3.0, -4.0)])
@pytest.mark.parametrize("contact", OPEN)
def test_an_eccentric_is_a_circle(contact, radius, x, y):
    """A = πr², L = 2πr, centroid at e from the axis, ∫r² dA = πr⁴/2 + A·e²."""
    data = cam_with(contact, outputs=["section"])
    del data["motion"], data["cam"]["base_radius"]
    if contact == "spherical":
        data["follower"]["face_radius"] = 20
    data["profile"] = [{"element": "arc", "radius": radius, "x": x, "y": y}]
    found, eccentricity = evaluate(Scene.from_dict(data)), np.hypot(x, y)
    area = np.pi * radius**2
    assert found["area_mm2"] == pytest.approx(area, rel=1e-12)
    assert found["profile_length_mm"] == pytest.approx(2 * np.pi * radius, rel=1e-12)
    assert found["polar_moment_mm4"] == pytest.approx(area * (radius**2 / 2 + eccentricity**2), rel=1e-12)
    assert np.hypot(found["centroid_x_mm"], found["centroid_y_mm"]) == pytest.approx(eccentricity, rel=1e-12)


@pytest.mark.parametrize("law", ["cycloidal", "parabolic", "uniform", "poly4567"])
@pytest.mark.parametrize("base", ["roller", "offset-roller", "arm"])
def test_parallel_curves_after_steiner(base, law):
    """A(R) = A₀ − L₀·R + π·R² and L(R) = L₀ − 2π·R, corners and what is undercut by them included."""
    point = scene_of(base, law).replace(**{"cam.base_radius": 84 - 1e-9, "follower.roller_radius": 1e-9})
    pitch = evaluate(point)
    for radius in (5.0, 14.0):
        other = point.replace(**{"cam.base_radius": 84 - radius, "follower.roller_radius": radius})
        found = evaluate(other)
        area = pitch["area_mm2"] - pitch["profile_length_mm"] * radius + np.pi * radius**2
        assert found["area_mm2"] == pytest.approx(area, rel=1e-10)
        assert found["profile_length_mm"] == pytest.approx(
            pitch["profile_length_mm"] - 2 * np.pi * radius, rel=1e-10
        )


def displacement(x):
    """The turn of ``cam_with`` with poly345, and its derivative, at a cam angle in deg, as mpmath numbers."""
    for start, angle, low, high in ((0, 110, 0, 24), (110, 40, 24, 24), (150, 95, 24, 0), (245, 115, 0, 0)):
        if x <= start + angle:
            u = (x - start) / angle
            s, v = u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * (1 - u) ** 2
            return low + (high - low) * s, (high - low) * v / (mpf(angle) * mp.pi / 180)
    raise AssertionError(x)


def turned_integral(integrand):
    ends = [mpf(a) for a in (0, 110, 150, 245, 360)]
    return mp.quad(lambda x: integrand(*displacement(x)), ends) * mp.pi / 180


def test_sections_in_fifty_digits():
    """Knife: 2A = ∮(s² + e²)dθ, L = ∮√(s² + (y' − e)²)dθ. Flat: 2A = ∮((R_b + y)² − y'²)dθ, L = ∮(R_b + y)dθ."""
    knife, flat = (
        evaluate(scene_of(c, "poly345").replace(**{"follower.offset": e})) for c, e in (("knife", 9), ("flat", 0))
    )
    with mp.workdps(50):
        height = mp.sqrt(mpf(70) ** 2 - 81)
        area = turned_integral(lambda y, v: (height + y) ** 2 + 81) / 2
        length = turned_integral(lambda y, v: mp.sqrt((height + y) ** 2 + (v - 9) ** 2))
        polar = turned_integral(lambda y, v: ((height + y) ** 2 + 81) * ((height + y) ** 2 - 9 * (v - 9))) / 4
        face = turned_integral(lambda y, v: (70 + y) ** 2 - v**2) / 2
        around = turned_integral(lambda y, v: 70 + y)
    assert knife["area_mm2"] == pytest.approx(float(area), rel=2e-14)
    assert knife["profile_length_mm"] == pytest.approx(float(length), rel=2e-14)
    assert knife["polar_moment_mm4"] == pytest.approx(float(polar), rel=2e-14)
    assert flat["area_mm2"] == pytest.approx(float(face), rel=2e-14)
    assert flat["profile_length_mm"] == pytest.approx(float(around), rel=2e-14)


@pytest.mark.parametrize("order", GAUSS_ORDERS)
def test_a_rule_is_exact_for_polynomials(order):
    rule, powers = gauss_rule(order), np.arange(order)
    values = rule.nodes[:, None] ** powers
    even = np.where(powers % 2, 0.0, 2.0 / (powers + 1))
    np.testing.assert_allclose(rule.weights @ values, even, atol=1e-14)
    slopes = powers * rule.nodes[:, None] ** np.maximum(powers - 1, 0)
    np.testing.assert_allclose(rule.derivative @ values, slopes, atol=1e-13 * order**2)


SIZES = st.lists(st.tuples(st.floats(60, 160), st.floats(3, 40)), min_size=5, max_size=5)


@settings(max_examples=times(10, deep=1000))
@given(st.sampled_from(OPEN), SIZES, st.sampled_from(["cycloidal", "parabolic"]))
def test_the_width_that_is_told_holds_the_value(contact, drawn, law):
    """At a coarse tolerance the values are off by no more than the row says."""
    scene = scene_of(contact, law)
    key = {"spherical": "face_radius"}.get(contact, "roller_radius")
    sizes = {"base_radius_mm": [size + 30.0 for size, _ in drawn]}
    if getattr(scene.follower, key):
        sizes[f"{key}_mm"] = [roller for _, roller in drawn]
    coarse, fine = (
        evaluate_designs(scene.replace(**{"accuracy.relative_error": tolerance}), sizes)
        for tolerance in (1e-2, 1e-13)
    )
    there = fine["violated"] != "assembly"
    assert ((coarse["violated"] != "assembly") == there).all()
    assume(there.any())
    coarse, fine = coarse[there], fine[there]
    radius = np.sqrt(abs(fine["area_mm2"]) / np.pi)
    for name in NAMES:
        scale = radius if name in section.CENTROID else abs(fine[name])
        assert (abs(coarse[name] - fine[name]) / scale <= coarse["relative_half_width"] + 2e-13).all()


def test_many_designs_are_those_one_by_one():
    """Also where they are more than a block."""
    scene = find_scene("roller-1000rpm").replace(outputs=["section"])
    sizes = np.linspace(60.0, 90.0, 301)
    many = evaluate_designs(scene, {"base_radius_mm": sizes, "offset_mm": 0.1 * sizes, "law": "cycloidal"})
    for row in (0, 150, 300):
        one = {"base_radius_mm": sizes[[row]], "offset_mm": 0.1 * sizes[[row]], "law": "cycloidal"}
        alone = evaluate_designs(scene, one)
        for name in NAMES:
            assert many[name].iloc[row] == pytest.approx(alone[name].iloc[0], rel=1e-13)
    problem = resolve_design(scene)
    design = problem.design.take(np.zeros(3000, dtype=int))
    found = section.integrate_section(EvaluationBlock(problem.setup, problem.programme, design))
    assert np.ptp(found.value, axis=1).max() == 0.0


@pytest.mark.parametrize(("width", "depth", "angle"), [(8.0, 3.3, 0.0), (8.0, 3.3, 2.0), (24.9, 0.2, -1.0)])
def test_a_keyway_is_a_rectangle_less_its_bore(width, depth, angle):
    radius, steps = 12.5, np.linspace(-1.0, 1.0, 200_001)
    arc = np.arcsin(width / 2 / radius) * steps
    inner = radius * np.exp(1j * arc)
    bottom = radius + depth + 0.5j * width * np.array([1.0, -1.0])
    z = np.concatenate([inner, bottom]) * np.exp(1j * angle)
    after = np.roll(z, -1)
    twice = -(np.conj(z) * after).imag
    expected = keyway_moments(radius, width, depth, angle)
    assert twice.sum() / 2 == pytest.approx(expected.area, rel=1e-8)
    assert ((z + after) * twice).sum() / 6 == pytest.approx(expected.moment, rel=1e-8)
    polar = (twice * (np.abs(z) ** 2 + np.abs(after) ** 2 + (np.conj(z) * after).real)).sum() / 12
    assert polar == pytest.approx(expected.polar, rel=1e-8)
