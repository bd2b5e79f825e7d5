"""Mechanisms: pairings of cam and follower.

Each pairing is a module with one record, ``MECHANISM``. Grooves in a face, pairs and ribs make theirs from these.
"""

from camopt.model.mechanisms import (
    cylindrical,
    cylindrical_oscillating,
    face_groove,
    oscillating,
    oscillating_flat,
    pairs,
    ribs,
    translating,
    translating_flat,
)
from camopt.model.mechanisms.design import (
    FIELDS,
    SECOND_FIELDS,
    SIZE_FIELDS,
    Designs,
    Mechanism,
    concatenate_designs,
)
from camopt.model.mechanisms.elements import FLAT, TIPS

__all__ = [
    "DRIVEN",
    "FIELDS",
    "MECHANISMS",
    "SECOND_FIELDS",
    "SIZE_FIELDS",
    "Designs",
    "Mechanism",
    "concatenate_designs",
    "mechanism_for",
    "mechanisms_for",
]

MECHANISMS: dict[tuple[str, str, bool], Mechanism] = {
    (mechanism.body.form, mechanism.motion.name, FLAT in mechanism.tips): mechanism
    for mechanism in (
        translating.MECHANISM,
        translating_flat.MECHANISM,
        oscillating.MECHANISM,
        oscillating_flat.MECHANISM,
        cylindrical.MECHANISM,
        cylindrical_oscillating.MECHANISM,
    )
}
"""The mechanisms with their usual drive, by form of the cam, motion of the follower, and whether its face is
flat."""
DRIVEN: tuple[Mechanism, ...] = (*face_groove.FACE_GROOVE_MECHANISMS, *pairs.PAIR_MECHANISMS, *ribs.RIB_MECHANISMS)
"""The mechanisms with another drive."""


def mechanisms_for(form: str, motion: str, contact: str) -> list[Mechanism]:
    """The mechanisms of a form of cam, a motion of the follower and its contact, the usual drive first.

    If none has the contact, all mechanisms of the form and motion.
    """
    mechanisms = [m for m in (*MECHANISMS.values(), *DRIVEN) if (m.body.form, m.motion.name) == (form, motion)]
    return [m for m in mechanisms if TIPS.get(contact) in m.tips] or mechanisms


def mechanism_for(form: str, motion: str, contact: str, drive: str | None = None) -> Mechanism:
    """The mechanism of a scene's ``cam.form``, ``follower.motion``, ``follower.contact`` and ``drive.kind``.

    Without a drive, or with one that no such mechanism has, the one with the usual drive.
    """
    mechanisms = mechanisms_for(form, motion, contact)
    return next((m for m in mechanisms if m.drive.name == drive), mechanisms[0])
