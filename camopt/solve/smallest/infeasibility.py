"""Why no design within bounds is feasible, in words.

The reason is the first of these that applies: the parts cannot be assembled; no design meets a limit, taken alone;
no design meets a smallest set of limits together. The range of the size is added if a cam beyond it is feasible.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, inf, log10

from camopt.core.numerics.budget import Budget
from camopt.core.numerics.irreducible import irreducible_set
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.model.mechanisms.design import SizeBounds
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.solve.smallest.grid_search import FEW_GRID_VALUES, coarse_grid, search_coarse_grid
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.tables.cells import number_text, with_unit

REASON_DIGITS = 6  # digits of a size in a reason


@dataclass(frozen=True)
class Infeasibility:
    """Why no design within bounds is feasible."""

    cause: str
    """The names of limits, or why parts cannot be assembled."""
    size_range: str = ""
    """The range of the size, if a cam beyond it is feasible."""
    size: float = inf
    """The size of that cam, mm."""
    is_smallest: bool = True
    """Whether that cam is proved to be the smallest."""


def find_infeasibility(problem: Problem, bounds: SizeBounds, budget: Budget) -> Infeasibility:
    """The limits that no design within bounds meets, alone or together.

    Once the budget is spent, the set named together may be larger than needed.
    """
    problem, (low, high) = with_rounding_relative_error(problem), bounds["size"]
    beyond = solve_smallest_cam(problem, {**bounds, "size": (0.0, inf)}, budget) if high < inf else None
    cause = _blocking_limits_in_words(problem, bounds, budget)
    if beyond is None or beyond.design is None:
        return Infeasibility(cause)
    ends = (
        with_unit(high, "mm")
        if low == high
        else f"{number_text(to_shown_unit(low, 'mm'))} to {with_unit(high, 'mm')}"
    )
    size_range = f"{problem.setup.mechanism.body.size_key} = {ends}"
    return Infeasibility(cause, size_range, round_size_up(beyond.size), beyond.is_proved)


def _blocking_limits_in_words(problem: Problem, bounds: SizeBounds, budget: Budget) -> str:
    grid = coarse_grid(replace(problem, limits=()), bounds, FEW_GRID_VALUES)
    if not problem.setup.mechanism.can_assemble(grid, problem.programme).any():
        return f"assembly: {problem.setup.mechanism.assembly}"
    limits = problem.without_deferred_limits.limits  # deferred limits need designs that meet all others
    if alone := [limit.name for limit in limits if _limits_exclude_all_designs([limit], problem, bounds, budget)]:
        return ", ".join(alone)
    together = irreducible_set(
        problem.limits, lambda rest: not _limits_exclude_all_designs(rest, problem, bounds, budget)
    )
    names = [limit.name for limit in together]
    if len(names) == 1:
        return names[0]
    late = " (perhaps fewer of them: the search stopped early)" if budget.is_spent else ""
    return f"{join_names(names)} together{late}"


def round_size_up(size: float) -> float:
    """A size rounded up to six digits; one that is above a multiple by less than 1e-9 is rounded down to it."""
    unit = 10.0 ** (floor(log10(size)) + 1 - REASON_DIGITS)
    return ceil(size / unit * (1.0 - 1e-9)) * unit


def _limits_exclude_all_designs(
    limits: Sequence[Limit], problem: Problem, bounds: SizeBounds, budget: Budget
) -> bool:
    relaxed = replace(problem, limits=tuple(limits))
    if search_coarse_grid(relaxed, bounds, FEW_GRID_VALUES, budget).design is not None:
        return False
    answer = solve_smallest_cam(relaxed, bounds, budget)
    return answer.design is None and answer.is_proved


def join_names(names: Iterable[str]) -> str:
    """Names as a sentence lists them: a, b and c."""
    *most, last = list(names) or [""]
    return f"{', '.join(most)} and {last}" if most else last
