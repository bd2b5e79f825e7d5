"""Motion laws against 50 digits, and the programme that joins them."""

import json
from itertools import pairwise
from math import inf, isinf, radians
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import own

from camopt import Scene, evaluate
from camopt.core.kernels.compile import compiled
from camopt.core.numerics.piecewise import state_on_panel
from camopt.core.quantities import motion_rms_name
from camopt.model.motion import LAWS
from camopt.model.motion.law import is_symmetric, vdi_motion_task
from camopt.model.motion.law_panels import law_panel_polynomials
from camopt.model.motion.polynomial import PolynomialLaw
from camopt.model.motion.programme import (
    TURN_PANELS,
    Programme,
    derivative_peak,
    law_peaks,
    law_peaks_inside_stroke,
)
from camopt.model.motion.stroke import RETURN, RISE


@compiled
def fill_motion(table, u, found):
    for panel in range(u.size):
        at = state_on_panel(table, panel, u[panel])
        found[0, panel], found[1, panel], found[2, panel], found[3, panel] = at.y, at.y1, at.y2, at.y3


def all_motion(table, u):
    """The motion and its derivatives at one point of each panel: kernels call ``motion``, Python cannot."""
    found = np.empty((4, u.size))
    fill_motion(table, u, found)
    return found


REFERENCE = json.loads((Path(__file__).parents[2] / "data" / "laws.json").read_text())
VERBS = {"s": "displacement", "v": "velocity", "a": "acceleration", "j": "jerk"}


@pytest.mark.parametrize("law", REFERENCE)
@pytest.mark.parametrize("letter", VERBS)
def test_laws_against_fifty_digits(law, letter):
    points = REFERENCE[law]["points"]
    found = getattr(LAWS[law], VERBS[letter])(np.array([p["x"] for p in points]))
    expected = np.array([float(p[letter]) for p in points])
    # near a zero inside the stroke (mid-stroke acceleration) the argument's rounding limits the digits
    room = 1e-14 * np.abs(expected) + (1e-15 * np.abs(expected).max() if letter in "aj" else 1e-300)
    assert np.all(np.abs(found - expected) <= room)


@pytest.mark.parametrize("law", REFERENCE)
def test_peaks_against_fifty_digits(law):
    found = law_peaks(LAWS[law])
    for letter, name in (("v", "peak_velocity"), ("a", "peak_acceleration"), ("j", "peak_jerk")):
        expected = float(REFERENCE[law]["peaks"][letter])
        assert found[name] == (expected if isinf(expected) else pytest.approx(expected, rel=1e-12))


CLOSED_PEAKS = {
    "cubic": (1.5, 6.0, inf),
    "double-harmonic": (3 * np.sqrt(3) * np.pi / 8, np.pi**2, inf),
    "poly56789": (315 / 128, None, 78.75),
}


INSIDE = {  # whatever is around the stroke
    "uniform": (1, 0, 0),
    "parabolic": (2, 4, 0),
    "harmonic": (np.pi / 2, np.pi**2 / 2, np.pi**3 / 2),
    "cubic": (1.5, 6, 12),
    **dict.fromkeys(("half-cycloidal-1", "half-cycloidal-2"), (2, np.pi, np.pi**2)),
    **dict.fromkeys(("half-harmonic-1", "half-harmonic-2"), (np.pi / 2, np.pi**2 / 4, np.pi**3 / 8)),
}


@pytest.mark.parametrize("law", LAWS)
def test_peaks_inside_a_stroke(law):
    found, between = law_peaks_inside_stroke(LAWS[law]), law_peaks(LAWS[law])
    if law in INSIDE:
        assert tuple(found.values()) == pytest.approx(INSIDE[law], rel=1e-12)
    assert all(value == between[name] for name, value in found.items() if between[name] < inf)


@pytest.mark.parametrize("law", CLOSED_PEAKS)
def test_peaks_in_closed_form(law):
    found = law_peaks(LAWS[law])
    for name, expected in zip(("peak_velocity", "peak_acceleration", "peak_jerk"), CLOSED_PEAKS[law], strict=True):
        if expected is not None:
            assert found[name] == pytest.approx(expected, rel=1e-12)


PAIRS = {  # Kloomok and Muffley, Product Engineering, Feb. 1955, of half curves; VDI 2143 of what the letters mean
    "half-cycloidal-1": "R-G",
    "half-cycloidal-2": "G-R",
    "half-harmonic-1": "U-G",
    "half-harmonic-2": "G-U",
    "uniform": "G-G",
    **dict.fromkeys(("double-harmonic", "poly8"), "R-U"),
    **dict.fromkeys(("parabolic", "harmonic", "cubic"), "U-U"),
}


@pytest.mark.parametrize("law", LAWS)
def test_a_law_tells_what_it_joins(law):
    assert vdi_motion_task(LAWS[law]) == PAIRS.get(law, "R-R")


def test_a_motion_in_general_has_velocity_and_acceleration():
    assert vdi_motion_task(PolynomialLaw("own", (0.0, 1.0, 2.0), (1.0, 0.0, 0.0))) == "B-R"


@pytest.mark.parametrize(("half", "whole"), [("half-cycloidal", "cycloidal"), ("half-harmonic", "harmonic")])
def test_half_curves_are_the_halves_of_a_law(half, whole):
    x = np.linspace(0.0, 1.0, 101)
    for place in (0.0, 1.0):
        law = LAWS[f"{half}-{place + 1:g}"]
        for order, verb in enumerate(VERBS.values()):
            expected = 2.0 ** (1 - order) * getattr(LAWS[whole], verb)((x + place) / 2) - place * (order == 0)
            np.testing.assert_allclose(getattr(law, verb)(x), expected, rtol=0, atol=2e-15 * np.abs(expected).max())


@pytest.mark.parametrize("law", own.EVERY)
def test_a_law_runs_from_0_to_1_and_its_verbs_are_derivatives(law):
    module = own.EVERY[law]
    assert list(module.displacement([0.0, 1.0])) == [0.0, 1.0]
    x = np.linspace(0.0007, 0.9993, 1001)
    x = x[np.min(np.abs(x[:, None] - np.array(module.BREAKS)), axis=1) > 2e-4]
    verbs = [module.displacement, module.velocity, module.acceleration, module.jerk]
    for lower, higher in pairwise(verbs):
        step = 1e-4
        slope = (8 * (lower(x + step / 2) - lower(x - step / 2)) - (lower(x + step) - lower(x - step))) / (6 * step)
        assert slope == pytest.approx(higher(x), abs=1e-9 * max(1.0, np.abs(higher(x)).max()))


def test_laws_that_join_the_same_at_both_ends_are_symmetric():
    assert {law for law in LAWS if is_symmetric(LAWS[law])} == {
        law for law in LAWS if len(set(vdi_motion_task(LAWS[law]).split("-"))) == 1
    }


@pytest.mark.parametrize("law", [law for law in LAWS if is_symmetric(LAWS[law])])
@given(x=st.floats(0.0, 1.0))
def test_symmetric_laws_mirror(law, x):
    module = LAWS[law]
    assert module.displacement(1.0 - x) + module.displacement(x) == pytest.approx(1.0, abs=7e-16)
    assert module.velocity(1.0 - x) == pytest.approx(module.velocity(x), rel=1e-14, abs=1e-15)


@pytest.mark.parametrize(
    "law", ["harmonic", "cycloidal", "poly345", "poly4567", "modified-trapezoid", "modified-sine"]
)
@pytest.mark.parametrize("x", [1e-3, 1e-8, 1e-60, 1e-100])
def test_the_start_of_a_stroke_keeps_its_digits(law, x):
    with mpmath.workdps(400):
        exact = mpmath.mpf(x)
        w = 4 * mpmath.pi
        value = {
            "harmonic": lambda t: mpmath.sin(mpmath.pi * t / 2) ** 2,
            "cycloidal": lambda t: t - mpmath.sin(2 * mpmath.pi * t) / (2 * mpmath.pi),
            "poly345": lambda t: t**3 * (10 - 15 * t + 6 * t**2),
            "poly4567": lambda t: t**4 * (35 - 84 * t + 70 * t**2 - 20 * t**3),
            "modified-trapezoid": lambda t: 8 * mpmath.pi / (2 + mpmath.pi) * (w * t - mpmath.sin(w * t)) / w**2,
            "modified-sine": lambda t: 4 * mpmath.pi**2 / (4 + mpmath.pi) * (w * t - mpmath.sin(w * t)) / w**2,
        }[law](exact)
        found = mpmath.mpf(float(LAWS[law].displacement(x)))
        if float(value) > 1e-300:
            assert abs(found - value) <= 8 * mpmath.mpf(2) ** -53 * value


def turn(law, other=None):
    return Programme.from_segments(
        [
            ("rise", 100, 25, law),
            ("dwell", 80, 0, None),
            ("return", 70, 25, other or law),
            ("dwell", 110, 0, None),
        ],
        angular=False,
        laws=own.EVERY,
    )


@pytest.mark.parametrize("law", own.EVERY)
def test_tables_are_the_laws(law):
    programme = turn(law)
    table = programme.table
    u = np.random.default_rng(1).uniform(-1, 1, table.centre.size)
    exact = programme.motion_at(table.centre + u * table.half_width)
    found = all_motion(table, u)
    scale = np.abs(exact).max(axis=1, keepdims=True) + 1e-300
    assert np.all(np.abs(found - exact) <= scale * np.array([[1e-14], [1e-13], [1e-12], [1e-10]]))


@pytest.mark.one_in(5)
@pytest.mark.parametrize("law", own.EVERY)
@pytest.mark.parametrize("lift", [1e-6, 20.0, 1e6])
@mpmath.workdps(50)
def test_tables_are_as_good_as_they_say_and_lie_in_their_ranges(law, lift):
    """Against 50 digits, at random points of every panel."""
    strokes = [("rise", 77.7, lift, law), ("return", 123.4, lift, law)]
    turn = [strokes[0], ("dwell", 50, 0, None), strokes[1], ("dwell", 108.9, 0, None)]
    programme = Programme.from_segments(turn, angular=False, laws=own.EVERY)
    table, rng = programme.table, np.random.default_rng(3)
    _, ends, _ = law_panel_polynomials(own.EVERY[law], TURN_PANELS, ())
    count = ends.size - 1
    places = rng.uniform(-1, 1, table.centre.size)
    found = all_motion(table, places)
    for stroke, first in ((programme.strokes[0], 0), (programme.strokes[2], count + 1)):
        for k in range(count):
            panel, b = first + k, mpmath.mpf(stroke.angle)
            x = (ends[k + 1] + ends[k]) / 2 + mpmath.mpf(places[panel]) * ((ends[k + 1] - ends[k]) / 2)
            level, lifted = mpmath.mpf(stroke.low), mpmath.mpf(stroke.high) - mpmath.mpf(stroke.low)
            unit = own.law_at(own.EVERY[law], x)
            exact = [lifted * d / b**order for order, d in enumerate(unit[:4])]
            exact[0] += level
            y, error = found[:, panel], table.error[panel]
            for order in range(4):
                assert abs(exact[order] - y[order]) <= error[order], (panel, order)
                assert abs(exact[order]) <= table.most[panel, order] + error[order]
            for order in range(3):
                assert table.low[panel, order] - error[order] <= exact[order]
                assert exact[order] <= table.high[panel, order] + error[order]


def test_jumps_are_known_as_such():
    assert [(j.order, round(np.degrees(j.at))) for j in turn("harmonic").jumps] == [
        (2, 0),
        (2, 100),
        (2, 180),
        (2, 250),
    ]
    assert [(j.order, round(np.degrees(j.at))) for j in turn("uniform").corners] == [
        (1, 0),
        (1, 100),
        (1, 180),
        (1, 250),
    ]
    assert turn("cycloidal").jumps == ()


def test_a_jump_that_cancels_is_none():
    eccentric = Programme.from_segments(
        [("rise", 180, 10, "harmonic"), ("return", 180, 10, "harmonic")], angular=False
    )
    assert eccentric.jumps == ()
    assert derivative_peak(eccentric, 3, RISE) == pytest.approx(5.0)


def test_peaks_are_infinite_only_where_a_lower_derivative_jumps():
    mixed = turn("cycloidal", "uniform")
    assert derivative_peak(mixed, 2, RISE) < inf
    assert derivative_peak(mixed, 2, RETURN) == inf
    assert derivative_peak(mixed, 1, RETURN) == pytest.approx(25 / radians(70))


def test_zero_length_dwells_drop_out():
    segments = [("rise", 180, 10, "cycloidal"), ("dwell", 0, 0, None), ("return", 180, 10, "cycloidal")]
    assert len(Programme.from_segments(segments, angular=False).strokes) == 2


@pytest.mark.parametrize(("angle", "lift"), [(0.01, 1e-9), (0.01, 1e6), (359.98, 1e6), (359.98, 1e-9)])
def test_extreme_strokes_have_exact_peaks(angle, lift):
    programme = Programme.from_segments(
        [("rise", angle, lift, "cycloidal"), ("return", 360 - angle, lift, "cycloidal")], angular=False
    )
    assert derivative_peak(programme, 2, RISE) == pytest.approx(2 * np.pi * lift / radians(angle) ** 2, rel=1e-12)


SQUARES = {"harmonic": {"acceleration": (np.pi**2 / 2) ** 2 / 2}, "cycloidal": {"acceleration": 2 * np.pi**2}}
SQUARES["cycloidal"]["jerk"] = (2 * np.pi) ** 4 / 2
SQUARES["poly345"] = {"acceleration": 120 / 7, "jerk": 720.0}
"""Mean squares over a unit stroke, by integrals of the laws in closed form."""


@pytest.mark.parametrize(("law", "derivative"), [(law, each) for law, means in SQUARES.items() for each in means])
@pytest.mark.parametrize("motion", ["translating", "oscillating"])
@pytest.mark.parametrize("rpm", [None, 300.0])
def test_root_mean_squares_in_closed_form(law, derivative, motion, rpm):
    angular, order = motion == "oscillating", {"acceleration": 2, "jerk": 3}[derivative]
    contact = {"arm_length": 80, "centre_distance": 100} if angular else {}
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 60} | ({} if rpm is None else {"rpm": rpm}),
            "follower": {"motion": motion, "contact": "roller", "roller_radius": 8, **contact},
            "motion": [
                {"segment": "rise", "angle": 110, "lift": 15, "law": law},
                {"segment": "dwell", "angle": 40},
                {"segment": "return", "angle": 150, "lift": 15, "law": law},
                {"segment": "dwell", "angle": 60},
            ],
            "outputs": ["rms"],
        }
    )
    name = motion_rms_name(derivative, angular=angular, timed=rpm is not None)
    strokes = np.radians([110.0, 150.0])
    mean = np.sum((15 / strokes**order) ** 2 * SQUARES[law][derivative] * strokes) / (2 * np.pi)
    in_degrees = np.radians(1.0) if angular and rpm is not None else 1.0 if angular or rpm is None else 1e-3
    speed = 1.0 if rpm is None else rpm * np.pi / 30
    assert evaluate(scene)[name] == pytest.approx(np.sqrt(mean) * speed**order * in_degrees, rel=1e-12)
    limited = scene.replace(limits={name: evaluate(scene)[name] * (1 - 1e-9)})
    assert evaluate(limited)["violated"] == name
