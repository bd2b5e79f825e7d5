"""Mechanisms: pairings of cam and follower.

One module each, all with one record, MECHANISM; further drives of such cams have a module with MECHANISMS.
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
from camopt.model.mechanisms.design import FIELDS, SECOND_FIELDS, SIZE_FIELDS, Designs, Mechanism, concatenate
from camopt.model.mechanisms.elements import FLAT, TIPS

__all__ = [
    "DRIVEN",
    "FIELDS",
    "MECHANISMS",
    "SECOND_FIELDS",
    "SIZE_FIELDS",
    "Designs",
    "Mechanism",
    "concatenate",
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
"""By form of the cam, motion of the follower, and whether its face is flat: each with its usual drive."""
DRIVEN: tuple[Mechanism, ...] = (*face_groove.FACE_GROOVE_MECHANISMS, *pairs.PAIR_MECHANISMS, *ribs.RIB_MECHANISMS)
"""Those with another drive than the usual one."""


def mechanisms_for(form: str, motion: str, contact: str) -> list[Mechanism]:
    """The mechanisms of a form of cam, a motion and a contact of its follower, that with its usual drive first.

    Where none has the contact, those of that form and motion.
    """
    known = [m for m in (*MECHANISMS.values(), *DRIVEN) if (m.body.form, m.motion.name) == (form, motion)]
    return [m for m in known if TIPS.get(contact) in m.tips] or known


def mechanism_for(form: str, motion: str, contact: str, drive: str | None = None) -> Mechanism:
    """The mechanism of a scene's ``cam.form``, ``follower.motion``, ``follower.contact`` and ``drive.kind``.

    Where none has that drive, or none is named, the one with the usual drive.
    """
    known = mechanisms_for(form, motion, contact)
    return next((m for m in known if m.drive.name == drive), known[0])
