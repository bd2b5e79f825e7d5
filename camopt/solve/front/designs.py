"""``camopt.evaluate_designs``: a table of designs from any program, evaluated at once, for other optimisers.

A sweep evaluates its own grid; here each row of a table is a design. A scene is resolved only once, so that an
optimiser can evaluate one design at a time.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.numerics import IndexArray
from camopt.core.numerics.identity_cache import cached_by_identity
from camopt.core.quantities import QUANTITIES, in_column_order
from camopt.model.effects import EvaluationBlock, find_quantity
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.design_rows import (
    ANGLES_COLUMN,
    DERIVED_SIZES,
    EXCESS_PREFIX,
    LAW_NAME_COLUMNS,
    design_column_error,
    has_embedded_scene,
    unknown_columns,
    warn_of_unknown_columns,
)
from camopt.scene.problem.limit import ASSEMBLY
from camopt.scene.problem.problem import Problem, missing_variable_mistakes, resolve
from camopt.scene.problem.rows import VERDICT_COLUMNS, DesignRows, scatter_rows
from camopt.scene.problem.settings import (
    given_profile_mistakes,
    problem_with_searched_numbers_per_design,
    problems_in_settings,
)
from camopt.scene.problem.variables import Variable
from camopt.scene.pydantic_mistakes import mistakes_from_pydantic
from camopt.scene.scene import Scene
from camopt.scene.tables import Cam, Drive, Dynamics, Follower, Materials, SceneTable
from camopt.scene.train import TrainStage
from camopt.solve.front.design_columns import DESIGNS_LABEL, DesignColumns, read_design_columns
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_verdicts import (
    CERTIFIED,
    evaluate_with_verdicts_and_effort,
    relative_excesses_by_limit,
)

if TYPE_CHECKING:
    import pandas as pd

TABLE_TYPES: dict[str, type[SceneTable]] = {
    "cam": Cam,
    "follower": Follower,
    "follower.dynamics": Dynamics,
    "drive": Drive,
    "materials": Materials,
    "train": TrainStage,
}
LAWS_OF_STROKES = (("law_rise", "law"), ("law_return", "law"))
"""Columns with the law of the rises, and columns with the law of the returns."""
UNASSEMBLED_VALUES = {"violated": ASSEMBLY, "status": CERTIFIED}
"""The values of designs that cannot be assembled; their numbers are infinite, and they are not feasible."""
ROW_SCENE_COLUMN = "scene"  # the column with scenes of rows
SCENE_ADVICE = "pass each row to scene_of, and its scene to evaluate"
CACHED_SCENES, CACHED_MOTIONS = 4, 256  # scenes and motions whose results are cached


def evaluate_designs(
    scene: SceneSource, designs: Any, *, names: Iterable[str] | None = None, strict: bool = False
) -> "pd.DataFrame":
    """Compute the quantities of many designs, and the excess of each over every limit.

    A scene is resolved once: later calls with the same scene take a few milliseconds.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        Everything that the designs share: motion, limits, ``outputs``, and the sizes, laws and other numbers that
        ``designs`` does not have.
    designs : table, mapping, sequence of mappings or array
        A row for each design: a table of pandas, polars or pyarrow, a mapping of columns, a list of mappings, or an
        array with ``names``. A mapping of single values, a pandas Series and a 1-D array are one design.
        Columns are sizes of the scene's mechanism (``base_radius_mm``, ``offset_mm``, ``roller_radius_mm`` and so
        on), names of laws (``law``, or ``law_rise`` and ``law_return``), and other numbers of the scene that
        ``[search]`` accepts (``spring_rate_N_per_mm``, ``face_width_mm`` and so on). Named levels of a pandas index
        are columns too. Rows of camopt's own tables are accepted unchanged; their other quantities are recomputed.
    names : str or iterable of str, optional
        The columns of an array, in their order.
    strict : bool, default False
        Whether a column that is not a quantity of camopt raises an error. If False, one warning names such columns.

    Returns
    -------
    pandas.DataFrame
        A row for each design, in the same order and with the same index. Its columns are the quantities of
        ``evaluate`` for the scene, to its ``[accuracy] relative_error``, with ``feasible``, ``violated``,
        ``status`` and ``relative_half_width``. For each limit, ``excess_…`` is the excess relative to its bound: 0
        or less if the limit is met, apart from that error. If a design cannot be assembled, all its numbers except
        the sizes are infinite, and ``violated`` is "assembly". ``attrs`` has the ``units`` and the ``scene``, for
        ``scene_of``.

    Raises
    ------
    BadInput
        For a table without a column of a size, number or law of the mechanism. For a value that a scene would not
        accept. For a size or searched number that neither the scene nor ``designs`` has. For angles of segments,
        and for rows with scenes of their own, which ``scene_of`` reads. With ``strict``, for every column that is
        not a quantity of camopt.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm")
    >>> table = camopt.evaluate_designs(scene, {"base_radius_mm": [60, 90], "law": ["cycloidal", "poly345"]})
    >>> table["violated"].tolist(), table["excess_pressure_angle"].round(3).tolist()
    (['pressure_angle', ''], [0.312, -0.017])
    >>> one = camopt.evaluate_designs(scene, [90, 10], names=["base_radius_mm", "offset_mm"])
    >>> one["base_radius_mm"].tolist()
    [90.0]
    """
    import pandas as pd

    scene = scene_from(scene)
    scene_problem = resolve(scene)
    columns = _variables_by_column(scene_problem)
    table = _read_designs(designs, columns, names)
    known = (*columns, *LAW_NAME_COLUMNS)
    unknown = unknown_columns(scene, table.others)
    if (not table.values and (table.others or table.count)) or (unknown and strict):
        raise design_column_error(unknown or table.others, known, DESIGNS_LABEL)
    if unknown:
        warn_of_unknown_columns(unknown, known, table.values, DESIGNS_LABEL)
    varied = _variables_with_table_columns(columns, table)
    rows = _designs_from_table(scene_problem, table, varied)
    problem = _problem_varying_table_numbers(scene, scene_problem, varied, table)
    wanted = problem.evaluated_quantities | problem.size_quantity_names | frozenset(VERDICT_COLUMNS)
    motions = _problems_and_rows_by_motion(scene_problem, problem, table)
    parts = [
        part
        for motion, index in motions
        for part in _evaluate_designs_of_one_motion(motion, rows.take(index), index, wanted)
    ]
    values = scatter_rows(parts, table.count).columns
    quantities = {name: find_quantity(name, scene_problem.setup) for name in in_column_order(wanted)}
    columns_in_order = [*quantities, *(f"{EXCESS_PREFIX}{limit.name}" for limit in problem.limits)]
    if not table.count:  # without rows pandas would not know the columns of texts
        values |= {name: values[name].astype(quantity.kind) for name, quantity in quantities.items()}
    frame = pd.DataFrame({name: values[name] for name in columns_in_order}, index=table.labels)
    units = {name: quantity.unit for name, quantity in quantities.items()}
    frame.attrs = {"units": units, "scene": _scene_toml(scene)}
    return frame


def check_columns_that_define_designs(scene: Scene, designs: "pd.DataFrame") -> None:
    """BadInput unless the columns that define the designs of a table are valid for a scene; others are ignored."""
    problem = resolve(scene)
    columns = _variables_by_column(problem)
    if missing := sorted(problem.size_quantity_names - {*DERIVED_SIZES, *designs}):
        raise BadInput([Mistake(DESIGNS_LABEL, name, None, "missing", bare=True) for name in missing])
    table = _read_designs(designs, columns)
    varied = _variables_with_table_columns(columns, table)
    _designs_from_table(problem, table, varied)
    _problem_varying_table_numbers(scene, problem, varied, table)


@cached_by_identity(maxsize=CACHED_SCENES)
def _scene_toml(scene: Scene) -> str:
    return scene.to_toml()


@cached_by_identity(maxsize=CACHED_SCENES)
def _variables_by_column(problem: Problem) -> Mapping[str, Variable]:
    """The variables of a problem by the names of their columns; sizes also by their keys in the scene."""
    sizes = {f"{each.name}_mm": each for each in problem.variables if each.is_size}
    return sizes | {each.quantity: each for each in problem.variables}


def _read_designs(
    designs: Any, known_columns: Collection[str], names: Iterable[str] | None = None
) -> DesignColumns:
    """The columns that define the designs of a table; BadInput for angles, and for scenes of rows."""
    table = read_design_columns(designs, {*known_columns, *LAW_NAME_COLUMNS, ROW_SCENE_COLUMN}, names)
    scenes = table.values.pop(ROW_SCENE_COLUMN, None)
    if scenes is not None and any(has_embedded_scene({ROW_SCENE_COLUMN: scene}) for scene in scenes.tolist()):
        why = f"each row has a scene of its own: {SCENE_ADVICE}"
        raise BadInput([Mistake(DESIGNS_LABEL, ROW_SCENE_COLUMN, None, why, bare=True)])
    if ANGLES_COLUMN in table.others:
        why = f"here all designs have the angles of the scene: {SCENE_ADVICE}"
        raise BadInput([Mistake(DESIGNS_LABEL, ANGLES_COLUMN, None, why, bare=True)])
    return table if scenes is None else replace(table, others=[*table.others, ROW_SCENE_COLUMN])


def _variables_with_table_columns(columns: Mapping[str, Variable], table: DesignColumns) -> dict[str, Variable]:
    if "law" in table.values and ("law_rise" in table.values or "law_return" in table.values):
        raise BadInput(
            [Mistake(DESIGNS_LABEL, "law", None, "must stand alone, without law_rise and law_return", bare=True)]
        )
    return {name: columns[name] for name in table.values if name in columns}


def _designs_from_table(
    problem: Problem, table: DesignColumns, varied_by_column: Mapping[str, Variable]
) -> Designs:
    """The designs of a table, with the scene's own sizes and searched numbers where the table has none."""
    values = table.values
    mistakes = [
        *(
            mistake
            for name, each in varied_by_column.items()
            for mistake in _column_value_mistakes(each.key, name, table)
        ),
        *(
            mistake
            for name in values
            if name in LAW_NAME_COLUMNS
            for mistake in _law_mistakes(problem, name, table)
        ),
        *missing_variable_mistakes(problem, {each.key for each in varied_by_column.values()}),
    ]
    if mistakes:
        raise BadInput(mistakes)
    defaults = {
        each.field: problem.setup.given[each.key] for each in problem.search_space.numbers if each.varies_by_design
    }
    defaults |= {name: value[0] for name, value in problem.design.sizes.items()}
    columns = {name: np.full(table.count, value) for name, value in defaults.items()}
    tabled = {
        name: each
        for name, each in varied_by_column.items()
        if each.is_size or (each.varies_by_design and table.count)
    }
    arrays = {each.field: np.asarray(values[name], dtype=float) for name, each in tabled.items()}
    sizes = [each.field for each in tabled.values() if each.is_size and each.field in columns]
    sizes_differ = any(np.any(arrays[size] != columns[size]) for size in sizes)
    if sizes_differ and (mistakes := given_profile_mistakes(problem, "sizes")):
        raise BadInput(mistakes)
    return problem.design.with_values(columns | arrays)


@cached_by_identity(maxsize=CACHED_SCENES)
def _cached_searches_by_varied_keys(
    scene: Scene,
) -> dict[frozenset[str], tuple[dict[str, tuple[float, float]], Problem]]:
    """The cached problems of a scene with the ends of the ranges that they vary, by the keys of these.

    The quantities of designs do not depend on the ends of a search, so the ends only grow.
    """
    return {}


def _problem_varying_table_numbers(
    scene: Scene, scene_problem: Problem, varied_by_column: Mapping[str, Variable], table: DesignColumns
) -> Problem:
    """The problem of a scene whose search varies the numbers that a valid table has columns for."""
    columns = {
        each.search_key: name for name, each in varied_by_column.items() if each.is_scene_number and table.count
    }
    if not columns:
        return problem_with_searched_numbers_per_design(scene_problem)
    ends = {key: (float(table.values[n].min()), float(table.values[n].max())) for key, n in columns.items()}
    cache = _cached_searches_by_varied_keys(scene)
    cached_ends, cached_problem = cache.get(frozenset(ends), (ends, None))
    widest = {
        key: (min(low, cached_ends[key][0]), max(high, cached_ends[key][1])) for key, (low, high) in ends.items()
    }
    if cached_problem and widest == cached_ends:
        return cached_problem
    try:
        problem = resolve(scene.replace(**{key: list(pair) for key, pair in ends.items()}))
    except BadInput as error:
        raise BadInput(
            replace(each, file=DESIGNS_LABEL, key=columns.get(each.key, each.key)) for each in error.mistakes
        ) from None
    numbers = {each.key: widest[each.search_key] for each in varied_by_column.values() if each.search_key in ends}
    problem = problem_with_searched_numbers_per_design(problem, numbers)
    cache[frozenset(ends)] = widest, problem
    return problem


@cache
def _type_adapter_of_scene_key(key: str) -> TypeAdapter[Any]:
    table, _, name = key.rpartition(".")
    return TypeAdapter(TABLE_TYPES[table].model_fields[name].rebuild_annotation())


def _column_value_mistakes(scene_key: str, column: str, table: DesignColumns) -> Iterator[Mistake]:
    """A mistake for the first value of a column that a scene would not accept; of numbers, for an extreme."""
    scene_key, values = re.sub(r"\.\d+", "", scene_key), table.values[column]
    checked_rows: Iterable[int] = range(len(values))
    if values.size and values.dtype.kind in "iuf":
        checked_rows = [int(values.argmin()), int(values.argmax())]  # both find the first NaN, if there is one
    for row in checked_rows:
        place, value = f"{column}[{table.labels[row]}]", values.item(row)
        if value is None:
            yield Mistake(DESIGNS_LABEL, place, None, "missing", bare=True)
            return
        try:
            _type_adapter_of_scene_key(scene_key).validate_python(value)
        except ValidationError as error:
            yield mistakes_from_pydantic(error, TABLE_TYPES[scene_key.rpartition(".")[0]], place, DESIGNS_LABEL)[0]
            return


def _law_mistakes(problem: Problem, column: str, table: DesignColumns) -> Iterator[Mistake]:
    known = {*problem.laws, *map(problem.programme.law_names, (RISE, RETURN))}
    for row, law in enumerate(table.values[column].tolist()):
        if not isinstance(law, str) or law not in known:
            place = f"{column}[{table.labels[row]}]"
            yield Mistake(DESIGNS_LABEL, place, law, f"a motion law; {suggest_names(str(law), problem.laws)}")
            return


def _problems_and_rows_by_motion(
    scene_problem: Problem, problem: Problem, table: DesignColumns
) -> Iterator[tuple[Problem, IndexArray]]:
    """The problem of each pair of laws and each setting of shared numbers, with the rows that have it."""
    values = table.values
    strokes = [next((name for name in names if name in values), None) for names in LAWS_OF_STROKES]
    shared = [
        each for each in problem.search_space.numbers if each.quantity in values and not each.varies_by_design
    ]
    named = [name for name in dict.fromkeys((*strokes, *(each.quantity for each in shared))) if name]
    for rows in _group_rows_with_equal_values([values[name] for name in named], table.count):
        first = {name: values[name].item(rows[0]) for name in named} if rows.size else {}
        motion_problem = problem
        if shared and first:
            setting = {each.key: float(first[each.quantity]) for each in shared}
            (motion_problem,) = problems_in_settings(problem, [setting])
        laws = [name and first.get(name) for name in strokes]
        pairs = zip(laws, map(scene_problem.programme.law_names, (RISE, RETURN)), strict=True)
        rise, fall = (None if law == scene_law else law for law, scene_law in pairs)
        if (rise, fall) != (None, None):
            motion_problem = motion_problem.with_given_motion(_motion_with_laws(scene_problem, rise, fall))
        yield motion_problem, rows


@cached_by_identity(maxsize=CACHED_MOTIONS)
def _motion_with_laws(problem: Problem, rise_law: str | None, return_law: str | None) -> Programme:
    return problem.given_motion_with_laws(rise_law, return_law)


def _group_rows_with_equal_values(columns: Iterable[NDArray[Any]], count: int) -> list[IndexArray]:
    """The rows of each combination of values in some columns."""
    codes = np.zeros(count, dtype=np.intp)
    for values in columns:
        kinds, column_codes = np.unique(values, return_inverse=True)
        codes = np.unique(codes * kinds.size + column_codes, return_inverse=True)[1]
    order = np.argsort(codes, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(codes[order])) + 1)


def _evaluate_designs_of_one_motion(
    problem: Problem, designs: Designs, result_rows: IndexArray, names: frozenset[str]
) -> Iterator[tuple[IndexArray, DesignRows]]:
    """The quantities, verdicts and excesses of designs that share a motion, with the places of their rows."""
    exists = problem.setup.mechanism.can_assemble(designs, problem.programme)
    existing, impossible = np.flatnonzero(exists), np.flatnonzero(~exists)
    limits = [f"{EXCESS_PREFIX}{limit.name}" for limit in problem.limits]
    if existing.size or not impossible.size:
        assembled = designs.take(existing) if impossible.size else designs
        evaluated = evaluate_with_verdicts_and_effort(problem, assembled, names | problem.required_quantities)[0]
        excess = dict(
            zip(limits, relative_excesses_by_limit(problem.limits, evaluated.columns, assembled), strict=True)
        )
        yield result_rows[existing], DesignRows(evaluated.select_columns(names).columns | excess, existing.size)
    if impossible.size:
        block = EvaluationBlock(problem.setup, problem.programme, designs.take(impossible))
        sizes = run_effects(block, problem.size_quantity_names)
        missing = names - problem.size_quantity_names
        kinds = {name: QUANTITIES[name].kind if name in QUANTITIES else float for name in missing}
        values = {name: inf if kind is float else kind() for name, kind in kinds.items()} | UNASSEMBLED_VALUES
        columns = sizes.columns | values | dict.fromkeys(limits, inf)
        yield result_rows[impossible], DesignRows(columns, impossible.size)
