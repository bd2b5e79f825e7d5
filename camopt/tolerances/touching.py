"""The exact error of the motion of a cam that is off, at the angle at which it touches with a point of its profile.

At φ a nominal follower touches a point, and stands at y(φ). The real one touches it at θ = φ + turned, where it
should stand at y(θ), and stands at y(φ) + moved (``mechanisms.rest``): its error is

    δ = moved − (y(θ) − y(φ)),    of the tool  f(y(θ) + δ) − f(y(θ))

with the train's f. Nothing is linear here, and nothing is iterated.

A profile that is anywhere within its zone ±t moves the follower no more than one that stands out by t, or is short
of it by t, everywhere: the body is between these two.
"""

from collections.abc import Mapping
from math import pi, radians
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms import FIELDS
from camopt.mechanisms.rest import Off
from camopt.motion.driven import tool_position
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem
from camopt.problem.zones import size_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import zone_of

BORE, BORE_WAY = "bore_eccentricity", "bore_eccentricity_way"
"""The distance of the bore's axis, and in which direction of the ground it is when the point is touched, rad."""
ANGLES = ("phase", "face_tilt")
"""Keys of tolerances that are angles: rad inside, deg outside."""
Errors = Mapping[str, Any]
"""By key of ``[tolerances]``, mm or rad, with BORE_WAY."""


def error_ends(scene: Scene, problem: Problem) -> dict[str, tuple[float, float]]:
    """Between which values each error of the cams within the tolerances is."""
    given, developed = scene.tolerances, problem.setup.mechanism.body.developed
    zones = size_zones(scene, problem.design)
    found = {f"follower.{key}": (zone.lower, zone.upper) for key, zone in zones.items()}
    if given.profile is not None:
        found["profile"] = -given.profile, given.profile
    if given.bore_eccentricity is not None:  # what is across the surface of a cylinder moves nothing
        found[BORE] = -given.bore_eccentricity if developed else 0.0, given.bore_eccentricity
        found |= {} if developed else {BORE_WAY: (-pi, pi)}
    for key in ANGLES:
        if (tolerance := getattr(given, key)) is not None:
            zone = zone_of(tolerance, key, 0.0).scaled(radians(1.0))
            found[key] = zone.lower, zone.upper
    return found


def off_by(errors: Errors) -> Off:
    """What is off of a cam and its follower by errors."""
    sizes = {FIELDS[k.partition(".")[2]]: each for k, each in errors.items() if k.startswith("follower.")}
    out, distance = errors.get("profile", 0.0) + sizes.pop("roller_radius", 0.0), errors.get(BORE, 0.0)
    bore: tuple[Any, Any] = (distance, 0.0)
    if BORE_WAY in errors:
        bore = np.cos(errors[BORE_WAY]) * distance, np.sin(errors[BORE_WAY]) * distance
    return Off(sizes, out, bore, errors.get("face_tilt", 0.0))


class Contact(NamedTuple):
    """Where cams touch with points of their profiles, and the errors of their motion there."""

    angle: FloatArray
    """The cam angle θ, rad."""
    error: FloatArray
    """Of the tool, mm or rad."""


def contact_of(problem: Problem, errors: Errors, angles: FloatArray) -> Contact:
    """The contact of cams with the points that a nominal follower touches at cam angles (m,), rad.

    Errors are numbers, or arrays (m,) of a cam for each angle.
    """
    programme, train = problem.programme, problem.setup.train
    turn = programme.strokes[-1].end
    y, y1, *_ = programme.at(np.mod(angles, turn))
    rest = problem.setup.mechanism.rest(problem.design, programme.lift, y, y1, off_by(errors))
    there = angles + rest.turned - errors.get("phase", 0.0)
    asked = np.mod(there, turn)
    if train is None:
        return Contact(there, y + rest.moved - programme.at(asked)[0])
    first, last = (train.follower_at(tool_position(programme, np.mod(each, turn))) for each in (angles, asked))
    stood = np.asarray(train.tool(Taylor([first + rest.moved])).terms[0])
    return Contact(there, stood - np.asarray(train.tool(Taylor([last])).terms[0]))
