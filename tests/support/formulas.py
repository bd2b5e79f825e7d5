"""Random formulas, on ranges and on balls: a script, so that other processors' kernels can be asked for them.

``python -m support.formulas SEED COUNT`` says how many formulas at points have a range that does not hold the ball.
"""

import sys

import numpy as np
from flint import arb

from camopt.core.numerics.interval import Interval
from camopt.core.numerics.sloped_interval import box_variables
from camopt.core.numerics.stable_functions import compensated_sum, difference_of_squares_root
from support.balls.ball import Ball, as_arb, precisely

TWO = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": lambda a, b: a / (np.square(b) + 0.125),
    "angle of a vector": lambda a, b: np.arctan2(a, np.square(b) + 0.125),
}
ONE = {
    "negative": np.negative,
    "square": np.square,
    "root": lambda a: np.sqrt(np.square(a) + 0.5),
    "sine": np.sin,
    "cosine": np.cos,
    "power": lambda a: np.power(np.square(a) + 0.25, 0.7),
    "inverse power": lambda a: np.power(np.square(a) + 0.25, -0.43),
    "magnitude": np.absolute,
    "angle": lambda a: np.arcsin(a / np.sqrt(np.square(a) + 1.0)),
    "tangent": lambda a: np.sin(0.1 * a) / (np.square(np.cos(a)) + 0.01),
}
OPERATIONS, LARGEST = 12, 1e6
"""Of a formula, and the largest number in one that is worth it."""


def formula(rng):
    """The operations of a random formula of two numbers, each with the places of its operands."""
    steps = []
    for k in range(2, 2 + OPERATIONS):
        name = str(rng.choice([*TWO, *ONE]))
        steps.append((name, *(int(x) for x in rng.integers(max(0, k - 5), k, 2 if name in TWO else 1))))
    return steps


def values(steps, *given):
    """All numbers of a formula."""
    known = list(given)
    for name, *places in steps:
        known.append((TWO.get(name) or ONE[name])(*(known[place] for place in places)))
    return known


def count_missed(seed, count):
    """Of formulas at points, how many have a range, or one with slopes, that does not hold the exact value."""
    rng, wrong = np.random.default_rng(seed), 0
    for _ in range(count):
        steps, (x, y) = formula(rng), rng.uniform(-3.0, 3.0, 2) * 10.0 ** rng.integers(-2, 3)
        if max(map(abs, values(steps, x, y))) > LARGEST:
            continue
        true = as_arb(values(steps, Ball(x), Ball(y))[-1])
        points = [Interval(np.array([each]), np.array([each])) for each in (x, y)]
        wide = [Interval(each.low - 1e-7, each.high + 1e-7) for each in points]
        sloped = values(steps, *box_variables(wide, [np.array([x]), np.array([y])]))[-1]
        wrong += not all(_holds(each, true) for each in (values(steps, *points)[-1], sloped.at, sloped.value))
        wrong += not _root_is_held(rng)
    return wrong


def _holds(found, true):
    """Whether a range may hold what a ball holds: the ball is 1e-40 wide."""
    return not true < arb(float(found.low[0])) and not true > arb(float(found.high[0]))


def _root_is_held(rng):
    """Whether √((a + c)² − b²), nearly 0, and a sum that nearly cancels, lie in their ranges."""
    a, c = rng.uniform(1.0, 100.0, 2)
    b = (a + c) * (1.0 - 10.0 ** -rng.uniform(1.0, 15.0))
    one, other, more = (Interval(np.array([each]), np.array([each])) for each in (a, b, c))
    total = arb(a) + arb(c)
    root = _holds(difference_of_squares_root(one, other, more), (total * total - arb(b) * arb(b)).sqrt())
    return root and _holds(compensated_sum(one, more, -other), total - arb(b))


if __name__ == "__main__":
    with precisely():
        print(count_missed(*map(int, sys.argv[1:])))
