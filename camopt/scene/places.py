"""The tables of a scene by their place, and the texts of their keys from the code."""

import ast
import inspect
from functools import cache
from itertools import pairwise
from textwrap import dedent

from camopt.quantities import BOUNDED, OF_SPRING, OF_TOOL
from camopt.scene.choices import StepRange
from camopt.scene.own_quantities import QuantityExpression
from camopt.scene.tables import Dynamics, OwnLaw, ProfileElement, SceneTable, Segment, Through
from camopt.scene.tolerances import Tolerance
from camopt.scene.train import TrainStage

TOP = ""
"""Where the keys before the first table of a scene stand."""
LISTS = ("motion", "motion.through", "train", "profile")
"""Those of which a scene has several."""


@cache
def tables_of(scene: type[SceneTable]) -> dict[str, type[SceneTable]]:
    """Every table by where it stands in a scene."""
    own = {name: field.annotation for name, field in scene.model_fields.items()}
    return {
        TOP: scene,
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
    return f"[[{place}]]" if place in LISTS else f"[{place}]"


def said_of(model: type[SceneTable], key: str) -> tuple[str, str]:
    """What is said of a key, without its full stop, and the unit that it ends with, "" if none."""
    own = (said[key] for base in model.__mro__ if key in (said := _docstrings(base)))
    text = next(own, None) or (BOUNDED[key].bounded if key in BOUNDED else f"Most allowed ``{key}``.")
    sentence, mark, unit = text.removesuffix(".").rpartition("; ")
    return (sentence, unit) if mark else (text.removesuffix("."), "")


def without_choice(key: str) -> str:
    """The key of a number of the scene, of which another table says something."""
    return key.removeprefix("search.").removeprefix("tolerances.")


def is_angle(key: str, angular: bool, tool_turns: bool, straight: bool) -> bool:
    """Whether the motion that a key is about is an angle: that of the follower for its loads, else of the tool.

    The motion of a spring on an arm is none if it is a straight one.
    """
    key = without_choice(key)
    if straight and key in OF_SPRING:
        return False
    return angular if key.startswith("follower.") and key not in OF_TOOL else tool_turns


def unit_for(unit: str, angular: bool) -> str:
    """Of a unit that is another one where the follower oscillates, that of this follower."""
    linear, _, turning = unit.partition(", oscillating ")
    return turning if angular and turning else linear


@cache
def _docstrings(model: type) -> dict[str, str]:
    """The texts under the keys of a class, in one line each."""
    if "__annotations__" not in vars(model) or model.__module__.split(".")[0] == "pydantic":
        return {}
    try:
        (tree,) = ast.parse(dedent(inspect.getsource(model))).body
    except OSError:  # it was made, not written
        return {}
    found: dict[str, str] = {}
    for key, text in pairwise(tree.body if isinstance(tree, ast.ClassDef) else []):
        match key, text:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(said))):
                found[name] = " ".join(said.split())
    return found
