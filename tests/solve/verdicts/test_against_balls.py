"""Certificates against balls: random limits of shipped scenes, a billionth or less beside what is reached."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.balls.proof import verdicts_in_balls

from camopt import evaluate, find_scene, shipped_scenes
from camopt.core.mistakes import BadInput
from camopt.core.quantities import QUANTITIES
from camopt.model.effects import available_quantities
from camopt.scene.problem.problem import resolve_design
from camopt.solve.verdicts.certify import certify_limits
from camopt.solve.verdicts.verdict_words import UNDECIDED

MARGINS = 1e-9, 1e-12
NEARLY_ZERO = 1e-9
"""In the unit of a quantity: rounding is all that is left of a smaller one."""


@cache
def reached_quantities(name):
    """The scene without limits, and what its cam reaches of each quantity that a limit bounds."""
    scene = find_scene(name).replace(limits=None, search=None)
    names = [
        each
        for each in available_quantities(resolve_design(scene).setup)
        if each in QUANTITIES and QUANTITIES[each].relation_to_limit
    ]
    found = evaluate(scene.replace(outputs=names))
    return scene, {each: found[each] for each in names if NEARLY_ZERO < abs(found[each]) < np.inf}


def random_verdicts(seed, count):
    """Verdicts in intervals and in balls, and the margin, of some random limits."""
    rng = np.random.default_rng(seed)
    while count:
        scene, values = reached_quantities(str(rng.choice(shipped_scenes())))
        name, margin, side = str(rng.choice(sorted(values))), float(rng.choice(MARGINS)), rng.choice([-1.0, 1.0])
        try:
            problem = resolve_design(scene.replace(limits={name: values[name] + side * margin * abs(values[name])}))
        except BadInput:  # a bound that no cam can be asked to hold
            continue
        problem = replace(problem, limits=tuple(limit for limit in problem.limits if limit.name == name))
        ours, theirs = (of(problem, problem.design)[name] for of in (certify_limits, verdicts_in_balls))
        count -= 1
        yield (scene.name, name, margin), ours, theirs


@pytest.mark.parametrize("seed", range(3))
def test_no_certificate_contradicts_balls(seed):
    for about, ours, theirs in random_verdicts(seed, 4):
        assert UNDECIDED in (ours, theirs) or ours == theirs, about
        assert ours != UNDECIDED or about[2] < MARGINS[0], about


@pytest.mark.long
def test_of_two_thousand_no_certificate_contradicts_balls():
    found = [each for seed in range(100) for each in random_verdicts(1000 + seed, 20)]
    assert [each for each in found if UNDECIDED not in each[1:] and each[1] != each[2]] == []
    assert sum(ours == UNDECIDED for _, ours, _ in found) < 0.01 * len(found)
