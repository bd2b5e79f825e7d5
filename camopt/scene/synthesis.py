"""The table ``[synthesis]`` of a scene: what free laws minimise, and their further limits."""

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
    check_pair,
    check_whole_number,
    known_name,
)


def _check_peak_factor(value: Any) -> Any:
    """A peak factor: ± a number, a range that holds 0, or that of a law, by name."""
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple)):
        pair = check_pair(value)
        if not -LARGEST_VALUE <= pair[0] <= 0.0 < pair[1] <= LARGEST_VALUE:
            raise ValueError("a range with 0 in it")
        return pair
    number = check_number(value)
    if not 0.0 < number <= LARGEST_VALUE:
        raise ValueError("a number above 0, a range or the name of a law")
    return number


AXIS_TERMS = (
    *("size", "velocity", "acceleration", "jerk", "acceleration_rms", "jerk_rms"),
    *("residual_vibration", "lost_lift_area"),
)
OBJECTIVE_TERMS = (*AXIS_TERMS, "crossing_jerk")
TERM_OR_AXIS = "a term of the objective; loads, as torque_peak_N_m, are axes of a frontier"
PeakAsked = Annotated[float | tuple[float, float] | str, BeforeValidator(_check_peak_factor)] | None
ObjectiveTerm = Annotated[str, known_name(OBJECTIVE_TERMS, TERM_OR_AXIS)]
PointPairs = tuple[Annotated[tuple[float, float], BeforeValidator(check_pair)], ...]


class SynthesisSettings(SceneTable):
    """The objective and the further limits of new motion laws, beside ``[limits]``.

    ``minimise`` is size (mm), velocity, acceleration or jerk (largest over the turn), acceleration_rms or
    jerk_rms (root mean square over the turn), residual_vibration (in a dwell), lost_lift_area (what the lift area
    lacks of the highest lift over 360 deg, mm·deg: the least has the largest lift area), crossing_jerk (largest
    while a roller crosses ``drive.clearance``, which it does within ``crossing_window``), or a table of weights for
    several; units are those of ``[limits]``, or by the cam angle without a speed. ``peak_velocity``,
    ``peak_acceleration``, ``peak_jerk`` are those of rises and returns, as `camopt laws` lists them: a number
    for ±, a range, or the name of a law that has as much. Where neither these nor ``[limits]`` bound
    acceleration or jerk, each that is not minimised is held to poly345's, and in moves to 1.25 times what the
    scene's own have. ``rest`` is 2 at least where the jerk is bounded or minimised. A ``smooth`` of 0.01 gives
    up 1 % of the objective; what then varies less rings less. Laws are B-splines.
    """

    minimise: Annotated[
        Annotated[ObjectiveTerm, Tag("range/")]
        | Annotated[dict[ObjectiveTerm, Positive], Field(min_length=1), Tag("values/")],
        Discriminator(lambda value: LOCATION_TAGS[isinstance(value, dict)]),
        Key("What free laws minimise: one term, or a table of weights for several"),
    ] = "size"
    peak_velocity: Annotated[PeakAsked, Key("Bound on the velocity of the unit stroke", "no unit")] = None
    peak_acceleration: Annotated[PeakAsked, Key("Bound on the acceleration of the unit stroke", "no unit")] = None
    peak_jerk: Annotated[PeakAsked, Key("Bound on the jerk of the unit stroke", "no unit")] = None
    rest: Annotated[
        int,
        BeforeValidator(check_whole_number),
        Field(ge=1, le=3),
        Key("How many derivatives are zero beside a dwell"),
    ] = 2
    monotone: Annotated[Switch, Key("Whether rises never fall, and returns never rise")] = False
    symmetric: Annotated[
        Switch, Key("Whether the motion is its own mirror image, about a cam angle that the segments allow")
    ] = False
    crossing_window: Annotated[
        float,
        BoundedNumber(gt=0, le=180),
        Key(
            "Cam angle from where the force turns round, within which the roller has to land on the other flank",
            "deg",
        ),
    ] = 15.0
    smooth: Annotated[
        float,
        BoundedNumber(ge=0, le=1),
        Key("Share of the objective that is given up for the least variation of the jerk", "no unit"),
    ] = 0.0
    points: Annotated[
        PointPairs, Key("Points (cam angle, displacement) that the motion goes through", "deg and mm", "deg")
    ] = ()
    degree: Annotated[
        int, BeforeValidator(check_whole_number), Field(ge=4, le=9), Key("Degree of the B-splines")
    ] = 5
    pieces: Annotated[
        int, BeforeValidator(check_whole_number), Field(ge=2, le=200), Key("Polynomial pieces of a stroke")
    ] = 48
    continuity: Annotated[
        Annotated[int, BeforeValidator(check_whole_number), Field(ge=2, le=8)] | None,
        Key("How many derivatives are continuous, one less than the degree if not given"),
    ] = None
