"""Margins of limits: what tolerances leave of them, over all cams whose sizes are within their zones.

Each of these cams is one of its own: it has the motion that is asked, with its own sizes. (How far the motion of a
profile is off that was made for other sizes, is the other question: ``tolerances.tolerance``.) The worst cam is
looked for at the corners of the box of sizes; the proof that none in it is worse (``verdicts.limit_boxes``) finds a
cam that is, if there is one.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite
from typing import NamedTuple

from camopt.mechanisms import FIELDS, Designs
from camopt.numerics import FloatArray
from camopt.numerics.clock import now
from camopt.problem.limit import Limit, QuantityLimit
from camopt.problem.problem import Problem, exactly
from camopt.problem.zones import all_moved, corners, size_zones
from camopt.quantities import QUANTITIES
from camopt.quantities.unit_systems import shown
from camopt.scene.scene import Scene
from camopt.scene.tolerances import Zone
from camopt.tables.cells import number, with_unit
from camopt.tables.layout import NUMERIC, Cell, Table
from camopt.tolerances.limited import is_of_errors, limited, worst_of
from camopt.verdicts.claim_boxes import Ends
from camopt.verdicts.limit_boxes import limit_over_box
from camopt.verdicts.words import BROKEN, HELD

GAPS = (1e-9, 1e-6, 1e-3)
"""Relative, of the worst value: by no more than this a cam may be worse, the first that is proved."""
WORSE = 8
"""How often a worse cam than the worst so far is taken for it."""
SECONDS = 20.0
"""For the proofs of a limit."""


class Margin(NamedTuple):
    """A limit, and what all cams within the tolerances of their sizes have of its quantity at worst.

    Examples
    --------
    >>> scene = camopt.find_scene("rocker-valve").replace(**{"tolerances.follower.arm_length": 0.05})
    >>> margin = camopt.tolerance(scene).margins[0]
    >>> margin.limit, round(margin.nominal, 3), round(margin.worst, 3), margin.verdict
    ('pressure_angle', 24.493, 24.604, 'held')
    """

    limit: str
    quantity: str
    """The quantity that it bounds; "" of one without a quantity."""
    relation: str
    bound: float
    """In the unit of the quantity."""
    nominal: float
    worst: float
    """Of the cam that is the worst found (``sizes``)."""
    gap: float | None
    """By how much a cam within the tolerances may be worse, proved; None if that is not known."""
    verdict: str
    """Whether every cam holds the limit: held or broken, both proved, or undecided."""
    sizes: dict[str, float]
    """Those of the worst cam that have tolerances, by key of the scene, mm."""


@dataclass(frozen=True)
class Box:
    """The cams within the tolerances of the sizes of a scene."""

    scene: Scene
    problem: Problem

    @classmethod
    def of(cls, scene: Scene, problem: Problem) -> "Box":
        return cls(scene, exactly(problem))

    @cached_property
    def margins(self) -> tuple[Margin, ...]:
        """The margin of each limit; none without tolerances of sizes."""
        return tuple(self._margins()) if self.ends else ()

    @cached_property
    def zones(self) -> dict[str, Zone]:
        """The zones of sizes, by field."""
        found = size_zones(self.scene, self.problem.design)
        return {FIELDS[key]: zone for key, zone in found.items()}

    @cached_property
    def ends(self) -> Ends:
        """Between which values sizes are, by field."""
        nominal = {field: float(self.problem.design.sizes[field][0]) for field in self.zones}
        return {f: (nominal[f] + zone.lower, nominal[f] + zone.upper) for f, zone in self.zones.items()}

    @cached_property
    def tried(self) -> Designs:
        """The design itself, and those at the corners."""
        return all_moved(self.problem.design, [{}, *corners(self.zones)])

    def _margins(self) -> Iterator[Margin]:
        keys = {FIELDS[key]: f"follower.{key}" for key in size_zones(self.scene, self.problem.design)}
        for limit in self.problem.limits:
            if is_of_errors(limit):
                continue
            excess, values = self._found(limit, self.tried)
            place = worst_of(limit, excess, values)
            verdict = self._verdict(limit, float(excess.max()))
            witness, worst, gap = self._proved(limit, self.tried.take([place]), float(values[place]))
            name = limit.shown[0] if limit.shown else ""
            sizes = {key: float(witness.sizes[field][0]) for field, key in keys.items()}
            nominal = float(values[0])
            yield Margin(limit.name, name, limit.relation, limit.bound, nominal, worst, gap, verdict, sizes)

    def _found(self, limit: Limit, designs: Designs) -> tuple[FloatArray, FloatArray]:
        """The excess of designs over a limit, and its quantity."""
        excess, values = limited(self.problem, [limit], designs)
        return excess[0], values[0]

    def _verdict(self, limit: Limit, excess: float) -> str:
        """Whether all cams hold a limit, of which the worst at a corner has an excess."""
        if excess > 0.0:
            return BROKEN
        return limit_over_box(self.problem, limit, self.problem.design, self.ends, now() + SECONDS).verdict

    def _proved(self, limit: Limit, witness: Designs, worst: float) -> tuple[Designs, float, float | None]:
        """The worst cam, its quantity, and by how much others may be worse."""
        if not isinstance(limit, QuantityLimit) or not isfinite(worst):
            return witness, worst, None
        if limit.is_of_motion:
            return witness, worst, 0.0
        side, until = QUANTITIES[limit.quantities[0]].side, now() + SECONDS
        gaps = iter(GAPS)
        share = next(gaps)
        for _ in range(WORSE):
            gap = share * (abs(worst) or 1.0)
            easier = replace(limit, bound=worst + side * gap)
            answer = limit_over_box(self.problem, easier, self.problem.design, self.ends, until)
            if answer.verdict == HELD:
                return witness, worst, gap
            if answer.witness is not None:
                value = float(self._found(limit, answer.witness)[1][0])
                if side * (value - worst) > 0.0:
                    witness, worst = answer.witness, value
                    continue
            if (larger := next(gaps, None)) is None:
                break
            share = larger
        return witness, worst, None


def margins_table(scene: Scene, margins: tuple[Margin, ...]) -> Table:
    """The limits with the nominal cam's quantity, that of the worst cam, and whether every cam holds them."""
    heads = ["limit", "bound", "nominal", "worst", "every cam", "worst cam"]
    rows = []
    for each in margins:
        unit = QUANTITIES[each.quantity].unit if each.quantity else ""
        bound = f"{each.relation} {with_unit(each.bound, unit)}" if each.quantity else ""
        values = [number(shown(v, unit)) if each.quantity else "" for v in (each.nominal, each.worst)]
        sizes = ", ".join(f"{key.partition('.')[2]} {with_unit(v, 'mm')}" for key, v in each.sizes.items())
        differs = each.quantity and each.worst != each.nominal
        rows.append([each.limit, bound, *values, each.verdict, sizes if differs else ""])
    kinds = [Cell(head, NUMERIC if head in ("nominal", "worst") else "") for head in heads]
    return Table.of(f"{scene.name}: limits within the tolerances of sizes", kinds, rows)
