"""Elastic constants and densities of common materials of cams and followers.

Sources: Norton, Machine Design, app. A, and Budynas and Nisbett, Shigley's Mechanical Engineering Design, table A-5
(steel, cast irons, bronze); Munz and Fett, Ceramics (silicon nitride). Densities: the unit weights of Shigley's
table A-5 by 9.81 m/s², rounded to 50 kg/m³; EN 1563 (ductile iron); ASTM F2094 (silicon nitride). Grades scatter by
a few per cent: set ``cam_modulus``, ``part.density`` and similar keys where that matters.
"""

from typing import NamedTuple


class Material(NamedTuple):
    """Young's modulus [GPa], Poisson's ratio, density [kg/m³]."""

    modulus: float
    poisson: float
    density: float


MATERIALS: dict[str, Material] = {
    "steel": Material(207.0, 0.292, 7800.0),
    "stainless-steel": Material(190.0, 0.305, 7750.0),
    "grey-cast-iron": Material(100.0, 0.211, 7200.0),
    "ductile-iron": Material(169.0, 0.29, 7100.0),
    "bronze": Material(111.0, 0.349, 8150.0),
    "silicon-nitride": Material(310.0, 0.27, 3200.0),
}
"""Materials by the name that scenes use."""
