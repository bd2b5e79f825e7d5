"""The tables of a scene: their keys, what each allows, and what it means."""

from collections.abc import Mapping
from numbers import Integral, Real
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
)

from camopt.mistakes import BadInput, nearest
from camopt.quantities import DISCIPLINES, EVERYTHING, QUANTITIES
from camopt.scene.complaints import TAGS, mistakes_of
from camopt.scene.law_forms import DEGREES
from camopt.scene.materials import MATERIALS


def _is_number(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError("a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("a finite number") from None


SHORTEST, LONGEST, SLOWEST = 1e-9, 1e9, 1e-9
Number = Annotated[float, BeforeValidator(_is_number), Field(allow_inf_nan=False)]
Length = Annotated[Number, Field(ge=SHORTEST, le=LONGEST)]
Anywhere = Annotated[Number, Field(ge=-LONGEST, le=LONGEST)]
Positive = Annotated[Number, Field(ge=1e-15, le=1e15)]
NotNegative = Annotated[Number, Field(ge=0, le=1e15)]
Acute = Annotated[Number, Field(ge=1e-9, lt=90)]


def _known(names: Any, what: str) -> Any:
    def validate(value: Any) -> Any:
        if not isinstance(value, str) or value not in names:
            raise ValueError(f"{what}; {nearest(str(value), names)}")
        return value

    return BeforeValidator(validate)


def one_line(value: Any) -> Any:
    if isinstance(value, str) and not value.isprintable():
        raise ValueError("a text of one line, of printable characters")
    return value


def is_whole(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise ValueError("a whole number")
    return int(value)


def _is_name(value: Any) -> Any:
    if not isinstance(value, str):
        raise ValueError("the name of a motion law")
    return value


def _is_switch(value: Any) -> Any:
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


Switch = Annotated[bool, BeforeValidator(_is_switch)]
LawName = Annotated[str, BeforeValidator(_is_name)]
MaterialName = Annotated[str, _known(MATERIALS, "a material")]
QuantityName = Annotated[str, _known(QUANTITIES, "a quantity")]


class Table(BaseModel):
    """A table of a scene: unknown keys are mistakes, and nothing changes once made."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    elsewhere: ClassVar[Mapping[str, str]] = {}
    """Keys that do not belong here although they seem to, each with what the message says of it."""

    def __init__(self, /, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise BadInput(mistakes_of(error, type(self), type(self).__name__.lower())) from None


def _turns(value: Any) -> Any:
    if isinstance(value, Real) and not isinstance(value, bool) and value < SLOWEST:
        raise ValueError(f"at least {SLOWEST:g}; the sense of rotation is cam.rotation, 'ccw' or 'cw'")
    return value


class Cam(Table):
    """The cam: form, sense of rotation, speed (rev/min) and size (mm)."""

    form: Literal["disc", "cylindrical"]
    rotation: Literal["ccw", "cw"] = "ccw"
    rpm: Annotated[Number, BeforeValidator(_turns), Field(le=1e15)] | None = None
    base_radius: Length | None = None
    mean_radius: Length | None = None
    shaft_diameter: Length | None = None


def _rows(value: Any) -> Any:
    return tuple(tuple(row) if isinstance(row, list) else row for row in value)


def _kind_of_load(value: Any) -> str:
    return "file/" if isinstance(value, str) else "rows/" if isinstance(value, (list, tuple)) else "constant/"


Load = Annotated[
    Annotated[Anywhere, Tag("constant/")]
    | Annotated[str, Tag("file/")]
    | Annotated[tuple[Any, ...], BeforeValidator(_rows), Tag("rows/")],  # what is in them is checked with the scene
    Discriminator(_kind_of_load),
]


class Dynamics(Table):
    """What moves with the follower, and what presses it on the cam.

    Translating: kg, N/mm, N, N·s/mm. Oscillating, about the pivot: inertia in kg·m² in place of the mass, N·m/rad,
    N·m, N·m·s/rad. ``load`` is an external force (moment) that presses the follower on the cam; ``gravity`` the
    acceleration (m/s²) that does so to the mass. Guide, overhang, stem in mm, natural frequency in Hz. ``lash`` is
    the displacement (mm, or deg) that the follower makes before what it drives moves, ± ``lash_variation``.

    A load that changes over the turn is a list of rows (cam angle from the start of the first segment, 0 to 360
    deg; load), or a CSV file with columns angle and load (a path relative to the scene file), read when the scene
    is made. It goes straight from row to row, and from the last to the first of the next turn; two rows at one cam
    angle (0 and 360 are one) are a jump.
    """

    mass: Positive | None = None
    inertia: Positive | None = None
    spring_rate: NotNegative | None = None
    preload: NotNegative | None = None
    damping: NotNegative | None = None
    load: Load | None = None
    gravity: Anywhere | None = None
    guide_length: Length | None = None
    overhang: NotNegative | None = None
    friction: NotNegative | None = None
    stem_diameter: Length | None = None
    natural_frequency: Positive | None = None
    damping_ratio: Annotated[Number, Field(ge=0, lt=1)] | None = None
    fluctuation: Positive | None = None
    lash: NotNegative | None = None
    lash_variation: NotNegative | None = None


class Follower(Table):
    """The follower: how it moves, what touches the cam, and its sizes (mm)."""

    motion: Literal["translating", "oscillating"]
    contact: Literal["knife", "roller", "flat", "spherical"]
    roller_radius: Length | None = None
    face_radius: Length | None = None
    face_offset: Anywhere | None = None
    arm_length: Length | None = None
    centre_distance: Length | None = None
    offset: Anywhere = 0.0
    dynamics: Dynamics | None = None


def _number_or_range(what: str, least: float, most: float) -> BeforeValidator:
    """A number from one to another, or a range of such numbers."""

    def taken(value: Any) -> Any:
        pair = value if isinstance(value, (list, tuple)) else (value, value)
        try:
            low, high = map(_is_number, pair)
        except ValueError:
            raise ValueError(what) from None
        if not least <= low <= high <= most:
            raise ValueError(f"{what}, from {least:g} to {most:g}")
        return low if low == high else (low, high)

    return BeforeValidator(taken)


Asked = Annotated[
    float | tuple[float, float], _number_or_range("a number, or a range [low, high]", -LONGEST, LONGEST)
]
CamAngle = Annotated[
    float | tuple[float, float], _number_or_range("a cam angle, or a range [from, to], deg", 0.0, 360.0)
]

MOST_SEGMENTS, MOST_CONDITIONS = 1_000, 200


class Through(Table):
    """What a move is asked for on its way: at a cam angle of the turn, or all along a range [from, to] of it (deg).

    The ``position`` (mm, or deg when oscillating), ``velocity``, ``acceleration`` and ``jerk``: each a number, or a
    range [low, high]. Derivatives are by what the segment says (``per``).
    """

    elsewhere: ClassVar[Mapping[str, str]] = {"per": "belongs to the segment, for all that it asks"}
    angle: CamAngle
    position: Asked | None = None
    velocity: Asked | None = None
    acceleration: Asked | None = None
    jerk: Asked | None = None


class Segment(Table):
    """One segment of the turn: cam angle in deg; a rise, dwell, return, move or stretch at constant velocity.

    A rise or return has a motion law and a ``lift`` (mm, or deg when oscillating), or the position ``to`` at its
    end. A stretch at constant velocity goes ``to`` a position, or at a ``velocity``. A move goes ``to`` a position
    as the polynomial of degree 5 that joins what is beside it with continuous velocity and acceleration, or with a
    ``law`` of positions (``[laws]``), as ``synthesise`` writes it; what it asks at its end that law has to meet.
    ``velocity``, ``acceleration`` and ``jerk`` may be given at its end, in mm (deg) ``per`` rad or deg of the cam's
    angle, or per s. Between two moves each of these, and ``to``, may be a range [low, high], or be left out: it is
    then as for the least mean-square jerk. Where a jerk is asked for, the jerk of moves that follow each other is
    continuous too (degree 7). ``through`` are conditions on the way (``Through``), which the motion of the least
    mean-square jerk meets, and all that ``synthesise`` finds.

    Where positions are given, the turn starts at the last of them. Designs count displacements from the lowest
    position of the turn, which is on the base circle.
    """

    segment: Literal["rise", "dwell", "return", "move", "constant-velocity"]
    angle: Annotated[Number, Field(ge=0, le=360 * (1 + 1e-9))]
    lift: Annotated[Number, Field(ge=0, le=LONGEST)] = 0.0
    law: LawName | None = None
    to: Asked | None = None
    velocity: Asked | None = None
    acceleration: Asked | None = None
    jerk: Asked | None = None
    per: Literal["rad", "deg", "s"] = "rad"
    through: Annotated[tuple[Through, ...], Field(max_length=MOST_CONDITIONS)] = ()


class Element(Table):
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

    element: Literal["arc", "line"]
    radius: Anywhere | None = None
    x: Anywhere | None = None
    y: Anywhere | None = None


def _is_pair(value: Any) -> Any:
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError("two numbers")
    return tuple(_is_number(v) for v in value)


Numbers = Annotated[tuple[Anywhere, ...], Field(min_length=1)]


class OwnLaw(Table):
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
      ``rest`` says ("start", "end", "none"); at an end that does not rest it has the least mean-square jerk. The
      ``status`` of its verdicts is "sampled", for the motion between the points is not known. A function ``f`` of
      Python is given as points too: ``x = [k / 200 for k in range(201)]`` and ``s = [f(v) for v in x]``.

    ``crossing`` is where the acceleration of a symmetric law crosses zero in place of ½; ``peaks = [a, d]`` puts it
    where the largest acceleration is to the largest deceleration as a to d. ``overshoot`` allows s below 0 or above
    1; the lowest of the turn is on the base circle.

    A rise follows y = lift·s(x), a return y = lift·(1 − s(x)): each starts as the law starts. ``mirror`` takes
    1 − s(1 − x) in place of s(x). On a return it then retraces the rise with the law as it was given, backwards.
    """

    law: LawName | None = None
    scca: Numbers | None = None
    start: Numbers | None = None
    end: Numbers | None = None
    degree: Annotated[int, BeforeValidator(is_whole), Field(ge=DEGREES[0], le=DEGREES[-1])] | None = None
    knots: Numbers | None = None
    coefficients: Numbers | None = None
    positions: Numbers | None = None
    x: Numbers | None = None
    s: Numbers | None = None
    file: str | None = None
    rest: Literal["both", "start", "end", "none"] | None = None
    crossing: Number | None = None
    peaks: Annotated[tuple[Positive, Positive], BeforeValidator(_is_pair)] | None = None
    mirror: Switch = False
    overshoot: Switch = False


class Limits(Table):
    """What the cam must hold, each optional: deg, mm, m/s, m/s², m/s³ (oscillating: rad), N, rpm, MPa, N·m, W.

    ``pressure_angle`` holds for rises, dwells and returns; ``pressure_angle_return`` replaces it for returns alone.
    ``face_reach`` bounds both sides of a flat face, ``outer_radius`` the reach of a disc cam from its axis.
    ``cutter_radius`` is that of a cutter or grinding wheel that has to reach every hollow flank. Of the part:
    ``area`` in mm², ``cam_mass`` in kg, ``cam_inertia`` in kg·m², ``unbalance`` in g·mm, the change of the lift in
    mm (deg) by degree of the cam, ``hub_wall`` in mm, at least.
    """

    pressure_angle: Acute | None = None
    pressure_angle_return: Acute | None = None
    curvature_radius: Length | None = None
    face_reach: Length | None = None
    outer_radius: Length | None = None
    cutter_radius: Length | None = None
    lift_change: Positive | None = None
    hub_wall: Length | None = None
    area: Positive | None = None
    cam_mass: Positive | None = None
    cam_inertia: Positive | None = None
    unbalance: Positive | None = None
    velocity: Positive | None = None
    acceleration: Positive | None = None
    jerk: Positive | None = None
    contact_force_min: Anywhere | None = None
    jump_speed: Positive | None = None
    normal_force: Positive | None = None
    side_thrust: Positive | None = None
    guide_reaction: Positive | None = None
    stem_bending_stress: Positive | None = None
    jamming_margin: Annotated[Number, Field(ge=0, le=1)] | None = None
    contact_stress: Positive | None = None
    wear: Positive | None = None
    sliding_speed: Positive | None = None
    film_ratio: Positive | None = None
    residual_vibration: Positive | None = None
    lash_speed: Positive | None = None
    contact_force_elastic: Anywhere | None = None
    torque: Positive | None = None
    power: Positive | None = None


def as_list(value: Any) -> Any:
    return [value] if isinstance(value, (Real, str)) and not isinstance(value, bool) else value


Outputs = Annotated[
    tuple[Annotated[str, _known((*QUANTITIES, *DISCIPLINES, EVERYTHING), "a quantity, an effect or all")], ...],
    BeforeValidator(as_list),
]
Quantities = Annotated[tuple[QuantityName, ...], BeforeValidator(as_list)]


def _is_peak(value: Any) -> Any:
    """A peak factor: ± a number, a range that holds 0, or that of a law, by name."""
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple)):
        pair = _is_pair(value)
        if not -LONGEST <= pair[0] <= 0.0 < pair[1] <= LONGEST:
            raise ValueError("a range with 0 in it")
        return pair
    number = _is_number(value)
    if not 0.0 < number <= LONGEST:
        raise ValueError("a number above 0, a range or the name of a law")
    return number


TERMS = ("size", "velocity", "acceleration", "jerk", "acceleration_rms", "jerk_rms", "residual_vibration")
PeakAsked = Annotated[float | tuple[float, float] | str, BeforeValidator(_is_peak)] | None
Term = Annotated[str, _known(TERMS, "a term of the objective")]
Points = tuple[Annotated[tuple[float, float], BeforeValidator(_is_pair)], ...]


class Synthesis(Table):
    """What free motion laws minimise and hold, beside ``[limits]``.

    ``minimise`` is size (mm), velocity, acceleration or jerk (largest over the turn), acceleration_rms or jerk_rms
    (root mean square over the turn), residual_vibration (in a dwell), or a table of weights for several; units are
    those of ``[limits]``, or by the cam angle without a speed. ``peak_velocity``, ``peak_acceleration``,
    ``peak_jerk`` bound the unit stroke of rises and returns, as `camopt laws` lists them: a number for ±, a range,
    or the name of a law that has as much. Where neither these nor ``[limits]`` bound acceleration or jerk, each
    that is not minimised is held to poly345's, and in moves to 1.25 times what the scene's own have. ``rest`` is
    how many derivatives are zero beside a dwell, 2 at least where the jerk is bounded or minimised. ``points`` are
    (cam angle in deg, displacement in mm) that the motion goes through. A ``symmetric`` motion is its own mirror
    image, about a cam angle that the segments allow. ``smooth`` is the share of the objective (0.01 for 1 %) that
    is given up for the least variation of the jerk, which rings less. Laws are B-splines of a ``degree`` in so many
    ``pieces`` a stroke, with ``continuity`` continuous derivatives (one less than the degree if not given).
    """

    minimise: Annotated[
        Annotated[Term, Tag("range/")] | Annotated[dict[Term, Positive], Field(min_length=1), Tag("values/")],
        Discriminator(lambda value: TAGS[isinstance(value, dict)]),
    ] = "size"
    peak_velocity: PeakAsked = None
    peak_acceleration: PeakAsked = None
    peak_jerk: PeakAsked = None
    rest: Annotated[int, BeforeValidator(is_whole), Field(ge=1, le=3)] = 2
    monotone: Switch = False
    symmetric: Switch = False
    smooth: Annotated[Number, Field(ge=0, le=1)] = 0.0
    points: Points = ()
    degree: Annotated[int, BeforeValidator(is_whole), Field(ge=4, le=9)] = 5
    pieces: Annotated[int, BeforeValidator(is_whole), Field(ge=2, le=200)] = 48
    continuity: Annotated[int, BeforeValidator(is_whole), Field(ge=2, le=8)] | None = None


class Materials(Table):
    """Bodies in contact: names of materials, or moduli in GPa and Poisson's ratios; face width in mm.

    Wear rate of the cam in mm²/N, viscosity of the lubricant in Pa·s and its pressure coefficient in 1/GPa,
    composite roughness (root mean square) in µm.
    """

    cam: MaterialName | None = None
    follower: MaterialName | None = None
    cam_modulus: Positive | None = None
    cam_poisson: Annotated[Number, Field(ge=0, lt=0.5)] | None = None
    follower_modulus: Positive | None = None
    follower_poisson: Annotated[Number, Field(ge=0, lt=0.5)] | None = None
    face_width: Length | None = None
    wear_rate: Positive | None = None
    viscosity: Positive | None = None
    pressure_viscosity: Positive | None = None
    roughness: Positive | None = None


class Accuracy(Table):
    """Relative error allowed in each reported value."""

    tolerance: Annotated[Number, Field(ge=1e-14, le=1e-2)] = 1e-9
