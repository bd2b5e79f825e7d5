"""Means over the turn: against 50 digits of another program, identities, orders of convergence, and boxes."""

from dataclasses import replace
from functools import cache
from itertools import islice, pairwise
from math import inf, isfinite, sqrt

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.optimize import brentq
from support.balls.ball import precisely
from support.balls.curves import in_balls
from support.balls.means import DISPLACEMENT_TERMS, TAYLOR_ORDER, MeanOfPowers
from support.balls.proof import exact_turn
from support.cams import CONTACTS, FREE, GUIDED, SWUNG, cam_with

from camopt import Scene, certify, evaluate, optimise, prices
from camopt.core.numerics.interval import Interval
from camopt.core.quantities import AT_LEAST, QUANTITIES
from camopt.model.effects import EFFECTS, EvaluationBlock
from camopt.model.effects.loads import torque_curve
from camopt.model.effects.mean import Mean
from camopt.model.effects.mean_columns import power_means
from camopt.model.effects.peak import MotionDerivative
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.solve.verdicts.mean_boxes import enclose_mean_of_curve_power

DIGITS = 50
LONG = 3600.0  # seconds: searches end when they have proved what they find


def scene_of(contact, law="poly345", **more):
    dynamics = SWUNG if CONTACTS[contact]["motion"] == "oscillating" else GUIDED
    return Scene.from_dict(cam_with(contact, law, dynamics, **more))


def means_of(problem):
    return {name: mean for effect in EFFECTS.values() for name, mean in effect.means(problem.setup).items()}


def narrow_ball(problem, mean, rounds=200, enough=0.0):
    """The last ball, or the first that is narrow enough, relative to its middle, and how wide each was."""
    with precisely(DISPLACEMENT_TERMS):
        motion, widths = exact_turn(problem.programme), []
        for ball in islice(MeanOfPowers.of(mean, in_balls(problem.design), motion).enclosures(), rounds):
            widths.append(float(ball.rad()))
            if widths[-1] < enough * abs(float(ball.mid())):
                break
    return ball, widths


# ----------------------------------------------------------------------------------------------- second answers


def quadrature(curve, ends):
    """1/2π·∮curve dθ by Gauss's rule of mpmath between cam angles, in 50 digits."""
    return mp.quad(curve, ends) / (2 * mp.pi)


def position(x, order):
    """3-4-5 polynomial: s and its derivatives."""
    powers = [0, 0, 0, 10, -15, 6]
    for _ in range(order):
        powers = [k * c for k, c in enumerate(powers)][1:]
    return sum(c * x**k for k, c in enumerate(powers))


class Turn:
    """Rise 110°, dwell 40°, return 95°, dwell 115° of 24 mm, of the cam of ``cam_with``."""

    def __init__(self):
        self.degree = mp.pi / 180
        self.omega = 420 * mp.pi / 30
        self.strokes = [(0, 110, mpf(0), 24), (150, 95, mpf(24), -24)]

    def motion(self, stroke, theta):
        start, angle, low, lift = stroke
        x = (theta - start * self.degree) / (angle * self.degree)
        first, *rest = (lift * position(x, k) / (angle * self.degree) ** k for k in range(3))
        return low + first, *rest

    def force(self, y, y1, y2):
        mass, damping, weight = mpf("0.0008"), mpf("0.03"), mpf("0.0008") * mpf("9.81") * 1000
        steady = 260 + 12 + weight
        return mass * self.omega**2 * y2 + damping * self.omega * y1 + 9 * y + steady

    def torque(self, stroke, theta, radius, offset):
        """With the friction of a guide of 80 mm, 70 mm over it, on a roller of 14 mm."""
        y, y1, y2 = self.motion(stroke, theta)
        force, height = self.force(y, y1, y2), mp.sqrt((radius + 14) ** 2 - offset**2) + y
        lean, drag = abs((y1 - offset) / height), mpf("0.12") * (2 * (70 - y) + 80) / 80
        return force * y1 / (1 - mp.sign(force * y1) * drag * lean)

    def kinks(self, stroke, offset):
        """Where F or the lean of the contact changes sign: between samples, by bisection."""
        start, angle, *_ = stroke
        ends = [start * self.degree, (start + angle) * self.degree]
        for changing in (
            lambda t: self.force(*self.motion(stroke, t)),
            lambda t: self.motion(stroke, t)[1] - offset,
        ):
            places = [ends[0] + (ends[1] - ends[0]) * k / 60 for k in range(1, 60)]
            for a, b in pairwise(places):
                if changing(a) * changing(b) < 0:
                    ends.append(mp.findroot(changing, (a, b), solver="anderson", tol=mpf(10) ** -90))
        middles = [ends[0] + (ends[1] - ends[0]) * k / 12 for k in range(1, 12)]
        return sorted([*ends, *middles])


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize(("contact", "offset"), [("roller", 0), ("offset-roller", 11)])
def test_the_torque_of_a_rubbing_follower_is_that_of_50_digits(contact, offset):
    problem = with_rounding_relative_error(resolve(scene_of(contact)))
    known, cam = means_of(problem), evaluate(scene_of(contact))
    with mp.workdps(DIGITS):
        turn = Turn()
        ends = {stroke: turn.kinks(stroke, offset) for stroke in turn.strokes}
        torque = cache(lambda stroke, t: turn.torque(stroke, t, 70, offset))  # at the same angles for both powers
        for name, power in (("torque_mean_N_m", 1), ("torque_rms_N_m", 2)):
            true = sum(
                quadrature(lambda t, s=stroke, p=power: torque(s, t) ** p, ends[stroke]) for stroke in turn.strokes
            )
            ball, _ = narrow_ball(problem, known[name], enough=1e-20)
            near = mpf(str(ball.mid().str(45, radius=False)))
            # the scene's numbers are doubles of rad/s and N there: 1e-16 relative
            assert abs(near / true - 1) < mpf("1e-14")
            reached = float(true) if power == 1 else sqrt(float(true))
            assert cam[name] == pytest.approx(reached * 1e-3, rel=1e-14)


def test_root_mean_squares_of_a_polynomial_are_those_in_closed_form():
    """∮(y⁽ⁿ⁾)² dθ of 3-4-5 strokes: Σ h²·c/φ^(2n−1), c = 10/7, 120/7, 720."""
    problem = with_rounding_relative_error(resolve(scene_of("knife")))
    for order, share in ((1, mpf(10) / 7), (2, mpf(120) / 7), (3, mpf(720))):
        with mp.workdps(DIGITS):
            angles = [mpf(angle) * mp.pi / 180 for angle in (110, 95)]
            true = sum(24**2 * share / angle ** (2 * order - 1) for angle in angles) / (2 * mp.pi)
        mean = Mean(((MotionDerivative(order), ALL_STROKES),), 2)
        ball, widths = narrow_ball(problem, mean)
        assert len(widths) == 1  # nothing is left out of a polynomial
        assert abs(mpf(str(ball.mid().str(45, radius=False))) / true - 1) < mpf("1e-38")
        found = power_means(EvaluationBlock(problem.setup, problem.programme, problem.design), mean).value[0]
        assert found == pytest.approx(float(true), rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["groove", "groove-arm"])
def test_a_groove_is_as_long_as_its_chords(contact):
    """By the mechanism's own points, of which chords fall short by the square of their length."""
    problem = with_rounding_relative_error(resolve(scene_of(contact)))
    ball, _ = narrow_ball(problem, means_of(problem)["groove_length_mm"])
    found, lengths = 2.0 * np.pi * float(ball.mid()), []
    for count in (20_000, 40_000):
        angles = np.linspace(0.0, 2.0 * np.pi, count + 1)
        angles[-1] -= 1e-12
        travel = problem.setup.mechanism.trace_and_normal(problem.design, problem.programme, angles)
        lengths.append(np.abs(np.diff(travel.trace)).sum())
    assert lengths[1] + (lengths[1] - lengths[0]) / 3.0 == pytest.approx(found, rel=1e-11)
    assert evaluate(scene_of(contact))["groove_length_mm"] == pytest.approx(found, rel=1e-13)


@pytest.mark.parametrize(("contact", "unit"), [("knife", "mm"), ("arm", "deg")])
@pytest.mark.parametrize("law", ["cycloidal", "poly345", "harmonic"])
def test_the_lift_area_of_a_symmetric_law_is_half_that_of_its_box(contact, unit, law):
    """h·(110/2 + 40 + 95/2) for these strokes; the volume that a valve lets through, and a limit from below."""
    lift = 14.0 if unit == "deg" else 24.0
    name, true = f"lift_area_{unit}_deg", lift * (110 / 2 + 40 + 95 / 2)
    scene = scene_of(contact, law, outputs=["rms"])
    assert evaluate(scene)[name] == pytest.approx(true, rel=1e-14)
    for share, verdict in ((1 - 1e-12, "held"), (1 + 1e-12, "broken")):
        assert certify(scene.replace(limits={name: true * share}))[name] == verdict


@pytest.mark.one_in(4)
@pytest.mark.parametrize("law", ["cycloidal", "modified-sine", "poly345", "harmonic"])
@pytest.mark.parametrize("contact", ["flat", "arm", "groove-arm"])
def test_springs_and_masses_give_back_what_they_take(contact, law):
    """∮F·y' dθ is what damping takes: the mean of all of the torque lies in the ball of the mean of that."""
    problem = with_rounding_relative_error(resolve(scene_of(contact, law)))
    spent, _ = narrow_ball(problem, means_of(problem)["torque_mean_N_m"])
    whole, _ = narrow_ball(problem, Mean(((lambda d, p: torque_curve(problem.setup, d, p), ALL_STROKES),)))
    assert whole.overlaps(spent)
    assert float((whole - spent).mid()) == pytest.approx(0.0, abs=1e-40 * float(abs(spent)))


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("contact", CONTACTS)
def test_columns_are_those_of_balls(contact):
    problem, cam = (
        with_rounding_relative_error(resolve(scene_of(contact, "cycloidal"))),
        evaluate(scene_of(contact, "cycloidal")),
    )
    known = means_of(problem)
    assert {"torque_mean_N_m", "torque_rms_N_m", "power_mean_W"} < known.keys()
    for name, mean in known.items():
        ball, _ = narrow_ball(problem, mean, 60, enough=1e-16)
        value = mean.scale.quantity_from_extreme(mean.mean_from_power_mean(float(ball.mid())), problem.design)
        assert cam[name] == pytest.approx(np.asarray(value).item(), rel=1e-13)


# ------------------------------------------------------------------------------------------ orders and kinks


def test_halved_parts_are_as_much_nearer_as_the_order_says():
    """What is left out of a sine wave falls by 2^(K + 1)."""
    problem = with_rounding_relative_error(resolve(scene_of("knife", "cycloidal")))
    _, widths = narrow_ball(problem, means_of(problem)["acceleration_rms_m_s2"], 4)
    far = [width for width in widths if width > 1e-50 * widths[0]]
    assert len(far) > 2
    assert all(after < before * 2.0 ** (-0.8 * TAYLOR_ORDER) for before, after in pairwise(far[1:]))


@pytest.mark.slow
def test_next_to_a_kink_the_range_tells_and_is_cut():
    problem = with_rounding_relative_error(resolve(scene_of("offset-roller")))
    ball, widths = narrow_ball(problem, means_of(problem)["torque_rms_N_m"])
    assert widths[-1] < 1e-40 * float(ball)
    assert len(widths) > 40


def test_a_mean_at_its_bound_is_undecided():
    scene = scene_of("roller").replace(limits={"torque_rms_N_m": evaluate(scene_of("roller"))["torque_rms_N_m"]})
    assert certify(scene)["torque_rms_N_m"] == "undecided"


def test_where_the_velocity_jumps_the_mean_is_known_and_its_root_mean_square_infinite():
    scene = scene_of("flat", "uniform")
    cam = evaluate(scene)
    assert isfinite(cam["torque_mean_N_m"])
    limits = {"torque_mean_N_m": cam["torque_mean_N_m"] * (1 + 1e-9), "torque_rms_N_m": 1e9}
    verdicts = certify(scene.replace(limits=limits))
    assert (verdicts["torque_mean_N_m"], verdicts["torque_rms_N_m"]) == ("held", "broken")
    limits["torque_mean_N_m"] = cam["torque_mean_N_m"] * (1 - 1e-9)
    assert certify(scene.replace(limits=limits))["torque_mean_N_m"] == "broken"


# ----------------------------------------------------------------------------------------------------- boxes


def boxes_of(problem, width, count, seed):
    """Boxes of sizes about the problem's own design, and one design of each."""
    rng, sizes, inside = np.random.default_rng(seed), {}, {}
    free = [name for name, value in problem.design.sizes.items() if value[0] and name in ("size", "offset")]
    for name, value in problem.design.sizes.items():
        middle = value[0] + (0.2 * value[0] * rng.uniform(-1.0, 1.0, count) if name in free else np.zeros(count))
        half = width * np.abs(middle) * rng.uniform(0.2, 1.0, count) if name in free else np.zeros(count)
        sizes[name], inside[name] = Interval(middle - half, middle + half), middle
    return replace(problem.design, **sizes), replace(problem.design, **inside), free


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("contact", ["roller", "offset-roller", "spherical", "groove"])
def test_the_range_over_a_box_holds_every_design_of_it(contact):
    problem = resolve(scene_of(contact))
    for name, mean in means_of(problem).items():
        if isinstance(mean.curves[0][0], MotionDerivative):
            continue
        spans = []
        for width in (0.08, 0.02, 0.005):
            box, inside, free = boxes_of(problem, width, 5, 3)
            found, rng = enclose_mean_of_curve_power(problem, mean, box, inside, free), np.random.default_rng(5)
            for _ in range(4):
                sizes = {n: s.low + (s.high - s.low) * rng.uniform(size=5) for n, s in box.sizes.items()}
                case = EvaluationBlock(problem.setup, problem.programme, replace(problem.design, **sizes))
                value = power_means(case, mean).value
                assert np.all((found.value.low <= value) & (value <= found.value.high)), name
            spans.append((found.value.high - found.value.low).mean())
        assert spans[0] > 3.0 * spans[1] > 9.0 * spans[2]  # in proportion to the box, or faster


def test_of_designs_that_may_jam_nothing_is_known():
    scene = scene_of("roller").replace(**{"follower.dynamics.friction": 1.6})
    problem = resolve(scene)
    least, most = (
        evaluate(scene.replace(**{"cam.base_radius": radius, "outputs": ["jamming_margin", "torque_rms_N_m"]}))
        for radius in (40.0, 90.0)
    )
    assert least["jamming_margin"] < 0.0 < most["jamming_margin"]
    assert least["torque_rms_N_m"] == inf > most["torque_rms_N_m"]
    mean = means_of(problem)["torque_rms_N_m"]
    box = {name: Interval(value, value) for name, value in problem.design.sizes.items()}
    box["size"] = Interval(np.array([40.0]), np.array([90.0]))
    inside = replace(problem.design, size=np.array([90.0]))
    found = enclose_mean_of_curve_power(problem, mean, replace(problem.design, **box), inside, ["size"])
    assert found.value.high[0] == inf


@pytest.mark.slow
def test_the_smallest_cam_under_a_limit_on_a_mean_is_proved_and_has_a_price():
    """Against a root of evaluations, as the torque falls while the cam grows."""
    scene, bound = scene_of("roller").replace(outputs=["torque_rms_N_m"]), 4.705

    def torque(radius):
        return evaluate(scene.replace(**{"cam.base_radius": radius}))["torque_rms_N_m"]

    least = brentq(lambda radius: torque(radius) - bound, 60.0, 75.0, xtol=1e-9)
    asked = scene.replace(**{"cam.base_radius": None, "limits": {"torque_rms_N_m": bound}, "outputs": ["sizes"]})
    found = optimise(asked.replace(search={"base_radius": {"start": 60, "stop": 80, "step": 1}}), seconds=LONG)
    row = found.by_law["poly345"]
    assert row["proved"]
    assert row["base_radius_mm"] == pytest.approx(least, rel=1e-7)
    (price,) = (each for each in prices(found)["poly345"] if each.key == "limits.torque_rms_N_m")
    slope = (torque(least + 0.01) - torque(least - 0.01)) / 0.02
    assert price.price == pytest.approx(1.0 / slope, rel=1e-5)


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("key", "ends", "name"),
    [
        ("follower.dynamics.spring_rate", (1, 20), "torque_rms_N_m"),
        ("follower.dynamics.damping", (0.01, 0.1), "torque_mean_N_m"),
        ("cam.rpm", (200, 900), "jerk_rms_m_s3"),
    ],
)
def test_a_free_number_takes_a_value_that_its_mean_allows_if_there_is_one(key, ends, name):
    """The torque and the jerk are known at both ends of the range, and least at, or near, one value."""
    least = Scene.from_dict(cam_with("roller", "poly345", FREE, outputs=[name]))
    values = [evaluate(least.replace(**{key: float(value)}))[name] for value in np.linspace(*ends, 39)]
    free = {f"search.{key}": dict(zip(("start", "stop"), ends, strict=True))}
    searched = least.replace(**free, **{"search.base_radius": {"start": 30, "stop": 120}})
    found = optimise(searched.replace(limits={name: min(values) * 1.02, "pressure_angle": 26}), seconds=LONG).best
    assert found["proved"]
    assert evaluate(found.scene)[name] <= min(values) * 1.02
    assert set(certify(found.scene).values()) == {"held"}
    assert (
        optimise(searched.replace(limits={name: min(values) * 0.98, "pressure_angle": 26}), seconds=LONG).best
        is None
    )


def test_every_mean_is_bounded_from_the_side_that_its_list_says():
    for contact in CONTACTS:
        for name, mean in means_of(resolve(scene_of(contact))).items():
            least = QUANTITIES[name].relation_to_limit == AT_LEAST
            assert not mean.scale.is_decreasing or least
