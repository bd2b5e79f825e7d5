"""Columns of quantities that are means: exact for the motion itself, else by Gauss's rule on parts of panels."""

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.quadrature import GaussRule, Integrals, integrate_with_rising_order
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.effects.effect import EnclosedValue, EvaluationBlock
from camopt.model.effects.mean import Mean
from camopt.model.effects.panel_parts import PanelParts, cut_panels, part_states
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme, derivative_power_mean

POINTS_AT_ONCE = 2**17  # points of all designs that are computed together
ALL_DESIGNS = np.s_[:, None, None]
"""Index of all designs, for many cam angles of many parts."""


def power_means(case: EvaluationBlock, mean: Mean) -> Integrals:
    """Mean of the curve to the power p, by design (designs,), with its error."""
    count, programme = len(case.designs), case.programme
    if mean.jumps(programme):
        return Integrals(np.full(count, inf), np.zeros(count))
    if isinstance(curve := mean.curves[0][0], MotionDerivative):
        value = derivative_power_mean(curve.motion_of_tool_or_follower(programme), curve.order, mean.power)
        return Integrals(np.full(count, value), np.zeros(count))
    if mean.smooth is None:
        return _power_means_over_parts(case, mean, cut_panels(programme.table, ()))
    means = Integrals(*np.zeros((2, count)))
    for number in range(count):
        one = replace(case, designs=case.designs.take([number]))
        part = _power_means_over_parts(one, mean, mean.smooth(one.designs, programme))
        means.value[number], means.error[number] = part.value[0], part.error[0]
    return means


def _power_means_over_parts(case: EvaluationBlock, mean: Mean, parts: PanelParts) -> Integrals:
    """Power means by design with their errors, for designs whose curves are smooth on the same parts."""
    count = len(case.designs)

    def power_means_of_designs(rule: GaussRule, index: Any) -> FloatArray:
        designs = case.designs.take(index)
        points = len(designs) * parts.panel.size * rule.nodes.size
        blocks = np.array_split(np.arange(len(designs)), 1 + points // POINTS_AT_ONCE)
        rows = [
            _power_means_by_gauss_rule(mean, designs.take(block), case.programme, parts, rule) for block in blocks
        ]
        return np.concatenate(rows)[None]

    value, error = integrate_with_rising_order(power_means_of_designs, np.abs, count, case.setup.relative_error)
    return Integrals(value[0], error[0])


def _power_means_by_gauss_rule(
    mean: Mean, designs: Designs, programme: Programme, parts: PanelParts, rule: GaussRule
) -> FloatArray:
    """Mean of the curve to the power p, by one rule on each part."""
    total = np.zeros(len(designs))
    kinds = np.repeat(programme.table.kind, np.diff(programme.table.first_panel))[parts.panel]
    for make, curve_kinds in mean.curves:
        curve_parts = parts.take((kinds & curve_kinds) != 0)
        state = part_states(programme, curve_parts, curve_parts.panel_places_of_part_places(rule.nodes[:, None]))
        value = curve_value(make(designs, programme), ALL_DESIGNS, state)
        half = 0.5 * programme.table.half_width[curve_parts.panel] * (curve_parts.high - curve_parts.low)
        powers = np.broadcast_to(value**mean.power, (len(designs), rule.nodes.size, half.size))
        total += matrix_product(matrix_product(rule.weights, np.moveaxis(powers, 1, 0)), half) / (2.0 * np.pi)
    return total


def mean_column(case: EvaluationBlock, mean: Mean, sound_designs: Any = True) -> EnclosedValue:
    """The column of a mean; infinite for designs that are not ``sound_designs``."""
    count = len(case.designs)
    index = np.flatnonzero(np.broadcast_to(sound_designs, count))
    powers = Integrals(np.full(count, inf), np.zeros(count))
    for column, part in zip(
        powers, power_means(replace(case, designs=case.designs.take(index)), mean), strict=True
    ):
        column[index] = part
    near, far = (
        np.asarray(mean.mean_from_power_mean(each)) for each in (powers.value, powers.value + powers.error)
    )
    value = np.asarray(mean.scale.quantity_from_extreme(near, case.designs))
    finite = np.isfinite(near)
    by = np.where(finite, far - np.where(finite, near, 0.0), 0.0)
    return EnclosedValue(value, mean.scale.quantity_change(near, by, case.designs), np.abs(value))
