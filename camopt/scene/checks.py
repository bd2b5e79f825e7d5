"""Checks across the tables of a scene: its mechanism's needs, and whether motion and sizes fit together.

They work on the plain mapping, whatever is wrong elsewhere in it: a check whose inputs are missing or no
numbers says nothing (that mistake is reported on its own). Each fault is (key, value, what is wrong).
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from math import degrees
from typing import Any

from camopt.mechanisms import DRIVEN, SECOND_FIELDS, Mechanism, mechanisms_for
from camopt.mechanisms.body import BODIES
from camopt.mechanisms.drive import PRELOAD
from camopt.mechanisms.follower import FLAT, MOTIONS, Tip
from camopt.quantities.scene_numbers import NUMBERS
from camopt.scene.law_forms import NEAR_END, Fault
from camopt.scene.load import check_load
from camopt.scene.mapping import at, length, number_of, segments
from camopt.scene.own_laws import check_laws, law_names
from camopt.scene.own_quantities import check_own_quantities
from camopt.scene.part import check_part, run_of_groove
from camopt.scene.profile import check_profile, highest_on_profile
from camopt.scene.sizes import FOLLOWER_SIZES, SEARCHED, SIGNED_SIZES, mechanism_in, sizes_in
from camopt.scene.spring import spring_faults
from camopt.scene.tables import Drive, Follower
from camopt.scene.tolerances import check_tolerances
from camopt.scene.train import Lifts, check_train, lifts_through
from camopt.scene.turn import LEAST_MOVE, POSITIONED, check_law, check_turn, highest_of

LARGEST_PLAY = 0.1  # of the radius of a roller: its clearance or interference, which theory takes for small
GUIDE_KEYS = tuple(each.name for each in NUMBERS if each.guide)
"""The keys of a guide in ``[follower.dynamics]``."""


def faults_of(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault that needs more than one value to be seen."""
    yield from check_laws(data)
    yield from check_own_quantities(data)
    yield from check_load(data)
    profiled = data.get("profile") is not None
    if profiled:
        yield from check_profile(data)
        yield from _searched_motion(data)
    else:
        if data.get("motion") is None:
            yield "motion", None, "missing; a scene has [[motion]], or the [[profile]] of its cam"
        yield from check_turn(data)
        yield from _searched_angles(data)
    yield from check_train(data)
    yield from _searched_laws(data)
    yield from _synthesis(data)
    if found := mechanism_in(data):
        mechanism, tip = found
        asked, lift = _lifts(data)
        yield from _dynamics(data, lift, mechanism, tip)
        yield from _lash(data, asked)
        wrong = list(_drive(data, mechanism, tip))
        yield from wrong
        if any(key == "drive.kind" for key, *_ in wrong):
            return  # the mechanism of another drive has other keys
        yield from _keys(data, mechanism, tip)
        if lift is not None or not profiled:  # that a follower cannot be on its profile is told already
            yield from _fit(data, lift, mechanism, tip)
        yield from check_part(data, mechanism, lift, _trace_radius(data, tip))
        yield from check_tolerances(data, mechanism, tip, _named(mechanism, tip))
        yield from _search(data, mechanism, tip)
        yield from _limits(data, mechanism, tip)


def _lifts(data: Mapping[str, Any]) -> Lifts:
    """The largest lift of the motion that is asked, and that of the follower."""
    # of moves it is that of their polynomials, of a profile that of its follower, which are made for it
    given = highest_of(data) if data.get("profile") is None else highest_on_profile(data)
    return lifts_through(data, given) if data.get("train") else Lifts(given, given)


def groove_run(data: Mapping[str, Any]) -> float | None:
    """The length over which the groove of a cylindrical cam runs along its axis, mm; None if not known."""
    found = mechanism_in(data)
    if found is None or not found[0].body.developed:
        return None
    return run_of_groove(data, found[0], _lifts(data).follower, _trace_radius(data, found[1]))


def _size(data: Mapping[str, Any], key: str) -> float | None:
    return number_of(at(data, key))


def _searched_motion(data: Mapping[str, Any]) -> Iterator[Fault]:
    """With a profile, no size that the motion follows from may be searched."""
    laws, angles = ("law", "law_rise", "law_return"), ("angle_rise", "angle_return", "angle_dwell")
    for key in (*SEARCHED, *laws, *angles):
        if at(data, f"search.{key}") is not None:
            why = "the motion would change: it follows from the profile and the sizes of the follower"
            yield f"search.{key}", None, why


def _searched_laws(data: Mapping[str, Any]) -> Iterator[Fault]:
    for key in ("search.law", "search.law_rise", "search.law_return"):
        named = at(data, key)
        for place, law in enumerate(named if isinstance(named, list) else [named], start=1):
            yield from check_law(law, f"{key}.{place}", law_names(data))


def _searched_angles(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Each freed angle has its segment, and the ranges can hold the degrees that the angles share."""
    ranges, freed, reached = {}, [], True
    for kind in ("rise", "return", "dwell"):
        key = f"search.angle_{kind}"
        given = at(data, key)
        if given is None:
            continue
        if not isinstance(given, Mapping):
            return
        least = 0.0 if kind == "dwell" else LEAST_MOVE["angle"]
        start, stop = number_of(given.get("start")), number_of(given.get("stop"))
        if start is None or stop is None or stop < start:
            return
        if start < least:
            yield f"{key}.start", given["start"], f"must be at least {least:g}"
            reached = False
        if stop > 360.0:
            yield f"{key}.stop", given["stop"], "must be at most 360"
            reached = False
        here = [number_of(s.get("angle")) for s in segments(data) if s.get("segment") == kind]
        if any(s.get("segment") in POSITIONED for s in segments(data)):
            yield key, None, "the angles of a motion with moves or constant velocities stay as they are"
            return
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
    elif not low - NEAR_END * total <= total <= high + NEAR_END * total:
        between = f"between {low:g} and {high:g}"
        yield (
            next(iter(ranges)),
            None,
            f"the segments with a range share {total:g} deg, their ranges allow {between}",
        )


def _synthesis(data: Mapping[str, Any]) -> Iterator[Fault]:
    for key in ("synthesis.peak_velocity", "synthesis.peak_acceleration", "synthesis.peak_jerk"):
        yield from check_law(at(data, key), key, law_names(data))
    degree, continuity = _size(data, "synthesis.degree"), _size(data, "synthesis.continuity")
    degree = 5 if degree is None else degree
    if continuity is not None and continuity >= degree:
        yield "synthesis.continuity", continuity, f"must be below the degree ({degree:g})"


def _named(mechanism: Mechanism, tip: Tip) -> str:
    return f"{mechanism.body.words} with {mechanism.motion.words} {tip.name} follower"


def _one_of(names: Iterable[str]) -> str:
    """Words to choose from."""
    *others, last = map(repr, names)
    return f"{', '.join(others)} or {last}" if others else last


def _drive(data: Mapping[str, Any], mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    """A drive is one that there is on such a cam, and has no keys of other drives."""
    kind, own = at(data, "drive.kind"), mechanism.drive
    if kind is not None and kind != own.name and tip in mechanism.tips:
        known = mechanisms_for(mechanism.body.form, mechanism.motion.name, tip.name)
        drives = _one_of(each.drive.name for each in known)
        yield "drive.kind", kind, f"must be {drives} on a {_named(mechanism, tip)}"
        return
    for key in (name for name in Drive.model_fields if name not in ("kind", *own.keys)):
        for place in _both(f"drive.{key}"):
            if at(data, place) is not None:
                yield place, at(data, place), _has_none(key, mechanism)
    yield from _play(data, mechanism)
    if mechanism.further:
        yield from _of_two_contacts(data, mechanism)


def _play(data: Mapping[str, Any], mechanism: Mechanism) -> Iterator[Fault]:
    """A clearance, or an interference, is a small part of the roller, or of the disc that flat faces are on."""
    roller, base = length(data, "follower.roller_radius"), length(data, "cam.base_radius")
    size, words = (roller, "roller's radius") if roller is not None else (base, "base radius")
    arm = length(data, "follower.arm_length") if mechanism.motion.angular else None
    for key in ("clearance", PRELOAD[0]):
        swung = mechanism.motion.angular and key == PRELOAD[0]
        if size is None or (swung and arm is None):
            continue
        most = degrees(LARGEST_PLAY * size / arm) if swung and arm else LARGEST_PLAY * size
        least = f"must be at most a tenth of the {words}{' at the end of the arm' if swung else ''}"
        for place in _both(f"drive.{key}"):
            if any(each is not None and each > most for each in _values(at(data, place), "stop")):
                yield place, at(data, place), f"{least} ({most:.4g}{' deg' if swung else ''})"


def _has_none(key: str, mechanism: Mechanism) -> str:
    """That there is no such key of a drive; one that it has with another follower, it has not with this one."""
    drive, follower = mechanism.drive, f"{mechanism.drive.words} with {mechanism.motion.words} follower"
    if mechanism.second_keys and f"drive.{key}" in SECOND_FIELDS:
        return f"{follower} has none; it has {', '.join(mechanism.second_keys)}"
    with_it = any(each.drive.name == drive.name and key in each.drive.keys for each in DRIVEN)
    return f"{follower if with_it else drive.words} has none"


def _of_two_contacts(data: Mapping[str, Any], mechanism: Mechanism) -> Iterator[Fault]:
    """What there is not of a follower with two contacts."""
    words = mechanism.drive.words
    if data.get("profile") is not None:
        yield "profile", None, f"{words} is given by the [[motion]] of its follower"
    for name in (each for each in GUIDE_KEYS if each in mechanism.motion.dynamics):
        for key in _both(f"follower.dynamics.{name}"):
            if at(data, key) is not None:
                why = f"the guide of {words} is not computed: which of both contacts it takes up is not known"
                yield key, at(data, key), why
    for key, other in (PRELOAD, PRELOAD[::-1]):
        for place in _both(f"drive.{key}"):
            if at(data, place) is not None and all(at(data, each) is None for each in _both(f"drive.{other}")):
                yield (
                    place,
                    at(data, place),
                    f"goes with drive.{other}, which is missing: together they are a preload",
                )
    for place in _both("drive.clearance") if "clearance" in mechanism.drive.keys else ():
        if at(data, place) is not None and any(at(data, each) for each in _both(f"drive.{PRELOAD[0]}")):
            yield (
                place,
                at(data, place),
                "there is none between contacts with an interference: leave one of both out",
            )
    if mechanism.drive.one_disc and at(data, "follower.offset") not in (None, 0.0):
        yield "follower.offset", at(data, "follower.offset"), f"must be 0 with {words}"


def _keys(data: Mapping[str, Any], mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    """A mechanism has all its sizes, and no sizes of other mechanisms."""
    what, body, own = _named(mechanism, tip), mechanism.body, mechanism.follower_keys(tip)
    if tip not in mechanism.tips:
        tips = _one_of(each.name for each in mechanism.tips)
        yield "follower.contact", tip.name, f"must be {tips} on a {body.words}"
        return
    others = [key for other in BODIES.values() for key in other.cam if key not in body.cam]
    absent = [f"cam.{key}" for key in others]
    absent += [f"follower.{name}" for name in FOLLOWER_SIZES if name not in own]
    absent += [f"search.cam.{key}" for key in others if key not in SEARCHED]
    for key in absent:
        if at(data, key) not in (None, 0.0):
            instead = f": its size is cam.{body.size}" if key in (f"cam.{b.size}" for b in BODIES.values()) else ""
            yield key, at(data, key), f"a {what} has none{instead}"
    for name in own:
        if Follower.model_fields[name].default is not None:
            continue
        if at(data, f"follower.{name}") is None and at(data, f"search.{name}") is None:
            yield f"follower.{name}", None, f"missing; a {what} needs it"


def _dynamics(data: Mapping[str, Any], lift: float | None, mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    """A follower that swings has an inertia and no guide; the guide never reaches the trace point."""
    motion = mechanism.motion
    for name in (key for other in MOTIONS.values() if other != motion for key in other.dynamics):
        for key in _both(f"follower.dynamics.{name}"):
            if at(data, key) is not None:
                yield (
                    key,
                    at(data, key),
                    f"a {_named(mechanism, tip)} has none; it has {', '.join(motion.dynamics)}",
                )
    if motion.angular:
        yield from spring_faults(data)
    for key in _both("follower.dynamics.overhang") if "overhang" in motion.dynamics else ():
        if lift is not None and any(each is not None and each < lift for each in _values(at(data, key))):
            why = f"must be at least the lift ({lift:g}): the rise shortens it by that much"
            yield key, at(data, key), why
    if isinstance(at(data, "follower.dynamics.load"), list) and at(data, "search.follower.dynamics.load"):
        why = "the load of this scene changes over the turn (follower.dynamics.load), and no number replaces it"
        yield "search.follower.dynamics.load", at(data, "search.follower.dynamics.load"), why


def _lash(data: Mapping[str, Any], lift: float | None) -> Iterator[Fault]:
    """A lash is taken up before the highest position, and its variation is smaller than the lash."""
    key = "follower.dynamics.lash"
    for name in _both(key):
        if lift is not None and any(each is not None and each >= lift for each in _values(at(data, name))):
            yield name, at(data, name), f"must be below the lift ({lift:g}): what it drives would never move"
    lash, varies = number_of(at(data, key)), number_of(at(data, f"{key}_variation"))
    if lash is not None and varies is not None and varies > lash:
        yield f"{key}_variation", varies, f"must be at most the lash ({lash:g})"


def _both(key: str) -> tuple[str, str]:
    """The places of a number: in its table, and in ``[search]``."""
    return key, f"search.{key}"


def _fit(data: Mapping[str, Any], lift: float | None, mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    """Whether the design can be put together, at its lowest and its highest position."""
    base, shaft = length(data, "cam.base_radius"), length(data, "cam.shaft_diameter")
    if base and shaft and shaft / 2 > base:
        yield "cam.shaft_diameter", shaft, f"must be at most twice the base radius ({2 * base:g})"
    sizes = sizes_in(data, mechanism, tip) | ({} if lift is None else {"lift": lift})
    with suppress(KeyError):  # what is missing is told on its own, or left to a search
        if misfit := mechanism.misfit(sizes):
            yield misfit
            return
    yield from _fit_of_second(data, mechanism, sizes, shaft)


def _fit_of_second(
    data: Mapping[str, Any], mechanism: Mechanism, sizes: Mapping[str, float], shaft: float | None
) -> Iterator[Fault]:
    """Likewise of a second contact with sizes of its own."""
    given = {key: number_of(at(data, key)) for key in mechanism.second_keys}
    own = {key: size for key, size in given.items() if size is not None}
    base = own.get("drive.base_radius")
    if base and shaft and shaft / 2 > base:
        yield (
            "cam.shaft_diameter",
            shaft,
            f"must be at most twice the base radius of the second disc ({2 * base:g})",
        )
    seen = {SECOND_FIELDS[key].removeprefix("second_"): size for key, size in own.items()}
    with suppress(KeyError):
        if own and (misfit := mechanism.misfit({**sizes, **seen})):
            place = misfit[0].replace("follower.", "drive.")
            key = (
                place if place in own else [*own][-1]
            )  # the first disc fits: a size of the second one's own does not
            yield key, own[key], f"of the second disc: {misfit[2]}"


def _trace_radius(data: Mapping[str, Any], tip: Tip) -> float | None:
    """Distance of the trace point from the profile: the radius of a roller or spherical face; None if not known."""
    return length(data, f"follower.{tip.radius}") if tip.radius else 0.0


def _search(data: Mapping[str, Any], mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    search = data.get("search")
    if not isinstance(search, Mapping):
        return
    own = (*mechanism.follower_keys(tip), mechanism.body.size)
    for key in SEARCHED:
        if search.get(key) is not None and key not in own:
            yield (
                f"search.{key}",
                search[key],
                f"a {_named(mechanism, tip)} has none; known: {', '.join(own)}",
            )
    for key in (each for each in own if each not in SIGNED_SIZES):
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


def _values(choice: Any, end: str = "start") -> list[float | None]:
    if isinstance(choice, Mapping):
        return [number_of(choice.get(end))]
    return [number_of(v) for v in choice] if isinstance(choice, list) else [number_of(choice)]


def _limits(data: Mapping[str, Any], mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    limits = data.get("limits")
    if not isinstance(limits, Mapping):
        return
    if limits.get("face_reach") is not None and tip != FLAT:
        yield "limits.face_reach", limits["face_reach"], "only a flat face has a reach"
    if limits.get("outer_radius") is not None and mechanism.outline is None:
        yield "limits.outer_radius", limits["outer_radius"], "only a disc cam has one"
    if limits.get("cutter_radius") is not None and tip == FLAT:
        yield (
            "limits.cutter_radius",
            limits["cutter_radius"],
            "a flat face makes no hollow flanks: any cutter will do",
        )
    elif limits.get("cutter_radius") is not None and mechanism.cut_as_by_roller:
        what = "rib" if mechanism.further else "groove"
        why = f"the flanks of a {what} are cut with at most the radius of its roller: choose follower.roller_radius"
        yield "limits.cutter_radius", limits["cutter_radius"], why
    for key in ("velocity", "acceleration", "jerk"):
        if limits.get(key) is not None and all(at(data, speed) is None for speed in _both("cam.rpm")):
            yield f"limits.{key}", limits[key], "needs cam.rpm"
