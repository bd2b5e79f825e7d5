"""Loads on the follower that change over the turn: those of a table, and those of a train.

The load of a table is linear between its rows, and periodic.

The load of a train, S and I of ``trains.carried_load``, depends on the cam angle as the motion does, and is
tabulated on the panels of the motion. On each panel the slopes are interpolated at Chebyshev points and integrated
once. The error of the table is its distance from the formulas between these points, plus rounding.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import pi, radians
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import UNIT_ROUNDOFF, FloatArray, IntArray
from camopt.core.numerics.load_tables import ForceTable, LoadTable, TrainLoadTable, tabulated_load
from camopt.core.numerics.panels import TABLE_DEGREE, value_and_three_derivatives
from camopt.core.numerics.piecewise import (
    MotionTable,
    derivative_ranges_and_errors,
    node_displacements_and_derivatives,
)
from camopt.core.numerics.quadrature import chebyshev_nodes_and_matrix, chebyshev_nodes_and_powers_matrix
from camopt.core.numerics.stable_functions import matrix_product
from camopt.core.numerics.state import Load, TrainForces
from camopt.core.numerics.taylor import Series, Taylor
from camopt.model.motion.stroke import motion_directions
from camopt.model.trains.carried_load import FollowerLoad, sum_follower_load
from camopt.model.trains.joint_forces import WeightedForce
from camopt.model.trains.train import Train

LOAD_NODES, LOAD_TO_POWERS = chebyshev_nodes_and_powers_matrix(TABLE_DEGREE - 1)
LOAD_FIT_NODES = np.array([0.0, *LOAD_NODES])
LOAD_CHECK_NODES, _ = chebyshev_nodes_and_matrix(TABLE_DEGREE + 3)
BETWEEN_NODES_FACTOR = 2.0  # the error between checked places may be larger than at them by this factor
ERROR_MAGNIFIER = 2.0**20  # factor on the errors of the motion, so that their effect on the load exceeds rounding
LOAD_ROUNDING = 64.0  # error of the formulas, in roundings of the largest value in the turn


@dataclass(frozen=True)
class ExternalLoad:
    """A table of cam angles and loads over a turn, periodic and linear between its rows.

    ``rows`` are as the scene gives them: angles in deg from 0 to 360 in order, two rows at the angle of a jump. One
    unit of their loads is ``unit`` N (N·mm).
    """

    rows: tuple[tuple[float, float], ...]
    unit: float

    @cached_property
    def angles(self) -> tuple[float, ...]:
        """Cam angles of the rows [rad]."""
        return tuple(radians(angle) for angle, _ in self.rows)

    @cached_property
    def loads(self) -> tuple[float, ...]:
        """Loads of the rows [N or N·mm]."""
        return tuple(load * self.unit for _, load in self.rows)

    @property
    def largest_load_magnitude(self) -> float:
        """Largest magnitude of the load [N or N·mm]."""
        return max(map(abs, self.loads))

    @cached_property
    def _rows_with_those_of_adjacent_turns(self) -> tuple[FloatArray, FloatArray]:
        """The rows with the last one of the turn before and the first one of the next."""
        angles = (self.angles[-1] - 2 * pi, *self.angles, self.angles[0] + 2 * pi)
        return np.array(angles), np.array((self.loads[-1], *self.loads, self.loads[0]))

    def load_and_slope(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The load and its slope by the cam angle; at a jump the values to its right."""
        corners, loads = self._rows_with_those_of_adjacent_turns
        left = np.clip(np.searchsorted(corners, angles, side="right") - 1, 0, len(corners) - 2)
        slope = (loads[left + 1] - loads[left]) / (corners[left + 1] - corners[left])
        return loads[left] + slope * (angles - corners[left]), slope

    def load_state(self, angles: FloatArray, motion: FloatArray, velocity_sign: FloatArray) -> Load:
        """The load as curves take it; it does not depend on the motion."""
        return Load(*self.load_and_slope(angles))

    def panel_table(self, table: MotionTable, stroke_numbers: IntArray) -> LoadTable:
        """The load on the panels of a turn; panels end at its corners."""
        centre, slope = self.load_and_slope(table.centre)
        return tabulated_load(
            centre, slope, self.largest_load_magnitude, table.half_width, table.first_panel, table.group
        )


class ReflectedLoad(NamedTuple):
    """The load of a train of constant ratio at its follower: a spring, a mass and a force."""

    stiffness: float
    mass: float
    highest: float
    """Largest force of the turn at the lowest position; friction as in an outward motion."""


@dataclass(frozen=True)
class TrainLoad:
    """The load of a train on its follower, or a force in its joints: F = S + ω²·I [N or N·mm]."""

    train: Train
    loads: tuple[tuple[int, ExternalLoad], ...] = ()
    """Loads that change over the turn, by joint; joint 0 is the follower."""
    zero: float = 0.0
    """Lowest position of the follower in the turn, from the start position of the train [mm or rad]."""
    parts: tuple[WeightedForce, ...] = ()
    """The joint forces of which it is the sum; empty for the load on the follower."""

    @property
    def angles(self) -> tuple[float, ...]:
        """Cam angles where loads have corners [rad]."""
        return tuple(angle for _, load in self.loads for angle in load.angles)

    @property
    def reflected_load(self) -> ReflectedLoad:
        """The load on the follower of a train whose ratios are constant."""
        ratios = [float(joint.ratio.terms[0]) for joint in self.train.joint_motions(Taylor([0.0, 1.0]))]
        carried = [(part, ratios[part.joint]) for part in self.train.carried]
        stiffness = sum(part.stiffness * ratio**2 for part, ratio in carried)
        mass = sum(part.mass * ratio**2 for part, ratio in carried)
        force = sum(part.force * ratio + part.friction * abs(ratio) for part, ratio in carried)
        external = sum(max(ratios[joint] * row for row in load.loads) for joint, load in self.loads)
        return ReflectedLoad(stiffness, mass, force + external + stiffness * self.zero)

    def follower_load(
        self, train: Train, follower: Series, velocity_sign: Any, loads: Mapping[int, Series]
    ) -> FollowerLoad:
        """S and I, in the kind of number of ``train``.

        ``velocity_sign`` is the sign of the follower's velocity: 1, −1, or 0 at rest.
        """
        ways = [velocity_sign * sense for sense in self.train.joint_motion_signs]
        if self.parts:
            return train.sum_joint_forces(self.parts, follower, ways, loads)
        return sum_follower_load(train.joint_motions(follower), train.carried, ways, loads)

    def load_state(self, angles: FloatArray, motion: FloatArray, velocity_sign: FloatArray) -> TrainForces:
        """The load as curves take it, from a motion (4, …) at cam angles and the sign of its velocity."""
        y, y1, y2, y3 = motion
        loads = {joint: Taylor([*load.load_and_slope(angles), 0.0, 0.0]) for joint, load in self.loads}
        follower = Taylor([y + self.zero, y1, y2 / 2.0, y3 / 6.0])
        still, carried = self.follower_load(self.train, follower, velocity_sign, loads)
        return TrainForces(*(np.broadcast_to(row, y.shape) for row in (*still.terms[:2], *carried.terms[:2])))

    def panel_table(self, table: MotionTable, stroke_numbers: IntArray) -> TrainLoadTable:
        """The load on the panels of a turn, which end at its corners.

        ``stroke_numbers`` has the stroke number of each panel.
        """
        fitted = self._load_at_panel_places(table, LOAD_FIT_NODES)
        errors = ERROR_MAGNIFIER * table.error[: len(table.centre), :4].T
        shifts = np.eye(len(errors), len(errors) + 1, 1)[..., None] * errors[:, None]
        checked, *shifted = np.moveaxis(self._load_at_panel_places(table, LOAD_CHECK_NODES, shifts), 1, 0)
        effects = np.sum([np.abs(forces - checked).max(axis=2) for forces in shifted], axis=0) / ERROR_MAGNIFIER
        tables = []
        for k in (0, 2):
            series = polynomial.polyint(matrix_product(fitted[k + 1][:, 1:], LOAD_TO_POWERS.T).T) * table.half_width
            series[0] = fitted[k][:, 0]
            tables.append(_force_table(table, stroke_numbers, series.T, checked[k : k + 2], effects[k : k + 2]))
        return TrainLoadTable(*tables)

    def _load_at_panel_places(
        self, table: MotionTable, panel_places: FloatArray, shifts: FloatArray | None = None
    ) -> FloatArray:
        """The load at places u of all panels, (4, panels, places).

        With ``shifts`` (4, motions, panels) it is the load of shifted motions, (4, motions, panels, places).
        """
        panels = np.arange(len(table.centre))[:, None]
        angles = table.centre[:, None] + table.half_width[:, None] * panel_places
        motion = np.array(value_and_three_derivatives(table, panels, panel_places))
        if shifts is not None:
            motion = motion[:, None] + shifts[..., None]
        kinds = np.repeat(table.kind, np.diff(table.first_panel))
        return np.array(
            self.load_state(angles, motion, np.broadcast_to(motion_directions(kinds)[:, None], angles.shape))
        )


def _force_table(
    table: MotionTable,
    stroke_numbers: IntArray,
    coefficients: FloatArray,
    exact_values_and_slopes: FloatArray,
    motion_error_effects: FloatArray,
) -> ForceTable:
    """The table of a force from its coefficients in powers of u, with its errors.

    ``checked`` are the exact value and slope (2, …) at ``LOAD_CHECK_NODES``; ``effects`` are their errors caused by
    those of the motion.
    """
    rows = derivative_ranges_and_errors(coefficients, table.half_width, stroke_numbers, table.group)
    force = ForceTable(coefficients, table.half_width, np.empty(0), *rows)
    panels = np.arange(len(coefficients))
    tabulated = np.array(value_and_three_derivatives(force, panels[:, None], LOAD_CHECK_NODES)[:2])
    error = motion_error_effects + BETWEEN_NODES_FACTOR * np.abs(tabulated - exact_values_and_slopes).max(axis=2)
    error += LOAD_ROUNDING * UNIT_ROUNDOFF * np.abs(exact_values_and_slopes).max(axis=(1, 2))[:, None]
    force.error[panels, :2] += error.T
    starts = np.flatnonzero(np.diff(table.group, prepend=-1))
    force.error[len(panels) :] = np.maximum.reduceat(force.error[panels], starts)
    return force._replace(nodes=node_displacements_and_derivatives(force, table.first_panel))
