"""The columns of quantities that are means: exact for the motion alone, else by Gauss's rule on parts of panels."""

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.quadrature import Integrated, Rule, by_orders
from camopt.core.numerics.stable import matrix_product
from camopt.model.effects.case import Bounded, Case
from camopt.model.effects.mean import Mean
from camopt.model.effects.panel_parts import PanelParts, cut_panels, motion_in
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme, mean_of_powers

POINTS_AT_ONCE = 2**17  # points of all designs of a block
ALL_DESIGNS = np.s_[:, None, None]
"""All designs, at many cam angles of many parts."""


def powers_of(case: Case, mean: Mean) -> Integrated:
    """The mean of the curve to the power p of each design (designs,), with its error."""
    count, programme = len(case.designs), case.programme
    if mean.jumps(programme):
        return Integrated(np.full(count, inf), np.zeros(count))
    if isinstance(made := mean.curves[0][0], Derivative):
        return Integrated(
            np.full(count, mean_of_powers(made.of(programme), made.order, mean.power)), np.zeros(count)
        )
    if mean.smooth is None:
        return _integrated(case, mean, cut_panels(programme.table, ()))
    found = Integrated(*np.zeros((2, count)))
    for number in range(count):
        one = replace(case, designs=case.designs.take([number]))
        each = _integrated(one, mean, mean.smooth(one.designs, programme))
        found.value[number], found.error[number] = each.value[0], each.error[0]
    return found


def _integrated(case: Case, mean: Mean, parts: PanelParts) -> Integrated:
    """As ``powers_of``, for designs whose curves are smooth on the same parts."""
    count = len(case.designs)

    def integrals(rule: Rule, index: Any) -> FloatArray:
        designs = case.designs.take(index)
        points = len(designs) * parts.panel.size * rule.nodes.size
        blocks = np.array_split(np.arange(len(designs)), 1 + points // POINTS_AT_ONCE)
        rows = [_by_rule(mean, designs.take(block), case.programme, parts, rule) for block in blocks]
        return np.concatenate(rows)[None]

    value, error = by_orders(integrals, np.abs, count, case.setup.relative_error)
    return Integrated(value[0], error[0])


def _by_rule(mean: Mean, designs: Designs, programme: Programme, parts: PanelParts, rule: Rule) -> FloatArray:
    """The mean of the curve to the power p by one rule on each part."""
    total = np.zeros(len(designs))
    kinds = np.repeat(programme.table.kind, np.diff(programme.table.first_panel))[parts.panel]
    for make, chosen in mean.curves:
        some = parts.take((kinds & chosen) != 0)
        state = motion_in(programme, some, some.at(rule.nodes[:, None]))
        value = value_of(make(designs, programme), ALL_DESIGNS, state)
        half = 0.5 * programme.table.half_width[some.panel] * (some.high - some.low)
        whole = np.broadcast_to(value**mean.power, (len(designs), rule.nodes.size, half.size))
        total += matrix_product(matrix_product(rule.weights, np.moveaxis(whole, 1, 0)), half) / (2.0 * np.pi)
    return total


def mean_column(case: Case, mean: Mean, sound: Any = True) -> Bounded:
    """A quantity that is a mean, of all designs of a case; infinite for designs that are not sound."""
    count = len(case.designs)
    index = np.flatnonzero(np.broadcast_to(sound, count))
    found = Integrated(np.full(count, inf), np.zeros(count))
    for whole, some in zip(found, powers_of(replace(case, designs=case.designs.take(index)), mean), strict=True):
        whole[index] = some
    near, far = (np.asarray(mean.of_powers(each)) for each in (found.value, found.value + found.error))
    value = np.asarray(mean.scale.quantity(near, case.designs))
    finite = np.isfinite(near)
    by = np.where(finite, far - np.where(finite, near, 0.0), 0.0)
    return Bounded(value, mean.scale.change(near, by, case.designs), np.abs(value))
