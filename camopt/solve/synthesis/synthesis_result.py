"""The result of a synthesis: free laws, the smallest cam for them, and the gap to the bound."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from camopt.core.quantities.display import Drawable
from camopt.model.motion import LAWS
from camopt.model.motion.programme import LAW_PEAKS, law_peaks, law_peaks_inside_stroke
from camopt.model.motion.segments import MOVE, MotionSegment
from camopt.model.motion.spline import SplineLaw
from camopt.scene import tables
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.solve.smallest.price import Price, price_table
from camopt.solve.synthesis.problem_from_scene import default_peak_factors
from camopt.solve.synthesis.result_sentences import (
    best_known_in_words,
    bound_in_words,
    broken_limits_in_words,
    default_limits_in_words,
    own_size_limit_in_words,
    reason_for_local_optimum,
    robust_verdict_and_cost_in_words,
)
from camopt.solve.synthesis.term_units import objective_unit
from camopt.solve.tables.designs import Design, designs_table, with_rise_law_as_law_column
from camopt.solve.tables.result import Result, Table, to_json_values

if TYPE_CHECKING:
    from camopt.solve.synthesis.known_law_cams import KnownLawCams

FREE_KINDS = ("rise", "return", MOVE)


@dataclass(frozen=True)
class Synthesis(Result, Drawable):
    """New ("free") motion laws, the smallest cam for them, and a bound for any motion.

    Attributes
    ----------
    asked : Scene
        The scene as given.
    scene : Scene
        The scene with the new laws, the size and the offset.
    design : Design
        The quantities of its cam, as from ``optimise``.
    objective : float
        The minimised value.
    bound : float or None
        Lower bound of the objective for any motion within the convex limits; None if it was not computed.
    convex : bool
        Whether the convex limits alone decide. If not, the laws are a local optimum.
    known : KnownLawCams or None
        The smallest cam of each known law, if it was computed, as the command does.
    prices : list of Price or None
        The result of ``camopt.prices``, if it was computed, as the command does.

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> found = camopt.synthesise(coarse)
    >>> found.bound <= found.objective, list(found.laws)
    (True, ['free-rise', 'free-return'])
    """

    picture = "pictures.new_laws"
    asked: Scene
    scene: Scene
    design: Design
    objective: float
    bound: float | None = None
    convex: bool = True
    known: "KnownLawCams | None" = None
    prices: Sequence[Price] | None = None

    def __repr__(self) -> str:
        known = "" if self.gap is None else f", at most {self.gap:.2%} from the best of any motion"
        return f"<Synthesis of {self.scene.name}: objective {self.objective:.6g}{known}>"

    def table(self, known: Mapping[str, Mapping[str, Any]] | None = None) -> Table:
        """A table of the cams of known laws, if any, and of free laws; * marks a cam that breaks a limit."""
        known = self.known.rows if known is None and self.known else known
        every = [
            dict(row) if row["law_rise"] or row["law_return"] else {**row, "law_rise": law, "law_return": law}
            for law, row in [*(known or {}).items(), ("free moves", self.design)]
        ]
        peaks_by_law = {**{name: law_peaks(law) for name, law in LAWS.items()}, **self.peaks}
        rows: list[dict[str, Any]] = []
        for row in with_rise_law_as_law_column(every):
            star = {} if row.get("within", True) else {name: f"{row[name]} *" for name in ("law", "law_rise")}
            laws = [name for key in ("law_rise", "law_return") for name in row[key].split("+")]
            own_peaks = [peaks_by_law[name] for name in laws if name in peaks_by_law]
            largest = {name: max(float(each[name]) for each in own_peaks) for name in LAW_PEAKS if own_peaks}
            rows.append({**row, **largest, **star})
        peaks = [name for name in rows[0] if name.startswith("peak_")]
        title = f"{self.scene.name}: free laws" + (", and the smallest cam of each known law" if known else "")
        return designs_table(title, resolve(self.scene), rows, [*peaks, "binding"])

    def sections(self) -> Iterator[Table | str]:
        """The table of cams, the default limits, the best known law, the bound with the gap, and the prices."""
        yield self.table()
        if self.known and self.known.broken_limits:
            yield f"* breaks limits of the free laws: {broken_limits_in_words(self.known.broken_limits)}"
        yield from default_limits_in_words(self.asked, default_peak_factors(self.asked))
        yield from filter(None, (own_size_limit_in_words(self), robust_verdict_and_cost_in_words(self.design)))
        if self.known:
            yield best_known_in_words(self, self.known)
        local = "" if self.convex else f" {reason_for_local_optimum(self)}, so the laws are a local optimum."
        yield bound_in_words(self) + local
        if self.prices:
            yield ""
            yield price_table({"": self.prices}, ["limit", "value", "price"], objective_unit(self.asked))

    def values_for_json(self) -> dict[str, Any]:
        """The design, its objective with the bound, the known laws and the prices."""
        known, prices = self.known, self.prices
        laws = {"known_laws": known.rows, "own_law": known.own_law, "best_known_law": known.best} if known else {}
        return {
            **to_json_values(self.design),
            "objective": self.objective,
            "bound": self.bound,
            "gap": self.gap,
            "convex": self.convex,
            "peaks": self.peaks,
            "default_peaks": default_peak_factors(self.asked),
            **laws,
            **({} if prices is None else {"prices": prices}),
        }

    @property
    def relative_half_width(self) -> float:
        """Relative half-width of the design's enclosures."""
        return float(self.design["relative_half_width"])

    @property
    def gap(self) -> float | None:
        """Largest possible improvement by another motion, as a share of the objective; None without a bound."""
        return None if self.bound is None else max(0.0, 1.0 - self.bound / self.objective)

    @cached_property
    def laws(self) -> dict[str, SplineLaw]:
        """The free laws, by name."""
        names = free_law_names(self.scene.motion)
        return {n: law for n, law in resolve(self.scene).laws.items() if n in names and isinstance(law, SplineLaw)}

    @cached_property
    def peaks(self) -> dict[str, dict[str, float | str]]:
        """Peak factors of each free law of a rise or return.

        Peaks count inside the law only: a law that meets another one has no dwells around it.
        """
        moves = {segment.law for segment in self.scene.motion if segment.segment == MOVE}
        return {
            name: {**law_peaks(law), **law_peaks_inside_stroke(law)}
            for name, law in self.laws.items()
            if name not in moves
        }


def free_law_names(segments: Sequence[tables.Segment] | Sequence[MotionSegment]) -> list[str]:
    """Names of the free laws of a turn's rises, returns and moves, in order."""
    kinds = [segment.segment for segment in segments if segment.segment in FREE_KINDS]
    counts = [kinds[: n + 1].count(kind) for n, kind in enumerate(kinds)]
    return [f"free-{k}-{n}" if kinds.count(k) > 1 else f"free-{k}" for k, n in zip(kinds, counts, strict=True)]
