"""What ``[search]`` leaves open of a scene, as searches take it."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

from camopt.mechanisms import FIELDS
from camopt.scene.choices import Chosen, StepRange
from camopt.scene.search import Search

LawPair = tuple[str | None, str | None]
"""The names of the laws of rises and of returns; None keeps those of the scene."""


@dataclass(frozen=True)
class Choices:
    """What a search may choose, and how many designs it is to draw."""

    sizes: Mapping[str, Chosen]
    """Sizes by key of ``[search]``, the slowest of a sweep first; mm."""
    numbers: Mapping[str, Chosen]
    """Other numbers by their key in the scene, as ``cam.rpm``."""
    laws: tuple[LawPair, ...]
    angles: Mapping[str, StepRange]
    """The angle of each rise, return and dwell, by kind of segment; deg."""
    samples: int | None
    """How many designs are drawn; None for a grid."""
    sampler: str
    """How they are drawn."""
    seed: int
    """Which of all such draws."""


def choices_of(search: Search) -> Choices:
    """The choices that ``[search]`` gives."""
    pairs: list[LawPair] = [(law, law) for law in search.law]
    return Choices(
        sizes={key: search.sizes[key] for key in FIELDS if key in search.sizes},
        numbers=search.numbers,
        laws=tuple(pairs or product(search.law_rise or (None,), search.law_return or (None,))),
        angles=search.angles,
        samples=search.samples,
        sampler=search.sampler,
        seed=search.seed,
    )
