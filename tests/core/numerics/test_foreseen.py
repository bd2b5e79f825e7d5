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
from camopt.core.kernels import compile
from camopt.core.kernels.address_calls import address_of_values
from camopt.core.kernels.arguments import kernel_argument_type
from camopt.core.numerics.climbing import PeakQuery
from camopt.core.numerics.curve_kernels import evaluator_with_function_addresses
from camopt.core.numerics.extremes import Precision, extremes_of_curve
from camopt.core.numerics.halving import POINT_WIDTH
from camopt.core.numerics.panel_prefetch import HALF_LEVELS, CachingEvaluator
from camopt.model.effects.loads import contact_load_curve, torque_curve
from camopt.model.effects.surface import inverse_film_curve
from camopt.scene.problem.problem import resolve

DEEPEST = 2 * HALF_LEVELS  # halvings: more than are evaluated in advance
DESIGNS = 4
SMALLEST = 7.05953123
"""Size of the arm's smallest cam without undercut, in mm."""
MOST_FORMULAS = 500


def curves_of(contact, setup, designs, programme):
    """Curves of geometry and of loads, the latter under one that changes."""
    mechanism = setup.mechanism
    yield from (make(designs, programme) for make in (mechanism.pressure, mechanism.curvature) if make)
    yield from (make(setup, designs, programme) for make in (torque_curve, contact_load_curve))
    if mechanism.sliding and contact != "knife":
        yield inverse_film_curve(setup, designs, programme)


def problem_of(contact, law="modified-sine"):
    """A cam with all loads."""
    swinging = CONTACTS[contact]["motion"] == "oscillating"
    dynamics = {**(SWUNG if swinging else GUIDED), "load": MOMENT if swinging else CORNERED}
    return resolve(Scene.from_dict(cam_with(contact, law, dynamics, materials=WORN)))


@cache
def evaluators(contact):
    """What evaluates each curve of a cam, and its table."""
    problem = problem_of(contact)
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


def row_of(curve, panel, sign, place):
    """A part that waits to be halved: its design and its ends."""
    design, middle, reach = place
    sides = middle - reach, middle + reach
    return design, *sides, *(x for u in sides for x in curve.point(curve.source, panel, u, sign, design))


SIDES = st.lists(st.sampled_from((-1.0, 1.0)), min_size=1, max_size=DEEPEST)
PARTS = st.lists(st.builds(part_from, st.integers(0, DESIGNS - 1), SIDES), min_size=1, max_size=3)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("contact", CONTACTS)
@settings(max_examples=times(4, deep=100))
@given(
    places=PARTS,
    asked=PARTS,
    share=st.floats(0.0, 1.0),
    sign=st.sampled_from((-1.0, 1.0)),
    blur=st.sampled_from((np.inf, 1e-14)),
)
def test_together_and_alone_are_the_same_bits(contact, places, asked, share, sign, blur):
    least = np.zeros(DESIGNS)
    for curve in evaluators(contact):
        _, table = curve.source[0]
        panel = int(share * (table.centre.size - 1))
        with np.errstate(all="ignore"):
            parts = np.array([row_of(curve, panel, sign, place) for place in places]).T
            foreseen, query = CachingEvaluator(*curve), PeakQuery(sign, 1e-13, np.inf, blur)
            foreseen.begin_halving(panel, parts, query, (0, least, least))
            points = [(i, middle, POINT_WIDTH) for i, middle, _ in places]
            for design, middle, reach in (*places, *asked, *points, *((i, 0.0, 1.0) for i, _, _ in places)):
                alone = curve.part(curve.source, panel, middle, reach, design)
                assert np.array_equal(
                    foreseen.part(curve.source, panel, middle, reach, design), alone, equal_nan=True
                )
                alone = curve.point(curve.source, panel, middle, sign, design)
                assert np.array_equal(
                    foreseen.point(curve.source, panel, middle, sign, design), alone, equal_nan=True
                )


@pytest.mark.slow
def test_a_curve_without_bounds_takes_few_formulas(monkeypatch):
    """At the smallest size a denominator comes near zero, and two panels are halved into 4,000 parts each."""
    monkeypatch.setattr(compile, "NEVER_COMPILE", True)
    problem = problem_of("arm", "cycloidal")
    film = inverse_film_curve(problem.setup, replace(problem.design, size=np.array([SMALLEST])), problem.programme)
    extremes = extremes_of_curve(film, 1, problem.programme.table, [(7, 0)], Precision(1e-13, np.inf))
    formulas = compile.PLAIN_RUN.work / compile.FORMULA_CALL_WORK
    assert extremes.width == np.inf
    assert formulas / compile.nested_curve_count(kernel_argument_type(film)) < MOST_FORMULAS
