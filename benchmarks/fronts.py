"""Fronts of the default sweep: of the grid, refined, and of NSGA-II (pymoo) in as much time and ten times that.

    python benchmarks/fronts.py

NSGA-II calls the same kernels, a whole generation at once, with the limits as constraints; laws and rollers are
choices, base radius and offset continuous. All hypervolumes are shares of one box: from the ideal of the refined
front to a tenth beyond its nadir. "Archive" counts every feasible design that a run has ever evaluated.
"""

import sys
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.callback import Callback
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.termination.max_time import TimeBasedTermination

from camopt import Scene, find_scene, load, sweep
from camopt.effects import Case
from camopt.judging import excesses, run_effects
from camopt.mechanisms import Designs
from camopt.numerics import FloatArray
from camopt.question import resolve
from camopt.rows import Rows
from camopt.search.pareto import Scale, costs_of, hypervolume, non_dominated, objectives, scale_of
from camopt.search.space import axis_values, programmes_of

RUNS, SEEDS, POPULATION, TIMES = 3, 3, 400, (1, 10)
WORST = 1e6  # what stands for an infinite constraint


class Cams(Problem):  # type: ignore[misc]
    """The default scene as NSGA-II sees it: law, roller, offset and base radius as four numbers."""

    def __init__(self, scene: Scene) -> None:
        self.question, search = resolve(scene), scene.search
        self.programmes, self.rollers = programmes_of(self.question), axis_values(search.roller_radius)
        low = [0.0, 0.0, search.offset.start, search.base_radius.start]
        high = [len(self.programmes), len(self.rollers), search.offset.stop, search.base_radius.stop]
        limits = len(self.question.limits)
        super().__init__(n_var=4, n_obj=len(search.minimise), n_ieq_constr=limits, xl=low, xu=high)

    def _evaluate(self, x: FloatArray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        scene, fixed = self.question.scene, self.question.design
        law = np.minimum(x[:, 0].astype(int), len(self.programmes) - 1)
        roller = self.rollers[np.minimum(x[:, 1].astype(int), len(self.rollers) - 1)]
        out["F"], out["G"] = np.empty((len(x), self.n_obj)), np.full((len(x), self.n_ieq_constr), WORST)
        zeros = {name: np.zeros(len(x)) for name in fixed.sizes}
        designs = Designs(
            **{**zeros, "roller_radius": roller, "offset": x[:, 2], "size": x[:, 3]}, sense=fixed.sense
        )
        for k, programme in enumerate(self.programmes):
            index = np.flatnonzero((law == k) & (np.abs(x[:, 2]) < designs.prime_radius))
            chosen = designs.take(index)
            columns = run_effects(Case(self.question.subject, programme, chosen), self.question.needed).columns
            out["F"][index] = costs_of(columns, len(chosen), scene.search)
            excess = excesses(self.question.limits, columns, chosen)
            out["G"][index] = np.clip(excess, -WORST, WORST).T
        out["F"][np.all(out["G"] == WORST, axis=1)] = WORST  # cannot be put together


class Archive(Callback):  # type: ignore[misc]
    """The non-dominated ones of all feasible designs that a run evaluates."""

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self.search, self.rows = scene.search, None

    def notify(self, algorithm: Any) -> None:
        new = algorithm.off if algorithm.off is not None else algorithm.pop
        costs = new.get("F")[np.all(new.get("G") <= 0.0, axis=1)]
        costs = costs if self.rows is None else np.concatenate([self.rows, costs])
        columns = dict(zip(self.search.minimise, costs.T, strict=True))
        self.rows = objectives(non_dominated(Rows(columns, len(costs)), self.search), self.search)


def rival(scene: Scene, seconds: float, seed: int, scale: Scale) -> tuple[float, float, int]:
    """Hypervolume of the last population and of the archive of a run of NSGA-II; and its evaluations."""
    archive, until = Archive(scene), TimeBasedTermination(seconds)
    found = minimize(Cams(scene), NSGA2(POPULATION), until, seed=seed, callback=archive)
    volumes = [hypervolume(scale.normalised(costs))[0] for costs in (found.F, archive.rows)]
    return volumes[0], volumes[1], found.algorithm.evaluator.n_eval


def least_seconds(run: Any) -> float:
    """The least time of a few runs, after one that does not count."""
    run()
    times = []
    for _ in range(RUNS):
        start = perf_counter()
        run()
        times.append(perf_counter() - start)
    return min(times)


def main() -> None:
    scene = find_scene(sys.argv[1] if len(sys.argv) > 1 else "roller-1000rpm")
    finer = scene.replace(**{"search.refine": True})
    with TemporaryDirectory() as folder:
        front = sweep(finer, folder).front
        costs = load(Path(folder) / "pareto.parquet")[list(scene.search.minimise)].to_numpy()
        plain, whole = (least_seconds(partial(sweep, each, folder)) for each in (scene, finer))
    assert front is not None
    print("| front | seconds | points | designs | hypervolume |\n|---|---:|---:|---:|---:|")
    print(f"| grid | {plain:.2f} | {front.grid_points} | | {front.grid_hypervolume:.6f} |")
    print(f"| grid, refined | {whole:.2f} | {front.points} | | {front.hypervolume:.6f} |")
    rival(scene, 1.0, 0, scale_of(costs))  # imports, kernels
    for times in TIMES:
        runs = [rival(scene, times * whole, seed, scale_of(costs)) for seed in range(SEEDS)]
        for name, k in (("last population", 0), ("archive", 1)):
            volumes = sorted(run[k] for run in runs)
            label, designs = f"NSGA-II × {times}, {name}", sorted(run[2] for run in runs)[SEEDS // 2]
            spread = f"{volumes[SEEDS // 2]:.6f} ({volumes[0]:.6f} to {volumes[-1]:.6f})"
            print(f"| {label} | {times * whole:.2f} | | {designs:,} | {spread} |")


if __name__ == "__main__":
    main()
