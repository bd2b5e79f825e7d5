"""Bounds of quantities over all errors: quantities with a known maximum, and reasons for no bound."""

import numpy as np
import pytest

import camopt
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.scene.problem.problem import resolve_design
from camopt.solve.tolerances.bound_search import (
    BoundSearch,
    coordinate_box,
    missing_bound_reason,
    whole_panel_parts,
)

ENDS = {"size": (-0.1, 0.2), "offset": (-0.3, 0.1), "bore_eccentricity": (0.0, 0.05)}
WAY = {"bore_eccentricity_way": (-np.pi, np.pi)}


def search(quantity, ends, **more):
    problem = resolve_design(camopt.find_scene("bucket-valve"))
    return BoundSearch(problem, quantity, ends, coordinate_box(ends), **more)


def proven_bound(quantity, ends, sides=(1.0,), gap=1e-6, budget=UNLIMITED):
    of = search(quantity, ends)
    return of.prove_upper_bound(whole_panel_parts(of.problem, of.box, sides=sides), -np.inf, gap, budget)


def test_the_bound_of_errors_that_are_not_monotone_and_of_a_direction_is_their_most():
    """x − x² has its most inside, 0.1² of an offset at its lower end, and a vector its length times its slope."""

    def quantity(x, at):
        first = x["size"] * (0.15 - x["size"]) + np.square(x["offset"])
        return first + x["bore_eccentricity"] * 0.6 - x["bore_eccentricity_way"] * 0.8

    exact = 0.075**2 + 0.3**2 + 0.05
    found = proven_bound(quantity, ENDS | WAY)
    assert exact - 1e-9 <= found.high <= exact * (1.0 + 1.1e-6)
    assert found.witness_value <= exact
    assert found.witness["offset"] == -0.3
    assert found.witness["size"] == pytest.approx(0.075, abs=1e-3)
    assert found.witness["bore_eccentricity"] == pytest.approx(0.05)
    assert found.witness["bore_eccentricity_way"] == pytest.approx(np.arctan2(-0.8, 0.6), abs=1e-3)


def test_the_turn_is_cut_where_a_quantity_is_the_most():
    """y·(1 + x) of a lift of the scene, and the least of it on the other side."""
    lift = resolve_design(camopt.find_scene("bucket-valve")).programme.lift
    ends = {"size": ENDS["size"]}
    found = proven_bound(lambda x, at: at.y * (x["size"] + 1.0), ends)
    assert lift * 1.2 * (1.0 - 1e-12) <= found.high <= lift * 1.2 * (1.0 + 1.1e-6)
    both = proven_bound(lambda x, at: at.y * (x["size"] - 1.0), ends, (1.0, -1.0))
    assert both.high == pytest.approx(1.1 * lift, rel=1.1e-6)


def test_a_coarse_gap_is_kept_and_why_there_is_no_bound_is_said():
    def quantity(x, at):
        return np.sin(x["size"] * 7.0) * at.y

    fine, coarse = (proven_bound(quantity, {"size": (-0.4, 0.4)}, gap=gap).high for gap in (1e-6, 0.1))
    assert fine <= coarse <= 1.1 * fine
    assert proven_bound(quantity, {"size": (-0.4, 0.4)}, budget=Budget(0.0)).high == np.inf
    assert missing_bound_reason(fine, UNLIMITED) == ""
    assert missing_bound_reason(np.inf, UNLIMITED) == "the tolerances are too large for it"
    assert missing_bound_reason(np.inf, Budget(0.0)) == "the proof takes too much work"
