"""Rib: how thick it is between the two rollers of a follower.

From the tangent of a flank where its roller touches it to the other roller, square to that tangent,

    t = d·cos(β − σ·½δ) − 2·R_r − j,     sin(½δ) = d/(2l)      (translating: δ = 0)

with the distance d of the rollers' centres, their clearance j, the pressure angle β at that roller, the sense of
rotation σ, and arms of the length l (``mechanisms.ribs``). The rib of a follower that translates is nowhere thinner
than the least t. That of one that swings may be thicker than that, since its rollers go on circles: the least t is
then on the safe side. At 0 and below the rollers leave no rib, and it is no cam.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.effects.case import Case, Effect, Setup
from camopt.effects.peak import Peak
from camopt.effects.peak_columns import peak_column
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import ALL_STROKES
from camopt.numerics import LEAST, FloatArray
from camopt.numerics.curves import curve, formula

THICKNESS = "rib_thickness_min_mm"


class RibThickness(NamedTuple):
    """t, mm: (across + along·tan β)/√(1 + tan² β) − rollers."""

    pressure: Any
    across: FloatArray
    along: FloatArray
    rollers: FloatArray


@formula(RibThickness)
def rib_thickness(f, i, at):
    t, t1 = curve(f.pressure, i, at)
    across, along, square = f.across[i], f.along[i], 1.0 + np.square(t)
    root = np.sqrt(square)
    return (across + along * t) / root - f.rollers[i], (along - across * t) * t1 / (square * root)


def offers(setup: Setup) -> tuple[str, ...]:
    return (THICKNESS,) if has_rib(setup) else ()


def has_rib(setup: Setup) -> bool:
    return "roller_spacing" in setup.mechanism.sizes


def _spacing(designs: Designs) -> Any:
    """d, mm: thicknesses are right to so much of it."""
    return designs.roller_spacing


def peaks(setup: Setup) -> dict[str, Peak]:
    def thickness(designs: Designs, programme: Programme) -> RibThickness:
        d, zero = designs.roller_spacing, designs.size * 0.0
        sine = 0.5 * d / designs.arm_length if setup.angular else zero
        across, along = d * np.sqrt((1.0 - sine) * (1.0 + sine)), d * sine * designs.sense
        pressure = setup.mechanism.pressure(designs, programme)
        return RibThickness(pressure, across, along, 2.0 * setup.half_width(designs) + zero)

    return (
        {THICKNESS: Peak(((thickness, ALL_STROKES),), LEAST, unit=_spacing, open_at_zero=True)}
        if has_rib(setup)
        else {}
    )


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    return {THICKNESS: peak_column(case, peaks(case.setup)[THICKNESS])}


EFFECT = Effect("rib", offers, run, peaks=peaks, of_contact=True)
