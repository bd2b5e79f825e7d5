"""The search space of a scene: the variables and laws that ``[search]`` varies."""

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
    """Variables and laws of a search, and the number of designs to draw."""

    variables: Mapping[str, Variable]
    """Variables by field of boxes: sizes (the slowest of a sweep first), other numbers, angles of segments."""
    laws: tuple[LawPair, ...]
    samples: int | None
    """Number of designs to draw; None for a grid."""
    sampler: str
    """Method of drawing, a key of ``sample.SAMPLERS``."""
    seed: int
    """Seed of the random draw."""

    @property
    def sizes(self) -> list[Variable]:
        return [each for each in self.variables.values() if each.is_size]

    @property
    def numbers(self) -> list[Variable]:
        """The variables that are other numbers of the scene."""
        return [each for each in self.variables.values() if each.is_scene_number]

    @property
    def trains(self) -> list[Variable]:
        """The variables that are numbers of the train."""
        return [each for each in self.numbers if each.role == "train"]

    @property
    def angles(self) -> list[Variable]:
        return [each for each in self.variables.values() if each.role == "angle"]


def search_space_of(
    search: Search, variables: Sequence[Variable], segments: Sequence[MotionSegment]
) -> SearchSpace:
    """The search space of a scene, from its ``[search]``, variables and segments."""
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
