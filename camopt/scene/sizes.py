"""The mechanism and the sizes that a scene gives."""

from math import isnan
from typing import Any

from camopt.model.mechanisms import FIELDS, Mechanism, mechanism_for
from camopt.model.mechanisms.elements import BODIES, DRIVES, MOTIONS, TIPS, Tip
from camopt.scene.tables import Cam, Follower

FOLLOWER_SIZES, CAM_SIZES = (tuple(key for key in table.model_fields if key in FIELDS) for table in (Follower, Cam))
"""The keys of sizes in ``[follower]``, and in ``[cam]``."""
SEARCH_SIZES = (*FOLLOWER_SIZES, *CAM_SIZES)
"""The keys of sizes in ``[search]``."""
SIGNED_SIZES = {"offset": 0.0, "face_offset": None}
"""Sizes that may be 0 or below, each with its value if not given."""

FORM_WORDS: tuple[dict[str, Any], ...] = (BODIES, MOTIONS, TIPS)
"""The words allowed for ``cam.form``, ``follower.motion`` and ``follower.contact``."""


def mechanism_and_tip_named(form: Any, motion: Any, contact: Any, drive: Any) -> tuple[Mechanism, Tip] | None:
    """The mechanism and its tip, by the words in a scene; None if a word is wrong."""
    named = form, motion, contact
    known = all(isinstance(word, str) and word in words for word, words in zip(named, FORM_WORDS, strict=True))
    known &= drive is None or (isinstance(drive, str) and drive in DRIVES)
    return (mechanism_for(*named, drive), TIPS[contact]) if known else None


def known_number_or_none(value: Any) -> float | None:
    """A number of a scene; None if it is missing or wrong."""
    return value if isinstance(value, float) and not isnan(value) else None


def known_sizes(mechanism: Mechanism, tip: Tip, follower: Any, cam: Any = None) -> dict[str, float]:
    """The sizes of a mechanism in mm, by field of ``Designs``, without those that are missing or wrong."""
    keys = {field: field for field in mechanism.sizes} | {"roller_radius": tip.radius}
    given = {field: getattr(follower, key) if key else 0.0 for field, key in keys.items()}
    given |= {} if cam is None else {"size": getattr(cam, mechanism.body.size_key)}
    sizes = {
        field: SIGNED_SIZES.get(field) if size is None else known_number_or_none(size)
        for field, size in given.items()
    }
    return {field: size for field, size in sizes.items() if size is not None}
