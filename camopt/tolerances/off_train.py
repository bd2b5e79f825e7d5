"""What the errors of a follower are at the tool, through a train whose links may be off too.

A follower that should stand at s(θ) stands at s + δ, and its train is f* in place of f:

    ε = Δ₀,    ε' = Δ₁·(s' + δ') + f'·δ',    ε'' = Δ₂·(s' + δ')² + f''·(2s' + δ')·δ' + Δ₁·(s'' + δ'') + f'·δ''

with f* and its derivatives at s + δ less those of f at s, which are small as the errors are:

    Δ_k = f*⁽ᵏ⁾(s + δ) − f⁽ᵏ⁾(s) ∈ f*⁽ᵏ⁺¹⁾·δ + Σ ∂f*⁽ᵏ⁾/∂p·δp

on the ranges between both (the mean value theorem), and at a point as they are.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import factorial
from typing import Any

import numpy as np

from camopt.motion.driven import tool_position
from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Sloped, at_point, by_chain, range_of
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train
from camopt.tolerances.ranges import from_0, none_of, plain, still

Off = Mapping[str, Interval]
"""By how much links are off, by key of the scene."""


def through(
    problem: Problem, errors: Mapping[str, Any], errors_of_follower: Sequence[Any], asked: Callable[[int], Any]
) -> Any:
    """The error of the tool of the last order, from those of a follower up to it, and its motion that is asked."""
    found = [each.divided() if hasattr(each, "divided") else each for each in errors_of_follower]
    order = len(found) - 1
    if problem.setup.train is None:
        return found[order]
    motion = [asked(k) for k in range(order + 1)]
    links = _links(problem, errors, motion[0])
    if (ratio := _constant_ratio(problem, links)) is not None:
        return found[order] * ratio
    off = OffTrain(problem, links, found[0], motion[0], order)
    if order == 0:
        return off.differs(0)
    speed = motion[1] + found[1]
    if order == 1:
        return off.differs(1) * speed + off.slope(1) * found[1]
    bent = off.slope(2) * (motion[1] * 2.0 + found[1]) * found[1] + off.slope(1) * found[2]
    return off.differs(2) * np.square(speed) + off.differs(1) * (motion[2] + found[2]) + bent


def between(problem: Problem, errors: Mapping[str, Any], first: Any, second: Any, stands: Sloped) -> Any:
    """f*(s + δ₁) − f*(s + δ₂), of a follower that should stand at s: by the mean value theorem."""
    further, start = first - second, stands + second
    if problem.setup.train is None:
        return further
    links = _links(problem, errors, stands)
    if (ratio := _constant_ratio(problem, links)) is not None:
        return further * ratio
    tower, apart = _Tower(problem), range_of(further)
    places, off = range_of(start) + from_0(apart), {key: range_of(each) for key, each in links.items()}
    slopes, off_at = tower.derivatives(places, off, 3), {key: at_point(each) for key, each in links.items()}
    ends = [tower.derivatives(at_point(each), off_at, 1)[0] for each in (start + further, start)]
    by_links = [(each, tower.derivatives(places, off, 2, key)[1] * apart) for key, each in links.items()]
    parts = [(further, slopes[1]), (start, slopes[2] * apart), *by_links]
    return by_chain(slopes[1] * apart, ends[0] - ends[1], parts)


def _links(problem: Problem, errors: Mapping[str, Any], like: Sloped) -> dict[str, Sloped]:
    """By how much links are off."""
    return {key: plain(each, like) for key, each in errors.items() if is_of_train(key)}


def _constant_ratio(problem: Problem, links: Mapping[str, Sloped]) -> float | None:
    """That of a train whose links are not off, if it has one."""
    train = problem.setup.train
    assert train is not None
    return None if links else train.constant_ratio


@dataclass(frozen=True)
class OffTrain:
    """A train whose links may be off, of a follower that is off by an error from where it stands."""

    problem: Problem
    links: Mapping[str, Sloped]
    error: Sloped
    stands: Sloped
    order: int

    def differs(self, order: int) -> Sloped:
        """Δ_k."""
        parts = [(self.error, self._between[order + 1]), (self.stands, self._near(order + 1))]
        parts += [(each, self._by_link[key][order]) for key, each in self.links.items()]
        return by_chain(self._near(order), self._real_at[order] - self._asked_at[order], parts)

    def slope(self, order: int) -> Sloped:
        """The derivative of f where the follower should stand."""
        return by_chain(self._asked[order], self._asked_at[order], [(self.stands, self._asked[order + 1])])

    def _near(self, order: int) -> Interval:
        """By how much a derivative differs, on ranges."""
        found = self._between[order + 1] * range_of(self.error)
        for key, each in self.links.items():
            found = found + self._by_link[key][order] * range_of(each)
        return as_interval(found)

    @property
    def _from_asked(self) -> tuple[Interval, Off]:
        """From where the follower should stand to where it does, and links."""
        off = {key: from_0(range_of(each)) for key, each in self.links.items()}
        return range_of(self.stands) + from_0(range_of(self.error)), off

    @cached_property
    def _between(self) -> list[Interval]:
        return _Tower(self.problem).derivatives(*self._from_asked, self.order + 3)

    @cached_property
    def _by_link(self) -> dict[str, list[Interval]]:
        ends, count = self._from_asked, self.order + 2
        return {key: _Tower(self.problem).derivatives(*ends, count, key) for key in self.links}

    @cached_property
    def _asked(self) -> list[Interval]:
        none = {key: none_of(range_of(each)) for key, each in self.links.items()}
        return _Tower(self.problem).derivatives(range_of(self.stands), none, self.order + 2)

    @cached_property
    def _asked_at(self) -> list[Interval]:
        none = {key: none_of(at_point(each)) for key, each in self.links.items()}
        return _Tower(self.problem).derivatives(at_point(self.stands), none, self.order + 1)

    @cached_property
    def _real_at(self) -> list[Interval]:
        off = {key: at_point(each) for key, each in self.links.items()}
        return _Tower(self.problem).derivatives(at_point(self.stands) + at_point(self.error), off, self.order + 1)


@dataclass(frozen=True)
class _Tower:
    """The derivatives of trains by where their follower stands."""

    problem: Problem

    def derivatives(self, place: Interval, off: Off, count: int, key: str = "") -> list[Interval]:
        """f, f', … on ranges; or with a key those of ∂f/∂p of that number."""
        nominal, start = self.problem.nominal, follower_start(self.problem)
        made: dict[str, Any] = {each: still(nominal[each] + by) for each, by in off.items()}
        none = still(none_of(place))
        stands: Any = Taylor([still(start + place), none + 1.0, *[none] * count][:count])
        if key:
            made[key] = Taylor([made[key], 1.0])
            stands = Taylor([stands, stands * 0.0])
        train = self.problem.trains(made) if made else self.problem.setup.train
        assert train is not None
        found = train.tool(stands)
        terms = (found.terms[1] if key else found).terms
        return [range_of(each) * float(factorial(k)) for k, each in enumerate(terms)]


def follower_start(problem: Problem) -> float:
    """The displacement of the follower from the start position of its train, where that of the turn is 0."""
    programme, first, train = problem.programme, np.zeros(1), problem.setup.train
    assert train is not None
    return float((train.follower_at(tool_position(programme, first)) - programme.at(first)[0])[0])
