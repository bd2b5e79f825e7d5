"""A fitted motion as the segments and laws of a scene, which start where the motion is lowest."""

from typing import Any, NamedTuple

import numpy as np

from camopt.solve.measured.least_jerk import Shaped
from camopt.solve.measured.outline import ANGLE_DIGITS
from camopt.solve.measured.reading import FULL_TURN, angle_from
from camopt.solve.measured.spline_chain import CHAIN_DEGREE

FITTED_LAW = "measured"
LEVEL_DIGITS = 9  # of lifts, whose levels have fewer


class Segments(NamedTuple):
    """The tables of a motion; ``start`` (deg) and ``zero`` are the measured angle and lift where it has 0 and 0."""

    motion: list[dict[str, Any]]
    laws: dict[str, dict[str, Any]]
    start: float
    zero: float


def fitted_segments(shaped: Shaped) -> Segments:
    """The segments of a motion, from its lowest: an angle of 0 if it rests there, else the end of that dwell."""
    nodes, count = shaped.nodes, len(shaped.nodes)
    first = min(range(count), key=lambda k: (nodes[k].level, nodes[k].start - nodes[k].end))
    lowest, zero = nodes[first], nodes[first].level
    rest = _rounded(lowest.end - lowest.start)
    before = float(angle_from(lowest.start, 0.0))  # from where the dwell starts to an angle of 0
    inside = 0.0 < before < rest
    start = 0.0 if inside else lowest.end % FULL_TURN
    motion: list[dict[str, Any]] = [_dwell(rest - before)] if inside else []
    laws = {}
    for number in range(count):
        k, following = (first + number) % count, (first + number + 1) % count
        lift = nodes[following].level - nodes[k].level
        name = f"{FITTED_LAW}-{number + 1}"
        segment = "rise" if lift > 0.0 else "return"
        angle, lift = _rounded(shaped.strokes[k].angle), round(abs(lift), LEVEL_DIGITS)
        motion.append({"segment": segment, "angle": angle, "lift": lift, "law": name})
        knots, coefficients = shaped.strokes[k].chain.knots.tolist(), shaped.coefficients[k].tolist()
        laws[name] = {"degree": CHAIN_DEGREE, "knots": knots, "coefficients": coefficients}
        if nodes[following].rests:
            last = following == first
            length = nodes[following].end - nodes[following].start
            motion.append(_dwell(before if last and inside else length))
    return Segments(motion, laws, start, zero)


def _dwell(angle: float) -> dict[str, Any]:
    return {"segment": "dwell", "angle": _rounded(angle)}


def _rounded(angle: float) -> float:
    return float(np.round(angle, ANGLE_DIGITS))
