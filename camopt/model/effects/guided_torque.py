"""The torque of a follower with friction in its guide, as polynomials on parts of panels, for one design.

    T = F·y'/(1 − sgn(F·y')·μ·q·|tan β|)

T is smooth between the cam angles where F, y' or tan β changes its sign. Panels end where y' changes its sign. They
are cut where F and y'' change theirs, so that tan β = (y' − e)/s has at most one zero in a part, and then at that
zero. On each part T is interpolated at Chebyshev points, to 1e-10 if the follower is not close to jamming.
"""

from functools import lru_cache
from typing import Any

import numpy as np

from camopt.core.numerics import BISECTIONS, FloatArray
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.panel_series import derivative_polynomials_by_panel
from camopt.core.numerics.piecewise import sign_changes
from camopt.core.numerics.quadrature import chebyshev_nodes_and_powers_matrix
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.effects.effect import Setup
from camopt.model.effects.effect_numbers import FollowerDynamics
from camopt.model.effects.force import force_factors_with_train, force_polynomials_by_panel
from camopt.model.effects.loads import friction_signs_by_stroke_kind, torque_curve
from camopt.model.effects.panel_parts import PanelParts, cut_panels, part_states
from camopt.model.mechanisms.design import SIZE_FIELDS, Designs, Mechanism
from camopt.model.motion.programme import Programme

GUIDED_DEGREE = 20
PanelCuts = tuple[tuple[int, float], ...]
"""Cuts of panels: (panel, u)."""


def panel_parts_with_smooth_torque(setup: Setup, design: Designs, programme: Programme) -> PanelParts:
    """Parts of panels on which T is smooth."""
    setup, design = setup.absorb_design_numbers(design)
    sizes = tuple(float(size[0]) for size in design.sizes.values())
    cuts = _force_and_acceleration_sign_cuts(programme, setup.dynamics, setup.omega)
    return _cut_panels_at_cuts_and_pressure_sign_changes(programme, cuts, setup.mechanism, sizes, design.sense)


@lru_cache(maxsize=4096)
def _cut_panels_at_cuts_and_pressure_sign_changes(
    programme: Programme, cuts: PanelCuts, mechanism: Mechanism, sizes: tuple[float, ...], sense: float
) -> PanelParts:
    """The panels cut at ``cuts``, and where tan β changes its sign."""
    arrays: dict[str, Any] = {name: np.array([size]) for name, size in zip(SIZE_FIELDS, sizes, strict=True)}
    design = Designs(**arrays, sense=sense)
    parts, pressure = cut_panels(programme.table, cuts), mechanism.pressure(design, programme)

    def pressure_sign(parts: PanelParts, u: FloatArray) -> FloatArray:
        return np.asarray(np.sign(curve_value(pressure, 0, part_states(programme, parts, u))))

    between = parts.take(pressure_sign(parts, parts.low) * pressure_sign(parts, parts.high) < 0.0)
    low, high, before = between.low, between.high, pressure_sign(between, between.low)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        same = pressure_sign(between, middle) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return cut_panels(programme.table, [*cuts, *zip(between.panel.tolist(), low.tolist(), strict=True)])


@lru_cache(maxsize=64)
def _force_and_acceleration_sign_cuts(programme: Programme, dynamics: FollowerDynamics, omega: float) -> PanelCuts:
    """The changes of sign of F and y'', which do not depend on the design."""
    force = force_polynomials_by_panel(programme, force_factors_with_train(dynamics, omega))[:, 0]
    return *sign_changes(force), *sign_changes(derivative_polynomials_by_panel(programme.table, 2))


def guided_torque_polynomials(setup: Setup, design: Designs, programme: Programme) -> tuple[FloatArray, FloatArray]:
    """T of one design: half-widths of parts [rad] (n,), and polynomials on them (powers, n) [N·mm]."""
    table, (nodes, to_powers) = programme.table, chebyshev_nodes_and_powers_matrix(GUIDED_DEGREE)
    parts = panel_parts_with_smooth_torque(setup, design, programme)
    kinds = np.repeat(table.kind, np.diff(table.first_panel))[parts.panel]
    values = np.zeros((nodes.size, parts.panel.size))
    for way, way_kinds in friction_signs_by_stroke_kind(setup):
        here = (kinds & way_kinds) != 0
        way_parts = parts.take(here)
        states = part_states(programme, way_parts, way_parts.panel_places_of_part_places(nodes[:, None]))
        values[:, here] = curve_value(torque_curve(setup, design, programme, way), 0, states)
    return 0.5 * table.half_width[parts.panel] * (parts.high - parts.low), matrix_product(to_powers, values)
