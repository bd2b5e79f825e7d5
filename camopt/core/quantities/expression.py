"""Expressions over quantities, as a scene writes them: parsed into a tree, never run as Python.

A text is read by Python's own parser, which runs nothing; then only numbers, names, arithmetic and the functions
listed here are let through. Bounds on the text hold before the parser sees it, for it works by recursion.
"""

import ast
import re
import warnings
from collections.abc import Callable, Mapping
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import shorten, suggest_names

MOST_CHARACTERS, MOST_WORDS, MOST_NODES = 4000, 1000, 200
WORD_PATTERN = re.compile(r"\w+|\*\*|[^\w\s]")
"""What texts are counted in before they are parsed: names, numbers and signs."""
OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "**",
    ast.USub: "neg",
}
FUNCTIONS = {
    "abs": 1,
    "sqrt": 1,
    "min": 2,
    "max": 2,
    "sin": 1,
    "cos": 1,
    "tan": 1,
    "asin": 1,
    "acos": 1,
    "atan": 1,
    "atan2": 2,
    "radians": 1,
    "degrees": 1,
}
"""How many arguments each function takes; of min and max so many at least."""
CONSTANTS = {"pi": float(np.pi)}
WHAT_IS_ALLOWED = f"allowed are numbers, quantities, + - * / **, parentheses, {', '.join(FUNCTIONS)} and pi"
SIGN_NODES = (ast.operator, ast.unaryop, ast.expr_context)
"""What the parser makes nodes of that only say which operator another node is, or how a name is used."""
ExpressionRules = Mapping[str, Callable[..., Any]]
DOUBLE_RULES: ExpressionRules = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.true_divide,
    "**": np.power,
    "neg": np.negative,
    "abs": np.absolute,
    "sqrt": np.sqrt,
    "min": lambda *values: reduce(np.minimum, values),
    "max": lambda *values: reduce(np.maximum, values),
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "radians": np.radians,
    "degrees": np.degrees,
}
"""What operators and functions are on numbers and arrays of them."""


class ExpressionNode(NamedTuple):
    """A node of the tree: a number, a name, or an operator or function with what it takes."""

    rule: str
    """Of a number and a name empty."""
    value: float | str = 0.0
    parts: "tuple[ExpressionNode, ...]" = ()

    def evaluate(self, names: Mapping[str, Any], rules: ExpressionRules = DOUBLE_RULES) -> Any:
        """Its value, from those of the names."""
        if self.rule:
            return rules[self.rule](*(part.evaluate(names, rules) for part in self.parts))
        return names[self.value] if isinstance(self.value, str) else self.value

    @property
    def names(self) -> tuple[str, ...]:
        """The quantities that it reads, each once."""
        own = (self.value,) if isinstance(self.value, str) else ()
        return tuple(dict.fromkeys([*own, *(name for part in self.parts for name in part.names)]))


def parse_expression(text: str, check_name: Callable[[str], None]) -> ExpressionNode:
    """The tree of an expression; ``check_name`` raises a ValueError for a name that it may not have.

    Raises
    ------
    ValueError
        With what is wrong, as the end of a message.
    """
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"has {len(text):,} characters; at most {MOST_CHARACTERS:,} are allowed")
    if (words := len(WORD_PATTERN.findall(text))) > MOST_WORDS:
        raise ValueError(f"has {words:,} names, numbers and signs; at most {MOST_NODES} nodes are allowed")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            body = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(
            f"is no expression, such as 'outer_radius_mm * torque_rms_N_m'; {WHAT_IS_ALLOWED}"
        ) from None
    if (count := sum(not isinstance(each, SIGN_NODES) for each in ast.walk(body))) > MOST_NODES:
        raise ValueError(f"has {count:,} nodes; at most {MOST_NODES} are allowed")
    tree = _parse_node(body, check_name)
    _check_constants(tree)
    return tree


def _parse_node(each: ast.AST, check_name: Callable[[str], None]) -> ExpressionNode:
    match each:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return ExpressionNode("", _finite_number(value))
        case ast.Name(id=name) if name in CONSTANTS:
            return ExpressionNode("", CONSTANTS[name])
        case ast.Name(id=name) if name in FUNCTIONS:
            raise ValueError(f"{name} is a function: give it arguments, as in {name}(…)")
        case ast.Name(id=name):
            check_name(name)
            return ExpressionNode("", name)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            return ExpressionNode(
                OPERATORS[type(op)], parts=(_parse_node(left, check_name), _parse_node(right, check_name))
            )
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _parse_node(operand, check_name)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return ExpressionNode("neg", parts=(_parse_node(operand, check_name),))
        case ast.Call(func=ast.Name(id=name)) if name not in FUNCTIONS:
            raise ValueError(f"{shorten(name)} is no function here; {suggest_names(name, FUNCTIONS)}")
        case ast.Call(func=ast.Name(id=name), args=given, keywords=[]):
            return ExpressionNode(
                name, parts=_checked_arguments(name, tuple(_parse_node(part, check_name) for part in given))
            )
    raise ValueError(f"{shorten(ast.unparse(each))} is not allowed; {WHAT_IS_ALLOWED}")


def _finite_number(value: float) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = np.inf
    if not np.isfinite(number):
        raise ValueError("has a number beyond 1.8e308; numbers are finite")
    return number


def _checked_arguments(name: str, parts: tuple[ExpressionNode, ...]) -> tuple[ExpressionNode, ...]:
    least, many = FUNCTIONS[name], name in ("min", "max")
    if len(parts) < least or (len(parts) > least and not many):
        count = f"{least}{' or more' if many else ''} argument{'s' if least > 1 else ''}"
        raise ValueError(f"{name} takes {count}, and has {len(parts)} here")
    return parts


def _check_constants(tree: ExpressionNode) -> float | None:
    """The value of a part without names, which has to be finite; None of another part."""
    values = [_check_constants(part) for part in tree.parts]
    if tree.rule == "/" and values[1] == 0.0:
        raise ValueError("divides by zero")
    if isinstance(tree.value, str) or None in values:
        return None
    with np.errstate(all="ignore"):
        value = float(DOUBLE_RULES[tree.rule](*values)) if tree.rule else tree.value
    if not np.isfinite(value):
        of = " and ".join(f"{each:g}" for each in values)
        raise ValueError(f"has no finite value: {tree.rule} of {of} has none")
    return value
