"""Area, first moment and polar moment of plane figures about the cam's axis: discs, and a keyway beside its bore.

A keyway of width w runs from the bore (radius r) to a flat bottom at the distance r + t from the axis. It is the
rectangle |v| ≤ a = w/2, 0 ≤ u ≤ r + t, without the part of the bore inside it. With c = √(r² − a²) and
φ = arcsin(a/r) that part has

    area = a·c + r²·φ,    ∫u dA = a·r² − a³/3,    ∫(u² + v²) dA = a·c·(r² + 2a²)/6 + r⁴·φ/2

Source: integrals of Bronshtein et al., Handbook of Mathematics, table 21.7 (√(a² − x²)).
"""

from math import asin, cos, pi, sin, sqrt
from typing import Any, NamedTuple


class AreaMoments(NamedTuple):
    """Area [mm²], first moment (complex x + iy) [mm³] and polar moment about the axis [mm⁴]; numbers or arrays."""

    area: Any
    moment: Any
    polar: Any

    def subtract(self, other: "AreaMoments") -> "AreaMoments":
        """The figure without another one inside it."""
        return AreaMoments(*(a - b for a, b in zip(self, other, strict=True)))

    def add(self, other: "AreaMoments") -> "AreaMoments":
        """Both figures together; they do not overlap."""
        return AreaMoments(*(a + b for a, b in zip(self, other, strict=True)))

    def times(self, factor: float) -> "AreaMoments":
        """The moments times a factor, as a thickness or a density."""
        return AreaMoments(*(factor * each for each in self))


def disc_moments(radius: Any) -> AreaMoments:
    return AreaMoments(pi * radius**2, 0.0, pi * radius**4 / 2.0)


def keyway_moments(bore_radius: float, width: float, depth: float, angle: float) -> AreaMoments:
    """Moments of a keyway in the direction of an angle [rad], without the bore; all 0 if its width is 0."""
    r, a, u = bore_radius, width / 2.0, bore_radius + depth
    if not a:
        return AreaMoments(0.0, 0.0, 0.0)
    c, phi = sqrt((r - a) * (r + a)), asin(a / r)
    area = 2.0 * a * u - (a * c + r**2 * phi)
    along = a * u**2 - (a * r**2 - a**3 / 3.0)
    polar = 2.0 * a * u * (u**2 + a**2) / 3.0 - (a * c * (r**2 + 2.0 * a**2) / 6.0 + r**4 * phi / 2.0)
    return AreaMoments(area, along * complex(cos(angle), sin(angle)), polar)
