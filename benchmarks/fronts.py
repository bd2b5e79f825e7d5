"""Fronts of the default sweep: of the grid, refined, and of NSGA-II (pymoo) in as much time and ten times that.

    python benchmarks/fronts.py

NSGA-II calls the same kernels, a whole generation at once, with the limits as constraints; laws and rollers are
choices, base radius and offset continuous. All hypervolumes are shares of one box: from the ideal of the refined
front to a tenth beyond its nadir. An archive keeps every feasible design that a run has ever evaluated, where none
betters it. The time of a sweep is the least of a few, warm, without the command's start.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.callback import Callback
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.termination.max_time import TimeBasedTermination
from scipy.interpolate import CubicSpline

from camopt import Scene, find_scene, load, sweep
from camopt.core.numerics import FloatArray
from camopt.model.effects import EvaluationBlock
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.settings import problems_by_motion_and_setting
from camopt.show.drawing.style import SERIES, add_grid, new_figure
from camopt.solve.front import refine
from camopt.solve.front.pareto import (
    cost_scale,
    hypervolume_and_exactness,
    non_dominated,
    objective_costs,
    row_costs,
)
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_verdicts import relative_excesses_by_limit

MANY = 10_000
RUNS, SEEDS, POPULATION, TIMES = 3, 3, 400, (1, 10)
WORST = 1e6  # what stands for an infinite constraint


class Cams(Problem):  # type: ignore[misc]
    """The default scene as NSGA-II sees it: law, roller, offset and base radius as four numbers."""

    def __init__(self, scene: Scene) -> None:
        self.problem, search = resolve(scene), scene.search
        self.motions = problems_by_motion_and_setting(self.problem)
        self.rollers = self.problem.search_space.variables["roller_radius"].grid_values
        low = [0.0, 0.0, search.offset.start, search.base_radius.start]
        high = [len(self.motions), len(self.rollers), search.offset.stop, search.base_radius.stop]
        limits = len(self.problem.limits)
        super().__init__(n_var=4, n_obj=len(search.minimise), n_ieq_constr=limits, xl=low, xu=high)

    def _evaluate(self, x: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        fixed = self.problem.design
        law = np.minimum(x[:, 0].astype(int), len(self.motions) - 1)
        roller = self.rollers[np.minimum(x[:, 1].astype(int), len(self.rollers) - 1)]
        out["F"], out["G"] = np.empty((len(x), self.n_obj)), np.full((len(x), self.n_ieq_constr), WORST)
        zeros = {name: np.zeros(len(x)) for name in fixed.sizes}
        designs = Designs(
            **{**zeros, "roller_radius": roller, "offset": x[:, 2], "size": x[:, 3]}, sense=fixed.sense
        )
        for k, problem in enumerate(self.motions):
            index = np.flatnonzero((law == k) & (np.abs(x[:, 2]) < designs.prime_radius))
            chosen = designs.take(index)
            columns = run_effects(
                EvaluationBlock(problem.setup, problem.programme, chosen), self.problem.required_quantities
            ).columns
            out["F"][index] = objective_costs(columns, len(chosen), self.problem.objectives)
            excess = relative_excesses_by_limit(self.problem.limits, columns, chosen)
            out["G"][index] = np.clip(excess, -WORST, WORST).T
        out["F"][np.all(out["G"] == WORST, axis=1)] = WORST  # cannot be put together


class Archive(Callback):  # type: ignore[misc]
    """The non-dominated ones of all feasible designs that a run evaluates."""

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self.objectives, self.rows = scene.search.objectives, None

    def notify(self, algorithm: Any) -> None:
        new = algorithm.off if algorithm.off is not None else algorithm.pop
        costs = new.get("F")[np.all(new.get("G") <= 0.0, axis=1)]
        costs = costs if self.rows is None else np.concatenate([self.rows, costs])
        columns = dict(zip(self.objectives, costs.T, strict=True))
        self.rows = row_costs(non_dominated(DesignRows(columns, len(costs)), self.objectives), self.objectives)


class Run(NamedTuple):
    """What a run of NSGA-II ends with: costs of its last population and of its archive, and its evaluations."""

    last: FloatArray
    archive: FloatArray
    designs: int


def rival(scene: Scene, seconds: float, seed: int) -> Run:
    """A run of NSGA-II."""
    archive, until = Archive(scene), TimeBasedTermination(seconds)
    found = minimize(Cams(scene), NSGA2(POPULATION), until, seed=seed, callback=archive)
    return Run(found.F, archive.rows, found.algorithm.evaluator.n_eval)


def least_seconds(run: Callable[[], Any]) -> float:
    """The least time of a few runs, after one that does not count."""
    run()
    times = []
    for _ in range(RUNS):
        start = perf_counter()
        run()
        times.append(perf_counter() - start)
    return min(times)


def curves(exact: FloatArray) -> dict[float, FloatArray]:
    """The costs of each law of an exact front in order of angle, by its acceleration, which tells the laws."""
    parts = {float(peak): exact[exact[:, 1] == peak] for peak in np.unique(exact[:, 1])}
    return {peak: part[np.argsort(part[:, 2])] for peak, part in parts.items()}


def excess(costs: FloatArray, exact: FloatArray) -> FloatArray:
    """By how much base radii exceed the least at the same law and pressure angle, mm, by splines; NaN elsewhere."""
    over = np.full(len(costs), np.nan)
    for peak, curve in curves(exact).items():
        law = np.isclose(costs[:, 1], peak, rtol=1e-9)
        if len(curve) > 3:
            least = CubicSpline(curve[:, 2], curve[:, 0])
            over[law] = costs[law, 0] - least(np.clip(costs[law, 2], curve[0, 2], curve[-1, 2]))
    return over


def draw(fronts: dict[str, FloatArray], exact: FloatArray, file: Path) -> None:
    """The exact front, base radius by pressure angle, and how far each point of other fronts is above it."""
    with new_figure(file, (11.0, 4.6), layout="constrained") as figure:
        left, right = figure.subplots(1, 2)
        for (peak, curve), colour in zip(curves(exact).items(), SERIES, strict=False):
            left.plot(curve[:, 2], curve[:, 0], color=colour, label=f"{peak:.0f} m/s²")
        for (name, costs), mark, colour in zip(fronts.items(), "ox+", SERIES, strict=False):
            above = np.maximum(excess(costs, exact), 1e-7)
            right.semilogy(costs[:, 2], above, mark, ms=3, color=colour, label=name)
        left.set(xlabel="pressure angle, deg", ylabel="base radius, mm")
        left.set_title("The default sweep's front, refined", loc="left")
        right.set(xlabel="pressure angle, deg", ylabel="mm")
        right.yaxis.set_major_formatter("{x:g}")
        right.set_title("Base radius above the least at the same angle", loc="left")
        for axes in (left, right):
            add_grid(axes)
        left.legend(title="acceleration")
        right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)


def main() -> None:
    scene = find_scene("roller-1000rpm")
    finer = scene.replace(**{"search.refine": True})
    with TemporaryDirectory() as folder:
        plain, whole = (least_seconds(partial(sweep, each, folder)) for each in (scene, finer))
        grid, fine = (
            load(Path(folder) / f"{table}.parquet")[list(scene.search.minimise)].to_numpy()
            for table in ("pareto-grid", "pareto")
        )
    scale = cost_scale(fine)

    def tell(name: str, seconds: float, designs: str, fronts: list[FloatArray]) -> None:
        volumes = sorted(hypervolume_and_exactness(scale.normalise_costs(costs))[0] for costs in fronts)
        points, over = len(fronts[0]), np.nanmax(excess(fronts[0], fine))
        span = f" ({volumes[0]:.5f} to {volumes[-1]:.5f})" if len(volumes) > 1 else ""
        middle = volumes[len(volumes) // 2]
        print(f"| {name} | {seconds:.2f} | {designs} | {points:,} | {middle:.5f}{span} | {max(over, 0):.1e} |")

    print("| front | seconds | designs | points | hypervolume | most above the least radius, mm |")
    print("|---|---:|---:|---:|---:|---:|")
    tell("grid", plain, "1,003,023", [grid])
    tell("grid, refined", whole, "", [fine])
    refine.CURVE_LEVELS = MANY
    with TemporaryDirectory() as folder:
        start = perf_counter()
        sweep(finer, folder)
        seconds = perf_counter() - start
        most = load(Path(folder) / "pareto.parquet")[list(scene.search.minimise)].to_numpy()
    tell("grid, refined with ten times the levels", seconds, "", [most])
    rival(scene, 1.0, 0)  # imports, kernels
    drawn = {"grid": grid}
    for times in TIMES:
        runs = [rival(scene, times * whole, seed) for seed in range(SEEDS)]
        designs, name = f"{runs[0].designs:,}", f"NSGA-II, {times} × the time"
        tell(name, times * whole, designs, [run.last for run in runs])
        tell(f"{name}, archive", times * whole, designs, [run.archive for run in runs])
        drawn[name] = runs[0].last
    draw(drawn, fine, Path(__file__).with_name("fronts.png"))


if __name__ == "__main__":
    main()
