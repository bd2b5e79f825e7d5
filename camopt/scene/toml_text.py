"""Parse the TOML text of a scene; faults name their line and a likely cause."""

import re
import tomllib
from typing import Any

from pydantic import BaseModel

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.files import decode_user_text

DEEPEST_NESTING = 16  # tables within tables; a scene has five
ERROR_PLACE = re.compile(r" \(at line (\d+), column \d+\)$")
NUMBER_WITH_UNIT = re.compile(
    r"\s*[-+]?\d+(\.\d+)?(e[-+]?\d+)?((\s+\d+)?/[1-9]\d*)?\s*(1/)?[a-zA-Zµ°%].*", re.DOTALL
)
"""A number with a unit, such as ``1.5 in`` or ``1 1/2 in``, allowed as a text in place of a number."""
ILLEGAL_LINE_END, NO_CLOSING_QUOTE = r"Illegal character '\n'", "a text has no closing quote"
"""How the parser words a line that ends within a text, and what the user reads in place of it."""
SYNTAX_HINTS = {
    r"[\u2018-\u201f\u00ab\u00bb]": "a text has straight quotes, \" or '",
    r"[=\[,]\s*[-+]?\d+,\d+\s*(#|$)": "a number has a decimal point, not a comma",
    r"[=\[,]\s*[-+]?(\.\d|\d+\.(?!\d))": "a number has digits on both sides of its decimal point",
    r"[=\[,]\s*[-+]?\d[\d.]*(e[-+]?\d+)?\s*([^\W\d_]|[°µ%])": "a number with a unit is a text: in quotes",
    r"^\s*[\w.-]+\s*[:;]": "a key and its value have = between them",
    r"=\s*[^\W\d]": "a text is in quotes, and a switch is true or false",
}


def parse_toml(data: bytes | str, file: str) -> dict[str, Any]:
    """The tables in the text of a scene.

    Raises
    ------
    BadInput
        If the text is not TOML in UTF-8, with the wrong line; if tables are nested too deep.
    """
    try:
        text = data if isinstance(data, str) else decode_user_text(data)
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _toml_mistake(file, _error_with_line(text, str(error))) from None
    except ValueError as error:  # not UTF-8, or a number with too many digits
        raise _toml_mistake(file, str(error)) from None
    except RecursionError:
        raise _toml_mistake(file, "tables or lists are nested too deep") from None
    return tables


def _toml_mistake(file: str, reason: str) -> BadInput:
    return BadInput([Mistake(file, "TOML", None, f"not valid: {reason}", bare=True)])


def _error_with_line(text: str, error: str) -> str:
    """A parser's message with its line and, where known, the rule that it breaks."""
    place = ERROR_PLACE.search(error)
    if not place:
        return error
    number = int(place[1])
    line = text.split("\n")[number - 1].strip()
    hint = next(
        (hint for pattern, hint in SYNTAX_HINTS.items() if re.search(pattern, line)),
        NO_CLOSING_QUOTE if error.startswith(ILLEGAL_LINE_END) else ERROR_PLACE.sub("", error),
    )
    return f"line {number}, {line!r}: {hint}"


def plain_mappings_and_lists(value: Any, file: str, depth: int = 0) -> Any:
    """Tables as mappings and tuples as lists, so that input from Python and TOML gets the same checks."""
    if depth > DEEPEST_NESTING:
        raise BadInput([Mistake(file, "scene", None, "tables or lists are nested too deep", bare=True)])
    if isinstance(value, BaseModel):
        return plain_mappings_and_lists(value.model_dump(exclude_none=True, exclude_defaults=True), file, depth)
    if isinstance(value, dict):
        return {str(key): plain_mappings_and_lists(each, file, depth + 1) for key, each in value.items()}
    return (
        [plain_mappings_and_lists(each, file, depth + 1) for each in value]
        if isinstance(value, (list, tuple))
        else value
    )


def has_unit_text(value: Any) -> bool:
    """Whether any text within a value looks like a number with a unit."""
    if isinstance(value, dict):
        return any(map(has_unit_text, value.values()))
    return (
        any(map(has_unit_text, value))
        if isinstance(value, list)
        else isinstance(value, str) and bool(NUMBER_WITH_UNIT.fullmatch(value))
    )
