"""Margins of limits: the worst value of each limit's quantity over all cams whose numbers are within tolerances.

Each of these cams is designed for its own numbers: it has the programmed motion with its own sizes, speed, spring
and train. (The motion error of a profile that was cut for other sizes is a different question:
``tolerances.tolerance``.)

The worst cam is searched at the corners of the box of numbers. The proof that no cam in the box is worse
(``verdicts.limit_boxes``) finds a worse cam if there is one. Each train moves the follower differently: the proof
covers all of these motions (``verdicts.train_boxes``).

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import Budget
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.model.effects import EvaluationBlock, find_quantity
from camopt.model.effects.contacts import (
    quantities_that_differ_by_design,
    select_designs,
    with_designs_and_kept_columns,
)
from camopt.model.effects.preload import INTERFERENCE_KEY
from camopt.model.mechanisms.design import Designs, concatenate_designs
from camopt.scene.problem.limit import Limit, QuantityLimit, quantities_of_limits
from camopt.scene.problem.limits import ERROR_LIMITS
from camopt.scene.problem.problem import Problem, resolve, with_rounding_relative_error
from camopt.scene.problem.settings import with_toleranced_numbers_per_design
from camopt.scene.problem.tolerance_zones import (
    MOST_CORNER_LINKS,
    MOST_CORNER_NUMBERS,
    NumberErrors,
    corner_errors,
    design_copies_with_errors,
    entries_of_train_numbers,
    tolerance_zones_of_numbers,
)
from camopt.scene.problem.variables import Variable, variables_of_scene
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ToleranceZone
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Table
from camopt.solve.tolerances.plays_and_interference import LEAST_INTERFERENCE, Interference
from camopt.solve.verdicts.constraint_boxes import BoxVerdict, NumberRanges
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_boxes import limit_verdict_over_box, tolerance_ranges
from camopt.solve.verdicts.limit_verdicts import relative_excesses_by_limit
from camopt.solve.verdicts.train_boxes import depends_on_train_errors
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

MARGIN_GAPS = (1e-9, 1e-6, 1e-3)
"""Relative gaps of the worst value that a proof tries, one after the other, until one is proved."""
WORSE_CAMS = 8
"""Number of times that a worse cam replaces the worst so far."""
LOST_PRELOAD = 1e-6
"""Without interference, a preload below this share of the nominal value counts as 0."""
MARGIN_WORK, TRAIN_MARGIN_WORK = 20e6, 1.5e6
"""Work of the proofs of a limit, and of a limit that depends on a train with tolerances."""
SAME_QUANTITY = 1e-12
"""Values of a quantity are equal if their relative difference is smaller."""
OWN_SIZES_NOTE = "Each cam has the programmed motion, as if its profile were cut for its own sizes and numbers."
ERROR_LIMITS_NOTE = (
    "Limits on errors apply to the cam of the first table: cut for the nominal sizes, at the nominal speed."
)


class Margin(NamedTuple):
    """A limit, and the worst value of its quantity over all cams whose numbers are within tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("rocker-valve").replace(**{"tolerances.follower.arm_length": 0.05})
    >>> margin = camopt.tolerance(scene).margins[0]
    >>> margin.limit, round(margin.nominal, 3), round(margin.worst, 3), margin.verdict
    ('pressure_angle', 24.493, 24.604, 'held')
    """

    limit: str
    quantity: str
    """Quantity that the limit bounds; "" if it has none."""
    relation: str
    bound: float
    """Bound of the limit, in the unit of the quantity."""
    nominal: float
    worst: float
    """Value of the worst cam found (``sizes``)."""
    gap: float | None
    """Proven bound of how much worse another cam within the tolerances may be.

    None if no gap up to 0.1 % of the worst value was proved (the verdict has its own budget), or if the limit
    has no finite value.
    """
    verdict: str
    """Whether every cam holds the limit: "held" and "broken" are proved, otherwise "undecided"."""
    sizes: dict[str, float]
    """Toleranced numbers of the worst cam, by key of the scene, in its units."""
    moving: tuple[str, ...] = ()
    """Keys of those numbers that change the quantity of the worst cam."""


class TriedCam(NamedTuple):
    """The worst cam found with one train."""

    problem: Problem
    """The problem with the cam's train."""
    design: Designs
    excess: float
    """Largest excess over the limit of all cams tried with this train."""
    value: float
    """Quantity of the limit."""


@dataclass(frozen=True)
class ToleranceBox:
    """The cams within the tolerances of the numbers of a scene."""

    problem: Problem
    """The problem; its designs have the toleranced numbers, except those of the train."""
    zones: Mapping[str, ToleranceZone]
    """Tolerance zones, by key of the scene."""
    variables: Mapping[str, Variable]
    interference: Interference | None = None
    """Interference of two contacts; all proofs take its whole zone, whatever the sizes of a cam."""
    _proven_gaps: dict[tuple[tuple[str, ...], float], tuple[TriedCam, float | None]] = field(default_factory=dict)
    """Worst cams and proven gaps so far, by quantities and worst value of the tried cams."""

    @classmethod
    def from_scene(cls, scene: Scene, problem: Problem) -> "ToleranceBox":
        zones, interference = tolerance_zones_of_numbers(scene, problem.nominal_numbers), None
        if INTERFERENCE_KEY in problem.nominal_numbers and problem.setup.mechanism.further_contacts:
            interference = Interference.from_scene(
                scene, problem, problem.nominal_numbers[INTERFERENCE_KEY], zones.get(INTERFERENCE_KEY)
            )
            zones[INTERFERENCE_KEY] = interference.zone
        variables = {each.key: each for each in problem.variables if each.key in zones}
        zones_by_field = {
            v.field: zones[key] for key, v in variables.items() if v.varies_by_design or zones[key].has_width
        }
        return cls(
            with_toleranced_numbers_per_design(
                with_rounding_relative_error(replace(problem, zones=zones_by_field, robust_errors=()))
            ),
            zones,
            variables,
            interference,
        )

    @cached_property
    def margins(self) -> tuple[Margin, ...]:
        """The margin of each limit; without tolerances of numbers, only of limits on motion errors."""
        # limits on motion errors are those of the nominal cam
        nominal_box = ToleranceBox(replace(self.problem, zones={}, robust_errors=()), {}, {})
        return tuple(
            (nominal_box if limit.is_on_motion_error else self)._margin_of_limit(place, limit)
            for place, limit in enumerate(self.problem.limits)
            if limit.is_on_motion_error or self.zones
        )

    @cached_property
    def number_ranges(self) -> NumberRanges:
        """Least and largest value of each toleranced number, by field."""
        return tolerance_ranges(self.problem, self.problem.design)

    @cached_property
    def nominal_and_corner_designs(self) -> Designs:
        """The nominal design, and the designs at the corners of the box."""
        return design_copies_with_errors(self.problem.design, self.nominal_and_corner_errors)

    @cached_property
    def nominal_and_corner_errors(self) -> list[NumberErrors]:
        """Errors of the tried designs."""
        return [{}, *corner_errors(self.design_zones)]

    @cached_property
    def design_zones(self) -> dict[str, ToleranceZone]:
        """Zones of the numbers of designs, by field."""
        return {field: zone for field, zone in self.problem.zones.items() if field not in self.train_zones}

    @cached_property
    def train_zones(self) -> dict[str, ToleranceZone]:
        """Zones of the numbers of the train."""
        return entries_of_train_numbers(self.problem.zones)

    @cached_property
    def nominal_and_tried_train_errors(self) -> list[NumberErrors]:
        """Errors of the tried trains: at the corners of a few numbers, else of one number at a time."""
        return [{}, *corner_errors(self.train_zones, MOST_CORNER_LINKS)]

    @cached_property
    def problems_of_tried_trains(self) -> list[Problem]:
        """The problem with the nominal train, and with each tried train."""
        return [self.problem.with_number_errors(errors) for errors in self.nominal_and_tried_train_errors]

    def _margin_of_limit(self, limit_number: int, limit: Limit) -> Margin:
        """The margin of the limit with index ``limit_number``."""
        cams = [
            self._worst_cam_of_train(problem, problem.limits[limit_number])
            for problem in self.problems_of_tried_trains
        ]
        if len(self.train_zones) > MOST_CORNER_LINKS:
            combined = self.problem.with_number_errors(
                _worst_ends_of_numbers(limit, cams, self.nominal_and_tried_train_errors, self.train_zones)
            )
            cams.append(self._worst_cam_of_train(combined, combined.limits[limit_number]))
        worst, gap = self._worst_cam_and_proven_gap(limit, cams[_worst_tried_cam_index(limit, cams)])
        verdict = self._verdict_of_limit(limit, max(each.excess for each in cams), worst.value, gap)
        worst_limit = worst.problem.limits[limit_number]
        if verdict == UNDECIDED and self._excess_and_quantity(worst_limit, worst.design, worst.problem)[0][0] > 0.0:
            verdict = BROKEN
        if self.interference is not None:
            real = self._worst_with_possible_interference(limit, worst, self.interference)
            if gap is not None and isinstance(limit, QuantityLimit):
                gap += max(limit.bound_sign * (worst.value - real.value), 0.0)
            verdict = BROKEN if real.excess > 0.0 else UNDECIDED if verdict == BROKEN else verdict
            worst = real
        name, nominal = (
            limit.shown_quantities[0] if limit.shown_quantities else "",
            float(self._excess_and_quantity(limit, self.nominal_and_corner_designs)[1][0]),
        )
        head = limit.name, name, limit.relation, limit.bound, nominal
        numbers = self._numbers_of_cam(worst)
        moving = tuple(
            key for key in numbers if limit.shown_quantities and self._changes_quantity(limit, worst, key)
        )
        value = (
            0.0
            if _has_no_interference(numbers) and abs(worst.value) <= LOST_PRELOAD * abs(nominal)
            else worst.value
        )
        return Margin(*head, value, gap, verdict, numbers, moving)

    def _changes_quantity(self, limit: Limit, cam: TriedCam, key: str) -> bool:
        """Whether a number of a cam changes the quantity of a limit; true for numbers of the train."""
        field = self.variables[key].field
        if field not in self.design_zones:
            return not self.variables[key].varies_by_design
        nominal = cam.design.with_values({field: self.problem.design.values[field]})
        value = float(self._excess_and_quantity(limit, nominal, cam.problem)[1][0])
        return not abs(value - cam.value) <= SAME_QUANTITY * abs(cam.value)

    def _worst_cam_of_train(self, problem: Problem, limit: Limit) -> TriedCam:
        """The worst cam with the train of a problem."""
        designs = self.nominal_and_corner_designs
        if len(self.design_zones) > MOST_CORNER_NUMBERS:
            excess, values = self._excess_and_quantity(limit, designs, problem)
            cams = [TriedCam(problem, designs, *both) for both in zip(excess, values, strict=True)]
            designs = design_copies_with_errors(
                self.problem.design,
                [
                    *self.nominal_and_corner_errors,
                    _worst_ends_of_numbers(limit, cams, self.nominal_and_corner_errors, self.design_zones),
                ],
            )
        return self._worst_of_designs(limit, designs, problem)

    def _worst_of_designs(self, limit: Limit, designs: Designs, problem: Problem) -> TriedCam:
        """The worst of designs with the train of a problem."""
        excess, values = self._excess_and_quantity(limit, designs, problem)
        place = worst_design_index(limit, excess, values)
        return TriedCam(problem, designs.take([place]), float(excess.max()), float(values[place]))

    def _worst_with_possible_interference(
        self, limit: Limit, worst: TriedCam, interference: Interference
    ) -> TriedCam:
        """The worst of the tried cams with a train, each with an interference that its own sizes can have."""
        cams, field = (
            concatenate_designs([self.nominal_and_corner_designs, worst.design]),
            self.variables[INTERFERENCE_KEY].field,
        )
        nominal = self.problem.design.values
        errors = {
            k: cams.values[v.field] - nominal[v.field]
            for k, v in self.variables.items()
            if v.field in self.design_zones
        }
        cams = cams.with_values({field: np.clip(cams.values[field], *interference.interference_range(errors))})
        return self._worst_of_designs(limit, cams, worst.problem)

    def _depends_on_train(self, limit: Limit) -> bool:
        """Whether errors of the train change a limit."""
        return bool(self.train_zones) and depends_on_train_errors(self.problem, limit)

    def _excess_and_quantity(
        self, limit: Limit, designs: Designs, problem: Problem | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Excess of designs over a limit, and the quantity of the limit."""
        excess, values = evaluate_limits(problem or self.problem, [limit], designs)
        return excess[0], values[0]

    def _numbers_of_cam(self, cam: TriedCam) -> dict[str, float]:
        """Toleranced numbers of a cam, by key of the scene."""
        values, train = cam.design.values, cam.problem.nominal_numbers
        return {k: float(values[v.field][0]) if v.varies_by_design else train[k] for k, v in self.variables.items()}

    def _verdict_of_limit(self, limit: Limit, excess: float, worst_value: float, gap: float | None) -> str:
        """Whether all cams hold a limit: from the largest excess of the tried cams, the proven gap, or a proof."""
        if excess > 0.0:
            return BROKEN
        if gap and isinstance(limit, QuantityLimit):
            side = limit.bound_sign
            if side * (worst_value + side * gap) < side * limit.bound:
                return HELD
        return self._certify_limit(limit, self._proof_budget(limit)).verdict

    def _proof_budget(self, limit: Limit) -> Budget:
        return Budget(TRAIN_MARGIN_WORK if self._depends_on_train(limit) else MARGIN_WORK)

    def _certify_limit(self, limit: Limit, budget: Budget) -> BoxVerdict:
        """Proof that all cams hold a limit, or a witness that breaks it."""
        return limit_verdict_over_box(self.problem, limit, self.problem.design, self.number_ranges, budget)

    def _worst_cam_and_proven_gap(self, limit: Limit, worst: TriedCam) -> tuple[TriedCam, float | None]:
        """The worst cam, and the proven gap to any worse cam; None if no gap is proved."""
        if not isinstance(limit, QuantityLimit) or not isfinite(worst.value):
            return worst, None
        if limit.is_decided_by_motion_alone and not self._depends_on_train(limit):
            return worst, 0.0
        question = limit.quantities, worst.value  # two limits may bound one quantity
        if question not in self._proven_gaps:
            self._proven_gaps[question] = self._prove_gap(limit, worst)
        return self._proven_gaps[question]

    def _prove_gap(self, limit: QuantityLimit, worst: TriedCam) -> tuple[TriedCam, float | None]:
        """The worst cam, and the least of ``MARGIN_GAPS`` that is proved with its share of the budget."""
        side, gaps, budget = limit.bound_sign, [*MARGIN_GAPS], self._proof_budget(limit)
        for _ in range(WORSE_CAMS):
            gap = gaps[0] * (abs(worst.value) or 1.0)
            proof = self._certify_limit(replace(limit, bound=worst.value + side * gap), budget.share(len(gaps)))
            if proof.verdict == HELD:
                return worst, gap
            if proof.witness is not None:  # it may have its own train
                train = {
                    k: float(proof.witness.numbers[k][0]) for k in self.train_zones if k in proof.witness.numbers
                }
                problem, design = self.problem.with_numbers(train), proof.witness.without_numbers(train)
                own_limit = next(each for each in problem.limits if each.name == limit.name)
                cam = self._worst_of_designs(own_limit, design, problem)
                if side * (cam.value - worst.value) > 0.0:
                    worst = cam
                    continue
            if len(gaps) == 1:
                break
            gaps.pop(0)
        return worst, None


def _has_no_interference(numbers: Mapping[str, float]) -> bool:
    """Whether the two contacts of a cam have no interference."""
    return numbers.get(INTERFERENCE_KEY, inf) <= 2.0 * LEAST_INTERFERENCE


def _worst_tried_cam_index(limit: Limit, cams: Sequence[TriedCam]) -> int:
    """Index of the worst cam for a limit."""
    excess, values = (np.array([getattr(each, name) for each in cams]) for name in ("excess", "value"))
    return worst_design_index(limit, excess, values)


def _worst_ends_of_numbers(
    limit: Limit, cams: Sequence[TriedCam], cam_errors: Sequence[NumberErrors], fields: Iterable[str]
) -> NumberErrors:
    """The worst single error of each number, combined. ``cam_errors`` are those of the cams; the first has none."""
    errors: dict[str, float] = {}
    for name in fields:
        places = [0, *(k for k, each in enumerate(cam_errors) if name in each)]
        errors |= cam_errors[places[_worst_tried_cam_index(limit, [cams[k] for k in places])]]
    return errors


def margins_table(scene: Scene, margins: tuple[Margin, ...]) -> Table:
    """The limits with the nominal and the worst cam's value, and whether every cam holds them."""
    heads = ["limit", "bound", "nominal", "worst", "every cam", "worst cam"]
    units = {each.key: each.unit for each in variables_of_scene(scene)}
    setup, rows = resolve(scene).setup, []
    for margin in margins:
        unit = find_quantity(margin.quantity, setup).unit if margin.quantity else ""
        bound = f"{margin.relation} {with_unit(margin.bound, unit)}" if margin.quantity else ""
        ends = margin.nominal, margin.worst
        values = [number_text(to_shown_unit(v, unit)) if margin.quantity else "" for v in ends]
        numbers = margin.sizes | ({INTERFERENCE_KEY: 0.0} if _has_no_interference(margin.sizes) else {})
        sizes = ", ".join(
            f"{key.removeprefix('follower.')} {with_unit(numbers[key], units[key])}" for key in margin.moving
        )
        differs = margin.quantity and margin.worst != margin.nominal
        rows.append([margin.limit, bound, *values, margin.verdict, sizes if differs else ""])
    kinds = [Cell(head, NUMERIC if head in ("nominal", "worst") else "") for head in heads]
    error_note = {ERROR_LIMITS_NOTE for each in margins if each.limit in ERROR_LIMITS}
    note = " ".join([*{OWN_SIZES_NOTE for each in margins if each.limit not in ERROR_LIMITS}, *error_note])
    title = f"{scene.name}: limits within the tolerances, each cam cut for its own sizes"
    return Table.from_texts(title, kinds, rows, note)


LARGE_FACTOR = 1e6
"""Factor of a number (or of 1) with which every quantity that depends on the number changes."""


class LimitValues(NamedTuple):
    """Values of limits for designs, arrays of shape (limits, designs)."""

    excess: FloatArray
    """Relative excess over the limit; infinite if a design cannot be assembled."""
    values: FloatArray
    """Quantity of the limit; the excess if the limit has none."""


def evaluate_limits(problem: Problem, limits: Sequence[Limit], designs: Designs) -> LimitValues:
    """Excesses of designs over limits, and the limits' quantities."""
    return _evaluate_block(EvaluationBlock(problem.setup, problem.programme, designs), limits)


@dataclass(frozen=True)
class LimitsByNumber:
    """Evaluates limits for several values of one number; quantities that do not depend on it are computed once."""

    problem: Problem
    limits: Sequence[Limit]
    field: str
    """Field of the number."""

    def evaluate_limits_by_number(
        self, designs: Designs, number_values: Iterable[FloatArray]
    ) -> Iterator[LimitValues]:
        """Values of the limits, for each array (designs,) of values of the number."""
        nominal = self.problem.design.values
        block = EvaluationBlock(self.problem.setup, self.problem.programme, designs)
        if all(np.all(each == nominal[name]) for name, each in designs.values.items() if name != self.field):
            # only the number differs from the nominal design: the other quantities are known
            block = select_designs(self._block_of_nominal_and_huge_number, np.zeros(len(designs), dtype=int))
        for numbers in number_values:
            block = with_designs_and_kept_columns(
                block, designs.with_values({self.field: numbers}), self._quantities_depending_on_number
            )
            yield _evaluate_block(block, self.limits)

    @cached_property
    def _quantities_depending_on_number(self) -> frozenset[str]:
        """Quantities at each contact that depend on the number."""
        return quantities_that_differ_by_design(self._block_of_nominal_and_huge_number)

    @cached_property
    def _block_of_nominal_and_huge_number(self) -> EvaluationBlock:
        """The nominal design with the number's own value and with a very large one, evaluated."""
        design = self.problem.design
        (value,) = design.values[self.field]
        both = design.take([0, 0]).with_values({self.field: np.array([value, LARGE_FACTOR * max(value, 1.0)])})
        block = EvaluationBlock(self.problem.setup, self.problem.programme, both)
        run_effects(block, quantities_of_limits(self.limits))
        return block


def _evaluate_block(case: EvaluationBlock, limits: Sequence[Limit]) -> LimitValues:
    columns, designs = run_effects(case, quantities_of_limits(limits)).columns, case.designs
    exists = case.setup.mechanism.can_assemble(designs, case.programme)
    excess = np.where(exists, relative_excesses_by_limit(limits, columns, designs), np.inf)
    values = np.empty(excess.shape)
    for row, limit in enumerate(limits):
        shown = [np.broadcast_to(columns[name], len(designs)) for name in limit.shown_quantities] or [excess[row]]
        values[row] = shown[0] if len(shown) == 1 else np.abs(shown).max(axis=0)
    return LimitValues(excess, values)


def worst_design_index(limit: Limit, excess: FloatArray, values: FloatArray) -> int:
    """Index of the worst design by the quantity of a limit; a design that cannot be assembled comes first."""
    outward = limit.quantity.limit_sign * values if limit.quantity else excess
    return int(np.argmax(np.where(np.isnan(outward) | np.isposinf(excess), np.inf, outward)))
