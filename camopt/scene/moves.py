"""Checks of the conditions on moves: that they can be met, and that a named law meets them."""

from collections.abc import Iterator, Sequence
from itertools import accumulate
from math import radians
from typing import TYPE_CHECKING

import numpy as np

from camopt.core.mistakes import join_words
from camopt.model.motion import LAWS
from camopt.model.motion.law import Law
from camopt.model.motion.move_run import InfeasibleMoves
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import MOVE, MotionSegment, segment_positions
from camopt.model.motion.stroke import ALL_STROKES, DERIVATIVE_NAMES, SOLVER_TOLERANCE, Stroke, required_range
from camopt.scene.law_forms import NEAR_END, VALUE_IN_SCENE, Fault
from camopt.scene.own_laws import check_laws, laws_of_scene, make_own_law_from_values, own_law_values_by_name
from camopt.scene.tables import Segment

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

INSIDE_MOVE = 1e-6  # share of a move: least distance of a condition from its ends, and least length of a range
MOVE_SAMPLES = 257  # cam angles of a move


def check_moves(scene: "Scene", segments: Sequence[MotionSegment]) -> Iterator[Fault]:
    """Every fault of the conditions on moves, if segments and laws are faultless by themselves."""
    faults = list(_check_condition_angles_in_move(scene.motion))
    yield from faults
    if faults or not has_faultless_named_laws(scene, segments):
        return
    if any(segment.law for segment in segments if segment.segment == MOVE):
        yield from _check_move_laws(scene, segments)
    if not any(segment.segment == MOVE and segment.law is None for segment in segments):
        return
    try:
        if programme_in_scene_units(scene, segments).lift == 0.0:
            yield "motion", None, "never moves: no position or condition differs from its start"
    except InfeasibleMoves as contradiction:
        first, *others = contradiction.keys
        why = f"contradicts {join_words(others)}: {contradiction.headline}"
        if not others:
            others_text = "the segments next to the moves, or the positions at their ends (to)"
            why = f"contradicts {others_text}: {contradiction.headline.replace('all of these', 'both')}"
        yield first, None, f"{why}; leave one out, or give a wider range"


def has_faultless_named_laws(scene: "Scene", segments: Sequence[MotionSegment]) -> bool:
    """Whether all laws that segments name exist, and the laws of the scene have no faults."""
    names = (segment.law for segment in segments if segment.law is not None)
    if scene.has_refused_value("laws") or not all(name in LAWS or name in scene.laws for name in names):
        return False
    laws = own_law_values_by_name(scene)
    return all(law["file"] is None for law in laws.values()) and not any(check_laws({"laws": laws}))


def programme_in_scene_units(scene: "Scene", segments: Sequence[MotionSegment]) -> Programme:
    """The motion of faultless laws and segments, with displacements in the scene's unit."""
    return Programme.from_segments(segments, angular=False, laws=laws_of_scene(scene))


def _check_move_laws(scene: "Scene", segments: Sequence[MotionSegment]) -> Iterator[Fault]:
    """Check that a law of positions starts and ends where its move does, and meets the conditions at its end."""
    tables, ends = own_law_values_by_name(scene), segment_positions(segments)
    named = (tables[segment.law]["positions"] for segment in segments if segment.segment == MOVE and segment.law)
    room = NEAR_END * max(max(ends) - min(ends), *(max(map(abs, positions)) for positions in named))
    starts = [0.0, *accumulate(segment.angle for segment in segments)]
    for k, (segment, before, after) in enumerate(zip(segments, ends, ends[1:], strict=False), start=1):
        if segment.segment != MOVE or segment.law is None:
            continue
        positions = tables[segment.law]["positions"]
        for place, end, word in ((0, before, "starts"), (-1, after, "ends")):
            if abs(positions[place] - end) > room:
                why = f"{word} at {positions[place]:.10g}; the move {word} at {end:.10g}"
                yield f"motion.{k}.law", segment.law, why
                return
        through = tuple(each._replace(start=radians(each.start), end=radians(each.end)) for each in segment.through)
        asked = segment._replace(through=through)
        yield from _unmet_conditions(
            make_own_law_from_values(segment.law, tables[segment.law]), asked, before, starts[k - 1], f"motion.{k}"
        )


def _check_condition_angles_in_move(rows: Sequence[Segment]) -> Iterator[Fault]:
    """Check that conditions within a move are at cam angles inside it, and are not empty."""
    turned = 0.0
    for k, row in enumerate(rows, start=1):
        before, turned = turned, turned + row.angle
        for number_, each in enumerate(row.through, start=1):
            key = f"motion.{k}.through.{number_}"
            start, end = required_range(each.angle)
            room = INSIDE_MOVE * row.angle
            if all(getattr(each, name) is None for name in DERIVATIVE_NAMES):
                names = f"{', '.join(DERIVATIVE_NAMES[:-1])} or {DERIVATIVE_NAMES[-1]}"
                yield key, None, f"has no condition: give {names}"
            elif start == end and not before + room <= start <= turned - room:
                what = f"must be inside the move, between {before:g} and {turned:g} deg of the turn"
                yield f"{key}.angle", VALUE_IN_SCENE, f"{what}; for its end use to, velocity, …"
            elif start < end and not (before - room <= start and end <= turned + room and end - start >= room):
                what = f"must be a range within the move, from {before:g} to {turned:g} deg of the turn"
                yield f"{key}.angle", VALUE_IN_SCENE, what


def _unmet_conditions(
    law: Law, segment: MotionSegment, start_position: float, start_angle_deg: float, key: str
) -> Iterator[Fault]:
    """The conditions of a move that its law does not meet."""
    start, angle = radians(start_angle_deg), radians(segment.angle)
    stroke = Stroke(
        ALL_STROKES,
        law,
        start,
        angle,
        start_position,
        start_position + 1.0,
        None,
        (None, *segment.wanted),
        segment.through,
        key,
    )
    largest = np.abs(stroke.motion(np.linspace(start, start + angle, MOVE_SAMPLES))).max(axis=1)
    for each in stroke.conditions():
        room = SOLVER_TOLERANCE[each.order] * largest[each.order]
        values = stroke.values_under_condition(each)
        for value in (float(values.min()), float(values.max())):
            if not each.low - room <= value <= each.high + room:
                wanted = f"{each.low:.6g}" if each.low == each.high else f"{each.low:.6g} to {each.high:.6g}"
                unit = "" if each.order == 0 else f" by rad{('', '²', '³')[each.order - 1]}"
                why = f"has {each.key.rpartition('.')[2]} {value:.6g}{unit}; {each.key} requires {wanted}"
                yield f"{key}.law", segment.law, why
                break
