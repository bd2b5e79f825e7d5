"""The problems of a space: every choice of laws; and the numbers of the scene, no sizes, that a search varies.

Designs bring these numbers as they bring their sizes. A setting is one choice of all of them: there is a problem
for each setting only of what decides which limits there are.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics.same import Same
from camopt.model.effects import lacking
from camopt.model.motion.programme import Programme
from camopt.scene.problem.choices import LawPair
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.zones import of_train

MOST_SETTINGS = 10_000  # of which each has problems of its own, one for each motion

Setting = Mapping[str, float]
"""Values of numbers of the scene that are no sizes, by key."""


def laws_of(problem: Problem) -> Mapping[Programme, LawPair]:
    """The scene's programme under every choice of laws in ``[search]``, and the laws on its rises and returns."""
    return _laws_of(Same(problem))


@lru_cache(maxsize=4)  # of a scene they are asked for again and again
def _laws_of(same: Same[Problem]) -> Mapping[Programme, LawPair]:
    return {same.value.with_laws(*pair): pair for pair in same.value.choices.laws}


def problems_of(problem: Problem, settings: Sequence[Setting] = ({},)) -> tuple[Problem, ...]:
    """The problem under every choice of laws in ``[search]``, and in each of some settings, these faster.

    Raises
    ------
    BadInput
        If a quantity that the problem calls for cannot be computed in one of the settings.
    """
    problems = in_settings(problem, settings)
    return tuple(
        each.with_programme(programme) if each.programme is problem.programme else each.moving(each.asked_by(*pair))
        for programme, pair in laws_of(problem).items()
        for each in problems
    )


def freed_of(problem: Problem, ends: Mapping[str, tuple[float, float]] | None = None) -> Problem:
    """The problem of designs that bring the numbers which its ``[search]`` varies, and those that tolerances move.

    Other ends of a number, by key, may be given in place of those in ``[search]``.

    Raises
    ------
    BadInput
        If a quantity that the problem calls for cannot be computed with the least of one of the numbers.
    """
    return _freed_of(Same(problem)) if ends is None else _freed(problem, {**_searched_ends(problem), **ends})


@lru_cache(maxsize=4)  # designs of a scene are evaluated again and again
def _freed_of(same: Same[Problem]) -> Problem:
    return _freed(same.value, _searched_ends(same.value))


def _searched_ends(problem: Problem) -> dict[str, tuple[float, float]]:
    return {each.key: each.ends for each in problem.choices.numbers if each.is_ranged}


def toleranced(problem: Problem) -> Problem:
    """The problem whose design brings the numbers that its tolerances move; raises as ``freed_of``."""
    return _freed(problem, {})


def _freed(problem: Problem, searched: Mapping[str, tuple[float, float]]) -> Problem:
    brought = problem.zones.keys() - problem.design.sizes.keys() - of_train(problem.zones).keys()
    zones = {key: each for key, each in problem.zones.items() if key in brought}
    own = {key: problem.nominal[key] for key in zones if key not in searched}
    ends = {**searched, **{key: (value, value) for key, value in own.items()}}
    if not ends:
        return problem
    for key, zone in zones.items():
        ends[key] = ends[key][0] + zone.lower, ends[key][1] + zone.upper
    in_settings(problem, [{key: least for key, (least, _) in ends.items()}])
    freed = problem.freed({key: largest for key, (_, largest) in ends.items()})
    return replace(freed, design=freed.design.with_values({key: np.array([value]) for key, value in own.items()}))


def in_settings(problem: Problem, settings: Iterable[Setting]) -> list[Problem]:
    """The problem in some settings; raises as ``problems_of``."""
    problems = [problem.with_numbers(setting) for setting in settings]
    if mistakes := list(_lacking(problem, problems)):
        raise BadInput(mistakes)
    return problems


def _lacking(problem: Problem, problems: Iterable[Problem]) -> Iterator[Mistake]:
    """A mistake for each number that is 0 in some settings where a wanted quantity needs more, as jamming does."""
    wanted, found = problem.wanted, dict[str, set[str]]()
    for each in problems:
        for name, keys in lacking(each.setup).items():
            for key in keys if name in wanted else ():
                found.setdefault(key, set()).add(name)
    for key, names in found.items():
        needed = f"{', '.join(sorted(names))} {'need' if len(names) > 1 else 'needs'} it"
        yield Mistake(problem.file, f"search.{key}", 0.0, f"above 0: {needed}")


def too_many_settings(problem: Problem, count: int) -> list[Mistake]:
    """A mistake if there are more settings than there can be problems for."""
    allowed = f"ranges and lists of at most {MOST_SETTINGS:,} combinations of numbers that are taken one by one"
    why = f"{allowed}; these have {count:,}"
    return [Mistake(problem.file, "search", None, why)] if count > MOST_SETTINGS else []


def given_profile(problem: Problem, what: str) -> list[Mistake]:
    """A mistake if the cam is given by its profile, for those that look for another size, or another motion."""
    why = f"{what} cannot change, for the profile of the cam is given"
    return [Mistake(problem.file, "profile", None, why, bare=True)] if problem.profile else []
