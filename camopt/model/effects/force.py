"""The force along the follower's motion: contact force, required springs, and the speed at which contact is lost.

    F = m·ω²·y'' + c·ω·y' + k·y + F₀ + F_ext            contact is lost where F < 0

F is linear in the motion. F_ext is constant, or linear between corners, or the load S + ω²·I of a train
(``motion.load``). So F is a polynomial on each panel; its extremes are exact, and the same for all designs of a
programme. For an oscillating follower F is the moment about the pivot, and forces are those at the trace point,
F/l.

The jump speed is the largest ω at which F is nowhere below 0, to 1e-14 of its largest value. A follower without a
preload rests on its cam without force; this is no loss of contact.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 8 and 9.
"""

from collections.abc import Callable, Sequence
from functools import partial
from math import inf, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LEAST, Curve, FloatArray
from camopt.core.numerics.curves import Linear, curve_type_from_formula
from camopt.core.numerics.extremes import Precision, extremes_of_curve
from camopt.core.numerics.panel_series import derivative_polynomials_by_panel, sum_series
from camopt.core.numerics.piecewise import external_load_polynomials_by_panel, train_inertia_polynomials_by_panel
from camopt.core.numerics.state import TrainForces
from camopt.model.effects.effect import (
    Effect,
    EnclosedValue,
    EvaluationBlock,
    LeastForce,
    NecessaryConditions,
    Setup,
)
from camopt.model.effects.effect_numbers import FollowerDynamics
from camopt.model.effects.peak import Peak, is_infinite_by_velocity_jumps
from camopt.model.effects.setting_cache import once_per_setting
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.load import TrainLoad
from camopt.model.motion.programme import Programme, derivative_peak, weighted_derivative_range
from camopt.model.motion.stroke import ALL_STROKES

CONTACT_FORCES = ("contact_force_min_N", "contact_force_max_N")
STIFFEST_RATIO = 1e12  # times the force over the lift: no stiffer spring helps
INERTIA_SPEED = 1e9  # rad/s: at this speed only the inertia decides where F is least
ROOT_TOLERANCE = 1e-8  # relative: this near to a root its cam angle is too inexact, and F itself is used
FORCE_ERROR = 1e-14  # of the largest force: a force below 0 by less is rounding


@curve_type_from_formula(reads_load=True)
def force_with_changing_load(state, steady_force, load_share):
    """F with an external load that changes over the turn: all other forces, ``steady_force``, plus share·load."""
    return steady_force + load_share * state.load.value


@curve_type_from_formula(reads_load=True)
def force_with_train_load(state, steady_force, load_share, inertia_factor):
    """F with the load of a train: ``steady_force`` plus share·S + carried·I."""
    return steady_force + load_share * state.load.value + inertia_factor * state.load.carried


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    """Nothing for a follower with two contacts, which a preload keeps in contact (``effects.preload``)."""
    if setup.mechanism.further_contacts:
        return ()
    force = "N_m" if setup.angular else "N"
    rate = "N_m_per_rad" if setup.angular else "N_per_mm"
    names = (f"preload_required_{force}", f"spring_rate_required_{rate}", "jump_speed_rpm", "jump_speed_ratio")
    flat_swing = setup.angular and setup.mechanism.flat_faced  # its lever changes over the turn
    return names if flat_swing else (*CONTACT_FORCES, *names)


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    keys = missing_force_keys(setup)
    mass = tuple(key for key in keys if key != "cam.rpm")
    wanted = {name: mass if name == "jump_speed_rpm" else keys for name in applicable_quantities(setup)}
    return {name: keys for name, keys in wanted.items() if keys}


def missing_force_keys(setup: Setup) -> tuple[str, ...]:
    """The keys that a force needs and the scene lacks."""
    speed = () if setup.omega is not None else ("cam.rpm",)
    mass = "follower.dynamics.inertia" if setup.angular else "follower.dynamics.mass"
    return (*speed, *(() if setup.dynamics.mass is not None else (mass,)))


def force_weights_and_constant(dynamics: FollowerDynamics, omega: Any) -> tuple[Any, Any, Any, Any]:
    """The factors of y, y' and y'' in F, and its constant [N and mm per radⁿ; oscillating, N·mm and rad per radⁿ].

    A load that changes over the turn is not in them; the programme adds it.
    """
    return dynamics.stiffness, dynamics.damping * omega, dynamics.mass * omega**2, dynamics.preload + dynamics.load


def force_factors_with_train(dynamics: FollowerDynamics, omega: Any) -> tuple[Any, ...]:
    """The factors of ``force_weights_and_constant``, and the factor ω² of a train's inertia."""
    return *force_weights_and_constant(dynamics, omega), omega**2


def force_polynomials_by_panel(programme: Programme, factors: Sequence[Any]) -> FloatArray:
    """F on the panels (powers, settings, panels) [N or N·mm], from ``force_factors_with_train``, (settings,)."""
    table = programme.table
    *weights, constant, carried = (np.reshape(factor, (-1, 1)) for factor in factors)
    terms = [
        factor * derivative_polynomials_by_panel(table, order)[:, None] for order, factor in enumerate(weights)
    ]
    series = sum_series(
        *terms,
        external_load_polynomials_by_panel(table)[:, None],
        carried * train_inertia_polynomials_by_panel(table)[:, None],
    )
    series[0] += constant
    return series


class ForceExtremes(NamedTuple):
    """Least and largest F over a turn [N or N·mm], (settings,), and the motion at the least F."""

    least: FloatArray
    largest: FloatArray
    y: FloatArray
    y1: FloatArray
    y2: FloatArray
    load: FloatArray
    """The external load at the least F if it changes over the turn; else 0."""
    carried: FloatArray
    """The inertia of a train at the least F, over ω²; 0 without a train."""

    @property
    def is_in_contact(self) -> Any:
        """Whether the least force keeps contact, up to rounding."""
        return self.least >= -FORCE_ERROR * np.maximum(-self.least, self.largest)


def force_extremes(programme: Programme, *factors: FloatArray) -> ForceExtremes:
    """Extremes of F from its factors (``force_factors_with_train``), (settings,), over a turn without corners."""
    count, (*steady, carried) = len(factors[0]), factors
    curve = add_changing_load_and_train_inertia(Linear(*steady), np.ones(count), carried, programme)
    questions = [(ALL_STROKES, goal) for goal in (LEAST, LARGEST)]
    ends = extremes_of_curve(curve, count, programme.table, questions, Precision(FORCE_ERROR, inf))
    at = programme.state(programme.one_sided_angles(ends.where[0], ALL_STROKES))
    load = (at.load.value if at.load else 0.0, at.load.carried if isinstance(at.load, TrainForces) else 0.0)
    sides = np.array([*at[:3], *(each + np.zeros_like(at.y) for each in load)])
    force = factors[0] * sides[0] + factors[1] * sides[1] + factors[2] * sides[2] + sides[3] + carried * sides[4]
    return ForceExtremes(*ends.value, *sides[:, np.argmin(force, axis=0), np.arange(count)])


@once_per_setting
def jump_speed(programme: Programme, *factors: FloatArray) -> FloatArray:
    """Largest speed ω up to which contact is kept [rad/s], from the factors of F at ω = 1.

    It is 0 without contact at rest.

    At any one cam angle F reaches 0 at some speed, and the jump speed is at most that. The angle where F is least
    at this speed gives the next, lower speed, until contact is kept. With damping, contact may be lost, regained
    and lost again as ω grows. So ω rises in steps over which contact is proved
    (``_is_contact_proved_between_speeds``): a step without a proof is halved, one with a proof doubles the next.
    """
    stiffness, _, mass, constant, carried = factors
    none = np.zeros_like(mass)
    kept, step, top = none.copy(), np.full_like(mass, inf), none.copy()
    if programme.corners:
        return kept
    rest = force_extremes(programme, stiffness, none, none, constant, none)
    fast = force_extremes(programme, stiffness, none, mass * INERTIA_SPEED**2, constant, carried * INERTIA_SPEED**2)
    presses = rest.is_in_contact & (rest.largest > 0.0)
    top[presses] = _lift_off_speed(fast, factors)[presses]
    kept[top == inf] = inf
    pending = np.flatnonzero(top > kept)
    while pending.size:
        part = [factor[pending] for factor in factors]
        low, high = kept[pending], np.minimum(kept + step, top)[pending]
        here = force_extremes(programme, part[0], part[1] * high, part[2] * high**2, part[3], part[4] * high**2)
        proved = here.is_in_contact & _is_contact_proved_between_speeds(programme, part, low, high)
        lower = _lift_off_speed(here, part)
        with np.errstate(all="ignore"):
            nearer = high - here.least / (
                part[1] * here.y1 + 2.0 * _inertia_force_per_squared_speed(here, part) * high
            )
        lower = np.where(lower < (1.0 - ROOT_TOLERANCE) * high, lower, np.minimum(nearer, np.nextafter(high, 0.0)))
        top[pending] = np.where(here.is_in_contact, top[pending], lower)
        kept[pending] = np.where(proved, high, low)
        step[pending] = np.where(
            proved, 2.0 * step[pending], np.where(here.is_in_contact, 0.5 * (high - low), step[pending])
        )
        pending = pending[np.minimum(kept + step, top)[pending] > kept[pending]]
    return kept


def _is_contact_proved_between_speeds(
    programme: Programme, factors: Sequence[FloatArray], low: FloatArray, high: FloatArray
) -> Any:
    """Whether contact is proved at all speeds between two at which it is kept.

    At a cam angle where the inertia pulls the follower off, F is concave in ω, and so F ≥ 0 in between. Elsewhere F
    is at least its value with the inertia at the lower speed, which is linear in ω.
    """
    stiffness, damping, mass, constant, carried = factors
    proved = damping == 0.0
    if not proved.all():
        proved |= force_extremes(
            programme, stiffness, damping * high, mass * low**2, constant, carried * low**2
        ).is_in_contact
    return proved


def _inertia_force_per_squared_speed(extremes: ForceExtremes, factors: Sequence[FloatArray]) -> FloatArray:
    """Force of inertia over ω²."""
    _, _, mass, _, carried = factors
    return mass * extremes.y2 + carried * extremes.carried


def _lift_off_speed(extremes: ForceExtremes, factors: Sequence[FloatArray]) -> FloatArray:
    """Least speed ω at which F falls to 0 at the cam angles of ``extremes`` [rad/s]; infinite if it never does.

    At rest F is not below 0 there.
    """
    stiffness, damping, _, constant, _ = factors
    rest = np.maximum(stiffness * extremes.y + constant + extremes.load, 0.0)
    slope, bend = damping * extremes.y1, _inertia_force_per_squared_speed(extremes, factors)
    with np.errstate(all="ignore"):
        root = np.sqrt(slope**2 - 4.0 * rest * bend)  # nan where F stays above 0
        first = np.where(slope > 0.0, (slope + root) / (-2.0 * bend), 2.0 * rest / (root - slope))
    falls = (bend < 0.0) | ((slope < 0.0) & (root >= 0.0))
    return np.asarray(np.where(falls, first, inf))


@once_per_setting
def required_spring_rate(programme: Programme, *other_factors: FloatArray) -> FloatArray:
    """Least spring rate that keeps contact with the other factors of F; infinite if none does.

    Where F is least with one rate, the next rate makes it 0; no smaller one suffices.
    """
    damping, mass, constant, carried = other_factors
    needed, pending = np.zeros_like(mass), np.arange(mass.size)
    if programme.corners:
        return needed + inf
    bare = force_extremes(programme, needed, damping, mass, constant, carried)
    stiffest = STIFFEST_RATIO * np.maximum(np.abs(bare.least), np.abs(bare.largest)) / programme.lift
    while pending.size:
        part = [factor[pending] for factor in (needed, damping, mass, constant, carried)]
        here = force_extremes(programme, *part)
        rest = part[1] * here.y1 + _inertia_force_per_squared_speed(here, part) + part[3] + here.load
        with np.errstate(all="ignore"):
            enough = np.where(here.y > 0.0, -rest / here.y, inf)
            enough = np.where(enough > (1.0 + ROOT_TOLERANCE) * part[0], enough, part[0] - here.least / here.y)
        lost = ~here.is_in_contact
        pending = pending[lost]
        needed[pending] = np.maximum(enough[lost], np.nextafter(part[0][lost], inf))
        needed[needed > stiffest] = inf
        pending = pending[needed[pending] < inf]
    return needed


def peaks(setup: Setup) -> dict[str, Peak]:
    if setup.omega is None or CONTACT_FORCES[0] not in applicable_quantities(setup):
        return {}
    curves = ((partial(contact_force_curve, setup), ALL_STROKES),)
    return {
        name: Peak(curves, goal, jumps=is_infinite_by_velocity_jumps)
        for name, goal in zip(CONTACT_FORCES, (LEAST, LARGEST), strict=True)
    }


def contact_force_curve(setup: Setup, designs: Designs, programme: Programme) -> Curve:
    """Curve of F at the contact: F [N], F/l of an arm [N], or the moment on an oscillating flat face [N·mm].

    At a contact on the other side of the follower it is −F.
    """
    lever = designs.arm_length if setup.angular and setup.mechanism.curvature else np.ones(len(designs))
    numbers = setup.with_design_numbers(designs)
    return force_over_lever_curve(numbers, numbers.omega, setup.mechanism.way * lever, programme)


def force_curve_at_speed(
    setup: Setup, designs: Designs, programme: Programme, speed: Callable[[Setup], Any]
) -> Any:
    """Curve of F [N or N·mm] at a speed [rad/s], which may depend on the numbers of the designs."""
    numbers = setup.with_design_numbers(designs)
    return force_over_lever_curve(numbers, speed(numbers), np.ones(len(designs)), programme)


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    setup, programme, numbers = case.setup, case.programme, case.setup_per_design
    columns: dict[str, Any] = {}
    if wanted_quantities & {"jump_speed_rpm", "jump_speed_ratio"}:
        jump = jump_speed(programme, *force_factors_with_train(numbers.dynamics, 1.0))
        columns["jump_speed_rpm"] = jump * 30.0 / pi
        columns |= {} if setup.omega is None else {"jump_speed_ratio": jump / numbers.omega}
    if setup.omega is None:
        return columns
    force = least_and_largest_contact_force(case)
    if CONTACT_FORCES[0] in applicable_quantities(setup):
        lever = case.designs.arm_length if setup.angular else 1.0
        columns |= {name: divide_by_lever(end, lever) for name, end in zip(CONTACT_FORCES, force, strict=True)}
    per_length, per_rate = ("N_m", "N_m_per_rad") if setup.angular else ("N", "N_per_mm")
    unit = 1e-3 if setup.angular else 1.0
    columns[f"preload_required_{per_length}"] = _required_preload(numbers.dynamics.preload, force[0], unit)
    if f"spring_rate_required_{per_rate}" in wanted_quantities:
        _, *others = force_factors_with_train(numbers.dynamics, numbers.omega)
        columns[f"spring_rate_required_{per_rate}"] = required_spring_rate(programme, *others) * unit
    return columns


def least_and_largest_contact_force(case: EvaluationBlock) -> tuple[Any, Any]:
    """Extremes of F over the turn [N or N·mm]; one value for all designs if they have no numbers of their own."""
    setup, programme, differ = case.setup, case.programme, bool(case.designs.numbers)
    if programme.corners:
        endless = np.full(len(case.designs), inf) if differ else inf
        return -endless, endless
    if differ:
        ends = case.extremes(partial(follower_force_curve, setup), [(ALL_STROKES, LEAST), (ALL_STROKES, LARGEST)])
        scale = np.abs(ends.value).max(axis=0)
        (least, largest), outward = ends.value, (-ends.width[0], ends.width[1])
    else:
        *weights, constant = force_weights_and_constant(setup.dynamics, setup.omega)
        shared = weighted_derivative_range(programme, tuple(weights), ALL_STROKES, 1.0, setup.omega**2)
        least, largest = (end + constant for end in shared)
        scale = max(abs(least), abs(largest))
        terms = [abs(weight) * derivative_peak(programme, n, ALL_STROKES) for n, weight in enumerate(weights)]
        rounding = FORCE_ERROR * (sum(terms, abs(constant)) + scale)  # the scale includes a changing load
        outward = (-rounding, rounding)
    return EnclosedValue(least, outward[0], scale), EnclosedValue(largest, outward[1], scale)


def contact_kept_and_never_made(case: EvaluationBlock) -> tuple[Any, Any]:
    """Whether the bodies stay in contact over the whole turn, and whether one of two contacts never bears.

    A contact bears F/2 + max(|F|/2, P) > 0 as long as F > −2·P, with P = 0 on an open cam (``effects.preload``).
    """
    mechanism, preload = case.setup.mechanism, case.setup_per_design.dynamics.pair_preload
    loss = -2.0 * (0.0 if preload is None else preload)
    least, largest = (
        end.value + end.outward if isinstance(end, EnclosedValue) else end
        for end in least_and_largest_contact_force(case)
    )
    if mechanism.way < 0.0:
        least, largest = -largest, -least
    one_of_two = mechanism.way < 0.0 or "interference" in mechanism.drive.keys
    return np.asarray(least > loss), one_of_two & np.asarray(largest <= loss)


def follower_force_curve(setup: Setup, designs: Designs, programme: Programme) -> Curve:
    """Curve of F [N or N·mm] at the speed of the cam, with the numbers of the designs."""
    return force_curve_at_speed(setup, designs, programme, lambda numbers: numbers.omega)


def force_over_lever_curve(setup: Setup, omega: Any, lever: Any, programme: Programme) -> Curve:
    """Curve of F at a speed [rad/s], divided by a lever [N or N·mm]."""
    steady = Linear(*(weight / lever for weight in force_weights_and_constant(setup.dynamics, omega)))
    return add_changing_load_and_train_inertia(steady, 1.0 / lever, omega**2 / lever, programme)


def add_changing_load_and_train_inertia(
    steady_force: Linear, load_share: Any, inertia_factor: Any, programme: Programme
) -> Curve:
    """A force plus a share of the load that changes over the turn, and of the inertia of a train."""
    if isinstance(programme.load, TrainLoad):
        return force_with_train_load(steady_force, load_share, inertia_factor)
    return steady_force if programme.load is None else force_with_changing_load(steady_force, load_share)


def divide_by_lever(force: Any, lever: Any) -> Curve:
    """The force at the end of a lever, from its moment."""
    return EnclosedValue(*(part / lever for part in force)) if isinstance(force, EnclosedValue) else force / lever


def _required_preload(preload: Any, least_force: Any, unit_factor: float) -> Any:
    """Least preload that keeps contact; exactly 0 if only rounding makes it positive."""
    if not isinstance(least_force, EnclosedValue):
        return np.maximum(preload - least_force, 0.0) * unit_factor
    required, far = (
        np.maximum(preload - each, 0.0) for each in (least_force.value, least_force.value + least_force.outward)
    )
    required = np.where(required > FORCE_ERROR * least_force.scale, required, 0.0)
    return EnclosedValue(
        required * unit_factor,
        (far - required) * unit_factor,
        np.maximum(required, least_force.scale) * unit_factor,
    )


def necessary_conditions(setup: Setup, quantity_name: str, bound: float) -> NecessaryConditions:
    """The least contact force that a bound requires; up to its jump speed a cam keeps contact."""
    if quantity_name == "jump_speed_rpm":
        return NecessaryConditions(force=LeastForce(bound * pi / 30, 0.0))
    if quantity_name == "jump_speed_ratio" and setup.omega is not None:
        return NecessaryConditions(force=LeastForce(bound * setup.omega, 0.0))
    if quantity_name == "contact_force_min_N" and setup.omega is not None:
        return NecessaryConditions(force=LeastForce(setup.omega, bound))
    return NecessaryConditions()


EFFECT = Effect(
    "force",
    applicable_quantities,
    evaluate_columns,
    missing_keys_by_quantity,
    is_of_motion=lambda setup: True,
    peaks=peaks,
    necessary_conditions=necessary_conditions,
)
