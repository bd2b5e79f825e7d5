"""The table ``[tolerances]`` of a scene: by how much numbers of a real cam, its follower and train may be off.

A tolerance is a number, ± in the unit of its key; a table with ``plus`` and ``minus``; or a class of ISO 286, such
as ``"h6"``, of a length, or of the diameter that a radius belongs to.
"""

from collections.abc import Iterator, Mapping
from functools import cache, partial
from math import sqrt
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError

from camopt.core.mistakes import BadInput
from camopt.core.quantities import STAGE_NUMBER_KEYS
from camopt.core.quantities.key import Key
from camopt.model.mechanisms import SECOND_FIELDS, Mechanism
from camopt.model.mechanisms.elements import Tip
from camopt.scene.choices import Reader, read_number_choices, read_row_choices, searchable_numbers
from camopt.scene.csv_columns import MOST_SPANS, read_csv_columns
from camopt.scene.iso286 import limit_deviations
from camopt.scene.law_forms import VALUE_IN_SCENE, Fault
from camopt.scene.mapping import finite_number, leaves
from camopt.scene.pydantic_mistakes import mistakes_from_pydantic
from camopt.scene.sizes import CAM_SIZES, FOLLOWER_SIZES, SEARCH_SIZES, SIGNED_SIZES, known_number
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
from camopt.scene.train import CARRIED_KEYS, TrainStage, keys_of_stage, stage_count_text

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

RADIUS_KEYS = ("roller_radius", "face_radius", "radius")
"""Keys whose class of ISO 286 is that of a diameter."""
DEVIATIONS_PER_HALF_ZONE = {"uniform": sqrt(3.0), "triangular": sqrt(6.0)}
"""How many standard deviations half of a zone is, of what ends with it."""
DEVIATIONS_AT_CPK_1 = 3.0
"""The same of normal errors, at a Cpk of 1."""
MOST_PROFILE_WAVES = 10_000
ANGLE_TOLERANCES = ("phase", "face_tilt", "disc_phase")
"""Keys of tolerances that are angles of their own."""
HALF_TURN = 180.0
"""A cam that is further off on its shaft is less off the other way, deg."""
NUMBER_TABLES: dict[str, type[SceneTable]] = {
    "cam": Cam,
    "follower": Follower,
    "drive": Drive,
    "materials": Materials,
    "train": TrainStage,
}
"""The tables of a scene whose numbers may have tolerances."""


def _as_measured_errors(value: Any) -> Any:
    """Errors of parts, of which a single one is a list too; a file and its column stay a text, which is told."""
    return tuple(value) if isinstance(value, list) else value


class Tolerance(SceneTable):
    """How far a number may be from what the scene says, and how it is spread over parts."""

    plus: Annotated[NotNegative, Key("How much larger the number may be", "in the unit of the number")] = 0.0
    minus: Annotated[NotNegative, Key("How much smaller the number may be", "in the unit of the number")] = 0.0
    iso: Annotated[
        str | None,
        Key(
            "Class of ISO 286 in place of ``plus`` and ``minus``, such as h6, of the diameter if the "
            "size is a radius"
        ),
    ] = None
    distribution: Annotated[
        Literal["normal", "uniform", "triangular"], Key("How parts are spread over the zone")
    ] = "normal"
    cpk: Annotated[
        Positive,
        Key(
            "Process capability of a normal distribution: half of the zone is 3·cpk standard deviations", "no unit"
        ),
    ] = 1.0
    values: Annotated[
        Annotated[
            tuple[SceneNumber, ...],
            Field(min_length=1, max_length=MOST_SPANS),
            BeforeValidator(_as_measured_errors, json_schema_input_type=str | list[float]),
        ]
        | None,
        Key(
            "Measured errors of parts (what was measured less the nominal number), or a column of a "
            'CSV file, as "rollers.csv:error": parts are spread as these are, and unless ``plus`` '
            "and ``minus`` are given their ends are those of the zone",
            "in the unit of the number",
        ),
    ] = None
    batch: Annotated[
        str | None,
        Key("A name that tolerances have in common whose errors go together in a cam, as of rollers of one lot"),
    ] = None
    shared: Annotated[
        float,
        BoundedNumber(gt=0, le=1),
        Key(
            "Share of the variance that errors of a batch have in common: two have the correlation √(s₁·s₂)",
            "no unit",
        ),
    ] = 1.0

    @property
    def has_measured_values(self) -> bool:
        """Whether parts are spread as some that were measured."""
        return self.values is not None


def _as_tolerance(value: Any) -> Any:
    if isinstance(value, str):
        return {"iso": value}
    if isinstance(value, Real) and not isinstance(value, bool):
        if (number := finite_number(value)) is None or number < 0.0:
            raise ValueError("a number of at least 0")
        return {"plus": value, "minus": value}
    if isinstance(value, (Mapping, Tolerance)):
        return value
    raise ValueError("a number, a class of ISO 286 such as 'h6', or a table with plus and minus")


GivenTolerance = Annotated[
    Tolerance, BeforeValidator(_as_tolerance, json_schema_input_type=NotNegative | str | Tolerance)
]
OptionalTolerance = GivenTolerance | None


@cache
def _tolerance_adapter() -> TypeAdapter[Any]:
    """The validator of a tolerance, made when needed."""
    return TypeAdapter(OptionalTolerance)


def _read_tolerance(number: Any, value: Any, where: str) -> Tolerance | None:
    """The tolerance of a number of another table."""
    try:
        found: Tolerance | None = _tolerance_adapter().validate_python(value)
    except ValidationError as error:
        raise BadInput(mistakes_from_pydantic(error, Tolerance, where)) from None
    return found


TOLERANCE_READER = Reader(_read_tolerance, sizes=True)


class Tolerances(SceneTable):
    """How far a real cam and its follower may be from what the scene says; errors that no key names are 0.

    ``cam``, ``follower``, ``drive``, ``train`` and ``materials`` hold tolerances of numbers by the keys that these
    have in the scene, as ``follower.roller_radius``, ``follower.dynamics.spring_rate`` or ``train.1.coupler``. The
    sizes of the follower and the links of a train move the tool; all of them move what limits are about.
    """

    elsewhere: ClassVar[Mapping[str, str]] = {
        key: f"not a known key; did you mean tolerances.{'cam' if key in CAM_SIZES else 'follower'}.{key}?"
        for key in SEARCH_SIZES
    }

    cam: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Cam, reader=TOLERANCE_READER)),
        Key(
            "Tolerances of numbers of ``[cam]``: of the speed, and of the base (mean) radius of a "
            "cam that has the same motion"
        ),
    ] = Field(default_factory=dict)
    follower: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Follower, reader=TOLERANCE_READER)),
        Key("Tolerances of sizes of the follower, and of numbers of ``[follower.dynamics]``"),
    ] = Field(default_factory=dict)
    drive: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Drive, reader=TOLERANCE_READER)),
        Key("Tolerances of sizes and other numbers of ``[drive]``"),
    ] = Field(default_factory=dict)
    materials: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Materials, reader=TOLERANCE_READER)),
        Key("Tolerances of numbers of ``[materials]``"),
    ] = Field(default_factory=dict)
    train: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_row_choices, TrainStage, reader=TOLERANCE_READER)),
        Key("Tolerances of numbers of ``[[train]]``, by the number of the stage"),
    ] = Field(default_factory=dict)
    profile: Annotated[NotNegative | None, Key("Tolerance of the profile along its normal, ±", "mm")] = None
    waves: Annotated[
        Annotated[int, BeforeValidator(check_whole_number), Field(ge=1, le=MOST_PROFILE_WAVES)] | None,
        Key(
            "How many waves the error of the profile has in a turn at most, as the follower feels it "
            "(a roller at its centre, a flat face as it lies on the profile): without it, no slope "
            "of it is known"
        ),
    ] = None
    bore_eccentricity: Annotated[
        NotNegative | None, Key("How far the bore's axis may be from that of the profile, in any direction", "mm")
    ] = None
    phase: Annotated[OptionalTolerance, Key("Tolerance of the cam's angle on its shaft", "deg")] = None
    face_tilt: Annotated[
        OptionalTolerance,
        Key("Tolerance of the angle of a translating flat face, by which it is not square to its motion", "deg"),
    ] = None
    disc_phase: Annotated[
        OptionalTolerance, Key("Tolerance of the angle between both discs of a conjugate pair", "deg")
    ] = None

    @property
    def numbers(self) -> dict[str, Tolerance]:
        """The tolerances of numbers of the scene, by key of these."""
        return dict(sorted(self.numbers_in_order()))

    def numbers_in_order(self) -> Iterator[tuple[str, Tolerance]]:
        """The same in the order in which the scene gives them."""
        tables = {name: getattr(self, name) for name in NUMBER_TABLES}
        yield from ((key, each) for key, each in leaves(tables) if isinstance(each, Tolerance))

    @property
    def number_and_angle_tolerances(self) -> dict[str, Tolerance]:
        """Those, and of angles, by key: all that are a number each."""
        angles = {key: getattr(self, key) for key in ANGLE_TOLERANCES}
        return self.numbers | {key: each for key, each in angles.items() if each is not None}


class ToleranceZone(NamedTuple):
    """How far a number may be from its nominal value, and how it is spread, in the unit of its key."""

    lower: float
    upper: float
    deviation: float
    """Standard deviation."""
    mean: float = 0.0
    below_lower: float = 0.0
    """How far parts may be below ``lower``: of normal ones, which have no end, three standard deviations out."""
    above_upper: float = 0.0
    """The same above ``upper``."""

    @property
    def has_width(self) -> bool:
        """Whether a number within it may be another one than the nominal."""
        return bool(self.lower or self.upper)

    def scale_by(self, unit: float) -> "ToleranceZone":
        """The zone in another unit."""
        return ToleranceZone(*(unit * each for each in self))


def tolerance_zone(given: Tolerance, key: str, size: float) -> ToleranceZone:
    """The zone of a number, by the last part of its key; ValueError for a class of ISO 286 that it has not."""
    if given.iso is not None:
        share = 0.5 if key in RADIUS_KEYS else 1.0
        lower, upper = (share * each for each in limit_deviations(given.iso, abs(size) / share))
    elif given.values is not None and not given.plus and not given.minus:
        lower, upper = min(given.values), max(given.values)
    else:
        lower, upper = -given.minus, given.plus
    if given.values is not None:
        under, over = max(lower - min(given.values), 0.0), max(max(given.values) - upper, 0.0)
        return ToleranceZone(lower, upper, float(np.std(given.values)), float(np.mean(given.values)), under, over)
    half = (upper - lower) / 2
    deviation = half / DEVIATIONS_PER_HALF_ZONE.get(given.distribution, DEVIATIONS_AT_CPK_1 * given.cpk)
    beyond = max(half / given.cpk - half, 0.0)
    return ToleranceZone(lower, upper, deviation, (lower + upper) / 2, beyond, beyond)


def moves_tool(key: str) -> bool:
    """Whether what is off by a key of ``[tolerances]`` moves the tool of a cam which is cut as it should be.

    Of numbers, a size of the follower does, and a link of a train. Another base (mean) radius makes another cam
    with the same motion, further out: that is taken up where the follower is mounted. Speeds, springs, masses and
    materials move no tool; loads bend nothing here.
    """
    table, _, rest = key.partition(".")
    if table == "train":
        return rest.partition(".")[2] not in CARRIED_KEYS
    if key in SECOND_FIELDS:
        return rest not in CAM_SIZES
    return table not in NUMBER_TABLES or (table == "follower" and rest in FOLLOWER_SIZES)


# ----------------------------------------------------------------------------------------------------- files


def read_measured_errors(data: dict[str, Any], folder: Path | None) -> Iterator[Fault]:
    """Put measured errors in place of each file that a tolerance names, in ``data`` itself.

    ``folder`` is where files are looked for; None if none may be named.
    """
    for place, given in (
        *_number_tolerances_in(data.get("tolerances")),
        *_angle_tolerances_in(data.get("tolerances")),
    ):
        named = given.get("values") if isinstance(given, dict) else None
        if not isinstance(named, str):
            continue
        file, _, column = named.rpartition(":")
        try:
            if not (file and column):
                raise ValueError("must be a list of numbers, or a file and its column, as rollers.csv:error")
            given["values"] = read_csv_columns(folder, file, (column,))[column]
        except ValueError as trouble:
            yield f"tolerances.{place}.values", named, str(trouble)


def _number_tolerances_in(table: Any) -> Iterator[tuple[str, Any]]:
    """What the plain table has for numbers of the scene, by key of these."""
    for name in NUMBER_TABLES if isinstance(table, Mapping) else ():
        given = table.get(name)
        for key, value in given.items() if isinstance(given, Mapping) else ():
            nested = isinstance(value, Mapping) and (name == "train" or key == "dynamics")
            for last, each in value.items() if nested else [("", value)]:
                yield ".".join(filter(None, (name, str(key), str(last)))), each


def _angle_tolerances_in(table: Any) -> Iterator[tuple[str, Any]]:
    for key in ANGLE_TOLERANCES if isinstance(table, Mapping) else ():
        yield key, table.get(key)


# ----------------------------------------------------------------------------------------------------- checks


def check_tolerances(scene: "Scene", mechanism: Mechanism, tip: Tip, name: str) -> Iterator[Fault]:
    """Check that there is what a tolerance is of, and that it has a zone which leaves a number."""
    given, drawn = scene.tolerances, scene.part.profile_tolerance
    yield from _check_profile_tolerances(scene, mechanism)
    for key, each in given.numbers_in_order():
        place = f"tolerances.{key}"
        if why := _missing_number_reason(scene, key, mechanism, tip, name):
            yield place, None, why
        else:
            size = known_number(_nominal_number(scene, key))
            yield from (
                *_check_iso_class(place, each, key, size),
                *_check_extreme_numbers(place, each, key, size),
                *_check_distribution(place, each),
            )
    for key in ANGLE_TOLERANCES:
        if not isinstance(each := getattr(given, key), Tolerance):
            continue
        yield from _check_distribution(f"tolerances.{key}", each)
        if max(each.plus, each.minus) > HALF_TURN:
            why = f"must be at most {HALF_TURN:g} deg: what is turned further is turned less the other way"
            yield f"tolerances.{key}", VALUE_IN_SCENE, why
        if each.iso is not None:
            yield f"tolerances.{key}", VALUE_IN_SCENE, "must be an angle in deg: ISO 286 is for lengths"
    if given.face_tilt is not None and (mechanism.motion.angular or not mechanism.flat_faced):
        yield "tolerances.face_tilt", None, "is for a translating follower with a flat face"
    if given.disc_phase is not None and not mechanism.second_keys:
        yield "tolerances.disc_phase", None, "is for the two discs of a conjugate pair"
    if given.waves is not None and given.profile is None and drawn is None:
        yield "tolerances.waves", VALUE_IN_SCENE, "goes with tolerances.profile, which is missing"
    if given.profile is not None and drawn is not None:
        yield "part.profile_tolerance", VALUE_IN_SCENE, "is tolerances.profile already: leave it out"


def _check_profile_tolerances(scene: "Scene", mechanism: Mechanism) -> Iterator[Fault]:
    """Check that what is off of profiles, and of their axis, is less than their cams are."""
    sizes = {
        key: known_number(each)
        for key, each in scene.numbers((f"cam.{mechanism.body.size}", "drive.base_radius")).items()
    }
    places = ("tolerances.profile", "part.profile_tolerance", "tolerances.bore_eccentricity")
    for place, off in scene.numbers(places).items():
        if key := next((key for key, size in sizes.items() if size and off is not None and off >= size), None):
            yield place, off, f"must be below {key} ({sizes[key]:g})"


def _missing_number_reason(scene: "Scene", key: str, mechanism: Mechanism, tip: Tip, name: str) -> str:
    """Why there is nothing that a tolerance is of; "" if there is."""
    table, _, rest = key.partition(".")
    last = rest.rpartition(".")[2]
    if key == "cam.shaft_diameter":
        return "has none: give the shaft its largest diameter, and its fit to the drawing (part.bore_fit)"
    if rest in SEARCH_SIZES and table in ("cam", "follower"):
        if key not in mechanism.keys(tip):
            return f"a {name} has no {last.replace('_', ' ')}"
        if last in RADIUS_KEYS and mechanism.two_sided:
            return "is held by the groove from both sides: how thick it is does not move it"
        return ""
    if key in SECOND_FIELDS:
        if not mechanism.further_contacts:
            return "is of a second contact, and this follower has one alone"
        return "" if key in mechanism.second_keys else f"{mechanism.drive.words} has none"
    if table == "train" and (why := _missing_stage_reason(scene, rest)):
        return why
    value = scene.numbers((key,))[key]
    named = table == "materials" and getattr(scene.materials, last.partition("_")[0], None) is not None
    searched = table != "train" and scene.search.choices_by_key.get(key) is not None
    if value is None and not searched and not named:
        return f"is of {key}, which the scene does not give"
    return f"is of {key}, which changes over the turn" if isinstance(value, (tuple, list)) else ""


def _missing_stage_reason(scene: "Scene", rest: str) -> str:
    """The same of a number of a train, by the number of the stage and its key."""
    number, _, last = rest.partition(".")
    if not (number.isdecimal() and 0 < int(number) <= len(scene.train)):
        return f"the train of the scene has {stage_count_text(scene)}"
    stage = scene.train[int(number) - 1].stage
    return "" if last in keys_of_stage(str(stage)) else f"this stage, {stage}, has no {last}"


def _nominal_number(scene: "Scene", key: str) -> Any:
    """What the scene gives by a key; a size of a second contact is that of the first where it is not given."""
    value, rest = scene.numbers((key,))[key], key.partition(".")[2]
    if key in SECOND_FIELDS and value is None:
        return getattr(scene.cam if rest in CAM_SIZES else scene.follower, rest)
    return value


def _number_type(key: str) -> Any:
    """The type of a number of a scene by its key, with its bounds."""
    table, *rest = key.split(".")
    found: Any = NUMBER_TABLES[table]
    for name in rest[1:] if table == "train" else rest:
        found = searchable_numbers(found, sizes=True)[name]
    return found


def _check_distribution(place: str, given: Tolerance) -> Iterator[Fault]:
    """Check that there is one distribution, and that its capability is that of a normal one."""
    if given.distribution in DEVIATIONS_PER_HALF_ZONE and given.cpk != 1.0:
        why = f"a cpk is of a normal distribution, and this one is {given.distribution}: leave out one of both"
        yield f"{place}.cpk", VALUE_IN_SCENE, why
    for key in ("distribution", "cpk") if given.values is not None else ():
        if key in given.model_fields_set:
            why = "has measured values, which are a distribution: leave out one of both"
            yield f"{place}.{key}", VALUE_IN_SCENE, why
    plus, minus, found = given.plus, given.minus, given.values or ()
    if found and (plus or minus) and not any(-minus <= error <= plus for error in found):
        why = f"all {len(found)} are outside of plus ({plus:g}) and minus ({minus:g}): look at signs and units"
        yield f"{place}.values", f"{min(found):g} to {max(found):g}", why
    if "shared" in given.model_fields_set and given.batch is None:
        yield f"{place}.shared", VALUE_IN_SCENE, "goes with the name of a batch, which is missing"


def _check_extreme_numbers(place: str, given: Tolerance, key: str, size: float | None) -> Iterator[Fault]:
    """Check that the least and the largest number are ones that the scene may have."""
    plus, minus = given.plus, given.minus
    if given.values and not (plus or minus):
        plus, minus = max(given.values), -min(given.values)
    last = key.rpartition(".")[2]
    if size is not None and last in SEARCH_SIZES and last not in SIGNED_SIZES:
        if minus >= size > 0.0:
            yield place, minus, f"must be below {key} ({size:g}): no size is 0 or less"
        return
    for side, off in ((1.0, plus), (-1.0, minus)):
        if size is None or not off:
            continue
        try:
            TypeAdapter(_number_type(key)).validate_python(size + side * off)
        except ValidationError as error:
            (allowed,) = (each.allowed for each in mistakes_from_pydantic(error, Tolerance, place))
            yield place, off, f"takes {key} ({size:g}) to {size + side * off:g}, which must be {allowed}"


def _check_iso_class(place: str, given: Tolerance, key: str, size: float | None) -> Iterator[Fault]:
    """Check a class of ISO 286: of a length, which has a zone in it."""
    last, why = key.rpartition(".")[2], ""
    if given.iso is None:
        return
    if (
        last not in SEARCH_SIZES
        and key not in SECOND_FIELDS
        and (last not in STAGE_NUMBER_KEYS or STAGE_NUMBER_KEYS[last].unit != "mm")
    ):
        why = f"{key} has no class of ISO 286, which sizes of cam, follower and train have: give ± a number"
    elif given.model_fields_set & {"plus", "minus"}:
        why = "has a class and plus or minus: give one of both"
    elif size is None:
        why = f"needs {key}: a class of ISO 286 is of a size"
    else:
        try:
            tolerance_zone(Tolerance(iso=given.iso), last, size)
        except ValueError as trouble:
            why = str(trouble)
    if why:
        yield place, given.iso, why
