"""``Scene``: the input of camopt, checked when it is made, read from TOML and written to TOML.

Keys and units (mm, deg, rev/min) are those of the scene file. A wrong scene raises one BadInput with all its
mistakes, a line each.
"""

import os
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import tomli_w
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PrivateAttr, ValidationError

from camopt.core.mistakes import BadInput, Mistake, escape_unprintable, suggest_names
from camopt.core.quantities import STAGE_NUMBER_KEYS, quantity_name_by_number_key, stage_quantity_name
from camopt.core.quantities.display import Drawable, HasHtml
from camopt.core.quantities.key import Key
from camopt.core.storage.files import read_bytes
from camopt.model.mechanisms import FIELDS, SECOND_FIELDS, Mechanism, mechanism_for
from camopt.model.mechanisms.elements import TIPS, Tip
from camopt.model.motion import LAWS
from camopt.scene.checks import faults_across_tables
from camopt.scene.design_rows import check_design_row, is_missing, values_of_row
from camopt.scene.drawn_profile import replace_drawing_by_elements
from camopt.scene.faultless_tables import faultless_table
from camopt.scene.fits import expand_standard_keyway, split_bore_into_diameter_and_fit
from camopt.scene.law_forms import VALUE_IN_SCENE, Fault
from camopt.scene.limits import Limits
from camopt.scene.load import replace_load_files
from camopt.scene.mapping import is_motion_given_at_follower, table_named, value_at_key
from camopt.scene.materials import MATERIALS
from camopt.scene.own_laws import replace_law_files, with_canonical_law_names
from camopt.scene.own_quantities import QuantityExpression, check_limit_keys, expand_own_quantities
from camopt.scene.part import TOWARDS_FOLLOWER, USUAL_GAP, Part
from camopt.scene.profile import set_base_radius_from_profile
from camopt.scene.pydantic_mistakes import KNOWN_TABLES, mistakes_from_pydantic
from camopt.scene.search import Search, nest_dotted_keys
from camopt.scene.sources import shipped_machines, shipped_scenes, shipped_toml
from camopt.scene.speed import CRANK_SPEED_KEY, replace_crank_speed
from camopt.scene.spring import has_straight_spring
from camopt.scene.synthesis import SynthesisSettings
from camopt.scene.table_places import tables_by_place
from camopt.scene.table_shapes import replace_wrong_shapes
from camopt.scene.tables import (
    MOST_SEGMENTS,
    Accuracy,
    Cam,
    Drive,
    Dynamics,
    Follower,
    InnerTable,
    Materials,
    Outputs,
    OwnLaw,
    ProfileElement,
    SceneTable,
    Segment,
    Through,
    allow_text_in_schema,
    check_one_line,
)
from camopt.scene.tolerances import Tolerances, replace_measured_error_files
from camopt.scene.toml_text import has_unit_text, parse_toml, plain_mappings_and_lists
from camopt.scene.train import MOST_STAGES, TrainStage, keys_of_stage_kind, tool_turns
from camopt.scene.turn import set_first_searched_laws
from camopt.scene.units import replace_unit_texts
from camopt.scene.yoke_halves import append_second_half_turn

if TYPE_CHECKING:
    import pandas as pd

SCENE_WORDS = "a TOML file or a shipped scene"
RESULT_WORDS = "a TOML file, a shipped scene, a table of designs (.parquet) or a folder that a command wrote"

FORMER_KEYS = {"accuracy.tolerance": "accuracy.relative_error"}
"""The present key, by its former name, which scenes may still use."""
KEYS_OF_ROWS = {
    "motion": {*Segment.model_fields, *Through.model_fields},
    "profile": {*ProfileElement.model_fields},
    "laws": {*OwnLaw.model_fields},
}


class Scene(HasHtml, Drawable, SceneTable):
    """A whole scene, made from tables, from TOML (``from_toml``) or from a mapping (``from_dict``).

    Keys and units are those of a scene file. A scene never changes: ``replace`` returns a changed copy.

    Parameters
    ----------
    name : str, default "scene"
        Title of results and pictures.
    cam : Cam
        Form, sense of rotation, speed and size.
    follower : Follower
        Its motion, its tip that touches the cam, its sizes, masses and forces.
    drive : Drive
        What keeps the follower on the cam: a spring, or the cam itself.
    motion : tuple of Segment
        Rises, dwells, returns and moves of one turn.
    motion_at : str, default "tool"
        With a train: whether ``motion`` is the motion of the "tool" or of the "follower".
    train : tuple of TrainStage
        The linkage between the follower and the tool.
    profile : tuple of ProfileElement
        The profile of a disc cam, in place of a motion: arcs and lines, or the name of a DXF file. The file is read
        when the scene is made; its path is relative to the scene file.
    laws : dict
        Motion laws that the scene defines, by name.
    quantities : dict
        Quantities that the scene defines, by name: expressions to report, to limit or to minimise.
    limits : Limits
        Limits that a feasible cam meets.
    search : Search
        What ``sweep`` and ``optimise`` may vary, and the objectives.
    synthesis : SynthesisSettings
        What new motion laws minimise, and their limits.
    materials : Materials
        Materials of the cam and the follower.
    part : Part
        The cam as a workpiece: thickness, hub, keyway.
    tolerances : Tolerances
        Tolerances of the cam, the follower and the train.
    accuracy : Accuracy
        Largest relative error of reported values.
    outputs : tuple of str
        Quantities or effects to report in place of those of motion and geometry. Sizes are always reported.

    Raises
    ------
    BadInput
        When the scene is made; it has every mistake.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm").replace(**{"cam.rpm": 500, "limits.pressure_angle": 35})
    >>> scene.cam.rpm, scene.limits.pressure_angle
    (500.0, 35.0)
    >>> scene == camopt.Scene.from_dict(scene.to_dict())
    True
    """

    picture: ClassVar[str] = "drawing.figures"
    elsewhere: ClassVar[Mapping[str, str]] = {"station": "the file is a machine: use camopt machine"}
    model_config = ConfigDict(defer_build=False)  # its keys are in its signature before there is one
    name: Annotated[str, BeforeValidator(check_one_line), Key("Title of results and pictures")] = "scene"
    cam: Annotated[InnerTable[Cam], Key("The cam")]
    follower: Annotated[InnerTable[Follower], Key("The follower")]
    drive: Annotated[InnerTable[Drive], Key("What keeps the follower on the cam")] = Drive.model_construct()
    motion: Annotated[
        tuple[InnerTable[Segment], ...],
        Field(min_length=1, max_length=MOST_SEGMENTS),
        Key("The turn, segment by segment"),
    ] = ()
    motion_at: Annotated[
        Literal["tool", "follower"],
        Key("With a train: whether `[[motion]]` is the motion of the tool or of the follower"),
    ] = "tool"
    train: Annotated[
        tuple[InnerTable[TrainStage], ...],
        Field(max_length=MOST_STAGES),
        Key("The train, a linkage between the follower and the tool, stage by stage"),
    ] = ()
    profile: Annotated[
        tuple[InnerTable[ProfileElement], ...],
        Field(min_length=1, max_length=MOST_SEGMENTS, json_schema_extra=allow_text_in_schema),
        Key("Profile of the cam, in place of the motion: arcs and lines, or the name of a DXF file"),
    ] = ()
    laws: Annotated[dict[str, InnerTable[OwnLaw]], Key("Motion laws that the scene defines, by name")] = Field(
        default_factory=dict
    )
    quantities: Annotated[
        dict[str, InnerTable[QuantityExpression]],
        Key("Quantities that the scene defines, by name: expressions over other quantities"),
    ] = Field(default_factory=dict)
    limits: Annotated[InnerTable[Limits], Key("Limits that the cam must meet")] = Limits.model_construct()
    search: Annotated[InnerTable[Search], Key("What a search may vary, and the objectives")] = (
        Search.model_construct()
    )
    synthesis: Annotated[InnerTable[SynthesisSettings], Key("Objective and limits of computed motion laws")] = (
        SynthesisSettings.model_construct()
    )
    materials: Annotated[InnerTable[Materials], Key("Materials of the bodies in contact, and the lubricant")] = (
        Materials.model_construct()
    )
    part: Annotated[InnerTable[Part], Key("The cam as a workpiece, and the texts of its drawing")] = (
        Part.model_construct()
    )
    tolerances: Annotated[InnerTable[Tolerances], Key("Tolerances of the cam, the follower and the train")] = (
        Tolerances.model_construct()
    )
    accuracy: Annotated[InnerTable[Accuracy], Key("Accuracy of results")] = Accuracy.model_construct()
    outputs: Annotated[
        Outputs,
        Key(
            "Quantities or effects to report, or `all`, in place of those of motion and geometry. Sizes, "
            "limited quantities and objectives are always reported"
        ),
    ] = ()
    _file: str = PrivateAttr("scene")
    _by_crank: bool = PrivateAttr(False)
    _wrong: frozenset[str] = PrivateAttr(frozenset())

    @property
    def shown_cam(self) -> "Scene":
        """The scene itself, as the cam to draw."""
        return self

    def __repr__(self) -> str:
        cam, follower = self.cam, self.follower
        words = [
            f"{cam.form} cam",
            f"{follower.motion} {follower.contact} follower",
            f"a profile of {len(self.profile)}" if self.profile else f"{len(self.motion)} segments",
        ]
        words += [] if cam.rpm is None else [f"{cam.rpm:g} rev/min"]
        return f"<Scene {self.name}: {', '.join(words)}>"

    __str__ = __repr__

    @property
    def file(self) -> str:
        """The name of the scene's file; without a file, the name that messages use."""
        return self._file

    @property
    def is_speed_of_crank(self) -> bool:
        """Whether the scene gives its speed as ``cam.rpm_of_crank``."""
        return self._by_crank

    def has_refused_value(self, table: str, all_keys: bool = False) -> bool:
        """Whether a value in the tables of a name was refused; unknown keys count only with ``all_keys``."""
        keys = (key.split(".")[1:] for key in self._wrong if key.startswith(f"{table}."))
        paths = ([part for part in parts if not part.isdecimal()] for parts in keys)
        return any(all_keys or len(path) <= (table == "laws") or path[-1] in KEYS_OF_ROWS[table] for path in paths)

    @property
    def mechanism(self) -> Mechanism:
        """The pairing of cam and follower."""
        return mechanism_for(self.cam.form, self.follower.motion, self.follower.contact, self.drive.kind)

    @property
    def tool_turns(self) -> bool:
        """Whether the tool turns; without a train, whether the follower does."""
        return self.output_turns_after_stages(len(self.train))

    @property
    def given_at_follower(self) -> bool:
        """Whether ``[[motion]]`` is the motion of a follower that moves a tool."""
        return is_motion_given_at_follower(dict(self))

    @property
    def given_motion_is_angle(self) -> bool:
        """Whether ``[[motion]]`` is an angle."""
        return self.output_turns_after_stages(0 if self.given_at_follower else len(self.train))

    def output_turns_after_stages(self, stage_count: int) -> bool:
        """Whether the output of the first ``stage_count`` stages of the train turns.

        For 0, whether the follower does.
        """
        rows = [row.model_dump(exclude_none=True) for row in self.train[:stage_count]]
        return tool_turns(rows, self.mechanism.motion.angular)

    @property
    def straight_spring(self) -> bool:
        """Whether a straight spring acts on the arm of an oscillating follower."""
        return has_straight_spring(
            {"follower": {"dynamics": dict(self.follower.dynamics or ())}, "search": dict(self.search)}
        )

    @property
    def number_quantities(self) -> Mapping[str, str]:
        """The quantity that tables show for each number of the scene, by key."""
        turns = {"angular": self.mechanism.motion.angular, "tool_turns": self.tool_turns}
        return quantity_name_by_number_key(**turns, straight_spring=self.straight_spring)

    @property
    def tip(self) -> Tip:
        """The tip of the follower, which touches the cam."""
        return TIPS[self.follower.contact]

    @property
    def whole_part(self) -> Part:
        """The part, completed from other tables of the scene: bore, material, density, name."""
        part, paired = self.part, bool(self.mechanism.second_contact_size_keys)
        defaults = {
            "bore": self.cam.shaft_diameter,
            "material": self.materials.cam,
            "density": MATERIALS[self.materials.cam].density if self.materials.cam else None,
            "name": self.name,
            "profile_tolerance": self.tolerances.profile or None,
            "keyway_angle": TOWARDS_FOLLOWER if part.keyway_width else None,
            "disc_gap": USUAL_GAP * part.thickness if paired and part.thickness else None,
        }
        return part.model_copy(update={key: v for key, v in defaults.items() if getattr(part, key) is None})

    @property
    def with_profile_tolerance_moved(self) -> "Scene":
        """The scene with ``part.profile_tolerance``, if given, moved to ``tolerances.profile``."""
        given = self.part.profile_tolerance
        return (
            self if given is None else self.replace(**{"part.profile_tolerance": None, "tolerances.profile": given})
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __init__(self, /, **values: Any) -> None:
        self._fill_and_check(values, str(values.get("name", "scene")))

    def _fill_and_check(
        self, values: dict[str, Any], file: str, folder: Path | None = Path(), mistakes: Iterable[Mistake] = ()
    ) -> None:
        given, mistakes = plain_mappings_and_lists(values, file), [*mistakes]
        if "search" in given:
            given["search"] = nest_dotted_keys(given["search"])
        if "tolerances" in given:
            given["tolerances"] = nest_dotted_keys(given["tolerances"])
        unread = [*_replace_former_keys(given)]
        expand_own_quantities(given)
        mistakes += replace_wrong_shapes(given, SCENE_TABLES, file)
        split_bore_into_diameter_and_fit(given)  # before units, since a fit is no unit
        if has_unit_text({key: value for key, value in given.items() if key != "name"}):
            given, unit_mistakes = replace_unit_texts(given, SCENE_TABLES, file)
            mistakes += unit_mistakes
        tables = with_canonical_law_names(given, table_named(given, "laws"))
        unread += expand_standard_keyway(tables)
        unread += [
            *replace_law_files(tables, folder),
            *replace_load_files(tables, folder),
            *replace_drawing_by_elements(tables, folder),
        ]
        unread += [*replace_measured_error_files(tables, folder), *check_limit_keys(tables)]
        by_crank = isinstance(cam := tables.get("cam"), dict) and "rpm_of_crank" in cam
        unread += replace_crank_speed(tables)
        set_base_radius_from_profile(tables)
        set_first_searched_laws(tables)
        append_second_half_turn(tables)
        is_sound = not mistakes
        try:
            BaseModel.__init__(self, **tables)
        except ValidationError as error:
            is_sound = False
            reported = {*(mistake.key for mistake in mistakes), *(fault[0] for fault in unread)}
            mistakes += [m for m in mistakes_from_pydantic(error, Scene, "", file) if m.key not in reported]
        keys = {mistake.key for mistake in mistakes}
        sound = self if is_sound else faultless_table(Scene, tables, keys)
        sound._wrong = frozenset(keys)
        for key, value, why in (*unread, *faults_across_tables(sound, tables)):
            row = key.startswith(("train.", "motion.")) and key.rpartition(".")[2].isdecimal()
            if key not in keys and not (row and any(each.startswith(f"{key}.") for each in keys)):
                mistakes.append(
                    Mistake(
                        file, key, value_at_key(tables, key) if value is VALUE_IN_SCENE else value, why, bare=True
                    )
                )
        if mistakes:
            raise BadInput(mistakes, sound)
        self._file, self._by_crank = file, by_crank

    @classmethod
    def from_dict(cls, data: dict[str, Any], file: str = "scene") -> "Scene":
        """A scene from nested mappings with the keys of a scene file; messages name ``file``.

        Paths of laws, loads and profiles are relative to the current folder.
        """
        if not isinstance(data, dict):
            raise BadInput([Mistake(file, "scene", data, "a mapping of tables")])
        scene = cls.__new__(cls)
        scene._fill_and_check(data, file)
        return scene

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str], changes: Mapping[str, Any] | None = None) -> "Scene":
        """A scene from a TOML file, with changes by key as in ``replace``.

        Changes are made before the file is checked, so they may correct it or add what is missing.

        Raises
        ------
        BadInput
            For all mistakes in the file.
        OSError
            If the file does not exist or cannot be read.
        """
        name = os.fsdecode(path)
        data = parse_toml(read_bytes(name), name)
        data = plain_mappings_and_lists({"name": escape_unprintable(Path(name).stem), **data}, name)
        scene, changes = cls.__new__(cls), changes or {}
        try:
            scene._fill_and_check(data, name, Path(name).parent)
        except BadInput:
            if not changes:
                raise
            data |= {table: nest_dotted_keys(data[table]) for table in ("search", "tolerances") if table in data}
            scene._fill_and_check(data, name, Path(name).parent, _apply_changes_to_tables(data, changes, name))
            return scene
        return scene.replace(**changes) if changes else scene

    @classmethod
    def embedded(cls, text: str, file: str) -> "Scene":
        """The scene from TOML text inside another file; a scene that names files is refused."""
        scene = cls.__new__(cls)
        scene._fill_and_check(parse_toml(text, file), file, None)
        return scene

    def to_dict(self) -> dict[str, Any]:
        """Nested plain mappings without default values; ``from_dict`` gives an equal scene."""
        data = self.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
        return {"name": self.name, **{key: value for key, value in data.items() if value not in ({}, [])}}

    def to_toml(self) -> str:
        """The scene as TOML text, which reads back as an equal scene."""
        return tomli_w.dumps(self.to_dict())

    def replace(self, *tables: Any, **changes: Any) -> "Scene":
        """A changed copy, by dotted key such as ``cam.rpm`` or ``motion.1.angle``; None removes a key."""
        if tables:
            why = 'keywords, as in scene.replace(**{"cam.rpm": 500})'
            raise BadInput([Mistake("camopt", "changes", tables[0], why)])
        data = self.to_dict()
        if self.profile and changes.get("profile"):
            del data["cam"]["base_radius"]  # which follows from it
        if misplaced := _apply_changes_to_tables(data, changes, self.file):
            raise BadInput(misplaced)
        scene = Scene.from_dict(data, self.file)
        scene._by_crank |= self._by_crank and "cam.rpm" not in changes
        return scene

    def numbers(self, keys: Iterable[str]) -> dict[str, Any]:
        """Values by dotted key; None where the scene has no value."""
        found: dict[str, Any] = {}
        for key in keys:
            found[key] = self
            for name in key.split("."):
                rows = isinstance(found[key], tuple)
                found[key] = _row_by_number(found[key], name) if rows else getattr(found[key], name, None)
        return found

    @property
    def size_fields(self) -> dict[str, str]:
        """The field of ``Designs`` for each size, by key; the size of the body comes first.

        Sizes of a second contact that equal those of the first contact are left out.
        """
        mechanism, searched, toleranced = self.mechanism, self.search.sizes, self.tolerances.numbers
        own = {key: FIELDS[key.partition(".")[2]] for key in mechanism.keys(self.tip)}
        seconds = {key: SECOND_FIELDS[key] for key in mechanism.second_contact_size_keys}
        given = self.numbers(seconds)
        different = (key for key in seconds if given[key] is not None or key in searched or toleranced)
        return own | {key: seconds[key] for key in different}

    @property
    def stage_quantities(self) -> dict[str, str]:
        """The quantity that tables show for each number of a train stage, by key."""
        found: dict[str, str] = {}
        for number, row in enumerate(self.train, start=1):
            own, turns = keys_of_stage_kind(row.stage), self.output_turns_after_stages(number)
            keys = [key for key in STAGE_NUMBER_KEYS if key in own]
            found |= {f"train.{number}.{key}": stage_quantity_name(number, key, angular=turns) for key in keys}
        return found

    @property
    def row_columns(self) -> dict[str, str]:
        """The table column of each size and number of a design, by key."""
        columns = self.mechanism.size_quantity_by_field
        sizes = {key: columns[field] for key, field in self.size_fields.items()}
        return {**sizes, **self.number_quantities, **self.stage_quantities}

    def with_row(self, row: "Mapping[str, Any] | pd.Series[Any]") -> "Scene":
        """The scene of one design: a copy with the sizes, other numbers, laws and angles of a row of a table.

        Parameters
        ----------
        row : Mapping, pandas.Series or pandas.DataFrame of one row
            Values by column name; unknown columns are ignored.

        Returns
        -------
        Scene
            For ``evaluate``, ``plot``, ``certify`` and other functions.

        Raises
        ------
        BadInput
            If no column is a size, number or law of the mechanism; if a value is missing or not allowed; if the
            scene does not know a law.

        Examples
        --------
        >>> scene = camopt.find_scene("roller-1000rpm")
        >>> scene.with_row({"base_radius_mm": 90, "law": "poly345"}).motion[0].law
        'poly345'
        """
        values = values_of_row(row)
        check_design_row(self, values)
        given = {name: value for name, value in values.items() if not is_missing(value)}
        changes: dict[str, Any] = {key: given[name] for key, name in self.row_columns.items() if name in given}
        changes = {
            key: value + 0.0 if isinstance(value, Real) and not isinstance(value, bool) else value
            for key, value in changes.items()
        }  # no −0
        known, motion = {*LAWS, *self.laws}, self.to_dict().get("motion")
        for number, segment in enumerate(motion or ()):
            both = given.get("law") if segment["segment"] in ("rise", "return") else None
            law = given.get(f"law_{segment['segment']}", both)
            segment |= {"law": law} if law in known else {}  # else a list of the laws that segments have already
            segment |= {"angle": given["angles_deg"][number]} if "angles_deg" in given else {}
        return self.replace(**changes, motion=motion)

    def with_values(self, values: Mapping[str, Any]) -> "Scene":
        """A copy with other values by dotted key, unchecked, as those of ``[search]`` are checked already."""
        scene = self
        for key, value in values.items():
            scene = _copy_with_value_at_keys(scene, key.split("."), value)
        return scene


SCENE_TABLES = tables_by_place(Scene)
"""Every table by its place in a scene."""
KNOWN_TABLES.update(SCENE_TABLES)  # messages about unknown keys name the table that has them


def _replace_former_keys(tables: dict[str, Any]) -> Iterator[Fault]:
    """Replace former keys by present ones, in ``tables`` itself; a fault where both are given."""
    for former, key in FORMER_KEYS.items():
        if (value := value_at_key(tables, former)) is None:
            continue
        if value_at_key(tables, key) is not None:
            yield former, value, f"is the old name of {key}, which is given too: leave this one out"
        place, _, name = former.rpartition(".")
        table = tables[place]
        del table[name]
        table.setdefault(key.removeprefix(f"{place}."), value)


def _apply_changes_to_tables(data: dict[str, Any], changes: Mapping[str, Any], file: str) -> list[Mistake]:
    """Make changes by dotted key in the tables of a scene; a mistake for each key whose table does not exist."""
    for key, other in (("rpm", CRANK_SPEED_KEY), ("rpm_of_crank", "cam.rpm")):
        if changes.get(other) is not None and isinstance(cam := data.get("cam"), dict):
            cam.pop(key, None)
    mistakes = []
    for key, value in changes.items():
        *tables, last = FORMER_KEYS.get(key, key).split(".")
        table: Any = data
        above: list[tuple[Any, str]] = []
        for place, name in enumerate(tables):
            rows = table if isinstance(table, list) else None
            above.append((table, name))
            table = _row_by_number(rows, name) if rows is not None else table.setdefault(name, {})
            if not isinstance(table, dict) and not (isinstance(table, list) and tables[place + 1 :]):
                why = f"{name} is not a table: set {'.'.join(tables[: place + 1])} itself"
                if isinstance(table, list) and table and isinstance(table[0], dict):
                    why = f"set a key of this table, such as {key}.{next(iter(table[0]))}, or set {name} itself"
                if rows is not None:
                    why = f"there is no table {name}: [[{'.'.join(tables[:place])}]] has {len(rows)}"
                mistakes.append(Mistake(file, key, value, why, bare=True))
                break
        else:
            if value is not None:
                table[last] = plain_mappings_and_lists(value, file)
                continue
            table.pop(last, None)
            for parent, name in above[:0:-1]:  # an inner table without keys is removed
                if isinstance(parent, dict) and parent[name] == {}:
                    del parent[name]
    return mistakes


def _row_by_number(rows: Sequence[Any], number: str) -> Any:
    """A row of a list of tables by number from 1; None if it does not exist."""
    return rows[int(number) - 1] if number.isdecimal() and 1 <= int(number) <= len(rows) else None


def _copy_with_value_at_keys(table: Any, keys: list[str], value: Any) -> Any:
    """A copy of a table with another value under a path of keys, unchecked; [follower.dynamics] may be absent."""
    first, *rest = keys
    if isinstance(table, tuple):
        place = int(first) - 1
        return (*table[:place], _copy_with_value_at_keys(table[place], rest, value), *table[place + 1 :])
    changed = _copy_with_value_at_keys(getattr(table, first) or Dynamics(), rest, value) if rest else value
    return table.model_copy(update={first: changed})


def find_scene(name: str | os.PathLike[str]) -> Scene:
    """A scene by the path of its file, or by the name of a shipped one.

    Parameters
    ----------
    name : str or os.PathLike
        A path that ends in .toml, or one of ``shipped_scenes()``.

    Returns
    -------
    Scene
        The checked scene; keys that the file leaves out have their defaults.

    Raises
    ------
    BadInput
        If no such file or shipped scene exists, or the scene has mistakes.
    OSError
        If the file cannot be read.

    Examples
    --------
    >>> camopt.find_scene("roller-1000rpm").cam.rpm
    1000.0
    """
    if not isinstance(name, (str, os.PathLike)):
        raise BadInput(
            [Mistake("camopt", "scene", name, "the path of a TOML file, or the name of a shipped scene")]
        )
    return scene_named(os.fsdecode(name))


def scene_named(
    word: str,
    noun_for_message: str = "scene",
    allowed_words: str = SCENE_WORDS,
    changes: Mapping[str, Any] | None = None,
) -> Scene:
    """As ``find_scene``, with changes by key.

    If the word is neither a file nor a shipped scene, the message names ``noun_for_message`` and
    ``allowed_words``.
    """
    if word in shipped_scenes():
        return _shipped_scene(word).replace(**changes) if changes else _shipped_scene(word)
    path = Path(word)
    if path.is_file():
        return Scene.from_toml(word, changes)
    if word and path.exists():
        why = "this is a folder, pipe or device"
    elif word in shipped_machines():
        why = f"{word} is a machine: use camopt machine {word}"
    elif path.suffix or {"/", os.sep} & {*word}:
        why = "there is no such file"
    else:
        why = suggest_names(word, shipped_scenes())
    raise BadInput([Mistake("camopt", noun_for_message, word, f"{allowed_words}; {why}")])


@cache
def _shipped_scene(name: str) -> Scene:
    """A shipped scene, read once."""
    return Scene.from_dict(tomllib.loads(shipped_toml(name)), name)
