"""Why no design within bounds is feasible, in words.

The reason is the first of these that applies: the parts cannot be assembled; no design meets a limit, taken alone;
no design meets a smallest set of limits together. The range of the size is added if a cam beyond it is feasible.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, inf, log10

from camopt.core.mistakes import join_words
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.core.numerics.irreducible import irreducible_set
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.model.mechanisms.design import SizeBounds
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.solve.smallest.grid_search import FEW_GRID_VALUES, coarse_grid, search_coarse_grid
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.tables.cells import number_text, with_unit

REASON_DIGITS = 6  # digits of a size in a reason
MOST_LISTED_BOXES = 3  # boxes whose sizes a reason lists


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

    def __str__(self) -> str:
        return self.cause + self.range_in_words()

    def range_in_words(self, other_sizes: str = "") -> str:
        """The range, and the cam beyond it; ``other_sizes`` describes the other sizes of this cam."""
        if not self.size_range:
            return ""
        which = "the smallest feasible cam has" if self.is_smallest else "a feasible cam has"
        cam = f"{which} {with_unit(self.size, 'mm')}{f', with {other_sizes}' if other_sizes else ''}"
        return f", for {self.size_range} ({cam})"


def find_infeasibility(problem: Problem, bounds: SizeBounds, budget: Budget = UNLIMITED) -> Infeasibility:
    """The limits that no design within bounds meets, alone or together.

    Once the budget is spent, the set named together may be larger than needed.
    """
    problem = with_rounding_relative_error(problem)
    return replace(
        _infeasibility_with_cam_beyond_range(problem, bounds, budget),
        cause=_blocking_limits_in_words(problem, bounds, budget),
    )


def join_infeasibilities(reasons: Mapping[str, Infeasibility]) -> str:
    """One text of the reasons of all boxes, each reason once, with the boxes that it applies to.

    The keys describe the sizes of the boxes. A reason names the smallest cam beyond the range, over its boxes.
    """
    boxes_by_cause: dict[tuple[str, str], list[str]] = {}
    for where, reason in reasons.items():
        boxes_by_cause.setdefault((reason.cause, reason.size_range), []).append(where)
    texts = []
    for (cause, _), boxes in boxes_by_cause.items():
        best = min(boxes, key=lambda where: reasons[where].size)
        where = f", if {join_words(boxes, MOST_LISTED_BOXES)}" if len(boxes_by_cause) > 1 else ""
        texts.append(f"{cause}{where}{reasons[best].range_in_words(best)}")
    return "; ".join(texts)


def _blocking_limits_in_words(problem: Problem, bounds: SizeBounds, budget: Budget) -> str:
    grid = coarse_grid(replace(problem, limits=()), bounds, problem.programme.lift, FEW_GRID_VALUES)
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


def _infeasibility_with_cam_beyond_range(problem: Problem, bounds: SizeBounds, budget: Budget) -> Infeasibility:
    """The range of the size, if there is one and a cam beyond it is feasible; without a cause."""
    low, high = bounds["size"]
    answer = solve_smallest_cam(problem, {**bounds, "size": (0.0, inf)}, budget) if high < inf else None
    if answer is None or answer.design is None:
        return Infeasibility("")
    key, size = problem.setup.mechanism.body.size_key, round_size_up(answer.size)
    ends = (
        with_unit(high, "mm")
        if low == high
        else f"{number_text(to_shown_unit(low, 'mm'))} to {with_unit(high, 'mm')}"
    )
    return Infeasibility("", f"{key} = {ends}", size, answer.is_proved)


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
