"""Radii of bodies with which designs of a pitch curve meet a limit, against the weight itself."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camopt.model.effects.peak import BodyRadiusPlus, CutterExcessOverRoller, RadiusRange
from camopt.scene.problem.limit import CLEAR_SHARE


@pytest.mark.parametrize("weight", [BodyRadiusPlus, CutterExcessOverRoller])
@given(radius=st.sampled_from([0.0, 0.3, 1.0, 25.0, 1e4]), seed=st.integers(0, 10**6))
def test_bodies_hold_where_the_weight_times_the_extreme_is_at_most_one(weight, radius, seed):
    """For certain within the range, and nowhere beyond the wider range; only next to its end it is open."""
    rng = np.random.default_rng(seed)
    extreme = rng.choice([-np.inf, -0.2, 0.0, 1e-6, 0.01, 0.2, 3.0, np.inf], 200)
    with np.errstate(divide="ignore"):
        end = np.abs(1.0 / np.maximum(extreme, 0.0) - radius)
    near = np.where(np.isfinite(end), end, 1.0) * (1.0 + rng.choice([0.0, 1e-15, -1e-12, 1e-7, -1e-7], 200))
    body = np.where(rng.random(200) < 0.5, near, rng.uniform(0.0, 60.0, 200))
    product = np.where(np.isfinite(extreme), extreme * 1.0, 0.0) * weight(radius)(
        SimpleNamespace(roller_radius=body)
    )
    held = np.where(np.isfinite(extreme), product, extreme) <= 1.0
    surely, perhaps = (
        weight(radius).radii_with_weighted_extreme_below_1(extreme, room).contains(body)
        for room in (CLEAR_SHARE, -CLEAR_SHARE)
    )
    assert not np.any(surely & ~held)
    assert not np.any(held & ~perhaps)
    clear = ~np.isfinite(extreme) | (
        np.abs(product - 1.0) > 3e-9 * (1.0 + radius * np.where(np.isfinite(extreme), np.abs(extreme), 0.0))
    )
    assert np.array_equal(surely[clear], held[clear])


@pytest.mark.parametrize("weight", [BodyRadiusPlus, CutterExcessOverRoller])
@given(radius=st.sampled_from([0.0, 0.3, 25.0, 1e4]), ends=st.tuples(st.floats(0, 60), st.floats(0, 60)))
def test_no_body_of_a_range_weighs_more_than_the_largest(weight, radius, ends):
    range_ = RadiusRange(min(ends), max(ends))
    bodies = np.linspace(*range_, 50)
    assert weight(radius).largest_weight(range_) == weight(radius)(SimpleNamespace(roller_radius=bodies)).max()
