"""Checks across the tables of a scene: what its mechanism needs, and whether its motion and sizes fit together.

They work on the plain mapping, whatever is wrong elsewhere in it: a check whose inputs are missing or no
numbers says nothing (that mistake is reported on its own). Each fault is (key, value, what is wrong).
"""

from collections.abc import Iterator, Mapping
from math import acos, asin, degrees, hypot, isfinite
from typing import Any

from camopt.mistakes import nearest

Fault = tuple[str, Any, str]
CLOSE = 1e-9  # relative, of the sums of angles and lifts

SIZES = ("roller_radius", "face_radius", "face_offset", "arm_length", "centre_distance", "offset")
TRACE = {"knife": (), "roller": ("roller_radius",), "spherical": ("face_radius",)}


def check(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault that needs more than one value to be seen."""
    yield from _programme(data)
    mechanism = tuple(_text(data, key) for key in ("cam.form", "follower.motion", "follower.contact"))
    if all(mechanism):
        yield from _keys(data, *mechanism)  # type: ignore[arg-type]
        yield from _fit(data, *mechanism)  # type: ignore[arg-type]
        yield from _search(data, *mechanism)  # type: ignore[arg-type]
        yield from _limits(data, *mechanism)  # type: ignore[arg-type]


def _at(data: Mapping[str, Any], key: str) -> Any:
    value: Any = data
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    return value


def _text(data: Mapping[str, Any], key: str) -> str | None:
    known = {
        "cam.form": ("disc", "cylindrical"),
        "follower.motion": ("translating", "oscillating"),
        "follower.contact": ("knife", "roller", "flat", "spherical"),
    }[key]
    value = _at(data, key)
    return value if isinstance(value, str) and value in known else None


def _number(value: Any) -> float | None:
    number = isinstance(value, (int, float)) and not isinstance(value, bool) and isfinite(value)
    return float(value) if number else None


def _size(data: Mapping[str, Any], key: str) -> float | None:
    return _number(_at(data, key))


def _segments(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    motion = data.get("motion")
    return [s for s in motion if isinstance(s, Mapping)] if isinstance(motion, list) else []


def _programme(data: Mapping[str, Any]) -> Iterator[Fault]:
    """The turn closes in angle and displacement, and never goes below its start."""
    segments = _segments(data)
    for number, segment in enumerate(segments, start=1):
        yield from _segment(segment, f"motion.{number}")
    angles = [_number(s.get("angle")) for s in segments]
    if None not in angles and "motion" in data:
        total = sum(a for a in angles if a is not None)
        if not abs(total - 360.0) <= 360.0 * CLOSE:
            yield "motion.angle", None, f"the angles add up to {total:g} deg, not to 360"
    lifts = [_number(s.get("lift", 0.0)) for s in segments]
    kinds = [s.get("segment") for s in segments]
    if None in lifts or not set(kinds) <= {"rise", "dwell", "return"}:
        return
    if segments and "rise" not in kinds:
        yield "motion", None, "has no rise"
    y, largest = 0.0, max([abs(v) for v in lifts if v is not None], default=0.0)
    for number, (kind, lift) in enumerate(zip(kinds, lifts, strict=True), start=1):
        y += {"rise": 1.0, "return": -1.0}.get(str(kind), 0.0) * (lift or 0.0)
        if y < -largest * CLOSE:
            yield (
                f"motion.{number}",
                None,
                "the follower goes below the start of the turn, its lowest position",
            )
            return
    if abs(y) > largest * CLOSE:
        yield "motion.lift", None, f"the follower ends {y:g} above its start: rises and returns must cancel"


def _segment(segment: Mapping[str, Any], key: str) -> Iterator[Fault]:
    if segment.get("segment") == "dwell":
        for name in ("lift", "law"):
            if segment.get(name):
                yield f"{key}.{name}", segment[name], "a dwell has none"
    elif segment.get("segment") in ("rise", "return"):
        if segment.get("law") is None:
            yield f"{key}.law", None, "missing; a rise or return needs a motion law"
        for name in ("angle", "lift"):
            value = _number(segment.get(name, 0.0))
            if value is not None and value == 0.0:
                yield f"{key}.{name}", segment.get(name), "must be above 0"


def _needed(form: str, motion: str, contact: str) -> tuple[str, ...]:
    """The sizes of the follower that a mechanism needs."""
    if form == "cylindrical":
        return (*TRACE.get(contact, ()), *(("arm_length",) if motion == "oscillating" else ()))
    if motion == "translating":
        return TRACE.get(contact, ())
    return ("centre_distance", *(("face_offset",) if contact == "flat" else ("arm_length", *TRACE[contact])))


def _allowed(form: str, motion: str, contact: str) -> tuple[str, ...]:
    """The sizes of the follower that a mechanism may have."""
    radial = motion == "translating" and form == "disc"
    return (*_needed(form, motion, contact), *(("offset",) if radial else ()))


def _keys(data: Mapping[str, Any], form: str, motion: str, contact: str) -> Iterator[Fault]:
    what = f"{form} cam with a {motion} {contact} follower"
    if form == "cylindrical" and contact == "flat":
        yield "follower.contact", contact, "a cylindrical cam takes a knife, roller or spherical contact"
        return
    size, other = ("base_radius", "mean_radius") if form == "disc" else ("mean_radius", "base_radius")
    if _at(data, f"cam.{size}") is None:
        yield f"cam.{size}", None, f"missing; a {form} cam needs it"
    absent = [f"cam.{other}", *(["cam.shaft_diameter"] if form == "cylindrical" else [])]
    absent += [f"follower.{name}" for name in SIZES if name not in _allowed(form, motion, contact)]
    for key in absent:
        if _at(data, key) not in (None, 0.0):
            yield key, _at(data, key), f"a {what} has none"
    for name in _needed(form, motion, contact):
        if _at(data, f"follower.{name}") is None:
            yield f"follower.{name}", None, f"missing; a {what} needs it"


def _fit(data: Mapping[str, Any], form: str, motion: str, contact: str) -> Iterator[Fault]:
    """Whether the design can be put together, at its lowest and its highest position."""
    base, shaft = _size(data, "cam.base_radius"), _size(data, "cam.shaft_diameter")
    if base and shaft and shaft / 2 > base:
        yield "cam.shaft_diameter", shaft, f"at most twice the base radius ({2 * base:g})"
    lift = _highest(data)
    if form == "cylindrical":
        if motion == "oscillating" and lift is not None and lift >= 180.0:
            yield "motion.lift", None, f"the arm swings {lift:g} deg; a swing stays below 180"
        return
    if base is None:
        return
    radius = (_size(data, "follower.roller_radius") or 0.0) + (_size(data, "follower.face_radius") or 0.0)
    offset = _size(data, "follower.offset") or 0.0
    if motion == "translating" and contact != "flat" and abs(offset) >= base + radius:
        yield "follower.offset", offset, f"smaller than the prime radius ({base + radius:g})"
    if motion == "oscillating" and lift is not None:
        yield from (_flat_swing if contact == "flat" else _arm_swing)(data, base + radius, lift)


def _arm_swing(data: Mapping[str, Any], prime: float, lift: float) -> Iterator[Fault]:
    arm, centre = _size(data, "follower.arm_length"), _size(data, "follower.centre_distance")
    if not (arm and centre and arm > 0 and centre > 0):
        return
    if not abs(centre - arm) < prime < centre + arm:
        between = f"{abs(centre - arm):g} and {centre + arm:g}"
        yield (
            "follower.arm_length",
            arm,
            f"no triangle: the prime radius ({prime:g}) must lie between {between}",
        )
        return
    start = degrees(acos((centre**2 + arm**2 - prime**2) / (2 * centre * arm)))
    if start + lift >= 180.0:
        yield (
            "motion.lift",
            None,
            f"the arm starts at {start:g} deg and rises {lift:g}: it stays below 180 deg",
        )


def _flat_swing(data: Mapping[str, Any], base: float, lift: float) -> Iterator[Fault]:
    face, centre = _size(data, "follower.face_offset"), _size(data, "follower.centre_distance")
    if face is None or not centre or centre <= 0:
        return
    if not abs(base - face) < centre:
        yield "follower.centre_distance", centre, f"above base radius minus face offset ({base - face:g})"
        return
    start = degrees(asin((base - face) / centre))
    if start + lift >= 90.0:
        yield (
            "motion.lift",
            None,
            f"the face starts at {start:g} deg and rises {lift:g}: it stays below 90 deg",
        )


def _highest(data: Mapping[str, Any]) -> float | None:
    """The highest displacement of the turn."""
    y = highest = 0.0
    for segment in _segments(data):
        lift = _number(segment.get("lift", 0.0))
        if lift is None:
            return None
        y += {"rise": lift, "return": -lift}.get(str(segment.get("segment")), 0.0)
        highest = max(highest, y)
    return highest if isfinite(hypot(y, highest)) else None


def _search(data: Mapping[str, Any], form: str, motion: str, contact: str) -> Iterator[Fault]:
    search = data.get("search")
    if not isinstance(search, Mapping):
        return
    own = (*_allowed(form, motion, contact), "base_radius" if form == "disc" else "mean_radius")
    for key in (*SIZES, "base_radius", "mean_radius"):
        if search.get(key) is not None and key not in own:
            yield f"search.{key}", search[key], f"not a size of this mechanism; {nearest(key, own)}"
    for key in set(own) - {"offset", "face_offset"}:
        if any(v is not None and v <= 0 for v in _values(search.get(key))):
            yield f"search.{key}", search[key], "must be above 0"
    if search.get("law") and (search.get("law_rise") or search.get("law_return")):
        yield "search.law", search["law"], "either law, or law_rise and law_return"


def _values(choice: Any) -> list[float | None]:
    if isinstance(choice, Mapping):
        return [_number(choice.get("start"))]
    return [_number(v) for v in choice] if isinstance(choice, list) else [_number(choice)]


def _limits(data: Mapping[str, Any], form: str, motion: str, contact: str) -> Iterator[Fault]:
    limits = data.get("limits")
    if not isinstance(limits, Mapping):
        return
    if limits.get("face_reach") is not None and contact != "flat":
        yield "limits.face_reach", limits["face_reach"], "only a flat face has a reach"
    for key in ("velocity", "acceleration", "jerk"):
        if limits.get(key) is not None and _at(data, "cam.rpm") is None:
            yield f"limits.{key}", limits[key], "needs cam.rpm"
