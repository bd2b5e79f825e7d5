"""Quantities that a scene defines by expressions or Python functions, and the checks of these and their names."""

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from functools import lru_cache, partial
from keyword import iskeyword
from typing import Annotated, Any

from pydantic import BeforeValidator

from camopt.core.mistakes import shorten, suggest_names
from camopt.core.quantities import DISCIPLINES, EVERYTHING, QUANTITIES
from camopt.core.quantities.expression import CONSTANTS, FUNCTIONS, MOST_CHARACTERS, WORD_PATTERN, parse_expression
from camopt.core.quantities.function import (
    FunctionCall,
    QuantityFunction,
    installed_quantities,
    load_installed_quantity,
)
from camopt.core.quantities.key import Key
from camopt.core.quantities.own_quantity import OWN_EFFECT, OwnQuantity
from camopt.scene.law_forms import Fault
from camopt.scene.limits import Limits
from camopt.scene.mapping import table_named, value_at_key
from camopt.scene.pydantic_mistakes import unknown_key_message
from camopt.scene.tables import QUANTITY_SYNONYMS, ListOrItem, SceneTable, check_one_line, single_value_as_list

MOST_QUANTITIES, LONGEST_NAME = 100, 60
QUANTITY_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
VERDICTS = ("limits", "proof")
"""The effects whose quantities are verdicts on designs."""
RESULT_KEYS = (
    *("law", "binding", "proved", "local", "within", "bound", "free", "held_by", "gap_mm", "clear_above_mm"),
    *("angles_deg", "every_cam", "nominal_mm", "nominal_proved", "safety_mm", "by_law", "scene", "row"),
    *("unbounded", "warnings", "joint_forces", "tightest"),
)
"""Names that results use for other values than quantities."""


class QuantityExpression(SceneTable):
    """A quantity that the scene defines: an expression over quantities of a design, or a Python function of them.

    ``compactness = "outer_radius_mm * torque_rms_N_m"`` is short for a table with this ``value``. An expression may
    have numbers, names of quantities, names of quantities defined above it, ``+ - * / **``, parentheses, ``pi``,
    and the functions ``abs``, ``sqrt``, ``min``, ``max``, ``sin``, ``cos``, ``tan``, ``asin``, ``acos``, ``atan``,
    ``atan2``, ``radians`` and ``degrees``. It has at most 200 nodes. These functions take angles in rad:
    ``sin(radians(pressure_angle_max_deg))``.

    camopt evaluates only the effects that the expression needs. ``limits.compactness = 3`` is an upper limit; for a
    lower limit, define the negative of the quantity and limit that. ``search.minimise`` and ``search.maximise``
    take the name of the quantity. If a limit or an objective names it, a design without a finite value is
    infeasible.

    In Python, ``camopt.quantity`` makes a quantity from a function. Installed packages can add quantities to every
    scene, as entry points of the group ``camopt.quantities``.
    """

    value: Annotated[
        str | None, Key('Expression over quantities, such as `"outer_radius_mm * torque_rms_N_m"`')
    ] = None
    function: Annotated[
        Annotated[str, BeforeValidator(check_one_line)] | None,
        Key(
            "Name of a Python function, in place of `value`: an entry point of the group "
            "`camopt.quantities`, or a name given to `camopt.quantity`. A name in a file never "
            "imports a module"
        ),
    ] = None
    columns: Annotated[
        tuple[str, ...], ListOrItem(single_value_as_list), Key("Quantities that the function takes, in order")
    ] = ()
    unit: Annotated[str, BeforeValidator(check_one_line), Key("Unit of the value, for headings and tables")] = ""
    sentence: Annotated[
        str,
        BeforeValidator(check_one_line),
        Key("Description of the quantity, for tables and reports; the expression if not given"),
    ] = ""


def expand_own_quantities(data: dict[str, Any]) -> None:
    """Replace each bare expression or function by a table, in ``data`` itself.

    Quantities of installed packages that the scene names are added.
    """
    given = data.get(OWN_EFFECT, {})
    if isinstance(given, list) and all(isinstance(each, QuantityFunction) for each in given):
        given = {each.name: each for each in given}
    if not isinstance(given, dict):
        return
    tables = {name: _table_of_quantity_definition(each) for name, each in given.items()}
    known = {*QUANTITIES, *tables, *FUNCTIONS, *CONSTANTS, *DISCIPLINES, EVERYTHING}
    if unknown := {name for name in _possible_quantity_names_in(data, tables) if name.isidentifier()} - known:
        tables = {
            name: _table_of_quantity_definition({"function": name})
            for name in installed_quantities()
            if name in unknown
        } | tables
    if tables:
        data[OWN_EFFECT] = tables


def _table_of_quantity_definition(definition: Any) -> Any:
    """The table of a defined quantity."""
    if isinstance(definition, QuantityFunction):
        return definition.table
    if isinstance(definition, str):
        return {"value": definition}
    name = definition.get("function") if isinstance(definition, dict) and "columns" not in definition else None
    if isinstance(name, str) and name in installed_quantities():
        with suppress(ValueError):  # reported when the quantity is computed
            return load_installed_quantity(name).table | definition
    return definition


def _possible_quantity_names_in(data: Mapping[str, Any], tables: Mapping[str, Any]) -> Iterator[str]:
    """The names of quantities in a scene, among other words."""
    yield from (key for key in table_named(data, "limits") if key not in Limits.model_fields)
    for key in ("search.minimise", "search.maximise", "outputs"):
        named = value_at_key(data, key)
        yield from (each for each in (named if isinstance(named, list) else [named]) if isinstance(each, str))
    for each in tables.values():
        value = each.get("value") if isinstance(each, Mapping) else None
        yield from WORD_PATTERN.findall(value[:MOST_CHARACTERS]) if isinstance(value, str) else ()


def own_quantities(tables: Mapping[str, QuantityExpression]) -> dict[str, OwnQuantity]:
    """The quantities that a checked scene defines, by name, each after those that it reads."""
    return {name: _own_quantity(name, *vars(each).values()) for name, each in tables.items()}


@lru_cache(maxsize=256)  # a search makes many scenes with the same quantities
def _own_quantity(
    name: str, value: str | None, function: str | None, columns: tuple[str, ...], unit: str, sentence: str
) -> OwnQuantity:
    if value is not None:
        tree: Any = parse_expression(value, lambda name: None)
        return OwnQuantity(name, "", unit, OWN_EFFECT, sentence or value, tree=tree)
    assert function is not None
    made_of, tree = f"{function} of {', '.join(columns)}", FunctionCall(name, function, columns)
    return OwnQuantity(name, "", unit, OWN_EFFECT, sentence or made_of, tree=tree)


# ----------------------------------------------------------------------------------------------------- checks


def check_own_quantities(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Every fault in the quantities that a scene defines, and in names that may refer to them."""
    tables = table_named(data, OWN_EFFECT)
    if len(tables) > MOST_QUANTITIES:
        yield OWN_EFFECT, None, f"has {len(tables):,} quantities; at most {MOST_QUANTITIES} are allowed"
        return
    names = [*tables]
    for place, (name, table) in enumerate(tables.items()):
        if why := _quantity_name_fault(name):
            yield OWN_EFFECT, name, why
        if isinstance(table, Mapping):
            check_name = partial(_refuse_name_unreadable_in_expression, names[:place], names[place:])
            yield from _check_quantity_table(f"{OWN_EFFECT}.{name}", table, check_name)
    yield from _check_objective_and_output_names(data, names)


def _check_quantity_table(key: str, table: Mapping[str, Any], check_name: Callable[[str], None]) -> Iterator[Fault]:
    """Check that a quantity has either an expression or a function with columns, and reads known quantities."""
    value, function, columns = (table.get(name) for name in ("value", "function", "columns"))
    if (value is None) == (function is None):
        yield key, None, "needs either a value or a function"
    elif value is None and not columns:
        yield f"{key}.columns", None, "missing; a function takes columns"
    elif function is None and columns:
        yield f"{key}.columns", columns, "is for a function; an expression names its quantities itself"
    if isinstance(value, str) and (why := _message_of_failed_check(parse_expression, value, check_name)):
        yield key, value, why
    for place, name in enumerate(columns if isinstance(columns, list) else (), start=1):
        if why := _message_of_failed_check(check_name, str(name)):
            yield f"{key}.columns.{place}", name, why


def _message_of_failed_check(check: Callable[..., Any], *arguments: Any) -> str:
    """The message of the ValueError that a check raises; empty without one."""
    try:
        check(*arguments)
    except ValueError as wrong:
        return str(wrong)
    return ""


def _quantity_name_fault(name: str) -> str:
    """Why a name cannot be that of a defined quantity; empty if it can."""
    if not QUANTITY_NAME.fullmatch(name) or len(name) > LONGEST_NAME or iskeyword(name):
        return f"the name of a quantity must be a letter, then letters, digits and _, at most {LONGEST_NAME} in all"
    if name in QUANTITIES:
        return "is a built-in quantity; give yours another name"
    if name in Limits.model_fields:
        return f"is the limit limits.{name}; give your quantity another name"
    if name in (*FUNCTIONS, *CONSTANTS, *DISCIPLINES, EVERYTHING, *RESULT_KEYS):
        return "has another meaning already; give your quantity another name"
    return ""


def _refuse_name_unreadable_in_expression(
    earlier_quantities: Collection[str], this_and_later_quantities: Collection[str], name: str
) -> None:
    """Raise ValueError if an expression may not read a name: this quantity, a later one, or an unknown one."""
    if name in this_and_later_quantities:
        raise ValueError(
            f"{name} must be defined above it in [{OWN_EFFECT}]: an expression reads only quantities above it"
        )
    if name in earlier_quantities:
        return
    if name not in QUANTITIES:
        meant = suggest_names(QUANTITY_SYNONYMS.get(name, name), (*earlier_quantities, *QUANTITIES))
        raise ValueError(f"{shorten(name)} is not a quantity; {meant}")
    if QUANTITIES[name].kind is not float or QUANTITIES[name].effect in VERDICTS:
        raise ValueError(f"{name} cannot be used: an expression reads only numerical quantities of a design")


def check_limit_keys(data: Mapping[str, Any]) -> Iterator[Fault]:
    """Check that the key of each limit is a short key or the name of a quantity."""
    own = table_named(data, OWN_EFFECT)
    for key, bound in table_named(data, "limits").items():
        if key not in Limits.model_fields and key not in own:
            yield f"limits.{key}", bound, unknown_key_message(str(key), Limits, own)


def _check_objective_and_output_names(
    data: Mapping[str, Any], own_quantity_names: Collection[str]
) -> Iterator[Fault]:
    """Check that objectives are quantities, and outputs quantities or effects."""
    allowed_names = {
        "search.minimise": ("a quantity", ()),
        "search.maximise": ("a quantity", ()),
        "outputs": ("a quantity, an effect (camopt effects lists them) or all", (*DISCIPLINES, EVERYTHING)),
    }
    for key, (what, others) in allowed_names.items():
        named = value_at_key(data, key)
        known = (*own_quantity_names, *QUANTITIES, *others)
        for place, name in enumerate(named if isinstance(named, list) else [named], start=1):
            if isinstance(name, str) and name not in known and name not in QUANTITIES:
                yield (
                    f"{key}.{place}",
                    name,
                    f"must be {what}; {suggest_names(QUANTITY_SYNONYMS.get(name, name), known)}",
                )
