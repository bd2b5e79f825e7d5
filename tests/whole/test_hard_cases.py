"""Hard cases, each by name, with the exact answer where there is one."""

import json
import os
import subprocess
import sys
from math import cos, hypot, inf, pi, radians, sqrt

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support import own
from support.depth import times

from camopt import LAWS, Scene, certify, evaluate, find_scene, load
from camopt.core.kernels import compile
from camopt.core.mistakes import BadInput
from camopt.core.numerics import LARGEST, LEAST
from camopt.core.numerics.curves import value_and_slope
from camopt.model.effects import EvaluationBlock, Setup
from camopt.model.mechanisms import MECHANISMS, Designs
from camopt.model.mechanisms.elements import KNIFE, ROLLER
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.rows import DesignRows
from camopt.scene.search import Search
from camopt.solve.front.pareto import non_dominated

ULP = 2.0**-52


def cam(*segments, base=40.0, contact="roller", roller=8.0, offset=0.0, **more) -> Scene:
    """A translating follower; segments are (kind, angle, lift, law)."""
    sizes = {"roller": {"roller_radius": roller}, "spherical": {"face_radius": roller}}.get(contact, {})
    motion = [
        {"segment": kind, "angle": angle, **({"lift": lift, "law": law} if lift else {})}
        for kind, angle, lift, law in segments
    ]
    return Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": base},
            "follower": {"motion": "translating", "contact": contact, "offset": offset, **sizes},
            "motion": motion,
            **more,
        }
    )


UP_DOWN = (
    ("rise", 120, 20, "cycloidal"),
    ("dwell", 60, 0, None),
    ("return", 120, 20, "poly345"),
    ("dwell", 60, 0, None),
)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_offset_next_to_the_prime_radius(side, gap):
    """s₀ → 0: on the dwell at the bottom tan β = −e/s₀ exactly."""
    prime = 48.0
    offset = side * (prime - gap)
    found = evaluate(cam(*UP_DOWN, offset=offset))
    height = sqrt((prime - abs(offset)) * (prime + abs(offset)))  # the difference is exact
    exact = np.degrees(np.arctan2(abs(offset), height))
    assert found["pressure_angle_max_dwell_deg"] == pytest.approx(exact, rel=1e-13)
    assert found["relative_half_width"] < 1e-9
    assert np.isfinite([v for v in found.values() if isinstance(v, float)]).sum() > 10


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize(("base", "roller"), [(39.9, 8.1), (5.39, 15.753), (40.1, 0.3)])
@mpmath.workdps(50)
def test_sizes_whose_sum_rounds_next_to_the_prime_radius(base, roller, gap):
    """The sum R_b + R_r is that of the numbers as given: its rounding would be 1e-6 of such a gap."""
    offset = base + roller - gap
    found = evaluate(cam(*UP_DOWN, base=base, roller=roller, offset=offset))
    prime = mpmath.mpf(base) + mpmath.mpf(roller)
    exact = mpmath.degrees(mpmath.atan2(offset, mpmath.sqrt(prime**2 - mpmath.mpf(offset) ** 2)))
    complement = 90 - mpmath.mpf(found["pressure_angle_max_dwell_deg"])
    assert abs(complement / (90 - exact) - 1) <= 1e-13 + 1e-14 / complement


@pytest.mark.parametrize("law", ["parabolic", "cycloidal", "modified-trapezoid", "uniform"])
@pytest.mark.parametrize("gap", [1e-5, 1e-7, 1e-9])
def test_a_peak_next_to_the_end_of_a_return(law, gap):
    """s₀ → 0: |tan β| is largest a hair before the end, where jets reach beyond s = 0 and 0·∞ is no bound."""
    prime = 20.0
    motion = [("rise", 40, 25, law), ("dwell", 86, 0, None), ("return", 147, 25, law), ("dwell", 87, 0, None)]
    turn = Programme.from_segments(motion, angular=False)
    zero, mechanism = np.zeros(1), MECHANISMS["disc", "translating", False]
    for side in (1.0, -1.0):
        design = Designs(np.array([prime]), zero, np.array([side * (prime - gap)]), zero, zero, zero, zero, 1.0)
        found = EvaluationBlock(Setup(mechanism, KNIFE), turn, design).extremes(
            mechanism.pressure, [(ALL_STROKES, LARGEST), (ALL_STROKES, LEAST)]
        )
        hairs = np.geomspace(1e-9, 0.1, 20001)
        angles = np.concatenate(
            [place + way * hairs for s in turn.strokes for place, way in ((s.start, 1), (s.end, -1))]
        )
        points = value_and_slope(mechanism.pressure(design, turn), 0, turn.state(angles))[0]
        room = found.width[:, 0] + 1e-12 * np.abs(points).max()
        assert points.max() <= found.value[0, 0] + room[0]
        assert points.min() >= found.value[1, 0] - room[1]


@pytest.mark.parametrize("offset", [48.0, 48.000001, -48.0])
def test_offset_at_or_beyond_the_prime_radius_is_refused(offset):
    with pytest.raises(BadInput, match="must be smaller than the prime radius"):
        cam(*UP_DOWN, offset=offset)


def test_a_cusp_of_the_pitch_curve():
    """s = 0 and y' = e at once: κ without bound next to it, and no NaN at it."""
    rise = Programme.from_segments([("rise", 180, 20, "harmonic"), ("return", 180, 20, "harmonic")], angular=False)
    zero, mechanism = np.zeros(4), MECHANISMS["disc", "translating", False]
    size = np.array([1e-3, 1e-6, 1e-9, 1e-12])
    designs = Designs(size, zero, zero, zero, zero, zero, zero, 1.0)
    found = EvaluationBlock(Setup(mechanism, KNIFE), rise, designs).extremes(
        mechanism.curvature, [(ALL_STROKES, LARGEST), (ALL_STROKES, LEAST)]
    )
    assert not np.isnan(found.value).any()
    assert not np.isnan(found.width).any()
    assert np.all(np.diff(np.abs(found.value).max(axis=0)) >= 0.0)


@pytest.mark.parametrize("k", range(1, 13))
@pytest.mark.parametrize("side", [1, -1])
def test_the_pitch_curve_has_an_inflection_up_to_a_prime_radius(k, side):
    """Harmonic, radial: N² − s·y'' = R_p·(R_p − a) at the start, a = π²L/(2β²) = 90 mm, so κ = 0 at R_p = a."""
    segments = [(kind, 60, 20, "harmonic") for kind in ("rise", "return")]
    found = evaluate(cam(*segments, ("dwell", 240, 0, None), base=90.0 * (1 + side * 10.0**-k) - 5.0, roller=5.0))
    assert np.sign(found["pitch_curvature_min_per_mm"]) == side
    assert np.isinf(found["cutter_radius_max_mm"]) == (side > 0)


@pytest.mark.parametrize("prime", [3.0, 1e-1, 1e-3, 1e-6])
def test_a_flank_that_nearly_conforms_to_the_roller(prime):
    """κ_profile → −1/R_r where κ → −∞: at the start of the same rise, 1/|κ| = R_p²/(a − R_p)."""
    segments = [(kind, 60, 20, "harmonic") for kind in ("rise", "return")]
    loads = {
        "outputs": ["hertz", "cutter_radius_max_mm"],
        "materials": {"cam": "steel", "follower": "steel", "face_width": 10},
    }
    scene = cam(*segments, ("dwell", 240, 0, None), base=prime / 10, roller=prime * 0.9, **loads)
    found = evaluate(
        scene.replace(**{"cam.rpm": 30, "follower.dynamics": {"mass": 1, "preload": 50, "spring_rate": 5}})
    )
    assert found["cutter_radius_max_mm"] / (prime * 0.9) - 1 == pytest.approx(
        prime / (90 - prime) / 0.9, rel=1e-13, abs=4 * ULP
    )
    assert 0.0 < found["contact_stress_max_MPa"] < inf


@pytest.mark.one_in(5)
@pytest.mark.parametrize("k", range(1, 13))
@pytest.mark.parametrize("law", ["harmonic", "cycloidal", "modified-sine"])
def test_the_undercut_verdict_flips_on_the_right_side(law, k):
    """R_r = ρ_min·(1 ± 10⁻ᵏ) on the same pitch curve."""
    segments = [("rise", 60, 20, law), ("dwell", 10, 0, None), ("return", 60, 20, law), ("dwell", 230, 0, None)]
    prime = 30.0
    critical = 1.0 / evaluate(cam(*segments, base=prime - 1.0, roller=1.0))["pitch_curvature_max_per_mm"]
    assert critical < prime
    for side, cut in ((1, True), (-1, False)):
        roller = critical * (1.0 + side * 10.0**-k)
        scene = cam(*segments, base=prime - roller, roller=roller)
        assert evaluate(scene)["undercut"] is cut
        assert certify(scene)["undercut"] == ("broken" if cut else "held")


@pytest.mark.parametrize("contact", ["knife", "roller", "flat", "spherical"])
def test_uniform_velocity_has_corners_under_every_contact(contact):
    segments = [
        ("rise", 90, 10, "uniform"),
        ("dwell", 90, 0, None),
        ("return", 90, 10, "uniform"),
        ("dwell", 90, 0, None),
    ]
    found = evaluate(cam(*segments, contact=contact))
    assert found["velocity_max_rise_mm_per_rad"] == pytest.approx(10 / (pi / 2), rel=1e-15)
    assert found["acceleration_max_rise_mm_per_rad2"] == inf
    assert "jumps at 0°, 90°" in found.unbounded["acceleration_max_rise_mm_per_rad2"]
    assert found["undercut"] is (contact != "knife")


def test_accelerations_at_jumps_are_one_sided():
    harmonic = evaluate(
        cam(("rise", 120, 20, "harmonic"), ("dwell", 60, 0, None), ("return", 180, 20, "parabolic"))
    )
    assert harmonic["acceleration_max_rise_mm_per_rad2"] == pytest.approx(
        20 * pi**2 / 2 / radians(120) ** 2, rel=1e-15
    )
    assert harmonic["acceleration_max_return_mm_per_rad2"] == pytest.approx(4 * 20 / pi**2, rel=1e-15)


@pytest.mark.one_in(5)
@pytest.mark.parametrize(
    ("angle", "lift"), [(0.01, 1e-6), (0.01, 1.0), (359.98, 1e-9), (359.98, 1e6), (120.0, 1e6)]
)
@pytest.mark.parametrize("law", own.EVERY)
def test_extreme_angles_and_lifts(law, angle, lift):
    """Peaks scale with lift and angle, and nothing is NaN."""
    extreme = (("rise", angle, lift, law), ("return", 360 - angle, lift, law))
    found = evaluate(cam(*extreme, base=max(40.0, lift), laws=own.TABLES))
    plain = evaluate(cam(("rise", 180, 1, law), ("return", 180, 1, law), laws=own.TABLES))
    ratio = lift * 180 / angle
    assert found["velocity_max_rise_mm_per_rad"] == pytest.approx(
        plain["velocity_max_rise_mm_per_rad"] * ratio, rel=1e-12
    )
    assert not any(isinstance(value, float) and np.isnan(value) for value in found.values())


@pytest.mark.parametrize("base", [1e-6, 1.0, 1e9])
def test_extreme_base_radii(base):
    found = evaluate(cam(*UP_DOWN, base=base))
    assert not any(isinstance(value, float) and np.isnan(value) for value in found.values())
    assert found["status"] == "certified"


@pytest.mark.parametrize("law", own.EVERY)
@pytest.mark.parametrize("exponent", [1, 3, 8, 16, 50, 100, 150, 300])
@mpmath.workdps(1300)
def test_laws_are_exact_at_the_very_ends(law, exponent):
    """A few units in the last place at x = 10⁻ᵏ, against 1,300 digits."""
    x = float(f"1e-{exponent}")
    exact = own.law_at(own.EVERY[law], mpmath.mpf(x))
    for order, verb in enumerate(("displacement", "velocity", "acceleration")):
        found, expected = float(getattr(own.EVERY[law], verb)(x)), exact[order]
        assert abs(found - expected) <= max(12 * ULP * abs(expected), mpmath.mpf("1e-307")), verb


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("k", [4, 13, 31, 53])
@mpmath.workdps(200)
def test_shipped_laws_are_as_exact_next_to_the_end(law, k):
    """At x = 1 − 2⁻ᵏ, where velocity and acceleration fall to nothing with full digits."""
    exact = own.law_at(LAWS[law], mpmath.mpf(1.0 - 2.0**-k))
    for order, verb in enumerate(("displacement", "velocity", "acceleration")):
        found = float(getattr(LAWS[law], verb)(1.0 - 2.0**-k))
        assert abs(found - exact[order]) <= 12 * ULP * abs(exact[order]), verb


@pytest.mark.parametrize("gap", [1e-2, 1e-5, 1e-8])
@pytest.mark.parametrize(("arm", "centre"), [(80.0, 120.0), (80.7, 121.3)])
@pytest.mark.parametrize("straight", [False, True])
@mpmath.workdps(50)
def test_an_oscillating_follower_next_to_a_flat_triangle(arm, centre, gap, straight):
    """|c − l| → R_p or c + l → R_p, where ψ → 0 or π: tan β of the bottom dwell is (l − c·cos ψ₀)/(c·sin ψ₀)."""
    prime, lift = (centre + arm - gap, 0.02 * sqrt(gap)) if straight else (centre - arm + gap, 10.0)
    motion = [{"segment": s, "angle": 120, **({"lift": lift, "law": "cycloidal"} if s != "dwell" else {})}
              for s in ("rise", "return", "dwell")]  # fmt: skip
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": prime},
            "follower": {
                "motion": "oscillating",
                "contact": "knife",
                "arm_length": arm,
                "centre_distance": centre,
            },
            "motion": motion,
        }
    )
    found = evaluate(scene)
    p, c, l = mpmath.mpf(prime), mpmath.mpf(centre), mpmath.mpf(arm)  # noqa: E741
    cosine = (c * c + l * l - p * p) / (2 * c * l)
    exact = mpmath.degrees(mpmath.atan2(abs(l - c * cosine), c * mpmath.sqrt(1 - cosine**2)))
    assert abs((90 - mpmath.mpf(found["pressure_angle_max_dwell_deg"])) / (90 - exact) - 1) <= 1e-13 / (90 - exact)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_a_flat_face_that_nearly_turns_as_fast_as_the_cam(gap):
    """1 + p → 0 in mid-return: the contact is c·cos ψ/q from the pivot there, q = 1 − 2L/β.

    A hair later ψ is smaller: with q'' = 4π²L/β³ the largest is 1 + tan²ψ·q/(2q'') times as far.
    """
    lift = 30 * (1 - gap)
    segments = {"rise": 150, "dwell": 60, "return": 60}
    motion = [
        {"segment": kind, "angle": angle, **({} if kind == "dwell" else {"lift": lift, "law": "cycloidal"})}
        for kind, angle in segments.items()
    ]
    follower = {"motion": "oscillating", "contact": "flat", "centre_distance": 90, "face_offset": 6}
    scene = {"cam": {"form": "disc", "base_radius": 30}, "follower": follower, "motion": motion}
    found = evaluate(Scene.from_dict({**scene, "motion": [*motion, {"segment": "dwell", "angle": 90}]}))
    psi, rest = np.arcsin(24 / 90) + radians(lift) / 2, 1 - 2 * lift / 60
    bend = 4 * pi**2 * radians(lift) / radians(60) ** 3
    expected = 90 * cos(psi) / rest * (1 + np.tan(psi) ** 2 * rest / (2 * bend))
    assert found["face_reach_max_mm"] == pytest.approx(expected, rel=0.1 * gap**2 + 4 * ULP / gap)
    assert not any(isinstance(value, float) and np.isnan(value) for value in found.values())


def test_angles_that_close_only_after_rounding():
    third = 360 / 7
    turn = [("rise", 3 * third, 10, "poly345"), ("return", 3 * third, 10, "poly345"), ("dwell", third, 0, None)]
    assert evaluate(cam(*turn))["velocity_max_rise_mm_per_rad"] == pytest.approx(10 * 1.875 / radians(3 * third))


@pytest.mark.parametrize("length", [0, 5e-324, 1e-100, 1e-14])
def test_dwells_of_no_length_are_nothing(length):
    plain = evaluate(cam(("rise", 180, 10, "cycloidal"), ("return", 180, 10, "cycloidal")))
    padded = evaluate(
        cam(
            ("rise", 180, 10, "cycloidal"),
            ("dwell", length, 0, None),
            ("return", 180, 10, "cycloidal"),
            ("dwell", length, 0, None),
        )
    )
    assert dict(plain) == dict(padded)


def test_a_turn_of_one_segment_is_refused():
    with pytest.raises(BadInput, match=r"motion\.lift: the follower ends 10 above its start"):
        cam(("rise", 360, 10, "cycloidal"))
    with pytest.raises(BadInput, match="motion: has no rise"):
        cam(("dwell", 360, 0, None))


@pytest.mark.parametrize("k", [-20, -3, 1, 20])
def test_lengths_scaled_by_powers_of_two_scale_exactly(k):
    plain, scale = evaluate(cam(*UP_DOWN, offset=7.0)), 2.0**k
    larger = [(kind, angle, lift * scale, law) for kind, angle, lift, law in UP_DOWN]
    found = evaluate(cam(*larger, base=40.0 * scale, roller=8.0 * scale, offset=7.0 * scale))
    assert found["pressure_angle_max_deg"] == plain["pressure_angle_max_deg"]
    assert found["profile_radius_min_mm"] == plain["profile_radius_min_mm"] * scale
    assert found["pitch_curvature_max_per_mm"] == plain["pitch_curvature_max_per_mm"] / scale


@pytest.mark.parametrize("k", [-300, 300])
def test_lengths_out_of_range_are_refused(k):
    with pytest.raises(BadInput, match=r"cam\.base_radius = .*must be at"):
        cam(*UP_DOWN, base=40.0 * 2.0**k)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "name", ["roller-1000rpm", pytest.param("oscillating-roller", marks=pytest.mark.long), "flat-reciprocating"]
)
def test_compiled_and_uncompiled_agree_bit_for_bit(name, monkeypatch):
    monkeypatch.setattr(compile, "COMPILATION", 0.0)
    command = [sys.executable, "-m", "camopt", "evaluate", name, "--json"]
    plain = subprocess.run(
        command, capture_output=True, text=True, check=True, env={**os.environ, "NUMBA_DISABLE_JIT": "1"}
    )
    assert json.loads(plain.stdout) == evaluate(find_scene(name)).to_dict()


@settings(max_examples=times(20, deep=1000))
@given(data=st.data(), key=st.sampled_from(list(MECHANISMS)), law=st.sampled_from(list(own.EVERY)))
def test_no_point_of_a_curve_lies_outside_of_its_enclosure(data, key, law):
    """Random cams of every mechanism and law: 2,000 points of the true motion each, against value ± half-width."""
    mechanism, angular = MECHANISMS[key], key[1] == "oscillating"
    lift = data.draw(st.floats(2, 20) if angular else st.floats(1, 60))
    rise, fall = data.draw(st.floats(20, 170)), data.draw(st.floats(20, 170))
    rest = (360 - rise - fall) / 2
    turn = Programme.from_segments(
        [
            ("rise", rise, lift, law),
            ("dwell", rest, 0, None),
            ("return", fall, lift, law),
            ("dwell", rest, 0, None),
        ],
        angular=angular,
        laws=own.EVERY,
    )
    sizes = {
        "size": data.draw(st.floats(20, 90)),
        "roller_radius": data.draw(st.floats(0, 20)),
        "offset": 0.0 if angular else data.draw(st.floats(-15, 15)),
        "arm_length": data.draw(st.floats(90, 130)),
        "centre_distance": data.draw(st.floats(120, 160)),
        "face_offset": data.draw(st.floats(-5, 15)),
        "roller_spacing": 0.0,
    }
    design = Designs(**{n: np.array([v]) for n, v in sizes.items()}, sense=data.draw(st.sampled_from([1.0, -1.0])))
    assume(mechanism.can_assemble(design, turn)[0])
    angles = np.concatenate([s.start + s.angle * np.linspace(1e-9, 1 - 1e-9, 500) for s in turn.strokes])
    tolerance = data.draw(st.sampled_from([1e-3, 1e-6, 1e-9, 1e-12]))
    case = EvaluationBlock(Setup(mechanism, ROLLER, tolerance), turn, design)
    for name in ("pressure", "curvature", "profile_radius", "reach"):
        make = getattr(mechanism, name)
        if make is None:
            continue
        found = case.extremes(make, [(ALL_STROKES, LARGEST), (ALL_STROKES, LEAST)])
        points = np.broadcast_to(value_and_slope(make(design, turn), 0, turn.state(angles))[0], angles.shape)
        (most, least), (above, below) = found.value[:, 0], found.width[:, 0]
        slack = 1e-13 * np.abs(points).max()  # of the points themselves, near steep places
        assert points.max() <= most + above + slack
        assert points.min() >= least - below - slack
        assert above <= tolerance * max(abs(most), abs(least)) + 1e-10 * abs(most)


def test_lead_and_height_of_a_right_triangle():
    """3-4-5: offset 3 and prime radius 5 leave a height of 4, so β = atan 3/4 on the bottom dwell."""
    found = evaluate(cam(*UP_DOWN, base=40.0, roller=10.0, offset=30.0))
    assert hypot(30, 40) == 50
    assert cos(radians(found["pressure_angle_max_dwell_deg"])) == pytest.approx(0.8, rel=1e-14)


def test_global_self_crossing_with_harmless_curvature():
    """Two flanks of a slim lobe cut each other off near the base circle; every radius of the profile is sound."""
    segments = (("rise", 40, 160, "parabolic"), ("dwell", 6, 0, None), ("return", 40, 160, "parabolic"))
    slim = evaluate(cam(*segments, ("dwell", 274, 0, None), base=2.4, roller=5.6))
    assert slim["profile_radius_min_mm"] == pytest.approx(2.4, rel=1e-12)
    assert (slim["undercut"], slim["self_crossing"]) == (False, True)
    stout = evaluate(cam(*segments, ("dwell", 274, 0, None), base=2.8, roller=5.2))
    assert (stout["undercut"], stout["self_crossing"]) == (False, False)


# 13. exact ties and duplicates in a Pareto set; infinite objectives


def test_pareto_ties_duplicates_and_infinities():
    infinite = np.inf
    sizes = np.array([1.0, 1.0, 2.0, 2.0, 3.0, 4.0, 5.0])
    peaks = np.array([9.0, 9.0, 5.0, 6.0, infinite, 5.0, 4.0])
    rows = DesignRows({"base_radius_mm": sizes, "acceleration_max_m_s2": peaks}, 7)
    objectives = Search(minimise=["base_radius_mm", "acceleration_max_m_s2"]).objectives
    assert non_dominated(rows, objectives).column("base_radius_mm").tolist() == [1.0, 1.0, 2.0, 5.0]
    rng = np.random.default_rng(0)  # against the definition, on numbers with many ties
    costs = rng.choice([0.0, 1.0, 2.0, 3.0, infinite], size=(400, 2))
    rows = DesignRows({"base_radius_mm": costs[:, 0], "acceleration_max_m_s2": costs[:, 1]}, 400)
    found = non_dominated(rows, objectives)
    better = (costs[:, None] <= costs[None]).all(axis=2) & (costs[:, None] < costs[None]).any(axis=2)
    expected = costs[~better.any(axis=0)]
    assert np.column_stack([found.column(name) for name in objectives]).tolist() == expected.tolist()


TIED = {
    "search.base_radius": [40.25, 40.5, 40.75, 41.0],
    "search.roller_radius": [8.25, 8.5, 8.75, 9.0],
    "search.offset": [0],
    "search.law": ["harmonic", "cycloidal"],
    "search.minimise": ["pressure_angle_max_deg"],
    "search.maximise": ["pitch_curvature_max_per_mm"],
    "limits": {"pressure_angle": 80},
}


@pytest.mark.parametrize("wide", [True, False])
def test_ties_are_ties_with_and_without_wide_vectors(wide, tmp_path):
    """Designs of one prime radius tie. A larger one lowers pressure angle and curvature: all are on the front."""
    features = np._core._multiarray_umath
    known = [each for each in features.__cpu_dispatch__ if features.__cpu_features__[each]]
    narrow = {"NPY_DISABLE_CPU_FEATURES": " ".join(known), "OPENBLAS_CORETYPE": "Nehalem"}
    (tmp_path / "tied.toml").write_text(find_scene("roller-1000rpm").replace(**TIED).to_toml(), encoding="utf-8")
    command = [sys.executable, "-m", "camopt", "sweep", "tied.toml", "--keep", "all", "--out", ".", "--quiet"]
    subprocess.run(command, check=True, cwd=tmp_path, env=os.environ | ({} if wide else narrow))
    designs, front = load(tmp_path / "designs.parquet"), load(tmp_path / "pareto.parquet")
    designs["prime"] = designs.base_radius_mm + designs.roller_radius_mm
    assert designs.groupby(["law_rise", "prime"]).pressure_angle_max_deg.nunique().max() == 1
    assert len(front) == len(designs) == 32
