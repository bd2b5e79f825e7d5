"""Scenes whose proof once took minutes: few boxes prove them, and no design near the answer is smaller."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from support.loaded_scenes import random_scene

from camopt import Scene
from camopt.core.numerics import LARGEST, curve_kernels
from camopt.core.numerics.extremes import search_curve
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.loads import contact_load_curve
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.scene.problem.space import search_boxes
from camopt.solve.smallest.branch_and_bound import BoxSearch
from camopt.solve.smallest.result import allowed_proof_gap
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.verdicts.feasible_filter import feasible_designs

MOST_BOXES = {
    43: 50_000,  # knife on an arm, three free sizes: two peaks of the side thrust hold it; 375,000 did not prove it
    45: 1_000,  # groove with an arm: the force changes by 1e-8 of itself where the size does by 1e-3 mm
}


@pytest.mark.long
@pytest.mark.parametrize("seed", [43, pytest.param(45, marks=pytest.mark.long)])
def test_few_boxes_prove_the_smallest_cam(seed, monkeypatch):
    monkeypatch.setattr(BoxSearch, "most_boxes", MOST_BOXES[seed])
    problem = with_rounding_relative_error(resolve(Scene.from_dict(random_scene(seed)[1])))
    (bounds,) = search_boxes(problem)
    found = solve_smallest_cam(problem, bounds)
    assert found.is_proved
    assert feasible_designs(problem, found.design)[0]
    assert not np.any(feasible_designs(problem, smaller_than(found.design, bounds)))


def smaller_than(design, bounds):
    """Random designs within bounds, near one and further away, that a proof says are not feasible."""
    rng, count = np.random.default_rng(0), 4000
    near = design.take(np.zeros(count, dtype=int))
    step = 10.0 ** rng.uniform(-9, -1, count)
    free = [name for name, (low, high) in bounds.items() if name != "size" and high > low]
    sizes = {n: np.clip(near.sizes[n] * (1.0 + step * rng.uniform(-1, 1, count)), *bounds[n]) for n in free}
    return replace(
        near, **sizes, size=near.size - allowed_proof_gap(design) - near.size * step * rng.uniform(0, 1, count)
    )


@pytest.mark.slow
def test_what_has_no_bound_is_not_looked_at_to_the_last_part(monkeypatch):
    """The load of a mushroom on an undercut flank has none over half a stroke: 83,000 parts were looked at."""
    problem = with_rounding_relative_error(resolve(Scene.from_dict(random_scene(129)[1])))
    undercut = replace(problem.design, size=np.array([25.8107]), roller_radius=np.array([66.365]))
    parts, looked_at = [], curve_kernels.state_jets_over_part
    monkeypatch.setattr(curve_kernels, "state_jets_over_part", lambda *given: parts.append(1) or looked_at(*given))
    plain = getattr(search_curve, "py_func", search_curve)
    monkeypatch.setattr("camopt.core.numerics.extremes.search_curve", plain)
    found = EvaluationBlock(problem.setup, problem.programme, undercut).extremes(
        partial(contact_load_curve, problem.setup), [(ALL_STROKES, LARGEST)]
    )
    assert np.isinf(found.width).all()
    assert len(parts) < 4000
