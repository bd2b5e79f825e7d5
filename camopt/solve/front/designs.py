"""Designs from elsewhere: any table of sizes and laws through the kernels at once, for other optimisers.

A sweep evaluates a grid; here the designs are those of another program, a row each. A scene is resolved once, so
that an optimiser can ask for one design at a time.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.numerics import IndexArray
from camopt.core.numerics.identity_key import IdentityKey
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
    design_column_mistakes,
    has_scene,
    unknown_columns,
    warn_of_unknown_columns,
)
from camopt.scene.problem.limit import ASSEMBLY
from camopt.scene.problem.problem import Problem, missing_variable_mistakes, resolve
from camopt.scene.problem.rows import VERDICT_COLUMNS, DesignRows, scatter_rows
from camopt.scene.problem.settings import given_profile_mistakes, problem_with_free_numbers, problems_in_settings
from camopt.scene.problem.variables import Variable
from camopt.scene.pydantic_mistakes import mistakes_from_pydantic
from camopt.scene.scene import Scene
from camopt.scene.tables import Cam, Drive, Dynamics, Follower, Materials, SceneTable
from camopt.scene.train import TrainStage
from camopt.solve.front.design_columns import DESIGNS_LABEL, DesignColumns, read_design_columns
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_verdicts import CERTIFIED, evaluate_with_effort, excesses

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
"""Columns with the law of the rises, and with that of the returns."""
UNASSEMBLED_VALUES = {"violated": ASSEMBLY, "status": CERTIFIED}
"""What is known of designs that cannot be assembled, beside that they are not feasible; numbers are infinite."""
ROW_SCENE_COLUMN = "scene"  # the column with scenes of rows
SCENE_ADVICE = "give each row to scene_of, and that to evaluate"
CACHED_SCENES, CACHED_MOTIONS = 4, 256  # of which answers are remembered


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
        Columns are sizes of the scene's mechanism
        (``base_radius_mm``, ``offset_mm``, ``roller_radius_mm`` and so on), names of laws: ``law``, or
        ``law_rise`` and ``law_return``, and other numbers of the scene that ``[search]`` takes
        (``spring_rate_N_per_mm``, ``face_width_mm`` and so on). Rows of camopt's own tables go in as they are:
        their other quantities are computed anew.
        The named levels of an index of pandas are columns too.
    names : str or iterable of str, optional
        The columns of an array, in their order.
    strict : bool, default False
        Whether columns that are no quantities of camopt are a mistake. If not, one warning names them.

    Returns
    -------
    pandas.DataFrame
        A row for each design, in the same order and with the same index: what ``evaluate`` gives for the
        scene, to its ``[accuracy] relative_error``, with ``feasible``, ``violated``, ``status`` and
        ``relative_half_width``; and for each limit ``excess_…``, relative to its bound: 0 or less where it is met,
        but for that error. Of a design that cannot be assembled all but the sizes is infinite, and ``violated``
        is "assembly". ``attrs`` has the ``units`` and the ``scene``, for ``scene_of``.

    Raises
    ------
    BadInput
        For a table of which no column is a size, number or law of the mechanism, a value that a scene would not
        take, and a size or searched number that neither the scene nor ``designs`` has; for angles of segments, and
        for rows with scenes of their own, which ``scene_of`` reads; with ``strict`` for every column that is no
        quantity of camopt.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm")
    >>> found = camopt.evaluate_designs(scene, {"base_radius_mm": [60, 90], "law": ["cycloidal", "poly345"]})
    >>> found["violated"].tolist(), found["excess_pressure_angle"].round(3).tolist()
    (['pressure_angle', ''], [0.312, -0.017])
    >>> one = camopt.evaluate_designs(scene, [90, 10], names=["base_radius_mm", "offset_mm"])
    >>> one["base_radius_mm"].tolist()
    [90.0]
    """
    import pandas as pd

    scene = scene_from(scene)
    given = resolve(scene)
    columns = _variables_by_column(given)
    table = _read_designs(designs, columns, names)
    known = (*columns, *LAW_NAME_COLUMNS)
    if odd := _other_columns(scene, known, table, strict=strict):
        warn_of_unknown_columns(odd, known, table.values, DESIGNS_LABEL)
    varied = _variables_in(columns, table)
    rows = _designs_from_table(given, table, varied)
    problem = _problem_of_search(scene, given, varied, table)
    found = problem.evaluated_quantities | problem.size_names | frozenset(VERDICT_COLUMNS)
    motions = _split_by_motion(given, problem, table)
    parts = [part for each, some in motions for part in _evaluate_rows(each, rows.take(some), some, found)]
    values = scatter_rows(parts, table.count).columns
    quantities = {name: find_quantity(name, given.setup) for name in in_column_order(found)}
    columns_in_order = [*quantities, *(f"{EXCESS_PREFIX}{limit.name}" for limit in problem.limits)]
    if not table.count:  # pandas sees no texts there
        values |= {name: values[name].astype(each.kind) for name, each in quantities.items()}
    frame = pd.DataFrame({name: values[name] for name in columns_in_order}, index=table.labels)
    units = {name: each.unit for name, each in quantities.items()}
    frame.attrs = {"units": units, "scene": _scene_text(IdentityKey(scene))}
    return frame


def check_designs(scene: Scene, designs: "pd.DataFrame") -> None:
    """BadInput unless the columns of a table that tell its designs can be those of a scene; others may be there."""
    problem = resolve(scene)
    columns = _variables_by_column(problem)
    if lacking := sorted(problem.size_names - {*DERIVED_SIZES, *designs}):
        raise BadInput([Mistake(DESIGNS_LABEL, name, None, "missing", bare=True) for name in lacking])
    table = _read_designs(designs, columns)
    varied = _variables_in(columns, table)
    _designs_from_table(problem, table, varied)
    _problem_of_search(scene, problem, varied, table)


@lru_cache(maxsize=CACHED_SCENES)
def _scene_text(same: IdentityKey[Scene]) -> str:
    return same.value.to_toml()


def _variables_by_column(problem: Problem) -> Mapping[str, Variable]:
    """The variables of a problem by the columns that give them; a size also by its key in the scene."""
    return _find_variables(IdentityKey(problem))


@lru_cache(maxsize=CACHED_SCENES)
def _find_variables(same: IdentityKey[Problem]) -> Mapping[str, Variable]:
    sizes = {f"{each.name}_mm": each for each in same.value.variables if each.is_size}
    return sizes | {each.quantity: each for each in same.value.variables}


def _read_designs(designs: Any, columns: Collection[str], names: Iterable[str] | None = None) -> DesignColumns:
    """The columns of a table that tell its designs: no angles, and no scenes of their own."""
    table = read_design_columns(designs, {*columns, *LAW_NAME_COLUMNS, ROW_SCENE_COLUMN}, names)
    scenes = table.values.pop(ROW_SCENE_COLUMN, None)
    if scenes is not None and any(has_scene({ROW_SCENE_COLUMN: each}) for each in scenes.tolist()):
        raise BadInput(
            [
                Mistake(
                    DESIGNS_LABEL,
                    ROW_SCENE_COLUMN,
                    None,
                    f"each row has a scene of its own: {SCENE_ADVICE}",
                    bare=True,
                )
            ]
        )
    if ANGLES_COLUMN in table.others:
        raise BadInput(
            [
                Mistake(
                    DESIGNS_LABEL,
                    ANGLES_COLUMN,
                    None,
                    f"all designs have the scene's angles: {SCENE_ADVICE}",
                    bare=True,
                )
            ]
        )
    return table if scenes is None else replace(table, others=[*table.others, ROW_SCENE_COLUMN])


def _other_columns(scene: Scene, known: Collection[str], table: DesignColumns, *, strict: bool) -> list[str]:
    """The columns that are no quantities; BadInput for these if ``strict``, and without a column of a design."""
    odd = unknown_columns(scene, table.others)
    if (not table.values and (table.others or table.count)) or (odd and strict):
        raise design_column_mistakes(odd or table.others, known, DESIGNS_LABEL)
    return odd


def _variables_in(columns: Mapping[str, Variable], table: DesignColumns) -> dict[str, Variable]:
    """The variables that a table has columns of."""
    if "law" in table.values and ("law_rise" in table.values or "law_return" in table.values):
        raise BadInput(
            [Mistake(DESIGNS_LABEL, "law", None, "must stand alone, without law_rise and law_return", bare=True)]
        )
    return {name: columns[name] for name in table.values if name in columns}


def _designs_from_table(problem: Problem, table: DesignColumns, varied: Mapping[str, Variable]) -> Designs:
    """The designs of a table: its columns, and the scene's own sizes and searched numbers."""
    values = table.values
    mistakes = [
        *(mistake for name, each in varied.items() for mistake in _column_range_mistakes(each.key, name, table)),
        *(
            mistake
            for name in values
            if name in LAW_NAME_COLUMNS
            for mistake in _law_mistakes(problem, name, table)
        ),
        *missing_variable_mistakes(problem, {each.key for each in varied.values()}),
    ]
    if mistakes:
        raise BadInput(mistakes)
    own = {
        each.field: problem.setup.given[each.key] for each in problem.search_space.numbers if each.varies_by_design
    }
    own |= {name: value[0] for name, value in problem.design.sizes.items()}
    columns = {name: np.full(table.count, value) for name, value in own.items()}
    brought = {
        name: each for name, each in varied.items() if each.is_size or (each.varies_by_design and table.count)
    }
    found = {each.field: np.asarray(values[name], dtype=float) for name, each in brought.items()}
    changed = (f for name, each in brought.items() if each.is_size for f in [each.field] if f in columns)
    if any(np.any(found[f] != columns[f]) for f in changed) and (given := given_profile_mistakes(problem, "sizes")):
        raise BadInput(given)
    return problem.design.with_values(columns | found)


@dataclass
class _CachedSearch:
    """The problem of designs that bring some numbers of the scene, between some ends."""

    ends: Mapping[str, tuple[float, float]]
    problem: Problem

    def covers_ends(self, ends: Mapping[str, tuple[float, float]]) -> bool:
        return all(self.ends[key][0] <= low and high <= self.ends[key][1] for key, (low, high) in ends.items())


@lru_cache(maxsize=CACHED_SCENES)
def _cached_searches(same: IdentityKey[Scene]) -> dict[frozenset[str], _CachedSearch]:
    """The searches of a scene that are known, by the numbers that they vary; what designs have does not depend on
    the ends of a search, which only grow."""
    return {}


def _problem_of_search(
    scene: Scene, given: Problem, varied: Mapping[str, Variable], table: DesignColumns
) -> Problem:
    """The problem of a scene whose search varies the numbers of which a faultless table has columns."""
    columns = {each.search_key: name for name, each in varied.items() if each.is_number and table.count}
    if not columns:
        return problem_with_free_numbers(given)
    ends = {key: (float(table.values[n].min()), float(table.values[n].max())) for key, n in columns.items()}
    known = _cached_searches(IdentityKey(scene))
    before = known.get(frozenset(ends))
    if before and before.covers_ends(ends):
        return before.problem
    try:
        problem = resolve(scene.replace(**{key: list(each) for key, each in ends.items()}))
    except BadInput as error:
        raise BadInput(
            replace(each, file=DESIGNS_LABEL, key=columns.get(each.key, each.key)) for each in error.mistakes
        ) from None
    if before:
        ends = {
            key: (min(low, before.ends[key][0]), max(high, before.ends[key][1]))
            for key, (low, high) in ends.items()
        }
    numbers = {each.key: ends[each.search_key] for each in varied.values() if each.search_key in ends}
    found = _CachedSearch(ends, problem_with_free_numbers(problem, numbers))
    known[frozenset(ends)] = found
    return found.problem


@cache
def _column_number_type(key: str) -> TypeAdapter[Any]:
    """The type of a number, by its key."""
    table, _, name = key.rpartition(".")
    return TypeAdapter(TABLE_TYPES[table].model_fields[name].rebuild_annotation())


def _column_range_mistakes(key: str, name: str, table: DesignColumns) -> Iterator[Mistake]:
    """The first value of a size that a scene would not take; of numbers, the least or the largest."""
    key, values = re.sub(r"\.\d+", "", key), table.values[name]
    looked_at: Iterable[int] = range(len(values))
    if values.size and values.dtype.kind in "iuf":
        looked_at = [int(values.argmin()), int(values.argmax())]  # the first that is not a number, if there is one
    for row in looked_at:
        place, value = f"{name}[{table.labels[row]}]", values.item(row)
        if value is None:
            yield Mistake(DESIGNS_LABEL, place, None, "missing", bare=True)
            return
        try:
            _column_number_type(key).validate_python(value)
        except ValidationError as error:
            yield mistakes_from_pydantic(error, TABLE_TYPES[key.rpartition(".")[0]], place, DESIGNS_LABEL)[0]
            return


def _law_mistakes(problem: Problem, name: str, table: DesignColumns) -> Iterator[Mistake]:
    """The first name of a column that is no law."""
    known = {*problem.laws, *_laws_of_scene(problem)}
    for row, law in enumerate(table.values[name].tolist()):
        if not isinstance(law, str) or law not in known:
            place = f"{name}[{table.labels[row]}]"
            yield Mistake(DESIGNS_LABEL, place, law, f"a motion law; {suggest_names(str(law), problem.laws)}")
            return


def _laws_of_scene(problem: Problem) -> tuple[str, str]:
    """The laws of the scene's own rises and returns, as tables name them."""
    return problem.programme.law_names(RISE), problem.programme.law_names(RETURN)


def _split_by_motion(
    given: Problem, problem: Problem, table: DesignColumns
) -> Iterator[tuple[Problem, IndexArray]]:
    """The problem of each pair of laws, in each setting that is one of problems, and the rows that have it."""
    values = table.values
    strokes = [next((name for name in names if name in values), None) for names in LAWS_OF_STROKES]
    shared = [
        each for each in problem.search_space.numbers if each.quantity in values and not each.varies_by_design
    ]
    named = [name for name in dict.fromkeys((*strokes, *(each.quantity for each in shared))) if name]
    for rows in _group_rows([values[name] for name in named], table.count):
        first = {name: values[name].item(rows[0]) for name in named} if rows.size else {}
        set_ = problem
        if shared and first:
            (set_,) = problems_in_settings(problem, [{each.key: float(first[each.quantity]) for each in shared}])
        laws = [name and first.get(name) for name in strokes]
        rise, fall = (None if law == own else law for law, own in zip(laws, _laws_of_scene(given), strict=True))
        yield (
            set_
            if rise is fall is None
            else set_.with_given_motion(_motion_with_laws(IdentityKey(given), rise, fall)),
            rows,
        )


@lru_cache(maxsize=CACHED_MOTIONS)
def _motion_with_laws(same: IdentityKey[Problem], rise: str | None, fall: str | None) -> Programme:
    """The motion that is asked with other laws."""
    return same.value.given_motion_with_laws(rise, fall)


def _group_rows(columns: Iterable[NDArray[Any]], count: int) -> list[IndexArray]:
    """The rows of each combination of values that some columns have."""
    codes = np.zeros(count, dtype=np.intp)
    for values in columns:
        kinds, own = np.unique(values, return_inverse=True)
        codes = np.unique(codes * kinds.size + own, return_inverse=True)[1]
    order = np.argsort(codes, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(codes[order])) + 1)


def _evaluate_rows(
    problem: Problem, designs: Designs, rows: IndexArray, names: frozenset[str]
) -> Iterator[tuple[IndexArray, DesignRows]]:
    """Quantities, verdicts and excesses of designs that share a motion, with the places of their rows."""
    exists = problem.setup.mechanism.can_assemble(designs, problem.programme)
    there, apart = np.flatnonzero(exists), np.flatnonzero(~exists)
    limits = [f"{EXCESS_PREFIX}{limit.name}" for limit in problem.limits]
    if there.size or not apart.size:
        some = designs.take(there) if apart.size else designs
        found = evaluate_with_effort(problem, some, names | problem.required_quantities)[0]
        excess = dict(zip(limits, excesses(problem.limits, found.columns, some), strict=True))
        yield rows[there], DesignRows(found.select_columns(names).columns | excess, there.size)
    if apart.size:
        sizes = run_effects(
            EvaluationBlock(problem.setup, problem.programme, designs.take(apart)), problem.size_names
        )
        unknown = {name: UNASSEMBLED_VALUES.get(name, _missing_value(name)) for name in names - problem.size_names}
        yield rows[apart], DesignRows(sizes.columns | unknown | dict.fromkeys(limits, inf), apart.size)


def _missing_value(name: str) -> Any:
    """What a table has in place of a quantity that a design does not have."""
    kind = QUANTITIES[name].kind if name in QUANTITIES else float
    return inf if kind is float else kind()
