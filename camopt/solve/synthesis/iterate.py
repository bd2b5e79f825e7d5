"""Solutions of a convex programme of free laws, without a solver's error."""

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
    """A solution: e and s₀ in units of the sizes, and the coefficients of each moving stroke."""

    lead: float
    height: float
    coefficients: tuple[FloatArray, ...]


def free_motions(model: ConvexModel) -> list[SplineMotion]:
    """The free motions of a programme."""
    return [motion for motion in model.motions if isinstance(motion, SplineMotion)]


def sampled_motions(model: ConvexModel) -> list[SplineMotion | FixedMotion]:
    """The motions of all strokes of a programme with free motions."""
    return [motion for motion in model.motions if isinstance(motion, SplineMotion | FixedMotion)]


def iterate_of(model: ConvexModel) -> Iterate:
    """The values of a solved programme."""
    sizes = float(model.sizes.lead.value), float(model.sizes.height.value)
    return Iterate(
        *sizes, without_solver_error(model.problem, [motion.coefficients.value for motion in free_motions(model)])
    )


def without_solver_error(problem: SynthesisProblem, coefficients: Sequence[FloatArray]) -> tuple[FloatArray, ...]:
    """Coefficients without a solver's error: as smooth where strokes meet as they have to be, and monotone.

    However small, an error there would be a jump of the acceleration, or a motion that turns back.
    """
    found = [np.array(each, dtype=float) for each in coefficients]
    _impose_mirror(problem, found)
    _impose_opposition(problem, found)
    for own, stroke in zip(found, problem.free_strokes, strict=True):
        if not stroke.is_move:
            np.clip(own, 0.0, 1.0, out=own)
            own[[0, -1]] = 0.0, 1.0
            if problem.monotone:
                np.maximum.accumulate(own, out=own)
    free = iter(found)
    ends = [_StrokeLaw(stroke, next(free) if stroke.is_free else None) for stroke in problem.strokes]
    for before, after in zip(ends, [*ends[1:], ends[0]], strict=True):
        _join_strokes(problem, before, after)
    return tuple(found)


def _impose_mirror(problem: SynthesisProblem, found: Sequence[FloatArray]) -> None:
    """Make coefficients of strokes that mirror each other do so."""
    own = dict(zip(problem.free_strokes, found, strict=True))
    for stroke, each in own.items():
        partner = problem.mirror_partner(stroke)
        if partner is not None and problem.strokes.index(stroke) <= problem.strokes.index(partner):
            (low, change), (low_there, change_there) = map(problem.law_offset_and_scale, (stroke, partner))
            there = low_there + change_there * own[partner][::-1]
            mean = (low + change * each + there) / 2.0
            each[:], own[partner][:] = (mean - low) / change, (mean[::-1] - low_there) / change_there


def _impose_opposition(problem: SynthesisProblem, found: Sequence[FloatArray]) -> None:
    """Make coefficients of strokes that are each other upside down so."""
    own = dict(zip(problem.free_strokes, found, strict=True))
    for one, other in problem.opposed_pairs:
        stroke, partner = problem.strokes[one], problem.strokes[other]
        if stroke.is_free:
            (low, change), (low_there, change_there) = map(problem.law_offset_and_scale, (stroke, partner))
            total = problem.sum_of_starts(one, other)
            mean = (low + change * own[stroke] + total - low_there - change_there * own[partner]) / 2.0
            own[stroke][:] = (mean - low) / change
            own[partner][:] = (total - mean - low_there) / change_there


class _StrokeLaw(NamedTuple):
    """A stroke, and the coefficients of its law if it is free."""

    stroke: Stroke
    coefficients: FloatArray | None


def _join_strokes(problem: SynthesisProblem, before: _StrokeLaw, after: _StrokeLaw) -> None:
    """Make two strokes that follow each other meet: free ones change, to what is asked there."""
    if before.coefficients is None and after.coefficients is None:
        return
    count = 1 + problem.continuity_at(before.stroke.end)
    state = _state_at_joint(problem, before, after, count)
    for side, last in ((before, True), (after, False)):
        if side.coefficients is not None:
            # y, y', y'' … as the law of a stroke has them
            low, change = problem.law_offset_and_scale(side.stroke)
            found = state / problem.motion_unit * side.stroke.angle ** np.arange(state.size)
            found[0] -= low
            by_law = np.asarray(found / change)
            by_law[0] = by_law[0] if side.stroke.is_move else float(last)
            _set_end_state(problem.splines_of(side.stroke), side.coefficients, by_law, last)


def _state_at_joint(problem: SynthesisProblem, before: _StrokeLaw, after: _StrokeLaw, count: int) -> FloatArray:
    """y, y', y'' … where two strokes meet: those of the one that keeps its law, or else those asked for."""
    if before.coefficients is None or after.coefficients is None:
        fixed = before.stroke if before.coefficients is None else after.stroke
        velocity = (fixed.high - fixed.low) / fixed.angle
        return np.array([fixed.high if before.coefficients is None else fixed.low, velocity, 0.0, 0.0])[:count]
    if {before.stroke.kind, after.stroke.kind} == {RISE, RETURN}:
        before.coefficients[-2] = before.coefficients[-1]  # no velocity: neither leaves its stroke
    low, change = problem.law_offset_and_scale(before.stroke)
    splines = problem.splines_of(before.stroke)
    values = [
        splines.value_matrix(np.array([1.0]), order).toarray()[0] @ before.coefficients for order in range(count)
    ]
    state = change * np.array(values) / before.stroke.angle ** np.arange(count)
    state[0] += low
    state *= problem.motion_unit
    for condition in problem.conditions:
        if condition.start == condition.end == before.stroke.end and condition.order < count:
            state[condition.order] = np.clip(state[condition.order], condition.low, condition.high)
    if not after.stroke.is_move:
        state[0] = after.stroke.low
    return state


def _set_end_state(splines: Splines, own: FloatArray, state: FloatArray, last: bool) -> None:
    """Give a law a state at an end, by its first coefficients or its last."""
    places = [-1 - order if last else order for order in range(state.size)]
    for order, place in enumerate(places):
        nearer = places[:order]
        if not state[1 : order + 1].any():
            own[place] = state[0]  # at rest, without rounding
            continue
        row = splines.value_matrix(np.array([1.0 if last else 0.0]), order).toarray()[0]
        own[place] = (state[order] - row[nearer] @ own[nearer]) / row[place]
