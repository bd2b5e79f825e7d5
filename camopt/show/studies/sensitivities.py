"""Sensitivities: derivatives of the quantities of a cam by its sizes and numbers.

    f'(x) ≈ (f(x − 2h) − 8·f(x − h) + 8·f(x + h) − f(x + 2h))/(12·h)

All points around the cam are designs of one block, so that each effect runs once. At a kink, such as the maximum of
two equal peaks, a quantity has a slope on each side:

    f'(x±) ≈ ∓(3·f(x) − 4·f(x ± h) + f(x ± 2h))/(2·h)

Source: A. Griewank, A. Walther, Evaluating Derivatives, ch. 1. By the envelope theorem, the peak of a curve changes
as the curve at the cam angle of the peak.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.mistakes import UnknownName, suggest_names
from camopt.core.numerics import FloatArray
from camopt.core.quantities import in_column_order
from camopt.model.effects import EvaluationBlock, find_quantity
from camopt.model.mechanisms import Designs
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.problem import Problem, resolve_design, with_rounding_relative_error
from camopt.scene.problem.variables import Variable
from camopt.scene.scene import Scene
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.verdicts.effect_runs import run_effects

STEP_SHARE = 1e-3  # step over the order of magnitude of a variable; the error is its fourth power
STENCIL = np.array([-2.0, -1.0, 1.0, 2.0])
CENTRAL_WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0
LEAST_SLOPE_KINK = 1e-4  # relative difference of the slopes of both sides above which there is a kink
LEAST_SLOPE_JUMP = 1.0  # deg: a cam angle that bends by more within two steps belongs to another peak


class Sensitivity(NamedTuple):
    """The derivative of a quantity by a variable, in the unit of the quantity over that of the variable.

    It is None if the quantity is infinite or the cam cannot be assembled on one side, if the cam angle of a peak
    jumps to another peak, or at a kink, where ``below`` and ``above`` differ.

    Examples
    --------
    >>> found = camopt.sensitivities(camopt.find_scene("belt-matching"))
    >>> slope = found["pressure_angle_max_deg", "cam.base_radius"]
    >>> slope.derivative < 0, round(slope.below / slope.above, 6)
    (True, 1.0)
    """

    derivative: float | None
    below: float | None
    """Derivative towards smaller values of the variable."""
    above: float | None
    """Derivative towards larger values."""


@dataclass(frozen=True)
class Sensitivities(Result, Mapping[tuple[str, str], Sensitivity]):
    """The sensitivities of one cam by (quantity, key of the variable).

    Attributes
    ----------
    scene : Scene
        The cam.
    quantities : dict
        Those of the cam itself.
    found : dict
        The sensitivities.

    Examples
    --------
    >>> found = camopt.sensitivities(camopt.find_scene("roller-1000rpm"))
    >>> round(found["pressure_angle_max_deg", "cam.base_radius"].derivative, 4)
    -0.4006
    """

    scene: Scene
    quantities: dict[str, float]
    found: dict[tuple[str, str], Sensitivity]
    main_rows: ClassVar[str] = "sensitivities"

    def table(self) -> Table:
        """A row for each quantity and variable: the derivative, in the quantity's unit by the variable's."""
        rows = [
            {**row, "derivative": "" if row["derivative"] is None else row["derivative"]} for row in self._records
        ]
        return table_of(f"{self.scene.name}: sensitivities", rows, ["quantity", "variable", "derivative"])

    def values_for_json(self) -> dict[str, Any]:
        """The quantities of the cam, and a record for each derivative."""
        return {"scene": self.scene.name, "quantities": self.quantities, "sensitivities": self._records}

    @property
    def _records(self) -> list[dict[str, Any]]:
        return [{"quantity": name, "variable": key, **each._asdict()} for (name, key), each in self.found.items()]

    def __getitem__(self, pair: tuple[str, str]) -> Sensitivity:
        if isinstance(pair, str):
            such = next(iter(self.found), ("base_radius_mm", "cam.base_radius"))
            raise UnknownName(
                f"{pair!r} is one name; a sensitivity has two names, a quantity and a variable: {such}"
            )
        if pair not in self.found:
            names = [*dict.fromkeys(name for key in self.found for name in key)]
            wrong = next((str(name) for name in pair if name not in names), str(pair))
            raise UnknownName(f"{wrong!r} is not a quantity or variable of this cam; {suggest_names(wrong, names)}")
        return self.found[pair]

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return iter(self.found)

    def __len__(self) -> int:
        return len(self.found)

    def __repr__(self) -> str:
        variables = len({key for _, key in self.found})
        return f"<Sensitivities of {self.scene.name}: {len(self.quantities)} quantities by {variables} variables>"


def sensitivities(scene: SceneSource) -> Sensitivities:
    """Find the derivative of each quantity of a cam by each of its sizes and numbers.

    Quantities are the numbers that ``evaluate`` gives for the scene. Variables are the sizes of the mechanism, such
    as ``cam.base_radius``, and the numbers of the scene for speed, dynamics, materials and train that are not 0,
    such as ``follower.dynamics.spring_rate`` or ``train.1.crank``. Everything else is fixed.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with all sizes.

    Returns
    -------
    Sensitivities
        A mapping from (quantity, key) to ``Sensitivity``. Derivatives of smooth quantities are exact to about 1e-8,
        one-sided derivatives to about 1e-5.

    Raises
    ------
    BadInput
        If the scene lacks a size or number.

    References
    ----------
    A. Griewank, A. Walther, Evaluating Derivatives, ch. 1.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm")
    >>> round(camopt.sensitivities(scene)["acceleration_max_m_s2", "cam.rpm"].derivative, 4)
    1.7778
    """
    scene = scene_from(scene)
    problem = with_rounding_relative_error(resolve_design(scene))
    variables = _variable_values_and_magnitudes(problem)
    numbers = {each.key: value for each, (value, _) in variables.items() if each.is_scene_number}
    freed = problem.with_numbers_per_design(numbers)
    names = [name for name in problem.evaluated_quantities if find_quantity(name, problem.setup).kind is float]
    around = _stencil_designs(problem.design, variables)
    columns = run_effects(EvaluationBlock(freed.setup, freed.programme, around), names).columns
    exists = freed.setup.mechanism.can_assemble(around, freed.programme)
    train_variables = {each.key: each for each in problem.variables if each.role == "train"}
    trains = {
        train_variables[key]: _train_stencil(problem, key, value, names)
        for key, value in scene.numbers(train_variables).items()
        if value and not isinstance(value, tuple)  # no loads by cam angle
    }
    found, values = {}, {}
    for name in in_column_order(columns):
        column = np.where(exists, np.broadcast_to(columns[name], len(around)), np.nan).astype(float)
        values[name], most = float(column[0]), LEAST_SLOPE_JUMP if name.endswith("_at_deg") else np.inf
        for number, (each, (_, order)) in enumerate(variables.items()):
            beside = column[1 + len(STENCIL) * number : 1 + len(STENCIL) * (number + 1)]
            found[name, each.key] = _stencil_slopes(column[0], beside, STEP_SHARE * order, most)
        for each, (step, rows) in trains.items():
            found[name, each.key] = _stencil_slopes(
                column[0], np.array([row.get(name, np.nan) for row in rows]), step, most
            )
    return Sensitivities(scene, values, found)


def _variable_values_and_magnitudes(problem: Problem) -> dict[Variable, tuple[float, float]]:
    """Value and order of magnitude of each variable."""
    found, prime = {}, float(problem.design.prime_radius[0])
    for each in problem.variables:
        given = problem.design.sizes[each.field][0] if each.is_size else problem.setup.given[each.key]
        if each.is_size or (each.varies_by_design and given):
            found[each] = float(given), max(abs(float(given)), 0.1 * prime * each.is_size)
    return found


def _train_stencil(
    problem: Problem, key: str, value: float, quantity_names: Sequence[str]
) -> tuple[float, list[dict[str, float]]]:
    """The step of a number of the train, and the quantities at the points of the stencil.

    A train that cannot be assembled has no quantities.
    """
    step = STEP_SHARE * abs(value)
    rows = []
    for move in STENCIL:
        shifted = problem.with_numbers({key: value + move * step})
        exists = shifted.setup.mechanism.can_assemble(problem.design, shifted.programme)[0]
        case = EvaluationBlock(shifted.setup, shifted.programme, problem.design)
        columns = run_effects(case, quantity_names).columns if exists else {}
        rows.append({name: float(np.broadcast_to(each, 1)[0]) for name, each in columns.items()})
    return step, rows


def _stencil_designs(design: Designs, variables: Mapping[Variable, tuple[float, float]]) -> Designs:
    """The cam, followed by the designs of the stencil of each variable."""
    values: dict[str, Any] = {}
    count = 1 + len(STENCIL) * len(variables)
    for number, (each, (value, order)) in enumerate(variables.items()):
        column = np.full(count, value)
        column[1 + len(STENCIL) * number : 1 + len(STENCIL) * (number + 1)] += STENCIL * STEP_SHARE * order
        values[each.field] = column
    return design.take(np.zeros(count, dtype=int)).with_values(values)


def _stencil_slopes(value: float, stencil_values: FloatArray, step: float, largest_bend: float) -> Sensitivity:
    """Slopes of a quantity from its values on the stencil.

    None on a side where it bends by more than ``largest_bend``.
    """
    with np.errstate(invalid="ignore"):
        change = stencil_values - value
        change[:2] = np.where(abs(change[0] - 2.0 * change[1]) > largest_bend, np.nan, change[:2])
        change[2:] = np.where(abs(change[3] - 2.0 * change[2]) > largest_bend, np.nan, change[2:])
        below = float(change[0] - 4.0 * change[1]) / (2.0 * step)
        above = float(4.0 * change[2] - change[3]) / (2.0 * step)
        middle = float(CENTRAL_WEIGHTS @ change) / step
    known = (
        LEAST_SLOPE_KINK * max(abs(below), abs(above), abs(value) * STEP_SHARE / step)
        if np.isfinite(below + above)
        else 0.0
    )
    smooth = np.isfinite(middle) and abs(above - below) <= known
    return Sensitivity(middle if smooth else None, _finite_or_none(below), _finite_or_none(above))


def _finite_or_none(value: float) -> float | None:
    return value if np.isfinite(value) else None
