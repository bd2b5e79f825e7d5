"""The problems of a space: every choice of laws; and the numbers of the scene, no sizes, that a search varies.

Designs bring these numbers as they bring their sizes. A setting is one choice of all of them: there is a problem
for each setting only of what decides which limits there are.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics.identity_key import IdentityKey
from camopt.model.effects import missing_keys_by_quantity
from camopt.model.motion.programme import Programme
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.search_space import LawPair
from camopt.scene.problem.tolerance_zones import train_entries

MOST_SETTINGS = 10_000  # of which each has problems of its own, one for each motion

NumberSetting = Mapping[str, float]
"""Values of numbers of the scene that are no sizes, by key."""


def law_choices(problem: Problem) -> Mapping[Programme, LawPair]:
    """The scene's programme under every choice of laws in ``[search]``, and the laws on its rises and returns."""
    return _cached_law_choices(IdentityKey(problem))


@lru_cache(maxsize=4)  # of a scene they are asked for again and again
def _cached_law_choices(same: IdentityKey[Problem]) -> Mapping[Programme, LawPair]:
    return {same.value.follower_motion_with_laws(*pair): pair for pair in same.value.search_space.laws}


def problems_by_motion(problem: Problem, settings: Sequence[NumberSetting] = ({},)) -> tuple[Problem, ...]:
    """The problem under every choice of laws in ``[search]``, and in each of some settings, these faster.

    Raises
    ------
    BadInput
        If a quantity that the problem calls for cannot be computed in one of the settings.
    """
    problems = problems_in_settings(problem, settings)
    return tuple(
        each.with_programme(programme)
        if each.programme is problem.programme
        else each.with_given_motion(each.given_motion_with_laws(*pair))
        for programme, pair in law_choices(problem).items()
        for each in problems
    )


def problem_with_free_numbers(problem: Problem, ends: Mapping[str, tuple[float, float]] | None = None) -> Problem:
    """The problem of designs that bring the numbers which its ``[search]`` varies, and those that tolerances move.

    Other ends of a number, by key, may be given in place of those in ``[search]``.

    Raises
    ------
    BadInput
        If a quantity that the problem calls for cannot be computed with the least of one of the numbers.
    """
    return (
        _cached_free_problem(IdentityKey(problem))
        if ends is None
        else _with_free_numbers(problem, {**_search_ranges(problem), **ends})
    )


@lru_cache(maxsize=4)  # designs of a scene are evaluated again and again
def _cached_free_problem(same: IdentityKey[Problem]) -> Problem:
    return _with_free_numbers(same.value, _search_ranges(same.value))


def _search_ranges(problem: Problem) -> dict[str, tuple[float, float]]:
    return {each.key: each.range_ends for each in problem.search_space.numbers if each.varies_by_design}


def with_toleranced_numbers(problem: Problem) -> Problem:
    """The problem whose design has the numbers with tolerances; raises as ``problem_with_free_numbers``."""
    return _with_free_numbers(problem, {})


def _with_free_numbers(problem: Problem, searched: Mapping[str, tuple[float, float]]) -> Problem:
    brought = problem.zones.keys() - problem.design.sizes.keys() - train_entries(problem.zones).keys()
    zones = {key: each for key, each in problem.zones.items() if key in brought}
    own = {key: problem.nominal_numbers[key] for key in zones if key not in searched}
    ends = {**searched, **{key: (value, value) for key, value in own.items()}}
    if not ends:
        return problem
    for key, zone in zones.items():
        ends[key] = ends[key][0] + zone.lower, ends[key][1] + zone.upper
    problems_in_settings(problem, [{key: least for key, (least, _) in ends.items()}])
    freed = problem.with_free_numbers({key: largest for key, (_, largest) in ends.items()})
    return replace(freed, design=freed.design.with_values({key: np.array([value]) for key, value in own.items()}))


def problems_in_settings(problem: Problem, settings: Iterable[NumberSetting]) -> list[Problem]:
    """The problem in some settings; raises as ``problems_by_motion``."""
    problems = [problem.with_numbers(setting) for setting in settings]
    if mistakes := list(_zero_number_mistakes(problem, problems)):
        raise BadInput(mistakes)
    return problems


def _zero_number_mistakes(problem: Problem, problems: Iterable[Problem]) -> Iterator[Mistake]:
    """A mistake for each number that is 0 in some settings where a wanted quantity needs more, as jamming does."""
    wanted, found = problem.evaluated_quantities, dict[str, set[str]]()
    for each in problems:
        for name, keys in missing_keys_by_quantity(each.setup).items():
            for key in keys if name in wanted else ():
                found.setdefault(key, set()).add(name)
    for key, names in found.items():
        needed = f"{', '.join(sorted(names))} {'need' if len(names) > 1 else 'needs'} it"
        yield Mistake(problem.file, f"search.{key}", 0.0, f"above 0: {needed}")


def setting_count_mistakes(problem: Problem, count: int) -> list[Mistake]:
    """A mistake if there are more settings than there can be problems for."""
    allowed = f"ranges and lists of at most {MOST_SETTINGS:,} combinations of numbers that are taken one by one"
    why = f"{allowed}; these have {count:,}"
    return [Mistake(problem.file, "search", None, why)] if count > MOST_SETTINGS else []


def given_profile_mistakes(problem: Problem, what: str) -> list[Mistake]:
    """A mistake if the cam is given by its profile, for those that look for another size, or another motion."""
    why = f"{what} cannot change, for the profile of the cam is given"
    return [Mistake(problem.file, "profile", None, why, bare=True)] if problem.profile else []
