"""What is off of a cam: errors by key of ``[tolerances]``, and between which values each is.

An error that has a direction is told as a length and a way, the angle of it, under a key of its own; formulas take
both coordinates, under the same keys: ``flat``. The axis of a bore has one in the ground, at the cam angle φ of the
point that a nominal follower touches. Of a profile with at most n waves it is that of δn and δn'/n
(``tolerances.exact``).

A profile that is anywhere within its zone ±t moves the follower no more than one that stands out by t, or is short
of it by t, everywhere: the body is between these two.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.effects.error_response import SECOND_CONTACT_SUFFIX, errors_by_contact
from camopt.model.mechanisms import FIELDS
from camopt.model.mechanisms.contact_errors import ContactErrors
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.tolerance_zones import tool_zones
from camopt.scene.problem.variables import is_train_key, variables_of
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES, moves_tool

BORE, BORE_DIRECTION = "bore_eccentricity", "bore_eccentricity_way"
"""The distance of the bore's axis, and in which direction of the ground it is when the point is touched, rad."""
WAVE_PHASE = "profile_way"
"""Of a profile with waves: how far the point is from a crest, rad of the wave."""
PROFILE_LEVEL = "profile_level"
"""By how much a profile with waves stands out, where x is that of its second derivative."""
Errors = Mapping[str, Any]
"""By key of ``[tolerances]``, mm or rad, with BORE_WAY; of a number of the train in the unit of its key."""
CamErrors = Mapping[str, FloatArray]
"""By how much cams are off, each (n,), by key of ``[tolerances]``, in mm or rad; complex of a profile with
waves (a + ib stands out by a·cos nφ + b·sin nφ) and of the bore's axis (x + iy in the frame of the cam)."""


def error_ranges(scene: Scene, problem: Problem) -> dict[str, tuple[float, float]]:
    """Between which values each error of the cams within the tolerances is."""
    given, developed = scene.tolerances, problem.setup.mechanism.body.developed
    found = {key: (zone.lower, zone.upper) for key, zone in tool_zones(scene, problem.nominal_numbers).items()}
    if given.profile:
        found["profile"] = -given.profile, given.profile
    if given.bore_eccentricity:  # what is across the surface of a cylinder moves nothing
        found[BORE] = -given.bore_eccentricity if developed else 0.0, given.bore_eccentricity
        found |= {} if developed else {BORE_DIRECTION: (-pi, pi)}
    return found


def error_unit(scene: Scene, key: str) -> str:
    """The unit of what is off by a key of ``[tolerances]``, or of a way, where it is shown."""
    own = {each.key: each.unit for each in variables_of(scene)}
    return own.get(key, "deg" if key in ANGLE_TOLERANCES or is_direction(key) else "mm")


def is_direction(key: str) -> bool:
    """Whether an error is a direction, or where waves are: any angle of a turn."""
    return key.startswith((BORE_DIRECTION, WAVE_PHASE))


def direction_key(key: str) -> str:
    """The key of the direction of an error, or of where its waves are, if it has one."""
    return key.replace("profile", WAVE_PHASE) if key.startswith("profile") else f"{key}_way"


def flat_errors(errors: Errors) -> dict[str, Any]:
    """Errors with both coordinates of those that have a way: x under their own key, y under that of the way."""
    found = dict(errors)
    for key in errors:
        if (way := direction_key(key)) in errors and not is_direction(key):
            found |= {key: errors[key] * np.cos(errors[way]), way: errors[key] * np.sin(errors[way])}
    return found


def polar_errors(errors: Errors, ends: Errors) -> dict[str, Any]:
    """Flat errors with the lengths and ways of those of ``ends`` that have one."""
    found = {key: errors[key] for key in ends}
    for key in ends:
        if (way := direction_key(key)) in ends and not is_direction(key):
            found |= {key: np.hypot(errors[key], errors[way]), way: np.arctan2(errors[way], errors[key])}
    return found


def turn_error(errors: Errors, key: str, angle: Any) -> dict[str, Any]:
    """Flat errors, of which one that has a way is turned ccw by an angle, rad."""
    if (way := direction_key(key)) not in errors:
        return dict(errors)
    x, y, cosine, sine = errors[key], errors[way], np.cos(angle), np.sin(angle)
    return {**errors, key: x * cosine - y * sine, way: x * sine + y * cosine}


def contact_errors(errors: Errors) -> ContactErrors:
    """What is off of a cam and its follower by errors that are flat."""
    sizes = {FIELDS[k.partition(".")[2]]: each for k, each in errors.items() if k.startswith("follower.")}
    out = errors.get("profile", 0.0) + sizes.pop("roller_radius", 0.0)
    bore = errors.get(BORE, 0.0), errors.get(BORE_DIRECTION, 0.0)
    return ContactErrors(sizes, out, bore, errors.get("face_tilt", 0.0))


def errors_at_places(errors: Mapping[str, float], count: int) -> CamErrors:
    """The errors of one cam in mm and deg, as those of the worst cam are told, for a number of places on it."""
    found: dict[str, FloatArray] = {}
    for key, value in errors.items():
        if direction_key(key) in errors and not is_direction(key):
            found[key] = np.full(count, value * np.exp(1j * np.radians(errors[direction_key(key)])))
        elif not is_direction(key):
            found[key] = np.full(count, np.radians(value) if key in ANGLE_TOLERANCES else value)
    return found


def contact_problems(problem: Problem) -> tuple[Problem, ...]:
    """Each contact of the follower, as that of an ordinary cam without a train."""
    alone, programme = replace(problem.setup, train=None), replace(problem.programme, tool_programme=None)
    return replace(problem, setup=alone, programme=programme).contact_problems


def is_second_mirrored(problem: Problem) -> bool:
    """Whether the second contact sees the cam turn the other way: in a mirror along its axis, not across it."""
    (further,) = problem.setup.mechanism.further_contacts
    return bool(further.local_designs(problem.design).sense != problem.design.sense)


def errors_at_contact(problem: Problem, place: int, errors: Mapping[str, Any]) -> dict[str, Any]:
    """Errors as a contact has them; that of the bore, in the frame of the cam, is in the mirror at the second."""
    if not problem.setup.mechanism.further_contacts:
        return dict(errors)
    found, turned = dict[str, Any](), bool(place) and is_second_mirrored(problem)
    for key, value in errors.items():
        if key == BORE:
            found[key] = np.conj(value) if turned and BORE_DIRECTION not in errors else value
        elif key == BORE_DIRECTION:
            found[key] = -value if turned else value
        elif key.startswith((WAVE_PHASE, PROFILE_LEVEL)):
            second = SECOND_CONTACT_SUFFIX if key.endswith(SECOND_CONTACT_SUFFIX) else ""
            own = errors_by_contact(problem.setup.mechanism, "profile")[f"profile{second}"][place]
            found |= {key.removesuffix(SECOND_CONTACT_SUFFIX): own[1] * value} if own else {}
        elif (
            own := errors_by_contact(problem.setup.mechanism, key.removesuffix(SECOND_CONTACT_SUFFIX))[key][place]
        ) is not None:
            found[own[0]] = found.get(own[0], 0.0) + own[1] * value
    return found


def error_keys(problem: Problem, key: str) -> tuple[str, ...]:
    """The keys of the errors that a tolerance is of: with two contacts it may be one of each."""
    both = problem.setup.mechanism.further_contacts and moves_tool(key)
    alone = not both or key == BORE_DIRECTION or is_train_key(key)
    return (key,) if alone else tuple(errors_by_contact(problem.setup.mechanism, key))


def contact_error_ranges(scene: Scene, problem: Problem, order: int = 0) -> dict[str, tuple[float, float]]:
    """Between which values each error of the cams within the tolerances is, with one contact or two.

    To velocity (1) and acceleration (2) the axis of a cylinder counts with its way, and a profile with that of its
    waves; one whose waves are not limited counts as one that is off by a constant: it has no bound.
    """
    found = {each: ends for key, ends in error_ranges(scene, problem).items() for each in error_keys(problem, key)}
    for key, (_, high) in [*found.items()] if order else ():
        if key == BORE or (scene.tolerances.waves and key.startswith("profile")):
            found |= {key: (0.0, high), direction_key(key): (-pi, pi)}
    return found
