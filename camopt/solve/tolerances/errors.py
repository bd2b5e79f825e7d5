"""Errors of cams by key of ``[tolerances]``, and the range of each.

An error with a direction has two keys: its length under its own key, and its angle under a second key. This is the
*polar* form. Formulas take the *flat* form, with the coordinates x and y under the same two keys. The direction of
the bore's axis is measured in the ground, at the cam angle φ of the point that the nominal follower touches. For a
profile with at most n waves, x and y are the error δn and δn'/n (``tolerances.real_cam``).

A profile anywhere within its zone ±t moves the follower by no more than a profile that is too high, or too low, by
t everywhere: the body lies between these two.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.effects.error_response import SECOND_CONTACT_SUFFIX, errors_at_contacts_by_key
from camopt.model.mechanisms import FIELDS
from camopt.model.mechanisms.contact_errors import ContactErrors
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.tolerance_zones import tolerance_zones_that_move_tool
from camopt.scene.problem.variables import is_train_key, variables_of_scene
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES, does_error_move_tool

BORE, BORE_DIRECTION = "bore_eccentricity", "bore_eccentricity_way"
"""Keys of the eccentricity of the bore, and of its direction in the ground when the point is touched (rad)."""
WAVE_PHASE = "profile_way"
"""Key of the phase of a profile's waves: distance of the point from a crest (rad of the wave)."""
PROFILE_LEVEL = "profile_level"
"""Key of the height of a profile with waves, where x is the share of its second derivative."""
Errors = Mapping[str, Any]
"""Errors by key of ``[tolerances]`` and ``BORE_DIRECTION``: mm or rad, numbers of the train in their own units."""
CamErrors = Mapping[str, FloatArray]
"""Errors of many cams by key of ``[tolerances]``, arrays of (cams,), mm or rad.

They are complex for a profile with waves (a + ib is the error a·cos nφ + b·sin nφ), and for the axis of the bore (x
+ iy in the frame of the cam).
"""


def error_ranges_at_one_contact(scene: Scene, problem: Problem) -> dict[str, tuple[float, float]]:
    """Least and largest value of each error of cams within the tolerances, mm or rad."""
    tolerances, developed = scene.tolerances, problem.setup.mechanism.body.developed
    ranges = {
        key: (zone.lower, zone.upper)
        for key, zone in tolerance_zones_that_move_tool(scene, problem.nominal_numbers).items()
    }
    if tolerances.profile:
        ranges["profile"] = -tolerances.profile, tolerances.profile
    if tolerances.bore_eccentricity:  # an error across the surface of a cylinder moves nothing
        ranges[BORE] = -tolerances.bore_eccentricity if developed else 0.0, tolerances.bore_eccentricity
        ranges |= {} if developed else {BORE_DIRECTION: (-pi, pi)}
    return ranges


def error_unit(scene: Scene, key: str) -> str:
    """Unit in which the error of a key, or its direction, is shown."""
    units = {each.key: each.unit for each in variables_of_scene(scene)}
    return units.get(key, "deg" if key in ANGLE_TOLERANCES or is_direction(key) else "mm")


def is_direction(key: str) -> bool:
    """Whether a key is of a direction or of the phase of waves: any angle of a turn."""
    return key.startswith((BORE_DIRECTION, WAVE_PHASE))


def direction_key(key: str) -> str:
    """The key under which an error's direction, or the phase of its waves, would stand."""
    return key.replace("profile", WAVE_PHASE) if key.startswith("profile") else f"{key}_way"


def direction_keys(errors: Collection[str]) -> dict[str, str]:
    """The key of the direction of each error that has one, by key of the error."""
    return {key: direction_key(key) for key in errors if not is_direction(key) and direction_key(key) in errors}


def flat_from_polar_errors(errors: Errors) -> dict[str, Any]:
    """Polar errors in flat form: x under the key of the error, y under the key of its direction."""
    flat = dict(errors)
    for key, way in direction_keys(errors).items():
        flat |= {key: errors[key] * np.cos(errors[way]), way: errors[key] * np.sin(errors[way])}
    return flat


def polar_from_flat_errors(errors: Errors, error_ranges_by_key: Errors) -> dict[str, Any]:
    """Flat errors in polar form: length and direction for the keys of ``error_ranges_by_key``."""
    polar = {key: errors[key] for key in error_ranges_by_key}
    for key, way in direction_keys(error_ranges_by_key).items():
        polar |= {key: np.hypot(errors[key], errors[way]), way: np.arctan2(errors[way], errors[key])}
    return polar


def with_turned_vector_error(errors: Errors, key: str, angle: Any) -> dict[str, Any]:
    """Flat errors, with that of one key turned anticlockwise by an angle (rad) if it has a direction."""
    if (way := direction_key(key)) not in errors:
        return dict(errors)
    x, y, cosine, sine = errors[key], errors[way], np.cos(angle), np.sin(angle)
    return {**errors, key: x * cosine - y * sine, way: x * sine + y * cosine}


def contact_errors_from_flat_errors(errors: Errors) -> ContactErrors:
    """Errors of cam and follower as the contact formulas take them, from flat errors."""
    sizes = {FIELDS[k.partition(".")[2]]: each for k, each in errors.items() if k.startswith("follower.")}
    out = errors.get("profile", 0.0) + sizes.pop("roller_radius", 0.0)
    bore = errors.get(BORE, 0.0), errors.get(BORE_DIRECTION, 0.0)
    return ContactErrors(sizes, out, bore, errors.get("face_tilt", 0.0))


def repeat_cam_errors(errors: Mapping[str, float], count: int) -> CamErrors:
    """Errors of one cam (mm and deg, as ``WorstCase`` has them), repeated for a number of places on it."""
    factors = {key: np.exp(1j * np.radians(errors[way])) for key, way in direction_keys(errors).items()}
    return {
        key: np.full(count, np.radians(value) if key in ANGLE_TOLERANCES else value * factors.get(key, 1.0))
        for key, value in errors.items()
        if not is_direction(key)
    }


def contact_problems(problem: Problem) -> tuple[Problem, ...]:
    """One problem for each contact of the follower, as an ordinary cam without a train."""
    setup, programme = replace(problem.setup, train=None), replace(problem.programme, tool_programme=None)
    return replace(problem, setup=setup, programme=programme).problem_of_each_contact


def reverses_cam_at_second_contact(problem: Problem) -> bool:
    """Whether the cam turns in the opposite sense at the second contact: a mirror image along the cam's axis."""
    (further,) = problem.setup.mechanism.further_contacts
    return bool(further.local_designs(problem.design).sense != problem.design.sense)


def errors_at_contact(problem: Problem, contact_number: int, errors: Mapping[str, Any]) -> dict[str, Any]:
    """Errors as they act at one contact (0 or 1).

    The error of the bore, in the frame of the cam, is mirrored at a mirrored second contact.
    """
    if not problem.setup.mechanism.further_contacts:
        return dict(errors)
    at_contact, mirrored = dict[str, Any](), bool(contact_number) and reverses_cam_at_second_contact(problem)
    for key, value in errors.items():
        if key == BORE:
            at_contact[key] = np.conj(value) if mirrored and BORE_DIRECTION not in errors else value
        elif key == BORE_DIRECTION:
            at_contact[key] = -value if mirrored else value
        elif key.startswith((WAVE_PHASE, PROFILE_LEVEL)):
            suffix = SECOND_CONTACT_SUFFIX if key.endswith(SECOND_CONTACT_SUFFIX) else ""
            signed_key = errors_at_contacts_by_key(problem.setup.mechanism, "profile")[f"profile{suffix}"][
                contact_number
            ]
            at_contact |= {key.removesuffix(SECOND_CONTACT_SUFFIX): signed_key[1] * value} if signed_key else {}
        elif (
            signed_key := errors_at_contacts_by_key(
                problem.setup.mechanism, key.removesuffix(SECOND_CONTACT_SUFFIX)
            )[key][contact_number]
        ) is not None:
            at_contact[signed_key[0]] = at_contact.get(signed_key[0], 0.0) + signed_key[1] * value
    return at_contact


def error_keys_at_contacts(problem: Problem, key: str) -> tuple[str, ...]:
    """Keys of the errors that a tolerance permits: one, or one at each of two contacts."""
    has_two_contacts = problem.setup.mechanism.further_contacts and does_error_move_tool(key)
    is_single = not has_two_contacts or key == BORE_DIRECTION or is_train_key(key)
    return (key,) if is_single else tuple(errors_at_contacts_by_key(problem.setup.mechanism, key))


def error_ranges_by_key_at_all_contacts(
    scene: Scene, problem: Problem, derivative_order: int = 0
) -> dict[str, tuple[float, float]]:
    """Least and largest value of each error of cams within the tolerances, at one contact or two, mm or rad.

    For velocity (order 1) and acceleration (2) the axis of a cylinder has a direction, and a profile the phase of
    its waves. A profile without a limit of its waves counts as a constant error: its rate has no bound.
    """
    ranges = {
        each: ends
        for key, ends in error_ranges_at_one_contact(scene, problem).items()
        for each in error_keys_at_contacts(problem, key)
    }
    for key, (_, high) in [*ranges.items()] if derivative_order else ():
        if key == BORE or (scene.tolerances.waves and key.startswith("profile")):
            ranges |= {key: (0.0, high), direction_key(key): (-pi, pi)}
    return ranges
