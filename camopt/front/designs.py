"""Designs from elsewhere: any table of sizes and laws through the kernels at once, for other optimisers.

A sweep evaluates a grid; here the designs are those of another program, a row each.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from camopt.effects import Case
from camopt.mechanisms import Designs
from camopt.mistakes import BadInput, Mistake, nearest
from camopt.problem.limit import ASSEMBLY
from camopt.problem.problem import Problem, missing, resolve
from camopt.problem.rows import VERDICT
from camopt.problem.settings import freed_of, given_profile, in_settings
from camopt.problem.variables import Variable
from camopt.quantities import QUANTITIES, in_order
from camopt.scene.complaints import mistakes_of
from camopt.scene.scene import Scene
from camopt.scene.tables import Cam, Drive, Dynamics, Follower, Materials, SceneTable
from camopt.scene.train import TrainStage
from camopt.tables.columns import DERIVED
from camopt.verdicts.judging import CERTIFIED, evaluate_with_effort, excesses
from camopt.verdicts.running import run_effects

if TYPE_CHECKING:
    import pandas as pd

FILE = "designs"  # what messages call the table
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
LAW_KEYS = ("law", "law_rise", "law_return")
NOT_ASSEMBLED = {"violated": ASSEMBLY, "status": CERTIFIED}
"""What is known of designs that cannot be assembled, beside that they are not feasible; numbers are infinite."""
EXCESS = "excess_"  # before the name of a limit: the column of its excess


def evaluate_designs(scene: Scene, designs: "Mapping[str, Any] | pd.DataFrame") -> "pd.DataFrame":
    """Compute the quantities of many designs, and the excess of each over every limit.

    Parameters
    ----------
    scene : Scene
        Everything that the designs share: motion, limits, ``outputs``, and the sizes, laws and other numbers that
        ``designs`` does not have.
    designs : Mapping or pandas.DataFrame
        A DataFrame, or a mapping of arrays, with a row for each design. Columns are sizes of the scene's mechanism
        (``base_radius_mm``, ``offset_mm``, ``roller_radius_mm`` and so on), names of laws: ``law``, or
        ``law_rise`` and ``law_return``, and other numbers of the scene that ``[search]`` takes
        (``spring_rate_N_per_mm``, ``face_width_mm`` and so on).

    Returns
    -------
    pandas.DataFrame
        A row for each design, in the same order and with the same index: what ``evaluate`` gives for the
        scene, to its ``[accuracy] relative_error``, with ``feasible``, ``violated``, ``status`` and
        ``relative_half_width``; and for each limit ``excess_…``, relative to its bound: 0 or less where it is met,
        but for that error. Of a design that cannot be assembled all but the sizes is infinite, and ``violated``
        is "assembly".

    Raises
    ------
    BadInput
        For a column that is no size or number of the mechanism and no law, a value that a scene would not take, and
        a size or searched number that neither the scene nor ``designs`` has.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm")
    >>> found = camopt.evaluate_designs(scene, {"base_radius_mm": [60, 90], "law": ["cycloidal", "poly345"]})
    >>> found["violated"].tolist(), found["excess_pressure_angle"].round(3).tolist()
    (['pressure_angle', ''], [0.312, -0.017])
    """
    import pandas as pd

    problem = resolve(scene)
    try:
        frame = pd.DataFrame(designs)
    except (ValueError, TypeError) as trouble:  # columns of several lengths, or no columns at all
        raise BadInput([Mistake("camopt", FILE, None, f"columns of one length: {trouble}")]) from None
    varied = _varied(problem, frame)
    given = _given(problem, frame, varied)
    problem = freed_of(problem if frame.empty else _searching(scene, varied, frame))
    names = problem.wanted | problem.sizes | frozenset(VERDICT)
    parts = [_evaluated(each, given.take(rows), names).set_axis(rows) for each, rows in _by_motion(problem, frame)]
    found = pd.concat(parts).sort_index().set_axis(frame.index)
    columns = in_order(found.columns)
    found = found[[*columns, *(f"{EXCESS}{limit.name}" for limit in problem.limits)]]
    found.attrs = {"units": {name: QUANTITIES[name].unit for name in columns}}
    return found


def check_designs(scene: Scene, designs: "pd.DataFrame") -> None:
    """BadInput unless the columns of a table that tell its designs can be those of a scene; others may be there."""
    problem = resolve(scene)
    columns = _columns(problem)
    if lacking := sorted(problem.sizes - {*DERIVED, *designs}):
        raise BadInput([Mistake(FILE, name, None, "missing", bare=True) for name in lacking])
    telling = designs[[name for name in designs if name in columns or name in LAW_KEYS]]
    varied = _varied(problem, telling)
    _given(problem, telling, varied)
    if not telling.empty:
        _searching(scene, varied, telling)


def _columns(problem: Problem) -> dict[str, Variable]:
    """The variables of a problem by the columns that give them; a size also by its key in the scene."""
    sizes = {f"{each.name}_mm": each for each in problem.variables if each.is_size}
    return sizes | {each.quantity: each for each in problem.variables}


def _varied(problem: Problem, frame: "pd.DataFrame") -> dict[str, Variable]:
    """The variables that a table has columns of."""
    columns = _columns(problem)
    if odd := list(_odd_columns(frame, columns)):
        raise BadInput(odd)
    return {name: columns[name] for name in frame if name in columns}


def _given(problem: Problem, frame: "pd.DataFrame", varied: Mapping[str, Variable]) -> Designs:
    """The designs of a table: its columns, and the scene's own sizes and searched numbers."""
    if any(each.is_size for each in varied.values()) and (given := given_profile(problem, "sizes")):
        raise BadInput(given)
    mistakes = [
        *(mistake for name, each in varied.items() for mistake in _out_of_range(each.key, frame[name])),
        *(mistake for name in frame if name in LAW_KEYS for mistake in _unknown_laws(problem, frame[name])),
        *missing(problem, {each.key for each in varied.values()}),
    ]
    if mistakes:
        raise BadInput(mistakes)
    own = {each.field: problem.setup.given[each.key] for each in problem.choices.numbers if each.is_ranged}
    own |= {name: value[0] for name, value in problem.design.sizes.items()}
    columns = {name: np.full(len(frame), value) for name, value in own.items()}
    brought = {name: each for name, each in varied.items() if each.is_size or (each.is_ranged and not frame.empty)}
    return problem.design.with_values(columns | {v.field: frame[n].to_numpy(float) for n, v in brought.items()})


def _searching(scene: Scene, varied: Mapping[str, Variable], frame: "pd.DataFrame") -> Problem:
    """The problem of a scene whose search varies the numbers of which a faultless table has columns."""
    columns = {each.searched: name for name, each in varied.items() if each.is_number}
    ends = {key: [float(frame[name].min()), float(frame[name].max())] for key, name in columns.items()}
    try:
        return resolve(scene.replace(**ends))
    except BadInput as error:
        raise BadInput(
            replace(each, file=FILE, key=columns.get(each.key, each.key)) for each in error.mistakes
        ) from None


def _odd_columns(frame: "pd.DataFrame", columns: Mapping[str, Variable]) -> Iterator[Mistake]:
    """Columns that are no sizes or numbers of the mechanism and no laws, and what is given twice."""
    for twice in frame.columns[frame.columns.duplicated()]:
        yield Mistake(FILE, str(twice), None, "stands there twice", bare=True)
    for name in frame:
        if name not in columns and name not in LAW_KEYS:
            what = f"no size or number of this mechanism and no law; {nearest(str(name), (*columns, *LAW_KEYS))}"
            yield Mistake(FILE, str(name), None, what, bare=True)
    if "law" in frame and ("law_rise" in frame or "law_return" in frame):
        yield Mistake(FILE, "law", None, "must stand alone, without law_rise and law_return", bare=True)


def _out_of_range(key: str, column: "pd.Series[Any]") -> Iterator[Mistake]:
    """The first value of a size that a scene would not take; of numbers, the least or the largest."""
    table, _, name = re.sub(r"\.\d+", "", key).rpartition(".")
    size: TypeAdapter[Any] = TypeAdapter(TABLE_TYPES[table].model_fields[name].rebuild_annotation())
    values = column.to_numpy()
    looked_at: Iterable[int] = range(len(column))
    if values.size and values.dtype.kind in "iuf":
        looked_at = [int(values.argmin()), int(values.argmax())]  # the first that is not a number, if there is one
    for row in looked_at:
        try:
            size.validate_python(values.item(row))
        except ValidationError as error:
            yield mistakes_of(error, TABLE_TYPES[table], f"{column.name}[{column.index[row]}]", FILE)[0]
            return


def _unknown_laws(problem: Problem, column: "pd.Series[Any]") -> Iterator[Mistake]:
    """The first name of a column that is no law."""
    for row, law in column[~column.isin(list(problem.laws))].head(1).items():
        yield Mistake(FILE, f"{column.name}[{row}]", law, f"a motion law; {nearest(str(law), problem.laws)}")


def _by_motion(problem: Problem, frame: "pd.DataFrame") -> Iterator[tuple[Problem, NDArray[np.intp]]]:
    """The problem of each pair of laws, in each setting that is one of problems, and the rows that have it."""
    rise, fall = (next((name for name in names if name in frame), None) for names in LAWS_OF_STROKES)
    shared = [each for each in problem.choices.numbers if each.quantity in frame and not each.is_ranged]
    named = [name for name in dict.fromkeys((rise, fall, *(each.quantity for each in shared))) if name]
    if not named or frame.empty:
        yield problem, np.arange(len(frame))
        return
    for rows in frame.reset_index(drop=True).groupby(named, sort=False).indices.values():
        first = frame.iloc[rows[0]]
        laws = (None if name is None else first[name] for name in (rise, fall))
        (set_,) = in_settings(problem, [{each.key: float(first[each.quantity]) for each in shared}])
        yield set_.moving(set_.asked_by(*laws)), np.asarray(rows)


def _evaluated(problem: Problem, designs: Designs, names: frozenset[str]) -> "pd.DataFrame":
    """Quantities, verdicts and excesses of designs that share a motion."""
    import pandas as pd

    exists = np.flatnonzero(problem.setup.mechanism.exists(designs, problem.programme))
    made = run_effects(Case(problem.setup, problem.programme, designs), problem.sizes)
    rows = evaluate_with_effort(problem, designs.take(exists), names | problem.needed)[0]
    excess = excesses(problem.limits, rows.columns, designs.take(exists))
    columns = {name: rows.column(name) for name in names - problem.sizes}
    columns |= {f"{EXCESS}{limit.name}": over for limit, over in zip(problem.limits, excess, strict=True)}
    table = pd.DataFrame({name: made.column(name) for name in made.columns})
    for name, values in columns.items():
        otherwise = NOT_ASSEMBLED.get(name, inf if values.dtype.kind == "f" else values.dtype.type())
        table[name] = np.full(len(designs), otherwise, dtype=values.dtype if values.dtype.kind in "fb" else object)
        table.loc[exists, name] = values
    return table
