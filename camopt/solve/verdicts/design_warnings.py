"""Warnings about a design: lost contact, small preload, stress at low speed, a steep groove, overshoot."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import degrees, inf, isfinite
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.mistakes import Unmet
from camopt.core.numerics.piecewise import sign_changes
from camopt.core.quantities import displacement_unit
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects import EvaluationBlock, available_quantities
from camopt.model.effects.hertz import STRESS
from camopt.model.effects.preload import PRELOAD_RATIO
from camopt.model.effects.pressure import BOTTOM_ANGLE
from camopt.model.motion.move_joints import strokes_with_move_laws
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import start_position
from camopt.model.motion.stroke import Stroke
from camopt.scene.problem.problem import Problem
from camopt.solve.tables.cells import with_unit
from camopt.solve.verdicts.effect_runs import run_effects

MEAN_ANGLES = {"pressure_angle_max_rise_deg", "pressure_angle_max_return_deg"}  # at the mean radius
SLOW_SHARE = 1e-3  # share of the cam's speed at which inertia is negligible
NOTICED_SHARE = 1e-3  # relative difference of stresses that is worth a warning
RIGID, ELASTIC = "contact_force_min_N", "contact_force_elastic_min_N"
REACHED_SHARE = 1e-6  # share of the lift within which a position counts as reached
SIDE_NAMES = {1.0: "above", -1.0: "below"}


def warnings_of_design(problem: Problem) -> tuple[str, ...]:
    """Warnings about the problem's own design."""
    checks = (
        _warn_contact_lost_by_elastic_train,
        _warn_lost_preload,
        _warn_low_speed_stress_over_limit,
        _warn_steep_groove_bottom,
        _warn_overshoot,
    )
    return tuple(sentence for check in checks for sentence in check(problem))


def _warn_contact_lost_by_elastic_train(problem: Problem) -> Iterator[str]:
    """Warn if the elastic train loses contact and a rigid one does not, unless a limit says so."""
    setup = problem.setup
    limited = any(ELASTIC in limit.required_quantities for limit in problem.limits)
    if setup.mechanism.is_positive_drive or limited or not {RIGID, ELASTIC}.issubset(available_quantities(setup)):
        return
    rigid, elastic = _design_quantities(problem, RIGID, ELASTIC)
    if elastic <= 0.0 < rigid:
        least = (
            f"its smallest force is {_text_with_four_digits_and_unit(elastic, 'N')}"
            if isfinite(elastic)
            else "it is in resonance"
        )
        train = f"the elastic train (natural frequency {setup.dynamics.natural_frequency:g} Hz) loses contact"
        remedy = "limits.contact_force_elastic = 0 requires contact"
        yield f"{train}: {least}, that of a rigid train {_text_with_four_digits_and_unit(rigid, 'N')}; {remedy}"


def _warn_lost_preload(problem: Problem) -> Iterator[str]:
    """Warn if the preload of two contacts lets one of them open, unless a limit says so."""
    if PRELOAD_RATIO not in available_quantities(problem.setup) or any(
        PRELOAD_RATIO in limit.required_quantities for limit in problem.limits
    ):
        return
    (ratio,) = _design_quantities(problem, PRELOAD_RATIO)
    if ratio < 1.0:
        speed = f"at {problem.setup.rpm:g} rev/min"
        share = f"the preload is {ratio:.4g} times the preload that keeps both contacts closed {speed}"
        yield f"{share}; limits.{PRELOAD_RATIO} = 1 requires it"


def _warn_low_speed_stress_over_limit(problem: Problem) -> Iterator[str]:
    """Warn if the contact stress exceeds its limit at low speed, where inertia does not relieve it."""
    setup = problem.setup
    limits = [limit for limit in problem.limits if STRESS in limit.required_quantities]
    if limits and setup.rpm is not None:  # a knife edge exceeds the limit at any speed
        slow = replace(problem, setup=setup.with_numbers({"cam.rpm": setup.rpm * SLOW_SHARE}))
        (slowly,), limit = _design_quantities(slow, STRESS), limits[0]
        allowed = limit.bound * (1.0 + NOTICED_SHARE)
        if slowly > allowed and (stress := _design_quantities(problem, STRESS)[0]) <= allowed:
            stress_text = _text_with_four_digits_and_unit(stress, "MPa")
            at_speed = f"{stress_text} at {setup.rpm:g} rev/min, where inertia relieves it"
            limit_text = f"{limit.key} ({_text_with_four_digits_and_unit(limit.bound, 'MPa')})"
            beyond = f"is {_text_with_four_digits_and_unit(slowly, 'MPa')} at low speed, above {limit_text}"
            yield f"the contact stress {beyond}, and {at_speed}"


def _text_with_four_digits_and_unit(value: float, unit: str) -> str:
    return f"{to_shown_unit(value, unit):.4g} {unit_in_shown_system(unit)}"


def _warn_steep_groove_bottom(problem: Problem) -> Iterator[str]:
    """Warn if the pressure angle at the bottom of a groove exceeds the limit, which holds at the mean radius."""
    limits = [limit for limit in problem.limits if MEAN_ANGLES & {*limit.required_quantities}]
    limited = any(BOTTOM_ANGLE in limit.required_quantities for limit in problem.limits)
    if limits and not limited and BOTTOM_ANGLE in available_quantities(problem.setup):
        (angle,), limit = _design_quantities(problem, BOTTOM_ANGLE), max(limits, key=attrgetter("bound"))
        if angle > limit.bound:
            foot = problem.setup.mechanism.body.foot
            scope = f"{limit.key} ({limit.bound:g} deg) holds only at the mean radius"
            remedy = f"limits.{BOTTOM_ANGLE} = {limit.bound:g} limits it there"
            yield f"the pressure angle at {foot} is {angle:.4g} deg; {scope}; {remedy}"


def _design_quantities(problem: Problem, *names: str) -> list[float]:
    """Some quantities of the problem's own design."""
    columns = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), {*names}).columns
    return [float(np.broadcast_to(columns[name], 1)[0]) for name in names]


class FarthestPoint(NamedTuple):
    """The farthest position of a motion to one side [mm or rad from the base circle], its cam angle and stroke."""

    position: float
    angle: float
    stroke: int


def _warn_overshoot(problem: Problem) -> Iterator[str]:
    """Warn of moves beyond every position in the scene, unless a velocity in the scene causes it."""
    programme, strokes = problem.given_motion, problem.given_motion.strokes
    for side in (side for side in SIDE_NAMES if _moves_exceed_given_positions(programme, side)):
        extreme, farthest = farthest_point(programme, side), _farthest_given_position(programme, side)
        number, stroke = extreme.stroke, strokes[extreme.stroke]
        ends = ((number - 1, stroke.start), (number, stroke.end))
        fixed = [angle for k, angle in ends if not _has_free_end_velocity(strokes, k)]
        moving = np.abs(stroke.motion(np.array(fixed))[1]) * stroke.angle
        if np.any(moving > REACHED_SHARE * programme.lift):
            continue  # the stroke must start or end moving, as next to a segment of constant velocity
        start = start_position(problem.segments) - programme.strokes[0].low / programme.unit_in_mm_or_rad
        unit = displacement_unit(angular=problem.given_motion_is_angle)
        at, most = (
            with_unit(start + position / programme.unit_in_mm_or_rad, unit)
            for position in (extreme.position, farthest)
        )
        reached = f"the motion goes to {at} at {degrees(extreme.angle):.4g}°"
        remedy = _overshoot_remedy(programme, side)
        yield f"{reached}, {SIDE_NAMES[side]} every position in the scene ({most}); {remedy}"


def _moves_exceed_given_positions(programme: Programme, side: float) -> bool:
    """Whether moves go to one side beyond every position in the scene."""
    if not any(stroke.law_follows_from_neighbours for stroke in programme.strokes):
        return False
    beyond = side * (farthest_point(programme, side).position - _farthest_given_position(programme, side))
    return beyond > REACHED_SHARE * programme.lift


def _farthest_given_position(programme: Programme, side: float) -> float:
    """The farthest position to one side in the scene, or at the end of a stroke with a fixed law."""
    strokes = programme.strokes
    positions = [
        side * end
        for stroke in strokes
        if not stroke.law_follows_from_neighbours
        for end in (stroke.low, stroke.high)
    ]
    for stroke in (stroke for stroke in strokes if stroke.law_follows_from_neighbours):
        ends = (
            c.high if side > 0.0 else c.low for c in stroke.conditions_in_mm_or_rad(strokes[0].low) if c.order == 0
        )
        positions += [side * end for end in ends if isfinite(end)]
    return side * max(positions, default=-inf)


def farthest_point(programme: Programme, side: float) -> FarthestPoint:
    """The farthest position to one side, at an end of a panel or where the velocity changes sign."""
    table = programme.table
    series, panels = table.coefficients.T, range(table.centre.size)
    places = [
        *sign_changes(np.asarray(polynomial.polyder(series))),
        *((panel, u) for panel in panels for u in (-1.0, 1.0)),
    ]
    positions = [float(polynomial.polyval(u, series[:, panel])) for panel, u in places]
    best = int(np.argmax(side * np.array(positions)))
    panel, u = places[best]
    angle = float(table.centre[panel] + table.half_width[panel] * u)
    starts = [stroke.start for stroke in programme.strokes]
    return FarthestPoint(
        positions[best], angle, int(np.searchsorted(starts, table.centre[panel], side="right")) - 1
    )


def _has_free_end_velocity(strokes: Sequence[Stroke], stroke_number: int) -> bool:
    """Whether the scene leaves the velocity at the end of a stroke open, between two moves."""
    stroke, following = strokes[stroke_number], strokes[(stroke_number + 1) % len(strokes)]
    return (
        stroke.law_follows_from_neighbours
        and following.law_follows_from_neighbours
        and (stroke.wanted or ())[1:2] in ((), (None,))
    )


def _overshoot_remedy(programme: Programme, side: float) -> str:
    """Remedy that keeps the motion within the positions in the scene: rest at an end, or more positions."""
    strokes, here = programme.strokes, farthest_point(programme, side).stroke
    changes = [stroke.high - stroke.low for stroke in strokes]
    noses = [k for k in range(len(strokes)) if changes[k] * changes[(k + 1) % len(strokes)] <= 0.0]
    for numbers in ([here], [here - 1], noses):
        ends = [strokes[k] for k in numbers if _has_free_end_velocity(strokes, k)]
        if ends and _rest_keeps_within_positions(programme, ends, side):
            keys = " and ".join(f"{end.key}.velocity = 0" for end in ends)
            return f"{keys} {'stops' if len(ends) == 1 else 'stop'} it"
    return f"a position in {strokes[here].key}.through stops it"


def _rest_keeps_within_positions(programme: Programme, ends: Sequence[Stroke], side: float) -> bool:
    """Whether rest at the ends of some moves keeps the motion within the positions in the scene."""
    strokes = [_with_rest_at_end(stroke) if stroke in ends else stroke for stroke in programme.strokes]
    try:
        return not _moves_exceed_given_positions(
            replace(programme, strokes=strokes_with_move_laws(tuple(strokes))).on_base_circle(), side
        )
    except Unmet:  # other conditions forbid the rest
        return False


def _with_rest_at_end(move: Stroke) -> Stroke:
    position, _, *others = (*(move.wanted or ()), None, None)[:4]
    return replace(move, wanted=(position, 0.0, *others))
