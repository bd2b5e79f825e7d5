"""The result of a synthesis: free laws, the smallest cam for them, and how good they are."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from camopt.motion import LAWS
from camopt.motion.programme import PEAKS, law_peaks, peaks_inside
from camopt.motion.segments import MOVE, Segment
from camopt.motion.spline import SplineLaw
from camopt.problem.problem import resolve
from camopt.scene import tables
from camopt.scene.scene import Scene
from camopt.shown import Drawn, Shown
from camopt.smallest.prices import Price, prices
from camopt.tables.columns import joined_laws
from camopt.tables.designs import Design

FREE = ("rise", "return", MOVE)


@dataclass(frozen=True)
class Synthesis(Shown, Drawn):
    """New ("free") motion laws, the smallest cam for them, and how good they are.

    Attributes
    ----------
    asked : Scene
        What was given.
    scene : Scene
        The answer, with the new laws, the size and the offset.
    design : Design
        Its quantities, as from ``optimise``.
    objective : float
        What was minimised.
    bound : float or None
        No motion at all that meets the convex limits has an objective below; None if no bound was computed.
    convex : bool
        Whether the convex limits alone decide; if not, the laws are a local optimum.

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> found = camopt.synthesise(coarse)
    >>> found.bound <= found.objective, list(found.laws)
    (True, ['free-rise', 'free-return'])
    """

    picture = "synthesis"
    asked: Scene
    scene: Scene
    design: Design
    objective: float
    bound: float | None = None
    convex: bool = True

    def __repr__(self) -> str:
        known = "" if self.gap is None else f", at most {self.gap:.2%} from the best of any motion"
        return f"<Synthesis of {self.scene.name}: objective {self.objective:.6g}{known}>"

    @property
    def gap(self) -> float | None:
        """The most that any other motion could improve, as a share of the objective; None without a bound."""
        return None if self.bound is None else max(0.0, 1.0 - self.bound / self.objective)

    @cached_property
    def laws(self) -> dict[str, SplineLaw]:
        """The free laws by name."""
        names = free_names(self.scene.motion)
        return {n: law for n, law in resolve(self.scene).laws.items() if n in names and isinstance(law, SplineLaw)}

    @cached_property
    def peaks(self) -> dict[str, dict[str, float | str]]:
        """The peak factors of each free law of a rise or return, inside it: one that meets another has no dwells
        around it.
        """
        moves = {segment.law for segment in self.scene.motion if segment.segment == MOVE}
        unit = {name: law for name, law in self.laws.items() if name not in moves}
        return {name: {**law_peaks(law), **peaks_inside(law)} for name, law in unit.items()}


def peaks_of(row: Mapping[str, Any], result: Synthesis) -> dict[str, float]:
    """The largest peak factors of a row's laws, known or free."""
    peaks = {**{name: law_peaks(law) for name, law in LAWS.items()}, **result.peaks}
    each = [peaks[n] for key in ("law_rise", "law_return") for n in row[key].split("+") if n in peaks]
    return {name: max(float(peaks[name]) for peaks in each) for name in PEAKS if each}


def free_names(segments: Sequence[tables.Segment] | Sequence[Segment]) -> list[str]:
    """Names for the free laws of the rises, returns and moves of a turn, in order."""
    kinds = [segment.segment for segment in segments if segment.segment in FREE]
    counts = [kinds[: n + 1].count(kind) for n, kind in enumerate(kinds)]
    return [f"free-{k}-{n}" if kinds.count(k) > 1 else f"free-{k}" for k, n in zip(kinds, counts, strict=True)]


@prices.register
def _prices_of_free_laws(result: Synthesis, seconds: float | None = None) -> dict[str, list[Price]]:
    """By the laws of the cam, as those of known laws."""
    from camopt.synthesis.prices import prices_of_laws

    return {joined_laws(result.design["law_rise"], result.design["law_return"]): prices_of_laws(result)}
