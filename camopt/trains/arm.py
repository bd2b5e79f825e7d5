"""An arm whose end moves a slide by a roller or a rounded pad on a face that is square to the slide's motion.

Turned by φ from its start angle α, which is measured from the line square to the motion, an arm of length l gives

    z = l·(sin(α + φ) − sin α)        z′ = l·cos(α + φ)

whatever the radius of the roller or pad, since the face is square to the motion. It is at a dead point where it
points along the motion.

Source: Norton, Design of Machinery, ch. 2 (the Scotch yoke is the same pairing).
"""

from dataclasses import dataclass
from math import cos, pi, radians, sin

from camopt.numerics.taylor import Series, angle_of, direction, root
from camopt.trains.link import NO_COUPLERS, DeadPoint, Unassembled

ALONG = "the arm points along the motion of the slide"


@dataclass(frozen=True)
class Arm:
    """From an angle to a length; mm and rad."""

    length: float
    start: float
    cosine: float
    sine: float
    """Of the start angle, as both formulas take it."""
    couplers = NO_COUPLERS

    @property
    def turns(self) -> tuple[bool, bool]:
        return True, False

    @property
    def ends(self) -> tuple[DeadPoint, DeadPoint]:
        return DeadPoint(-pi / 2 - self.start, ALONG), DeadPoint(pi / 2 - self.start, ALONG)

    def forward(self, given: Series) -> Series:
        cosine, sine = direction(given)
        return (sine * self.cosine + (cosine - 1.0) * self.sine) * self.length

    def backward(self, asked: Series) -> Series:
        sine = asked / self.length + self.sine
        cosine = root(-((sine - 1.0) * (sine + 1.0)))
        return angle_of(cosine * self.cosine + sine * self.sine, sine * self.cosine - cosine * self.sine)

    def ratio(self, given: Series) -> Series:
        cosine, sine = direction(given)
        return (cosine * self.cosine - sine * self.sine) * self.length


def arm(length: float, angle: float) -> Arm:
    """An arm with its start angle in deg.

    Raises
    ------
    Unassembled
        If the angle is not between −90 and 90.
    """
    if not -90.0 < angle < 90.0:
        raise Unassembled(f"an arm at {angle:g} deg {ALONG.removeprefix('the arm ')}, or beyond")
    start = radians(angle)
    return Arm(length, start, cos(start), sin(start))
