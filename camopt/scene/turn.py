"""Checks of the segments of a scene's turn."""

from collections.abc import Iterator, Sequence
from math import hypot, isfinite
from typing import TYPE_CHECKING, Any

from camopt.core.numerics.identity_cache import cached_by_identity
from camopt.core.quantities import DERIVATIVE_UNITS
from camopt.model.motion import LAWS
from camopt.model.motion.aliases import suggest_law_names
from camopt.model.motion.move_run import InfeasibleMoves
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import CONSTANT_VELOCITY, MOVE, MotionSegment, segment_lifts, segment_positions
from camopt.scene import tables
from camopt.scene.law_forms import NEAR_END, VALUE_IN_SCENE, Fault
from camopt.scene.mapping import finite_number_or_none, table_named, value_at_key
from camopt.scene.moves import check_moves, has_faultless_named_laws, programme_in_scene_units
from camopt.scene.own_laws import (
    is_move_law,
    move_law_names,
    own_law_values_by_name,
    stroke_law_names,
)
from camopt.scene.segments import ends_at_constant_velocity_start, following_segments, motion_segments_of_rows
from camopt.scene.sizes import known_number_or_none

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

LEAST_MOVE = {"angle": 1e-6, "lift": 1e-9}  # least angle [deg] and lift [mm or deg] of a rise or return
MOVE_POSITION_WORDS = (
    ", mm (deg when oscillating); only a move without a law may leave it out, before another move of the turn or "
    "before a stretch at constant velocity that has both to and velocity"
)
POSITION_ALTERNATIVES = {"rise": "lift", "return": "lift", CONSTANT_VELOCITY: "velocity"}
"""The key that may replace ``to``, by kind of segment."""
POSITIONED_KINDS = (MOVE, CONSTANT_VELOCITY)
KEYS_OF_SEGMENT = {
    "rise": ("lift", "to", "law"),
    "return": ("lift", "to", "law"),
    "dwell": (),
    MOVE: ("to", *DERIVATIVE_UNITS, "law", "through"),
    CONSTANT_VELOCITY: ("to", "velocity"),
}
"""The keys of each kind of segment, besides ``angle`` and ``per``."""


def check_turn(scene: "Scene") -> Iterator[Fault]:
    """Check that the turn closes in angle and displacement; without positions it never goes below its start."""
    rows = scene.motion
    for k, (row, after) in enumerate(zip(rows, following_segments(rows), strict=True), start=1):
        yield from _check_segment(scene, row, rows[k - 2], f"motion.{k}")
        if row.segment == MOVE and _move_needs_position(row, after, k == len(rows)):
            missing = "missing; " if row.to is None else "must be a number: "
            yield f"motion.{k}.to", VALUE_IN_SCENE, f"{missing}a move goes to a position{MOVE_POSITION_WORDS}"
    angles = [angle for row in rows if (angle := known_number_or_none(row.angle)) is not None]
    if rows and len(angles) == len(rows) and not abs(sum(angles) - 360.0) <= 360.0 * NEAR_END:
        yield "motion.angle", None, f"the angles add up to {sum(angles):.10g} deg, not to 360"
    if given := _segments_of_turn(scene):
        yield from list(_check_positions_of_turn(given)) or check_moves(scene, given)


def check_law_exists(law: Any, key: str, laws: tuple[str, ...]) -> Iterator[Fault]:
    """Check that a named law exists."""
    if isinstance(law, str) and law not in laws:
        yield key, law, f"must be a motion law; {suggest_law_names(law, laws)}"


@cached_by_identity(maxsize=1)  # computed once for all checks of a scene, as ``_segments_of_turn`` is
def segments_and_programme_of_scene(scene: "Scene") -> tuple[list[MotionSegment], Programme] | None:
    """The segments of a scene and their motion; None if a value is missing or wrong."""
    given = _segments_of_turn(scene)
    if not given or not has_faultless_named_laws(scene, given):
        return None
    try:
        return given, programme_in_scene_units(scene, given)
    except InfeasibleMoves:  # check_moves reports it
        return None


def highest_displacement(scene: "Scene") -> float | None:
    """Largest displacement of the turn above its lowest [mm or deg]; None where unknown."""
    given = _segments_of_turn(scene)
    if not given:
        return None
    ends = segment_positions(given)
    overshoots = any(law.overshoot is True for law in scene.laws.values())
    if (overshoots or any(segment.segment == MOVE for segment in given)) and has_faultless_named_laws(scene, given):
        return turn[1].lift if (turn := segments_and_programme_of_scene(scene)) else None
    return max(ends) - min(ends) if isfinite(hypot(*ends)) else None


# --------------------------------------------------------------------------------------------------- segments


@cached_by_identity(maxsize=1)
def _segments_of_turn(scene: "Scene") -> list[MotionSegment] | None:
    """The segments in the form of ``model.motion``; None if a number or a kind is missing or wrong."""
    rows = scene.motion
    if scene.has_refused_value("motion"):
        return None
    for row, after in zip(rows, following_segments(rows), strict=True):
        if row.segment == MOVE:
            has_wrong_law = row.law is not None and not is_move_law(own_law_values_by_name(scene).get(row.law))
            is_unknown = has_wrong_law or _move_needs_position(row, after, row is rows[-1])
        else:
            key = POSITION_ALTERNATIVES.get(row.segment)
            lacks_end = row.to is None and key and (key not in row.model_fields_set or getattr(row, key) is None)
            is_unknown = lacks_end or any(isinstance(getattr(row, n), tuple) for n in ("to", *DERIVATIVE_UNITS))
        if is_unknown or row.angle < (0.0 if row.segment == "dwell" else LEAST_MOVE["angle"]):
            return None
    return motion_segments_of_rows(rows, known_number_or_none(scene.cam.rpm))


def _check_segment(scene: "Scene", row: tables.Segment, before: tables.Segment, key: str) -> Iterator[Fault]:
    kind = row.segment
    if kind not in KEYS_OF_SEGMENT:
        return
    named = "a stretch at constant velocity" if kind == CONSTANT_VELOCITY else f"a {kind}"
    for name in ("lift", "to", "law", "through", *DERIVATIVE_UNITS):
        value = getattr(row, name)
        if name not in KEYS_OF_SEGMENT[kind] and value not in (None, (), *([0.0] if name == "lift" else [])):
            yield f"{key}.{name}", VALUE_IN_SCENE, f"{named} has none{_replacement_hint(kind, name)}"
        elif kind != MOVE and name != "through" and isinstance(value, tuple):
            yield f"{key}.{name}", VALUE_IN_SCENE, "must be a number; only a move may have a range"
    if kind != "dwell" and (angle := known_number_or_none(row.angle)) is not None and angle < LEAST_MOVE["angle"]:
        where = "a rise or return" if kind in ("rise", "return") else named
        yield f"{key}.angle", VALUE_IN_SCENE, f"must be at least {LEAST_MOVE['angle']:g} in {where}"
    if kind in ("rise", "return"):
        yield from _check_stroke(scene, row, key)
    elif kind == CONSTANT_VELOCITY:
        yield from _check_constant_velocity(row, before, key)
    if row.law is not None and "law" in KEYS_OF_SEGMENT[kind]:
        yield from _check_segment_law(scene, kind, row.law, f"{key}.law")
    if row.per == "s":
        yield from _check_per_second_needs_speed(scene, key)


def _check_segment_law(scene: "Scene", kind: str, law: str, key: str) -> Iterator[Fault]:
    """Check that a named law exists, and that a move has a law of positions."""
    laws = own_law_values_by_name(scene)
    if law not in LAWS and law not in laws:
        yield from check_law_exists(law, key, move_law_names(laws) if kind == MOVE else stroke_law_names(laws))
    elif kind == MOVE and not is_move_law(laws.get(law)):
        yield (
            key,
            law,
            "is for a rise or return; a move takes a law of positions (one of [laws] with positions), or none",
        )
    elif kind != MOVE and is_move_law(laws.get(law)):
        yield key, law, "is a law of positions, for a move"


def _move_needs_position(row: tables.Segment, after: tables.Segment, is_last_segment: bool) -> bool:
    """Whether a move must give its position as a number: if the next segment or the next turn starts there.

    A move with a law must give it too.
    """
    free = row.law is None and (
        ends_at_constant_velocity_start(row, after) or (after.segment == MOVE and not is_last_segment)
    )
    return finite_number_or_none(row.to) is None and not free


def _replacement_hint(kind: str, name: str) -> str:
    """The key to use in place of one that a kind of segment does not have."""
    if kind in POSITIONED_KINDS and name == "lift":
        return ": give the position at its end (to)"
    return ": conditions are for a move" if name in (*DERIVATIVE_UNITS, "through") else ""


def set_first_searched_laws(data: dict[str, Any]) -> None:
    """Set the law of each rise and return without one to the first law of ``[search]``, in ``data`` itself."""
    for row in data["motion"] if isinstance(data.get("motion"), list) else ():
        if isinstance(row, dict) and row.get("segment") in ("rise", "return") and row.get("law") is None:
            named = [value_at_key(data, f"search.{key}") for key in ("law", f"law_{row['segment']}")]
            laws = [law for each in named if each for law in (each if isinstance(each, list) else [each])]
            row |= {"law": laws[0]} if laws and laws[0] in stroke_law_names(table_named(data, "laws")) else {}


def _check_stroke(scene: "Scene", row: tables.Segment, key: str) -> Iterator[Fault]:
    """Check that a rise or return has a law, and either a lift or a position at its end."""
    if row.law is None and not (scene.search.law or getattr(scene.search, f"law_{row.segment}")):
        yield f"{key}.law", None, "missing; a rise or return needs a motion law, here or in [search]"
    lift = known_number_or_none(row.lift)
    if row.to is not None:
        if lift:
            yield f"{key}.lift", VALUE_IN_SCENE, "give either the lift or the position at its end (to)"
    elif "lift" not in row.model_fields_set:
        yield f"{key}.lift", None, "missing; give the lift or the position at its end (to)"
    elif lift is not None and lift < LEAST_MOVE["lift"]:
        yield f"{key}.lift", VALUE_IN_SCENE, f"must be at least {LEAST_MOVE['lift']:g} in a rise or return"


def _check_constant_velocity(row: tables.Segment, before: tables.Segment, key: str) -> Iterator[Fault]:
    """Check that a constant velocity has a position at its end or a velocity; both only after a free move."""
    if row.to is None and row.velocity is None:
        yield f"{key}.to", None, "missing; give the position at its end (to) or the velocity"
    elif None not in (row.to, row.velocity) and not ends_at_constant_velocity_start(before, row):
        why = "give either the velocity or the position at its end (to): the segment before sets the start"
        yield f"{key}.velocity", VALUE_IN_SCENE, why


def _check_per_second_needs_speed(scene: "Scene", key: str) -> Iterator[Fault]:
    if scene.cam.rpm is None:
        yield f"{key}.per", "s", "derivatives by time need the speed: give cam.rpm, or use per deg or per rad"
    elif scene.search.choices_by_key.get("cam.rpm") is not None:
        yield f"{key}.per", "s", "search.cam.rpm varies the speed, which would change the motion: use deg or rad"


# ----------------------------------------------------------------------------------------------------- levels


def _check_positions_of_turn(segments: Sequence[MotionSegment]) -> Iterator[Fault]:
    """Check that rises go up and returns down; without positions, that the turn closes and ends at its lowest."""
    ends, largest = segment_positions(segments), max(map(abs, segment_lifts(segments)), default=0.0)
    positioned = any(segment.to is not None for segment in segments)
    kinds = [segment.segment for segment in segments]
    if not positioned and "rise" not in kinds and CONSTANT_VELOCITY not in kinds:
        yield "motion", None, "has no rise"
    conditioned = any(any(segment.wanted) or segment.through or segment.between for segment in segments)
    if positioned and largest == 0.0 and not conditioned:
        yield "motion", None, "never moves: all positions are equal"
    for k, (segment, before, after) in enumerate(zip(segments, ends, ends[1:], strict=False), start=1):
        if segment.to is not None and segment.segment in ("rise", "return"):
            up = segment.segment == "rise"
            if not (after - before if up else before - after) >= LEAST_MOVE["lift"]:
                way = "above" if up else "below"
                yield (
                    f"motion.{k}.to",
                    VALUE_IN_SCENE,
                    f"must be {way} {before:g}, where this {segment.segment} starts",
                )
                return
        if not positioned and after < -largest * NEAR_END:
            yield _below_start_fault(segments, k, before)
            return
    if not positioned and abs(ends[-1]) > largest * NEAR_END:
        yield "motion.lift", None, f"the follower ends {ends[-1]:g} above its start: rises and returns must cancel"


def _below_start_fault(segments: Sequence[MotionSegment], segment_number: int, position_before: float) -> Fault:
    """The fault of a return that goes below the start of the turn, where the follower is lowest."""
    if "rise" not in [each.segment for each in segments[:segment_number]]:
        why = "the turn starts where the follower is lowest: a rise must come before the first return"
        return f"motion.{segment_number}.segment", VALUE_IN_SCENE, why
    why = f"must be at most {position_before:g}: the follower never goes below the start of the turn"
    return f"motion.{segment_number}.lift", VALUE_IN_SCENE, why
