"""Loads on the follower that change over the turn: of a table, and what a train brings to its follower.

A table's load is straight between its rows, and periodic.

A train brings the loads and the inertia of what it carries, tabulated. S and I of ``trains.carried_load`` are
functions of the cam angle, as the motion is. On each panel their slopes, which the series of the motion give, are
interpolated at Chebyshev points and integrated once; how far that is from the formulas in between, and rounding, is
the error of the table.
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
from camopt.core.numerics.panels import TABLE_DEGREE, derivatives
from camopt.core.numerics.piecewise import MotionTable, panel_end_values, table_ranges
from camopt.core.numerics.quadrature import chebyshev_projection, chebyshev_series
from camopt.core.numerics.stable_functions import matrix_product
from camopt.core.numerics.state import Load, TrainForces
from camopt.core.numerics.taylor import Series, Taylor
from camopt.model.motion.stroke import motion_ways
from camopt.model.trains.carried_load import FollowerLoad
from camopt.model.trains.joint_forces import WeightedForce
from camopt.model.trains.train import Train

LOAD_NODES, LOAD_TO_POWERS = chebyshev_projection(TABLE_DEGREE - 1)
LOAD_FIT_NODES = np.array([0.0, *LOAD_NODES])
LOAD_CHECK_NODES, _ = chebyshev_series(TABLE_DEGREE + 3)
BETWEEN_NODES_FACTOR = 2.0  # how much larger the error between the places looked at may be than at them
ERROR_MAGNIFIER = 2.0**20  # times the errors of the motion: what these make of the load is beyond rounding
LOAD_ROUNDING = 64.0  # errors of the formulas, in roundings of the largest value in the turn


@dataclass(frozen=True)
class ExternalLoad:
    """Rows (cam angle, load) as given: deg from 0 to 360 in order, two at the same angle where the load jumps.

    ``unit`` is that of a load in N (N·mm). From the last row the load goes straight to the first of the next turn.
    """

    rows: tuple[tuple[float, float], ...]
    unit: float

    @cached_property
    def angles(self) -> tuple[float, ...]:
        """The cam angles of the rows, rad."""
        return tuple(radians(angle) for angle, _ in self.rows)

    @cached_property
    def loads(self) -> tuple[float, ...]:
        """The loads of the rows, N (N·mm)."""
        return tuple(load * self.unit for _, load in self.rows)

    @property
    def largest(self) -> float:
        """The largest magnitude."""
        return max(map(abs, self.loads))

    @property
    def highest(self) -> float:
        """The largest load, with its sign."""
        return max(self.loads)

    @cached_property
    def _wrapped_rows(self) -> tuple[FloatArray, FloatArray]:
        """The rows with the last one of the turn before, and the first of the next."""
        angles = (self.angles[-1] - 2 * pi, *self.angles, self.angles[0] + 2 * pi)
        return np.array(angles), np.array((self.loads[-1], *self.loads, self.loads[0]))

    def load_and_slope(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The load and its slope by the cam angle, from the right where they jump."""
        corners, loads = self._wrapped_rows
        left = np.clip(np.searchsorted(corners, angles, side="right") - 1, 0, len(corners) - 2)
        slope = (loads[left + 1] - loads[left]) / (corners[left + 1] - corners[left])
        return loads[left] + slope * (angles - corners[left]), slope

    def state(self, angles: FloatArray, motion: FloatArray, way: FloatArray) -> Load:
        """The load as curves take it, whatever the motion."""
        return Load(*self.load_and_slope(angles))

    def panel_table(self, table: MotionTable, strokes: IntArray) -> LoadTable:
        """The load on the panels of a turn, which are cut where it has corners."""
        centre, slope = self.load_and_slope(table.centre)
        return tabulated_load(centre, slope, self.largest, table.half_width, table.first_panel, table.group)


class ReflectedLoad(NamedTuple):
    """What comes to a follower at a constant ratio, from where it is lowest: a spring, a mass and a force."""

    stiffness: float
    mass: float
    highest: float
    """Of what does not change with its motion, the most of the turn; friction where it moves out."""


@dataclass(frozen=True)
class TrainLoad:
    """What comes to a follower through a train, or to joints of it, N (N·mm): F = S + ω²·I."""

    train: Train
    loads: tuple[tuple[int, ExternalLoad], ...] = ()
    """Loads that change over the turn, by joint; 0 is the follower."""
    zero: float = 0.0
    """Where the follower is lowest in the turn, from the start position of the train, mm (rad)."""
    parts: tuple[WeightedForce, ...] = ()
    """The forces in joints of which it is the sum; none for the force at the follower."""

    @property
    def angles(self) -> tuple[float, ...]:
        """The cam angles where loads have corners, rad."""
        return tuple(angle for _, load in self.loads for angle in load.angles)

    @property
    def reflected_load(self) -> ReflectedLoad:
        """What comes through a train whose ratios are the same everywhere."""
        ratios = [float(joint.ratio.terms[0]) for joint in self.train.joints(Taylor([0.0, 1.0]))]
        squares = [(each, ratios[each.joint] ** 2) for each in self.train.carried]
        stiffness = sum(each.stiffness * square for each, square in squares)
        mass = sum(each.mass * square for each, square in squares)
        force = sum(
            each.force * ratios[each.joint] + each.friction * abs(ratios[each.joint]) for each in self.train.carried
        )
        changing = sum(max(ratios[joint] * end for end in load.loads) for joint, load in self.loads)
        return ReflectedLoad(stiffness, mass, force + changing + stiffness * self.zero)

    def follower_load(self, train: Train, follower: Series, way: Any, loads: Mapping[int, Series]) -> FollowerLoad:
        """S and I, of its train in some kind of number, if the follower moves one way: 1, −1, or 0 at rest."""
        ways = [way * sense for sense in self.train.senses]
        if self.parts:
            return train.force_in(self.parts, follower, ways, loads)
        return train.load_at_follower(follower, ways, loads)

    def state(self, angles: FloatArray, motion: FloatArray, way: FloatArray) -> TrainForces:
        """As curves take it: of a motion (4, …) at cam angles, which goes out (1), in (−1) or rests (0)."""
        y, y1, y2, y3 = motion
        loads = {joint: Taylor([*load.load_and_slope(angles), 0.0, 0.0]) for joint, load in self.loads}
        follower = Taylor([y + self.zero, y1, y2 / 2.0, y3 / 6.0])
        still, carried = self.follower_load(self.train, follower, way, loads)
        rows = (*still.terms[:2], *carried.terms[:2])
        return TrainForces(*(np.broadcast_to(row, y.shape) for row in rows))

    def panel_table(self, table: MotionTable, strokes: IntArray) -> TrainLoadTable:
        """The load on the panels of a turn, which are cut where it has corners; ``strokes`` numbers theirs."""
        made = self._panel_forces(table, LOAD_FIT_NODES)
        errors = ERROR_MAGNIFIER * table.error[: len(table.centre), :4].T
        apart = np.eye(len(errors), len(errors) + 1, 1)[..., None] * errors[:, None]
        seen, *moved = np.moveaxis(self._panel_forces(table, LOAD_CHECK_NODES, apart), 1, 0)
        brought = np.sum([np.abs(each - seen).max(axis=2) for each in moved], axis=0) / ERROR_MAGNIFIER
        forces = []
        for k in (0, 2):
            series = polynomial.polyint(matrix_product(made[k + 1][:, 1:], LOAD_TO_POWERS.T).T) * table.half_width
            series[0] = made[k][:, 0]
            forces.append(_force_table(table, strokes, series.T, seen[k : k + 2], brought[k : k + 2]))
        return TrainLoadTable(*forces)

    def _panel_forces(self, table: MotionTable, u: FloatArray, apart: FloatArray | None = None) -> FloatArray:
        """The load at places u of all panels, (4, panels, places).

        Or (4, motions, panels, places), of motions that are apart from the table's by (4, motions, panels).
        """
        panels = np.arange(len(table.centre))[:, None]
        angles = table.centre[:, None] + table.half_width[:, None] * u
        motion = np.array(derivatives(table, panels, u))
        if apart is not None:
            motion = motion[:, None] + apart[..., None]
        kinds = np.repeat(table.kind, np.diff(table.first_panel))
        return np.array(self.state(angles, motion, np.broadcast_to(motion_ways(kinds)[:, None], angles.shape)))


def _force_table(
    table: MotionTable, strokes: IntArray, coefficients: FloatArray, seen: FloatArray, brought: FloatArray
) -> ForceTable:
    """A force in powers of u, with its errors: from what value and slope (2, …) are at places of the panels.

    ``brought`` is what errors of the motion bring to them.
    """
    rows = table_ranges(coefficients, table.half_width, strokes, table.group)
    force = ForceTable(coefficients, table.half_width, np.empty(0), *rows)
    panels = np.arange(len(coefficients))
    found = np.array(derivatives(force, panels[:, None], LOAD_CHECK_NODES)[:2])
    off = brought + BETWEEN_NODES_FACTOR * np.abs(found - seen).max(axis=2)
    off += LOAD_ROUNDING * UNIT_ROUNDOFF * np.abs(seen).max(axis=(1, 2))[:, None]
    force.error[panels, :2] += off.T
    starts = np.flatnonzero(np.diff(table.group, prepend=-1))
    force.error[len(panels) :] = np.maximum.reduceat(force.error[panels], starts)
    return force._replace(nodes=panel_end_values(force, table.first_panel))
