"""Notes of a drawing on two contacts of one follower: their distance, and its inspection.

An error t of a profile along its normal moves a roller on it by t/cos β along its motion, and an arm of length l by
t/(l·cos β). So the distance of two rollers, each on its disc, changes over a turn by at most

    t·(1/cos β₁ + 1/cos β₂)                (arms: t/(l₁·cos β₁) + t/(l₂·cos β₂))

in both directions, and the breadth of one disc between flat faces by 2·t.
"""

from collections.abc import Iterator
from math import degrees, floor
from typing import NamedTuple

import numpy as np

from camopt.model.effects.contact_distance import ANGLE, BREADTH, DISTANCE
from camopt.model.effects.error_response import contact_responses
from camopt.show.sheet.marks import decimal_text
from camopt.show.sheet.standards import length_text
from camopt.show.sheet.true_cam import TrueCam, design_quantity

DIGIT_ROUNDING = 1e-6  # of a last digit, against rounding


class ContactDistance(NamedTuple):
    """Distance of two contacts, equal at every cam angle [mm, or deg between two arms]."""

    value: float
    interference: float
    """Reduction of the made distance."""
    variation: float | None
    """Largest change over a turn, ±; None if the profile has no tolerance."""
    angular: bool

    def distance_text(self, value: float, digits: int = 3) -> str:
        """A distance as text."""
        return f"{decimal_text(value, digits)}°" if self.angular else length_text(value, digits)

    @property
    def largest_clearance(self) -> float:
        """Largest clearance of both contacts: the variation less the interference, at least 0."""
        return max((self.variation or 0.0) - self.interference, 0.0) if self.interference else 0.0

    @property
    def toleranced_text(self) -> str:
        """Text of the distance with its tolerance."""
        digits = 1e4 if self.angular else 1e3  # down to 0.0001°, or a µm
        tolerance = (
            ""
            if self.variation is None
            else f" ±{self.distance_text(floor(self.variation * digits + DIGIT_ROUNDING) / digits, 4)}"
        )
        return f"{self.distance_text(self.value)}{tolerance}"


def contact_distance(cam: TrueCam) -> ContactDistance | None:
    """Distance of both contacts of a follower; None if it has one contact."""
    setup, tolerance = cam.problem.setup, cam.part.profile_tolerance
    if not setup.mechanism.further_contacts:
        return None
    name = ANGLE if setup.angular else BREADTH if setup.mechanism.flat_faced else DISTANCE
    spacing = float(cam.problem.design.roller_spacing[0])  # of a rib
    value = spacing if spacing and not setup.angular else design_quantity(cam.problem, name)
    assert value is not None
    drive = cam.scene.drive
    varies = None if tolerance is None else distance_variation(cam, tolerance)
    return ContactDistance(value, (drive.interference if drive else None) or 0.0, varies, setup.angular)


def distance_variation(cam: TrueCam, tolerance: float) -> float:
    """Largest change of the distance over a turn [mm or deg], for profile errors up to a tolerance [mm]."""
    problem, angles = cam.problem, np.concatenate(cam.picture.angles_of_pieces)
    each = [
        of.profile_response.terms[0]
        for of in contact_responses(problem.setup, problem.design, problem.programme, angles)
    ]
    moved = tolerance * float(np.abs(each).sum(axis=0).max())
    return degrees(moved) if problem.setup.angular else moved


def contact_notes(cam: TrueCam) -> Iterator[str]:
    """Notes on two contacts; none for one contact."""
    found = contact_distance(cam)
    if found is None:
        return
    if cam.is_disc_pair:
        one, other = (f"{k + 1}" for k in (cam.place, 1 - cam.place))
        text = "Conjugate pair: disc {} in full lines, disc {} dashed. Both tables are from the same timing mark{}."
        where = cam.translate(", on disc 1" if cam.part.hub_diameter else ", which each disc has")
        yield cam.translate(text).format(one, other, where)
    what = (
        "Angle between both arms {}"
        if found.angular
        else "Distance of both flat faces {}"
        if cam.problem.setup.mechanism.flat_faced
        else "Distance of the centres of both rollers {}"
    )
    made = "{}, made {} for an interference of {}." if found.interference else "{}."
    sizes = [found.distance_text(found.value - found.interference), found.distance_text(found.interference, 4)]
    yield cam.translate(made).format(
        cam.translate(what).format(found.distance_text(found.value)), *sizes[: 2 * bool(found.interference)]
    )
    yield cam.translate(_inspection_text(cam)).format(found.toleranced_text)
    if found.largest_clearance:
        text = "Within the tolerance of the profile the interference may be lost: clearance up to {}."
        yield cam.translate(text).format(found.distance_text(found.largest_clearance, 4))


def _inspection_text(cam: TrueCam) -> str:
    """Text on the inspection of the discs or the rib."""
    mechanism = cam.problem.setup.mechanism
    what = "angle between the arms {}." if cam.problem.setup.angular else "distance of their centres {}."
    if cam.is_ribbed:
        return f"Inspect the rib between both rollers, over a turn: {what}"
    if mechanism.flat_faced:
        return "Inspect the breadth between two parallel faces, in every direction: {}."
    if mechanism.drive.one_disc:
        return "Inspect the disc between two rollers on opposite sides, over a turn: distance of their centres {}."
    return f"Inspect both discs together, with both rollers on them, over a turn: {what}"
