"""The exact error of the motion of a cam that is off, at the angle at which it touches with a point of its profile.

At φ a nominal follower touches a point, and stands at y(φ). The real one touches it at θ = φ + turned, where it
should stand at y(θ), and stands at y(φ) + moved (``mechanisms.rest``): its error is

    δ = moved − (y(θ) − y(φ)),    of the tool  f*(y(θ) + δ) − f(y(θ))

with the train's f, and the f* of its own links. Both count from the start position, in which a train is set: what
links that are off move there is taken out where it is mounted. Nothing is linear here, and nothing is iterated.

A profile that is anywhere within its zone ±t moves the follower no more than one that stands out by t, or is short
of it by t, everywhere: the body is between these two.
"""

from collections.abc import Mapping
from math import pi
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms import FIELDS
from camopt.mechanisms.rest import Off
from camopt.motion.driven import tool_position
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem
from camopt.problem.variables import variables_of
from camopt.problem.zones import tool_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLES

BORE, BORE_WAY = "bore_eccentricity", "bore_eccentricity_way"
"""The distance of the bore's axis, and in which direction of the ground it is when the point is touched, rad."""
WAY = "profile_way"
"""Of a profile with waves: how far the point is from a crest, rad of the wave."""
Errors = Mapping[str, Any]
"""By key of ``[tolerances]``, mm or rad, with BORE_WAY; of a number of the train in the unit of its key."""


def error_ends(scene: Scene, problem: Problem) -> dict[str, tuple[float, float]]:
    """Between which values each error of the cams within the tolerances is."""
    given, developed = scene.tolerances, problem.setup.mechanism.body.developed
    found = {key: (zone.lower, zone.upper) for key, zone in tool_zones(scene, problem.nominal).items()}
    if given.profile is not None:
        found["profile"] = -given.profile, given.profile
    if given.bore_eccentricity is not None:  # what is across the surface of a cylinder moves nothing
        found[BORE] = -given.bore_eccentricity if developed else 0.0, given.bore_eccentricity
        found |= {} if developed else {BORE_WAY: (-pi, pi)}
    return found


def error_unit(scene: Scene, key: str) -> str:
    """The unit of what is off by a key of ``[tolerances]``, or of a way, where it is shown."""
    own = {each.key: each.unit for each in variables_of(scene)}
    return own.get(key, "deg" if key in ANGLES or is_way(key) else "mm")


def is_way(key: str) -> bool:
    """Whether an error is a direction, or where waves are: any angle of a turn."""
    return key.startswith((BORE_WAY, WAY))


def way_of(key: str) -> str:
    """The key of the direction of an error, or of where its waves are, if it has one."""
    return key.replace("profile", WAY) if key.startswith("profile") else f"{key}_way"


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
    stood = np.asarray(problem.train_off(errors).tool(Taylor([first + rest.moved])).terms[0])
    return Contact(there, stood - np.asarray(train.tool(Taylor([last])).terms[0]))
