"""The tables of a scene by place, and the records of their keys."""

from functools import cache

from camopt.core.quantities import NUMBER_KEYS, has_number_angular_unit
from camopt.core.quantities.key import Key
from camopt.scene.choices import StepRange
from camopt.scene.own_quantities import QuantityExpression
from camopt.scene.tables import Dynamics, OwnLaw, ProfileElement, SceneTable, Segment, Through
from camopt.scene.tolerances import Tolerance
from camopt.scene.train import TrainStage

TOP_TABLE = ""
"""The place of the keys before the first table of a scene."""
TABLE_LISTS = ("motion", "motion.through", "train", "profile", "station", "body", "clear")
"""The places of lists of tables."""


@cache
def tables_by_place(scene: type[SceneTable]) -> dict[str, type[SceneTable]]:
    """Every table by its place in a scene."""
    own = {name: field.annotation for name, field in scene.model_fields.items()}
    return {
        TOP_TABLE: scene,
        **{name: table for name, table in own.items() if isinstance(table, type) and issubclass(table, SceneTable)},
        "follower.dynamics": Dynamics,
        "motion": Segment,
        "motion.through": Through,
        "profile": ProfileElement,
        "train": TrainStage,
        "tolerances.KEY": Tolerance,
        "laws.NAME": OwnLaw,
        "quantities.NAME": QuantityExpression,
        "search.KEY": StepRange,
    }


def table_heading(place: str) -> str:
    """The heading of a table in a scene."""
    return f"[[{place}]]" if place in TABLE_LISTS else f"[{place}]"


def key_record(model: type[SceneTable], name: str) -> Key:
    """The record of a key of a table."""
    return next(each for each in model.model_fields[name].metadata if isinstance(each, Key))


def without_table_prefix(key: str) -> str:
    """The key of a number of the scene, from its key in ``[search]`` or ``[tolerances]``."""
    return key.removeprefix("search.").removeprefix("tolerances.")


def is_key_of_angular_motion(key: str, angular: bool, tool_turns: bool, straight_spring: bool) -> bool:
    """Whether a key refers to a motion that is an angle: the follower's for its loads, else the tool's."""
    key = without_table_prefix(key)
    if key in NUMBER_KEYS:
        return has_number_angular_unit(key, angular=angular, tool_turns=tool_turns, straight_spring=straight_spring)
    return angular if key.startswith("follower.") else tool_turns
