"""The problems of a search space: one for each motion, and for each setting of shared numbers.

Designs carry most numbers that a search varies, as they carry their sizes. Numbers that decide the motion or the
list of limits are shared by all designs of a problem; a setting is one choice of these.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics.identity_cache import cached_by_identity
from camopt.model.effects import missing_keys_by_quantity
from camopt.model.motion.programme import Programme
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.search_space import LawPair
from camopt.scene.problem.tolerance_zones import entries_of_train_numbers

MOST_SETTINGS = 10_000  # each setting has a problem for every motion

NumberSetting = Mapping[str, float]
"""Values of numbers of the scene other than sizes, by key."""


@cached_by_identity(maxsize=4)  # read many times for a scene
def law_pair_by_programme(problem: Problem) -> Mapping[Programme, LawPair]:
    """The motion for every choice of laws in ``[search]``, with the laws on its rises and returns."""
    return {problem.follower_motion_with_laws(*pair): pair for pair in problem.search_space.laws}


def problems_by_motion_and_setting(
    problem: Problem, settings: Sequence[NumberSetting] = ({},)
) -> tuple[Problem, ...]:
    """The problem for every choice of laws in ``[search]`` and every setting; settings vary fastest.

    Raises
    ------
    BadInput
        If a quantity that the problem needs cannot be computed in a setting.
    """
    problems = problems_in_settings(problem, settings)
    return tuple(
        each.with_programme(programme)
        if each.programme is problem.programme
        else each.with_given_motion(each.given_motion_with_laws(*pair))
        for programme, pair in law_pair_by_programme(problem).items()
        for each in problems
    )


def problem_with_searched_numbers_per_design(
    problem: Problem, search_ends: Mapping[str, tuple[float, float]] | None = None
) -> Problem:
    """The problem whose designs carry the numbers that ``[search]`` varies, and numbers with robust tolerances.

    ``search_ends`` replaces the range ends in ``[search]``, by key.

    Raises
    ------
    BadInput
        If a quantity that the problem needs cannot be computed with the least value of a number.
    """
    return (
        _cached_problem_per_design(problem)
        if search_ends is None
        else _with_numbers_per_design(problem, {**_range_ends_of_searched_numbers(problem), **search_ends})
    )


@cached_by_identity(maxsize=4)  # designs of a scene are evaluated many times
def _cached_problem_per_design(problem: Problem) -> Problem:
    return _with_numbers_per_design(problem, _range_ends_of_searched_numbers(problem))


def _range_ends_of_searched_numbers(problem: Problem) -> dict[str, tuple[float, float]]:
    return {each.key: each.range_ends for each in problem.search_space.numbers if each.varies_by_design}


def with_toleranced_numbers_per_design(problem: Problem) -> Problem:
    """The problem whose design carries the numbers with tolerances.

    It raises as ``problem_with_searched_numbers_per_design``.
    """
    return _with_numbers_per_design(problem, {})


def _with_numbers_per_design(problem: Problem, range_ends_by_key: Mapping[str, tuple[float, float]]) -> Problem:
    carried = problem.zones.keys() - problem.design.sizes.keys() - entries_of_train_numbers(problem.zones).keys()
    zones = {key: each for key, each in problem.zones.items() if key in carried}
    fixed = {key: problem.nominal_numbers[key] for key in zones if key not in range_ends_by_key}
    ends = {**range_ends_by_key, **{key: (value, value) for key, value in fixed.items()}}
    if not ends:
        return problem
    for key, zone in zones.items():
        ends[key] = ends[key][0] + zone.lower, ends[key][1] + zone.upper
    problems_in_settings(problem, [{key: least for key, (least, _) in ends.items()}])
    freed = problem.with_numbers_per_design({key: largest for key, (_, largest) in ends.items()})
    return replace(freed, design=freed.design.with_values({key: np.array([value]) for key, value in fixed.items()}))


def problems_in_settings(problem: Problem, settings: Iterable[NumberSetting]) -> list[Problem]:
    """The problem in each setting; raises as ``problems_by_motion_and_setting``."""
    problems = [problem.with_numbers(setting) for setting in settings]
    wanted, names_by_key = problem.evaluated_quantities, dict[str, set[str]]()
    for each in problems:
        for name, keys in missing_keys_by_quantity(each.setup).items():
            for key in keys if name in wanted else ():  # 0 in this setting, although a quantity needs it
                names_by_key.setdefault(key, set()).add(name)
    needs = {
        key: f"{', '.join(sorted(n))} {'need' if len(n) > 1 else 'needs'} it" for key, n in names_by_key.items()
    }
    if needs:
        raise BadInput(Mistake(problem.file, f"search.{key}", 0.0, f"above 0: {why}") for key, why in needs.items())
    return problems


def too_many_settings_mistakes(problem: Problem, count: int) -> list[Mistake]:
    """A mistake if there are too many settings."""
    allowed = f"ranges and lists with at most {MOST_SETTINGS:,} combinations of train numbers and shaft diameters"
    why = f"{allowed}; these have {count:,}"
    return [Mistake(problem.file, "search", None, why)] if count > MOST_SETTINGS else []


def given_profile_mistakes(problem: Problem, fixed_values_text: str) -> list[Mistake]:
    """A mistake if the cam is given by its profile, for commands that change what ``fixed_values_text`` says."""
    why = f"{fixed_values_text} cannot change, since the scene gives the profile of the cam"
    return [Mistake(problem.file, "profile", None, why, bare=True)] if problem.profile else []
