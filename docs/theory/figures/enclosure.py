"""What chords and the second derivative say of a curve over its panels, and how fast that closes."""

import matplotlib.pyplot as plt
import numpy as np
from roller import PROGRAMME

from camopt.show.drawing.style import ALARM, INK, SERIES, add_grid


def tangent(theta):
    y, y1, *_ = PROGRAMME.motion_at(theta)
    return y1 / (y + 48.0)


def bounds(panels):
    """Nodes, their values, and a bound over each panel of the rise."""
    nodes = np.linspace(1e-9, np.radians(100) - 1e-9, panels + 1)
    values = tangent(nodes)
    inside = nodes[:-1, None] + np.diff(nodes)[:, None] * np.linspace(0, 1, 41)
    bend = (
        np.abs(np.gradient(np.gradient(tangent(inside), axis=1), axis=1)).max(axis=1) / (np.diff(nodes) / 40) ** 2
    )
    return nodes, values, np.maximum(values[:-1], values[1:]) + bend * np.diff(nodes) ** 2 / 8


figure, (above, below) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained", width_ratios=(3, 2))
nodes, values, most = bounds(12)
theta = np.linspace(0, np.radians(100), 500)
for left, right, bound in zip(nodes[:-1], nodes[1:], most, strict=True):
    open_still = bound > values.max()
    colour = ALARM if open_still else SERIES[0]
    above.fill_between(np.degrees([left, right]), 0, [bound] * 2, color=colour, alpha=0.16, lw=0)
    above.plot(np.degrees([left, right]), [bound] * 2, color=colour, lw=1.4)
above.plot(np.degrees(theta), tangent(theta), color=INK, lw=1.3)
above.plot(np.degrees(nodes), values, "o", color=INK, ms=3)
above.axhline(values.max(), color=INK, lw=0.7, ls=(0, (4, 3)))
above.set(xlabel="cam angle, deg", ylabel="tan β", title="12 panels of the rise: red ones stay open")
counts = np.array([6, 12, 24, 48, 96, 192])
gap = []
for count in counts:
    nodes, _, most = bounds(count)
    inside = nodes[:-1, None] + np.diff(nodes)[:, None] * np.linspace(0, 1, 401)
    gap.append((most - tangent(inside).max(axis=1)).max())
below.loglog(counts, gap, "o-", color=SERIES[0], lw=1.2, ms=4)
below.loglog(counts, gap[0] * (counts / counts[0]) ** -2.0, color=INK, lw=0.8, ls=(0, (4, 3)))
below.text(70, 2.5 * gap[0] * (70 / 6) ** -2.0, "$w^2$", color=INK)
below.set(xlabel="panels", ylabel="bound less largest value", title="closes with the square of the width")
add_grid(below)
