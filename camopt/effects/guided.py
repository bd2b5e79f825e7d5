"""The torque of a follower that rubs in its guide, as panel polynomials of one design.

    T = F·y'/(1 − sgn(F·y')·μ·q·|tan β|)

depends on the design, and is smooth between the cam angles where F, y' or tan β changes sign. The panels of the
motion end where y' does. They are cut where F and y'' do, so that tan β = (y' − e)/s passes 0 at most once in a
part, and where it does. On each part T is interpolated at Chebyshev points, to rounding while the follower is not
about to jam.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.effects.case import Setup
from camopt.effects.loads import torque_curve, ways
from camopt.effects.work import derivative
from camopt.mechanisms.design import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import IntArray, chebyshev_projection
from camopt.numerics import FloatArray
from camopt.numerics.curves import curve
from camopt.numerics.piecewise import MotionTable, load_series, sign_changes

DEGREE = 20
HALVINGS = 60


class PanelParts(NamedTuple):
    """Parts of panels (n,): the panel, and its ends in u."""

    panel: IntArray
    low: FloatArray
    high: FloatArray

    def at(self, share: FloatArray) -> FloatArray:
        """u at places from −1 to 1 of each part."""
        return 0.5 * ((1.0 - share) * self.low + (1.0 + share) * self.high)

    def take(self, index: Any) -> "PanelParts":
        """Some of the parts."""
        return PanelParts(self.panel[index], self.low[index], self.high[index])


def cut_panels(table: MotionTable, cuts: Iterable[tuple[int, float]]) -> PanelParts:
    """All panels of a motion, cut at (panel, u)."""
    whole = [(panel, -1.0) for panel in range(len(table.centre))]
    panel, low = (np.array(column) for column in zip(*sorted([*whole, *cuts]), strict=True))
    last = np.diff(panel, append=len(table.centre)) != 0
    return PanelParts(panel, low, np.where(last, 1.0, np.append(low[1:], 1.0)))


def motion_in(programme: Programme, parts: PanelParts, u: FloatArray) -> tuple[Any, ...]:
    """What curves take at places (…, n) of parts; y''' is left out, so that slopes mean nothing."""
    table = programme.table
    rows = [polynomial.polyval(u, derivative(table, order)[:, parts.panel], tensor=False) for order in range(3)]
    if programme.load is None:
        return *rows, 0.0
    load = polynomial.polyval(u, load_series(table)[:, parts.panel], tensor=False)
    return *rows, (0.0, load, 0.0)


def smooth_parts(setup: Setup, design: Designs, programme: Programme, force: FloatArray) -> PanelParts:
    """Parts of panels in each of which T is smooth; ``force`` is F on the panels."""
    cuts = [*sign_changes(force), *sign_changes(derivative(programme.table, 2))]
    parts, pressure = cut_panels(programme.table, cuts), setup.mechanism.pressure(design, programme)

    def lean(parts: PanelParts, u: FloatArray) -> FloatArray:
        return np.asarray(np.sign(curve(pressure, 0, *motion_in(programme, parts, u))[0]))

    turned = lean(parts, parts.low) * lean(parts, parts.high) < 0.0
    between = parts.take(turned)
    low, high, before = between.low, between.high, lean(between, between.low)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        same = lean(between, middle) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return cut_panels(programme.table, [*cuts, *zip(between.panel.tolist(), low.tolist(), strict=True)])


def guided_torque(
    setup: Setup, design: Designs, programme: Programme, force: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """T of one design, N·mm: half-widths of parts in rad (n,), and polynomials (powers, n); ``force`` as above."""
    table, (nodes, to_powers) = programme.table, chebyshev_projection(DEGREE)
    parts = smooth_parts(setup, design, programme, force)
    kinds = np.repeat(table.kind, np.diff(table.first_panel))[parts.panel]
    values = np.zeros((nodes.size, parts.panel.size))
    for way, chosen in ways(setup):
        here = (kinds & chosen) != 0
        some = parts.take(here)
        made = torque_curve(setup, design, programme, way)
        values[:, here] = curve(made, 0, *motion_in(programme, some, some.at(nodes[:, None])))[0]
    return 0.5 * table.half_width[parts.panel] * (parts.high - parts.low), to_powers @ values
