"""Parts of a panel that are evaluated together have the bits that each has alone."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.cams import CONTACTS, CORNERED, GUIDED, MOMENT, SWUNG, WORN, cam_with
from support.depth import times

from camopt import Scene
from camopt.core.kernels.address_calls import address_of_values
from camopt.core.numerics.curve_kernels import evaluator_with_function_addresses
from camopt.core.numerics.panel_prefetch import HALF_LEVELS, caching_evaluator
from camopt.model.effects.loads import contact_load_curve, torque_curve
from camopt.model.effects.surface import inverse_film_curve
from camopt.scene.problem.problem import resolve

DEEPEST = 2 * HALF_LEVELS  # halvings: more than are evaluated in advance
DESIGNS = 4


def curves_of(contact, setup, designs, programme):
    """Curves of geometry and of loads, the latter under one that changes."""
    mechanism = setup.mechanism
    yield from (make(designs, programme) for make in (mechanism.pressure, mechanism.curvature) if make)
    yield from (make(setup, designs, programme) for make in (torque_curve, contact_load_curve))
    if mechanism.sliding and contact != "knife":
        yield inverse_film_curve(setup, designs, programme)


@cache
def evaluators(contact):
    """What evaluates each curve of a cam, and its table."""
    swinging = CONTACTS[contact]["motion"] == "oscillating"
    dynamics = {**(SWUNG if swinging else GUIDED), "load": MOMENT if swinging else CORNERED}
    problem = resolve(Scene.from_dict(cam_with(contact, "modified-sine", dynamics, materials=WORN)))
    same = problem.design.take(np.zeros(DESIGNS, dtype=int))
    designs = replace(same, size=same.size * np.linspace(1.0, 1.2, DESIGNS))
    made = [(f, problem.programme.table) for f in curves_of(contact, problem.setup, designs, problem.programme)]
    return [evaluator_with_function_addresses(each, address_of_values(each)) for each in made]


def part_from(design, turns):
    """The part that halving comes to when it turns left or right so many times."""
    middle, reach = 0.0, 1.0
    for side in turns:
        reach /= 2
        middle += side * reach
    return design, middle, reach


SIDES = st.lists(st.sampled_from((-1.0, 1.0)), min_size=1, max_size=DEEPEST)
PARTS = st.lists(st.builds(part_from, st.integers(0, DESIGNS - 1), SIDES), min_size=1, max_size=3)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("contact", CONTACTS)
@settings(max_examples=times(4, deep=100))
@given(places=PARTS, asked=PARTS, share=st.floats(0.0, 1.0), sign=st.sampled_from((-1.0, 1.0)))
def test_together_and_alone_are_the_same_bits(contact, places, asked, share, sign):
    for curve in evaluators(contact):
        _, table = curve.source[0]
        panel = int(share * (table.centre.size - 1))
        with np.errstate(all="ignore"):
            foreseen = caching_evaluator(curve).prefetch_panel(panel, places)
            for design, middle, reach in (*places, *asked, *((i, 0.0, 1.0) for i, _, _ in places)):
                alone = curve.part(curve.source, panel, middle, reach, design)
                assert np.array_equal(
                    foreseen.part(curve.source, panel, middle, reach, design), alone, equal_nan=True
                )
                alone = curve.point(curve.source, panel, middle, sign, design)
                assert np.array_equal(
                    foreseen.point(curve.source, panel, middle, sign, design), alone, equal_nan=True
                )
