"""The reason why no design within bounds is feasible, in words.

These are, in this order: parts that cannot be put together; each limit that no design holds; limits that can each
be held, but not together. And the range of the cam's size, if a cam of another size is feasible.

Source: J. W. Chinneck, E. W. Dravnieks, Locating minimal infeasible constraint sets in linear programs, ORSA
Journal on Computing 3 (1991): the deletion filter.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import ceil, floor, inf, log10

from camopt.mechanisms.design import SizeBounds
from camopt.problem.limit import Limit
from camopt.problem.problem import Problem, exactly
from camopt.smallest.first_look import FEW_VALUES, coarse_grid, first_look
from camopt.smallest.smallest import smallest

DIGITS = 6  # of a size that a reason tells


def reason(problem: Problem, bounds: SizeBounds, until: float = inf) -> str:
    """The limits that no design within bounds meets, in words.

    After ``until`` (``clock.now``) more limits may be named together than it takes to stop them.
    """
    problem = exactly(problem)
    beyond = _beyond(problem, bounds, until)
    grid = coarse_grid(replace(problem, limits=()), bounds, problem.programme.lift, FEW_VALUES)
    if not problem.setup.mechanism.exists(grid, problem.programme).any():
        return f"assembly: {problem.setup.mechanism.assembly}{beyond}"
    first = problem.without_last.limits  # those that are asked last are asked of designs that hold all others
    alone = [limit.name for limit in first if _stop([limit], problem, bounds, until)]
    if alone:
        return ", ".join(alone) + beyond
    names = [limit.name for limit in _together(problem, bounds, until)]
    return (f"{listed(names)} together" if len(names) > 1 else names[0]) + beyond


def _beyond(problem: Problem, bounds: SizeBounds, until: float) -> str:
    """The range of the cam's size, if one is given and a cam beyond it is feasible."""
    low, high = bounds["size"]
    answer = smallest(problem, {**bounds, "size": (0.0, inf)}, until) if high < inf else None
    if answer is None or answer.design is None:
        return ""
    key, size = problem.setup.mechanism.body.size, rounded_up(answer.size)
    ends = f"{low:.{DIGITS}g} mm" if low == high else f"{low:.{DIGITS}g} to {high:.{DIGITS}g} mm"
    which = "the smallest feasible cam has" if answer.proved else "feasible is one of"
    return f", within the range of {key} ({ends}); {which} {size:.{DIGITS}g} mm"


def rounded_up(size: float) -> float:
    """A size to six digits, no smaller but for 1e-9 of it."""
    unit = 10.0 ** (floor(log10(size)) + 1 - DIGITS)
    return ceil(size / unit * (1.0 - 1e-9)) * unit


def _stop(limits: Sequence[Limit], problem: Problem, bounds: SizeBounds, until: float) -> bool:
    """Whether it is proved that no design holds these limits."""
    relaxed = replace(problem, limits=tuple(limits))
    if first_look(relaxed, bounds, FEW_VALUES, until).design is not None:
        return False
    answer = smallest(relaxed, bounds, until)
    return answer.design is None and answer.proved


def _together(problem: Problem, bounds: SizeBounds, until: float) -> list[Limit]:
    """Limits that stop every design, and would not without any one of them."""
    kept = list(problem.limits)
    for limit in problem.limits:
        others = [other for other in kept if other is not limit]
        if _stop(others, problem, bounds, until):
            kept = others
    return kept


def listed(names: Iterable[str]) -> str:
    """Names as a sentence lists them: a, b and c."""
    *most, last = list(names) or [""]
    return f"{', '.join(most)} and {last}" if most else last
