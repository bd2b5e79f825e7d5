"""The table ``[tolerances]`` of a scene: tolerances of the numbers of a cam, its follower and its train.

A tolerance is a number, ± in the unit of its key; a table with ``plus`` and ``minus``; or a class of ISO 286, such
as ``"h6"``, for a length. For a radius the class applies to the diameter.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from math import sqrt
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError

from camopt.core.mistakes import BadInput
from camopt.core.quantities import STAGE_NUMBER_KEYS
from camopt.core.quantities.key import Key
from camopt.model.mechanisms import SECOND_FIELDS, Mechanism
from camopt.model.mechanisms.elements import Tip
from camopt.scene.choices import Reader, read_number_choices, read_row_choices, searchable_number_types
from camopt.scene.csv_columns import MOST_SPANS, read_csv_columns
from camopt.scene.iso286 import limit_deviations
from camopt.scene.law_forms import VALUE_IN_SCENE, Fault
from camopt.scene.mapping import finite_number_or_none, leaf_values_by_key, table_named
from camopt.scene.pydantic_mistakes import mistakes_from_pydantic
from camopt.scene.sizes import CAM_SIZES, FOLLOWER_SIZES, SEARCH_SIZES, SIGNED_SIZES, known_number_or_none
from camopt.scene.tables import (
    BoundedNumber,
    Cam,
    Drive,
    Follower,
    Materials,
    NotNegative,
    Positive,
    SceneNumber,
    SceneTable,
    check_whole_number,
)
from camopt.scene.train import CARRIED_KEYS, TrainStage, keys_of_stage_kind, stage_count_text

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

RADIUS_KEYS = ("roller_radius", "face_radius", "radius")
"""Keys of radii; their class of ISO 286 applies to the diameter."""
DEVIATIONS_PER_HALF_ZONE = {"uniform": sqrt(3.0), "triangular": sqrt(6.0)}
"""Half a zone in standard deviations, for distributions that end with the zone."""
DEVIATIONS_AT_CPK_1 = 3.0
"""Half a zone in standard deviations, for normal errors with a Cpk of 1."""
MOST_PROFILE_WAVES = 10_000
ANGLE_TOLERANCES = ("phase", "face_tilt", "disc_phase")
"""Keys of angular tolerances without a number in the scene."""
HALF_TURN = 180.0
"""Largest error of an angle [deg]; a larger one is a smaller error the other way."""
NUMBER_TABLES: dict[str, type[SceneTable]] = {
    "cam": Cam,
    "follower": Follower,
    "drive": Drive,
    "materials": Materials,
    "train": TrainStage,
}
"""The tables of a scene whose numbers may have tolerances."""


class Tolerance(SceneTable):
    """Tolerance of a number of the scene, and the distribution of its errors over parts."""

    plus: Annotated[NotNegative, Key("How much larger the number may be", "in the unit of the number")] = 0.0
    minus: Annotated[NotNegative, Key("How much smaller the number may be", "in the unit of the number")] = 0.0
    iso: Annotated[
        str | None,
        Key(
            "Class of ISO 286, such as h6, in place of `plus` and `minus`; for a radius it applies to the diameter"
        ),
    ] = None
    distribution: Annotated[
        Literal["normal", "uniform", "triangular"], Key("Distribution of the errors over the tolerance zone")
    ] = "normal"
    cpk: Annotated[
        Positive,
        Key("Process capability of a normal distribution: half the zone is 3·cpk standard deviations", "no unit"),
    ] = 1.0
    values: Annotated[
        Annotated[
            tuple[SceneNumber, ...],
            Field(min_length=1, max_length=MOST_SPANS),
            BeforeValidator(  # a text (file and column) is left for the check to report
                lambda value: tuple(value) if isinstance(value, list) else value,
                json_schema_input_type=str | list[float],
            ),
        ]
        | None,
        Key(
            "Measured errors of parts (measured minus nominal), or a column of a CSV file such as "
            '"rollers.csv:error". They replace the distribution; without `plus` and `minus` the least '
            "and the largest are the ends of the zone",
            "in the unit of the number",
        ),
    ] = None
    batch: Annotated[
        str | None,
        Key("Name of a batch, such as a lot of rollers: errors of tolerances with the same batch are correlated"),
    ] = None
    shared: Annotated[
        float,
        BoundedNumber(gt=0, le=1),
        Key(
            "Share s of the variance that the error has in common with its batch: two errors have the "
            "correlation √(s₁·s₂)",
            "no unit",
        ),
    ] = 1.0


def _as_tolerance(value: Any) -> Any:
    if isinstance(value, str):
        return {"iso": value}
    if isinstance(value, Real) and not isinstance(value, bool):
        if (number := finite_number_or_none(value)) is None or number < 0.0:
            raise ValueError("a number of at least 0")
        return {"plus": value, "minus": value}
    if isinstance(value, (Mapping, Tolerance)):
        return value
    raise ValueError("a number, a class of ISO 286 such as 'h6', or a table with plus and minus")


GivenTolerance = Annotated[
    Tolerance, BeforeValidator(_as_tolerance, json_schema_input_type=NotNegative | str | Tolerance)
]
OptionalTolerance = GivenTolerance | None
TOLERANCE_VALIDATOR = TypeAdapter[Any](OptionalTolerance, config=ConfigDict(defer_build=True))


def _read_tolerance(number_type: Any, value: Any, where: str) -> Tolerance | None:
    """The tolerance of a number of another table."""
    try:
        tolerance: Tolerance | None = TOLERANCE_VALIDATOR.validate_python(value)
    except ValidationError as error:
        raise BadInput(mistakes_from_pydantic(error, Tolerance, where)) from None
    return tolerance


TOLERANCE_READER = Reader(_read_tolerance, sizes=True)


class Tolerances(SceneTable):
    """Tolerances of the cam, the follower and the train. Without a tolerance, an error is 0.

    ``cam``, ``follower``, ``drive``, ``train`` and ``materials`` hold tolerances of numbers, by their keys in the
    scene: ``follower.roller_radius``, ``follower.dynamics.spring_rate`` or ``train.1.coupler``. Errors of the
    follower's sizes and of the train's links move the tool. Errors of all numbers change the limited quantities.
    """

    elsewhere: ClassVar[Mapping[str, str]] = {
        key: f"not a known key; did you mean tolerances.{'cam' if key in CAM_SIZES else 'follower'}.{key}?"
        for key in SEARCH_SIZES
    }

    cam: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Cam, reader=TOLERANCE_READER)),
        Key(
            "Tolerances of numbers of `[cam]`: of the speed, and of the base (mean) radius, which does "
            "not change the motion"
        ),
    ] = Field(default_factory=dict)
    follower: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Follower, reader=TOLERANCE_READER)),
        Key("Tolerances of sizes of the follower, and of numbers of `[follower.dynamics]`"),
    ] = Field(default_factory=dict)
    drive: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Drive, reader=TOLERANCE_READER)),
        Key("Tolerances of sizes and other numbers of `[drive]`"),
    ] = Field(default_factory=dict)
    materials: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Materials, reader=TOLERANCE_READER)),
        Key("Tolerances of numbers of `[materials]`"),
    ] = Field(default_factory=dict)
    train: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_row_choices, TrainStage, reader=TOLERANCE_READER)),
        Key("Tolerances of numbers of `[[train]]`, by number of the stage"),
    ] = Field(default_factory=dict)
    profile: Annotated[NotNegative | None, Key("Tolerance of the profile along its normal, ±", "mm")] = None
    waves: Annotated[
        Annotated[int, BeforeValidator(check_whole_number), Field(ge=1, le=MOST_PROFILE_WAVES)] | None,
        Key(
            "Largest number of waves per turn in the error of the profile, as the follower traces it "
            "(a roller at its centre, a flat face by its contact). Without it, the slope of the error is "
            "unknown"
        ),
    ] = None
    bore_eccentricity: Annotated[
        NotNegative | None,
        Key("Largest distance between the axes of bore and profile, in any direction", "mm"),
    ] = None
    phase: Annotated[OptionalTolerance, Key("Tolerance of the cam's angle on its shaft", "deg")] = None
    face_tilt: Annotated[
        OptionalTolerance,
        Key("Tolerance of the squareness of a translating flat face to its motion", "deg"),
    ] = None
    disc_phase: Annotated[
        OptionalTolerance, Key("Tolerance of the angle between the discs of a conjugate pair", "deg")
    ] = None

    @property
    def numbers(self) -> dict[str, Tolerance]:
        """The tolerances of numbers of the scene, by key, sorted."""
        return dict(sorted(self.number_tolerances()))

    def number_tolerances(self) -> Iterator[tuple[str, Tolerance]]:
        """The tolerances of numbers of the scene, by key, in the order of the scene."""
        tables = {name: getattr(self, name) for name in NUMBER_TABLES}
        yield from ((key, each) for key, each in leaf_values_by_key(tables) if isinstance(each, Tolerance))

    @property
    def number_and_angle_tolerances(self) -> dict[str, Tolerance]:
        """The tolerances of numbers and of angles, by key."""
        angles = {key: getattr(self, key) for key in ANGLE_TOLERANCES}
        return self.numbers | {key: each for key, each in angles.items() if each is not None}


class ToleranceZone(NamedTuple):
    """The range of the error of a number, and its distribution, in the unit of its key."""

    lower: float
    upper: float
    deviation: float
    """Standard deviation."""
    mean: float = 0.0
    below_lower: float = 0.0
    """How far errors may be below ``lower``; normal errors are cut at three standard deviations."""
    above_upper: float = 0.0
    """How far errors may be above ``upper``; normal errors are cut at three standard deviations."""

    @property
    def has_width(self) -> bool:
        """Whether the zone allows any error."""
        return bool(self.lower or self.upper)

    def scale_by(self, unit: float) -> "ToleranceZone":
        """The zone in another unit."""
        return ToleranceZone(*(unit * each for each in self))


def tolerance_zone(tolerance: Tolerance, key: str, size: float) -> ToleranceZone:
    """The zone of a number, by the last part of its key; ValueError if ISO 286 has no such class for the size."""
    if tolerance.iso is not None:
        share = 0.5 if key in RADIUS_KEYS else 1.0
        lower, upper = (share * each for each in limit_deviations(tolerance.iso, abs(size) / share))
    elif tolerance.values is not None and not tolerance.plus and not tolerance.minus:
        lower, upper = min(tolerance.values), max(tolerance.values)
    else:
        lower, upper = -tolerance.minus, tolerance.plus
    if tolerance.values is not None:
        under, over = max(lower - min(tolerance.values), 0.0), max(max(tolerance.values) - upper, 0.0)
        return ToleranceZone(
            lower, upper, float(np.std(tolerance.values)), float(np.mean(tolerance.values)), under, over
        )
    half = (upper - lower) / 2
    deviation = half / DEVIATIONS_PER_HALF_ZONE.get(tolerance.distribution, DEVIATIONS_AT_CPK_1 * tolerance.cpk)
    overrun = max(half / tolerance.cpk - half, 0.0)
    return ToleranceZone(lower, upper, deviation, (lower + upper) / 2, overrun, overrun)


def does_error_move_tool(key: str) -> bool:
    """Whether an error of a key of ``[tolerances]`` moves the tool, for a cam with a correct profile.

    Sizes of the follower and links of a train move the tool. An error of the base (mean) radius gives a cam with
    the same motion further out, which the mounting of the follower takes up. Speeds, springs, masses and materials
    do not move the tool: bodies are rigid here.
    """
    table, _, rest = key.partition(".")
    if table == "train":
        return rest.partition(".")[2] not in CARRIED_KEYS
    if key in SECOND_FIELDS:
        return rest not in CAM_SIZES
    return table not in NUMBER_TABLES or (table == "follower" and rest in FOLLOWER_SIZES)


# ----------------------------------------------------------------------------------------------------- files


def replace_measured_error_files(data: dict[str, Any], folder: Path | None) -> Iterator[Fault]:
    """Replace each file that a tolerance names by the measured errors in it, in ``data`` itself.

    Paths are relative to ``folder``; None if the scene may not name files.
    """
    table = table_named(data, "tolerances")
    for place, given in (*_number_tolerances_in(table), *((key, table.get(key)) for key in ANGLE_TOLERANCES)):
        named = given.get("values") if isinstance(given, dict) else None
        if not isinstance(named, str):
            continue
        file, _, column = named.rpartition(":")
        try:
            if not (file and column):
                raise ValueError("must be a list of numbers, or a file and its column, such as rollers.csv:error")
            given["values"] = read_csv_columns(folder, file, (column,))[column]
        except ValueError as trouble:
            yield f"tolerances.{place}.values", named, str(trouble)


def _number_tolerances_in(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The tolerances of numbers in the plain table, by key of the scene."""
    for name in NUMBER_TABLES:
        for key, value in table_named(table, name).items():
            nested = isinstance(value, Mapping) and (name == "train" or key == "dynamics")
            for last, each in value.items() if nested else [("", value)]:
                yield ".".join(filter(None, (name, str(key), str(last)))), each


# ----------------------------------------------------------------------------------------------------- checks


def check_tolerances(scene: "Scene", mechanism: Mechanism, tip: Tip, mechanism_name: str) -> Iterator[Fault]:
    """Check that the number of each tolerance exists, and that its extremes are allowed."""
    given, drawn = scene.tolerances, scene.part.profile_tolerance
    yield from _check_profile_tolerances(scene, mechanism)
    for key, each in given.number_tolerances():
        place = f"tolerances.{key}"
        if why := _missing_number_reason(scene, key, mechanism, tip, mechanism_name):
            yield place, None, why
        else:
            size = known_number_or_none(_nominal_number(scene, key))
            yield from (
                *_check_iso_class(place, each, key, size),
                *_check_number_at_both_tolerance_ends(place, each, key, size),
                *_check_distribution(place, each),
            )
    for key in ANGLE_TOLERANCES:
        if not isinstance(each := getattr(given, key), Tolerance):
            continue
        yield from _check_distribution(f"tolerances.{key}", each)
        if max(each.plus, each.minus) > HALF_TURN:
            why = f"must be at most {HALF_TURN:g} deg: a larger error is a smaller one the other way"
            yield f"tolerances.{key}", VALUE_IN_SCENE, why
        if each.iso is not None:
            yield f"tolerances.{key}", VALUE_IN_SCENE, "must be an angle in deg: ISO 286 is for lengths"
    if given.face_tilt is not None and (mechanism.motion.angular or not mechanism.flat_faced):
        yield "tolerances.face_tilt", None, "is for a translating follower with a flat face"
    if given.disc_phase is not None and not mechanism.second_contact_size_keys:
        yield "tolerances.disc_phase", None, "is for the two discs of a conjugate pair"
    if given.waves is not None and given.profile is None and drawn is None:
        yield "tolerances.waves", VALUE_IN_SCENE, "needs tolerances.profile, which is missing"
    if given.profile is not None and drawn is not None:
        yield "part.profile_tolerance", VALUE_IN_SCENE, "tolerances.profile is given too: leave this one out"


def _check_profile_tolerances(scene: "Scene", mechanism: Mechanism) -> Iterator[Fault]:
    """Check that the tolerances of profile and axis are smaller than the cam."""
    sizes = {
        key: known_number_or_none(each)
        for key, each in scene.numbers((f"cam.{mechanism.body.size_key}", "drive.base_radius")).items()
    }
    places = ("tolerances.profile", "part.profile_tolerance", "tolerances.bore_eccentricity")
    for place, off in scene.numbers(places).items():
        if key := next((key for key, size in sizes.items() if size and off is not None and off >= size), None):
            yield place, off, f"must be below {key} ({sizes[key]:g})"


def _missing_number_reason(scene: "Scene", key: str, mechanism: Mechanism, tip: Tip, mechanism_name: str) -> str:
    """Why the number of a tolerance does not exist; "" if it does."""
    table, _, rest = key.partition(".")
    last = rest.rpartition(".")[2]
    if key == "cam.shaft_diameter":
        return "cannot have a tolerance: give the largest diameter of the shaft, and the fit as part.bore_fit"
    if rest in SEARCH_SIZES and table in ("cam", "follower"):
        if key not in mechanism.keys(tip):
            return f"a {mechanism_name} has no {last.replace('_', ' ')}"
        if last in RADIUS_KEYS and mechanism.has_flanks_on_both_sides:
            return (
                "cannot have a tolerance: both walls of the groove hold the roller, so its radius does not move it"
            )
        return ""
    if key in SECOND_FIELDS:
        if not mechanism.further_contacts:
            return "belongs to a second contact, but this follower has one contact"
        return "" if key in mechanism.second_contact_size_keys else f"{mechanism.drive.words} has none"
    if table == "train" and (why := _missing_stage_number_reason(scene, rest)):
        return why
    value = scene.numbers((key,))[key]
    named = table == "materials" and getattr(scene.materials, last.partition("_")[0], None) is not None
    searched = table != "train" and scene.search.choices_by_key.get(key) is not None
    if value is None and not searched and not named:
        return f"the scene does not give {key}"
    return f"{key} changes over the turn and cannot have a tolerance" if isinstance(value, (tuple, list)) else ""


def _missing_stage_number_reason(scene: "Scene", stage_number_and_key: str) -> str:
    """Why a number of a train does not exist, "" if it does; the stage and its key are such as 2.crank."""
    number, _, last = stage_number_and_key.partition(".")
    if not (number.isdecimal() and 0 < int(number) <= len(scene.train)):
        return f"the train of the scene has {stage_count_text(scene)}"
    stage = scene.train[int(number) - 1].stage
    return "" if last in keys_of_stage_kind(str(stage)) else f"this stage, {stage}, has no {last}"


def _nominal_number(scene: "Scene", key: str) -> Any:
    """The value of a key; a size of a second contact, if not given, equals that of the first."""
    value, rest = scene.numbers((key,))[key], key.partition(".")[2]
    if key in SECOND_FIELDS and value is None:
        return getattr(scene.cam if rest in CAM_SIZES else scene.follower, rest)
    return value


def _number_type(key: str) -> Any:
    """The type of a number of a scene by its key, with its bounds."""
    table, *rest = key.split(".")
    hint: Any = NUMBER_TABLES[table]
    for name in rest[1:] if table == "train" else rest:
        hint = searchable_number_types(hint, sizes=True)[name]
    return hint


def _check_distribution(place: str, tolerance: Tolerance) -> Iterator[Fault]:
    """Check that a tolerance has one distribution, and a cpk only with a normal one."""
    if tolerance.distribution in DEVIATIONS_PER_HALF_ZONE and tolerance.cpk != 1.0:
        why = f"only a normal distribution has a cpk; this one is {tolerance.distribution}: leave one of them out"
        yield f"{place}.cpk", VALUE_IN_SCENE, why
    for key in ("distribution", "cpk") if tolerance.values is not None else ():
        if key in tolerance.model_fields_set:
            why = "the measured values are the distribution: leave one of them out"
            yield f"{place}.{key}", VALUE_IN_SCENE, why
    plus, minus, errors = tolerance.plus, tolerance.minus, tolerance.values or ()
    if errors and (plus or minus) and not any(-minus <= error <= plus for error in errors):
        why = f"all {len(errors)} are outside plus ({plus:g}) and minus ({minus:g}): check signs and units"
        yield f"{place}.values", f"{min(errors):g} to {max(errors):g}", why
    if "shared" in tolerance.model_fields_set and tolerance.batch is None:
        yield f"{place}.shared", VALUE_IN_SCENE, "needs the name of a batch, which is missing"


def _check_number_at_both_tolerance_ends(
    place: str, tolerance: Tolerance, key: str, nominal: float | None
) -> Iterator[Fault]:
    """Check that the scene allows the least and the largest value of the number."""
    plus, minus = tolerance.plus, tolerance.minus
    if tolerance.values and not (plus or minus):
        plus, minus = max(tolerance.values), -min(tolerance.values)
    last = key.rpartition(".")[2]
    if nominal is not None and last in SEARCH_SIZES and last not in SIGNED_SIZES:
        if minus >= nominal > 0.0:
            yield place, minus, f"must be below {key} ({nominal:g}): a size is above 0"
        return
    for side, off in ((1.0, plus), (-1.0, minus)):
        if nominal is None or not off:
            continue
        try:
            TypeAdapter(_number_type(key)).validate_python(nominal + side * off)
        except ValidationError as error:
            (allowed,) = (each.allowed for each in mistakes_from_pydantic(error, Tolerance, place))
            yield (
                place,
                off,
                f"would change {key} from {nominal:g} to {nominal + side * off:g}, which must be {allowed}",
            )


def _check_iso_class(place: str, tolerance: Tolerance, key: str, size: float | None) -> Iterator[Fault]:
    """Check that a class of ISO 286 is for a length, and exists for its size."""
    last, why = key.rpartition(".")[2], ""
    if tolerance.iso is None:
        return
    if (
        last not in SEARCH_SIZES
        and key not in SECOND_FIELDS
        and (last not in STAGE_NUMBER_KEYS or STAGE_NUMBER_KEYS[last].unit != "mm")
    ):
        why = f"a class of ISO 286 is for sizes of cam, follower and train, not for {key}: give a number (±)"
    elif tolerance.model_fields_set & {"plus", "minus"}:
        why = "give a class, or plus and minus, not both"
    elif size is None:
        why = f"needs {key}: the zone of an ISO 286 class depends on the size"
    else:
        try:
            tolerance_zone(Tolerance(iso=tolerance.iso), last, size)
        except ValueError as trouble:
            why = str(trouble)
    if why:
        yield place, tolerance.iso, why
