"""Why there are no free laws: what cams reached of the limits that none holds, and what contradicts what."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

from camopt.core.mistakes import Unmet, join_words
from camopt.core.numerics.irreducible import irreducible_set
from camopt.core.quantities import AT_LEAST
from camopt.model.effects import find_quantity
from camopt.model.motion.segments import MOVE
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.scene.synthesis import AXIS_TERMS
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.synthesis.cams import largest_cam_size, limits_broken_by_cam
from camopt.solve.synthesis.problem_from_scene import GENTLE_LAW, MOVE_PEAK_FACTOR, default_peaks
from camopt.solve.synthesis.synthesis_problem import SIZE_WORDS, TERM_ORDERS, SynthesisProblem
from camopt.solve.synthesis.term_units import term_unit
from camopt.solve.tables.cells import quantity_text, shown_column_name, with_unit
from camopt.solve.tables.designs import Design

BoundFunction = Callable[[SynthesisProblem], float | None]
"""What no motion whatever can pass of a demand's objective; infinite if none holds its limits."""


class MissedLimit(NamedTuple):
    """A limit that a design breaks."""

    description: str
    """What it reached beside the bound."""
    relative_miss: float
    """How far that is from the bound, as a share of it."""
    easier: str
    """Which bounds are easier to hold: larger, or smaller ones."""


def no_cam_error(scene: Scene, problem: SynthesisProblem, searches: Sequence[Optimum]) -> Unmet:
    """No cam of free laws holds the limits that are not convex: what the one that misses by least has of each."""
    held, more = (
        "free laws hold the convex limits, but no cam was found that also holds",
        _defaults_in_words(scene, problem),
    )
    found = [missed for each in searches if (missed := _missed_limits(problem, each))]
    if not found:
        obstacles = dict.fromkeys(why for each in searches for why in each.obstacles.values())
        others = f"the others: {join_words(list(obstacles))}" if obstacles else "all of them together"
        return Unmet(f"{held} {others}{more}")
    nearest = min(found, key=lambda each: (len(each), max(missed.relative_miss for missed in each.values())))
    wider = [f"{missed.easier} {key}" for key, missed in nearest.items() if "." in key]
    instead = (
        "no such limit"
        if all(key.startswith("limits.") for key in nearest if "." in key)
        else "a range in [search]"
    )
    lifts = f"; what lifts this is a {' or a '.join(wider)}, or {instead}" if wider else ""
    reached = [f"{key} ({missed.description})" for key, missed in nearest.items()]
    return Unmet(f"{held} {join_words(reached)}{lifts}{more}")


def _defaults_in_words(scene: Scene, problem: SynthesisProblem) -> str:
    """What is limited by default alone, with the bound, and how to have another."""
    found = []
    for name in _default_limit_names(scene, problem):
        ends = [abs(end) for row in problem.derivative_ranges for end in row.get(TERM_ORDERS[name], ())]
        largest = with_unit(max(ends, default=0.0) * problem.term_factors[name], term_unit(name, scene))
        found.append(f"{name} of at most {largest}")
    if not found:
        return ""
    peaks = f"{join_words(found)} ({_default_peaks_in_words(scene)})"
    return f"; by default laws have {peaks}: {_override_keys_in_words(scene)}"


def _missed_limits(problem: SynthesisProblem, search: Optimum) -> dict[str, MissedLimit]:
    """What the nearest cam of a search breaks; one that holds all limits may be too large."""
    if search.nearest_miss is not None:
        # by the key of each limit that a design breaks what it reached beside the bound, and by what share
        miss = search.nearest_miss
        broken = str(miss["violated"]).split(",")
        limits = [limit for limit in resolve(miss.searched).limits if limit.name in broken]
        return {limit_key(limit): _worst_miss(limit, miss) for limit in limits}
    most, name = largest_cam_size(problem), problem.scene_problem.size_name
    if search.best is None or search.best[name] <= most:
        return {}
    found = f"{shown_column_name(name)} = {quantity_text(name, search.best[name])}"
    reached = f"{found} was reached, at most {with_unit(most, 'mm')} is allowed"
    return {_size_key(problem): MissedLimit(reached, search.best[name] / most - 1.0, "larger")}


def broken_keys_in_words(scene: Scene, problem: SynthesisProblem, row: Design) -> str:
    """What a known law's cam breaks of all that free laws hold, by keys."""
    names = limits_broken_by_cam(problem, row)
    said = [_condition_key(scene, problem, name) for name in names if name != SIZE_WORDS]
    size = f"{_size_key(problem)} of at most {with_unit(largest_cam_size(problem), 'mm')}"
    return join_words(said + [size] * (SIZE_WORDS in names))


def limit_key(limit: Limit) -> str:
    """The key of the scene that gives a limit; the name of one that every cam must meet."""
    return (limit.bound_key or f"limits.{limit.name}") if limit.set_by_scene else limit.name


def _worst_miss(limit: Limit, row: Mapping[str, Any]) -> MissedLimit:
    """The quantity that breaks a limit most."""
    values = {name: float(row[name]) for name in limit.shown_quantities if isinstance(row.get(name), (int, float))}
    if not values or not limit.set_by_scene:
        return MissedLimit("broken", inf, "other")
    worst = max(values, key=lambda name: abs(values[name] - limit.bound))
    by = abs(values[worst] - limit.bound) / (abs(limit.bound) or 1.0)
    asked = f"{limit.relation} {with_unit(limit.bound, find_quantity(worst, limit.setup).unit)}"
    easier = "smaller" if limit.relation.startswith((AT_LEAST, ">")) else "larger"
    reached = f"{shown_column_name(worst)} = {quantity_text(worst, values[worst])}"
    return MissedLimit(f"{reached} was reached, {asked} is asked", by, easier)


def contradiction_error(scene: Scene, problem: SynthesisProblem, bound_of: BoundFunction) -> Unmet:
    """The limits and conditions that no motion holds together: without any one of these one does."""
    found = irreducible_set(problem.limit_names, lambda kept: bound_of(problem.keep_limits(kept)) != inf)
    usual = [name for name in _default_limit_names(scene, problem) if name in found]
    asked = [
        f"{_condition_key(scene, problem, name)}{_least_term_in_words(scene, problem, name, found, bound_of)}"
        for name in found
        if name not in usual
    ]
    if not usual:
        count = "two" if len(asked) == 2 else len(asked)
        alone = "by itself it is this one that none holds"
        together = alone if len(asked) == 1 else f"these {count} contradict each other"
        return Unmet(f"no motion whatever holds all limits; {together}: {join_words(asked)}")
    default = " and ".join(f"{name}{_least_term_in_words(scene, problem, name, found, bound_of)}" for name in usual)
    within = f"within the {default} that it may have by default ({_default_peaks_in_words(scene)})"
    return Unmet(
        f"no motion whatever holds {join_words(asked) or 'the segments'} {within}; {_override_keys_in_words(scene)}"
    )


def _default_limit_names(scene: Scene, problem: SynthesisProblem) -> list[str]:
    """What is limited by default alone."""
    return [name.removeprefix("peak_") for name in default_peaks(scene, problem.objective)]


def _default_peaks_in_words(scene: Scene) -> str:
    """What the default limits of the motion are."""
    unit = [f"the peaks of {GENTLE_LAW}"] if _has_unit_strokes(scene) else []
    own = (
        [f"{MOVE_PEAK_FACTOR:g} times those of the scene's own moves"]
        if any(s.segment == MOVE for s in scene.motion)
        else []
    )
    return " and ".join([*unit, *own])


def _override_keys_in_words(scene: Scene) -> str:
    """Which keys put limits of the user's own in place of the default ones."""
    timed = "limits.acceleration or limits.jerk" if scene.cam.rpm is not None else ""
    unit = "synthesis.peak_acceleration or synthesis.peak_jerk" if _has_unit_strokes(scene) else ""
    keys = ", or ".join(filter(None, (timed, unit))) or "limits.acceleration or limits.jerk, with cam.rpm,"
    return f"{keys} takes the place of what is by default"


def _has_unit_strokes(scene: Scene) -> bool:
    """Whether there are rises or returns, whose peaks [synthesis] can limit."""
    return any(segment.segment in ("rise", "return") for segment in scene.motion)


def _condition_key(scene: Scene, problem: SynthesisProblem, name: str) -> str:
    """The key that gives a limit or condition of a demand."""
    if name == SIZE_WORDS:
        return f"{SIZE_WORDS} ({_size_key(problem)})"
    limits = {limit.name: limit_key(limit) for limit in problem.scene_problem.limits}
    if name in limits or "." in name:
        return limits.get(name, name)
    return f"synthesis.peak_{name}" if getattr(scene.synthesis, f"peak_{name}", None) else name


def _size_key(problem: SynthesisProblem) -> str:
    searched, key = (
        "size" in problem.scene_problem.search_space.variables,
        problem.scene_problem.setup.mechanism.body.size,
    )
    return f"{'search' if searched else 'cam'}.{key}"


def _least_term_in_words(
    scene: Scene, problem: SynthesisProblem, name: str, found: Sequence[str], bound_of: BoundFunction
) -> str:
    """In words, the least of a term of the objective that a motion has with the other limits found."""
    term = "size" if name == SIZE_WORDS else name
    if term not in AXIS_TERMS:
        return ""
    others = problem.keep_limits([other for other in found if other != name])
    least = bound_of(replace(others, objective={term: 1.0}))
    if not least or least == inf:
        return ""
    return f" (at least {with_unit(least, term_unit(term, scene))} with the rest)"
