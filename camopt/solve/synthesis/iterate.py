"""Solutions of a convex programme of free laws, corrected for the solver's error."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.motion.stroke import RETURN, RISE, Stroke
from camopt.solve.synthesis.convex_model import ConvexModel
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.splines import Splines
from camopt.solve.synthesis.stroke_motion import FixedMotion
from camopt.solve.synthesis.synthesis_problem import SynthesisProblem


class Iterate(NamedTuple):
    """A solution: e and s₀ in units of the sizes, and the coefficients of each free stroke."""

    lead: float
    height: float
    coefficients: tuple[FloatArray, ...]


def free_stroke_motions(model: ConvexModel) -> list[SplineMotion]:
    return [motion for motion in model.motions if isinstance(motion, SplineMotion)]


def spline_and_fixed_motions(model: ConvexModel) -> list[SplineMotion | FixedMotion]:
    """The motions of all strokes of a model with free motions."""
    return [motion for motion in model.motions if isinstance(motion, SplineMotion | FixedMotion)]


def iterate_of(model: ConvexModel) -> Iterate:
    """The solution of a solved model."""
    return Iterate(
        float(model.sizes.lead.value),
        float(model.sizes.height.value),
        without_solver_error(model.problem, [motion.coefficients.value for motion in free_stroke_motions(model)]),
    )


def without_solver_error(problem: SynthesisProblem, coefficients: Sequence[FloatArray]) -> tuple[FloatArray, ...]:
    """Coefficients corrected for the solver's error: monotone, and as smooth at joints as the problem requires.

    Even a tiny error would be a jump of the acceleration, or a motion that turns back.
    """
    corrected = [np.array(values, dtype=float) for values in coefficients]
    _impose_mirror(problem, corrected)
    _impose_opposition(problem, corrected)
    for law_coefficients, stroke in zip(corrected, problem.free_strokes, strict=True):
        if not stroke.is_move:
            np.clip(law_coefficients, 0.0, 1.0, out=law_coefficients)
            law_coefficients[[0, -1]] = 0.0, 1.0
            if problem.monotone:
                np.maximum.accumulate(law_coefficients, out=law_coefficients)
    free = iter(corrected)
    stroke_laws = [
        _StrokeLaw(stroke, next(free) if stroke.is_law_replaceable else None) for stroke in problem.strokes
    ]
    for before, after in zip(stroke_laws, [*stroke_laws[1:], stroke_laws[0]], strict=True):
        _join_strokes(problem, before, after)
    return tuple(corrected)


def _impose_mirror(problem: SynthesisProblem, coefficients: Sequence[FloatArray]) -> None:
    """Make the coefficients of mirrored strokes mirror images, in place."""
    by_stroke = dict(zip(problem.free_strokes, coefficients, strict=True))
    for stroke, values in by_stroke.items():
        partner = problem.mirror_partner(stroke)
        if partner is not None and problem.strokes.index(stroke) <= problem.strokes.index(partner):
            (low, change), (partner_low, partner_change) = map(problem.law_offset_and_scale, (stroke, partner))
            mirrored = partner_low + partner_change * by_stroke[partner][::-1]
            mean = (low + change * values + mirrored) / 2.0
            values[:], by_stroke[partner][:] = (mean - low) / change, (mean[::-1] - partner_low) / partner_change


def _impose_opposition(problem: SynthesisProblem, coefficients: Sequence[FloatArray]) -> None:
    """Make the coefficients of opposed strokes add up to a constant, in place."""
    by_stroke = dict(zip(problem.free_strokes, coefficients, strict=True))
    for one, other, total in problem.opposed_pairs:
        stroke, partner = problem.strokes[one], problem.strokes[other]
        if stroke.is_law_replaceable:
            (low, change), (partner_low, partner_change) = map(problem.law_offset_and_scale, (stroke, partner))
            mean = (
                low + change * by_stroke[stroke] + total - partner_low - partner_change * by_stroke[partner]
            ) / 2.0
            by_stroke[stroke][:] = (mean - low) / change
            by_stroke[partner][:] = (total - mean - partner_low) / partner_change


class _StrokeLaw(NamedTuple):
    """A stroke, and the coefficients of its law if it is free."""

    stroke: Stroke
    coefficients: FloatArray | None


def _join_strokes(problem: SynthesisProblem, before: _StrokeLaw, after: _StrokeLaw) -> None:
    """Make two consecutive strokes meet with the required continuity: free strokes change, in place."""
    if before.coefficients is None and after.coefficients is None:
        return
    count = 1 + problem.required_continuity_at_joint(before.stroke.end)
    state = _required_state_at_joint(problem, before, after, count)
    for side, last in ((before, True), (after, False)):
        if side.coefficients is not None:
            # y, y', y'' … by x of the unit stroke
            low, change = problem.law_offset_and_scale(side.stroke)
            unit_state = state / problem.motion_unit * side.stroke.angle ** np.arange(state.size)
            unit_state[0] -= low
            law_state = np.asarray(unit_state / change)
            law_state[0] = law_state[0] if side.stroke.is_move else float(last)
            _set_end_state(problem.splines_by_stroke[side.stroke], side.coefficients, law_state, last)


def _required_state_at_joint(
    problem: SynthesisProblem, before: _StrokeLaw, after: _StrokeLaw, derivative_count: int
) -> FloatArray:
    """y, y', y'' … where two strokes meet: those of the stroke that keeps its law, or else as required there."""
    if before.coefficients is None or after.coefficients is None:
        fixed = before.stroke if before.coefficients is None else after.stroke
        velocity = (fixed.high - fixed.low) / fixed.angle
        return np.array([fixed.high if before.coefficients is None else fixed.low, velocity, 0.0, 0.0])[
            :derivative_count
        ]
    if {before.stroke.kind, after.stroke.kind} == {RISE, RETURN}:
        before.coefficients[-2] = before.coefficients[-1]  # no velocity: neither leaves its stroke
    low, change = problem.law_offset_and_scale(before.stroke)
    splines = problem.splines_by_stroke[before.stroke]
    values = [
        splines.value_matrix(np.array([1.0]), order).toarray()[0] @ before.coefficients
        for order in range(derivative_count)
    ]
    state = change * np.array(values) / before.stroke.angle ** np.arange(derivative_count)
    state[0] += low
    state *= problem.motion_unit
    for condition in problem.conditions:
        if condition.start == condition.end == before.stroke.end and condition.order < derivative_count:
            state[condition.order] = np.clip(state[condition.order], condition.low, condition.high)
    if not after.stroke.is_move:
        state[0] = after.stroke.low
    return state


def _set_end_state(splines: Splines, coefficients: FloatArray, state: FloatArray, last: bool) -> None:
    """Give a law a state at an end, by its first coefficients or its last."""
    places = [-1 - order if last else order for order in range(state.size)]
    for order, place in enumerate(places):
        nearer = places[:order]
        if not state[1 : order + 1].any():
            coefficients[place] = state[0]  # at rest, exactly
        else:
            row = splines.value_matrix(np.array([1.0 if last else 0.0]), order).toarray()[0]
            coefficients[place] = (state[order] - row[nearer] @ coefficients[nearer]) / row[place]
