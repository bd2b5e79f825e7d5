"""The mechanism and sizes in the plain mapping of a scene."""

from collections.abc import Mapping
from typing import Any

from camopt.mechanisms import FIELDS, Mechanism, mechanism_for
from camopt.mechanisms.body import BODIES
from camopt.mechanisms.drive import DRIVES
from camopt.mechanisms.follower import MOTIONS, TIPS, Tip
from camopt.scene.mapping import at, length, number_of
from camopt.scene.tables import Cam, Follower

FOLLOWER_SIZES, CAM_SIZES = (tuple(key for key in table.model_fields if key in FIELDS) for table in (Follower, Cam))
"""The keys of sizes in ``[follower]``, and in ``[cam]``."""
SEARCHED = (*FOLLOWER_SIZES, *CAM_SIZES)
"""Those in ``[search]``."""
SIGNED_SIZES = {"offset": 0.0, "face_offset": None}
"""Sizes that may be 0 or below, each with what it is where a scene does not give it."""

FORM_WORDS: tuple[dict[str, Any], ...] = (BODIES, MOTIONS, TIPS)
"""What ``cam.form``, ``follower.motion`` and ``follower.contact`` may say."""


def mechanism_in(data: Mapping[str, Any], form: str | None = None) -> tuple[Mechanism, Tip] | None:
    """The mechanism and the tip of its follower, of a form of cam or the scene's own; None if a word is wrong."""
    named = form or at(data, "cam.form"), at(data, "follower.motion"), at(data, "follower.contact")
    drive = at(data, "drive.kind")
    if not all(isinstance(word, str) and word in known for word, known in zip(named, FORM_WORDS, strict=True)):
        return None
    if drive is not None and not (isinstance(drive, str) and drive in DRIVES):
        return None
    return mechanism_for(*named, drive), TIPS[named[2]]


def sizes_in(data: Mapping[str, Any], mechanism: Mechanism, tip: Tip) -> dict[str, float]:
    """The sizes of a mechanism in mm, by field of ``Designs``; without those that are missing or wrong."""
    found = {"size": length(data, f"cam.{mechanism.body.size}")}
    for field in mechanism.sizes:
        if field in SIGNED_SIZES:
            given = at(data, f"follower.{field}")
            found[field] = SIGNED_SIZES[field] if given is None else number_of(given)
        elif field != "roller_radius":
            found[field] = length(data, f"follower.{field}")
        else:
            found[field] = length(data, f"follower.{tip.radius}") if tip.radius else 0.0
    return {field: size for field, size in found.items() if size is not None}


def sizes_of(mechanism: Mechanism, tip: Tip, follower: Any) -> dict[str, float]:
    """The sizes that the table ``[follower]`` of a scene gives of a mechanism, likewise."""
    keys = {field: field for field in mechanism.sizes} | {"roller_radius": tip.radius}
    given = {field: getattr(follower, key) if key else 0.0 for field, key in keys.items()}
    found = {field: SIGNED_SIZES.get(field) if size is None else size for field, size in given.items()}
    return {field: size for field, size in found.items() if size is not None}
