"""Throughput: pressure angle and curvature extremes of 20,000 random roller cams, against numpy."""

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from rival_numpy import LAWS, Cams, Extremes, polished, sampled
from timing import measured, ratio, rival_seconds, seconds

from camopt import find_scene
from camopt.effects import Case
from camopt.mechanisms import Designs
from camopt.problem.problem import resolve
from camopt.verdicts.running import run_effects

DESIGNS = 20_000
POLISHED_ANGLES = 72  # the fewest, of those tried, that reach AGREEMENT for each law
SAMPLED_ANGLES = 360
AGREEMENT = 1e-9
QUANTITIES = ("pressure_angle_max_deg", "pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm")


def random_designs(law: str) -> tuple[Case, Cams]:
    """The same designs for camopt and for numpy."""
    scene = find_scene("roller-1000rpm")
    problem = resolve(scene)
    rng = np.random.default_rng(20240611)
    sizes = {name: np.zeros(DESIGNS) for name in problem.design.sizes}
    sizes["size"] = rng.uniform(30, 150, DESIGNS)
    sizes["offset"] = rng.uniform(-25, 25, DESIGNS)
    sizes["roller_radius"] = rng.uniform(5, 20, DESIGNS)
    designs = Designs(**sizes, sense=problem.design.sense)
    programme = problem.with_laws(law, law)
    return Case(problem.setup, programme, designs), Cams(designs.prime_radius, designs.lead)


def worst_difference(found: Extremes, reference: Extremes) -> float:
    """The largest difference of any quantity of any design, relative to the quantity.

    Of the two curvatures, relative to the larger one: the flattest place of a cam may have next to none.
    """
    curvature = np.maximum(*(np.abs(reference[name]) for name in QUANTITIES[1:]))
    scales = (reference[QUANTITIES[0]], curvature, curvature)
    pairs = zip(QUANTITIES, scales, strict=True)
    return max(float((np.abs(found[name] - reference[name]) / scale).max()) for name, scale in pairs)


@pytest.mark.parametrize("law", LAWS)
def bench_extremes(benchmark: BenchmarkFixture, law: str) -> None:
    """camopt against numpy at the same accuracy, and against numpy's plain samples."""
    case, cams = random_designs(law)
    rows = measured(benchmark, lambda: run_effects(case, QUANTITIES))
    found = {name: rows.columns[name] for name in QUANTITIES}
    same, samples = polished(cams, law, POLISHED_ANGLES), sampled(cams, law, SAMPLED_ANGLES)
    difference = worst_difference(found, same)
    own = seconds(benchmark)
    rival = rival_seconds(benchmark, lambda: polished(cams, law, POLISHED_ANGLES), 3)
    plain = rival_seconds(benchmark, lambda: sampled(cams, law, SAMPLED_ANGLES), 3)
    benchmark.extra_info |= {
        "designs_per_second": DESIGNS / own,
        "largest_pressure_angle_deg": float(found["pressure_angle_max_deg"].max()),
        "largest_curvature_per_mm": float(found["pitch_curvature_max_per_mm"].max()),
        "numpy_polished_ns_per_design": round(rival / DESIGNS * 1e9, 1),
        "numpy_polished_worst_difference": difference,
        "numpy_polished_ratio": ratio(rival, own),
        f"numpy_{SAMPLED_ANGLES}_ns_per_design": round(plain / DESIGNS * 1e9, 1),
        f"numpy_{SAMPLED_ANGLES}_worst_error": worst_difference(samples, found),
        f"numpy_{SAMPLED_ANGLES}_ratio": ratio(plain, own),
    }
    assert difference <= AGREEMENT
