"""Effects: pieces that compute quantities, and the plan that runs only those called for."""

from collections.abc import Iterable

from camopt.effects import crossing, curvature, motion, pressure, reach, sizes
from camopt.effects.case import Case, Effect, Subject
from camopt.quantities import QUANTITIES

__all__ = ["EFFECTS", "Case", "Effect", "Subject", "offered", "plan"]

EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        sizes.EFFECT,
        motion.EFFECT,
        pressure.EFFECT,
        curvature.EFFECT,
        reach.EFFECT,
        crossing.EFFECT,
    )
}
"""Every effect by name, cheapest first: the order in which they run."""


def offered(subject: Subject) -> tuple[str, ...]:
    """All quantities that a subject has, in the order of the columns."""
    names = {name for effect in EFFECTS.values() for name in effect.offers(subject)}
    return tuple(name for name in QUANTITIES if name in names)


def plan(wanted: Iterable[str]) -> tuple[Effect, ...]:
    """The effects that compute the wanted quantities, in order; nothing else runs."""
    called = {QUANTITIES[name].effect for name in wanted}
    return tuple(effect for name, effect in EFFECTS.items() if name in called)
