"""The scene: the question a user asks, validated when made. TOML in and out.

Keys, units (mm, deg, rev/min) and meaning are those of the scene file. Whatever is wrong with a scene is said
at once, a line for each mistake, as a BadInput.
"""

import os
import tomllib
from dataclasses import replace
from functools import cache
from importlib import resources
from numbers import Integral, Real
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import tomli_w
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PrivateAttr,
    Tag,
    ValidationError,
    model_validator,
)

from camopt.materials import MATERIALS
from camopt.mistakes import BadInput, Mistake, nearest
from camopt.own_laws import DEGREES, read_files
from camopt.quantities import DISCIPLINES, EVERYTHING, QUANTITIES
from camopt.scene_checks import check


def _is_number(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError("a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("a finite number") from None


LONGEST = 1e9
Number = Annotated[float, BeforeValidator(_is_number), Field(allow_inf_nan=False)]
Length = Annotated[Number, Field(ge=1e-9, le=LONGEST)]
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


def _one_line(value: Any) -> Any:
    if isinstance(value, str) and not value.isprintable():
        raise ValueError("a text of one line, of printable characters")
    return value


def _is_whole(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise ValueError("a whole number")
    return int(value)


def _is_name(value: Any) -> Any:
    if not isinstance(value, str):
        raise ValueError("the name of a motion law")
    return value


LawName = Annotated[str, BeforeValidator(_is_name)]
MaterialName = Annotated[str, _known(MATERIALS, "a material")]
QuantityName = Annotated[str, _known(QUANTITIES, "a quantity")]


class Table(BaseModel):
    """A table of a scene: unknown keys are mistakes, and nothing changes once made."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    def __init__(self, /, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise BadInput(mistakes_of(error, type(self), type(self).__name__.lower())) from None


class Cam(Table):
    """The cam: form, sense of rotation, speed (rev/min) and size (mm)."""

    form: Literal["disc", "cylindrical"]
    rotation: Literal["ccw", "cw"] = "ccw"
    rpm: Annotated[Number, Field(ge=1e-9, le=1e15)] | None = None
    base_radius: Length | None = None
    mean_radius: Length | None = None
    shaft_diameter: Length | None = None


class Dynamics(Table):
    """What moves with the follower, and what presses it on the cam.

    Translating: kg, N/mm, N, N·s/mm. Oscillating, about the pivot: inertia in kg·m² in place of the mass, N·m/rad,
    N·m, N·m·s/rad. ``load`` is a constant external force (moment) that presses the follower on the cam; ``gravity``
    the acceleration (m/s²) that does so to the mass. Guide, overhang, stem in mm, natural frequency in Hz.
    """

    mass: Positive | None = None
    inertia: Positive | None = None
    spring_rate: NotNegative | None = None
    preload: NotNegative | None = None
    damping: NotNegative | None = None
    load: Anywhere | None = None
    gravity: Anywhere | None = None
    guide_length: Length | None = None
    overhang: NotNegative | None = None
    friction: NotNegative | None = None
    stem_diameter: Length | None = None
    natural_frequency: Positive | None = None
    damping_ratio: Annotated[Number, Field(ge=0, lt=1)] | None = None
    fluctuation: Positive | None = None


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


class Segment(Table):
    """One segment of the turn: cam angle in deg, lift in mm (deg when oscillating), motion law."""

    segment: Literal["rise", "dwell", "return"]
    angle: Annotated[Number, Field(ge=0, le=360 * (1 + 1e-9))]
    lift: Annotated[Number, Field(ge=0, le=LONGEST)] = 0.0
    law: LawName | None = None


Numbers = Annotated[tuple[Anywhere, ...], Field(min_length=1)]


class OwnLaw(Table):
    """A motion law of the scene's own on the unit stroke, 0 ≤ s ≤ 1 for 0 ≤ x ≤ 1: a B-spline or a table.

    A B-spline has a ``degree`` from 3 to 12, clamped ``knots`` (degree + 1 zeros first, as many ones last) and
    ``coefficients``; it is exact. A table has points ``x`` and ``s``, or a CSV ``file`` with these columns (a path
    relative to the scene file), read when the scene is made. Its law is the quintic spline through the points, at
    rest at both ends; the ``status`` of its verdicts is "sampled", for the motion between the points is not known.
    A function ``f`` of Python is given as points too: ``x = [k / 200 for k in range(201)]`` and
    ``s = [f(v) for v in x]``.
    """

    degree: Annotated[int, BeforeValidator(_is_whole), Field(ge=DEGREES[0], le=DEGREES[-1])] | None = None
    knots: Numbers | None = None
    coefficients: Numbers | None = None
    x: Numbers | None = None
    s: Numbers | None = None
    file: str | None = None


class Limits(Table):
    """What the cam must hold, each optional: deg, mm, m/s, m/s², m/s³ (oscillating: rad), N, rpm, MPa, N·m, W."""

    pressure_angle: Acute | None = None
    pressure_angle_return: Acute | None = None
    curvature_radius: Length | None = None
    face_reach: Length | None = None
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
    contact_force_elastic: Anywhere | None = None
    torque: Positive | None = None
    power: Positive | None = None


class Range(Table):
    """A closed interval; the step matters to a sweep alone."""

    start: Anywhere
    stop: Anywhere
    step: Length | None = None

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.stop < self.start:
            raise ValueError("a range whose stop is not below its start")
        return self


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, (Real, str)) and not isinstance(value, bool) else value


Values = Annotated[tuple[Anywhere, ...], Field(min_length=1), BeforeValidator(_as_list)]
Laws = Annotated[tuple[LawName, ...], Field(min_length=1), BeforeValidator(_as_list)]
Outputs = Annotated[
    tuple[Annotated[str, _known((*QUANTITIES, *DISCIPLINES, EVERYTHING), "a quantity, an effect or all")], ...],
    BeforeValidator(_as_list),
]
Quantities = Annotated[tuple[QuantityName, ...], BeforeValidator(_as_list)]
TAGS = ("range/", "values/")  # parts of a location in pydantic's errors that are no keys; no law has a slash
Choice = (
    Annotated[
        Annotated[Range, Tag("range/")] | Annotated[Values, Tag("values/")],
        Discriminator(lambda value: TAGS[not isinstance(value, (dict, Range))]),
    ]
    | None
)


class Search(Table):
    """What a sweep or an optimisation may vary, and its objectives. A size is a Range or a list of values."""

    base_radius: Choice = None
    mean_radius: Choice = None
    offset: Choice = None
    roller_radius: Choice = None
    face_radius: Choice = None
    arm_length: Choice = None
    centre_distance: Choice = None
    face_offset: Choice = None
    law: Laws = ()
    law_rise: Laws = ()
    law_return: Laws = ()
    minimise: Quantities = ()
    maximise: Quantities = ()


def _is_pair(value: Any) -> Any:
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError("two numbers")
    return tuple(_is_number(v) for v in value)


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


TERMS = ("size", "velocity", "acceleration", "jerk", "acceleration_rms", "jerk_rms")
Peak = Annotated[float | tuple[float, float] | str, BeforeValidator(_is_peak)] | None
Term = Annotated[str, _known(TERMS, "a term of the objective")]
Points = tuple[Annotated[tuple[float, float], BeforeValidator(_is_pair)], ...]


class Synthesis(Table):
    """What free motion laws minimise and hold, beside ``[limits]``.

    ``minimise`` is size (mm), velocity, acceleration or jerk (largest over the turn), acceleration_rms or jerk_rms
    (root mean square over the turn), or a table of weights for several; units are those of ``[limits]``, or by the
    cam angle without a speed. ``peak_velocity``, ``peak_acceleration``, ``peak_jerk`` bound the unit stroke, as
    `camopt laws` lists them: a number for ±, a range, or the name of a law that has as much. Where neither these
    nor ``[limits]`` bound acceleration or jerk, each that is not minimised is held to poly345's. ``rest`` is how
    many derivatives are zero beside a dwell, 2 at least where the jerk is bounded or minimised. ``points`` are (cam
    angle in deg, displacement in mm) that the motion goes through. Laws are B-splines of a ``degree`` in so many
    ``pieces`` a stroke, with ``continuity`` continuous
    derivatives (one less than the degree if not given).
    """

    minimise: Annotated[
        Annotated[Term, Tag("range/")] | Annotated[dict[Term, Positive], Field(min_length=1), Tag("values/")],
        Discriminator(lambda value: TAGS[isinstance(value, dict)]),
    ] = "size"
    peak_velocity: Peak = None
    peak_acceleration: Peak = None
    peak_jerk: Peak = None
    rest: Annotated[int, BeforeValidator(_is_whole), Field(ge=1, le=3)] = 2
    monotone: bool = False
    points: Points = ()
    degree: Annotated[int, BeforeValidator(_is_whole), Field(ge=4, le=9)] = 5
    pieces: Annotated[int, BeforeValidator(_is_whole), Field(ge=2, le=200)] = 48
    continuity: Annotated[int, BeforeValidator(_is_whole), Field(ge=2, le=8)] | None = None


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


class Scene(Table):
    """A whole question. Made from tables, from TOML (``from_toml``) or from a mapping (``from_dict``).

    Raises
    ------
    BadInput
        With every mistake, when the scene is made.
    """

    name: Annotated[str, BeforeValidator(_one_line)] = "scene"
    cam: Cam
    follower: Follower
    motion: Annotated[tuple[Segment, ...], Field(min_length=1)]
    laws: dict[str, OwnLaw] = Field(default_factory=dict)
    limits: Limits = Limits()
    search: Search = Search()
    synthesis: Synthesis = Synthesis()
    materials: Materials = Materials()
    accuracy: Accuracy = Accuracy()
    outputs: Outputs = ()
    _file: str = PrivateAttr("scene")

    @property
    def file(self) -> str:
        """Where the scene comes from, as messages call it."""
        return self._file

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __init__(self, /, **values: Any) -> None:
        self._fill(values, str(values.get("name", "scene")))

    def _fill(self, values: dict[str, Any], file: str, folder: Path = Path()) -> None:
        plain = _plain(values)
        unread = list(read_files(plain, folder))
        found: list[Mistake] = []
        try:
            BaseModel.__init__(self, **plain)
        except ValidationError as error:
            found = mistakes_of(error, Scene, "", file)
        keys = {mistake.key for mistake in found}
        found += [Mistake(file, *fault, bare=True) for fault in (*unread, *check(plain)) if fault[0] not in keys]
        if found:
            raise BadInput(found)
        self._file = file

    @classmethod
    def from_dict(cls, data: dict[str, Any], file: str = "scene") -> "Scene":
        """A scene from nested mappings with the keys of a scene file; ``file`` is named in messages.

        Files of laws are looked for in the current folder.
        """
        if not isinstance(data, dict):
            raise BadInput([Mistake(file, "scene", data, "a mapping of tables")])
        scene = cls.__new__(cls)
        scene._fill(data, file)
        return scene

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> "Scene":
        """A scene from a TOML file."""
        try:
            data = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
        except (ValueError, RecursionError) as error:  # not TOML, not UTF-8, numbers or nesting without end
            raise BadInput([Mistake(os.fspath(path), "TOML", None, f"not valid: {error}", bare=True)]) from None
        scene = cls.__new__(cls)
        scene._fill({"name": Path(path).stem, **data}, os.fspath(path), Path(path).parent)
        return scene

    def to_dict(self) -> dict[str, Any]:
        """Nested plain mappings without what was left at its default; ``from_dict`` gives an equal scene."""
        data = self.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
        return {"name": self.name, **{key: value for key, value in data.items() if value not in ({}, [])}}

    def to_toml(self) -> str:
        """The scene as TOML text; parsed, it gives an equal scene."""
        return tomli_w.dumps(self.to_dict())

    def replace(self, **changes: Any) -> "Scene":
        """The scene with changes by dotted key, such as ``replace(**{"cam.rpm": 1000})``; None clears a key."""
        data = self.to_dict()
        for key, value in changes.items():
            *tables, last = key.split(".")
            table = data
            for name in tables:
                table = table.setdefault(name, {})
                if not isinstance(table, dict):
                    raise BadInput(
                        [Mistake(self.file, key, value, f"{name} is no table: give it whole", bare=True)]
                    )
            if value is None:
                table.pop(last, None)
            else:
                table[last] = _plain(value)
        return Scene.from_dict(data, self.file)


def _plain(value: Any) -> Any:
    """Tables as mappings and tuples as lists, so that Python and TOML input are checked alike."""
    if isinstance(value, BaseModel):
        return _plain(value.model_dump(exclude_none=True, exclude_defaults=True))
    if isinstance(value, dict):
        return {str(key): _plain(each) for key, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, (list, tuple)) else value


def mistakes_of(error: ValidationError, model: type[BaseModel], prefix: str, file: str = "scene") -> list[Mistake]:
    """Pydantic's errors as mistakes: one for each key, in plain words."""
    found: dict[str, Mistake] = {}
    for each in error.errors():
        *tables, last = each["loc"] or TAGS[:1]
        unknown = each["type"] == "extra_forbidden"  # then the last part is a key of the user, whatever it says
        where = (*(p for p in tables if p not in TAGS), *([last] if unknown or last not in TAGS else []))
        parts = [str(p + 1) if isinstance(p, int) else p for p in where]
        key = ".".join([prefix, *parts] if prefix else parts)
        within = each.get("ctx", {}).get("error")
        if isinstance(within, BadInput):  # of a table inside this one, which gave its keys its own name
            for mistake in within.mistakes:
                name = ".".join([key, *mistake.key.split(".")[1:]])
                found.setdefault(name, replace(mistake, file=file, key=name))
        elif each["type"] != "too_short" or not each["input"]:  # a list of mistakes is not empty
            found.setdefault(key, _mistake(each, where, model, key, file))
    return list(found.values())


def _mistake(each: Any, where: tuple[str | int, ...], model: type[BaseModel], key: str, file: str) -> Mistake:
    kind, value, context = each["type"], each["input"], each.get("ctx", {})
    if kind == "extra_forbidden":
        known = list(_table_at(model, where[:-1]).model_fields)
        return Mistake(file, key, value, f"not a known key; {nearest(str(where[-1]), known)}", bare=True)
    if kind == "missing":
        return Mistake(file, key, None, "missing", bare=True)
    if kind == "literal_error":
        return Mistake(file, key, value, f"one of {context['expected']}")
    if kind == "value_error":
        return Mistake(file, key, value, str(context["error"]))
    words = {
        "greater_than": "above",
        "greater_than_equal": "at least",
        "less_than": "below",
        "less_than_equal": "at most",
    }
    if kind in words:
        bound = next(iter(context.values()))
        return Mistake(file, key, value, f"{words[kind]} {bound:g}")
    plain = {
        "finite_number": "a finite number",
        "model_type": "a table",
        "dict_type": "a table",
        "model_attributes_type": "a table",
        "tuple_type": "a list",
        "string_type": "a text",
        "string_unicode": "a text",
        "too_short": "a list of at least one value",
    }
    return Mistake(file, key, value, plain.get(kind, each["msg"].lower()))


def _table_at(model: type[BaseModel], where: tuple[str | int, ...]) -> type[BaseModel]:
    """The table that a path of keys leads to."""
    parts = iter(where)
    for part in parts:
        if isinstance(part, int):
            continue
        annotation: Any = model.model_fields[part].annotation
        candidates = [annotation, *getattr(annotation, "__args__", ())]
        model = next(c for c in candidates if isinstance(c, type) and issubclass(c, BaseModel))
        if getattr(annotation, "__origin__", None) is dict:
            next(parts, None)  # a name that the user chose
    return model


@cache
def shipped_scenes() -> tuple[str, ...]:
    """The names of the scenes that come with the package."""
    folder = resources.files("camopt") / "scenes"
    return tuple(
        sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))
    )


def shipped_toml(name: str) -> str:
    """The text of a shipped scene."""
    return (resources.files("camopt") / "scenes" / f"{name}.toml").read_text(encoding="utf-8")


def find_scene(name: str) -> Scene:
    """A scene by the path of its file, or by the name of a shipped one."""
    if name in shipped_scenes():
        return Scene.from_dict(tomllib.loads(shipped_toml(name)), name)
    if Path(name).is_file():
        return Scene.from_toml(name)
    allowed = f"a TOML file or a shipped scene; {nearest(name, shipped_scenes())}"
    raise BadInput([Mistake("camopt", "SCENE", name, allowed)])
