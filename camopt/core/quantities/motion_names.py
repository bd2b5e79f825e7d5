"""Quantities of a motion: peaks, means and errors of its derivatives, with names and units."""

from itertools import product

from camopt.core.quantities.quantity import Quantity

AT_FOLLOWER = "follower"
STROKE_WORDS = {
    "rise": "over the rises; with a train, of the tool",
    "return": "over the returns; with a train, of the tool",
    "": "over the turn; with a train, of the tool",
    AT_FOLLOWER: "of a follower that drives a train",
}
"""The part of the turn that a motion quantity is about, by the part of its name."""
DERIVATIVE_UNITS = {
    "velocity": ("v", {"m_s": "m/s", "rad_s": "rad/s", "mm_per_rad": "mm/rad", "deg_per_rad": "deg/rad"}),
    "acceleration": (
        "a",
        {"m_s2": "m/s²", "rad_s2": "rad/s²", "mm_per_rad2": "mm/rad²", "deg_per_rad2": "deg/rad²"},
    ),
    "jerk": ("j", {"m_s3": "m/s³", "rad_s3": "rad/s³", "mm_per_rad3": "mm/rad³", "deg_per_rad3": "deg/rad³"}),
}


def displacement_unit(*, angular: bool) -> str:
    """Unit of a displacement in tables."""
    return "deg" if angular else "mm"


def motion_peak_name(derivative: str, stroke: str, *, angular: bool, timed: bool) -> str:
    """Name of the peak of a derivative: by time if ``timed`` (the scene has an rpm), else by cam angle."""
    suffix, _ = _motion_suffix_and_unit(derivative, angular=angular, timed=timed)
    return "_".join(part for part in (derivative, "max", stroke, suffix) if part)


def motion_unit(derivative: str, *, angular: bool, timed: bool) -> str:
    """Unit of a motion quantity in tables."""
    return _motion_suffix_and_unit(derivative, angular=angular, timed=timed)[1]


def _motion_suffix_and_unit(derivative: str, *, angular: bool, timed: bool) -> tuple[str, str]:
    return [*DERIVATIVE_UNITS[derivative][1].items()][2 * (not timed) + angular]  # the order of the units there


MOTION_QUANTITIES = [
    Quantity(
        motion_peak_name(derivative, stroke, angular=angular, timed=timed),
        f"{DERIVATIVE_UNITS[derivative][0]}_max",
        motion_unit(derivative, angular=angular, timed=timed),
        "motion",
        f"Largest |{derivative}| {words}.",
    )
    for derivative, (stroke, words), angular, timed in product(
        DERIVATIVE_UNITS, STROKE_WORDS.items(), (False, True), (True, False)
    )
]


def motion_error_name(derivative_order: int, *, angular: bool, timed: bool) -> str:
    """Name of the largest error of position, velocity or acceleration (order 0, 1, 2)."""
    if derivative_order == 0:
        return f"position_error_max_{displacement_unit(angular=angular)}"
    derivative = [*DERIVATIVE_UNITS][derivative_order - 1]
    return motion_peak_name(derivative, "", angular=angular, timed=timed).replace("_max_", "_error_max_")


def dwell_error_name(*, angular: bool) -> str:
    """Name of the largest change of the position in a dwell."""
    return f"dwell_error_max_{displacement_unit(angular=angular)}"


RMS_ORDERS = {"acceleration": 2, "jerk": 3}
"""Derivatives that have a root mean square, with their orders."""


def motion_rms_name(derivative: str, *, angular: bool, timed: bool) -> str:
    """Name of the root mean square of a derivative."""
    return motion_peak_name(derivative, "", angular=angular, timed=timed).replace("_max_", "_rms_")


MOTION_ERROR_QUANTITIES = [
    Quantity(name, "", unit, "motion_errors", f"{sentence} due to tolerances, to first order.")
    for name, unit, sentence in (
        *(
            (
                motion_error_name(0, angular=angular, timed=True),
                displacement_unit(angular=angular),
                "Largest error of the position over the turn",
            )
            for angular in (False, True)
        ),
        *(
            (
                motion_error_name(order, angular=angular, timed=timed),
                motion_unit(derivative, angular=angular, timed=timed),
                f"Largest error of the {derivative} over the turn",
            )
            for (order, derivative), timed, angular in product(
                enumerate([*DERIVATIVE_UNITS][:2], 1), (True, False), (False, True)
            )
        ),
        *(
            (
                dwell_error_name(angular=angular),
                displacement_unit(angular=angular),
                "Largest change of the position in a dwell",
            )
            for angular in (False, True)
        ),
    )
]
MOTION_RMS_QUANTITIES = [
    Quantity(
        motion_rms_name(derivative, angular=angular, timed=timed),
        f"{DERIVATIVE_UNITS[derivative][0]}_rms",
        motion_unit(derivative, angular=angular, timed=timed),
        "rms",
        f"Root mean square of the {derivative} over the turn; with a train, of the tool.",
    )
    for derivative, angular, timed in product(RMS_ORDERS, (False, True), (True, False))
]
