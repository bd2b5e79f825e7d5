"""Why there are no free laws: what cams reached of the limits that none holds, and what contradicts what."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

from camopt.core.mistakes import Unmet, listed_words
from camopt.core.numerics.irreducible import irreducible
from camopt.core.quantities import AT_LEAST
from camopt.model.effects import quantity_of
from camopt.model.motion.segments import MOVE
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.scene.synthesis import AXIS_TERMS
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.synthesis.cams import beyond, largest_size
from camopt.solve.synthesis.demand import SIZE_WORDS, TERM_ORDERS, Demand
from camopt.solve.synthesis.from_scene import AMPLE_FACTOR, GENTLE, default_peaks
from camopt.solve.synthesis.units import unit_of
from camopt.solve.tables.cells import quantity, shown_name, with_unit
from camopt.solve.tables.designs import Design

BestPossible = Callable[[Demand], float | None]
"""What no motion whatever can pass of a demand's objective; infinite if none holds its limits."""


class Missed(NamedTuple):
    """A limit that a design breaks."""

    words: str
    """What it reached beside the bound."""
    by: float
    """How far that is from the bound, as a share of it."""
    easier: str
    """Which bounds are easier to hold: larger, or smaller ones."""


def no_cam(scene: Scene, demand: Demand, searches: Sequence[Optimum]) -> Unmet:
    """No cam of free laws holds the limits that are not convex: what the one that misses by least has of each."""
    held, more = (
        "free laws hold the convex limits, but no cam was found that also holds",
        _by_default(scene, demand),
    )
    found = [missed for each in searches if (missed := _missed_by(demand, each))]
    if not found:
        obstacles = dict.fromkeys(why for each in searches for why in each.obstacles.values())
        others = f"the others: {listed_words(list(obstacles))}" if obstacles else "all of them together"
        return Unmet(f"{held} {others}{more}")
    nearest = min(found, key=lambda each: (len(each), max(missed.by for missed in each.values())))
    wider = [f"{missed.easier} {key}" for key, missed in nearest.items() if "." in key]
    instead = (
        "no such limit"
        if all(key.startswith("limits.") for key in nearest if "." in key)
        else "a range in [search]"
    )
    lifts = f"; what lifts this is a {' or a '.join(wider)}, or {instead}" if wider else ""
    reached = [f"{key} ({missed.words})" for key, missed in nearest.items()]
    return Unmet(f"{held} {listed_words(reached)}{lifts}{more}")


def _by_default(scene: Scene, demand: Demand) -> str:
    """What is limited by default alone, with the bound, and how to have another."""
    found = []
    for name in _usual(scene, demand):
        ends = [abs(end) for row in demand.ranges for end in row.get(TERM_ORDERS[name], ())]
        largest = with_unit(max(ends, default=0.0) * demand.per_unit[name], unit_of(name, scene))
        found.append(f"{name} of at most {largest}")
    if not found:
        return ""
    return f"; by default laws have {listed_words(found)} ({_gentle(scene)}): {_lifted_by(scene)}"


def _missed_by(demand: Demand, search: Optimum) -> dict[str, Missed]:
    """What the nearest cam of a search breaks; one that holds all limits may be too large."""
    if search.nearest_miss is not None:
        # by the key of each limit that a design breaks what it reached beside the bound, and by what share
        miss = search.nearest_miss
        broken = str(miss["violated"]).split(",")
        limits = [limit for limit in resolve(miss.searched).limits if limit.name in broken]
        return {key_of(limit): _reached(limit, miss) for limit in limits}
    most, name = largest_size(demand), demand.problem.size_name
    if search.best is None or search.best[name] <= most:
        return {}
    found = f"{shown_name(name)} = {quantity(name, search.best[name])}"
    reached = f"{found} was reached, at most {with_unit(most, 'mm')} is allowed"
    return {_size_key(demand): Missed(reached, search.best[name] / most - 1.0, "larger")}


def broken_in_words(scene: Scene, demand: Demand, row: Design) -> str:
    """What a known law's cam breaks of all that free laws hold, by keys."""
    names = beyond(demand, row)
    said = [_key(scene, demand, name) for name in names if name != SIZE_WORDS]
    size = f"{_size_key(demand)} of at most {with_unit(largest_size(demand), 'mm')}"
    return listed_words(said + [size] * (SIZE_WORDS in names))


def key_of(limit: Limit) -> str:
    """The key of the scene that gives a limit; the name of one that every cam must meet."""
    return (limit.given_by or f"limits.{limit.name}") if limit.asked else limit.name


def _reached(limit: Limit, row: Mapping[str, Any]) -> Missed:
    """The quantity that breaks a limit most."""
    values = {name: float(row[name]) for name in limit.shown if isinstance(row.get(name), (int, float))}
    if not values or not limit.asked:
        return Missed("broken", inf, "other")
    worst = max(values, key=lambda name: abs(values[name] - limit.bound))
    by = abs(values[worst] - limit.bound) / (abs(limit.bound) or 1.0)
    asked = f"{limit.relation} {with_unit(limit.bound, quantity_of(worst, limit.setup).unit)}"
    easier = "smaller" if limit.relation.startswith((AT_LEAST, ">")) else "larger"
    reached = f"{shown_name(worst)} = {quantity(worst, values[worst])}"
    return Missed(f"{reached} was reached, {asked} is asked", by, easier)


def contradiction(scene: Scene, demand: Demand, bound_of: BestPossible) -> Unmet:
    """The limits and conditions that no motion holds together: without any one of these one does."""
    found = irreducible(demand.names, lambda kept: bound_of(demand.only(kept)) != inf)
    usual = [name for name in _usual(scene, demand) if name in found]
    asked = [
        f"{_key(scene, demand, name)}{_least(scene, demand, name, found, bound_of)}"
        for name in found
        if name not in usual
    ]
    if not usual:
        count = "two" if len(asked) == 2 else len(asked)
        alone = "by itself it is this one that none holds"
        together = alone if len(asked) == 1 else f"these {count} contradict each other"
        return Unmet(f"no motion whatever holds all limits; {together}: {listed_words(asked)}")
    default = " and ".join(f"{name}{_least(scene, demand, name, found, bound_of)}" for name in usual)
    within = f"within the {default} that it may have by default ({_gentle(scene)})"
    return Unmet(f"no motion whatever holds {listed_words(asked) or 'the segments'} {within}; {_lifted_by(scene)}")


def _usual(scene: Scene, demand: Demand) -> list[str]:
    """What is limited by default alone."""
    return [name.removeprefix("peak_") for name in default_peaks(scene, demand.objective)]


def _gentle(scene: Scene) -> str:
    """What the default limits of the motion are."""
    unit = [f"the peaks of {GENTLE}"] if _has_unit_strokes(scene) else []
    own = (
        [f"{AMPLE_FACTOR:g} times those of the scene's own moves"]
        if any(s.segment == MOVE for s in scene.motion)
        else []
    )
    return " and ".join([*unit, *own])


def _lifted_by(scene: Scene) -> str:
    """Which keys put limits of the user's own in place of the default ones."""
    timed = "limits.acceleration or limits.jerk" if scene.cam.rpm is not None else ""
    unit = "synthesis.peak_acceleration or synthesis.peak_jerk" if _has_unit_strokes(scene) else ""
    keys = ", or ".join(filter(None, (timed, unit))) or "limits.acceleration or limits.jerk, with cam.rpm,"
    return f"{keys} takes the place of what is by default"


def _has_unit_strokes(scene: Scene) -> bool:
    """Whether there are rises or returns, whose peaks [synthesis] can limit."""
    return any(segment.segment in ("rise", "return") for segment in scene.motion)


def _key(scene: Scene, demand: Demand, name: str) -> str:
    """The key that gives a limit or condition of a demand."""
    if name == SIZE_WORDS:
        return f"{SIZE_WORDS} ({_size_key(demand)})"
    limits = {limit.name: key_of(limit) for limit in demand.problem.limits}
    if name in limits or "." in name:
        return limits.get(name, name)
    return f"synthesis.peak_{name}" if getattr(scene.synthesis, f"peak_{name}", None) else name


def _size_key(demand: Demand) -> str:
    searched, key = "size" in demand.problem.choices.variables, demand.problem.setup.mechanism.body.size
    return f"{'search' if searched else 'cam'}.{key}"


def _least(scene: Scene, demand: Demand, name: str, found: Sequence[str], bound_of: BestPossible) -> str:
    """In words, the least of a term of the objective that a motion has with the other limits found."""
    term = "size" if name == SIZE_WORDS else name
    if term not in AXIS_TERMS:
        return ""
    others = demand.only([other for other in found if other != name])
    least = bound_of(replace(others, objective={term: 1.0}))
    if not least or least == inf:
        return ""
    return f" (at least {with_unit(least, unit_of(term, scene))} with the rest)"
