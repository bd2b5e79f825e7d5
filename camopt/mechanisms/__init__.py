"""Mechanisms: pairings of cam and follower. One module each, all with one record, MECHANISM."""

from camopt.mechanisms import (
    cylindrical,
    cylindrical_oscillating,
    oscillating,
    oscillating_flat,
    translating,
    translating_flat,
)
from camopt.mechanisms.design import FIELDS, SIZE_FIELDS, Designs, Mechanism, concatenate
from camopt.mechanisms.follower import FLAT, TIPS

__all__ = ["FIELDS", "MECHANISMS", "SIZE_FIELDS", "Designs", "Mechanism", "concatenate", "mechanism_for"]

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
"""By form of the cam, motion of the follower, and whether its face is flat."""


def mechanism_for(form: str, motion: str, contact: str) -> Mechanism:
    """The mechanism of a scene's ``cam.form``, ``follower.motion`` and ``follower.contact``.

    Where none has the contact, the first of that form and motion.
    """
    known = [m for m in MECHANISMS.values() if (m.body.form, m.motion.name) == (form, motion)]
    return next((m for m in known if TIPS.get(contact) in m.tips), known[0])
