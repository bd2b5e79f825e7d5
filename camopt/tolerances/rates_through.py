"""What the errors of a follower are at the tool, through a train whose links may be off too.

A follower that should stand at s(θ) stands at s + δ, and its train is f* in place of f:

    ε = Δ₀,    ε' = Δ₁·(s' + δ') + f'·δ',    ε'' = Δ₂·(s' + δ')² + f''·(2s' + δ')·δ' + Δ₁·(s'' + δ'') + f'·δ''

with f* and its derivatives at s + δ less those of f at s, which are small as the errors are:

    Δ_k = f*⁽ᵏ⁾(s + δ) − f⁽ᵏ⁾(s) ∈ f*⁽ᵏ⁺¹⁾·δ + Σ ∂f*⁽ᵏ⁾/∂p·δp

on the ranges between both (the mean value theorem), and at a point as they are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import factorial
from typing import Any

import numpy as np

from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Sloped, at_point, by_chain, range_of
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train
from camopt.tolerances.ranges import from_0, none_of, plain, still
from camopt.tolerances.worst_case import Off, follower_start


def through(problem: Problem, errors: Mapping[str, Any], found: Sequence[Sloped], motion: Sequence[Sloped]) -> Any:
    """The error of the tool of the last order, from those of a follower, up to it, and its motion that is asked."""
    train, order = problem.setup.train, len(found) - 1
    links = {key: plain(each, motion[0]) for key, each in errors.items() if is_of_train(key)}
    assert train is not None
    if not links and (ratio := train.constant_ratio) is not None:
        return found[order] * ratio
    off = RatesThrough(problem, links, found[0], motion[0], order)
    if order == 0:
        return off.differs(0)
    speed = motion[1] + found[1]
    if order == 1:
        return off.differs(1) * speed + off.slope(1) * found[1]
    bent = off.slope(2) * (motion[1] * 2.0 + found[1]) * found[1] + off.slope(1) * found[2]
    return off.differs(2) * np.square(speed) + off.differs(1) * (motion[2] + found[2]) + bent


class RatesThrough:
    """A train whose links may be off, of a follower that is off by an error from where it stands."""

    def __init__(
        self, problem: Problem, links: Mapping[str, Sloped], error: Sloped, stands: Sloped, order: int
    ) -> None:
        self.error, self.stands, self.links = error, stands, links
        self._tower, count = _Tower(problem), order + 3
        place, off = range_of(stands), {key: range_of(each) for key, each in links.items()}
        ends = place + from_0(range_of(error)), {key: from_0(each) for key, each in off.items()}
        self._between = self._tower.derivatives(*ends, count)
        self._by_link = {key: self._tower.derivatives(*ends, count, key) for key in links}
        none = {key: none_of(each) for key, each in off.items()}
        self._asked = self._tower.derivatives(place, none, count)
        point = at_point(stands)
        self._asked_at = self._tower.derivatives(
            point, {key: at_point(each) * 0.0 for key, each in links.items()}, count
        )
        at = {key: at_point(each) for key, each in links.items()}
        self._real_at = self._tower.derivatives(point + at_point(error), at, count)

    def differs(self, order: int) -> Sloped:
        """Δ_k."""
        point = self._real_at[order] - self._asked_at[order]
        parts: list[tuple[Any, Any]] = [
            (self.error, self._between[order + 1]),
            (self.stands, self._near(order + 1)),
        ]
        parts += [(each, self._by_link[key][order]) for key, each in self.links.items()]
        return by_chain(self._near(order), point, parts)

    def slope(self, order: int) -> Sloped:
        """The derivative of f where the follower should stand."""
        return by_chain(self._asked[order], self._asked_at[order], [(self.stands, self._asked[order + 1])])

    def _near(self, order: int) -> Interval:
        """By how much a derivative differs, on ranges."""
        found = self._between[order + 1] * range_of(self.error)
        for key, each in self.links.items():
            found = found + self._by_link[key][order] * range_of(each)
        return as_interval(found)


@dataclass(frozen=True)
class _Tower:
    """The derivatives of trains by where their follower stands."""

    problem: Problem

    def derivatives(self, place: Interval, off: Off, count: int, key: str = "") -> list[Interval]:
        """f, f', … on ranges; or with a key those of ∂f/∂p of that number."""
        nominal, start = self.problem.nominal, follower_start(self.problem)
        made: dict[str, Any] = {each: still(nominal[each] + by) for each, by in off.items()}
        none = still(none_of(place))
        stands: Any = Taylor([still(start + place), none + 1.0, *[none] * (count - 2)])
        if key:
            made[key] = Taylor([made[key], 1.0])
            stands = Taylor([stands, stands * 0.0])
        train = self.problem.trains(made) if made else self.problem.setup.train
        assert train is not None
        found = train.tool(stands)
        terms = (found.terms[1] if key else found).terms
        return [range_of(each) * float(factorial(k)) for k, each in enumerate(terms)]
