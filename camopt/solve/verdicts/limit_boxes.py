"""Verdict on a limit for all designs of a box of sizes, from its constraints (``constraint_boxes``).

If a limit depends only on sizes, interval arithmetic on the ranges decides it. A limit without constraints, such as
that on the mass, stays undecided unless a design of the box is known to break it. No profile of the box crosses
itself if the largest pressure angle in the box is small enough
(``effects.self_crossing.proved_uncrossed_roller_radius``).
"""

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.core.numerics.interval import Interval, as_interval
from camopt.model.effects import EvaluationBlock, require_effect
from camopt.model.effects.contacts import FunctionAtContact, all_follower_contacts, block_at_contact
from camopt.model.effects.peak import MotionDerivative
from camopt.model.effects.self_crossing import proved_uncrossed_roller_radius
from camopt.model.mechanisms.design import SECOND_SIZE, Designs, FurtherContact
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.constraints import AnyConstraint, ConstantBound, Constraint
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.tolerance_zones import NumberErrors, entries_of_train_numbers
from camopt.solve.verdicts.constraint_boxes import (
    BoxVerdict,
    NumberRanges,
    constraint_verdict_over_box,
    verdict_on_alternatives,
)
from camopt.solve.verdicts.effect_runs import can_effect_run_on_ranges, quantities_over_box, run_effects
from camopt.solve.verdicts.train_boxes import (
    constraint_verdict_over_trains,
    depends_on_train_errors,
    driven_motion_over_trains,
    limit_verdict_over_trains,
)
from camopt.solve.verdicts.train_means import mean_verdict_over_trains
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED, WORST_FIRST

BODY_FIELDS = ("size", SECOND_SIZE)
"""Sizes of cams: if a circle fits within the smallest base circle, it fits within all."""
SPEED_KEY = "cam.rpm"
DERIVATIVE_ROUNDING = 1e-13
"""Relative rounding error of a derivative of the motion; the jerk has the largest (``piecewise.TABLE_ERRORS``)."""
STEEPER_SHARES = (1e-6, 1e-3, 1e-2, 1e-1)
"""Relative excesses of the pressure angle in a box over that at its corners, tried in turn for a proof."""


def tolerance_ranges(problem: Problem, design: Designs) -> NumberRanges:
    """Ranges of the toleranced numbers of a design, by field."""
    nominal = nominal_toleranced_numbers(problem, design)
    return {f: (nominal[f] + zone.lower, nominal[f] + zone.upper) for f, zone in problem.zones.items()}


def nominal_toleranced_numbers(problem: Problem, design: Designs) -> NumberErrors:
    """Nominal values of the toleranced numbers of a design and its train, by field."""
    values = design.values
    return {f: float(values[f][0]) if f in values else problem.nominal_numbers[f] for f in problem.zones}


def limit_verdict_over_box(
    problem: Problem, limit: Limit, design: Designs, number_ranges: NumberRanges, budget: Budget = UNLIMITED
) -> BoxVerdict:
    """Verdict on a limit for all designs whose numbers, those of the train included, lie between ``number_ranges``.

    A limit on errors due to tolerances is decided for the nominal design alone.
    """
    if limit.is_on_motion_error:
        number_ranges = {}
    if limit.single_design_decider:
        return BoxVerdict(_self_crossing_verdict(problem, limit, design, number_ranges, budget))
    if entries_of_train_numbers(number_ranges):
        if depends_on_train_errors(problem, limit):
            if limit.mean_constraint is not None and not limit.constraints:
                return mean_verdict_over_trains(problem, limit.mean_constraint, design, number_ranges, budget)
            return limit_verdict_over_trains(problem, limit, design, number_ranges, budget)
        number_ranges = _ranges_without_train(number_ranges)
    if limit.is_infinite_on_motion(problem.programme):
        return BoxVerdict(BROKEN, design)
    constraints: list[AnyConstraint] = [
        *limit.constraints,
        *([] if limit.mean_constraint is None else [limit.mean_constraint]),
    ]
    if constraints and all(map(_is_on_motion_derivatives, constraints)):
        return _derivative_verdict_at_speeds(problem, limit, design, number_ranges)
    if limit.is_on_base_circle:
        least = {field: np.array([number_ranges[field][0]]) for field in BODY_FIELDS if field in number_ranges}
        return _verdict_by_quantities(problem, limit, design.with_values(least))
    if not constraints and (not number_ranges or limit.is_decided_by_motion_alone):
        return _verdict_by_quantities(problem, limit, design)
    if number_ranges and _can_interval_arithmetic_decide_limit(problem, limit):
        return _verdict_by_interval_arithmetic(problem, limit, design, number_ranges)

    def decide(constraint: AnyConstraint, ranges: NumberRanges) -> BoxVerdict:
        return constraint_verdict_over_box(problem, constraint, design, ranges, budget)

    verdicts = [
        *(decide(constraint, number_ranges) for constraint in constraints),
        *(verdict_on_alternatives(decide, condition, number_ranges) for condition in limit.contact_conditions),
    ]
    return min(verdicts, key=lambda each: WORST_FIRST.index(each.verdict), default=BoxVerdict(UNDECIDED))


def _self_crossing_verdict(
    problem: Problem, limit: Limit, design: Designs, number_ranges: NumberRanges, budget: Budget
) -> str:
    """Verdict on self-crossing: by the profile for one design, by the largest pressure angle for a box."""
    if number_ranges:
        proved = all(
            _proves_disc_without_self_crossing(problem, contact, design, number_ranges, budget)
            for contact in all_follower_contacts(problem.setup)
        )
        return HELD if proved else UNDECIDED
    assert limit.single_design_decider is not None
    broken = limit.single_design_decider(problem.setup, design, problem.programme)
    return UNDECIDED if broken is None else BROKEN if broken else HELD


def _can_interval_arithmetic_decide_limit(problem: Problem, limit: Limit) -> bool:
    """Whether interval arithmetic on the ranges of a box decides a limit."""
    effects = [require_effect(name, problem.setup) for name in limit.required_quantities]
    return bool(effects) and all(can_effect_run_on_ranges(effect, problem.setup) for effect in effects)


def _verdict_by_interval_arithmetic(
    problem: Problem, limit: Limit, design: Designs, number_ranges: NumberRanges
) -> BoxVerdict:
    """Verdict on a limit for a box, by interval arithmetic on its ranges."""
    box = design.with_values({n: Interval(np.array([a]), np.array([b])) for n, (a, b) in number_ranges.items()})
    excess = as_interval(limit.excess(quantities_over_box(problem, {*limit.required_quantities}, box, 1.0), box))
    return BoxVerdict(HELD if np.all(excess.high <= 0.0) else UNDECIDED)


def _ranges_without_train(number_ranges: NumberRanges) -> NumberRanges:
    """The ranges of ``number_ranges`` without those of the train."""
    trains = entries_of_train_numbers(number_ranges)
    return {field: limits for field, limits in number_ranges.items() if field not in trains}


def _derivative_verdict_at_speeds(
    problem: Problem, limit: Limit, design: Designs, number_ranges: NumberRanges
) -> BoxVerdict:
    """Verdict on a limit on a derivative of the motion, which is proportional to a power of the speed."""
    if speeds := number_ranges.get(SPEED_KEY):
        design = design.take([0, 0]).with_values({SPEED_KEY: np.array(speeds)})
    return _verdict_by_quantities(problem, limit, design, DERIVATIVE_ROUNDING)


def _is_on_motion_derivatives(constraint: AnyConstraint) -> bool:
    """Whether a constraint is on derivatives of the motion alone."""
    curves = (
        [constraint.curve] if isinstance(constraint, Constraint) else [make for make, _ in constraint.mean.curves]
    )
    return all(isinstance(curve, MotionDerivative) for curve in curves)


def _outward_error_bound_of_column(rows: DesignRows, name: str, relative_rounding: float) -> Any:
    """Largest outward difference of a quantity's true value from its column, with a relative rounding error."""
    outward = rows.outward.get(name, 0.0)
    value = np.where(np.isfinite(rows.columns[name]), rows.columns[name], 0.0)
    return outward + np.copysign(relative_rounding * np.abs(value), outward)


def _verdict_by_quantities(
    problem: Problem, limit: Limit, designs: Designs, relative_rounding: float = 0.0
) -> BoxVerdict:
    """Verdict on a limit for some designs, from the enclosures of its quantities in double precision.

    Quantities that depend only on sizes are compared without an enclosure.
    """
    rows = run_effects(EvaluationBlock(problem.setup, problem.programme, designs), limit.required_quantities)
    rows = replace(
        rows, outward={name: _outward_error_bound_of_column(rows, name, relative_rounding) for name in rows.columns}
    )
    outer, inner = (limit.excess(rows.columns_shifted_by_width_share(share), designs) for share in (1.0, -1.0))
    if np.all(outer <= 0.0):
        return BoxVerdict(HELD)
    broken = np.flatnonzero(inner > 0.0)
    return BoxVerdict(BROKEN, designs.take(broken[:1])) if broken.size else BoxVerdict(UNDECIDED)


def _proves_disc_without_self_crossing(
    problem: Problem, contact: FurtherContact, design: Designs, number_ranges: NumberRanges, budget: Budget
) -> bool:
    """Whether the largest pressure angle proves that no disc at one contact crosses itself."""
    name = "pressure_angle_max_deg"
    ranges = _ranges_without_train(number_ranges)
    corners = np.array([*product(*ranges.values())])
    at_corners = dict(zip(ranges, corners.T, strict=True))
    corner_designs = design.take(np.zeros(len(corners), dtype=int)).with_values(at_corners)
    columns = run_effects(
        block_at_contact(EvaluationBlock(problem.setup, problem.programme, corner_designs), contact), [name]
    ).columns_shifted_by_width_share(1.0)
    curve = FunctionAtContact(contact.mechanism.pressure, contact.local_designs)
    for steeper in STEEPER_SHARES:
        most = float(np.max(columns[name])) * (1.0 + steeper)
        if not most < 90.0:
            return False
        steepest = Constraint(curve, ALL_STROKES, LARGEST_MAGNITUDE, ConstantBound(float(np.tan(np.radians(most)))))
        decide = constraint_verdict_over_box if ranges == number_ranges else constraint_verdict_over_trains
        if decide(problem, steepest, design, number_ranges, budget).verdict == HELD:
            break
    else:
        return False
    box = design.with_values({n: Interval(np.array([a]), np.array([b])) for n, (a, b) in ranges.items()})
    turn: Any = (
        problem.programme
        if ranges == number_ranges
        else driven_motion_over_trains(problem, steepest, design, number_ranges)
    )
    if turn is None:
        return False
    block = replace(
        block_at_contact(EvaluationBlock(problem.setup, turn, box), contact), columns={name: np.array([most])}
    )
    half_width = as_interval(block.setup.pitch_to_flank_distance(block.designs))
    return bool(np.all(as_interval(proved_uncrossed_roller_radius(block)).low > half_width.high))
