"""The reason why no design within bounds is feasible, in words.

These are, in this order: parts that cannot be put together; each limit that no design holds; limits that can each
be held, but not together. And the range of the cam's size, if a cam of another size is feasible.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, inf, log10

from camopt.core.mistakes import join_words
from camopt.core.numerics.clock import clock_seconds
from camopt.core.numerics.irreducible import irreducible_set
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.model.mechanisms.design import SizeBounds
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, at_rounding_error
from camopt.solve.smallest.grid_search import FEW_GRID_VALUES, coarse_grid, search_coarse_grid
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.tables.cells import number_text, with_unit

REASON_DIGITS = 6  # of a size that a reason tells
MOST_LISTED_BOXES = 3  # whose choices of sizes a reason lists


@dataclass(frozen=True)
class Infeasibility:
    """Why no design within bounds is feasible."""

    cause: str
    """Limits by name, or what keeps parts from being put together."""
    size_range: str = ""
    """The range of the cam's size, where a cam beyond it is feasible."""
    size: float = inf
    """The size of that cam, mm."""
    is_smallest: bool = True
    """Whether that is the smallest one, for certain."""

    def __str__(self) -> str:
        return self.cause + self.range_in_words()

    def range_in_words(self, where: str = "") -> str:
        """The range, and the cam beyond it; ``where`` says what other sizes that has."""
        if not self.size_range:
            return ""
        which = "the smallest feasible cam has" if self.is_smallest else "feasible is one of"
        cam = f"{which} {with_unit(self.size, 'mm')}{f', where {where}' if where else ''}"
        return f", within the range of {self.size_range}; {cam}"


def find_infeasibility(problem: Problem, bounds: SizeBounds, until: float = inf) -> Infeasibility:
    """The limits that no design within bounds meets.

    After ``until`` (``clock.now``) more limits may be named together than it takes to stop them.
    """
    problem = at_rounding_error(problem)
    return replace(_feasible_beyond_range(problem, bounds, until), cause=_blocking_limits(problem, bounds, until))


def join_infeasibilities(reasons: Mapping[str, Infeasibility]) -> str:
    """The reasons of boxes of sizes, by what each box has of them in words; those that are alike only once.

    Of the cams beyond a range the smallest is told.
    """
    alike: dict[tuple[str, str], list[str]] = {}
    for where, each in reasons.items():
        alike.setdefault((each.cause, each.size_range), []).append(where)
    texts = []
    for (stopped_by, _), places in alike.items():
        best = min(places, key=lambda where: reasons[where].size)
        here = f", where {join_words(places, MOST_LISTED_BOXES)}" if len(alike) > 1 else ""
        texts.append(f"{stopped_by}{here}{reasons[best].range_in_words(best)}")
    return "; ".join(texts)


def _blocking_limits(problem: Problem, bounds: SizeBounds, until: float) -> str:
    grid = coarse_grid(replace(problem, limits=()), bounds, problem.programme.lift, FEW_GRID_VALUES)
    if not problem.setup.mechanism.can_assemble(grid, problem.programme).any():
        return f"assembly: {problem.setup.mechanism.assembly}"
    first = (
        problem.without_deferred_limits.limits
    )  # those that are asked last are asked of designs that hold all others
    alone = [limit.name for limit in first if _limits_exclude_all([limit], problem, bounds, until)]
    if alone:
        return ", ".join(alone)
    together = irreducible_set(problem.limits, lambda some: not _limits_exclude_all(some, problem, bounds, until))
    names = [limit.name for limit in together]
    if len(names) == 1:
        return names[0]
    return f"{join_names(names)} together{' or some of them (not proved which)' if clock_seconds() > until else ''}"


def _feasible_beyond_range(problem: Problem, bounds: SizeBounds, until: float) -> Infeasibility:
    """The range of the cam's size, if one is given and a cam beyond it is feasible."""
    low, high = bounds["size"]
    answer = solve_smallest_cam(problem, {**bounds, "size": (0.0, inf)}, until) if high < inf else None
    if answer is None or answer.design is None:
        return Infeasibility("")
    key, size = problem.setup.mechanism.body.size, round_size_up(answer.size)
    ends = (
        with_unit(high, "mm")
        if low == high
        else f"{number_text(to_shown_unit(low, 'mm'))} to {with_unit(high, 'mm')}"
    )
    return Infeasibility("", f"{key} ({ends})", size, answer.is_proved)


def round_size_up(size: float) -> float:
    """A size to six digits, no smaller but for 1e-9 of it."""
    unit = 10.0 ** (floor(log10(size)) + 1 - REASON_DIGITS)
    return ceil(size / unit * (1.0 - 1e-9)) * unit


def _limits_exclude_all(limits: Sequence[Limit], problem: Problem, bounds: SizeBounds, until: float) -> bool:
    """Whether it is proved that no design holds these limits."""
    relaxed = replace(problem, limits=tuple(limits))
    if search_coarse_grid(relaxed, bounds, FEW_GRID_VALUES, until).design is not None:
        return False
    answer = solve_smallest_cam(relaxed, bounds, until)
    return answer.design is None and answer.is_proved


def join_names(names: Iterable[str]) -> str:
    """Names as a sentence lists them: a, b and c."""
    *most, last = list(names) or [""]
    return f"{', '.join(most)} and {last}" if most else last
