"""The reason why no design within bounds is feasible, in words.

These are, in this order: parts that cannot be put together; each limit that no design holds; limits that can each
be held, but not together. And the range of the cam's size, if a cam of another size is feasible.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, inf, log10

from camopt.core.mistakes import listed_words
from camopt.core.numerics.clock import now
from camopt.core.numerics.irreducible import irreducible
from camopt.core.quantities.unit_systems import shown
from camopt.model.mechanisms.design import SizeBounds
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, exactly
from camopt.solve.smallest.first_look import FEW_VALUES, coarse_grid, first_look
from camopt.solve.smallest.smallest import smallest
from camopt.solve.tables.cells import number, with_unit

DIGITS = 6  # of a size that a reason tells
MOST_BOXES = 3  # whose choices of sizes a reason lists


@dataclass(frozen=True)
class Reason:
    """Why no design within bounds is feasible."""

    stopped_by: str
    """Limits by name, or what keeps parts from being put together."""
    size_range: str = ""
    """The range of the cam's size, where a cam beyond it is feasible."""
    size: float = inf
    """The size of that cam, mm."""
    is_smallest: bool = True
    """Whether that is the smallest one, for certain."""

    def __str__(self) -> str:
        return self.stopped_by + self.beyond()

    def beyond(self, where: str = "") -> str:
        """The range, and the cam beyond it; ``where`` says what other sizes that has."""
        if not self.size_range:
            return ""
        which = "the smallest feasible cam has" if self.is_smallest else "feasible is one of"
        cam = f"{which} {with_unit(self.size, 'mm')}{f', where {where}' if where else ''}"
        return f", within the range of {self.size_range}; {cam}"


def reason(problem: Problem, bounds: SizeBounds, until: float = inf) -> Reason:
    """The limits that no design within bounds meets.

    After ``until`` (``clock.now``) more limits may be named together than it takes to stop them.
    """
    problem = exactly(problem)
    return replace(_beyond(problem, bounds, until), stopped_by=_stopped_by(problem, bounds, until))


def in_one_sentence(reasons: Mapping[str, Reason]) -> str:
    """The reasons of boxes of sizes, by what each box has of them in words; those that are alike only once.

    Of the cams beyond a range the smallest is told.
    """
    alike: dict[tuple[str, str], list[str]] = {}
    for where, each in reasons.items():
        alike.setdefault((each.stopped_by, each.size_range), []).append(where)
    texts = []
    for (stopped_by, _), places in alike.items():
        best = min(places, key=lambda where: reasons[where].size)
        here = f", where {listed_words(places, MOST_BOXES)}" if len(alike) > 1 else ""
        texts.append(f"{stopped_by}{here}{reasons[best].beyond(best)}")
    return "; ".join(texts)


def _stopped_by(problem: Problem, bounds: SizeBounds, until: float) -> str:
    grid = coarse_grid(replace(problem, limits=()), bounds, problem.programme.lift, FEW_VALUES)
    if not problem.setup.mechanism.exists(grid, problem.programme).any():
        return f"assembly: {problem.setup.mechanism.assembly}"
    first = problem.without_last.limits  # those that are asked last are asked of designs that hold all others
    alone = [limit.name for limit in first if _stop([limit], problem, bounds, until)]
    if alone:
        return ", ".join(alone)
    together = irreducible(problem.limits, lambda some: not _stop(some, problem, bounds, until))
    names = [limit.name for limit in together]
    if len(names) == 1:
        return names[0]
    return f"{listed(names)} together{' or some of them (not proved which)' if now() > until else ''}"


def _beyond(problem: Problem, bounds: SizeBounds, until: float) -> Reason:
    """The range of the cam's size, if one is given and a cam beyond it is feasible."""
    low, high = bounds["size"]
    answer = smallest(problem, {**bounds, "size": (0.0, inf)}, until) if high < inf else None
    if answer is None or answer.design is None:
        return Reason("")
    key, size = problem.setup.mechanism.body.size, rounded_up(answer.size)
    ends = with_unit(high, "mm") if low == high else f"{number(shown(low, 'mm'))} to {with_unit(high, 'mm')}"
    return Reason("", f"{key} ({ends})", size, answer.proved)


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


def listed(names: Iterable[str]) -> str:
    """Names as a sentence lists them: a, b and c."""
    *most, last = list(names) or [""]
    return f"{', '.join(most)} and {last}" if most else last
