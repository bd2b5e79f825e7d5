"""Why there are no free laws: limits that the nearest cams miss, and limits that contradict each other."""

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
from camopt.solve.synthesis.problem_from_scene import GENTLE_LAW, MOVE_PEAK_FACTOR, default_peak_factors
from camopt.solve.synthesis.synthesis_problem import SIZE_WORDS, TERM_ORDERS, SynthesisProblem
from camopt.solve.synthesis.term_units import term_unit
from camopt.solve.tables.cells import quantity_text, shown_column_name, with_unit
from camopt.solve.tables.designs import Design

BoundFunction = Callable[[SynthesisProblem], float | None]
"""Lower bound of a problem's objective for any motion; infinite if no motion meets its limits."""


class MissedLimit(NamedTuple):
    """A limit that a design breaks."""

    description: str
    """The value reached and the bound."""
    relative_miss: float
    """Distance from the bound, as a share of it."""
    easier: str
    """How to change the bound to make it easier: larger, or smaller."""


def no_cam_error(scene: Scene, problem: SynthesisProblem, searches: Sequence[Optimum]) -> Unmet:
    """An error for nonconvex limits that no cam of free laws meets, with what the nearest cam reached."""
    start, defaults = (
        "no cam was found for free laws that meets",
        _default_limits_and_remedy_in_words(scene, problem),
    )
    misses = [missed for search in searches if (missed := _limits_missed_by_nearest_cam(problem, search))]
    if not misses:
        obstacles = dict.fromkeys(why for search in searches for why in search.obstacles.values())
        reasons = f", because of {join_words(list(obstacles))}" if obstacles else " together"
        return Unmet(f"{start} all limits{reasons}{defaults}")
    nearest = min(misses, key=lambda keys: (len(keys), max(missed.relative_miss for missed in keys.values())))
    wider = [f"{missed.easier} {key}" for key, missed in nearest.items() if "." in key]
    instead = (
        "no such limit"
        if all(key.startswith("limits.") for key in nearest if "." in key)
        else "a range in [search]"
    )
    remedy = f"; set a {' or a '.join(wider)}, or {instead}" if wider else ""
    missed_limits = [f"{key} ({missed.description})" for key, missed in nearest.items()]
    return Unmet(f"{start} {join_words(missed_limits)}{remedy}{defaults}")


def _default_limits_and_remedy_in_words(scene: Scene, problem: SynthesisProblem) -> str:
    """The default limits with their bounds, and how to replace them; empty if there are none."""
    default_limits = []
    for name in _default_limit_names(scene, problem):
        ends = [abs(end) for row in problem.derivative_ranges for end in row.get(TERM_ORDERS[name], ())]
        largest = with_unit(max(ends, default=0.0) * problem.term_unit_factors[name], term_unit(name, scene))
        default_limits.append(f"{name} of at most {largest}")
    if not default_limits:
        return ""
    return f"; default limits: {join_words(default_limits)} {_source_and_override_of_defaults_in_words(scene)}"


def _limits_missed_by_nearest_cam(problem: SynthesisProblem, search: Optimum) -> dict[str, MissedLimit]:
    """Limits that the nearest cam of a search breaks, by key; a cam that meets all may still be too large."""
    if search.nearest_miss is not None:
        miss = search.nearest_miss
        broken = str(miss["violated"]).split(",")
        return {
            limit.key: _largest_miss_over_quantities(limit, miss)
            for limit in resolve(miss.searched).limits
            if limit.name in broken
        }
    largest_size, name = largest_cam_size(problem), problem.scene_problem.size_quantity_name
    if search.best is None or search.best[name] <= largest_size:
        return {}
    size_text = f"{shown_column_name(name)} = {quantity_text(name, search.best[name])}"
    description = f"best {size_text}, limit {with_unit(largest_size, 'mm')}"
    return {_size_key(problem): MissedLimit(description, search.best[name] / largest_size - 1.0, "larger")}


def broken_limit_keys_in_words(scene: Scene, problem: SynthesisProblem, row: Design) -> str:
    """The limits of free laws that the cam of a known law breaks, by their keys."""
    names = limits_broken_by_cam(problem, row)
    keys = [_condition_key(scene, problem, name) for name in names if name != SIZE_WORDS]
    size = f"{_size_key(problem)} of at most {with_unit(largest_cam_size(problem), 'mm')}"
    return join_words(keys + [size] * (SIZE_WORDS in names))


def _largest_miss_over_quantities(limit: Limit, row: Mapping[str, Any]) -> MissedLimit:
    """The quantity that breaks a limit most."""
    values = {name: float(row[name]) for name in limit.shown_quantities if isinstance(row.get(name), (int, float))}
    if not values or not limit.set_by_scene:
        return MissedLimit("broken", inf, "other")
    worst = max(values, key=lambda name: abs(values[name] - limit.bound))
    relative_miss = abs(values[worst] - limit.bound) / (abs(limit.bound) or 1.0)
    bound_text = f"{limit.relation} {with_unit(limit.bound, find_quantity(worst, limit.setup).unit)}"
    easier = "smaller" if limit.relation.startswith((AT_LEAST, ">")) else "larger"
    reached = f"{shown_column_name(worst)} = {quantity_text(worst, values[worst])}"
    return MissedLimit(f"best {reached}, limit {bound_text}", relative_miss, easier)


def contradiction_error(scene: Scene, problem: SynthesisProblem, objective_lower_bound: BoundFunction) -> Unmet:
    """An error for limits and conditions that contradict each other; without any one, a motion exists."""
    conflict = irreducible_set(
        problem.limit_names, lambda kept: objective_lower_bound(problem.keep_limits(kept)) != inf
    )
    default_names = [name for name in _default_limit_names(scene, problem) if name in conflict]
    others = [
        _condition_key(scene, problem, name)
        + _least_term_in_words(scene, problem, name, conflict, objective_lower_bound)
        for name in conflict
        if name not in default_names
    ]
    if not default_names:
        count = "two" if len(others) == 2 else len(others)
        conflict_words = "one alone is impossible" if len(others) == 1 else f"these {count} contradict each other"
        return Unmet(f"no motion meets all limits; {conflict_words}: {join_words(others)}")
    default = " and ".join(
        f"{name}{_least_term_in_words(scene, problem, name, conflict, objective_lower_bound)}"
        for name in default_names
    )
    start = f"no motion meets {join_words(others) or 'the segments'} within the default limits of {default}"
    return Unmet(f"{start} {_source_and_override_of_defaults_in_words(scene)}")


def _default_limit_names(scene: Scene, problem: SynthesisProblem) -> list[str]:
    """Names of the limits that hold by default only."""
    return [name.removeprefix("peak_") for name in default_peak_factors(scene, problem.objective)]


def _source_and_override_of_defaults_in_words(scene: Scene) -> str:
    """Where the default limits of the motion come from, and the keys that replace them."""
    has_strokes = any(segment.segment in ("rise", "return") for segment in scene.motion)
    sources = [f"the peaks of {GENTLE_LAW}"] if has_strokes else []
    if any(segment.segment == MOVE for segment in scene.motion):
        sources.append(f"{MOVE_PEAK_FACTOR:g} times those of the scene's own moves")
    limit_keys = "limits.acceleration or limits.jerk" if scene.cam.rpm is not None else ""
    peak_keys = "synthesis.peak_acceleration or synthesis.peak_jerk" if has_strokes else ""
    keys = (
        ", or ".join(filter(None, (limit_keys, peak_keys))) or "limits.acceleration or limits.jerk, with cam.rpm,"
    )
    return f"({' and '.join(sources)}); set {keys} to replace the default limits"


def _condition_key(scene: Scene, problem: SynthesisProblem, name: str) -> str:
    """The key that sets a limit or condition."""
    if name == SIZE_WORDS:
        return f"{SIZE_WORDS} ({_size_key(problem)})"
    limits = {limit.name: limit.key for limit in problem.scene_problem.limits}
    if name in limits or "." in name:
        return limits.get(name, name)
    return f"synthesis.peak_{name}" if getattr(scene.synthesis, f"peak_{name}", None) else name


def _size_key(problem: SynthesisProblem) -> str:
    searched, key = (
        "size" in problem.scene_problem.search_space.variables,
        problem.scene_problem.setup.mechanism.body.size_key,
    )
    return f"{'search' if searched else 'cam'}.{key}"


def _least_term_in_words(
    scene: Scene,
    problem: SynthesisProblem,
    name: str,
    conflict: Sequence[str],
    objective_lower_bound: BoundFunction,
) -> str:
    """Least value of a term for any motion within the other limits of the conflict; empty if unknown."""
    term = "size" if name == SIZE_WORDS else name
    if term not in AXIS_TERMS:
        return ""
    others = problem.keep_limits([other for other in conflict if other != name])
    least = objective_lower_bound(replace(others, objective={term: 1.0}))
    if not least or least == inf:
        return ""
    return f" (at least {with_unit(least, term_unit(term, scene))} with the rest)"
