"""Elastic constants of common materials of cams and followers.

Sources: Norton, Machine Design, app. A, and Budynas and Nisbett, Shigley's Mechanical Engineering Design, table A-5
(steel, cast irons, bronze); Munz and Fett, Ceramics (silicon nitride). Grades scatter by a few per cent: give
``cam_modulus`` and the like where it matters.
"""

from typing import NamedTuple


class Material(NamedTuple):
    """Young's modulus in GPa and Poisson's ratio."""

    modulus: float
    poisson: float


MATERIALS: dict[str, Material] = {
    "steel": Material(207.0, 0.292),
    "stainless-steel": Material(190.0, 0.305),
    "grey-cast-iron": Material(100.0, 0.211),
    "ductile-iron": Material(169.0, 0.29),
    "bronze": Material(111.0, 0.349),
    "silicon-nitride": Material(310.0, 0.27),
}
"""Materials by the name that scenes use."""
