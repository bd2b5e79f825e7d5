"""The force along the follower's motion: contact force, springs, and the speed at which contact is lost.

    F = m·ω²·y'' + c·ω·y' + k·y + F₀ + F_ext            contact is lost where F < 0

It is linear in the motion, and F_ext constant or straight between corners (``motion.load``), or S + ω²·I of what
comes through a train (``motion.load``), so that its extremes over the turn are those of a polynomial on each
panel: exact, and the same for all designs of a programme. For an oscillating follower F is the moment about the
pivot, and forces are those at the trace point, F/l. The jump speed is the ω up to which F is nowhere below 0, to
1e-14 of its largest value: a follower that nothing preloads rests on its cam without force, which is no loss of
contact.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 8 and 9.
"""

from collections.abc import Callable, Sequence
from functools import partial
from math import inf, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LEAST, FloatArray
from camopt.core.numerics.curves import Linear, curve_type
from camopt.core.numerics.extremes import Precision, extremes
from camopt.core.numerics.piecewise import carried_series, load_series
from camopt.core.numerics.state import TrainForces
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.effect_numbers import FollowerDynamics
from camopt.model.effects.necessary_conditions import LeastForce, NecessaryConditions
from camopt.model.effects.panel_series import displacement_derivative, sum_series
from camopt.model.effects.peak import Peak, jumps_at_corners
from camopt.model.effects.setting_cache import once_per_setting
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.load import TrainLoad
from camopt.model.motion.programme import Programme, derivative_peak, weighted_range
from camopt.model.motion.stroke import ALL_STROKES

CONTACT_FORCES = ("contact_force_min_N", "contact_force_max_N")
STIFFEST_RATIO = 1e12  # times the force over the lift: a spring that no stiffer one betters
INERTIA_SPEED = 1e9  # rad/s: a speed at which the inertia alone decides where F is least
ROOT_TOLERANCE = (
    1e-8  # relative: nearer than this to a root, its cam angle is not exact enough, and F itself tells more
)
FORCE_ERROR = 1e-14  # of the largest force: less below 0 is rounding


@curve_type(loaded=True)
def changing_force(at, steady, share):
    """F with an external load that changes over the turn: ``steady``, all other forces, plus share·load."""
    return steady + share * at.load.value


@curve_type(loaded=True)
def train_force(at, steady, share, carried):
    """F with what a train brings to the follower: share·S + carried·I."""
    return steady + share * at.load.value + carried * at.load.carried


def offers(setup: Setup) -> tuple[str, ...]:
    """Nothing of a follower with two contacts: what keeps these is their preload (``effects.preload``)."""
    if setup.mechanism.further_contacts:
        return ()
    force = "N_m" if setup.angular else "N"
    rate = "N_m_per_rad" if setup.angular else "N_per_mm"
    names = (f"preload_required_{force}", f"spring_rate_required_{rate}", "jump_speed_rpm", "jump_speed_ratio")
    flat_swing = setup.angular and setup.mechanism.flat_faced  # its lever changes over the turn
    return names if flat_swing else (*CONTACT_FORCES, *names)


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
    keys = missing_force_keys(setup)
    mass = tuple(key for key in keys if key != "cam.rpm")
    wanted = {name: mass if name == "jump_speed_rpm" else keys for name in offers(setup)}
    return {name: keys for name, keys in wanted.items() if keys}


def missing_force_keys(setup: Setup) -> tuple[str, ...]:
    """The keys that a force needs and the scene lacks."""
    speed = () if setup.omega is not None else ("cam.rpm",)
    mass = "follower.dynamics.inertia" if setup.angular else "follower.dynamics.mass"
    return (*speed, *(() if setup.dynamics.mass is not None else (mass,)))


def force_weights(dynamics: FollowerDynamics, omega: Any) -> tuple[Any, Any, Any, Any]:
    """Factors of y, y' and y'', and the constant: they give N from mm by rad (N·mm from rad by rad).

    A load that changes over the turn comes on top, from the programme.
    """
    assert dynamics.mass is not None
    constant = dynamics.preload + dynamics.load
    return dynamics.stiffness, dynamics.damping * omega, dynamics.mass * omega**2, constant


def force_factors(dynamics: FollowerDynamics, omega: Any) -> tuple[Any, ...]:
    """As ``force_weights``, with the factor ω² of the inertia of what a train carries."""
    return *force_weights(dynamics, omega), omega**2


def force_series(programme: Programme, factors: Sequence[Any]) -> FloatArray:
    """F on the panels, N (N·mm), from its factors (``force_factors``), (settings,): (powers, settings, panels)."""
    table = programme.table
    *moved, constant, carried = (np.reshape(factor, (-1, 1)) for factor in factors)
    terms = [factor * displacement_derivative(table, order)[:, None] for order, factor in enumerate(moved)]
    along = sum_series(*terms, load_series(table)[:, None], carried * carried_series(table)[:, None])
    along[0] += constant
    return along


def force_span(programme: Programme, dynamics: FollowerDynamics, omega: float) -> tuple[float, float]:
    """Least and largest F over the turn; infinite both ways where the velocity jumps."""
    if programme.corners:
        return -inf, inf
    *factors, constant = force_weights(dynamics, omega)
    least, largest = weighted_range(programme, tuple(factors), ALL_STROKES, 1.0, omega**2)
    return least + constant, largest + constant


class ForceExtremes(NamedTuple):
    """The least and the largest F over a turn, N (N·mm), (settings,), and the motion next to where it is least."""

    least: FloatArray
    largest: FloatArray
    y: FloatArray
    y1: FloatArray
    y2: FloatArray
    load: FloatArray
    """The external load there, if it changes over the turn; else 0."""
    carried: FloatArray
    """The inertia there of what a train carries, by ω²; else 0."""

    @property
    def is_in_contact(self) -> Any:
        """Whether such forces keep contact: less below 0 is rounding."""
        return self.least >= -FORCE_ERROR * np.maximum(-self.least, self.largest)


def force_extremes(programme: Programme, *factors: FloatArray) -> ForceExtremes:
    """F with these factors (``force_factors``), (settings,), over a turn without corners."""
    count, (*steady, carried) = len(factors[0]), factors
    made = add_load(Linear(*steady), np.ones(count), carried, programme)
    questions = [(ALL_STROKES, goal) for goal in (LEAST, LARGEST)]
    found = extremes(made, count, programme.table, questions, Precision(FORCE_ERROR, inf))
    at = programme.state(programme.one_sided_angles(found.where[0], ALL_STROKES))
    load = (at.load.value if at.load else 0.0, at.load.carried if isinstance(at.load, TrainForces) else 0.0)
    sides = np.array([*at[:3], *(each + np.zeros_like(at.y) for each in load)])
    force = factors[0] * sides[0] + factors[1] * sides[1] + factors[2] * sides[2] + sides[3] + carried * sides[4]
    return ForceExtremes(*found.value, *sides[:, np.argmin(force, axis=0), np.arange(count)])


@once_per_setting
def jump_speed(programme: Programme, *factors: FloatArray) -> FloatArray:
    """The largest ω up to which contact is kept, rad/s; 0 if there is none at rest. The factors are of F at ω = 1.

    No jump speed is above that at which F reaches 0 at any one cam angle: the angle where F is least at one such
    speed gives the next, until F is kept. With damping, contact may be lost, won and lost again as ω grows: then ω
    goes up in steps over which it is proved to be kept (``_is_kept_between``), halved where it is not, doubled
    else.
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
    open_ = np.flatnonzero(top > kept)
    while open_.size:
        some = [each[open_] for each in factors]
        low, high = kept[open_], np.minimum(kept + step, top)[open_]
        here = force_extremes(programme, some[0], some[1] * high, some[2] * high**2, some[3], some[4] * high**2)
        sure = here.is_in_contact & _is_kept_between(programme, some, low, high)
        lower = _lift_off_speed(here, some)
        with np.errstate(all="ignore"):
            nearer = high - here.least / (some[1] * here.y1 + 2.0 * _inertia_factor(here, some) * high)
        lower = np.where(lower < (1.0 - ROOT_TOLERANCE) * high, lower, np.minimum(nearer, np.nextafter(high, 0.0)))
        top[open_] = np.where(here.is_in_contact, top[open_], lower)
        kept[open_] = np.where(sure, high, low)
        step[open_] = np.where(
            sure, 2.0 * step[open_], np.where(here.is_in_contact, 0.5 * (high - low), step[open_])
        )
        open_ = open_[np.minimum(kept + step, top)[open_] > kept[open_]]
    return kept


def _is_kept_between(programme: Programme, factors: Sequence[FloatArray], low: FloatArray, high: FloatArray) -> Any:
    """Whether F ≥ 0 over the turn is sure at all speeds between two at which it is.

    At a cam angle where the inertia pulls, F is concave in ω: so it is sure. Elsewhere F is at least what it is
    with the inertia at the lower speed, which is linear in ω, and at that speed F itself.
    """
    stiffness, damping, mass, constant, carried = factors
    sure = damping == 0.0
    if not sure.all():
        sure |= force_extremes(
            programme, stiffness, damping * high, mass * low**2, constant, carried * low**2
        ).is_in_contact
    return sure


def _inertia_factor(here: ForceExtremes, factors: Sequence[FloatArray]) -> FloatArray:
    """The force of inertia by ω²."""
    _, _, mass, _, carried = factors
    return mass * here.y2 + carried * here.carried


def _lift_off_speed(here: ForceExtremes, factors: Sequence[FloatArray]) -> FloatArray:
    """The least ω at which F falls to 0, at cam angles where at rest it is not below; or infinite."""
    stiffness, damping, _, constant, _ = factors
    rest = np.maximum(stiffness * here.y + constant + here.load, 0.0)
    slope, bend = damping * here.y1, _inertia_factor(here, factors)
    with np.errstate(all="ignore"):
        root = np.sqrt(slope**2 - 4.0 * rest * bend)  # not a number where F stays above 0
        first = np.where(slope > 0.0, (slope + root) / (-2.0 * bend), 2.0 * rest / (root - slope))
    falls = (bend < 0.0) | ((slope < 0.0) & (root >= 0.0))
    return np.asarray(np.where(falls, first, inf))


@once_per_setting
def required_stiffness(programme: Programme, *others: FloatArray) -> FloatArray:
    """The least spring rate that keeps contact with the other factors of F; infinite if none does.

    Where F is least with one rate, the next is what makes it 0 there: none that is smaller is enough.
    """
    damping, mass, constant, carried = others
    needed, open_ = np.zeros_like(mass), np.arange(mass.size)
    if programme.corners:
        return needed + inf
    bare = force_extremes(programme, needed, damping, mass, constant, carried)
    stiffest = STIFFEST_RATIO * np.maximum(np.abs(bare.least), np.abs(bare.largest)) / programme.lift
    while open_.size:
        some = [each[open_] for each in (needed, damping, mass, constant, carried)]
        here = force_extremes(programme, *some)
        rest = some[1] * here.y1 + _inertia_factor(here, some) + some[3] + here.load
        with np.errstate(all="ignore"):
            enough = np.where(here.y > 0.0, -rest / here.y, inf)
            enough = np.where(enough > (1.0 + ROOT_TOLERANCE) * some[0], enough, some[0] - here.least / here.y)
        lost = ~here.is_in_contact
        open_ = open_[lost]
        needed[open_] = np.maximum(enough[lost], np.nextafter(some[0][lost], inf))
        needed[needed > stiffest] = inf
        open_ = open_[needed[open_] < inf]
    return needed


def peaks(setup: Setup) -> dict[str, Peak]:
    """The extremes of F as peaks of a curve."""
    if setup.omega is None or CONTACT_FORCES[0] not in offers(setup):
        return {}
    along = ((partial(force_curve, setup), ALL_STROKES),)
    return {
        name: Peak(along, goal, jumps=jumps_at_corners)
        for name, goal in zip(CONTACT_FORCES, (LEAST, LARGEST), strict=True)
    }


def force_curve(setup: Setup, designs: Designs, programme: Programme) -> Any:
    """F, N; F/l of an oscillating follower with a trace point, the moment (N·mm) of an oscillating flat face.

    At a contact whose own motion is that of the follower reversed, −F.
    """
    lever = designs.arm_length if setup.angular and setup.mechanism.curvature else np.ones(len(designs))
    own = setup.with_design_numbers(designs)
    return build_force_curve(own, own.omega, setup.mechanism.way * lever, programme)


def force_at_speed(setup: Setup, designs: Designs, programme: Programme, speed: Callable[[Setup], Any]) -> Any:
    """F at a speed, rad/s, which may depend on the designs' own numbers, N (N·mm)."""
    own = setup.with_design_numbers(designs)
    return build_force_curve(own, speed(own), np.ones(len(designs)), programme)


def run(case: EvaluationBlock, wanted: frozenset[str]) -> dict[str, Any]:
    setup, programme, own = case.setup, case.programme, case.setup_per_design
    columns: dict[str, Any] = {}
    if wanted & {"jump_speed_rpm", "jump_speed_ratio"}:
        jump = jump_speed(programme, *force_factors(own.dynamics, 1.0))
        columns["jump_speed_rpm"] = jump * 30.0 / pi
        columns |= {} if setup.omega is None else {"jump_speed_ratio": jump / own.omega}
    if setup.omega is None:
        return columns
    force = contact_force_bounds(case)
    if CONTACT_FORCES[0] in offers(setup):
        lever = case.designs.arm_length if setup.angular else 1.0
        columns |= {name: divide_by_lever(end, lever) for name, end in zip(CONTACT_FORCES, force, strict=True)}
    per_length, per_rate = ("N_m", "N_m_per_rad") if setup.angular else ("N", "N_per_mm")
    unit = 1e-3 if setup.angular else 1.0
    columns[f"preload_required_{per_length}"] = _required_preload(own.dynamics.preload, force[0], unit)
    if f"spring_rate_required_{per_rate}" in wanted:
        _, *others = force_factors(own.dynamics, own.omega)
        columns[f"spring_rate_required_{per_rate}"] = required_stiffness(programme, *others) * unit
    return columns


def _shared_extremes(programme: Programme, dynamics: FollowerDynamics, omega: float) -> tuple[Any, Any]:
    """The extremes of F over the turn, Bounded unless infinite: the sum of its terms is rounded as the largest."""
    least, largest = force_span(programme, dynamics, omega)
    if programme.corners:
        return least, largest
    *moved, constant = force_weights(dynamics, omega)
    terms = [abs(factor) * derivative_peak(programme, order, ALL_STROKES) for order, factor in enumerate(moved)]
    scale = max(abs(least), abs(largest))
    rounding = FORCE_ERROR * (sum(terms, abs(constant)) + scale)  # what a load adds is in the force
    return EnclosedValue(least, -rounding, scale), EnclosedValue(largest, rounding, scale)


def contact_force_bounds(case: EvaluationBlock) -> tuple[Any, Any]:
    """The extremes of F over the turn, N (N·mm); of designs without numbers of their own one for all."""
    if not case.designs.numbers:
        return _shared_extremes(case.programme, case.setup.dynamics, case.setup.omega)
    goals, count = (LEAST, LARGEST), len(case.designs)
    if case.programme.corners:
        return np.full(count, -inf), np.full(count, inf)
    found = case.extremes(partial(follower_force_curve, case.setup), [(ALL_STROKES, goal) for goal in goals])
    scale, outward = np.abs(found.value).max(axis=0), (-found.width[0], found.width[1])
    least, largest = (EnclosedValue(value, by, scale) for value, by in zip(found.value, outward, strict=True))
    return least, largest


def keeps_contact(case: EvaluationBlock) -> Any:
    """Whether the bodies stay in contact over the whole turn.

    An open cam and one of two contacts bear F/2 + max(|F|/2, P) > 0 as long as F > −2·P (``effects.preload``); that
    one of two which never touches loses no contact.
    """
    mechanism, preload = case.setup.mechanism, case.setup_per_design.dynamics.pair_preload
    lets_go = -2.0 * (0.0 if preload is None else preload)
    least, largest = map(_outer_value, contact_force_bounds(case))
    if mechanism.way < 0.0:
        least, largest = -largest, -least
    kept = np.asarray(least > lets_go)
    return kept | (largest <= lets_go) if "interference" in mechanism.drive.keys else kept


def _outer_value(extreme: Any) -> Any:
    """An extreme with its rounding."""
    return extreme.value + extreme.outward if isinstance(extreme, EnclosedValue) else extreme


def follower_force_curve(setup: Setup, designs: Designs, programme: Programme) -> Any:
    """F, N (N·mm), of designs with numbers of their own."""
    return force_at_speed(setup, designs, programme, lambda own: own.omega)


def build_force_curve(setup: Setup, omega: Any, lever: Any, programme: Programme) -> Any:
    """F at a speed, rad/s, over a length, N (N·mm), as a curve."""
    assert omega is not None
    steady = Linear(*(weight / lever for weight in force_weights(setup.dynamics, omega)))
    return add_load(steady, 1.0 / lever, omega**2 / lever, programme)


def add_load(steady: Linear, share: Any, carried: Any, programme: Programme) -> Any:
    """A force, with a share of the load if it changes over the turn, and one of the inertia through a train."""
    if isinstance(programme.load, TrainLoad):
        return train_force(steady, share, carried)
    return steady if programme.load is None else changing_force(steady, share)


def divide_by_lever(force: Any, lever: Any) -> Any:
    """The force at the end of a lever that gives a moment."""
    return EnclosedValue(*(part / lever for part in force)) if isinstance(force, EnclosedValue) else force / lever


def _required_preload(preload: Any, least: Any, unit: float) -> Any:
    """The least preload that keeps contact; what rounding alone makes of it is 0."""
    if not isinstance(least, EnclosedValue):
        return np.maximum(preload - least, 0.0) * unit
    required, far = (np.maximum(preload - each, 0.0) for each in (least.value, least.value + least.outward))
    required = np.where(required > FORCE_ERROR * least.scale, required, 0.0)
    return EnclosedValue(required * unit, (far - required) * unit, np.maximum(required, least.scale) * unit)


def implies(setup: Setup, name: str, bound: float) -> NecessaryConditions:
    """The contact force: up to its jump speed a cam keeps contact."""
    if name == "jump_speed_rpm":
        return NecessaryConditions(force=LeastForce(bound * pi / 30, 0.0))
    if name == "jump_speed_ratio" and setup.omega is not None:
        return NecessaryConditions(force=LeastForce(bound * setup.omega, 0.0))
    if name == "contact_force_min_N" and setup.omega is not None:
        return NecessaryConditions(force=LeastForce(setup.omega, bound))
    return NecessaryConditions()


EFFECT = Effect("force", offers, run, lacks, is_of_motion=lambda setup: True, peaks=peaks, implies=implies)
