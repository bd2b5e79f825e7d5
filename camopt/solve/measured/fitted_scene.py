"""A fitted motion as segments and laws of a scene, from its lowest point."""

from typing import Any, NamedTuple

import numpy as np

from camopt.solve.measured.least_jerk import OutlineMotion
from camopt.solve.measured.measured_points import TURN_DEG, forward_angle_deg
from camopt.solve.measured.outline import ANGLE_DIGITS
from camopt.solve.measured.spline_chain import CHAIN_DEGREE

FITTED_LAW = "measured"
LEVEL_DIGITS = 9  # decimals of lifts; levels have fewer


class FittedSegments(NamedTuple):
    """Tables of a motion; ``start`` [deg] and ``zero`` are the measured angle and lift at its 0 and 0."""

    motion: list[dict[str, Any]]
    laws: dict[str, dict[str, Any]]
    start: float
    zero: float


def fitted_segments(outline_motion: OutlineMotion) -> FittedSegments:
    """The segments of a motion from its lowest point.

    They begin at angle 0 if the motion rests there, else at the end of the lowest dwell or turning point.
    """
    nodes, count = outline_motion.nodes, len(outline_motion.nodes)
    first = min(range(count), key=lambda k: (nodes[k].level, nodes[k].start - nodes[k].end))
    lowest, zero = nodes[first], nodes[first].level
    dwell_angle = _round_angle(lowest.end - lowest.start)
    angle_before_0 = float(forward_angle_deg(lowest.start, 0.0))  # from the start of the dwell to angle 0
    rests_at_0 = 0.0 < angle_before_0 < dwell_angle
    start = 0.0 if rests_at_0 else lowest.end % TURN_DEG
    motion: list[dict[str, Any]] = [_dwell_segment(dwell_angle - angle_before_0)] if rests_at_0 else []
    laws = {}
    for number in range(count):
        k, following = (first + number) % count, (first + number + 1) % count
        lift = nodes[following].level - nodes[k].level
        name = f"{FITTED_LAW}-{number + 1}"
        segment = "rise" if lift > 0.0 else "return"
        angle, lift = _round_angle(outline_motion.strokes[k].angle), round(abs(lift), LEVEL_DIGITS)
        motion.append({"segment": segment, "angle": angle, "lift": lift, "law": name})
        knots, coefficients = (
            outline_motion.strokes[k].chain.clamped_knot_vector.tolist(),
            outline_motion.coefficients[k].tolist(),
        )
        laws[name] = {"degree": CHAIN_DEGREE, "knots": knots, "coefficients": coefficients}
        if nodes[following].is_dwell:
            is_last = following == first
            length = nodes[following].end - nodes[following].start
            motion.append(_dwell_segment(angle_before_0 if is_last and rests_at_0 else length))
    return FittedSegments(motion, laws, start, zero)


def _dwell_segment(angle: float) -> dict[str, Any]:
    return {"segment": "dwell", "angle": _round_angle(angle)}


def _round_angle(angle: float) -> float:
    return float(np.round(angle, ANGLE_DIGITS))
