"""What ``[search]`` leaves open of a scene, as searches take it."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

from camopt.model.mechanisms import FIELDS, SECOND_FIELDS
from camopt.model.motion.segments import MotionSegment
from camopt.scene.problem.variables import Variable, angle_variables
from camopt.scene.search import Search

LawPair = tuple[str | None, str | None]
"""The names of the laws of rises and of returns; None keeps those of the scene."""


class SearchSpace(NamedTuple):
    """What a search may choose, and how many designs it is to draw."""

    variables: Mapping[str, Variable]
    """What it varies, by field of boxes: sizes, the slowest of a sweep first, other numbers, angles of segments."""
    laws: tuple[LawPair, ...]
    samples: int | None
    """How many designs are drawn; None for a grid."""
    sampler: str
    """How they are drawn."""
    seed: int
    """Which of all such draws."""

    @property
    def sizes(self) -> list[Variable]:
        return [each for each in self.variables.values() if each.is_size]

    @property
    def numbers(self) -> list[Variable]:
        """Other numbers of the scene."""
        return [each for each in self.variables.values() if each.is_number]

    @property
    def trains(self) -> list[Variable]:
        """Those of them that are numbers of the train."""
        return [each for each in self.numbers if each.role == "train"]

    @property
    def angles(self) -> list[Variable]:
        return [each for each in self.variables.values() if each.role == "angle"]


def search_space_of(
    search: Search, variables: Sequence[Variable], segments: Sequence[MotionSegment]
) -> SearchSpace:
    """The choices that ``[search]`` gives of the variables of a scene, and of the angles of its segments."""
    pairs: list[LawPair] = [(law, law) for law in search.law]
    order = {name: place for place, name in enumerate((*FIELDS, *SECOND_FIELDS, *search.numbers))}
    varied = sorted((each for each in variables if each.is_searched), key=lambda each: order[each.name])
    return SearchSpace(
        variables={each.field: each for each in (*varied, *angle_variables(search, segments))},
        laws=tuple(pairs or product(search.law_rise or (None,), search.law_return or (None,))),
        samples=search.samples,
        sampler=search.sampler,
        seed=search.seed,
    )
