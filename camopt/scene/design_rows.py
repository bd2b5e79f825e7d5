"""A row of a table as a design: the columns that a scene reads, and what is wrong with their values."""

import warnings
from collections.abc import Collection, Container, Iterator, Mapping, Sequence
from math import isnan
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake, join_words, similar_name, suggest_names
from camopt.core.quantities import QUANTITIES
from camopt.model.motion import LAWS
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.own_quantities import RESULT_KEYS
from camopt.scene.turn import turn_of_scene

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

ROW_WORD = "row"  # what messages call the row
LAW_NAME_COLUMNS = ("law", "law_rise", "law_return")
"""Columns with the law of all strokes, of the rises, and of the returns."""
ANGLES_COLUMN = "angles_deg"
"""The column with the angles of all segments."""
EXCESS_PREFIX = "excess_"  # before the name of a limit: the column of its excess
NO_DESIGN = "no size or number of this mechanism and no law"
"""What is wrong with a column that no scene of a mechanism reads."""
OTHER_KEYS = ("objective", "gap", "convex", "change", "table")
"""Columns of a synthesis and of a comparison that are no quantities; ``RESULT_KEYS`` has the others."""
DERIVED_SIZES = ("prime_radius_mm", "shaft_clearance_mm")  # sums and differences of other sizes


def values_of_row(row: Any) -> dict[str, Any]:
    """The values of a row by column; of a DataFrame of one row the named levels of its index are columns too."""
    if hasattr(row, "iloc") and hasattr(row, "columns") and len(row) == 1:
        return values_of_index(row.index, 0) | values_of_row(row.iloc[0])
    if isinstance(row, Mapping) or (hasattr(row, "dropna") and not hasattr(row, "columns")):
        return {str(name): value for name, value in dict(row).items()}
    raise BadInput([Mistake("camopt", ROW_WORD, None, f"one row of a table; this is a {type(row).__name__}")])


def values_of_index(index: Any, place: int) -> dict[str, Any]:
    """The values of the named levels of an index of pandas, at one place."""
    levels = [index.get_level_values(level) for level in range(index.nlevels)]
    return {str(level.name): level[place] for level in levels if level.name is not None}


def has_scene(row: Mapping[str, Any]) -> bool:
    """Whether a row has a scene of its own, as TOML."""
    return "\n" in str(row.get("scene", ""))


def is_missing(value: Any) -> bool:
    """Whether a value of a table is missing: None, not a number, or what pandas has in place of these."""
    if isinstance(value, Real):
        return isnan(value)
    return value is None or type(value).__name__ in ("NAType", "NaTType", "MaskedConstant")


def check_row(scene: "Scene", values: Mapping[str, Any]) -> None:
    """BadInput unless a row has a column of a design, and in each a value that a scene may have there."""
    columns = scene.row_columns
    known = (*columns.values(), *LAW_NAME_COLUMNS, ANGLES_COLUMN)
    if not values.keys() & {*known}:
        raise design_column_mistakes(values, known, ROW_WORD)
    if mistakes := [*_missing_value_mistakes(scene, columns, values), *_unknown_law_mistakes(scene, values)]:
        raise BadInput(mistakes)
    angles: Any = values.get(ANGLES_COLUMN)
    count, shape = len(scene.motion), np.asarray(angles, dtype=object).shape
    if not is_missing(angles) and (isinstance(angles, str) or shape != (count,)):
        raise BadInput([Mistake(ROW_WORD, ANGLES_COLUMN, angles, f"the angles of the {count} segments")])


def design_column_mistakes(names: Collection[str], known: Collection[str], file: str) -> BadInput:
    """What is wrong with columns of which no scene of a mechanism reads any, or with one of them."""
    if not names:
        why = f"a {file if file == ROW_WORD else 'table'} with a size, a number or a law of this mechanism"
        return BadInput([Mistake("camopt", file, None, f"{why}; {suggest_names('', known)}")])
    return BadInput(Mistake(file, n, None, f"{NO_DESIGN}; {suggest_names(n, known)}", bare=True) for n in names)


def unknown_columns(scene: "Scene", names: Collection[str]) -> list[str]:
    """The columns that are neither quantities of camopt or of the scene, nor what results have beside these.

    A size of another mechanism is none of this one's quantities.
    """
    if not names:
        return []
    own = {
        *RESULT_KEYS,
        *OTHER_KEYS,
        *DERIVED_SIZES,
        *LAW_NAME_COLUMNS,
        *scene.quantities,
        *scene.row_columns.values(),
    }
    own |= {*scene.mechanism.size_quantities.values()}
    own |= {name for name, each in QUANTITIES.items() if each.effect != "sizes"}
    return [name for name in names if name not in own and not name.startswith(EXCESS_PREFIX)]


def warn_of_unknown_columns(odd: Sequence[str], known: Collection[str], given: Container[str], file: str) -> None:
    """One warning to the caller of a function, with the columns that may have been meant and are not there."""
    likes = {name: similar_name(name, known) for name in odd}
    shown = [f"{n} (did you mean {like}?)" if like and like not in given else n for n, like in likes.items()]
    warnings.warn(f"{file}: camopt ignores {join_words(shown)}: {NO_DESIGN}", stacklevel=3)


def _missing_value_mistakes(
    scene: "Scene", columns: Mapping[str, str], values: Mapping[str, Any]
) -> Iterator[Mistake]:
    """Sizes and laws that are missing in a row, and numbers for which the scene would bring its own.

    Tables of several scenes that stand after each other lack numbers that one of them does not have.
    """
    given, sizes = scene.numbers(columns), scene.size_fields
    asked = [name for key, name in columns.items() if key in sizes or given[key] is not None]
    for name in (*asked, *LAW_NAME_COLUMNS):
        if name in values and is_missing(values[name]):
            yield Mistake(ROW_WORD, name, None, "missing", bare=True)


def _unknown_law_mistakes(scene: "Scene", values: Mapping[str, Any]) -> Iterator[Mistake]:
    """Laws that the scene does not have; a name of several laws may be that of its own motion."""
    known = (*LAWS, *scene.laws)
    for name in LAW_NAME_COLUMNS:
        law = values.get(name)
        if not is_missing(law) and law not in known and law not in _own_law_names(scene):
            yield Mistake(ROW_WORD, name, law, f"a motion law; {suggest_names(str(law), known)}")


def _own_law_names(scene: "Scene") -> tuple[str, ...]:
    """The laws of the rises and of the returns of a motion, as tables name them; none has the name ""."""
    turn = turn_of_scene(scene)
    return ("",) if turn is None else ("", turn[1].law_names(RISE), turn[1].law_names(RETURN))
