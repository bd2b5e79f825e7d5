"""Checks across the tables of a scene: what its mechanism needs, and whether its motion and sizes fit together.

They work on the plain mapping, whatever is wrong elsewhere in it: a check whose inputs are missing or no
numbers says nothing (that mistake is reported on its own). Each fault is (key, value, what is wrong).
"""

from collections.abc import Iterator, Mapping
from math import acos, asin, degrees, hypot, isfinite
from numbers import Real
from typing import Any

from camopt.mistakes import nearest
from camopt.scene.load import check_load
from camopt.scene.own_laws import CLOSE, Fault, check_laws, law_names

LEAST = {"angle": 1e-6, "lift": 1e-9}  # of a rise or return, deg and mm or deg

SIZES = ("roller_radius", "face_radius", "face_offset", "arm_length", "centre_distance", "offset")
SEARCHED = (*SIZES, "base_radius", "mean_radius")
"""The keys of sizes in ``[search]``."""
TRACE = {"knife": (), "roller": ("roller_radius",), "spherical": ("face_radius",)}


def check(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault that needs more than one value to be seen."""
    yield from check_laws(data)
    yield from check_load(data)
    yield from _programme(data)
    yield from _searched_laws(data)
    yield from _searched_angles(data)
    yield from _synthesis(data)
    mechanism = tuple(_text(data, key) for key in ("cam.form", "follower.motion", "follower.contact"))
    if all(mechanism):
        yield from _dynamics(data, *mechanism)  # type: ignore[arg-type]
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
    if isinstance(value, bool) or not isinstance(value, Real):
        return None
    try:
        return float(value) if isfinite(value) else None
    except OverflowError:
        return None


def _size(data: Mapping[str, Any], key: str) -> float | None:
    return _number(_at(data, key))


def _length(data: Mapping[str, Any], key: str) -> float | None:
    size = _size(data, key)
    return size if size and size > 0.0 else None


def _segments(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The segments; what is no table there has no keys."""
    motion = data.get("motion")
    return [s if isinstance(s, Mapping) else {} for s in motion] if isinstance(motion, list) else []


def _programme(data: Mapping[str, Any]) -> Iterator[Fault]:
    """The turn closes in angle and displacement, and never goes below its start."""
    segments = _segments(data)
    for number, segment in enumerate(segments, start=1):
        yield from _segment(segment, f"motion.{number}", law_names(data))
    angles = [_number(s.get("angle")) for s in segments]
    if segments and None not in angles:
        total = sum(a for a in angles if a is not None)
        if not abs(total - 360.0) <= 360.0 * CLOSE:
            yield "motion.angle", None, f"the angles add up to {total:.10g} deg, not to 360"
    lifts = [_number(s.get("lift", 0.0)) for s in segments]
    kinds = [s.get("segment") for s in segments]
    if not segments or None in lifts or not all(kind in ("rise", "dwell", "return") for kind in kinds):
        return
    if "rise" not in kinds:
        yield "motion", None, "has no rise"
    y, largest = 0.0, max([abs(v) for v in lifts if v is not None], default=0.0)
    for number, (kind, lift) in enumerate(zip(kinds, lifts, strict=True), start=1):
        before = y
        y += {"rise": 1.0, "return": -1.0}.get(str(kind), 0.0) * (lift or 0.0)
        if y < -largest * CLOSE and "rise" not in kinds[:number]:
            first = "the turn starts where the follower is lowest, so that a rise comes before the first return"
            yield f"motion.{number}.segment", kind, first
            return
        if y < -largest * CLOSE:
            below = f"must be at most {before:g}: the follower never goes below the start of the turn"
            yield f"motion.{number}.lift", lift, below
            return
    if abs(y) > largest * CLOSE:
        yield "motion.lift", None, f"the follower ends {y:g} above its start: rises and returns must cancel"


def _segment(segment: Mapping[str, Any], key: str, laws: tuple[str, ...]) -> Iterator[Fault]:
    if segment.get("segment") == "dwell":
        for name in ("lift", "law"):
            if segment.get(name):
                yield f"{key}.{name}", segment[name], "a dwell has none"
    elif segment.get("segment") in ("rise", "return"):
        if segment.get("law") is None:
            yield f"{key}.law", None, "missing; a rise or return needs a motion law"
        for name, least in LEAST.items():
            value = _number(segment.get(name, 0.0))
            if value is not None and 0.0 <= value < least:
                yield f"{key}.{name}", segment.get(name), f"must be at least {least:g} in a rise or return"
    if segment.get("segment") != "dwell":
        yield from _law(segment.get("law"), f"{key}.law", laws)


def _law(law: Any, key: str, laws: tuple[str, ...]) -> Iterator[Fault]:
    if isinstance(law, str) and law not in laws:
        yield key, law, f"must be a motion law; {nearest(law, laws)}"


def _searched_laws(data: Mapping[str, Any]) -> Iterator[Fault]:
    for key in ("search.law", "search.law_rise", "search.law_return"):
        named = _at(data, key)
        for number, law in enumerate(named if isinstance(named, list) else [named], start=1):
            yield from _law(law, f"{key}.{number}", law_names(data))


def _searched_angles(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Freed angles have a segment each to go to, and ranges that hold the degrees they share."""
    ranges, freed, reached = {}, [], True
    for kind in ("rise", "return", "dwell"):
        key = f"search.angle_{kind}"
        given = _at(data, key)
        if given is None:
            continue
        if not isinstance(given, Mapping):
            return
        least = 0.0 if kind == "dwell" else LEAST["angle"]
        start, stop = _number(given.get("start")), _number(given.get("stop"))
        if start is None or stop is None or stop < start:
            return
        if start < least:
            yield f"{key}.start", given["start"], f"must be at least {least:g}"
            reached = False
        if stop > 360.0:
            yield f"{key}.stop", given["stop"], "must be at most 360"
            reached = False
        here = [_number(s.get("angle")) for s in _segments(data) if s.get("segment") == kind]
        if not here:
            yield key, None, f"the motion has no {kind}"
            reached = False
        ranges[key] = start, stop
        freed += [(angle, start, stop) for angle in here]
    if not ranges or not reached or any(angle is None for angle, _, _ in freed):
        return
    total, low, high = (sum(column) for column in zip(*freed, strict=True))
    if len(freed) == 1:
        yield (
            next(iter(ranges)),
            None,
            "no other segment can exchange degrees with it: give another kind a range too",
        )
    elif not low - CLOSE * total <= total <= high + CLOSE * total:
        between = f"between {low:g} and {high:g}"
        yield (
            next(iter(ranges)),
            None,
            f"the segments with a range share {total:g} deg, their ranges allow {between}",
        )


def _synthesis(data: Mapping[str, Any]) -> Iterator[Fault]:
    for key in ("synthesis.peak_velocity", "synthesis.peak_acceleration", "synthesis.peak_jerk"):
        yield from _law(_at(data, key), key, law_names(data))
    degree, continuity = _size(data, "synthesis.degree"), _size(data, "synthesis.continuity")
    degree = 5 if degree is None else degree
    if continuity is not None and continuity >= degree:
        yield "synthesis.continuity", continuity, f"must be below the degree ({degree:g})"


def _needed(form: str, motion: str, contact: str) -> tuple[str, ...]:
    """The sizes of the follower that a mechanism needs."""
    if form == "cylindrical":
        return (*TRACE.get(contact, ()), *(("arm_length",) if motion == "oscillating" else ()))
    if motion == "translating":
        return TRACE.get(contact, ())
    return ("centre_distance", *(("face_offset",) if contact == "flat" else ("arm_length", *TRACE[contact])))


def sizes_of(form: str, motion: str, contact: str) -> tuple[str, ...]:
    """The sizes of the follower that a mechanism may have."""
    radial = motion == "translating" and form == "disc"
    return (*_needed(form, motion, contact), *(("offset",) if radial else ()))


def _named(form: str, motion: str, contact: str) -> str:
    return f"{form} cam with {'an' if motion == 'oscillating' else 'a'} {motion} {contact} follower"


def _keys(data: Mapping[str, Any], form: str, motion: str, contact: str) -> Iterator[Fault]:
    what = _named(form, motion, contact)
    if form == "cylindrical" and contact == "flat":
        yield "follower.contact", contact, "must be 'knife', 'roller' or 'spherical' on a cylindrical cam"
        return
    other = "mean_radius" if form == "disc" else "base_radius"
    absent = [f"cam.{other}", *(["cam.shaft_diameter"] if form == "cylindrical" else [])]
    absent += [f"follower.{name}" for name in SIZES if name not in sizes_of(form, motion, contact)]
    for key in (*absent, "search.cam.shaft_diameter" if form == "cylindrical" else ""):
        if _at(data, key) not in (None, 0.0):
            yield key, _at(data, key), f"a {what} has none"
    for name in _needed(form, motion, contact):
        if _at(data, f"follower.{name}") is None and _at(data, f"search.{name}") is None:
            yield f"follower.{name}", None, f"missing; a {what} needs it"


def _dynamics(data: Mapping[str, Any], form: str, motion: str, contact: str) -> Iterator[Fault]:
    """A follower that swings has an inertia and no guide; the guide never reaches the trace point."""
    guide = ("mass", "gravity", "guide_length", "overhang", "friction", "stem_diameter")
    for name in guide if motion == "oscillating" else ("inertia",):
        for key in _both(f"follower.dynamics.{name}"):
            if _at(data, key) is not None:
                yield key, _at(data, key), f"a {_named(form, motion, contact)} has none"
    lift = _highest(data) if motion == "translating" else None
    for key in _both("follower.dynamics.overhang"):
        if lift is not None and any(each is not None and each < lift for each in _values(_at(data, key))):
            why = f"must be at least the lift ({lift:g}): the rise shortens it by that much"
            yield key, _at(data, key), why
    if isinstance(_at(data, "follower.dynamics.load"), list) and _at(data, "search.follower.dynamics.load"):
        why = "the load of this scene changes over the turn (follower.dynamics.load), and no number replaces it"
        yield "search.follower.dynamics.load", _at(data, "search.follower.dynamics.load"), why


def _both(key: str) -> tuple[str, str]:
    """Where a number may be: in its table, and in ``[search]``."""
    return key, f"search.{key}"


def _fit(data: Mapping[str, Any], form: str, motion: str, contact: str) -> Iterator[Fault]:
    """Whether the design can be put together, at its lowest and its highest position."""
    base, shaft = _length(data, "cam.base_radius"), _length(data, "cam.shaft_diameter")
    if base and shaft and shaft / 2 > base:
        yield "cam.shaft_diameter", shaft, f"must be at most twice the base radius ({2 * base:g})"
    lift = _highest(data)
    if form == "cylindrical":
        if motion == "oscillating" and lift is not None and lift >= 180.0:
            yield "motion.lift", None, f"the arm swings {lift:g} deg; a swing stays below 180"
        return
    radii = [_length(data, f"follower.{name}") for name in TRACE.get(contact, ())]
    if base is None or None in radii:
        return
    radius = sum(radius for radius in radii if radius is not None)
    offset = _size(data, "follower.offset") or 0.0
    if motion == "translating" and contact != "flat" and abs(offset) >= base + radius:
        yield "follower.offset", offset, f"must be smaller than the prime radius ({base + radius:g})"
    if motion == "oscillating" and lift is not None:
        yield from (_flat_swing if contact == "flat" else _arm_swing)(data, base + radius, lift)


def _arm_swing(data: Mapping[str, Any], prime: float, lift: float) -> Iterator[Fault]:
    arm, centre = _length(data, "follower.arm_length"), _length(data, "follower.centre_distance")
    if arm is None or centre is None:
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
    face, centre = _size(data, "follower.face_offset"), _length(data, "follower.centre_distance")
    if face is None or centre is None:
        return
    if not abs(base - face) < centre:
        between = f"between base radius and face offset ({abs(base - face):g})"
        yield "follower.centre_distance", centre, f"must be above the difference {between}"
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
    own = (*sizes_of(form, motion, contact), "base_radius" if form == "disc" else "mean_radius")
    for key in SEARCHED:
        if search.get(key) is not None and key not in own:
            yield (
                f"search.{key}",
                search[key],
                f"a {_named(form, motion, contact)} has none; known: {', '.join(own)}",
            )
    for key in set(own) - {"offset", "face_offset"}:
        if any(v is not None and v <= 0 for v in _values(search.get(key))):
            yield f"search.{key}", search[key], "must be above 0"
    for name in _texts(search.get("minimise")):
        if name in _texts(search.get("maximise")):
            yield "search.maximise", name, "is minimised too: an objective can be only one of the two"
    if search.get("law") and (search.get("law_rise") or search.get("law_return")):
        yield "search.law", search["law"], "name either law, or law_rise and law_return"
    for key in ("sampler", "seed"):
        if search.get(key) is not None and search.get("samples") is None:
            yield f"search.{key}", search[key], "belongs to search.samples, which is not given"


def _texts(value: Any) -> list[str]:
    return [each for each in (value if isinstance(value, list) else [value]) if isinstance(each, str)]


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
    if limits.get("outer_radius") is not None and form != "disc":
        yield "limits.outer_radius", limits["outer_radius"], "only a disc cam has one"
    for key in ("velocity", "acceleration", "jerk"):
        if limits.get(key) is not None and all(_at(data, speed) is None for speed in _both("cam.rpm")):
            yield f"limits.{key}", limits[key], "needs cam.rpm"
