"""A constant ratio: a lever, gears, a belt, or a rack with its pinion.

    output = i·input;        a pinion turns an angle φ into the length r·φ, and a length s into the angle s/r

The key ``ratio`` is i, negative if input and output move opposite ways. The key ``radius`` is r, the radius of the
pinion or drum.
"""

from camopt.model.trains.constant_ratio import ConstantRatio
from camopt.model.trains.link import AssemblyFault, Keys, StageKind, require_positive

LEAST_RATIO = 1e-9
"""Smallest magnitude of a ratio or radius: a smaller one leads to numbers that doubles cannot hold."""


def _ratio_links(keys: Keys, input_angular: bool) -> tuple[ConstantRatio]:
    if len(keys) != 1:
        raise AssemblyFault("it has either a ratio, or the radius of a pinion or drum (mm)")
    ((name, factor),) = keys.items()
    require_positive(
        abs(factor) - LEAST_RATIO, lambda: f"a {name} below {LEAST_RATIO:g} in size does not move the tool"
    )
    if name == "ratio":
        return (ConstantRatio(factor, (input_angular, input_angular)),)
    return (ConstantRatio(factor if input_angular else 1.0 / factor, (input_angular, not input_angular)),)


def _is_output_angular(keys: Keys, input_angular: bool) -> bool:
    return input_angular != ("radius" in keys)


STAGE = StageKind("ratio", "a constant ratio", (), ("ratio", "radius"), _is_output_angular, _ratio_links)
