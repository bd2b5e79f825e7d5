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
from camopt.core.numerics.clock import clock_seconds
from camopt.core.quantities import AT_LEAST, QUANTITIES
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.model.effects import EvaluationBlock, find_quantity
from camopt.model.effects.contacts import differing_quantities, select_designs, with_designs
from camopt.model.mechanisms.design import Designs, concatenate
from camopt.scene.problem.limit import Limit, QuantityLimit, quantities_of_limits
from camopt.scene.problem.limits import ERROR_LIMITS
from camopt.scene.problem.problem import Problem, at_rounding_error, resolve
from camopt.scene.problem.settings import with_toleranced_numbers
from camopt.scene.problem.tolerance_zones import (
    MOST_CORNER_LINKS,
    MOST_CORNER_NUMBERS,
    NumberErrors,
    corner_errors,
    designs_with_errors,
    number_zones,
    train_entries,
)
from camopt.scene.problem.variables import Variable, variables_of
from camopt.scene.scene import Scene
from camopt.scene.tolerances import NUMBER_TABLES, ToleranceZone
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Table
from camopt.solve.tolerances.plays_and_interference import INTERFERENCE_KEY, LEAST_INTERFERENCE, Interference
from camopt.solve.verdicts.constraint_boxes import BoxVerdict, NumberRanges
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_boxes import limit_over_box, tolerance_ranges
from camopt.solve.verdicts.limit_verdicts import excesses
from camopt.solve.verdicts.train_boxes import depends_on_train
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

MARGIN_GAPS = (1e-9, 1e-6, 1e-3)
"""Relative, of the worst value: by no more than this a cam may be worse, the first that is proved."""
WORSE_CAMS = 8
"""How often a worse cam than the worst so far is taken for it."""
LOST_PRELOAD = 1e-6
"""Of the nominal value: with no interference a preload, and what is in proportion to it, is less, which is none."""
MARGIN_SECONDS, TRAIN_MARGIN_SECONDS = 20.0, 5.0
"""For the proofs of a limit, and of one that trains change."""
SAME_QUANTITY = 1e-12
"""Values of a quantity that are this near to each other, relative, are the same."""
OWN_SIZES_NOTE = (
    "Each cam has the motion that is asked, as it would if its profile were cut for its own sizes and numbers."
)
ERROR_LIMITS_NOTE = (
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


class TriedCam(NamedTuple):
    """A cam within tolerances."""

    problem: Problem
    """That of its train."""
    design: Designs
    excess: float
    """The largest over a limit, of all that were tried with this train."""
    value: float
    """Of the quantity of the limit."""


@dataclass(frozen=True)
class ToleranceBox:
    """The cams within the tolerances of the numbers of a scene."""

    problem: Problem
    """With designs that bring the numbers which have tolerances, but for those of the train."""
    zones: Mapping[str, ToleranceZone]
    """Of those numbers, by key of the scene."""
    variables: Mapping[str, Variable]
    interference: Interference | None = None
    """That of two contacts: between the ends of its zone, whatever sizes a cam has, in all that is proved."""

    @classmethod
    def from_scene(cls, scene: Scene, problem: Problem) -> "ToleranceBox":
        zones, apart = number_zones(scene, problem.nominal_numbers), None
        if INTERFERENCE_KEY in problem.nominal_numbers and problem.setup.mechanism.further_contacts:
            apart = Interference.from_scene(
                scene, problem, problem.nominal_numbers[INTERFERENCE_KEY], zones.get(INTERFERENCE_KEY)
            )
            zones[INTERFERENCE_KEY] = apart.zone
        variables = {each.key: each for each in problem.variables if each.key in zones}
        of_fields = {
            v.field: zones[key] for key, v in variables.items() if v.varies_by_design or zones[key].has_width
        }
        return cls(
            with_toleranced_numbers(at_rounding_error(replace(problem, zones=of_fields, robust_errors=()))),
            zones,
            variables,
            apart,
        )

    @cached_property
    def margins(self) -> tuple[Margin, ...]:
        """The margin of each limit; without tolerances of numbers of those on errors alone."""
        return tuple(
            (self.nominal_box if limit.is_on_motion_error else self)._margin_of_limit(place, limit)
            for place, limit in enumerate(self.problem.limits)
            if limit.is_on_motion_error or self.zones
        )

    @cached_property
    def nominal_box(self) -> "ToleranceBox":
        """The nominal cam alone, of which errors by tolerances are."""
        return ToleranceBox(replace(self.problem, zones={}, robust_errors=()), {}, {})

    @cached_property
    def number_ranges(self) -> NumberRanges:
        """Between which values numbers are, by field."""
        return tolerance_ranges(self.problem, self.problem.design)

    @cached_property
    def tried_designs(self) -> Designs:
        """The design itself, and those at the corners."""
        return designs_with_errors(self.problem.design, self.tried_errors)

    @cached_property
    def tried_errors(self) -> list[NumberErrors]:
        """By how much they are off."""
        return [{}, *corner_errors(self.design_zones)]

    @cached_property
    def design_zones(self) -> dict[str, ToleranceZone]:
        """The zones of numbers that designs bring."""
        return {field: zone for field, zone in self.problem.zones.items() if field not in self.train_zones}

    @cached_property
    def train_zones(self) -> dict[str, ToleranceZone]:
        """The zones of numbers of the train."""
        return train_entries(self.problem.zones)

    @cached_property
    def tried_train_errors(self) -> list[NumberErrors]:
        """By how much these are off that are looked at: at the corners of a few, else each alone."""
        return [{}, *corner_errors(self.train_zones, MOST_CORNER_LINKS)]

    @cached_property
    def tried_trains(self) -> list[Problem]:
        """The problem itself, and those of trains that are off so."""
        return [self.problem.with_number_errors(off) for off in self.tried_train_errors]

    def _margin_of_limit(self, place: int, limit: Limit) -> Margin:
        """That of a limit, by its place among all."""
        found = [self._worst_cam_of_train(problem, problem.limits[place]) for problem in self.tried_trains]
        if len(self.train_zones) > MOST_CORNER_LINKS:
            together = self.problem.with_number_errors(
                _worst_ends_of_numbers(limit, found, self.tried_train_errors, self.train_zones)
            )
            found.append(self._worst_cam_of_train(together, together.limits[place]))
        worst, gap = found[_worst_tried_cam(limit, found)], None
        verdict = self._verdict_of_limit(limit, max(each.excess for each in found))
        worst, gap = self._prove_worst_cam(limit, worst)
        if self.interference is not None:
            made, side = (
                self._with_own_interference(limit, worst, self.interference),
                -1.0 if limit.relation == AT_LEAST else 1.0,
            )
            gap = None if gap is None else gap + max(side * (worst.value - made.value), 0.0)
            verdict = BROKEN if made.excess > 0.0 else UNDECIDED if verdict == BROKEN else verdict
            worst = made
        name, nominal = (
            limit.shown_quantities[0] if limit.shown_quantities else "",
            float(self._excess_and_quantity(limit, self.tried_designs)[1][0]),
        )
        about = limit.name, name, limit.relation, limit.bound, nominal
        numbers = self._numbers_of_cam(worst)
        moving = tuple(
            key for key in numbers if limit.shown_quantities and self._changes_quantity(limit, worst, key)
        )
        value = (
            0.0
            if _has_no_interference(numbers) and abs(worst.value) <= LOST_PRELOAD * abs(nominal)
            else worst.value
        )
        return Margin(*about, value, gap, verdict, numbers, moving)

    def _changes_quantity(self, limit: Limit, cam: TriedCam, key: str) -> bool:
        """Whether a number of a cam changes the quantity of a limit; one of the train does."""
        field = self.variables[key].field
        if field not in self.design_zones:
            return not self.variables[key].varies_by_design
        nominal = cam.design.with_values({field: self.problem.design.values[field]})
        value = float(self._excess_and_quantity(limit, nominal, cam.problem)[1][0])
        return not abs(value - cam.value) <= SAME_QUANTITY * abs(cam.value)

    def _worst_cam_of_train(self, problem: Problem, limit: Limit) -> TriedCam:
        """The worst cam with a train."""
        cams = self.tried_designs
        excess, values = self._excess_and_quantity(limit, cams, problem)
        if len(self.design_zones) > MOST_CORNER_NUMBERS:
            each = [TriedCam(problem, cams, *both) for both in zip(excess, values, strict=True)]
            cams = designs_with_errors(
                self.problem.design,
                [*self.tried_errors, _worst_ends_of_numbers(limit, each, self.tried_errors, self.design_zones)],
            )
            excess, values = self._excess_and_quantity(limit, cams, problem)
        place = worst_design(limit, excess, values)
        return TriedCam(problem, cams.take([place]), float(excess.max()), float(values[place]))

    def _with_own_interference(self, limit: Limit, worst: TriedCam, apart: Interference) -> TriedCam:
        """The worst of the cams that were tried with a train, each with an interference that its own sizes have."""
        cams, field = concatenate([self.tried_designs, worst.design]), self.variables[INTERFERENCE_KEY].field
        nominal = self.problem.design.values
        off = {
            k: cams.values[v.field] - nominal[v.field]
            for k, v in self.variables.items()
            if v.field in self.design_zones
        }
        cams = cams.with_values({field: np.clip(cams.values[field], *apart.interference_range(off))})
        excess, values = self._excess_and_quantity(limit, cams, worst.problem)
        place = worst_design(limit, excess, values)
        return TriedCam(worst.problem, cams.take([place]), float(excess.max()), float(values[place]))

    def _depends_on_train(self, limit: Limit) -> bool:
        """Whether trains that are off change a limit."""
        return bool(self.train_zones) and depends_on_train(self.problem, limit)

    def _excess_and_quantity(
        self, limit: Limit, designs: Designs, problem: Problem | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """The excess of designs over a limit, and its quantity."""
        excess, values = evaluate_limits(problem or self.problem, [limit], designs)
        return excess[0], values[0]

    def _numbers_of_cam(self, cam: TriedCam) -> dict[str, float]:
        """The numbers of a cam that have tolerances, by key of the scene."""
        own = cam.design.values
        of_train = cam.problem.nominal_numbers
        return {k: float(own[v.field][0]) if v.varies_by_design else of_train[k] for k, v in self.variables.items()}

    def _verdict_of_limit(self, limit: Limit, excess: float) -> str:
        """Whether all cams hold a limit, of which the worst at a corner has an excess."""
        if excess > 0.0:
            return BROKEN
        return self._certify_limit(limit, self._proof_deadline(limit)).verdict

    def _proof_deadline(self, limit: Limit) -> float:
        return clock_seconds() + (TRAIN_MARGIN_SECONDS if self._depends_on_train(limit) else MARGIN_SECONDS)

    def _certify_limit(self, limit: Limit, until: float) -> BoxVerdict:
        """Whether all cams hold a limit."""
        return limit_over_box(self.problem, limit, self.problem.design, self.number_ranges, until)

    def _cam_of_witness(self, limit: Limit, witness: Designs) -> TriedCam:
        """A cam that a proof finds, which may bring its train."""
        train = {key: float(witness.numbers[key][0]) for key in self.train_zones if key in witness.numbers}
        problem, design = self.problem.with_numbers(train), witness.without_numbers(train)
        own = next(each for each in problem.limits if each.name == limit.name)
        excess, values = self._excess_and_quantity(own, design, problem)
        return TriedCam(problem, design, float(excess[0]), float(values[0]))

    def _prove_worst_cam(self, limit: Limit, worst: TriedCam) -> tuple[TriedCam, float | None]:
        """The worst cam, and by how much others may be worse."""
        if not isinstance(limit, QuantityLimit) or not isfinite(worst.value):
            return worst, None
        if limit.is_of_motion and not self._depends_on_train(limit):
            return worst, 0.0
        side, until = QUANTITIES[limit.quantities[0]].side, self._proof_deadline(limit)
        gaps = iter(MARGIN_GAPS)
        share = next(gaps)
        for _ in range(WORSE_CAMS):
            gap = share * (abs(worst.value) or 1.0)
            easier = replace(limit, bound=worst.value + side * gap)
            answer = self._certify_limit(easier, until)
            if answer.verdict == HELD:
                return worst, gap
            if answer.witness is not None:
                found = self._cam_of_witness(limit, answer.witness)
                if side * (found.value - worst.value) > 0.0:
                    worst = found
                    continue
            if (larger := next(gaps, None)) is None:
                break
            share = larger
        return worst, None


def _has_no_interference(numbers: Mapping[str, float]) -> bool:
    """Whether two contacts of a cam have no interference."""
    return numbers.get(INTERFERENCE_KEY, inf) <= 2.0 * LEAST_INTERFERENCE


def scene_of_cam(scene: Scene, numbers: Mapping[str, float]) -> Scene:
    """The scene of one cam within the tolerances, whose errors are made: they are tolerances no more.

    Those of the profile, the bore and angles stay; where none is left, limits on errors of the motion go with them.
    """
    given = scene.to_dict()
    kept = {key: each for key, each in given["tolerances"].items() if key not in NUMBER_TABLES}
    limits = {f"limits.{key}": None for key in ERROR_LIMITS if not kept and key in given.get("limits", {})}
    return scene.replace(**{"tolerances": kept, "search.robust": None, **limits, **numbers})


def _worst_tried_cam(limit: Limit, cams: Sequence[TriedCam]) -> int:
    """Which of some cams is the worst by a limit."""
    excess, values = (np.array([getattr(each, name) for each in cams]) for name in ("excess", "value"))
    return worst_design(limit, excess, values)


def _worst_ends_of_numbers(
    limit: Limit, cams: Sequence[TriedCam], offs: Sequence[NumberErrors], fields: Iterable[str]
) -> NumberErrors:
    """Each number at the end which alone makes the worst of cams that are off so; the first is not off."""
    found: dict[str, float] = {}
    for field in fields:
        places = [0, *(k for k, off in enumerate(offs) if field in off)]
        found |= offs[places[_worst_tried_cam(limit, [cams[k] for k in places])]]
    return found


def margins_table(scene: Scene, margins: tuple[Margin, ...]) -> Table:
    """The limits with the nominal cam's quantity, that of the worst cam, and whether every cam holds them."""
    heads = ["limit", "bound", "nominal", "worst", "every cam", "worst cam"]
    units = {each.key: each.unit for each in variables_of(scene)}
    setup, rows = resolve(scene).setup, []
    for each in margins:
        unit = find_quantity(each.quantity, setup).unit if each.quantity else ""
        bound = f"{each.relation} {with_unit(each.bound, unit)}" if each.quantity else ""
        values = [number_text(to_shown_unit(v, unit)) if each.quantity else "" for v in (each.nominal, each.worst)]
        made = {**each.sizes, INTERFERENCE_KEY: 0.0} if _has_no_interference(each.sizes) else each.sizes
        sizes = ", ".join(
            f"{key.removeprefix('follower.')} {with_unit(made[key], units[key])}" for key in each.moving
        )
        differs = each.quantity and each.worst != each.nominal
        rows.append([each.limit, bound, *values, each.verdict, sizes if differs else ""])
    kinds = [Cell(head, NUMERIC if head in ("nominal", "worst") else "") for head in heads]
    of_errors = {ERROR_LIMITS_NOTE for each in margins if each.limit in ERROR_LIMITS}
    note = " ".join([*{OWN_SIZES_NOTE for each in margins if each.limit not in ERROR_LIMITS}, *of_errors])
    title = f"{scene.name}: limits within the tolerances, each cam cut for its own sizes"
    return Table.from_texts(title, kinds, rows, note)


LARGE_FACTOR = 1e6
"""Times a number, or 1: what reads the number has another value then."""


class LimitValues(NamedTuple):
    """What designs have of limits, each (limits, designs)."""

    excess: FloatArray
    """Infinite of what is not assembled."""
    values: FloatArray
    """The quantity; of a limit without one its excess."""


def evaluate_limits(problem: Problem, limits: Sequence[Limit], designs: Designs) -> LimitValues:
    """The excesses of designs over limits, and their quantities."""
    return _evaluate_case(EvaluationBlock(problem.setup, problem.programme, designs), limits)


@dataclass(frozen=True)
class LimitsByNumber:
    """What designs have of limits with some values of a number; quantities that do not read it are found once."""

    problem: Problem
    limits: Sequence[Limit]
    field: str
    """Of the number."""

    def evaluate_numbers(self, designs: Designs, values: Iterable[FloatArray]) -> Iterator[LimitValues]:
        """For each of the values (n,)."""
        case = self._designs_case(designs)
        for each in values:
            case = with_designs(case, designs.with_values({self.field: each}), self._changing_quantities)
            yield _evaluate_case(case, self.limits)

    def _designs_case(self, designs: Designs) -> EvaluationBlock:
        """A case of designs, with what is known of all that are as the one of the problem."""
        nominal = self.problem.design.values
        others = {name: each for name, each in designs.values.items() if name != self.field}
        if all(np.all(each == nominal[name]) for name, each in others.items()):
            return select_designs(self._probe_case, np.zeros(len(designs), dtype=int))
        return EvaluationBlock(self.problem.setup, self.problem.programme, designs)

    @cached_property
    def _changing_quantities(self) -> frozenset[str]:
        """The quantities at each contact that read the number."""
        return differing_quantities(self._probe_case)

    @cached_property
    def _probe_case(self) -> EvaluationBlock:
        """The design of the problem, and with much more of the number, with what contacts have."""
        design = self.problem.design
        (value,) = design.values[self.field]
        both = design.take([0, 0]).with_values({self.field: np.array([value, LARGE_FACTOR * max(value, 1.0)])})
        case = EvaluationBlock(self.problem.setup, self.problem.programme, both)
        run_effects(case, quantities_of_limits(self.limits))
        return case


def _evaluate_case(case: EvaluationBlock, limits: Sequence[Limit]) -> LimitValues:
    columns, designs = run_effects(case, quantities_of_limits(limits)).columns, case.designs
    exists = case.setup.mechanism.can_assemble(designs, case.programme)
    excess = np.where(exists, excesses(limits, columns, designs), np.inf)
    values = np.empty(excess.shape)
    for row, limit in enumerate(limits):
        shown = [np.broadcast_to(columns[name], len(designs)) for name in limit.shown_quantities] or [excess[row]]
        values[row] = shown[0] if len(shown) == 1 else np.abs(shown).max(axis=0)
    return LimitValues(excess, values)


def worst_design(limit: Limit, excess: FloatArray, values: FloatArray) -> int:
    """Which design is the worst by the quantity of a limit (designs,); one that is not assembled before others."""
    outward = limit.quantity.side * values if limit.quantity else excess
    return int(np.argmax(np.where(np.isnan(outward) | np.isposinf(excess), np.inf, outward)))
