"""The force along the follower's motion: contact, springs that keep it, and the speed at which it is lost.

    F = m·ω²·y'' + c·ω·y' + k·y + F₀ + F_ext            contact is lost where F < 0

It is linear in the motion, and F_ext constant or straight between corners (``motion.load``), so that its extremes
over the turn are those of a polynomial on each panel: exact, and the same for all designs of a programme. For an
oscillating follower F is the moment about the pivot, and forces are those at the trace point, F/l. The jump speed
is the ω up to which F is nowhere below 0, to 1e-14 of its largest value: a follower that nothing preloads rests on
its cam without force, which is no loss of contact.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 8 and 9.
"""

from dataclasses import replace
from functools import lru_cache
from itertools import product
from math import inf, pi
from typing import Any

from camopt.effects.case import Case, Dynamics, Effect, Setup
from camopt.motion.programme import Programme, span
from camopt.motion.table import TURN

HALVINGS = 60
STIFFEST = 1e12  # times the force over the lift: a spring that no stiffer one betters
ROUNDED = 1e-14  # of the largest force: less below 0 is rounding


def offers(setup: Setup) -> tuple[str, ...]:
    force = "N_m" if setup.angular else "N"
    rate = "N_m_per_rad" if setup.angular else "N_per_mm"
    names = (f"preload_required_{force}", f"spring_rate_required_{rate}", "jump_speed_rpm", "jump_speed_ratio")
    flat_swing = setup.angular and setup.mechanism.curvature is None  # its lever changes over the turn
    return names if flat_swing else ("contact_force_min_N", "contact_force_max_N", *names)


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


def weights(dynamics: Dynamics, omega: float) -> tuple[float, float, float, float]:
    """Factors of y, y' and y'', and the constant: N from mm by rad (N·mm from rad by rad).

    A load that changes over the turn comes on top, from the programme.
    """
    assert dynamics.mass is not None
    constant = dynamics.preload + dynamics.load
    return dynamics.stiffness, dynamics.damping * omega, dynamics.mass * omega**2, constant


def force_span(programme: Programme, dynamics: Dynamics, omega: float) -> tuple[float, float]:
    """Least and largest F over the turn; infinite both ways where the velocity jumps."""
    if programme.corners:
        return -inf, inf
    *factors, constant = weights(dynamics, omega)
    least, largest = span(programme, tuple(factors), TURN, 1.0)
    return least + constant, largest + constant


@lru_cache(maxsize=4096)
def jump_speed(programme: Programme, dynamics: Dynamics) -> float:
    """The largest ω up to which contact is kept, rad/s; 0 if it is not at rest, or nothing presses there.

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
    """Whether a force with these extremes keeps contact."""
    return least >= -ROUNDED * max(-least, largest)


def kept_between(programme: Programme, dynamics: Dynamics, low: float, high: float) -> bool:
    """Whether F ≥ 0 over the turn is sure at all speeds between two: F is linear in ω·y' and in ω²·y''.

    Undamped, that is so if it is at both ends.
    """
    stiffness, *_, constant = weights(dynamics, 1.0)
    ends = {
        (dynamics.damping * slow, (dynamics.mass or 0.0) * fast**2) for slow, fast in product((low, high), repeat=2)
    }
    spans = (span(programme, (stiffness, *pair), TURN, 1.0) for pair in ends)
    return all(_kept(least + constant, largest + constant) for least, largest in spans)


@lru_cache(maxsize=4096)
def required_stiffness(programme: Programme, dynamics: Dynamics, omega: float) -> float:
    """The least spring rate that keeps contact with the preload as it is; infinite if none does."""
    scale = max(map(abs, force_span(programme, replace(dynamics, stiffness=0.0), omega)))

    def kept(stiffness: float) -> bool:
        return force_span(programme, replace(dynamics, stiffness=stiffness), omega)[0] >= -ROUNDED * scale

    if programme.corners:
        return inf
    if kept(0.0):
        return 0.0
    low, high = 0.0, scale / programme.lift
    while not kept(high):
        low, high = high, 2.0 * high
        if high > STIFFEST * scale / programme.lift:
            return inf
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if kept(middle) else (middle, high)
    return high


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    setup, programme = case.setup, case.programme
    dynamics, omega = setup.dynamics, setup.omega
    columns: dict[str, Any] = {}
    if wanted & {"jump_speed_rpm", "jump_speed_ratio"}:
        columns["jump_speed_rpm"] = jump_speed(programme, dynamics) * 30.0 / pi
    if omega is None:
        return columns
    if "jump_speed_ratio" in wanted:
        columns["jump_speed_ratio"] = jump_speed(programme, dynamics) / omega
    least, largest = force_span(programme, dynamics, omega)
    if "contact_force_min_N" in offers(setup):
        lever = case.designs.arm_length if setup.angular else 1.0
        columns |= {"contact_force_min_N": least / lever, "contact_force_max_N": largest / lever}
    per_length, per_rate = ("N_m", "N_m_per_rad") if setup.angular else ("N", "N_per_mm")
    unit = 1e-3 if setup.angular else 1.0
    columns[f"preload_required_{per_length}"] = max(dynamics.preload - least, 0.0) * unit
    if f"spring_rate_required_{per_rate}" in wanted:
        required = required_stiffness(programme, dynamics, omega)
        columns[f"spring_rate_required_{per_rate}"] = required * unit
    return columns


EFFECT = Effect("force", offers, run, lacks, of_motion=lambda setup: True)
