"""
Another optimiser: pymoo asks for a generation at a time
========================================================

Any optimiser can use camopt's evaluation. Differential evolution comes near the smallest cam; ``optimise`` finds
and proves it.
"""

import matplotlib.pyplot as plt
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.core.problem import Problem
from pymoo.optimize import minimize

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(**{"search.law": ["cycloidal"], "search.roller_radius": [5]})


class SmallestCam(Problem):
    def __init__(self):
        limits = sum(
            name.startswith("excess_") for name in camopt.evaluate_designs(scene, {"base_radius_mm": [60]})
        )
        super().__init__(n_var=2, n_obj=1, n_ieq_constr=limits, xl=[10, -30], xu=[120, 30])

    def _evaluate(self, x, out):
        columns = {"base_radius_mm": x[:, 0], "offset_mm": x[:, 1], "law": "cycloidal"}
        found = camopt.evaluate_designs(scene, columns)
        out["F"] = x[:, 0]
        out["G"] = found.filter(like="excess_").clip(upper=10).to_numpy()  # 0 or less where a limit is met


rival = minimize(SmallestCam(), DE(pop_size=24, CR=0.9), ("n_gen", 60), seed=1, save_history=True)
proved = camopt.optimise(scene).best["base_radius_mm"]
print(f"differential evolution {rival.F[0]:.6f} mm, optimise {proved:.6f} mm")

# %%
# How far the best of each generation is above the smallest cam:

figure, ax = plt.subplots()
found = [(each.evaluator.n_eval, each.opt[0].F[0]) for each in rival.history if each.opt[0].FEAS]
evaluations, sizes = zip(*found, strict=True)
ax.semilogy(evaluations, [size - proved for size in sizes], "o-", ms=3)
ax.set(xlabel="designs evaluated", ylabel="base radius above the proved smallest, mm")
