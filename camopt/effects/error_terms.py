"""Terms of the errors of velocity and acceleration, as kernels have them (``effects.error_rates``).

Each is a value and its slope by the cam angle; ``f`` has coefficients of designs, and the order of the derivative.
"""

import numpy as np

from camopt.kernels.compile import inlined

TINY = 1e-60
"""Below any square that counts: so that a root of two squares has a slope where both are 0."""


@inlined
def either(half, middle, c, c1):
    """half·|c| + middle·c, and its slope."""
    return half * np.abs(c) + middle * c, (half * np.sign(c) + middle) * c1


@inlined
def length(a, a1, b, b1):
    """√(a² + b²), and its slope."""
    root = np.sqrt(np.square(a) + np.square(b) + TINY)
    return root, (a * a1 + b * b1) / root


@inlined
def of_normal(f, i, g, chi):
    """What is off along the normal, from G and χ', each with derivatives."""
    (g0, g1, g2, g3), (x1, x2, x3) = g, chi
    n = f.waves[i]
    if f.order == 1:
        waved, waved1 = length(g1, g2, n * g0, n * g1)
        turned, turned1 = length(g1, g2, g0 * x1, g1 * x1 + g0 * x2)
        other, other1 = either(f.half[i], f.middle[i], g1, g2)
    else:
        steep, steep1 = length(2.0 * g1, 2.0 * g2, n * g0, n * g1)
        waved, waved1 = np.abs(g2) + n * steep, np.sign(g2) * g3 + n * steep1
        square = np.square(x1)
        out, across = g2 - g0 * square, 2.0 * g1 * x1 + g0 * x2
        out1, across1 = g3 - g1 * square - 2.0 * g0 * x1 * x2, 2.0 * g2 * x1 + 3.0 * g1 * x2 + g0 * x3
        turned, turned1 = length(out, out1, across, across1)
        other, other1 = either(f.half[i], f.middle[i], g2, g3)
    value = f.profile[i] * waved + f.bore[i] * turned + other
    return value, f.profile[i] * waved1 + f.bore[i] * turned1 + other1


@inlined
def of_motion(f, i, at):
    """What answers as y' does."""
    if f.order == 1:
        ahead, ahead1 = either(f.turning[i], f.ahead[i], at.y2, at.y3)
        across, across1 = length(at.y2, at.y3, at.y1, at.y2)
    else:
        ahead, ahead1 = either(f.turning[i], f.ahead[i], at.y3, at.y4)
        across, across1 = length(at.y3 - at.y1, at.y4 - at.y2, 2.0 * at.y2, 2.0 * at.y3)
    return ahead + f.around[i] * across, ahead1 + f.around[i] * across1


@inlined
def of_order(order, c1, c2, c3):
    """The derivative of an order, and the next one."""
    return (c1, c2) if order == 1 else (c2, c3)
