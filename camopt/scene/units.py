"""Convert texts with a unit, such as ``"0.8 in"``, to numbers in the unit of their key.

Pint knows the units. Pint takes angles as dimensionless; here either both units contain an angle or neither does,
so 600 rev/min is not accepted as 62.8 Hz.
"""

import re
from collections.abc import Mapping
from functools import cache
from typing import Any

from camopt.core.mistakes import Mistake
from camopt.core.quantities.key import NO_UNIT
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.scene.mapping import is_motion_given_at_follower, tables_in_list, value_at_key
from camopt.scene.sizes import mechanism_and_tip_named
from camopt.scene.spring import has_straight_spring
from camopt.scene.table_places import (
    TABLE_LISTS,
    TOP_TABLE,
    is_key_of_angular_motion,
    key_record,
    without_table_prefix,
)
from camopt.scene.tables import SceneTable
from camopt.scene.toml_text import NUMBER_WITH_UNIT
from camopt.scene.train import tool_turns

ANGLE_UNIT = re.compile(r"rad|deg|°|rev|turn|rpm|arc")
PER_MINUTE = re.compile(r"(?<=[\d. ])(1/min|min\^-1|min⁻¹)$")
"""The spelling of rev/min on rating plates of motors."""
MIXED_FRACTION = re.compile(r"\b(\d+)\s+(\d+/\d+)\b(?!\.)")
"""A whole number and a fraction, as in lengths in inches."""
SHARE_KEYS = ("cpk", "shared")
"""Keys of a tolerance without the unit of its number."""
NAMED_TABLES = ("laws", "quantities")
"""Tables of inner tables that the user names."""
EXACT_DIGITS = 15
"""Digits of a converted number: rounding errors do not reach them."""
TableModels = Mapping[str, type[SceneTable]]
"""The tables of a scene by place (``tables_by_place``)."""


def replace_unit_texts(
    tables: dict[str, Any], models: TableModels, file: str
) -> tuple[dict[str, Any], list[Mistake]]:
    """The tables of a scene with numbers in place of texts with units, and a mistake for each wrong unit."""
    reader = _UnitReader(tables, models, file)
    return reader.convert_scene(), reader.mistakes


def tables_in_shown_units(tables: dict[str, Any], models: TableModels) -> dict[str, Any]:
    """The tables of a scene with their numbers in the units of results."""
    return _ShownUnitConverter(tables, models).convert_scene()


def tables_with_units_for_numbers(tables: dict[str, Any], models: TableModels) -> dict[str, Any]:
    """The tables of a scene with the unit of results in place of each number, "" without a unit."""
    return _UnitNamer(tables, models).convert_scene()


class _UnitReader:
    """Goes through the tables of a scene and converts texts with units."""

    def __init__(self, scene: dict[str, Any], models: TableModels, file: str = "") -> None:
        words = ("cam.form", "follower.motion", "follower.contact", "drive.kind")
        pair = mechanism_and_tip_named(*(value_at_key(scene, key) for key in words))
        self.scene, self.models, self.file = scene, models, file
        self.angular, self.stages = bool(pair and pair[0].motion.angular), tables_in_list(scene.get("train"))
        self.mistakes: list[Mistake] = []

    def convert_scene(self) -> dict[str, Any]:
        """All tables of the scene, converted."""
        return self.convert_table(self.scene, self.models[TOP_TABLE], "", "")

    def convert_table(
        self, given: Mapping[str, Any], model: type[SceneTable], place: str, kind_of_table: str
    ) -> dict[str, Any]:
        """The values of a table; ``kind_of_table`` is the place of its kind of table (``tables_by_place``)."""
        values = {}
        for key, value in given.items():
            where = f"{place}.{key}".lstrip(".")
            named = kind_of_table in NAMED_TABLES
            stands = (
                f"{kind_of_table}.NAME" if named else without_table_prefix(f"{kind_of_table}.{key}".lstrip("."))
            )
            if kind_of_table == "" and key in NAMED_TABLES and isinstance(value, Mapping):
                values[key] = self.convert_table(value, model, where, key)
            elif stands in self.models and isinstance(value, (Mapping, list)):  # tolerances.profile is a number
                values[key] = self.convert_table_or_rows(value, self.models[stands], where, stands)
            else:
                known_key = key in model.model_fields
                unit = (
                    key_record(model, key).unit_of(angular=self.is_key_of_angular_motion(where))
                    if known_key
                    else ""
                )
                values[key] = self.convert_value(value, unit, where)
        return values

    def is_key_of_angular_motion(self, where: str) -> bool:
        """Whether a key refers to a motion that is an angle; for a stage of a train, its output."""
        stage = re.match(r"train\.(\d+)\.", without_table_prefix(where))
        if where.startswith("motion.") and is_motion_given_at_follower(self.scene):
            return self.angular
        turns = tool_turns(self.stages[: int(stage[1])] if stage else self.stages, self.angular)
        return (
            turns
            if stage
            else is_key_of_angular_motion(where, self.angular, turns, has_straight_spring(self.scene))
        )

    def convert_table_or_rows(self, value: Any, model: type[SceneTable], place: str, kind_of_table: str) -> Any:
        if isinstance(value, list):
            return [
                self.convert_table_or_rows(each, model, f"{place}.{row}", kind_of_table)
                for row, each in enumerate(value, start=1)
            ]
        by_row = kind_of_table in TABLE_LISTS and place != kind_of_table == without_table_prefix(place)
        if by_row and isinstance(value, Mapping):
            return {
                row: self.convert_table_or_rows(each, model, f"{place}.{row}", "") for row, each in value.items()
            }
        return self.convert_table(value, model, place, kind_of_table) if isinstance(value, Mapping) else value

    def convert_value(self, value: Any, unit: str, where: str) -> Any:
        """A number, a list of numbers or a range, converted."""
        if isinstance(value, list):
            return [self.convert_value(each, unit, f"{where}.{row}") for row, each in enumerate(value, start=1)]
        if isinstance(value, Mapping):
            return {
                key: self.convert_value(each, "" if key in SHARE_KEYS else unit, f"{where}.{key}")
                for key, each in value.items()
            }
        if not (unit and isinstance(value, str) and NUMBER_WITH_UNIT.fullmatch(value)):
            return value
        try:
            return convert_text_to_unit(value, unit)
        except ValueError as trouble:
            self.mistakes.append(Mistake(self.file, where, value, str(trouble)))
            return value


class _ShownUnitConverter(_UnitReader):
    """Converts numbers to the units of results."""

    def convert_value(self, value: Any, unit: str, where: str) -> Any:
        return to_shown_unit(value, unit) if isinstance(value, float) else super().convert_value(value, unit, where)


class _UnitNamer(_UnitReader):
    """Replaces numbers by the units of results."""

    def convert_value(self, value: Any, unit: str, where: str) -> Any:
        if isinstance(value, Mapping):
            return super().convert_value(value, unit, where)
        return "" if unit == NO_UNIT else unit_in_shown_system(unit.replace("`", ""))


def convert_text_to_unit(text: str, unit: str) -> float:
    """Convert a text with a unit to a number in another unit; a ValueError says what is allowed."""
    from pint import PintError

    target = "" if unit == NO_UNIT else unit.replace("·", "*").replace("rev", "turn")
    if unit == "rev/min":
        text = PER_MINUTE.sub("rev/min", text)
    allowed = (
        f"a number in {unit}, or a text with a unit of the same kind, such as '1 {unit}'"
        if target
        else "a number without a unit"
    )
    try:
        if bool(ANGLE_UNIT.search(text)) != bool(ANGLE_UNIT.search(target)):
            raise ValueError(allowed)
        text = MIXED_FRACTION.sub(r"(\1+\2)", text)
        quantity = _pint_registry().Quantity(re.sub(r"\brev\b", "turn", text.replace("·", "*")))
        return float(f"{quantity.to(_pint_registry().parse_units(target)).magnitude:.{EXACT_DIGITS}g}")
    except (PintError, TypeError, AttributeError, SyntaxError, ArithmeticError) as error:
        why = f"; {error}" if type(error).__name__ == "UndefinedUnitError" else ""
        raise ValueError(f"{allowed}{why}") from None


@cache
def _pint_registry() -> Any:
    from pint import UnitRegistry

    return UnitRegistry()
