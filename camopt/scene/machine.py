"""``Machine``: several scenes that turn together, read from TOML and checked when it is made.

Angles are those of the machine's shaft, which turns once in a cycle. A station is a scene whose cam starts its turn
at ``phase`` and turns ``ratio`` times in a cycle. A wrong machine raises one BadInput with all mistakes, those of
its scenes included.
"""

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import tomli_w
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PrivateAttr, ValidationError

from camopt.core.mistakes import BadInput, Mistake, escape_unprintable, suggest_names
from camopt.core.quantities.display import Drawable
from camopt.core.quantities.key import NO_UNIT, Key
from camopt.core.storage.files import read_bytes
from camopt.scene.csv_columns import MOST_SPANS
from camopt.scene.law_forms import NEAR_END, Fault
from camopt.scene.mapping import tables_in_list
from camopt.scene.motors import MotorData, read_motors
from camopt.scene.part import TOWARDS_FOLLOWER
from camopt.scene.pydantic_mistakes import mistakes_from_pydantic
from camopt.scene.scene import Scene, find_scene
from camopt.scene.sources import MACHINES, path_beside_machine, shipped_machines
from camopt.scene.speed import CRANK_SPEED_KEY, TURNS_OF_CRANK
from camopt.scene.table_places import TOP_TABLE
from camopt.scene.table_shapes import replace_wrong_shapes
from camopt.scene.tables import (
    LARGEST_VALUE,
    SLOWEST_RPM,
    BoundedNumber,
    InnerTable,
    NotNegative,
    Positive,
    SceneTable,
    SignedNumber,
    check_number,
    check_one_line,
    check_two_numbers,
    check_whole_number,
    type_validator,
)
from camopt.scene.toml_text import has_unit_text, parse_toml, plain_mappings_and_lists
from camopt.scene.units import replace_unit_texts

MOST_STATIONS, MOST_TURNS = 50, 100
MACHINE_WORDS = "a machine's TOML file or a shipped machine"
STATION_TABLE = "station"
"""The table that makes a TOML file a machine."""


def _check_outline(value: Any) -> tuple[tuple[float, ...], ...]:
    """The points of an outline."""
    if not isinstance(value, (list, tuple)) or not 1 <= len(value) <= MOST_SPANS:
        raise ValueError(f"a list of 1 to {MOST_SPANS} points [x, y]")
    points = tuple(check_two_numbers(each) for each in value)
    if any(not isfinite(each) or abs(each) > LARGEST_VALUE for point in points for each in point):
        raise ValueError("a list of points [x, y] with finite numbers")
    return points


def _check_range_of_angles(value: Any) -> tuple[float, float]:
    start, end = check_two_numbers(value)
    if not (
        isfinite(start) and isfinite(end) and 0.0 < end - start <= 360.0 + NEAR_END and abs(start) <= LARGEST_VALUE
    ):
        raise ValueError("two angles, the second above the first and at most 360 deg more")
    return start, end


def _check_coefficients(value: Any) -> tuple[float, ...]:
    if not isinstance(value, (list, tuple)) or not value:
        raise ValueError("a list of numbers, one for each station in between")
    return tuple(check_number(each) for each in value)


Point = tuple[float, float]
Outline = Annotated[tuple[Point, ...], BeforeValidator(_check_outline)]
AngleRange = Annotated[tuple[float, float], BeforeValidator(_check_range_of_angles)]
MachineName = Annotated[str, BeforeValidator(check_one_line), Field(min_length=1)]


class Body(SceneTable):
    """A fixed body of the machine that tools must clear.

    The outline is a point, a line or a closed polygon in the plane of the machine, rounded by ``outline_radius``:
    a single point with a radius is a circle.
    """

    name: Annotated[MachineName, Key("Name of the body")]
    outline: Annotated[Outline, Key("Points [x, y] of the body's outline, in order", "mm")]
    outline_radius: Annotated[NotNegative, Key("Radius that rounds the outline outward", "mm")] = 0.0


class Station(SceneTable):
    """A station of the machine: a cam, its follower and tool, and their place in the machine's cycle.

    The tool may have an outline, which moves with it: along ``direction`` if the tool slides, about ``pivot`` if it
    turns. The outline is given where the tool is lowest.
    """

    name: Annotated[MachineName, Key("Name of the station")]
    scene: Annotated[
        str | dict[str, Any],
        BeforeValidator(
            type_validator((str, dict), "the path of a scene's TOML file, the name of a shipped scene, or a table")
        ),
        Key("The station's scene: the path of its file, relative to the machine's; a shipped scene; or a table"),
    ]
    phase: Annotated[
        SignedNumber, Key("Angle of the machine's shaft at which the turn of the cam starts", "deg")
    ] = 0.0
    ratio: Annotated[
        Annotated[int, BeforeValidator(check_whole_number), Field(ge=1, le=MOST_TURNS)],
        Key("Turns of the cam in a cycle of the machine"),
    ] = 1
    follower_angle: Annotated[
        SignedNumber,
        Key("Direction from the shaft in which the follower stands, ccw from x: the y of its drawing", "deg"),
    ] = TOWARDS_FOLLOWER
    outline: Annotated[Outline | None, Key("Points [x, y] of the tool's outline, in order", "mm")] = None
    outline_radius: Annotated[NotNegative, Key("Radius that rounds the outline outward", "mm")] = 0.0
    direction: Annotated[
        SignedNumber | None, Key("Direction in which a sliding tool leaves its lowest position", "deg")
    ] = None
    pivot: Annotated[
        Annotated[Point, BeforeValidator(check_two_numbers)] | None,
        Key("Point [x, y] about which a tool turns", "mm"),
    ] = None
    sense: Annotated[Literal["ccw", "cw"], Key("Sense in which a turning tool leaves its lowest position")] = "ccw"


class Clearance(SceneTable):
    """A clearance that the machine must hold.

    With ``along``, it is a linear form of the lifts of stations: the sum of ``along`` times lift is at least
    ``at_least``. A lift counts from the tool's lowest position. Without ``along``, it is the distance between the
    outlines of two stations or bodies.
    """

    name: Annotated[str, BeforeValidator(check_one_line), Key("Name of the clearance")] = ""
    between: Annotated[
        tuple[str, ...],
        Field(min_length=1, max_length=MOST_STATIONS),
        Key("Names of the stations, or of two stations or bodies with outlines"),
    ]
    along: Annotated[
        tuple[SignedNumber, ...] | None,
        BeforeValidator(_check_coefficients),
        Key("Coefficient of each station's lift", NO_UNIT),
    ] = None
    at_least: Annotated[SignedNumber, Key("Least clearance", "mm")] = 0.0
    angles: Annotated[AngleRange, Key("Range of the machine's angle in which it must be held", "deg")] = (
        0.0,
        360.0,
    )

    @property
    def title(self) -> str:
        """The name, or else the names of the stations."""
        return self.name or " – ".join(self.between)


class Flywheel(SceneTable):
    """What keeps the shaft's speed even."""

    fluctuation: Annotated[
        Annotated[float, BoundedNumber(gt=0, lt=2)] | None,
        Key("Largest allowed (highest − lowest)/mean of the shaft's speed", NO_UNIT),
    ] = None
    inertia: Annotated[Positive | None, Key("Moment of inertia on the shaft", "kg·m²")] = None


class Motor(SceneTable):
    """The motors to choose from, and what the chosen one must do."""

    catalogue: Annotated[
        str,
        Key(
            "CSV file of motors with the columns name, rated_torque_N_m, peak_torque_N_m, rated_speed_rpm and "
            "inertia_kg_m2; its path is relative to the machine's file"
        ),
    ]
    gear: Annotated[Positive, Key("Turns of the motor in a turn of the shaft", NO_UNIT)] = 1.0
    efficiency: Annotated[Annotated[float, BoundedNumber(gt=0, le=1)], Key("Efficiency of the gear", NO_UNIT)] = 1.0
    inertia_ratio: Annotated[
        Positive | None, Key("Largest ratio of the load's inertia to the motor's, at the motor", NO_UNIT)
    ] = None


class PhaseSearch(SceneTable):
    """Phases that may change, to find the least peak torque."""

    phase: Annotated[dict[str, AngleRange], Key("Range of the phase of stations, by name", "deg")] = Field(
        default_factory=dict
    )


class Machine(Drawable, SceneTable):
    """Several scenes that turn together, made from tables, from TOML (``from_toml``) or a mapping (``from_dict``).

    Parameters
    ----------
    name : str, default "machine"
        Title of results and pictures.
    rpm : float, optional
        Speed of the machine's shaft [rev/min], one turn a cycle. It replaces the speeds of the scenes. Without it,
        the speed follows from the first scene that has one.
    rpm_of_crank : float, optional
        Speed of a crankshaft that turns twice for each turn of the machine's shaft [rev/min], in place of ``rpm``.
    station : tuple of Station
        The cams of the machine.
    body : tuple of Body
        Fixed bodies that tools must clear.
    clear : tuple of Clearance
        The clearances that the machine must hold.
    flywheel : Flywheel
        What keeps the speed even.
    motor : Motor, optional
        The motors to choose from.
    search : PhaseSearch
        Phases that may change.

    Raises
    ------
    BadInput
        When the machine is made; it has every mistake, those of the scenes included.

    Examples
    --------
    >>> machine = camopt.find_machine("pick-and-place")
    >>> [station.name for station in machine.station][:2]
    ['lift', 'swing']
    """

    model_config = ConfigDict(defer_build=False)
    picture: ClassVar[str] = "machines.timing_sheet"
    elsewhere: ClassVar[Mapping[str, str]] = {
        "cam": "not a key of a machine: it belongs to the scene of a station",
        "motion": "not a key of a machine: it belongs to the scene of a station",
    }
    name: Annotated[MachineName, Key("Title of results and pictures")] = "machine"
    rpm: Annotated[
        Annotated[float, BoundedNumber(ge=SLOWEST_RPM, le=1e7)] | None,
        Key("Speed of the machine's shaft, in place of the speeds of the scenes", "rev/min"),
    ] = None
    rpm_of_crank: Annotated[
        Annotated[float, BoundedNumber(ge=SLOWEST_RPM, le=1e7)] | None,
        Key(
            "Speed of a crankshaft that turns twice for each turn of the machine's shaft, in place of `rpm`",
            "rev/min",
        ),
    ] = None
    station: Annotated[
        tuple[InnerTable[Station], ...],
        Field(min_length=1, max_length=MOST_STATIONS),
        Key("The stations of the machine"),
    ]
    body: Annotated[
        tuple[InnerTable[Body], ...], Field(max_length=MOST_STATIONS), Key("Fixed bodies that tools must clear")
    ] = ()
    clear: Annotated[
        tuple[InnerTable[Clearance], ...],
        Field(max_length=MOST_STATIONS**2),
        Key("Clearances that the machine must hold"),
    ] = ()
    flywheel: Annotated[InnerTable[Flywheel], Key("What keeps the speed even")] = Flywheel.model_construct()
    motor: Annotated[InnerTable[Motor] | None, Key("The motors to choose from")] = None
    search: Annotated[InnerTable[PhaseSearch], Key("What a search may vary")] = PhaseSearch.model_construct(
        phase={}
    )
    _file: str = PrivateAttr("machine")
    _folder: Path | None = PrivateAttr(None)
    _scenes: Mapping[str, Scene] = PrivateAttr(default_factory=dict)
    _motors: tuple[MotorData, ...] = PrivateAttr(())
    _speed_notes: tuple[str, ...] = PrivateAttr(())

    def __init__(self, /, **values: Any) -> None:
        self._fill_and_check(values, str(values.get("name", "machine")), Path())

    def _fill_and_check(self, values: dict[str, Any], file: str, folder: Path | None) -> None:
        tables = plain_mappings_and_lists(values, file)
        mistakes = [*replace_wrong_shapes(tables, MACHINE_TABLES, file)]
        if has_unit_text({key: value for key, value in tables.items() if key != "name"}):
            tables, unit_mistakes = replace_unit_texts(tables, MACHINE_TABLES, file)
            mistakes += unit_mistakes
        try:
            BaseModel.__init__(self, **tables)
        except ValidationError as error:
            known = {mistake.key for mistake in mistakes}
            mistakes += [each for each in mistakes_from_pydantic(error, Machine, "", file) if each.key not in known]
        is_sound, keys = not mistakes, [mistake.key for mistake in mistakes]
        scenes, scene_mistakes = _scenes_of_stations(tables_in_list(tables.get("station")), keys, file, folder)
        mistakes += scene_mistakes
        motor, motors = tables.get("motor"), tuple[MotorData, ...]()
        if isinstance(motor, dict) and isinstance(catalogue := motor.get("catalogue"), str):
            try:
                motors = read_motors(folder, catalogue)
            except ValueError as trouble:
                mistakes.append(Mistake(file, "motor.catalogue", catalogue, str(trouble), bare=True))
        if is_sound:
            mistakes += [
                Mistake(file, key, value, why, bare=True)
                for key, value, why in _faults_across_stations(self, scenes)
            ]
        if mistakes:
            raise BadInput(mistakes)
        self._file, self._folder, self._motors = file, folder, motors
        self._scenes = {each.name: scene for each, scene in zip(self.station, scenes, strict=True) if scene}
        self._speed_notes = tuple(_speed_notes(self, self._scenes))
        if self.shaft_rpm is not None:
            for station in self.station:
                if self._scenes[station.name].cam.rpm != (rpm := self.shaft_rpm * station.ratio):
                    self._scenes[station.name] = scene_at_speed(self._scenes[station.name], rpm)

    @classmethod
    def from_dict(cls, data: dict[str, Any], file: str = "machine") -> "Machine":
        """A machine from nested mappings with the keys of a machine's file.

        Paths are relative to the current folder.
        """
        if not isinstance(data, dict):
            raise BadInput([Mistake(file, "machine", data, "a mapping of tables")])
        machine = cls.__new__(cls)
        machine._fill_and_check(data, file, Path())
        return machine

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> "Machine":
        """A machine from a TOML file; paths in it are relative to the file.

        Raises
        ------
        BadInput
            For all mistakes in the file and in the files of its scenes.
        OSError
            If the file does not exist or cannot be read.
        """
        name = os.fsdecode(path)
        return cls._read(name, name)

    @classmethod
    def _read(cls, path: str, file: str) -> "Machine":
        """The machine of a TOML file that messages and results call ``file``."""
        machine = cls.__new__(cls)
        data = {"name": escape_unprintable(Path(path).stem), **parse_toml(read_bytes(path), file)}
        machine._fill_and_check(data, file, Path(path).parent)
        return machine

    @property
    def file(self) -> str:
        """The path of the machine's file, or the name that messages use where the machine was not read from one."""
        return self._file

    @property
    def folder(self) -> Path | None:
        """The folder that paths in the machine are relative to."""
        return self._folder

    @property
    def scenes(self) -> Mapping[str, Scene]:
        """The scene of each station by name, at the speed of the machine."""
        return self._scenes

    @property
    def keyed_scenes(self) -> dict[str, Scene]:
        """The scenes with the keyways turned so that one key of the shaft fits all disc cams of ratio 1.

        At the angle 0 of the shaft, a cam that turns ccw is φ behind its cam angle 0, φ being its phase. So a
        keyway at the angle k of its drawing is at k + f − 90° − φ, with the direction f of the follower. The first
        keyed cam keeps its keyway; the others have the k of the same direction.
        """
        keyed, scenes = None, dict(self._scenes)
        for station in self.station:
            scene = scenes[station.name]
            part, sense = scene.whole_part, 1.0 if scene.cam.rotation == "ccw" else -1.0
            if not part.keyway_width or scene.mechanism.body.developed or station.ratio != 1:
                continue
            turned = station.follower_angle - TOWARDS_FOLLOWER - sense * station.phase
            if keyed is None:
                keyed = (TOWARDS_FOLLOWER if part.keyway_angle is None else part.keyway_angle) + turned
            scenes[station.name] = scene.replace(**{"part.keyway_angle": round((keyed - turned) % 360.0, 9)})
        return scenes

    @property
    def motors(self) -> tuple[MotorData, ...]:
        """The motors of the catalogue; empty without one."""
        return self._motors

    @property
    def shaft_rpm(self) -> float | None:
        """Speed of the machine's shaft [rev/min]; None if neither the machine nor its scenes have one."""
        speeds = (
            scene.cam.rpm / station.ratio
            for station, scene in zip(self.station, self._scenes.values(), strict=True)
            if scene.cam.rpm is not None
        )
        if self.rpm_of_crank is not None:
            return self.rpm_of_crank / TURNS_OF_CRANK
        return self.rpm if self.rpm is not None else next(speeds, None)

    @property
    def speed_notes(self) -> tuple[str, ...]:
        """Notes on scenes whose own speed the machine replaces although it has none of its own."""
        return self._speed_notes

    def to_dict(self) -> dict[str, Any]:
        """Nested plain mappings without default values."""
        return {"name": self.name, **self.model_dump(mode="json", exclude_none=True, exclude_defaults=True)}

    def with_files_inside(self) -> "Machine":
        """The machine with its scenes as tables, so that its text needs no scene files beside it."""
        stations = [
            station.model_copy(update={"scene": self._scenes[station.name].to_dict()}) for station in self.station
        ]
        catalogue = self.motor and str(((self._folder or Path()) / self.motor.catalogue).resolve())
        motor = self.motor and self.motor.model_copy(update={"catalogue": catalogue})
        return self.model_copy(update={"station": tuple(stations), "motor": motor})

    def with_phases(self, phases: Mapping[str, float]) -> "Machine":
        """The machine with other phases of some stations, by name [deg]."""
        stations = [
            station.model_copy(update={"phase": phases.get(station.name, station.phase)})
            for station in self.station
        ]
        return self.model_copy(update={"station": tuple(stations)})

    def to_toml(self) -> str:
        """The machine as TOML text."""
        return tomli_w.dumps(self.to_dict())

    def __repr__(self) -> str:
        speed = "" if self.shaft_rpm is None else f", {self.shaft_rpm:g} rev/min"
        return f"<Machine {self.name}: {', '.join(station.name for station in self.station)}{speed}>"

    __str__ = __repr__


MachineSource = Machine | str | os.PathLike[str]
"""A machine, the name of a shipped one, or the path of its TOML file."""
MACHINE_TABLES: dict[str, type[SceneTable]] = {
    TOP_TABLE: Machine,
    "station": Station,
    "body": Body,
    "clear": Clearance,
    "flywheel": Flywheel,
    "motor": Motor,
    "search": PhaseSearch,
}
"""Every table by its place in a machine."""


def _scenes_of_stations(
    stations: Sequence[Mapping[str, Any]], wrong_keys: Collection[str], file: str, folder: Path | None
) -> tuple[list[Scene | None], list[Mistake]]:
    """The scenes of stations, None where one cannot be read, and the mistakes in them."""
    scenes, mistakes = list[Scene | None](), list[Mistake]()
    for number, row in enumerate(stations, start=1):
        place = f"station.{number}.scene"
        scenes.append(None)
        if "scene" in row and place not in wrong_keys:
            try:
                scenes[-1] = _scene_of_station(row["scene"], place, file, folder)
            except BadInput as error:
                mistakes += error.mistakes
    return scenes, mistakes


def _scene_of_station(scene_or_path: Any, place: str, file: str, folder: Path | None) -> Scene:
    """The scene of a station: a table, the path of a file, or the name of a shipped scene."""
    if isinstance(scene_or_path, dict):
        return Scene.from_dict(scene_or_path, f"{file}: {place}")
    path = path_beside_machine(folder, scene_or_path)
    try:
        return find_scene(path if path.suffix == ".toml" or path.is_file() else scene_or_path)
    except BadInput as error:
        raise BadInput(
            Mistake(file, place, scene_or_path, each.allowed)
            if (each.file, each.key) == ("camopt", "scene")
            else each
            for each in error.mistakes
        ) from None


def _speed_notes(machine: Machine, scenes: Mapping[str, Scene]) -> Iterator[str]:
    """Notes on scenes that run at another speed than their own, where a reader may not expect it."""
    for station in machine.station:
        scene, shaft = scenes[station.name], machine.shaft_rpm
        if shaft is None or scene.cam.rpm in (None, speed := shaft * station.ratio):
            continue
        if machine.rpm is None and machine.rpm_of_crank is None:
            own = f"its scene has {scene.cam.rpm:g}"
            yield f"{station.name} turns at {speed:g} rev/min, by the first station with a speed; {own}"
        elif machine.rpm is not None and scene.is_speed_of_crank:
            why = "rpm is the speed of the machine's shaft; rpm_of_crank is that of its crankshaft"
            yield f"{station.name}: its scene gives the speed of a crankshaft. {why}"


def scene_at_speed(scene: Scene, rpm: float) -> Scene:
    """A scene at another speed of its cam [rev/min], by the key that gives its speed."""
    return scene.replace(
        **({CRANK_SPEED_KEY: TURNS_OF_CRANK * rpm} if scene.is_speed_of_crank else {"cam.rpm": rpm})
    )


def _faults_across_stations(machine: Machine, scenes: Sequence[Scene | None]) -> Iterator[Fault]:
    """Every fault that involves more than one table."""
    stations = {each.name: each for each in machine.station}
    bodies = {each.name: each for each in machine.body}
    yield from _repeated_names(machine)
    for number, (station, scene) in enumerate(zip(machine.station, scenes, strict=True), start=1):
        if station.outline is not None and scene:
            slides = ("direction", "pivot", "slides")
            missing, other, kind = ("pivot", "direction", "turns") if scene.tool_turns else slides
            if getattr(station, missing) is None:
                yield f"station.{number}.{missing}", None, f"missing: the tool {kind} and has an outline"
            if getattr(station, other) is not None:
                yield f"station.{number}.{other}", getattr(station, other), f"not used: the tool {kind}"
    if machine.rpm is not None and machine.rpm_of_crank is not None:
        yield "rpm_of_crank", machine.rpm_of_crank, "leave it out, or leave out rpm"
    for number, clearance in enumerate(machine.clear, start=1):
        yield from _faults_of_clearance(f"clear.{number}", clearance, stations, bodies)
    for name in machine.search.phase:
        if name not in stations:
            yield f"search.phase.{name}", None, f"not a station; {suggest_names(name, stations)}"


def _repeated_names(machine: Machine) -> Iterator[Fault]:
    """A fault for each name that a station or body has already."""
    known = set[str]()
    for kind in ("station", "body"):
        for number, table in enumerate(getattr(machine, kind), start=1):
            if table.name in known:
                yield f"{kind}.{number}.name", table.name, "another station or body has this name"
            known.add(table.name)


def _faults_of_clearance(
    place: str, clearance: Clearance, stations: Mapping[str, Station], bodies: Mapping[str, Body]
) -> Iterator[Fault]:
    """The faults of a clearance: unknown names, missing outlines, a wrong number of coefficients."""
    known: Collection[str] = stations if clearance.along is not None else {**stations, **bodies}
    kind = "a station" if clearance.along is not None else "a station or a body"
    for number, name in enumerate(clearance.between, start=1):
        if name not in known:
            yield f"{place}.between.{number}", name, f"not {kind}; {suggest_names(name, known)}"
        elif clearance.along is None and name in stations and stations[name].outline is None:
            why = "has no outline: give it one, or give the clearance along, a coefficient for each lift"
            yield f"{place}.between.{number}", name, why
    count = len(clearance.between)
    if clearance.along is not None and len(clearance.along) != count:
        yield f"{place}.along", [*clearance.along], f"must have {count} numbers, one for each station in between"
    if clearance.along is None and count != 2:
        yield f"{place}.between", [*clearance.between], "must name two stations or bodies, or have along"
    if len({*clearance.between}) != count:
        yield f"{place}.between", [*clearance.between], "must name each station once"


def find_machine(name: str | os.PathLike[str]) -> Machine:
    """A machine by the path of its file, or by the name of a shipped one.

    Parameters
    ----------
    name : str or os.PathLike
        A path that ends in .toml, or one of ``shipped_machines()``.

    Returns
    -------
    Machine
        The checked machine, with the scenes of its stations.

    Raises
    ------
    BadInput
        If no such file or shipped machine exists, or the machine or one of its scenes has mistakes.
    OSError
        If a file cannot be read.

    Examples
    --------
    >>> camopt.find_machine("pick-and-place").shaft_rpm
    60.0
    """
    if not isinstance(name, (str, os.PathLike)):
        raise BadInput([Mistake("camopt", "machine", name, MACHINE_WORDS)])
    word = os.fsdecode(name)
    if word in shipped_machines():
        return Machine._read(os.fspath(MACHINES / f"{word}.toml"), word)
    if Path(word).is_file():
        return Machine.from_toml(word)
    why = "there is no such file" if Path(word).suffix else suggest_names(word, shipped_machines())
    raise BadInput([Mistake("camopt", "machine", word, f"{MACHINE_WORDS}; {why}")])


def machine_from(machine_or_name: MachineSource) -> Machine:
    """The machine itself, or by name or path; errors are those of ``find_machine``."""
    return machine_or_name if isinstance(machine_or_name, Machine) else find_machine(machine_or_name)


def is_machine(target: str) -> bool:
    """Whether a command's argument is a machine: a shipped one, or a TOML file with stations."""
    if target in shipped_machines():
        return True
    path = Path(target)
    if path.suffix != ".toml" or not path.is_file():
        return False
    return STATION_TABLE in parse_toml(read_bytes(target), target)
