"""A fitted motion as the segments and laws of a scene, which start where the motion is lowest."""

from typing import Any, NamedTuple

import numpy as np

from camopt.solve.measured.least_jerk import OutlineMotion
from camopt.solve.measured.measured_points import TURN_DEG, angle_from
from camopt.solve.measured.outline import ANGLE_DIGITS
from camopt.solve.measured.spline_chain import CHAIN_DEGREE

FITTED_LAW = "measured"
LEVEL_DIGITS = 9  # of lifts, whose levels have fewer


class FittedSegments(NamedTuple):
    """The tables of a motion; ``start`` (deg) and ``zero`` are the measured angle and lift where it has 0 and 0."""

    motion: list[dict[str, Any]]
    laws: dict[str, dict[str, Any]]
    start: float
    zero: float


def fitted_segments(shaped: OutlineMotion) -> FittedSegments:
    """The segments of a motion, from its lowest: an angle of 0 if it rests there, else the end of that dwell."""
    nodes, count = shaped.nodes, len(shaped.nodes)
    first = min(range(count), key=lambda k: (nodes[k].level, nodes[k].start - nodes[k].end))
    lowest, zero = nodes[first], nodes[first].level
    rest = _round_angle(lowest.end - lowest.start)
    before = float(angle_from(lowest.start, 0.0))  # from where the dwell starts to an angle of 0
    inside = 0.0 < before < rest
    start = 0.0 if inside else lowest.end % TURN_DEG
    motion: list[dict[str, Any]] = [_dwell_segment(rest - before)] if inside else []
    laws = {}
    for number in range(count):
        k, following = (first + number) % count, (first + number + 1) % count
        lift = nodes[following].level - nodes[k].level
        name = f"{FITTED_LAW}-{number + 1}"
        segment = "rise" if lift > 0.0 else "return"
        angle, lift = _round_angle(shaped.strokes[k].angle), round(abs(lift), LEVEL_DIGITS)
        motion.append({"segment": segment, "angle": angle, "lift": lift, "law": name})
        knots, coefficients = shaped.strokes[k].chain.knots.tolist(), shaped.coefficients[k].tolist()
        laws[name] = {"degree": CHAIN_DEGREE, "knots": knots, "coefficients": coefficients}
        if nodes[following].is_dwell:
            last = following == first
            length = nodes[following].end - nodes[following].start
            motion.append(_dwell_segment(before if last and inside else length))
    return FittedSegments(motion, laws, start, zero)


def _dwell_segment(angle: float) -> dict[str, Any]:
    return {"segment": "dwell", "angle": _round_angle(angle)}


def _round_angle(angle: float) -> float:
    return float(np.round(angle, ANGLE_DIGITS))
