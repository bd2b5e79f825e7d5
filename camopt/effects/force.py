"""The force along the follower's motion: contact force, springs, and the speed at which contact is lost.

    F = m·ω²·y'' + c·ω·y' + k·y + F₀ + F_ext            contact is lost where F < 0

It is linear in the motion, and F_ext constant or straight between corners (``motion.load``), so that its extremes
over the turn are those of a polynomial on each panel: exact, and the same for all designs of a programme. For an
oscillating follower F is the moment about the pivot, and forces are those at the trace point, F/l. The jump speed
is the ω up to which F is nowhere below 0, to 1e-14 of its largest value: a follower that nothing preloads rests on
its cam without force, which is no loss of contact.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 8 and 9.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial
from itertools import product
from math import inf, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.case import Bounded, Case, Effect, Setup
from camopt.effects.given import GivenDynamics
from camopt.effects.implied import Implied, LeastForce
from camopt.effects.peak import Peak, at_corners
from camopt.effects.work import added, derivative
from camopt.mechanisms.design import Designs
from camopt.motion.programme import Programme, span
from camopt.motion.table import ALL_STROKES
from camopt.numerics import BISECTIONS, LARGEST, LEAST, FloatArray
from camopt.numerics.curves import Linear, curve, formula
from camopt.numerics.piecewise import load_series

CONTACT = ("contact_force_min_N", "contact_force_max_N")
STIFFEST = 1e12  # times the force over the lift: a spring that no stiffer one betters
FORCE_ERROR = 1e-14  # of the largest force: less below 0 is rounding


class ChangingForce(NamedTuple):
    """F with an external load that changes over the turn: ``steady``, all other forces, plus share·load."""

    steady: Linear
    share: FloatArray


@formula(ChangingForce, loaded=True)
def changing_force(f, i, at):
    force, force1 = curve(f.steady, i, at)
    return force + f.share[i] * at.load.value, force1 + f.share[i] * at.load.slope


def offers(setup: Setup) -> tuple[str, ...]:
    force = "N_m" if setup.angular else "N"
    rate = "N_m_per_rad" if setup.angular else "N_per_mm"
    names = (f"preload_required_{force}", f"spring_rate_required_{rate}", "jump_speed_rpm", "jump_speed_ratio")
    flat_swing = setup.angular and setup.mechanism.curvature is None  # its lever changes over the turn
    return names if flat_swing else (*CONTACT, *names)


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
    keys = missing(setup)
    mass = tuple(key for key in keys if key != "cam.rpm")
    wanted = {name: mass if name == "jump_speed_rpm" else keys for name in offers(setup)}
    return {name: keys for name, keys in wanted.items() if keys}


def missing(setup: Setup) -> tuple[str, ...]:
    """The keys that a force needs and the scene lacks."""
    speed = () if setup.omega is not None else ("cam.rpm",)
    mass = "follower.dynamics.inertia" if setup.angular else "follower.dynamics.mass"
    return (*speed, *(() if setup.dynamics.mass is not None else (mass,)))


def weights(dynamics: GivenDynamics, omega: Any) -> tuple[Any, Any, Any, Any]:
    """Factors of y, y' and y'', and the constant: they give N from mm by rad (N·mm from rad by rad).

    A load that changes over the turn comes on top, from the programme.
    """
    assert dynamics.mass is not None
    constant = dynamics.preload + dynamics.load
    return dynamics.stiffness, dynamics.damping * omega, dynamics.mass * omega**2, constant


def force_series(programme: Programme, dynamics: GivenDynamics, omega: float) -> FloatArray:
    """F on the panels, N (N·mm)."""
    table = programme.table
    *factors, constant = weights(dynamics, omega)
    along = added(*(factor * derivative(table, order) for order, factor in enumerate(factors)), load_series(table))
    along[0] += constant
    return along


def force_span(programme: Programme, dynamics: GivenDynamics, omega: float) -> tuple[float, float]:
    """Least and largest F over the turn; infinite both ways where the velocity jumps."""
    if programme.corners:
        return -inf, inf
    *factors, constant = weights(dynamics, omega)
    least, largest = span(programme, tuple(factors), ALL_STROKES, 1.0)
    return least + constant, largest + constant


@lru_cache(maxsize=4096)
def jump_speed(programme: Programme, dynamics: GivenDynamics) -> float:
    """The largest ω up to which contact is kept, rad/s; 0 if there is none at rest.

    With damping, contact may be lost, won and lost again as ω grows. So ω goes up in steps over which it is proved
    to be kept, longer and longer while that succeeds, and halved where it does not, down to rounding.
    """
    if programme.corners or not _kept(*(at_rest := force_span(programme, dynamics, 0.0))) or at_rest[1] <= 0.0:
        return 0.0
    omega, step = 0.0, 1.0
    while omega + step > omega:
        if kept_between(programme, dynamics, omega, omega + step):
            omega, step = omega + step, 2.0 * step
        else:
            step *= 0.5
    return omega


def _kept(least: float, largest: float) -> bool:
    """Whether a force with given extremes keeps contact."""
    return least >= -FORCE_ERROR * max(-least, largest)


def kept_between(programme: Programme, dynamics: GivenDynamics, low: float, high: float) -> bool:
    """Whether F ≥ 0 over the turn is sure at all speeds between two: F is linear in ω·y' and in ω²·y''.

    Undamped, that is so if it is at both ends.
    """
    stiffness, *_, constant = weights(dynamics, 1.0)
    ends = {
        (dynamics.damping * slow, (dynamics.mass or 0.0) * fast**2) for slow, fast in product((low, high), repeat=2)
    }
    spans = (span(programme, (stiffness, *pair), ALL_STROKES, 1.0) for pair in ends)
    return all(_kept(least + constant, largest + constant) for least, largest in spans)


@lru_cache(maxsize=4096)
def required_stiffness(programme: Programme, dynamics: GivenDynamics, omega: float) -> float:
    """The least spring rate that keeps contact with the preload as it is; infinite if none does."""
    scale = max(map(abs, force_span(programme, replace(dynamics, stiffness=0.0), omega)))

    def kept(stiffness: float) -> bool:
        return force_span(programme, replace(dynamics, stiffness=stiffness), omega)[0] >= -FORCE_ERROR * scale

    if programme.corners:
        return inf
    if kept(0.0):
        return 0.0
    low, high = 0.0, scale / programme.lift
    while not kept(high):
        low, high = high, 2.0 * high
        if high > STIFFEST * scale / programme.lift:
            return inf
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if kept(middle) else (middle, high)
    return high


def peaks(setup: Setup) -> dict[str, Peak]:
    """The extremes of F as peaks of a curve, if designs have numbers of their own; else they are known exactly."""
    if not setup.free or setup.omega is None or CONTACT[0] not in offers(setup):
        return {}
    along = ((partial(force_curve, setup), ALL_STROKES),)
    return {name: Peak(along, goal, jumps=at_corners) for name, goal in zip(CONTACT, (LEAST, LARGEST), strict=True)}


def force_curve(setup: Setup, designs: Designs, programme: Programme) -> Any:
    """F, N; F/l of an oscillating follower with a trace point, the moment (N·mm) of an oscillating flat face."""
    lever = designs.arm_length if setup.angular and setup.mechanism.curvature else np.ones(len(designs))
    own = setup.at(designs)
    return force_of(own, own.omega, lever, programme)


def force_at_speed(setup: Setup, designs: Designs, programme: Programme, speed: Callable[[Setup], Any]) -> Any:
    """F at a speed, rad/s, which may depend on the designs' own numbers, N (N·mm)."""
    own = setup.at(designs)
    return force_of(own, speed(own), np.ones(len(designs)), programme)


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    setup, programme, own = case.setup, case.programme, case.each
    columns: dict[str, Any] = {}
    if wanted & {"jump_speed_rpm", "jump_speed_ratio"}:
        jump = case.by_setting(lambda each: jump_speed(programme, each.dynamics))
        columns["jump_speed_rpm"] = jump * 30.0 / pi
        columns |= {} if setup.omega is None else {"jump_speed_ratio": jump / own.omega}
    if setup.omega is None:
        return columns
    force = least_and_largest(case)
    if CONTACT[0] in offers(setup):
        lever = case.designs.arm_length if setup.angular else 1.0
        columns |= {name: over(end, lever) for name, end in zip(CONTACT, force, strict=True)}
    per_length, per_rate = ("N_m", "N_m_per_rad") if setup.angular else ("N", "N_per_mm")
    unit = 1e-3 if setup.angular else 1.0
    columns[f"preload_required_{per_length}"] = _preload(own.dynamics.preload, force[0], unit)
    if f"spring_rate_required_{per_rate}" in wanted:
        required = case.by_setting(lambda each: required_stiffness(programme, each.dynamics, each.omega))
        columns[f"spring_rate_required_{per_rate}"] = required * unit
    return columns


def least_and_largest(case: Case) -> tuple[Any, Any]:
    """The extremes of F over the turn, N (N·mm): numbers, or Bounded if designs have numbers of their own."""
    if not case.designs.numbers:
        return force_span(case.programme, case.setup.dynamics, case.setup.omega)
    goals, count = (LEAST, LARGEST), len(case.designs)
    if case.programme.corners:
        return np.full(count, -inf), np.full(count, inf)
    found = case.extremes(partial(own_force_curve, case.setup), [(ALL_STROKES, goal) for goal in goals])
    scale, outward = np.abs(found.value).max(axis=0), (-found.width[0], found.width[1])
    least, largest = (Bounded(value, by, scale) for value, by in zip(found.value, outward, strict=True))
    return least, largest


def keeps_contact(case: Case) -> Any:
    """Whether F > 0 over the whole turn, so that the bodies stay in contact."""
    least, _ = least_and_largest(case)
    return (least.value + least.outward if isinstance(least, Bounded) else least) > 0.0


def own_force_curve(setup: Setup, designs: Designs, programme: Programme) -> Any:
    """F, N (N·mm), of designs with numbers of their own."""
    return force_at_speed(setup, designs, programme, lambda own: own.omega)


def force_of(setup: Setup, omega: Any, lever: Any, programme: Programme) -> Any:
    """F at a speed, rad/s, over a length, N (N·mm), as a curve."""
    assert omega is not None
    steady = Linear(*(weight / lever for weight in weights(setup.dynamics, omega)))
    return steady if programme.load is None else ChangingForce(steady, 1.0 / lever)


def over(force: Any, lever: Any) -> Any:
    """The force at the end of a lever that gives a moment."""
    return Bounded(*(part / lever for part in force)) if isinstance(force, Bounded) else force / lever


def _preload(preload: Any, least: Any, unit: float) -> Any:
    """The least preload that keeps contact."""
    if not isinstance(least, Bounded):
        return np.maximum(preload - least, 0.0) * unit
    required, far = (np.maximum(preload - each, 0.0) for each in (least.value, least.value + least.outward))
    return Bounded(required * unit, (far - required) * unit, np.maximum(required, least.scale) * unit)


def implies(setup: Setup, name: str, bound: float) -> Implied:
    """The contact force: up to its jump speed a cam keeps contact."""
    if name == "jump_speed_rpm":
        return Implied(force=LeastForce(bound * pi / 30, 0.0))
    if name == "jump_speed_ratio" and setup.omega is not None:
        return Implied(force=LeastForce(bound * setup.omega, 0.0))
    if name == "contact_force_min_N" and setup.omega is not None:
        return Implied(force=LeastForce(setup.omega, bound))
    return Implied()


EFFECT = Effect("force", offers, run, lacks, of_motion=lambda setup: True, peaks=peaks, implies=implies)
