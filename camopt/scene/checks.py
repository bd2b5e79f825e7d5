"""Checks across the tables of a scene: the needs of its mechanism, and whether motion and sizes fit together.

They read a typed scene without its wrong values (``scene.faultless_tables``). A check whose inputs are missing
yields nothing. Each fault is (key, value, what is wrong).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from math import degrees, isnan
from operator import gt, le, lt
from typing import TYPE_CHECKING, Any

from camopt.core.quantities.scene_numbers import NUMBERS, SPRING_AT
from camopt.model.mechanisms import DRIVEN, SECOND_FIELDS, Mechanism, mechanisms_for
from camopt.model.mechanisms.elements import BODIES, FLAT, MOTIONS, PRELOAD, Tip
from camopt.scene.choices import StepRange
from camopt.scene.law_forms import NEAR_END, VALUE_IN_SCENE, Fault
from camopt.scene.load import check_load
from camopt.scene.own_laws import check_laws, own_law_values_by_name, stroke_law_names
from camopt.scene.own_quantities import check_own_quantities
from camopt.scene.part import check_part, groove_length_along_axis
from camopt.scene.profile import check_profile, highest_profile_displacement
from camopt.scene.sizes import (
    FOLLOWER_SIZES,
    SEARCH_SIZES,
    SIGNED_SIZES,
    known_number_or_none,
    known_sizes,
    mechanism_and_tip_named,
)
from camopt.scene.spring import SPRING_NUMBERS
from camopt.scene.tables import Drive
from camopt.scene.tolerances import check_tolerances
from camopt.scene.train import Lifts, check_train, lifts_through_train
from camopt.scene.turn import LEAST_MOVE, POSITIONED_KINDS, check_law_exists, check_turn, highest_displacement

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

KINDS, LAW_KEYS = ("rise", "return", "dwell"), ("law", "law_rise", "law_return")
LARGEST_PLAY = (
    0.1  # largest clearance or interference, as a share of the roller's radius: the theory is for small ones
)
GUIDE_KEYS = tuple(each.name for each in NUMBERS if each.guide)
"""The keys of a guide in ``[follower.dynamics]``."""


def faults_across_tables(scene: "Scene", data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault that involves more than one value, in a scene and in the mapping it was made from."""
    yield from check_laws(data)
    yield from check_own_quantities(data)
    yield from check_load(scene)
    profiled = data.get("profile") is not None
    if profiled:
        yield from check_profile(scene)
        yield from _refuse_motion_search_with_profile(scene)
    else:
        if data.get("motion") is None:
            yield "motion", None, "missing; a scene has [[motion]], or the [[profile]] of its cam"
        yield from check_turn(scene)
        yield from _check_searched_angles(scene)
    yield from check_train(scene)
    yield from _check_search_and_synthesis(scene)
    follower = scene.follower
    if pair := mechanism_and_tip_named(scene.cam.form, follower.motion, follower.contact, scene.drive.kind):
        mechanism, tip = pair
        tool_lift, lift = _lifts_of_scene(scene)
        yield from _check_dynamics_keys_and_guide(scene, lift, mechanism, tip)
        yield from _check_lash(scene, tool_lift)
        wrong = list(_check_follower_drive(scene, mechanism, tip))
        yield from wrong
        if any(key == "drive.kind" for key, *_ in wrong):
            return  # another drive makes another mechanism, with other keys
        yield from _check_sizes(scene, mechanism, tip)
        if lift is not None or not profiled:  # check_profile reports a follower that cannot run on its profile
            yield from _check_assembly(scene, lift, mechanism, tip)
        yield from check_part(scene, mechanism, lift, _trace_point_to_profile_mm(scene, tip))
        yield from check_tolerances(scene, mechanism, tip, _mechanism_words(mechanism, tip))
        yield from _check_search_fits_mechanism(scene, mechanism, tip)
        yield from _check_limits_fit_mechanism(scene, mechanism, tip)


def _lifts_of_scene(scene: "Scene") -> Lifts:
    """The largest lifts of tool and follower; moves and profiles are computed for it."""
    given = highest_profile_displacement(scene) if scene.profile else highest_displacement(scene)
    return lifts_through_train(scene, given) if scene.train else Lifts(given, given)


def groove_length_of_scene(scene: "Scene") -> float | None:
    """Length of the groove of a cylindrical cam along its axis [mm]; None where unknown."""
    if not scene.mechanism.body.developed:
        return None
    return groove_length_along_axis(
        scene, scene.mechanism, _lifts_of_scene(scene).follower, _trace_point_to_profile_mm(scene, scene.tip)
    )


def _refuse_motion_search_with_profile(scene: "Scene") -> Iterator[Fault]:
    """With a profile, refuse to search sizes, laws and angles that would change the motion."""
    for key in (*SEARCH_SIZES, *LAW_KEYS, *(f"angle_{kind}" for kind in KINDS)):
        if getattr(scene.search, key) not in (None, ()):
            why = "would change the motion, which follows from the profile and the sizes of the follower"
            yield f"search.{key}", None, why


def _check_search_and_synthesis(scene: "Scene") -> Iterator[Fault]:
    """Check that the named laws exist, and that computed laws are not smoother than their degree allows."""
    laws, given = stroke_law_names(own_law_values_by_name(scene)), scene.synthesis
    for key in LAW_KEYS:
        for place, law in enumerate(getattr(scene.search, key), start=1):
            yield from check_law_exists(law, f"search.{key}.{place}", laws)
    for key in ("peak_velocity", "peak_acceleration", "peak_jerk"):
        yield from check_law_exists(getattr(given, key), f"synthesis.{key}", laws)
    if isinstance(given.continuity, int) and given.continuity >= given.degree:
        yield "synthesis.continuity", float(given.continuity), f"must be below the degree ({given.degree:g})"


def _check_searched_angles(scene: "Scene") -> Iterator[Fault]:
    """Check that the angles to vary have segments, and that their ranges allow the degrees that they share."""
    ranges, freed, reached = {}, [], True
    for kind in KINDS:
        key, given = f"search.angle_{kind}", getattr(scene.search, f"angle_{kind}")
        if given is None:
            continue
        if (
            not isinstance(given, StepRange)
            or None in map(known_number_or_none, (given.start, given.stop))
            or given.stop < given.start
        ):
            return
        least = 0.0 if kind == "dwell" else LEAST_MOVE["angle"]
        if given.start < least:
            yield f"{key}.start", VALUE_IN_SCENE, f"must be at least {least:g}"
            reached = False
        if given.stop > 360.0:
            yield f"{key}.stop", VALUE_IN_SCENE, "must be at most 360"
            reached = False
        here = [segment.angle for segment in scene.motion if segment.segment == kind]
        if any(segment.segment in POSITIONED_KINDS for segment in scene.motion):
            yield key, None, "the angles of a motion with moves or constant velocities cannot vary"
            return
        if not here:
            yield key, None, f"the motion has no {kind}"
            reached = False
        ranges[key] = given
        freed += [(angle, given.start, given.stop) for angle in here]
    if not ranges or not reached or any(not isinstance(angle, float) or isnan(angle) for angle, _, _ in freed):
        return
    total, low, high = (sum(column) for column in zip(*freed, strict=True))
    first = next(iter(ranges))
    if len(freed) == 1:
        yield first, None, "no other segment can exchange degrees with it: give another kind a range too"
    elif not low - NEAR_END * total <= total <= high + NEAR_END * total:
        shared = f"the segments with a range share {total:g} deg, but their ranges allow {low:g} to {high:g}"
        yield first, None, shared


def _mechanism_words(mechanism: Mechanism, tip: Tip) -> str:
    return f"{mechanism.body.words} with {mechanism.motion.words} {tip.name} follower"


def _alternatives_text(names: Iterable[str]) -> str:
    """Names to choose from, as in 'a', 'b' or 'c'."""
    *others, last = map(repr, names)
    return f"{', '.join(others)} or {last}" if others else last


def _check_follower_drive(scene: "Scene", mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    """Check that the mechanism exists with this drive, and that the drive has no keys of other drives."""
    kind, own = scene.drive.kind, mechanism.drive
    if kind is not None and kind != own.name and tip in mechanism.tips:
        known = mechanisms_for(mechanism.body.form, mechanism.motion.name, tip.name)
        drives = _alternatives_text(each.drive.name for each in known)
        yield "drive.kind", kind, f"must be {drives} on a {_mechanism_words(mechanism, tip)}"
        return
    for key in (name for name in Drive.model_fields if name not in ("kind", *own.keys)):
        yield from _refuse_number(scene, f"drive.{key}", _message_for_key_the_drive_lacks(key, mechanism))
    yield from _check_clearance_and_interference(scene, mechanism)
    if mechanism.further_contacts:
        yield from _refuse_values_with_two_contacts(scene, mechanism)


def _check_clearance_and_interference(scene: "Scene", mechanism: Mechanism) -> Iterator[Fault]:
    """Check that a clearance or interference is small against the roller, or the disc between flat faces."""
    roller, base = known_number_or_none(scene.follower.roller_radius), known_number_or_none(scene.cam.base_radius)
    arm = known_number_or_none(scene.follower.arm_length)
    size, words = (roller, "roller's radius") if roller else (base, "base radius")
    for key in ("clearance", PRELOAD[0]):
        swung = mechanism.motion.angular and key == PRELOAD[0]
        if size is None or (swung and arm is None):
            continue
        most = degrees(LARGEST_PLAY * size / arm) if swung and arm else LARGEST_PLAY * size
        why = f"must be at most a tenth of the {words}{' at the end of the arm' if swung else ''}"
        why += f" ({most:.4g}{' deg' if swung else ''})"
        yield from _refuse_number(scene, f"drive.{key}", why, partial(lt, most), "stop")


def _message_for_key_the_drive_lacks(key: str, mechanism: Mechanism) -> str:
    """The message for a key that the drive does not have, or does not have with this follower."""
    drive, follower = mechanism.drive, f"{mechanism.drive.words} with {mechanism.motion.words} follower"
    if mechanism.second_contact_size_keys and f"drive.{key}" in SECOND_FIELDS:
        return f"{follower} has none; it has {', '.join(mechanism.second_contact_size_keys)}"
    with_it = any(each.drive.name == drive.name and key in each.drive.keys for each in DRIVEN)
    return f"{follower if with_it else drive.words} has none"


def _refuse_values_with_two_contacts(scene: "Scene", mechanism: Mechanism) -> Iterator[Fault]:
    """Faults of values that a follower with two contacts cannot have."""
    words = mechanism.drive.words
    if scene.profile:
        yield "profile", None, f"{words} is given by the [[motion]] of its follower"
    for name in (each for each in GUIDE_KEYS if each in mechanism.motion.own_dynamics_keys):
        why = f"camopt does not compute the guide of {words}: the share of each contact is unknown"
        yield from _refuse_number(scene, f"follower.dynamics.{name}", why)
    for key, other in (PRELOAD, PRELOAD[::-1]):
        if not _given_and_searched_value_by_key(scene, f"drive.{other}"):
            why = f"needs drive.{other}, which is missing: together they make a preload"
            yield from _refuse_number(scene, f"drive.{key}", why)
    interference = _given_and_searched_value_by_key(scene, f"drive.{PRELOAD[0]}")
    if "clearance" in mechanism.drive.keys and any(interference.values()):
        why = "contacts with an interference have no clearance: leave one of them out"
        yield from _refuse_number(scene, "drive.clearance", why)
    if mechanism.drive.one_disc and scene.follower.offset not in (None, 0.0):
        yield "follower.offset", VALUE_IN_SCENE, f"must be 0 with {words}"


def _check_sizes(scene: "Scene", mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    """Check that a mechanism has all its sizes, and none of other mechanisms."""
    what, body, own = _mechanism_words(mechanism, tip), mechanism.body, mechanism.follower_size_keys(tip)
    if tip not in mechanism.tips:
        tips = _alternatives_text(each.name for each in mechanism.tips)
        yield "follower.contact", tip.name, f"must be {tips} on a {body.words}"
        return
    others = [key for other in BODIES.values() for key in other.cam if key not in body.cam]
    absent = [f"cam.{key}" for key in others] + [f"follower.{name}" for name in FOLLOWER_SIZES if name not in own]
    given = scene.numbers(absent)
    given |= {
        f"search.cam.{k}": scene.search.choices_by_key.get(f"cam.{k}") for k in others if k not in SEARCH_SIZES
    }
    for key in (key for key, value in given.items() if value not in (None, 0.0)):
        instead = (
            f": its size is cam.{body.size_key}" if key in (f"cam.{b.size_key}" for b in BODIES.values()) else ""
        )
        yield key, VALUE_IN_SCENE, f"a {what} has none{instead}"
    for name in own:
        if getattr(scene.follower, name) is None and getattr(scene.search, name) is None:
            yield f"follower.{name}", None, f"missing; a {what} needs it"


def _check_dynamics_keys_and_guide(
    scene: "Scene", lift: float | None, mechanism: Mechanism, tip: Tip
) -> Iterator[Fault]:
    """Check that the follower has only keys of its motion, and that the guide never reaches the trace point."""
    motion, table = mechanism.motion, "follower.dynamics"
    why = f"a {_mechanism_words(mechanism, tip)} has none; it has {', '.join(motion.own_dynamics_keys)}"
    for name in (key for other in MOTIONS.values() if other != motion for key in other.own_dynamics_keys):
        yield from _refuse_number(scene, f"{table}.{name}", why)
    lever = _given_and_searched_value_by_key(scene, SPRING_AT) if motion.angular else {}
    if lever and not any(_given_and_searched_value_by_key(scene, key) for key in SPRING_NUMBERS):
        yield next(iter(lever)), VALUE_IN_SCENE, "needs spring_rate in N/mm or preload in N, which are missing"
    if lift is not None and "overhang" in motion.own_dynamics_keys:
        why = f"must be at least the lift ({lift:g}), by which the rise shortens it"
        yield from _refuse_number(scene, f"{table}.overhang", why, partial(gt, lift))
    loads = _given_and_searched_value_by_key(scene, f"{table}.load")
    if isinstance(loads.get(f"{table}.load"), tuple) and f"search.{table}.load" in loads:
        why = f"{table}.load changes over the turn; a single number cannot replace it"
        yield f"search.{table}.load", VALUE_IN_SCENE, why


def _check_lash(scene: "Scene", lift: float | None) -> Iterator[Fault]:
    """Check that a lash is smaller than the lift, and its variation at most the lash."""
    key = "follower.dynamics.lash"
    if lift is not None:
        why = f"must be below the lift ({lift:g}), or the driven part would never move"
        yield from _refuse_number(scene, key, why, partial(le, lift))
    lash, varies = map(known_number_or_none, scene.numbers((key, f"{key}_variation")).values())
    if lash is not None and varies is not None and varies > lash:
        yield f"{key}_variation", varies, f"must be at most the lash ({lash:g})"


def _given_and_searched_value_by_key(scene: "Scene", key: str) -> dict[str, Any]:
    """The given values of a number by key: in its table, and in ``[search]``."""
    both = {key: scene.numbers((key,))[key], f"search.{key}": scene.search.choices_by_key.get(key)}
    return {place: value for place, value in both.items() if value is not None}


def _refuse_number(
    scene: "Scene", key: str, why: str, is_wrong: Callable[[float], bool] | None = None, range_end: str = "start"
) -> Iterator[Fault]:
    """A fault for each place that gives a number; with ``is_wrong``, only if it holds for a value or range end."""
    for place, choice in _given_and_searched_value_by_key(scene, key).items():
        if is_wrong is None or any(map(is_wrong, _known_choice_values(choice, range_end))):
            yield place, VALUE_IN_SCENE, why


def _check_assembly(scene: "Scene", lift: float | None, mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    """Check that the mechanism, and a second contact with sizes of its own, can be assembled at both ends."""
    base, shaft = known_number_or_none(scene.cam.base_radius), known_number_or_none(scene.cam.shaft_diameter)
    if base and shaft and shaft / 2 > base:
        yield "cam.shaft_diameter", shaft, f"must be at most twice the base radius ({2 * base:g})"
    sizes = known_sizes(mechanism, tip, scene.follower, scene.cam) | ({} if lift is None else {"lift": lift})
    with suppress(KeyError):  # a missing size has its own message, or is left to a search
        if misfit := mechanism.misfit(sizes):
            yield misfit
            return
    given = {
        key: known_number_or_none(value) for key, value in scene.numbers(mechanism.second_contact_size_keys).items()
    }
    own = {key: size for key, size in given.items() if size is not None}  # of a second contact
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
            )  # the first disc fits, so that a size of the second contact must be wrong
            yield key, own[key], f"of the second disc: {misfit[2]}"


def _trace_point_to_profile_mm(scene: "Scene", tip: Tip) -> float | None:
    """Distance from trace point to profile, the radius of a roller or spherical face [mm]; None where unknown."""
    return known_number_or_none(getattr(scene.follower, tip.radius)) if tip.radius else 0.0


def _check_search_fits_mechanism(scene: "Scene", mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    search, own = scene.search, (*mechanism.follower_size_keys(tip), mechanism.body.size_key)
    for key in (each for each in SEARCH_SIZES if getattr(search, each) is not None):
        if key not in own:
            yield (
                f"search.{key}",
                VALUE_IN_SCENE,
                f"a {_mechanism_words(mechanism, tip)} has none; known: {', '.join(own)}",
            )
        elif key not in SIGNED_SIZES and any(each <= 0 for each in _known_choice_values(getattr(search, key))):
            yield f"search.{key}", VALUE_IN_SCENE, "must be above 0"
    for name in search.minimise:
        if name in search.maximise:
            yield "search.maximise", name, "is minimised too: leave one of them out"
    if search.law and (search.law_rise or search.law_return):
        yield "search.law", VALUE_IN_SCENE, "give either law, or law_rise and law_return"
    for key in ("sampler", "seed"):
        if key in search.model_fields_set and search.samples is None:
            yield f"search.{key}", VALUE_IN_SCENE, "needs search.samples, which is missing"


def _known_choice_values(choice: Any, range_end: str = "start") -> list[float]:
    """The known values of a choice; of a range, one end."""
    values = [getattr(choice, range_end)] if isinstance(choice, StepRange) else choice
    return [
        each
        for each in (values if isinstance(values, (tuple, list)) else [values])
        if known_number_or_none(each) is not None
    ]


def _check_limits_fit_mechanism(scene: "Scene", mechanism: Mechanism, tip: Tip) -> Iterator[Fault]:
    limits = scene.limits.bounds_by_key
    if "face_reach" in limits and tip != FLAT:
        yield "limits.face_reach", VALUE_IN_SCENE, "only a flat face has a reach"
    if "outer_radius" in limits and mechanism.outline is None:
        yield "limits.outer_radius", VALUE_IN_SCENE, "only a disc cam has one"
    if "cutter_radius" in limits and tip == FLAT:
        yield "limits.cutter_radius", VALUE_IN_SCENE, "a flat face has no hollow flanks, so any cutter fits"
    elif "cutter_radius" in limits and mechanism.is_cut_by_roller_sized_cutter:
        what = "rib" if mechanism.further_contacts else "groove"
        why = f"the cutter of a {what} is at most as large as its roller: set follower.roller_radius instead"
        yield "limits.cutter_radius", VALUE_IN_SCENE, why
    for key in ("velocity", "acceleration", "jerk"):
        if key in limits and not _given_and_searched_value_by_key(scene, "cam.rpm"):
            yield f"limits.{key}", VALUE_IN_SCENE, "needs cam.rpm"
