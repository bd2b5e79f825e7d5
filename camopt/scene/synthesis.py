"""The table ``[synthesis]`` of a scene: objective and limits of computed motion laws."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Field, Tag

from camopt.core.quantities.key import Key
from camopt.scene.pydantic_mistakes import LOCATION_TAGS
from camopt.scene.tables import (
    LARGEST_VALUE,
    BoundedNumber,
    Positive,
    SceneTable,
    Switch,
    check_number,
    check_two_numbers,
    check_whole_number,
    known_name_validator,
)


def _check_peak_factor(value: Any) -> float | tuple[float, ...] | str:
    """A peak factor: a number for ±, a range around 0, or the name of a law with that peak."""
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple)):
        pair = check_two_numbers(value)
        if not -LARGEST_VALUE <= pair[0] <= 0.0 < pair[1] <= LARGEST_VALUE:
            raise ValueError("a range that contains 0")
        return pair
    number = check_number(value)
    if not 0.0 < number <= LARGEST_VALUE:
        raise ValueError("a number above 0, a range, or the name of a law")
    return number


AXIS_TERMS = (
    *("size", "velocity", "acceleration", "jerk", "acceleration_rms", "jerk_rms"),
    *("residual_vibration", "lost_lift_area"),
)
OBJECTIVE_TERMS = (*AXIS_TERMS, "crossing_jerk")
TERM_OR_AXIS = "a term of the objective; loads such as torque_peak_N_m are axes of a frontier only"
PeakAsked = Annotated[float | tuple[float, float] | str, BeforeValidator(_check_peak_factor)] | None
ObjectiveTerm = Annotated[str, known_name_validator(OBJECTIVE_TERMS, TERM_OR_AXIS)]
PointPairs = tuple[Annotated[tuple[float, float], BeforeValidator(check_two_numbers)], ...]


class SynthesisSettings(SceneTable):
    """Objective and limits of motion laws that camopt computes as B-splines, in addition to ``[limits]``.

    Terms of ``minimise`` are:

    - size [mm];
    - velocity, acceleration or jerk: the largest over the turn;
    - acceleration_rms or jerk_rms: the root mean square over the turn;
    - residual_vibration: in a dwell;
    - lost_lift_area [mm·deg]: the highest lift times 360 deg, less the lift area; the least value has the largest
      lift area;
    - crossing_jerk: the largest jerk while a roller crosses ``drive.clearance``, within
    ``crossing_window``.

    A table of weights combines several terms. Units are those of ``[limits]``; without a speed, derivatives are by
    cam angle.

    ``peak_velocity``, ``peak_acceleration`` and ``peak_jerk`` limit rises and returns on the unit stroke, as
    ``camopt laws`` lists them: a number for ±, a range, or the name of a law with the same peak. If neither these
    keys nor ``[limits]`` limit acceleration or jerk, the one that is not minimised is limited to the peak of
    poly345; in moves, to 1.25 times the peak of the scene's moves. ``rest`` is at least 2 if jerk is limited or
    minimised. ``smooth = 0.01`` allows a 1 % worse objective for the least variation of jerk, which excites less
    vibration.
    """

    minimise: Annotated[
        Annotated[ObjectiveTerm, Tag("range/")]
        | Annotated[dict[ObjectiveTerm, Positive], Field(min_length=1), Tag("values/")],
        Discriminator(lambda value: LOCATION_TAGS[isinstance(value, dict)]),
        Key("Objective of computed laws: one term, or a table of weights for several"),
    ] = "size"
    peak_velocity: Annotated[PeakAsked, Key("Limit on the velocity of the unit stroke", "no unit")] = None
    peak_acceleration: Annotated[PeakAsked, Key("Limit on the acceleration of the unit stroke", "no unit")] = None
    peak_jerk: Annotated[PeakAsked, Key("Limit on the jerk of the unit stroke", "no unit")] = None
    rest: Annotated[
        int,
        BeforeValidator(check_whole_number),
        Field(ge=1, le=3),
        Key("Number of derivatives that are 0 where a stroke meets a dwell"),
    ] = 2
    monotone: Annotated[Switch, Key("Whether rises must never fall and returns never rise")] = False
    symmetric: Annotated[
        Switch, Key("Whether the motion must be symmetric about a cam angle; the segments must allow it")
    ] = False
    crossing_window: Annotated[
        float,
        BoundedNumber(gt=0, le=180),
        Key(
            "Cam angle within which the roller must reach the other flank, from where the force reverses",
            "deg",
        ),
    ] = 15.0
    smooth: Annotated[
        float,
        BoundedNumber(ge=0, le=1),
        Key("Share by which the objective may worsen for the least variation of the jerk", "no unit"),
    ] = 0.0
    points: Annotated[
        PointPairs, Key("Points [cam angle, displacement] that the motion passes through", "deg and mm", "deg")
    ] = ()
    degree: Annotated[
        int, BeforeValidator(check_whole_number), Field(ge=4, le=9), Key("Degree of the B-splines")
    ] = 5
    pieces: Annotated[
        Annotated[int, BeforeValidator(check_whole_number), Field(ge=2, le=200)] | None,
        Key("Number of polynomial pieces of a stroke; if not given, 10 to 48 if the limits are convex, else 48"),
    ] = None
    continuity: Annotated[
        Annotated[int, BeforeValidator(check_whole_number), Field(ge=2, le=8)] | None,
        Key("Number of continuous derivatives; one less than the degree if not given"),
    ] = None
