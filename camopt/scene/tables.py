"""The tables of a scene: their keys, allowed values and meanings."""

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
from camopt.core.quantities.scene_numbers import NUMBER_KEYS, numbers_in
from camopt.model.mechanisms.elements import CamForm, DriveName, MotionName, TipName
from camopt.model.motion import LAWS
from camopt.model.motion.aliases import ALIASES, SEGMENT_ALIASES, canonical_segment
from camopt.scene.law_forms import SPLINE_DEGREES
from camopt.scene.materials import MATERIALS
from camopt.scene.pydantic_mistakes import mistakes_from_pydantic


def check_number(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError("a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("a finite number") from None


def _number_as_given(value: Any) -> Any:
    """The number; a whole one stays so until its bounds are checked, and mistakes show what was written."""
    number = check_number(value)
    return value if type(value) is int else number


class BoundedNumber:
    """A finite number within bounds, or None if it may be: told to pydantic at once, which takes it less time."""

    def __init__(self, **bounds: float) -> None:
        self.bounds: Any = bounds

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        finite = core_schema.float_schema(allow_inf_nan=False, **self.bounds)
        number = core_schema.no_info_before_validator_function(_number_as_given, finite)
        return number if source is float else core_schema.nullable_schema(number)


LARGEST_VALUE, SLOWEST_RPM = ANYWHERE["le"], 1e-9
SceneNumber = Annotated[float, BoundedNumber()]
Length = Annotated[float, BoundedNumber(**LENGTH)]
SignedNumber = Annotated[float, BoundedNumber(**ANYWHERE)]
Positive = Annotated[float, BoundedNumber(**POSITIVE)]
NotNegative = Annotated[float, BoundedNumber(**NOT_NEGATIVE)]


class Name:
    """A text of which something is asked; the names that may be given are told in the schema alone."""

    def __init__(self, check: Callable[[Any], str], names: Iterable[str], others: bool = False) -> None:
        self.check, self.names, self.others = check, names, others

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        return core_schema.no_info_before_validator_function(self.check, core_schema.str_schema())

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        known = {"enum": [*self.names], "type": "string"}
        return {"anyOf": [known, {"type": "string"}]} if self.others else known


def known_name(names: Any, what: str) -> Name:
    """One of some names."""

    def check(value: Any) -> str:
        if not isinstance(value, str) or value not in names:
            raise ValueError(f"{what}; {suggest_names(str(value), names)}")
        return value

    return Name(check, names)


def known_or_own_name(names: Any, what: str) -> Name:
    """One of some names, or of those that the scene adds to them."""

    def check(value: Any) -> str:
        if not isinstance(value, str):
            raise ValueError(f"{what}; {suggest_names(str(value), names)}")
        return value

    return Name(check, names, others=True)


class ListOrItem:
    """A list in whose place an only item may stand."""

    def __init__(self, listed: Callable[[Any], Any]) -> None:
        self.listed = listed

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        return core_schema.no_info_before_validator_function(self.listed, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        item = handler(schema)["items"]
        return {"anyOf": [item, {"items": item, "type": "array"}]}


def check_one_line(value: Any) -> Any:
    if isinstance(value, str) and not value.isprintable():
        raise ValueError("a text of one line, of printable characters")
    return value


def check_whole_number(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise ValueError("a whole number")
    return int(value)


def _check_law_name(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError("the name of a motion law")
    return value


def _check_switch(value: Any) -> Any:
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


def _kind_of_segment(value: Any) -> Any:
    return canonical_segment(value) if isinstance(value, str) else value


def _add_segment_aliases(schema: dict[str, Any]) -> None:
    """In the schema of scenes, the other names of segments."""
    own = {name: schema.pop(name) for name in ("enum", "type")}
    schema["anyOf"] = [own, {**own, "enum": [*chain(*SEGMENT_ALIASES.values())]}]


def or_text(schema: dict[str, Any]) -> None:
    """In the schema of scenes, a key that takes a text too, which is read before keys are checked."""
    own = {name: schema.pop(name) for name in tuple(schema) if name not in ("default", "title", "description")}
    kinds = own.pop("anyOf", [own])
    schema["anyOf"] = [{"type": "string"}, *kinds]


Switch = Annotated[bool, BeforeValidator(_check_switch)]
LawName = Annotated[str, Name(_check_law_name, (*LAWS, *chain(*ALIASES.values())), others=True)]
MaterialName = Annotated[str, known_name(MATERIALS, "a material")]
QUANTITY_SYNONYMS = {"size": "base_radius_mm"}
"""Quantities by words of others."""
QuantityName = Annotated[str, known_or_own_name(QUANTITIES, "a quantity")]


class SceneTable(BaseModel):
    """A table of a scene: unknown keys are mistakes, and nothing changes once made."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)
    elsewhere: ClassVar[Mapping[str, str]] = {}
    """Keys that do not belong here although they seem to, each with what the message says of it."""
    read_as: ClassVar[Mapping[str, str]] = {}
    """Keys that are read as others, in whose place they stand: no search varies them."""

    def __init__(self, /, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise BadInput(mistakes_from_pydantic(error, type(self), type(self).__name__.lower())) from None

    if not TYPE_CHECKING:  # or types would let any name be set

        def __setattr__(self, name: str, value: Any) -> None:
            """Refuse a change, with the way to another scene."""
            if name in type(self).model_fields:
                why = "does not change: replace makes another scene, as scene.replace(name='x')"
                raise BadInput([Mistake(type(self).__name__.lower(), name, value, why, bare=True)])
            super().__setattr__(name, value)

    @classmethod
    def from_value(cls, value: Any) -> Self:
        """The table of a mapping."""
        if isinstance(value, cls):
            return value
        if not isinstance(value, dict):
            raise ValueError("a table")
        return cls(**value)

    @classmethod
    def from_known_keys(cls, value: Any) -> Self | None:
        """The table of the known keys of a mapping; None where a value of them is wrong, or one is missing."""
        try:
            return cls.from_value({key: value[key] for key in cls.model_fields if key in value})
        except (TypeError, ValueError):  # BadInput is one
            return None


def _table_to_mapping(table: "SceneTable", info: core_schema.SerializationInfo) -> dict[str, Any]:
    """The mapping of a table. pydantic up to 2.13 cannot write a table that it did not check before."""
    return table.model_dump(mode=info.mode, exclude_none=info.exclude_none, exclude_defaults=info.exclude_defaults)


class _SelfCheckedTable:
    """A table within another one checks itself: pydantic makes ready those that a scene has, and no more."""

    def __get_pydantic_core_schema__(self, source: type[SceneTable], handler: Any) -> Any:
        written = core_schema.plain_serializer_function_ser_schema(_table_to_mapping, info_arg=True)
        return core_schema.no_info_plain_validator_function(source.from_value, serialization=written)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        table: type[SceneTable] = schema["function"]["function"].__self__
        table.model_rebuild()
        return handler(core_schema.chain_schema([table.__pydantic_core_schema__]))  # so that it is referred to


AnyTable = TypeVar("AnyTable", bound=SceneTable)
InnerTable = Annotated[AnyTable, _SelfCheckedTable()]
"""A table within another one."""


class TableOfRecords(SceneTable):
    """A table of which some keys, or all, are made of their records."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...


def with_keys(keys: Mapping[str, tuple[Any, Key]]) -> Callable[[type[AnyTable]], type[AnyTable]]:
    """A table with more keys, each with the type of its value and its record; none of them is needed."""
    fields: Any = {name: (Annotated[kind | None, key], None) for name, (kind, key) in keys.items()}
    return lambda table: create_model(
        table.__name__, __base__=table, __doc__=table.__doc__, __module__=table.__module__, **fields
    )


def number_keys(numbers: Iterable[NumberKey], **kinds: Any) -> dict[str, tuple[Any, Key]]:
    """The keys of numbers, each with its type: one that is given, or a number within its bounds."""
    own = {each.name: each for each in numbers}
    return {
        name: (kinds.get(name, Annotated[float, BoundedNumber(**each.allowed)]), each) for name, each in own.items()
    }


def table_type_in(hint: Any) -> type[SceneTable] | None:
    """The table that a type has among its members."""
    if isinstance(hint, type) and issubclass(hint, SceneTable):
        return hint
    return next((found for each in get_args(hint) if (found := table_type_in(each))), None)


def _check_rpm(value: Any) -> Any:
    if isinstance(value, Real) and not isinstance(value, bool) and value < SLOWEST_RPM:
        raise ValueError(f"at least {SLOWEST_RPM:g}; the sense of rotation is cam.rotation, 'ccw' or 'cw'")
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
            "A disc cam turns about an axis square to the motion, a cylindrical (barrel) cam has a groove round it"
        ),
    ]
    rotation: Annotated[
        Literal["ccw", "cw"],
        Key("Sense of rotation, as seen in pictures: ccw (anticlockwise) or cw", example="ccw"),
    ] = "ccw"
    rpm: Annotated[Speed | None, NUMBER_KEYS["cam.rpm"]] = None
    rpm_of_crank: Annotated[
        Speed | None,
        Key(
            "In place of ``rpm``: speed of the crankshaft of a four-stroke engine, twice that of the cam", "rev/min"
        ),
    ] = None
    base_radius: Annotated[Length | None, Key("Least radius of the profile of a disc cam", "mm", usual=LENGTHS)] = (
        None
    )
    mean_radius: Annotated[
        Length | None, Key("Radius at which a cylindrical cam is developed", "mm", usual=LENGTHS)
    ] = None
    shaft_diameter: Annotated[Length | None, NUMBER_KEYS["cam.shaft_diameter"]] = None


def _rows_as_tuples(value: Any) -> Any:
    return tuple(tuple(row) if isinstance(row, list) else row for row in value)


def _kind_of_load(value: Any) -> str:
    return "file/" if isinstance(value, str) else "rows/" if isinstance(value, (list, tuple)) else "constant/"


LoadRows = Annotated[
    tuple[Any, ...], BeforeValidator(_rows_as_tuples, json_schema_input_type=list[tuple[float, float]])
]  # what is in them is checked with the scene
GivenLoad = Annotated[
    Annotated[SignedNumber, Tag("constant/")] | Annotated[str, Tag("file/")] | Annotated[LoadRows, Tag("rows/")],
    Discriminator(_kind_of_load),
]


@with_keys(number_keys(numbers_in("follower.dynamics"), load=GivenLoad))
class Dynamics(TableOfRecords):
    """The moving mass and the forces on the follower. An oscillating follower has inertias and moments.

    A load that changes over the turn is a list of rows (cam angle from the start of the first segment, 0 to 360
    deg; load), or a CSV file with columns angle and load (a path relative to the scene file), read when the scene
    is made. It goes straight from row to row, and from the last to the first of the next turn; two rows at one cam
    angle (0 and 360 are one) are a jump.
    """


class Follower(SceneTable):
    """The follower: how it moves, what touches the cam, and its sizes."""

    elsewhere: ClassVar[Mapping[str, str]] = {
        "roller_diameter": "not a known key; follower.roller_radius is half of it",
        "face_diameter": "not a known key; follower.face_radius is half of it",
    }

    motion: Annotated[MotionName, Key("Along a straight line, or about a pivot")]
    contact: Annotated[
        TipName, Key("What touches the cam: a knife edge, a roller, a flat face or a spherical (mushroom) face")
    ]
    roller_radius: Annotated[Length | None, Key("Radius of the roller", "mm", example=10, usual=LENGTHS)] = None
    face_radius: Annotated[Length | None, Key("Radius of a spherical face", "mm", example=10, usual=(0.1, 1e6))] = (
        None
    )
    face_offset: Annotated[
        SignedNumber | None, Key("Distance of an oscillating flat face from the pivot", "mm", example=10)
    ] = None
    arm_length: Annotated[
        Length | None, Key("Distance from the pivot to the trace point", "mm", example=80, usual=LENGTHS)
    ] = None
    centre_distance: Annotated[
        Length | None, Key("Distance from the pivot to the cam's axis", "mm", example=100, usual=LENGTHS)
    ] = None
    roller_spacing: Annotated[
        Length | None,
        Key(
            "Distance of the centres of two rollers, which have a rib between them", "mm", example=50, usual=LENGTHS
        ),
    ] = None
    offset: Annotated[SignedNumber, Key("Offset of a translating follower's axis, positive to the right", "mm")] = (
        0.0
    )
    dynamics: Annotated[
        InnerTable[Dynamics] | None, Key("What moves with the follower, and what presses it on the cam")
    ] = None


@with_keys(number_keys(numbers_in("drive")))
class Drive(TableOfRecords):
    """What keeps the follower on the cam.

    On an open cam a spring, or what else presses the follower on it (``[follower.dynamics]``). A positive drive has
    flanks that push the follower outward, and others that pull it back.
    """

    kind: Annotated[
        DriveName | None,
        Key(
            "A spring, or a groove with two walls, of which one pushes the roller outward and the "
            "other pulls it back. Two discs with a roller each (``conjugate``), or one disc in a "
            "yoke with two flat faces (``breadth``) or two rollers (``diameter``). Or a rib between "
            "two rollers (``rib``). If it is not given, ``spring`` on a disc cam and ``groove`` on a "
            "cylindrical one"
        ),
    ] = None
    base_radius: Annotated[
        Length | None,
        Key("Base radius of the second disc of a conjugate pair; ``cam.base_radius`` if not given", "mm"),
    ] = None
    roller_radius: Annotated[
        Length | None, Key("Radius of the second roller; that of the first if not given", "mm")
    ] = None
    offset: Annotated[
        SignedNumber | None,
        Key(
            "Offset of a second roller that translates, positive to the right; that of the first if not given", "mm"
        ),
    ] = None
    arm_length: Annotated[
        Length | None, Key("Length of the arm of the second roller; that of the first if not given", "mm")
    ] = None


def _number_or_range(what: str, least: float, most: float) -> BeforeValidator:
    """A number from one to another, or a range of such numbers."""

    def check_range(value: Any) -> Any:
        pair = value if isinstance(value, (list, tuple)) else (value, value)
        try:
            low, high = map(check_number, pair)
        except ValueError:
            raise ValueError(what) from None
        if not least <= low <= high <= most:
            raise ValueError(f"{what}, from {least:g} to {most:g}")
        return low if low == high else (low, high)

    return BeforeValidator(check_range)


NumberOrRange = Annotated[
    float | tuple[float, float], _number_or_range("a number, or a range [low, high]", -LARGEST_VALUE, LARGEST_VALUE)
]
CamAngle = Annotated[
    float | tuple[float, float], _number_or_range("a cam angle, or a range [from, to], deg", 0.0, 360.0)
]

MOST_SEGMENTS, MOST_CONDITIONS = 1_000, 200


class Through(SceneTable):
    """A condition on the way of a move: at a cam angle of the turn, or all along a range [from, to] of it.

    Each but the angle is a number, or a range [low, high]. Derivatives are by what the segment says (``per``).
    """

    elsewhere: ClassVar[Mapping[str, str]] = {"per": "belongs to the segment, for all that it asks"}
    angle: Annotated[
        CamAngle, Key("Cam angle, or range of cam angles [from, to], from the start of the first segment", "deg")
    ]
    position: Annotated[NumberOrRange | None, Key("Displacement at that cam angle", "mm", "deg")] = None
    velocity: Annotated[
        NumberOrRange | None, Key("First derivative at that cam angle", "mm (deg) ``per`` rad, deg or s")
    ] = None
    acceleration: Annotated[
        NumberOrRange | None, Key("Second derivative at that cam angle", "mm (deg) ``per`` rad², deg² or s²")
    ] = None
    jerk: Annotated[
        NumberOrRange | None, Key("Third derivative at that cam angle", "mm (deg) ``per`` rad³, deg³ or s³")
    ] = None


class Segment(SceneTable):
    """One segment of the turn: a rise, dwell, return, move or stretch at constant velocity.

    A rise or return has a motion law and a ``lift``, or the position ``to`` at its end. A stretch at constant
    velocity goes ``to`` a position, or at a ``velocity``. A move goes ``to`` a position as the polynomial of
    degree 5 that joins what is beside it with continuous velocity and acceleration, or with a ``law`` of
    positions (``[laws]``), as ``synthesise`` writes it; what it asks at its end that law has to meet.
    ``velocity``, ``acceleration`` and ``jerk`` may be given at its end. Between two moves each of these, and
    ``to``, may be a range [low, high], or be left out: it is then chosen for the least mean-square jerk. Where a
    jerk is asked for at a cam angle, the jerk of moves that follow each other is continuous too (degree 7), and
    the mean square of its derivative is the least. ``through`` are conditions on the way, which that
    motion meets, and all that ``synthesise`` finds.

    In a yoke (``drive.kind``) the segments may be those of half a turn, 180 deg: the other half is the same with
    rises for returns, and positions as much below the highest one as they are above the lowest.

    Where positions are given, the turn starts at the last of them. Designs count displacements from the lowest
    position of the turn, which is on the base circle.
    """

    segment: Annotated[
        Literal["rise", "dwell", "return", "move", "constant-velocity"],
        BeforeValidator(_kind_of_segment),
        Field(json_schema_extra=_add_segment_aliases),
        Key("What the follower does"),
    ]
    angle: Annotated[
        float,
        BoundedNumber(ge=0, le=360 * (1 + 1e-9)),
        Key("Cam angle that the segment takes; those of a turn add up to 360, of a yoke also to 180", "deg"),
    ]
    lift: Annotated[
        float, BoundedNumber(ge=0, le=LARGEST_VALUE), Key("Displacement of a rise or return, above 0", "mm", "deg")
    ] = 0.0
    law: Annotated[
        LawName | None,
        Key(
            "Motion law: a built-in one, or one of ``[laws]``. If it is not given, the first that "
            "``[search]`` tries"
        ),
    ] = None
    to: Annotated[
        NumberOrRange | None, Key("Position at the end; between moves also a range [low, high]", "mm", "deg")
    ] = None
    velocity: Annotated[
        NumberOrRange | None,
        Key(
            "First derivative at the end of a move, or along a constant velocity", "mm (deg) ``per`` rad, deg or s"
        ),
    ] = None
    acceleration: Annotated[
        NumberOrRange | None, Key("Second derivative at the end of a move", "mm (deg) ``per`` rad², deg² or s²")
    ] = None
    jerk: Annotated[
        NumberOrRange | None, Key("Third derivative at the end of a move", "mm (deg) ``per`` rad³, deg³ or s³")
    ] = None
    per: Annotated[
        Literal["rad", "deg", "s"],
        Key("What derivatives of this segment are by: rad or deg of the cam's angle, or s"),
    ] = "rad"
    through: Annotated[
        tuple[InnerTable[Through], ...], Field(max_length=MOST_CONDITIONS), Key("Conditions on the way of a move")
    ] = ()


class ProfileElement(SceneTable):
    """One arc or line of the cam's profile, which is given in place of the motion; mm.

    The elements are in the order in which the follower meets them, clockwise on a cam that turns ccw, each tangent
    to the next: base circle, flank, nose and flank of a three-arc cam. An arc has a ``radius``, below 0 where the
    flank is hollow, and a centre (``x``, ``y``); the axis of the cam is at 0, 0. Without a centre it touches both
    neighbours, as a ``line`` always does; these have centres. One arc about another centre is an eccentric.

    The motion of the follower is exact: on each element it has one formula, the velocity is continuous where two
    meet, and the acceleration jumps with the curvature. The turn starts where the follower comes on the first
    element, or, on an eccentric, where it is lowest; the profile may stand at any angle in its own coordinates.
    ``cam.base_radius`` is the least radius of the profile.
    """

    element: Annotated[Literal["arc", "line"], Key("An arc, or a line between two arcs")]
    radius: Annotated[SignedNumber | None, Key("Radius of an arc, negative if its flank is hollow", "mm")] = None
    x: Annotated[SignedNumber | None, Key("Centre of an arc in the cam's own frame, with ``y``", "mm")] = None
    y: Annotated[SignedNumber | None, Key("Centre of an arc in the cam's own frame, with ``x``", "mm")] = None


def check_pair(value: Any) -> Any:
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError("two numbers")
    return tuple(check_number(v) for v in value)


Numbers = Annotated[tuple[SignedNumber, ...], Field(min_length=1)]


class OwnLaw(SceneTable):
    """A motion law of the scene's own on the unit stroke, from s = 0 at x = 0 to s = 1 at x = 1, given in one way.

    - A polynomial has conditions at both ends: ``start`` and ``end`` hold s, s′, s″, …; ``start = [0, 0, 0]`` and
      ``end = [1, 0, 0]`` make the 3-4-5 polynomial. It is the one of least degree that meets them, 12 at most.
    - ``scca`` are shares of the stroke: sine ramps, constant acceleration, cosine, and constant velocity if there
      is a fourth. ``[0.25, 0.5, 0.25]`` is the modified trapezoid.
    - ``law`` is a built-in law, to be skewed or mirrored.
    - A B-spline has a ``degree`` from 3 to 12, clamped ``knots`` (degree + 1 zeros first, as many ones last) and
      ``coefficients``; for a move ``positions`` in their place, in mm, or deg when oscillating.
    - A table has points ``x`` and ``s``, or a CSV ``file`` with these columns (a path relative to the scene file),
      read when the scene is made. Its law is the quintic spline through the points, at rest at both ends, or where
      ``rest`` says ("start", "end", "none"). At an end that ``reversal`` names its velocity is 0 and its
      acceleration is not; an end that neither names is open. What is open has the least mean-square jerk. The
      ``status`` of its verdicts is "sampled", for the motion between the points is not known. A function ``f`` of
      Python is given as points too: ``x = [k / 200 for k in range(201)]`` and ``s = [f(v) for v in x]``.

    ``crossing`` is where the acceleration of a symmetric law crosses zero in place of ½; ``peaks = [a, d]`` puts it
    where the largest acceleration is to the largest deceleration as a to d. ``overshoot`` allows s below 0 or above
    1; the lowest of the turn is on the base circle.

    A rise follows y = lift·s(x), a return y = lift·(1 − s(x)): each starts as the law starts. ``mirror`` takes
    1 − s(1 − x) in place of s(x). On a return it then retraces the rise with the law as it was given, backwards.
    """

    law: Annotated[LawName | None, Key("A built-in law, to be skewed or mirrored")] = None
    scca: Annotated[
        Numbers | None,
        Key(
            "Shares of the stroke: sine ramps, constant acceleration, cosine, constant velocity if "
            "there is a fourth",
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
    x: Annotated[
        Numbers | None, Key("Shares of the stroke's angle at which a table has points, from 0 to 1", "no unit")
    ] = None
    s: Annotated[Numbers | None, Key("Shares of the lift there, from 0 to 1", "no unit")] = None
    file: Annotated[str | None, Key("CSV file with the columns x and s, a path relative to the scene file")] = None
    rest: Annotated[
        Literal["both", "start", "end", "none"] | None,
        Key(
            "At which ends the law of a table is at rest, without velocity and acceleration: where "
            "there is no ``reversal``, if not given"
        ),
    ] = None
    reversal: Annotated[
        Literal["both", "start", "end"] | None,
        Key(
            "At which ends the law of a table has no velocity but an acceleration, as where a rise "
            "goes over into a return"
        ),
    ] = None
    crossing: Annotated[
        SceneNumber | None, Key("Where the acceleration of a symmetric law crosses zero, in place of ½", "no unit")
    ] = None
    peaks: Annotated[
        Annotated[tuple[Positive, Positive], BeforeValidator(check_pair)] | None,
        Key("Largest acceleration to largest deceleration, [a, d], in place of ``crossing``", "no unit"),
    ] = None
    mirror: Annotated[Switch, Key("Take 1 − s(1 − x) in place of s(x)")] = False
    overshoot: Annotated[Switch, Key("Allow s below 0 or above 1")] = False


def as_list(value: Any) -> Any:
    return [value] if isinstance(value, (Real, str)) and not isinstance(value, bool) else value


OutputName = Annotated[
    str,
    known_or_own_name(
        (*QUANTITIES, *DISCIPLINES, EVERYTHING), "a quantity, an effect (camopt effects lists them) or all"
    ),
]
Outputs = Annotated[tuple[OutputName, ...], ListOrItem(as_list)]
QuantityNames = Annotated[tuple[QuantityName, ...], ListOrItem(as_list)]


@with_keys(number_keys(numbers_in("materials")))
class Materials(TableOfRecords):
    """The bodies in contact, as names of materials or as numbers, and their lubricant."""

    cam: Annotated[
        MaterialName | None,
        Key("Material of the cam, for its modulus, Poisson's ratio and density", example="steel"),
    ] = None
    follower: Annotated[
        MaterialName | None,
        Key("Material of the roller or face, for its modulus and Poisson's ratio", example="steel"),
    ] = None


class Accuracy(SceneTable):
    """Relative error allowed in each reported value."""

    relative_error: Annotated[
        float,
        BoundedNumber(ge=1e-14, le=1e-2),
        Key("Relative error allowed in each reported value", "no unit", example=1e-9),
    ] = 1e-9
