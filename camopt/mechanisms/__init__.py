"""Mechanisms: pairings of cam and follower. One module each, all with one record, MECHANISM."""

from camopt.mechanisms import (
    cylindrical,
    cylindrical_oscillating,
    oscillating,
    oscillating_flat,
    translating,
    translating_flat,
)
from camopt.mechanisms.design import FIELDS, SIZES, Designs, Mechanism, chained

__all__ = ["FIELDS", "MECHANISMS", "SIZES", "Designs", "Mechanism", "chained", "mechanism_for"]

MECHANISMS: dict[tuple[str, str, bool], Mechanism] = {
    ("disc", "translating", False): translating.MECHANISM,
    ("disc", "translating", True): translating_flat.MECHANISM,
    ("disc", "oscillating", False): oscillating.MECHANISM,
    ("disc", "oscillating", True): oscillating_flat.MECHANISM,
    ("cylindrical", "translating", False): cylindrical.MECHANISM,
    ("cylindrical", "oscillating", False): cylindrical_oscillating.MECHANISM,
}
"""By form of the cam, motion of the follower, and whether its face is flat."""


def mechanism_for(form: str, motion: str, contact: str) -> Mechanism:
    """The mechanism of a scene's ``cam.form``, ``follower.motion`` and ``follower.contact``."""
    return MECHANISMS[form, motion, contact == "flat"]
