"""The tables of a scene: their keys, with allowed values, units and sentences."""

from collections.abc import Callable, Iterable, Mapping
from itertools import chain
from numbers import Integral, Real
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypeVar, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    create_model,
)
from pydantic_core import core_schema

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.quantities import DISCIPLINES, EVERYTHING, QUANTITIES
from camopt.core.quantities.key import ANYWHERE, LENGTH, LENGTHS, NOT_NEGATIVE, POSITIVE, Key, NumberKey
from camopt.core.quantities.scene_numbers import NUMBER_KEYS, number_keys_of_table
from camopt.model.mechanisms.elements import CamForm, DriveName, MotionName, TipName
from camopt.model.motion import LAWS
from camopt.model.motion.aliases import ALIASES, SEGMENT_ALIASES, canonical_segment_kind
from camopt.scene.law_forms import SPLINE_DEGREES
from camopt.scene.materials import MATERIALS
from camopt.scene.pydantic_mistakes import mistakes_from_pydantic


def check_number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError("a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("a finite number") from None


def _check_number_and_keep_int(value: Any) -> float:
    """The number; an int stays an int until its bounds are checked, so that mistakes show what the user wrote."""
    number = check_number(value)
    return value if type(value) is int else number


class BoundedNumber:
    """A finite number within bounds, or None where the type allows it.

    One core schema holds all bounds: pydantic is faster with it than with a chain of validators.
    """

    def __init__(self, **bounds: float) -> None:
        self.bounds: Any = bounds

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        finite = core_schema.float_schema(allow_inf_nan=False, **self.bounds)
        number = core_schema.no_info_before_validator_function(_check_number_and_keep_int, finite)
        return number if source is float else core_schema.nullable_schema(number)


LARGEST_VALUE, SLOWEST_RPM = ANYWHERE["le"], 1e-9
SceneNumber = Annotated[float, BoundedNumber()]
Length = Annotated[float, BoundedNumber(**LENGTH)]
SignedNumber = Annotated[float, BoundedNumber(**ANYWHERE)]
Positive = Annotated[float, BoundedNumber(**POSITIVE)]
NotNegative = Annotated[float, BoundedNumber(**NOT_NEGATIVE)]


class Name:
    """A text with a check of its own; ``names`` appear in the JSON schema only."""

    def __init__(self, check: Callable[[Any], str], names: Iterable[str], others: bool = False) -> None:
        self.check, self.names, self.others = check, names, others

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        return core_schema.no_info_before_validator_function(self.check, core_schema.str_schema())

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        known = {"enum": [*self.names], "type": "string"}
        return {"anyOf": [known, {"type": "string"}]} if self.others else known


def known_name_validator(names: Any, message_start: str, others: bool = False) -> Name:
    """A name out of ``names``; ``message_start`` begins the message for any other.

    With ``others``, any text passes here: the scene may define the name.
    """

    def check_name(value: Any) -> str:
        if not isinstance(value, str) or not (others or value in names):
            raise ValueError(f"{message_start}; {suggest_names(str(value), names)}")
        return value

    return Name(check_name, names, others)


class ListOrItem:
    """A list; a single item may stand for a list of one."""

    def __init__(self, listed: Callable[[Any], Any]) -> None:
        self.listed = listed

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        return core_schema.no_info_before_validator_function(self.listed, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        item = handler(schema)["items"]
        return {"anyOf": [item, {"items": item, "type": "array"}]}


def check_one_line(value: Any) -> Any:
    if isinstance(value, str) and not value.isprintable():
        raise ValueError("a text of one line, with printable characters only")
    return value


def check_whole_number(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise ValueError("a whole number")
    return int(value)


def type_validator(kinds: type | tuple[type, ...], allowed: str) -> Callable[[Any], Any]:
    """A check of the type of a value; ``allowed`` is the message for any other."""

    def check_type(value: Any) -> Any:
        if not isinstance(value, kinds):
            raise ValueError(allowed)
        return value

    return check_type


def _add_segment_aliases(schema: dict[str, Any]) -> None:
    """Add the other names of segments to the JSON schema."""
    own = {name: schema.pop(name) for name in ("enum", "type")}
    schema["anyOf"] = [own, {**own, "enum": [*chain(*SEGMENT_ALIASES.values())]}]


def allow_text_in_schema(schema: dict[str, Any]) -> None:
    """Allow a text for a key in the JSON schema; the text is read before keys are checked."""
    own = {name: schema.pop(name) for name in tuple(schema) if name not in ("default", "title", "description")}
    schema["anyOf"] = [{"type": "string"}, *own.pop("anyOf", [own])]


Switch = Annotated[bool, BeforeValidator(type_validator(bool, "true or false"))]
LAW_NAMES = (*LAWS, *chain(*ALIASES.values()))
LawName = Annotated[str, Name(type_validator(str, "the name of a motion law"), LAW_NAMES, others=True)]
MaterialName = Annotated[str, known_name_validator(MATERIALS, "a material")]
QUANTITY_SYNONYMS = {"size": "base_radius_mm"}
"""The quantity that is suggested for a common word."""
QuantityName = Annotated[str, known_name_validator(QUANTITIES, "a quantity", others=True)]


class SceneTable(BaseModel):
    """A table of a scene; it refuses unknown keys and never changes."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)
    elsewhere: ClassVar[Mapping[str, str]] = {}
    """Keys that users expect here but that belong elsewhere, each with its message."""
    read_as: ClassVar[Mapping[str, str]] = {}
    """Keys that are converted to another key, by key; no search varies them."""

    def __init__(self, /, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise BadInput(mistakes_from_pydantic(error, type(self), type(self).__name__.lower())) from None

    if not TYPE_CHECKING:  # else type checkers would accept any attribute

        def __setattr__(self, name: str, value: Any) -> None:
            """Refuse a change; the message names ``replace``."""
            if name in type(self).model_fields:
                why = "cannot be changed; make a changed copy, as in scene.replace(name='x')"
                raise BadInput([Mistake(type(self).__name__.lower(), name, value, why, bare=True)])
            super().__setattr__(name, value)

    @classmethod
    def from_value(cls, value: Any) -> Self:
        """The table from a mapping."""
        if isinstance(value, cls):
            return value
        if not isinstance(value, dict):
            raise ValueError("a table")
        return cls(**value)

    @classmethod
    def from_known_keys(cls, value: Any) -> Self | None:
        """The table from the known keys of a mapping; None if a value is wrong or missing."""
        try:
            return cls.from_value({key: value[key] for key in cls.model_fields if key in value})
        except (TypeError, ValueError):  # BadInput is one
            return None


def _table_to_mapping(table: "SceneTable", info: core_schema.SerializationInfo) -> dict[str, Any]:
    """The table as a mapping: pydantic up to 2.13 cannot write a table that it did not check itself."""
    return table.model_dump(mode=info.mode, exclude_none=info.exclude_none, exclude_defaults=info.exclude_defaults)


class _SelfCheckedTable:
    """A table inside another one validates itself, so pydantic builds only the tables that a scene has."""

    def __get_pydantic_core_schema__(self, source: type[SceneTable], handler: Any) -> Any:
        written = core_schema.plain_serializer_function_ser_schema(_table_to_mapping, info_arg=True)
        return core_schema.no_info_plain_validator_function(source.from_value, serialization=written)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        table: type[SceneTable] = schema["function"]["function"].__self__
        table.model_rebuild()
        return handler(core_schema.chain_schema([table.__pydantic_core_schema__]))  # makes a $ref in the schema


AnyTable = TypeVar("AnyTable", bound=SceneTable)
InnerTable = Annotated[AnyTable, _SelfCheckedTable()]
"""A table inside another one."""


class TableOfRecords(SceneTable):
    """A table with keys that come from records (``with_optional_keys``)."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...


def with_optional_keys(keys: Mapping[str, tuple[Any, Key]]) -> Callable[[type[AnyTable]], type[AnyTable]]:
    """A class decorator that adds optional keys to a table, each with the type of its value and its record."""
    fields: Any = {name: (Annotated[kind | None, key], None) for name, (kind, key) in keys.items()}
    return lambda table: create_model(
        table.__name__, __base__=table, __doc__=table.__doc__, __module__=table.__module__, **fields
    )


def number_keys_with_types(numbers: Iterable[NumberKey], **types_by_key: Any) -> dict[str, tuple[Any, Key]]:
    """The keys of numbers with their types: the type in ``types_by_key``, or else a number within its bounds."""
    return {
        each.name: (types_by_key.get(each.name, Annotated[float, BoundedNumber(**each.allowed)]), each)
        for each in numbers
    }


def table_type_in(hint: Any) -> type[SceneTable] | None:
    """The first table class in a type hint; None without one."""
    if isinstance(hint, type) and issubclass(hint, SceneTable):
        return hint
    return next((found for each in get_args(hint) if (found := table_type_in(each))), None)


def _check_rpm(value: Any) -> Any:
    if isinstance(value, Real) and not isinstance(value, bool) and value < SLOWEST_RPM:
        raise ValueError(f"at least {SLOWEST_RPM:g}; set the sense of rotation with cam.rotation, 'ccw' or 'cw'")
    return value


Speed = Annotated[
    SceneNumber,
    Field(le=1e15),
    BeforeValidator(_check_rpm, json_schema_input_type=Annotated[float, Field(ge=SLOWEST_RPM, le=1e15)]),
]


class Cam(SceneTable):
    """The cam: form, sense of rotation, speed and size."""

    read_as: ClassVar[Mapping[str, str]] = {"rpm_of_crank": "rpm"}
    form: Annotated[
        CamForm,
        Key(
            "Form of the cam: a disc, which turns about an axis square to the motion, or a cylinder "
            "(barrel) with a groove round it"
        ),
    ]
    rotation: Annotated[
        Literal["ccw", "cw"],
        Key("Sense of rotation in pictures: ccw (anticlockwise) or cw (clockwise)", example="ccw"),
    ] = "ccw"
    rpm: Annotated[Speed | None, NUMBER_KEYS["cam.rpm"]] = None
    rpm_of_crank: Annotated[
        Speed | None,
        Key(
            "Speed of the crankshaft of a four-stroke engine, twice that of the cam; use it in place of `rpm`",
            "rev/min",
        ),
    ] = None
    base_radius: Annotated[Length | None, Key("Least radius of the profile of a disc cam", "mm", usual=LENGTHS)] = (
        None
    )
    mean_radius: Annotated[
        Length | None,
        Key(
            "Mean radius of a cylindrical cam, at which its surface is developed into a plane", "mm", usual=LENGTHS
        ),
    ] = None
    shaft_diameter: Annotated[Length | None, NUMBER_KEYS["cam.shaft_diameter"]] = None


LoadRows = Annotated[
    tuple[Any, ...],
    BeforeValidator(  # the rows are checked with the scene
        lambda rows: tuple(tuple(row) if isinstance(row, list) else row for row in rows),
        json_schema_input_type=list[tuple[float, float]],
    ),
]
GivenLoad = Annotated[
    Annotated[SignedNumber, Tag("constant/")] | Annotated[str, Tag("file/")] | Annotated[LoadRows, Tag("rows/")],
    Discriminator(
        lambda value: (
            "file/" if isinstance(value, str) else "rows/" if isinstance(value, (list, tuple)) else "constant/"
        )
    ),
]


@with_optional_keys(number_keys_with_types(number_keys_of_table("follower.dynamics"), load=GivenLoad))
class Dynamics(TableOfRecords):
    """Moving mass of the follower, and the forces on it. An oscillating follower has inertias and moments.

    A load that changes over the turn is a list of rows [cam angle, load], or the name of a CSV file with columns
    ``angle`` and ``load``. Cam angles run from 0 to 360 deg, from the start of the first segment. The load is
    linear between rows, and from the last row to the first row of the next turn. Two rows at the same cam angle (0
    and 360 are the same) make a jump. The path of the file is relative to the scene file; it is read when the scene
    is made.
    """


class Follower(SceneTable):
    """The follower: its motion, its tip that touches the cam, and its sizes."""

    elsewhere: ClassVar[Mapping[str, str]] = {
        "roller_diameter": "not a known key; give follower.roller_radius, half of it",
        "face_diameter": "not a known key; give follower.face_radius, half of it",
    }

    motion: Annotated[MotionName, Key("Motion of the follower: along a straight line, or about a pivot")]
    contact: Annotated[
        TipName,
        Key("Tip that touches the cam: a knife edge, a roller, a flat face or a spherical (mushroom) face"),
    ]
    roller_radius: Annotated[Length | None, Key("Radius of the roller", "mm", example=10, usual=LENGTHS)] = None
    face_radius: Annotated[Length | None, Key("Radius of a spherical face", "mm", example=10, usual=(0.1, 1e6))] = (
        None
    )
    face_offset: Annotated[
        SignedNumber | None, Key("Distance of an oscillating flat face from its pivot", "mm", example=10)
    ] = None
    arm_length: Annotated[
        Length | None, Key("Length of the arm, from the pivot to the trace point", "mm", example=80, usual=LENGTHS)
    ] = None
    centre_distance: Annotated[
        Length | None, Key("Distance from the pivot to the cam's axis", "mm", example=100, usual=LENGTHS)
    ] = None
    roller_spacing: Annotated[
        Length | None,
        Key("Centre distance of the two rollers on either side of a rib", "mm", example=50, usual=LENGTHS),
    ] = None
    offset: Annotated[SignedNumber, Key("Offset of a translating follower's axis, positive to the right", "mm")] = (
        0.0
    )
    dynamics: Annotated[InnerTable[Dynamics] | None, Key("Moving mass of the follower, and the forces on it")] = (
        None
    )


@with_optional_keys(number_keys_with_types(number_keys_of_table("drive")))
class Drive(TableOfRecords):
    """What keeps the follower on the cam.

    On an open cam a spring or another force presses the follower on the cam (``[follower.dynamics]``). A positive
    drive has flanks that push the follower outward, and flanks that pull it back.
    """

    kind: Annotated[
        DriveName | None,
        Key(
            "Kind of drive: `spring`; `groove`, with an outer and an inner wall; `conjugate`, "
            "two discs with a roller each; `breadth` or `diameter`, one disc in a yoke with two "
            "flat faces or two rollers; `rib`, between two rollers. If not given: `spring` on a "
            "disc cam, `groove` on a cylindrical cam"
        ),
    ] = None
    base_radius: Annotated[
        Length | None,
        Key("Base radius of the second disc of a conjugate pair; `cam.base_radius` if not given", "mm"),
    ] = None
    roller_radius: Annotated[
        Length | None, Key("Radius of the second roller; `follower.roller_radius` if not given", "mm")
    ] = None
    offset: Annotated[
        SignedNumber | None,
        Key("Offset of a translating second roller, positive to the right; `follower.offset` if not given", "mm"),
    ] = None
    arm_length: Annotated[
        Length | None, Key("Length of the second roller's arm; `follower.arm_length` if not given", "mm")
    ] = None


def _number_or_range_validator(message: str, least: float, most: float) -> BeforeValidator:
    """A validator of a number, or of a range of numbers, within bounds."""

    def check_range(value: Any) -> float | tuple[float, float]:
        pair = value if isinstance(value, (list, tuple)) else (value, value)
        try:
            low, high = map(check_number, pair)
        except ValueError:
            raise ValueError(message) from None
        if not least <= low <= high <= most:
            raise ValueError(f"{message}, from {least:g} to {most:g}")
        return low if low == high else (low, high)

    return BeforeValidator(check_range)


NumberOrRange = Annotated[
    float | tuple[float, float],
    _number_or_range_validator("a number, or a range [low, high]", -LARGEST_VALUE, LARGEST_VALUE),
]
CamAngle = Annotated[
    float | tuple[float, float], _number_or_range_validator("a cam angle, or a range [from, to], deg", 0.0, 360.0)
]

MOST_SEGMENTS, MOST_CONDITIONS = 1_000, 200


class Through(SceneTable):
    """A condition within a move: at one cam angle, or over a range [from, to] of cam angles.

    Position, velocity, acceleration and jerk are each a number or a range [low, high]. The segment's ``per`` sets
    the unit of derivatives.
    """

    elsewhere: ClassVar[Mapping[str, str]] = {"per": "belongs to the segment, for all its derivatives"}
    angle: Annotated[
        CamAngle, Key("Cam angle, or range [from, to], counted from the start of the first segment", "deg")
    ]
    position: Annotated[NumberOrRange | None, Key("Displacement at that cam angle", "mm", "deg")] = None
    velocity: Annotated[NumberOrRange | None, Key("Velocity at that cam angle", "mm (deg) `per` rad, deg or s")] = (
        None
    )
    acceleration: Annotated[
        NumberOrRange | None, Key("Acceleration at that cam angle", "mm (deg) `per` rad², deg² or s²")
    ] = None
    jerk: Annotated[NumberOrRange | None, Key("Jerk at that cam angle", "mm (deg) `per` rad³, deg³ or s³")] = None


class Segment(SceneTable):
    """One segment of the turn: a rise, dwell, return, move or stretch at constant velocity.

    A rise or return has a motion law, and either a ``lift`` or the position ``to`` at its end. A stretch at
    constant velocity has a position ``to`` at its end, or a ``velocity``.

    A move ends at the position ``to``. It is a polynomial of degree 5 that joins its neighbours with continuous
    velocity and acceleration. ``velocity``, ``acceleration`` and ``jerk`` may be given at its end. Between two
    moves each of these, and ``to``, may be a range [low, high] or be left out; camopt then chooses the value with
    the least mean-square jerk. If a jerk is given at a cam angle, its move and the moves joined to it have degree 7
    and continuous jerk, and the mean square of the derivative of jerk is the least. ``through`` holds conditions
    within the move; the polynomial and every motion of ``synthesise`` meet them. A ``law`` of positions
    (``[laws]``), as ``synthesise`` writes it, may replace the polynomial; it has to meet the values at the end of
    the move.

    In a yoke (``drive.kind``) the segments may cover half a turn, 180 deg. The other half exchanges rises and
    returns: its positions are as far below the highest position as those of the first half are above the lowest.

    With positions, the turn starts at the last position. Displacements of designs count from the lowest position of
    the turn, which is on the base circle.
    """

    segment: Annotated[
        Literal["rise", "dwell", "return", "move", "constant-velocity"],
        BeforeValidator(lambda value: canonical_segment_kind(value) if isinstance(value, str) else value),
        Field(json_schema_extra=_add_segment_aliases),
        Key("Kind of segment"),
    ]
    angle: Annotated[
        float,
        BoundedNumber(ge=0, le=360 * (1 + 1e-9)),
        Key("Cam angle of the segment. The angles of a turn add up to 360 (in a yoke 180 is allowed too)", "deg"),
    ]
    lift: Annotated[
        float, BoundedNumber(ge=0, le=LARGEST_VALUE), Key("Displacement of a rise or return, above 0", "mm", "deg")
    ] = 0.0
    law: Annotated[
        LawName | None,
        Key("Motion law: built-in, or one of `[laws]`. If not given, the first law that `[search]` tries"),
    ] = None
    to: Annotated[
        NumberOrRange | None, Key("Position at the end; between moves also a range [low, high]", "mm", "deg")
    ] = None
    velocity: Annotated[
        NumberOrRange | None,
        Key("Velocity at the end of a move, or of a stretch at constant velocity", "mm (deg) `per` rad, deg or s"),
    ] = None
    acceleration: Annotated[
        NumberOrRange | None, Key("Acceleration at the end of a move", "mm (deg) `per` rad², deg² or s²")
    ] = None
    jerk: Annotated[NumberOrRange | None, Key("Jerk at the end of a move", "mm (deg) `per` rad³, deg³ or s³")] = (
        None
    )
    per: Annotated[
        Literal["rad", "deg", "s"],
        Key("Unit that derivatives of this segment are taken by: rad or deg of cam angle, or s"),
    ] = "rad"
    through: Annotated[
        tuple[InnerTable[Through], ...], Field(max_length=MOST_CONDITIONS), Key("Conditions within a move")
    ] = ()


class ProfileElement(SceneTable):
    """One arc or line of the cam's profile [mm]; a profile replaces the motion.

    List the elements in the order in which the follower meets them: clockwise on a cam that turns ccw. Each is
    tangent to the next: base circle, flank, nose and flank of a three-arc cam. An arc has a ``radius`` (below 0 on
    a hollow flank) and a centre (``x``, ``y``); the cam turns about 0, 0. An arc without a centre is tangent to
    both neighbours, and so is every ``line``; these neighbours need centres. A single arc with its centre off the
    axis is an eccentric.

    The motion of the follower is exact: each element has one formula. Velocity is continuous between elements;
    acceleration jumps with the curvature. The turn starts where the follower reaches the first element; on an
    eccentric, where the follower is lowest. The profile may be drawn at any angle. ``cam.base_radius`` is the least
    radius of the profile.
    """

    element: Annotated[Literal["arc", "line"], Key("Kind of element: an arc, or a line between two arcs")]
    radius: Annotated[SignedNumber | None, Key("Radius of an arc, negative on a hollow flank", "mm")] = None
    x: Annotated[
        SignedNumber | None, Key("Coordinate x of the centre of an arc, in the frame of the cam", "mm")
    ] = None
    y: Annotated[
        SignedNumber | None, Key("Coordinate y of the centre of an arc, in the frame of the cam", "mm")
    ] = None


def check_two_numbers(value: Any) -> tuple[float, ...]:
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError("two numbers")
    return tuple(check_number(v) for v in value)


Numbers = Annotated[tuple[SignedNumber, ...], Field(min_length=1)]


class OwnLaw(SceneTable):
    """A motion law that the scene defines on the unit stroke, from s = 0 at x = 0 to s = 1 at x = 1.

    Give it in one of these forms:

    - A polynomial: ``start`` and ``end`` hold s, s′, s″, … at x = 0 and x = 1. For the 3-4-5 polynomial they are
      ``[0, 0, 0]`` and ``[1, 0, 0]``. The degree is the least that meets the conditions, at most 12.
    - ``scca``: shares of the stroke for sine ramps, constant acceleration, cosine, and optionally constant
      velocity. ``[0.25, 0.5, 0.25]`` is the modified trapezoid.
    - ``law``: a built-in law, to be skewed or mirrored.
    - A B-spline: ``degree`` (3 to 12), clamped ``knots`` (first degree + 1 zeros, last degree + 1 ones) and
      ``coefficients``. A law for a move has ``positions`` in place of coefficients, in mm (oscillating: deg).
    - A table: points ``x`` and ``s``, or a CSV ``file`` with these columns. Its law is the quintic spline through
      the points. ``rest`` names the ends where velocity and acceleration are 0; without it, all ends that
      ``reversal`` does not name. ``reversal`` names the ends where the velocity is 0 and the acceleration is not.
      An end that neither names is free; free ends get the least mean-square jerk. Verdicts on a table have the
      ``status`` "sampled", since the motion between the points is not known. The path of the file is relative to
      the scene file; it is read when the scene is made. A Python function ``f`` is a table too: ``x = [k / 200 for
      k in range(201)]`` and ``s = [f(v) for v in x]``.

    ``crossing`` skews a symmetric law: its acceleration crosses zero there, not at ½. ``peaks = [a, d]`` chooses
    the crossing so that the largest acceleration is to the largest deceleration as a to d. ``overshoot`` allows s
    below 0 or above 1; the lowest displacement of the turn is on the base circle.

    A rise follows y = lift·s(x), a return y = lift·(1 − s(x)): each starts as the law starts. ``mirror`` takes
    1 − s(1 − x) in place of s(x). A return with the mirrored law retraces, backwards, a rise with the law itself.
    """

    law: Annotated[LawName | None, Key("A built-in law, to be skewed or mirrored")] = None
    scca: Annotated[
        Numbers | None,
        Key(
            "Shares of the stroke: sine ramps, constant acceleration, cosine and, if there are four, constant "
            "velocity",
            "no unit",
        ),
    ] = None
    start: Annotated[Numbers | None, Key("s, s′, s″, … of a polynomial at x = 0", "no unit")] = None
    end: Annotated[Numbers | None, Key("s, s′, s″, … of a polynomial at x = 1", "no unit")] = None
    degree: Annotated[
        Annotated[int, BeforeValidator(check_whole_number), Field(ge=SPLINE_DEGREES[0], le=SPLINE_DEGREES[-1])]
        | None,
        Key("Degree of a B-spline"),
    ] = None
    knots: Annotated[
        Numbers | None, Key("Knots of a B-spline from 0 to 1, degree + 1 equal ones at each end", "no unit")
    ] = None
    coefficients: Annotated[Numbers | None, Key("Coefficients of a B-spline on the unit stroke", "no unit")] = None
    positions: Annotated[Numbers | None, Key("Coefficients of a B-spline for a move", "mm", "deg")] = None
    x: Annotated[Numbers | None, Key("Points of a table: shares of the stroke's angle, from 0 to 1", "no unit")] = (
        None
    )
    s: Annotated[Numbers | None, Key("Points of a table: shares of the lift at `x`, from 0 to 1", "no unit")] = None
    file: Annotated[
        str | None, Key("CSV file with the columns x and s; the path is relative to the scene file")
    ] = None
    rest: Annotated[
        Literal["both", "start", "end", "none"] | None,
        Key(
            "Ends of a table where velocity and acceleration are 0; if not given, all ends that "
            "`reversal` does not name"
        ),
    ] = None
    reversal: Annotated[
        Literal["both", "start", "end"] | None,
        Key(
            "Ends of a table where the velocity is 0 and the acceleration is not, as between a rise and "
            "the return that follows at once"
        ),
    ] = None
    crossing: Annotated[
        SceneNumber | None,
        Key("Share x of the stroke at which a symmetric law's acceleration crosses zero, in place of ½", "no unit"),
    ] = None
    peaks: Annotated[
        Annotated[tuple[Positive, Positive], BeforeValidator(check_two_numbers)] | None,
        Key(
            "Ratio of the largest acceleration to the largest deceleration, [a, d], in place of `crossing`",
            "no unit",
        ),
    ] = None
    mirror: Annotated[Switch, Key("Take 1 − s(1 − x) in place of s(x)")] = False
    overshoot: Annotated[Switch, Key("Allow s below 0 or above 1")] = False


def single_value_as_list(value: Any) -> Any:
    return [value] if isinstance(value, (Real, str)) and not isinstance(value, bool) else value


OutputName = Annotated[
    str,
    known_name_validator(
        (*QUANTITIES, *DISCIPLINES, EVERYTHING),
        "a quantity, an effect (camopt effects lists them) or all",
        others=True,
    ),
]
Outputs = Annotated[tuple[OutputName, ...], ListOrItem(single_value_as_list)]
QuantityNames = Annotated[tuple[QuantityName, ...], ListOrItem(single_value_as_list)]


@with_optional_keys(number_keys_with_types(number_keys_of_table("materials")))
class Materials(TableOfRecords):
    """Materials of the cam and the follower, by name or as numbers, and the lubricant between them."""

    cam: Annotated[
        MaterialName | None,
        Key("Material of the cam; sets its modulus, Poisson's ratio and density", example="steel"),
    ] = None
    follower: Annotated[
        MaterialName | None,
        Key("Material of the roller or face; sets its modulus and Poisson's ratio", example="steel"),
    ] = None


class Accuracy(SceneTable):
    """Accuracy of reported values."""

    relative_error: Annotated[
        float,
        BoundedNumber(ge=1e-14, le=1e-2),
        Key("Largest relative error of each reported value", "no unit", example=1e-9),
    ] = 1e-9
