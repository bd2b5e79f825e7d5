"""A constant ratio: a lever, gears or a belt, or a rack with its pinion.

    output = i·input        from an angle to a length r·φ, and back s/r

``ratio`` is i, below 0 where it turns the motion round; ``radius`` is r, that of the pinion or drum.
"""

from camopt.model.trains.constant import Constant
from camopt.model.trains.link import Keys, Stage, Unassembled, needed

LEAST = 1e-9
"""A ratio nearer to 0 makes numbers that no double holds."""


def _links(keys: Keys, turns: bool) -> tuple[Constant]:
    if len(keys) != 1:
        raise Unassembled("it has either a ratio, or the radius of a pinion or drum (mm)")
    ((name, factor),) = keys.items()
    needed(abs(factor) - LEAST, lambda: f"a {name} of 0, or less than {LEAST:g} from it, moves nothing")
    if name == "ratio":
        return (Constant(factor, (turns, turns)),)
    return (Constant(factor if turns else 1.0 / factor, (turns, not turns)),)


def _turns(keys: Keys, turns: bool) -> bool:
    return turns != ("radius" in keys)


STAGE = Stage("ratio", "a constant ratio", (), ("ratio", "radius"), _turns, _links)
