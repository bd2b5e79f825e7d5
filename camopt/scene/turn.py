"""The turn of a scene: the checks of its segments.

The checks work on the plain mapping of a scene, as those of ``scene.checks`` do.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from math import hypot, isfinite
from typing import Any

from camopt.motion import LAWS
from camopt.motion.aliases import nearest_law
from camopt.motion.programme import Programme
from camopt.motion.run import Contradiction
from camopt.motion.segments import CONSTANT_VELOCITY, MOVE, GivenSegment, lifts_of, positions_of
from camopt.numerics.same import Same
from camopt.quantities import DERIVATIVES
from camopt.scene import tables
from camopt.scene.law_forms import AS_GIVEN, NEAR_END, Fault
from camopt.scene.mapping import at, number_of, segments
from camopt.scene.moves import check_moves, has_laws, turn_as_given
from camopt.scene.own_laws import is_of_moves, law_names, laws_of_moves, own_law_tables
from camopt.scene.segments import after_each, given_segments, segment_in, starts_itself

LEAST_MOVE = {"angle": 1e-6, "lift": 1e-9}  # of a rise or return, deg and mm or deg
LAST = ", mm (deg when oscillating), unless another move follows it in the turn"
DECIDES = {"rise": "lift", "return": "lift", CONSTANT_VELOCITY: "velocity"}
"""What a segment of a kind may have in place of its position."""
POSITIONED = (MOVE, CONSTANT_VELOCITY)
KEYS_OF_SEGMENT = {
    "rise": ("lift", "to", "law"),
    "return": ("lift", "to", "law"),
    "dwell": (),
    MOVE: ("to", *DERIVATIVES, "law", "through"),
    CONSTANT_VELOCITY: ("to", "velocity"),
}
"""What a segment of a kind may have, beside its angle and the unit of its derivatives."""


def check_turn(data: Mapping[str, Any]) -> Iterator[Fault]:
    """The turn closes in angle and displacement, and one of rises and returns never goes below its start."""
    rows = segments(data)
    for k, (row, after) in enumerate(zip(rows, after_each(rows), strict=True), start=1):
        yield from _segment(data, row, rows[k - 2], f"motion.{k}")
        move, following = segment_in(row), segment_in(after)
        if move.segment == MOVE and _needs_position(move, following, k == len(rows)):
            missing = "missing; " if row.get("to") is None else "must be a number: "
            yield f"motion.{k}.to", row.get("to"), f"{missing}a move goes to a position{LAST}"
    angles = [number_of(row.get("angle")) for row in rows]
    if rows and None not in angles:
        total = sum(a for a in angles if a is not None)
        if not abs(total - 360.0) <= 360.0 * NEAR_END:
            yield "motion.angle", None, f"the angles add up to {total:.10g} deg, not to 360"
    if given := _given(data):
        faults = list(_levels(given))
        yield from faults or check_moves(data, rows, given)


def check_law(law: Any, key: str, laws: tuple[str, ...]) -> Iterator[Fault]:
    """Check that a named law exists."""
    if isinstance(law, str) and law not in laws:
        yield key, law, f"must be a motion law; {nearest_law(law, laws)}"


def turn_in(data: Mapping[str, Any]) -> tuple[list[GivenSegment], Programme] | None:
    """The turn of the plain mapping of a scene as it is given; None where it is not known."""
    return _turn_in(Same(data))


@lru_cache(maxsize=1)
def _turn_in(same: Same[Mapping[str, Any]]) -> tuple[list[GivenSegment], Programme] | None:
    """Once for all checks of a mapping, which do not change it; so is ``_given``."""
    data = same.value
    given = _given(data)
    if not given or not has_laws(data, given):
        return None
    try:
        return given, turn_as_given(data, given)
    except Contradiction:  # which is said
        return None


def highest_of(data: Mapping[str, Any]) -> float | None:
    """The highest displacement of the turn above its lowest, mm or deg; None where it is not known."""
    given = _given(data)
    if not given:
        return None
    ends, laws = positions_of(given), own_law_tables(data)
    beyond = any(isinstance(law, Mapping) and law.get("overshoot") is True for law in laws.values())
    if (beyond or any(segment.segment == MOVE for segment in given)) and has_laws(data, given):
        return found[1].lift if (found := turn_in(data)) else None
    return max(ends) - min(ends) if isfinite(hypot(*ends)) else None


# --------------------------------------------------------------------------------------------------- segments


def _given(data: Mapping[str, Any]) -> list[GivenSegment] | None:
    """The segments as the motion takes them; None where a number or a kind is missing or wrong."""
    return _segments_given(Same(data))


@lru_cache(maxsize=1)
def _segments_given(same: Same[Mapping[str, Any]]) -> list[GivenSegment] | None:
    data, laws = same.value, own_law_tables(same.value)
    rows = [tables.Segment.sound(row) for row in segments(data)]
    for row, after in zip(rows, after_each(rows), strict=True):
        if row is None or after is None or row.angle < (0.0 if row.segment == "dwell" else LEAST_MOVE["angle"]):
            return None
        decides = DECIDES.get(row.segment)
        if decides and row.to is None and (decides not in row.model_fields_set or getattr(row, decides) is None):
            return None
        if row.segment != MOVE and any(isinstance(getattr(row, key), tuple) for key in ("to", *DERIVATIVES)):
            return None
        if row.segment == MOVE and _needs_position(row, after, row is rows[-1]):
            return None
        if row.segment == MOVE and row.law is not None and not is_of_moves(laws.get(row.law)):
            return None
    return given_segments([row for row in rows if row], number_of(at(data, "cam.rpm")))


def _segment(
    data: Mapping[str, Any], row: Mapping[str, Any], before: Mapping[str, Any], key: str
) -> Iterator[Fault]:
    kind = row.get("segment")
    if not isinstance(kind, str) or kind not in KEYS_OF_SEGMENT:
        return
    named = "a stretch at constant velocity" if kind == CONSTANT_VELOCITY else f"a {kind}"
    for name in ("lift", "to", "law", "through", *DERIVATIVES):
        nothing: list[Any] = [None, (), [], *([0.0] if name == "lift" else [])]
        if name not in KEYS_OF_SEGMENT[kind] and row.get(name) not in nothing:
            yield f"{key}.{name}", row[name], f"{named} has none{_instead(kind, name)}"
        elif kind != MOVE and _is_range(row.get(name)):
            yield f"{key}.{name}", row[name], "must be a number: ranges are for what a move joins"
    angle = number_of(row.get("angle"))
    if kind != "dwell" and angle is not None and 0.0 <= angle < LEAST_MOVE["angle"]:
        where = "a rise or return" if kind in ("rise", "return") else named
        yield f"{key}.angle", row.get("angle"), f"must be at least {LEAST_MOVE['angle']:g} in {where}"
    if kind in ("rise", "return"):
        yield from _stroke(data, row, key)
    elif kind == CONSTANT_VELOCITY:
        yield from _stretch(row, before, key)
    if row.get("law") is not None and "law" in KEYS_OF_SEGMENT[kind]:
        yield from _named(data, kind, row["law"], f"{key}.law")
    if row.get("per") == "s":
        yield from _per_second(data, key)


def _named(data: Mapping[str, Any], kind: str, law: Any, key: str) -> Iterator[Fault]:
    """Check that a named law exists, and that a move has a law of positions."""
    if not isinstance(law, str):
        return  # which is said
    own = own_law_tables(data).get(law)
    if law in LAWS or isinstance(own, Mapping):
        if kind == MOVE and not is_of_moves(own):
            yield key, law, "is for a rise or return; a move joins what is beside it, or has a law of positions"
        elif kind != MOVE and is_of_moves(own):
            yield key, law, "is a law of positions, for a move"
    elif own is None:  # or else it is said that the law is no table
        yield from check_law(law, key, laws_of_moves(data) if kind == MOVE else law_names(data))


def _needs_position(row: tables.Segment, after: tables.Segment, last: bool) -> bool:
    """Whether a move must give its position as a number: the next segment, or the next turn, starts there.

    So has a move with a law of its own, which ends there.
    """
    free = row.law is None and (starts_itself(row, after) or (after.segment == MOVE and not last))
    return number_of(row.to) is None and not free


def _is_range(value: Any) -> bool:
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        return False
    low, high = map(number_of, value)
    return low is not None and high is not None and low <= high


def _instead(kind: str, name: str) -> str:
    """The key to use in place of one that a kind of segment does not have."""
    if kind in POSITIONED and name == "lift":
        return ": give the position at its end (to)"
    if name in (*DERIVATIVES, "through"):
        return ": conditions are for a move"
    return ""


def read_searched_laws(data: dict[str, Any]) -> None:
    """Give each rise and return without a law the first one that ``[search]`` tries, in ``data`` itself."""
    for row in data["motion"] if isinstance(data.get("motion"), list) else ():
        if isinstance(row, dict) and row.get("segment") in ("rise", "return") and row.get("law") is None:
            laws = searched_laws(data, row["segment"])
            row |= {"law": laws[0]} if laws and laws[0] in law_names(data) else {}


def searched_laws(data: Mapping[str, Any], kind: str) -> list[Any]:
    """What ``[search]`` has as laws of rises or of returns."""
    named = [at(data, f"search.{key}") for key in ("law", f"law_{kind}")]
    return [law for each in named if each for law in (each if isinstance(each, list) else [each])]


def _stroke(data: Mapping[str, Any], row: Mapping[str, Any], key: str) -> Iterator[Fault]:
    """A rise or return has a law, and a lift or the position at its end."""
    if row.get("law") is None and not searched_laws(data, row["segment"]):
        yield f"{key}.law", None, "missing; a rise or return needs a motion law, or those that [search] tries"
    lift = number_of(row.get("lift", 0.0))
    if row.get("to") is not None:
        if lift:
            yield f"{key}.lift", row["lift"], "give the lift, or the position at its end (to)"
    elif row.get("lift") is None:
        yield f"{key}.lift", None, "missing; give the lift, or the position at its end (to)"
    elif lift is not None and 0.0 <= lift < LEAST_MOVE["lift"]:
        yield f"{key}.lift", row.get("lift"), f"must be at least {LEAST_MOVE['lift']:g} in a rise or return"


def _stretch(row: Mapping[str, Any], before: Mapping[str, Any], key: str) -> Iterator[Fault]:
    """A constant velocity has a position at its end or a velocity; both if the move before it ends as it starts."""
    if row.get("to") is None and row.get("velocity") is None:
        yield f"{key}.to", None, "missing; give the position at its end (to), or the velocity"
    elif None not in (row.get("to"), row.get("velocity")) and not starts_itself(
        segment_in(before), segment_in(row)
    ):
        why = "give the velocity, or the position at its end (to): where it starts is given by what is before it"
        yield f"{key}.velocity", row["velocity"], why


def _per_second(data: Mapping[str, Any], key: str) -> Iterator[Fault]:
    if at(data, "cam.rpm") is None:
        yield f"{key}.per", "s", "derivatives by time need the speed: give cam.rpm, or use per deg or per rad"
    elif at(data, "search.cam.rpm") is not None:
        yield f"{key}.per", "s", "the motion would change with the speed that search.cam.rpm varies: use deg or rad"


# ----------------------------------------------------------------------------------------------------- levels


def _levels(given: Sequence[GivenSegment]) -> Iterator[Fault]:
    """Whether rises go up and returns down, and, where positions are not given, the turn closes above its start."""
    ends, largest = positions_of(given), max(map(abs, lifts_of(given)), default=0.0)
    positioned = any(segment.to is not None for segment in given)
    kinds = [segment.segment for segment in given]
    if not positioned and "rise" not in kinds and CONSTANT_VELOCITY not in kinds:
        yield "motion", None, "has no rise"
    asked = any(any(segment.wanted) or segment.through or segment.between for segment in given)
    if positioned and largest == 0.0 and not asked:
        yield "motion", None, "stays where it is: no position differs from another"
    for k, (segment, before, after) in enumerate(zip(given, ends, ends[1:], strict=False), start=1):
        if segment.to is not None and segment.segment in ("rise", "return"):
            up = segment.segment == "rise"
            if not (after - before if up else before - after) >= LEAST_MOVE["lift"]:
                way = "above" if up else "below"
                yield f"motion.{k}.to", AS_GIVEN, f"must be {way} {before:g}, where this {segment.segment} starts"
                return
        if not positioned and after < -largest * NEAR_END:
            yield _below(given, k, before)
            return
    if not positioned and abs(ends[-1]) > largest * NEAR_END:
        why = f"the follower ends {ends[-1]:g} above its start: rises and returns must cancel"
        yield "motion.lift", None, why


def _below(given: Sequence[GivenSegment], k: int, before: float) -> Fault:
    """A turn of rises and returns starts where the follower is lowest."""
    if "rise" not in [each.segment for each in given[:k]]:
        first = "the turn starts where the follower is lowest, so that a rise comes before the first return"
        return f"motion.{k}.segment", AS_GIVEN, first
    below = f"must be at most {before:g}: the follower never goes below the start of the turn"
    return f"motion.{k}.lift", AS_GIVEN, below
