"""Rows of tables as designs: the columns that a scene reads, and the checks of their values."""

import warnings
from collections.abc import Collection, Container, Mapping, Sequence
from math import isnan
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake, join_words, similar_name, suggest_names
from camopt.core.quantities import QUANTITIES
from camopt.model.motion import LAWS
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.own_quantities import RESULT_KEYS
from camopt.scene.turn import segments_and_programme_of_scene

if TYPE_CHECKING:
    from camopt.scene.scene import Scene

ROW_WORD = "row"  # the name of a row in messages
LAW_NAME_COLUMNS = ("law", "law_rise", "law_return")
"""Columns with the law of all strokes, of the rises, and of the returns."""
ANGLES_COLUMN = "angles_deg"
"""The column with the angles of all segments."""
EXCESS_PREFIX = "excess_"  # before the name of a limit: the column of its excess
NO_DESIGN = "this mechanism has no such size, number or law"
"""The message for a column that no scene of a mechanism reads."""
OTHER_KEYS = ("objective", "gap", "convex", "change", "table")
"""Columns of a synthesis or a comparison that are not quantities; ``RESULT_KEYS`` has further ones."""
DERIVED_SIZES = ("prime_radius_mm", "shaft_clearance_mm")  # sums and differences of other sizes


def values_of_row(row: Any) -> dict[str, Any]:
    """The values of a row by column; in a DataFrame of one row, named levels of the index are columns too."""
    if hasattr(row, "iloc") and hasattr(row, "columns") and len(row) == 1:
        return index_level_values_at_place(row.index, 0) | values_of_row(row.iloc[0])
    if isinstance(row, Mapping) or (hasattr(row, "dropna") and not hasattr(row, "columns")):
        return {str(name): value for name, value in dict(row).items()}
    raise BadInput([Mistake("camopt", ROW_WORD, None, f"one row of a table; this is a {type(row).__name__}")])


def index_level_values_at_place(index: Any, place: int) -> dict[str, Any]:
    """The values of the named levels of a pandas index, at one place."""
    levels = [index.get_level_values(level) for level in range(index.nlevels)]
    return {str(level.name): level[place] for level in levels if level.name is not None}


def has_embedded_scene(row: Mapping[str, Any]) -> bool:
    """Whether a row contains a scene as TOML."""
    return "\n" in str(row.get("scene", ""))


def is_missing(value: Any) -> bool:
    """Whether a value of a table is missing: None, NaN or a missing value of pandas."""
    if isinstance(value, Real):
        return isnan(value)
    return value is None or type(value).__name__ in ("NAType", "NaTType", "MaskedConstant")


def check_design_row(scene: "Scene", values: Mapping[str, Any]) -> None:
    """Raise BadInput unless a row has a column of a design, with values that the scene allows."""
    columns = scene.row_columns
    known = (*columns.values(), *LAW_NAME_COLUMNS, ANGLES_COLUMN)
    if not values.keys() & {*known}:
        raise design_column_error(values, known, ROW_WORD)
    # a number that the scene lacks may be missing: a table of several scenes has columns of all of them
    given, sizes = scene.numbers(columns), scene.size_fields
    required = [name for key, name in columns.items() if key in sizes or given[key] is not None]
    mistakes = [
        Mistake(ROW_WORD, name, None, "missing", bare=True)
        for name in (*required, *LAW_NAME_COLUMNS)
        if name in values and is_missing(values[name])
    ]
    laws = (*LAWS, *scene.laws)
    for name in LAW_NAME_COLUMNS:
        law = values.get(name)
        if not is_missing(law) and law not in laws and law not in _law_column_texts_of_scene_motion(scene):
            mistakes.append(Mistake(ROW_WORD, name, law, f"a motion law; {suggest_names(str(law), laws)}"))
    if mistakes:
        raise BadInput(mistakes)
    angles: Any = values.get(ANGLES_COLUMN)
    count, shape = len(scene.motion), np.asarray(angles, dtype=object).shape
    if not is_missing(angles) and (isinstance(angles, str) or shape != (count,)):
        raise BadInput([Mistake(ROW_WORD, ANGLES_COLUMN, angles, f"the angles of the {count} segments")])


def design_column_error(wrong_columns: Collection[str], known_columns: Collection[str], file: str) -> BadInput:
    """The error for columns that no scene of a mechanism reads, or for a row without columns."""
    if not wrong_columns:
        why = f"a {file if file == ROW_WORD else 'table'} with a size, a number or a law of this mechanism"
        return BadInput([Mistake("camopt", file, None, f"{why}; {suggest_names('', known_columns)}")])
    return BadInput(
        Mistake(file, n, None, f"{NO_DESIGN}; {suggest_names(n, known_columns)}", bare=True) for n in wrong_columns
    )


def unknown_columns(scene: "Scene", names: Collection[str]) -> list[str]:
    """The columns that are no quantities of camopt or of the scene, and no other columns of results.

    Sizes of other mechanisms are unknown too.
    """
    if not names:
        return []
    known = {
        *RESULT_KEYS,
        *OTHER_KEYS,
        *DERIVED_SIZES,
        *LAW_NAME_COLUMNS,
        *scene.quantities,
        *scene.row_columns.values(),
        *scene.mechanism.size_quantity_by_field.values(),
        *(name for name, each in QUANTITIES.items() if each.effect != "sizes"),
    }
    return [name for name in names if name not in known and not name.startswith(EXCESS_PREFIX)]


def warn_of_unknown_columns(
    unknown: Sequence[str], known_columns: Collection[str], present_columns: Container[str], file: str
) -> None:
    """Warn the caller of a function of unknown columns, with suggestions that are not columns already."""
    likes = {name: similar_name(name, known_columns) for name in unknown}
    shown = [
        f"{n} (did you mean {like}?)" if like and like not in present_columns else n for n, like in likes.items()
    ]
    warnings.warn(f"{file}: camopt ignores {join_words(shown)}: {NO_DESIGN}", stacklevel=3)


def _law_column_texts_of_scene_motion(scene: "Scene") -> tuple[str, ...]:
    """The names that tables have for the laws of a motion, of rises and of returns; "" for no law."""
    turn = segments_and_programme_of_scene(scene)
    return ("",) if turn is None else ("", turn[1].law_names(RISE), turn[1].law_names(RETURN))
