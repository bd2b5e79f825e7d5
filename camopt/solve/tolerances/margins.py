"""Margins of limits: what tolerances leave of them, over all cams whose numbers are within their zones.

Each of these cams is one of its own: it has the motion that is asked, with its own sizes, speed, spring and train.
(How far the motion of a profile is off that was made for other sizes, is the other question:
``tolerances.tolerance``.) The worst cam is looked for at the corners of the box of numbers; the proof that none in
it is worse (``verdicts.limit_boxes``) finds a cam that is, if there is one. Each train moves the follower in
another way: the proof goes over all of their motions (``verdicts.train_boxes``).

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.

What designs have of limits: their excesses and quantities, and which one is the worst.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import now
from camopt.core.quantities import AT_LEAST, QUANTITIES
from camopt.core.quantities.unit_systems import shown
from camopt.model.effects import Case, quantity_of
from camopt.model.effects.contacts import changing, some_of, with_designs
from camopt.model.mechanisms.design import Designs, concatenate
from camopt.scene.problem.limit import Limit, QuantityLimit, needs_of
from camopt.scene.problem.limits import ERROR_LIMITS
from camopt.scene.problem.problem import Problem, exactly, resolve
from camopt.scene.problem.settings import toleranced
from camopt.scene.problem.variables import Variable, variables_of
from camopt.scene.problem.zones import MOST_CORNERED, MOST_LINKS, Off, all_moved, corners, number_zones, of_train
from camopt.scene.scene import Scene
from camopt.scene.tolerances import NUMBERED, Zone
from camopt.solve.tables.cells import number, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Table
from camopt.solve.tolerances.held import INTERFERENCE, NO_INTERFERENCE, Interference
from camopt.solve.verdicts.claim_boxes import Answer, Ends
from camopt.solve.verdicts.judging import excesses
from camopt.solve.verdicts.limit_boxes import ends_within, limit_over_box
from camopt.solve.verdicts.running import run_effects
from camopt.solve.verdicts.train_boxes import enters_train
from camopt.solve.verdicts.words import BROKEN, HELD, UNDECIDED

GAPS = (1e-9, 1e-6, 1e-3)
"""Relative, of the worst value: by no more than this a cam may be worse, the first that is proved."""
WORSE = 8
"""How often a worse cam than the worst so far is taken for it."""
LOST = 1e-6
"""Of the nominal value: with no interference a preload, and what is in proportion to it, is less, which is none."""
SECONDS, TRAIN_SECONDS = 20.0, 5.0
"""For the proofs of a limit, and of one that trains change."""
SAME = 1e-12
"""Values of a quantity that are this near to each other, relative, are the same."""
OWN_SIZES = (
    "Each cam has the motion that is asked, as it would if its profile were cut for its own sizes and numbers."
)
OF_ERRORS = (
    "Limits on errors are of the cam of the first table, which is cut for the nominal sizes, at its nominal speed."
)


class Margin(NamedTuple):
    """A limit, and what all cams within the tolerances of their numbers have of its quantity at worst.

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
    """By how much a cam within the tolerances may be worse, proved.

    None if that is not known: none of up to 0.1 % of the worst was proved in its time (the
    verdict has another), or the limit has no value to be near to (infinite, or of no quantity).
    """
    verdict: str
    """Whether every cam holds the limit: held or broken, both proved, or undecided."""
    sizes: dict[str, float]
    """The numbers of the worst cam that have tolerances, by key of the scene, in its units."""
    moving: tuple[str, ...] = ()
    """Those of them that change the quantity of that cam."""


class Cam(NamedTuple):
    """A cam within tolerances."""

    problem: Problem
    """That of its train."""
    design: Designs
    excess: float
    """The largest over a limit, of all that were tried with this train."""
    value: float
    """Of the quantity of the limit."""


@dataclass(frozen=True)
class Box:
    """The cams within the tolerances of the numbers of a scene."""

    problem: Problem
    """With designs that bring the numbers which have tolerances, but for those of the train."""
    zones: Mapping[str, Zone]
    """Of those numbers, by key of the scene."""
    variables: Mapping[str, Variable]
    apart: Interference | None = None
    """That of two contacts: between the ends of its zone, whatever sizes a cam has, in all that is proved."""

    @classmethod
    def of(cls, scene: Scene, problem: Problem) -> "Box":
        zones, apart = number_zones(scene, problem.nominal), None
        if INTERFERENCE in problem.nominal and problem.setup.mechanism.further:
            apart = Interference.of(scene, problem, problem.nominal[INTERFERENCE], zones.get(INTERFERENCE))
            zones[INTERFERENCE] = apart.zone
        variables = {each.key: each for each in problem.variables if each.key in zones}
        of_fields = {v.field: zones[key] for key, v in variables.items() if v.is_ranged or zones[key].moves}
        return cls(toleranced(exactly(replace(problem, zones=of_fields, offs=()))), zones, variables, apart)

    @cached_property
    def margins(self) -> tuple[Margin, ...]:
        """The margin of each limit; without tolerances of numbers of those on errors alone."""
        return tuple(
            (self.nominal if limit.of_errors else self)._margin(place, limit)
            for place, limit in enumerate(self.problem.limits)
            if limit.of_errors or self.zones
        )

    @cached_property
    def nominal(self) -> "Box":
        """The nominal cam alone, of which errors by tolerances are."""
        return Box(replace(self.problem, zones={}, offs=()), {}, {})

    @cached_property
    def ends(self) -> Ends:
        """Between which values numbers are, by field."""
        return ends_within(self.problem, self.problem.design)

    @cached_property
    def tried(self) -> Designs:
        """The design itself, and those at the corners."""
        return all_moved(self.problem.design, self.offs)

    @cached_property
    def offs(self) -> list[Off]:
        """By how much they are off."""
        return [{}, *corners(self.own)]

    @cached_property
    def own(self) -> dict[str, Zone]:
        """The zones of numbers that designs bring."""
        return {field: zone for field, zone in self.problem.zones.items() if field not in self.of_train}

    @cached_property
    def of_train(self) -> dict[str, Zone]:
        """The zones of numbers of the train."""
        return of_train(self.problem.zones)

    @cached_property
    def train_offs(self) -> list[Off]:
        """By how much these are off that are looked at: at the corners of a few, else each alone."""
        return [{}, *corners(self.of_train, MOST_LINKS)]

    @cached_property
    def trains(self) -> list[Problem]:
        """The problem itself, and those of trains that are off so."""
        return [self.problem.with_numbers_off(off) for off in self.train_offs]

    def _margin(self, place: int, limit: Limit) -> Margin:
        """That of a limit, by its place among all."""
        found = [self._of_train(problem, problem.limits[place]) for problem in self.trains]
        if len(self.of_train) > MOST_LINKS:
            together = self.problem.with_numbers_off(_together(limit, found, self.train_offs, self.of_train))
            found.append(self._of_train(together, together.limits[place]))
        worst, gap = found[_worst(limit, found)], None
        verdict = self._verdict(limit, max(each.excess for each in found))
        worst, gap = self._proved(limit, worst)
        if self.apart is not None:
            made, side = self._made(limit, worst, self.apart), -1.0 if limit.relation == AT_LEAST else 1.0
            gap = None if gap is None else gap + max(side * (worst.value - made.value), 0.0)
            verdict = BROKEN if made.excess > 0.0 else UNDECIDED if verdict == BROKEN else verdict
            worst = made
        name, nominal = limit.shown[0] if limit.shown else "", float(self._found(limit, self.tried)[1][0])
        about = limit.name, name, limit.relation, limit.bound, nominal
        numbers = self._numbers(worst)
        moving = tuple(key for key in numbers if limit.shown and self._matters(limit, worst, key))
        value = 0.0 if _is_lost(numbers) and abs(worst.value) <= LOST * abs(nominal) else worst.value
        return Margin(*about, value, gap, verdict, numbers, moving)

    def _matters(self, limit: Limit, cam: Cam, key: str) -> bool:
        """Whether a number of a cam changes the quantity of a limit; one of the train does."""
        field = self.variables[key].field
        if field not in self.own:
            return not self.variables[key].is_ranged
        nominal = cam.design.with_values({field: self.problem.design.values[field]})
        value = float(self._found(limit, nominal, cam.problem)[1][0])
        return not abs(value - cam.value) <= SAME * abs(cam.value)

    def _of_train(self, problem: Problem, limit: Limit) -> Cam:
        """The worst cam with a train."""
        cams = self.tried
        excess, values = self._found(limit, cams, problem)
        if len(self.own) > MOST_CORNERED:
            each = [Cam(problem, cams, *both) for both in zip(excess, values, strict=True)]
            cams = all_moved(self.problem.design, [*self.offs, _together(limit, each, self.offs, self.own)])
            excess, values = self._found(limit, cams, problem)
        place = worst_of(limit, excess, values)
        return Cam(problem, cams.take([place]), float(excess.max()), float(values[place]))

    def _made(self, limit: Limit, worst: Cam, apart: Interference) -> Cam:
        """The worst of the cams that were tried with a train, each with an interference that its own sizes have."""
        cams, field = concatenate([self.tried, worst.design]), self.variables[INTERFERENCE].field
        nominal = self.problem.design.values
        off = {k: cams.values[v.field] - nominal[v.field] for k, v in self.variables.items() if v.field in self.own}
        cams = cams.with_values({field: np.clip(cams.values[field], *apart.within(off))})
        excess, values = self._found(limit, cams, worst.problem)
        place = worst_of(limit, excess, values)
        return Cam(worst.problem, cams.take([place]), float(excess.max()), float(values[place]))

    def _enters_train(self, limit: Limit) -> bool:
        """Whether trains that are off change a limit."""
        return bool(self.of_train) and enters_train(self.problem, limit)

    def _found(
        self, limit: Limit, designs: Designs, problem: Problem | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """The excess of designs over a limit, and its quantity."""
        excess, values = limited(problem or self.problem, [limit], designs)
        return excess[0], values[0]

    def _numbers(self, cam: Cam) -> dict[str, float]:
        """The numbers of a cam that have tolerances, by key of the scene."""
        own = cam.design.values
        of_train = cam.problem.nominal
        return {k: float(own[v.field][0]) if v.is_ranged else of_train[k] for k, v in self.variables.items()}

    def _verdict(self, limit: Limit, excess: float) -> str:
        """Whether all cams hold a limit, of which the worst at a corner has an excess."""
        if excess > 0.0:
            return BROKEN
        return self._over(limit, self._until(limit)).verdict

    def _until(self, limit: Limit) -> float:
        return now() + (TRAIN_SECONDS if self._enters_train(limit) else SECONDS)

    def _over(self, limit: Limit, until: float) -> Answer:
        """Whether all cams hold a limit."""
        return limit_over_box(self.problem, limit, self.problem.design, self.ends, until)

    def _cam(self, limit: Limit, witness: Designs) -> Cam:
        """A cam that a proof finds, which may bring its train."""
        train = {key: float(witness.numbers[key][0]) for key in self.of_train if key in witness.numbers}
        problem, design = self.problem.with_numbers(train), witness.without(train)
        own = next(each for each in problem.limits if each.name == limit.name)
        excess, values = self._found(own, design, problem)
        return Cam(problem, design, float(excess[0]), float(values[0]))

    def _proved(self, limit: Limit, worst: Cam) -> tuple[Cam, float | None]:
        """The worst cam, and by how much others may be worse."""
        if not isinstance(limit, QuantityLimit) or not isfinite(worst.value):
            return worst, None
        if limit.is_of_motion and not self._enters_train(limit):
            return worst, 0.0
        side, until = QUANTITIES[limit.quantities[0]].side, self._until(limit)
        gaps = iter(GAPS)
        share = next(gaps)
        for _ in range(WORSE):
            gap = share * (abs(worst.value) or 1.0)
            easier = replace(limit, bound=worst.value + side * gap)
            answer = self._over(easier, until)
            if answer.verdict == HELD:
                return worst, gap
            if answer.witness is not None:
                found = self._cam(limit, answer.witness)
                if side * (found.value - worst.value) > 0.0:
                    worst = found
                    continue
            if (larger := next(gaps, None)) is None:
                break
            share = larger
        return worst, None


def _is_lost(numbers: Mapping[str, float]) -> bool:
    """Whether two contacts of a cam have no interference."""
    return numbers.get(INTERFERENCE, inf) <= 2.0 * NO_INTERFERENCE


def made_so(scene: Scene, numbers: Mapping[str, float]) -> Scene:
    """The scene of one cam within the tolerances, whose errors are made: they are tolerances no more.

    Those of the profile, the bore and angles stay; where none is left, limits on errors of the motion go with them.
    """
    given = scene.to_dict()
    kept = {key: each for key, each in given["tolerances"].items() if key not in NUMBERED}
    limits = {f"limits.{key}": None for key in ERROR_LIMITS if not kept and key in given.get("limits", {})}
    return scene.replace(**{"tolerances": kept, "search.robust": None, **limits, **numbers})


def _worst(limit: Limit, cams: Sequence[Cam]) -> int:
    """Which of some cams is the worst by a limit."""
    excess, values = (np.array([getattr(each, name) for each in cams]) for name in ("excess", "value"))
    return worst_of(limit, excess, values)


def _together(limit: Limit, cams: Sequence[Cam], offs: Sequence[Off], fields: Iterable[str]) -> Off:
    """Each number at the end which alone makes the worst of cams that are off so; the first is not off."""
    found: dict[str, float] = {}
    for field in fields:
        places = [0, *(k for k, off in enumerate(offs) if field in off)]
        found |= offs[places[_worst(limit, [cams[k] for k in places])]]
    return found


def margins_table(scene: Scene, margins: tuple[Margin, ...]) -> Table:
    """The limits with the nominal cam's quantity, that of the worst cam, and whether every cam holds them."""
    heads = ["limit", "bound", "nominal", "worst", "every cam", "worst cam"]
    units = {each.key: each.unit for each in variables_of(scene)}
    setup, rows = resolve(scene).setup, []
    for each in margins:
        unit = quantity_of(each.quantity, setup).unit if each.quantity else ""
        bound = f"{each.relation} {with_unit(each.bound, unit)}" if each.quantity else ""
        values = [number(shown(v, unit)) if each.quantity else "" for v in (each.nominal, each.worst)]
        made = {**each.sizes, INTERFERENCE: 0.0} if _is_lost(each.sizes) else each.sizes
        sizes = ", ".join(
            f"{key.removeprefix('follower.')} {with_unit(made[key], units[key])}" for key in each.moving
        )
        differs = each.quantity and each.worst != each.nominal
        rows.append([each.limit, bound, *values, each.verdict, sizes if differs else ""])
    kinds = [Cell(head, NUMERIC if head in ("nominal", "worst") else "") for head in heads]
    of_errors = {OF_ERRORS for each in margins if each.limit in ERROR_LIMITS}
    note = " ".join([*{OWN_SIZES for each in margins if each.limit not in ERROR_LIMITS}, *of_errors])
    title = f"{scene.name}: limits within the tolerances, each cam cut for its own sizes"
    return Table.of(title, kinds, rows, note)


MUCH = 1e6
"""Times a number, or 1: what reads the number has another value then."""


class Limited(NamedTuple):
    """What designs have of limits, each (limits, designs)."""

    excess: FloatArray
    """Infinite of what is not assembled."""
    values: FloatArray
    """The quantity; of a limit without one its excess."""


def limited(problem: Problem, limits: Sequence[Limit], designs: Designs) -> Limited:
    """The excesses of designs over limits, and their quantities."""
    return _of_case(Case(problem.setup, problem.programme, designs), limits)


@dataclass(frozen=True)
class LimitedBy:
    """What designs have of limits with some values of a number; quantities that do not read it are found once."""

    problem: Problem
    limits: Sequence[Limit]
    field: str
    """Of the number."""

    def at(self, designs: Designs, values: Iterable[FloatArray]) -> Iterator[Limited]:
        """For each of the values (n,)."""
        case = self._known(designs)
        for each in values:
            case = with_designs(case, designs.with_values({self.field: each}), self._changed)
            yield _of_case(case, self.limits)

    def _known(self, designs: Designs) -> Case:
        """A case of designs, with what is known of all that are as the one of the problem."""
        nominal = self.problem.design.values
        others = {name: each for name, each in designs.values.items() if name != self.field}
        if all(np.all(each == nominal[name]) for name, each in others.items()):
            return some_of(self._tried, np.zeros(len(designs), dtype=int))
        return Case(self.problem.setup, self.problem.programme, designs)

    @cached_property
    def _changed(self) -> frozenset[str]:
        """The quantities at each contact that read the number."""
        return changing(self._tried)

    @cached_property
    def _tried(self) -> Case:
        """The design of the problem, and with much more of the number, with what contacts have."""
        design = self.problem.design
        (value,) = design.values[self.field]
        both = design.take([0, 0]).with_values({self.field: np.array([value, MUCH * max(value, 1.0)])})
        case = Case(self.problem.setup, self.problem.programme, both)
        run_effects(case, needs_of(self.limits))
        return case


def _of_case(case: Case, limits: Sequence[Limit]) -> Limited:
    columns, designs = run_effects(case, needs_of(limits)).columns, case.designs
    exists = case.setup.mechanism.exists(designs, case.programme)
    excess = np.where(exists, excesses(limits, columns, designs), np.inf)
    values = np.empty(excess.shape)
    for row, limit in enumerate(limits):
        shown = [np.broadcast_to(columns[name], len(designs)) for name in limit.shown] or [excess[row]]
        values[row] = shown[0] if len(shown) == 1 else np.abs(shown).max(axis=0)
    return Limited(excess, values)


def worst_of(limit: Limit, excess: FloatArray, values: FloatArray) -> int:
    """Which design is the worst by the quantity of a limit (designs,); one that is not assembled before others."""
    outward = limit.quantity.side * values if limit.quantity else excess
    return int(np.argmax(np.where(np.isnan(outward) | np.isposinf(excess), np.inf, outward)))
