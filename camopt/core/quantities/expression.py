"""Expressions of quantities in a scene, parsed into a tree and never run as Python.

Python's own parser reads the text without running it. Only numbers, names, arithmetic and the functions listed here
are accepted. The length of the text is checked first, because the parser is recursive.
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
"""Names, numbers and signs, which are counted before the text is parsed."""
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
"""Number of arguments of each function; for min and max, the smallest number."""
CONSTANTS = {"pi": float(np.pi)}
WHAT_IS_ALLOWED = f"allowed are numbers, quantities, + - * / **, parentheses, {', '.join(FUNCTIONS)} and pi"
SIGN_NODES = (ast.operator, ast.unaryop, ast.expr_context)
"""Nodes of the parser that only mark an operator or the use of a name. They are not counted."""
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
"""Operators and functions for numbers and arrays."""


class ExpressionNode(NamedTuple):
    """A node of the tree: a number, a name, or an operator or function with its arguments."""

    rule: str
    """Operator or function; empty for a number or a name."""
    value: float | str = 0.0
    parts: "tuple[ExpressionNode, ...]" = ()

    def evaluate(self, values_by_name: Mapping[str, Any], rules: ExpressionRules = DOUBLE_RULES) -> Any:
        """Value of the expression, from the values of its names."""
        if self.rule:
            return rules[self.rule](*(part.evaluate(values_by_name, rules) for part in self.parts))
        return values_by_name[self.value] if isinstance(self.value, str) else self.value

    @property
    def names(self) -> tuple[str, ...]:
        """Quantities that the expression reads, each once."""
        here = (self.value,) if isinstance(self.value, str) else ()
        return tuple(dict.fromkeys([*here, *(name for part in self.parts for name in part.names)]))


def parse_expression(text: str, check_name: Callable[[str], None]) -> ExpressionNode:
    """Parse an expression into its tree; ``check_name`` raises a ValueError for a name that is not allowed.

    Raises
    ------
    ValueError
        If the text is no allowed expression. Its message is the end of a sentence.
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
            f"is not an expression, such as 'outer_radius_mm * torque_rms_N_m'; {WHAT_IS_ALLOWED}"
        ) from None
    if (count := sum(not isinstance(node, SIGN_NODES) for node in ast.walk(body))) > MOST_NODES:
        raise ValueError(f"has {count:,} nodes; at most {MOST_NODES} are allowed")
    tree = _parse_node(body, check_name)
    _checked_constant_value(tree)
    return tree


def _parse_node(node: ast.AST, check_name: Callable[[str], None]) -> ExpressionNode:
    match node:
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
            raise ValueError(f"{shorten(name)} is not a known function; {suggest_names(name, FUNCTIONS)}")
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            parts = tuple(_parse_node(argument, check_name) for argument in arguments)
            return ExpressionNode(name, parts=_with_checked_argument_count(name, parts))
    raise ValueError(f"{shorten(ast.unparse(node))} is not allowed; {WHAT_IS_ALLOWED}")


def _finite_number(value: float) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = np.inf
    if not np.isfinite(number):
        raise ValueError("has a number beyond 1.8e308; numbers must be finite")
    return number


def _with_checked_argument_count(name: str, parts: tuple[ExpressionNode, ...]) -> tuple[ExpressionNode, ...]:
    least, many = FUNCTIONS[name], name in ("min", "max")
    if len(parts) < least or (len(parts) > least and not many):
        count = f"{least}{' or more' if many else ''} argument{'s' if least > 1 else ''}"
        raise ValueError(f"{name} takes {count}, not {len(parts)}")
    return parts


def _checked_constant_value(tree: ExpressionNode) -> float | None:
    """Value of a part without names, which must be finite; None for a part with names."""
    values = [_checked_constant_value(part) for part in tree.parts]
    if tree.rule == "/" and values[1] == 0.0:
        raise ValueError("divides by zero")
    if isinstance(tree.value, str) or None in values:
        return None
    with np.errstate(all="ignore"):
        value = float(DOUBLE_RULES[tree.rule](*values)) if tree.rule else tree.value
    if not np.isfinite(value):
        arguments = " and ".join(f"{number:g}" for number in values)
        raise ValueError(f"has no finite value: {tree.rule} of {arguments} has none")
    return value
