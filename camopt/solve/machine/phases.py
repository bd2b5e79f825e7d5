"""Phases with the least peak torque on the shaft, all clearances held, and a proved lower bound of that peak.

A branch and bound over boxes of phases. At one angle of the shaft the torque of each station has a range over a
box. So the sum has one, and the peak is nowhere in the box below its least magnitude. The largest such bound at
some angles is that of the box. A box in which a clearance is broken at some angle, whatever the phases, is dropped.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, radians

import numpy as np
import scipy

from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.budget import Budget
from camopt.core.numerics.turn_curve import TURN, TurnCurve, sum_curves
from camopt.scene.machine import Machine
from camopt.solve.machine.clearances import ClearanceForm, clearance_form, required_clearance
from camopt.solve.machine.outlines import TINY
from camopt.solve.machine.stations import ResolvedStation
from camopt.solve.smallest.nelder_mead import INFEASIBLE_COST, descend_simplex

GRID = np.arange(360) * (TURN / 360)
"""Angles at which a torque is looked at for its peaks [rad]."""
MOST_PEAKS = 8  # peaks of a torque at which a box is bounded
CLEARANCE_ANGLES = 49  # angles at which a clearance is looked at
STARTS, DESCENTS = 512, 4  # phases that are spread evenly, and the best of them, which are improved
BATCH = 64  # boxes that are bounded at once
LEAST_GAIN = 1e-9  # relative gain of the peak for which its exact value is computed
PEAK_GAP = 1e-3  # relative gap at which the least peak is enclosed closely enough
PHASE_WORK, CLEARANCE_WORK = 3_000_000, 100_000
DESCENT_END, DESCENT_MOVES = (1e-7, 1e-9), 60  # shares of the ranges and N·m; evaluations for each phase


@dataclass(frozen=True)
class PhaseOptimum:
    """Phases with the least peak torque that was found, and what it cannot be below."""

    phases: Mapping[str, float] | None
    """Phases of the stations of the search [deg]; None if no phases that hold the clearances were found."""
    peak_before: float
    """Largest magnitude of the torque with the phases of the machine [N·m]."""
    peak: float
    """Largest magnitude of the torque with the found phases [N·m]; infinite without any."""
    bound: float
    """A proved lower bound of the peak for all phases in their ranges that hold the clearances [N·m].

    It is infinite if no such phases exist.
    """

    @property
    def relative_gap(self) -> float:
        """Share of the peak by which other phases may at most be better."""
        return 1.0 - self.bound / self.peak if 0.0 < self.peak < inf else 0.0


@dataclass(frozen=True, eq=False)
class TorqueSum:
    """The torque on the shaft as a function of its angle and of some phases [rad]."""

    still: TurnCurve
    """The sum for the stations whose phases stay."""
    moving: tuple[TurnCurve, ...]
    """The torques of the others at the phase 0."""

    @cached_property
    def still_on_grid(self) -> FloatArray:
        """The torque of the stations that stay, at the angles of the grid."""
        return self.still.value(GRID)

    def on_grid(self, phases: FloatArray) -> FloatArray:
        """Torques at the angles of the grid for several phases (N, phases)."""
        return self.still_on_grid + sum(
            curve.value(GRID - phase[:, None]) for curve, phase in zip(self.moving, phases.T, strict=True)
        )

    def peak_angles(self, phases: FloatArray) -> FloatArray:
        """Angles near the largest magnitudes of the torque for several phases (N, peaks).

        Each is the top of a parabola through three angles of the grid.
        """
        size = np.abs(self.on_grid(phases))
        before, after = np.roll(size, 1, axis=1), np.roll(size, -1, axis=1)
        tops = np.where((size >= before) & (size >= after), size, -1.0)
        places = np.argpartition(-tops, MOST_PEAKS, axis=1)[:, :MOST_PEAKS]
        here, left, right = (np.take_along_axis(each, places, axis=1) for each in (size, before, after))
        bend = np.maximum(2.0 * here - left - right, TINY)
        return GRID[places] + np.clip(0.5 * (right - left) / bend, -0.5, 0.5) * (TURN / len(GRID))

    def peak_estimate(self, phases: FloatArray) -> float:
        """The peak for some phases, within a small share below it."""
        angles = self.peak_angles(phases[None, :])[0]
        torque = self.still.value(angles)
        for curve, phase in zip(self.moving, phases, strict=True):
            torque = torque + curve.value(angles - phase)
        return float(np.abs(torque).max())

    def peak(self, phases: FloatArray) -> float:
        """An upper bound of the peak for some phases, exact to rounding."""
        turned = [curve.shifted(float(phase)) for curve, phase in zip(self.moving, phases, strict=True)]
        total = sum_curves([self.still, *turned])
        most, least = total.largest(), total.least()
        return max(most.value + most.room, least.room - least.value)

    def bounds(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lower bounds of the peak over boxes of phases (N, phases), and what each phase adds to their room."""
        angles = self.peak_angles(0.5 * (low + high))
        still = self.still.range_over(angles, angles)
        least, most, widths = still.low, still.high, []
        for curve, first, last in zip(self.moving, low.T, high.T, strict=True):
            torques = curve.range_over(angles - last[:, None], angles - first[:, None])
            least, most = least + torques.low, most + torques.high
            widths.append(torques.high - torques.low)
        magnitudes = np.maximum(np.maximum(least, -most), 0.0)
        best = np.argmax(magnitudes, axis=1)[:, None]
        rooms = [np.take_along_axis(width, best, axis=1)[:, 0] for width in widths]
        return np.take_along_axis(magnitudes, best, axis=1)[:, 0], np.array(rooms).T


@dataclass(frozen=True, eq=False)
class PhaseClearance:
    """A clearance as a function of the phases of a search."""

    form: ClearanceForm
    required: float
    start: float
    width: float
    variables: IntArray
    """The phase of the search that each part of the clearance has; −1 for a part that stays."""
    origins: FloatArray
    """The phase of each part in the machine [rad]."""

    def shifts(self, phases: FloatArray) -> FloatArray:
        """Shifts of the parts (parts, N) for several phases (N, phases)."""
        moving = self.variables >= 0
        return np.where(moving, phases[:, self.variables] - self.origins, 0.0).T

    def is_held(self, phases: FloatArray) -> bool:
        """Whether the clearance is proved to be held for some phases."""
        if not self.may_be_held(phases[None, :], phases[None, :])[0]:
            return False
        shifts = self.shifts(phases[None, :])[:, 0].tolist()
        curves = tuple(curve.shifted(shift) for curve, shift in zip(self.form.curves, shifts, strict=True))
        least = replace(self.form, curves=curves).least(self.start, self.width, Budget(CLEARANCE_WORK))
        return least.lower >= self.required

    def may_be_held(self, low: FloatArray, high: FloatArray) -> BoolArray:
        """Whether some phases of each box (N, phases) may hold the clearance; if not, none does."""
        angles = self.start + self.width * np.linspace(0.0, 1.0, CLEARANCE_ANGLES)
        shifts = [np.repeat(self.shifts(each), len(angles), axis=1) for each in (low, high)]
        highest = self.form.highest(np.tile(angles, len(low)), *shifts)
        return np.asarray((highest.reshape(-1, CLEARANCE_ANGLES) >= self.required).all(axis=1))


@dataclass(eq=False)
class PhaseBranchAndBound:
    """The search for the phases of least peak torque between ``low`` and ``high`` [rad]."""

    torque: TorqueSum
    clearances: Sequence[PhaseClearance]
    low: FloatArray
    high: FloatArray
    budget: Budget = field(default_factory=lambda: Budget(PHASE_WORK))
    best: FloatArray | None = None
    peak: float = inf
    estimate: float = inf
    """The estimate of the best peak."""

    def try_phases(self, phases: FloatArray) -> float:
        """The peak for some phases; they are kept if they are the best so far and hold all clearances."""
        self.budget.spend(len(GRID) * len(phases))
        estimate = self.torque.peak_estimate(phases)
        if estimate >= self.estimate * (1.0 - LEAST_GAIN):
            return estimate
        self.budget.spend(100 * CLEARANCE_ANGLES * len(self.clearances))
        if not all(clearance.is_held(phases) for clearance in self.clearances):
            return INFEASIBLE_COST
        peak = self.torque.peak(phases)
        if peak < self.peak:
            self.best, self.peak, self.estimate = phases, peak, estimate
        return peak

    def descend_from(self, phases: FloatArray) -> None:
        """Improve phases by the simplex method."""
        scale = self.high - self.low
        start = (phases - self.low) / scale
        descend_simplex(
            lambda shares: self.try_phases(self.low + np.clip(shares, 0.0, 1.0) * scale),
            start,
            np.where(start > 0.5, -0.1, 0.1),
            DESCENT_END,
            DESCENT_MOVES,
            self.budget.share(8),
            (0.0, 1.0),
        )

    @cached_property
    def is_in_clearances(self) -> BoolArray:
        """Whether each phase is in some clearance."""
        return np.array([any(row in each.variables for each in self.clearances) for row in range(len(self.low))])

    def descend_from_spread_phases(self) -> None:
        """Improve the best of many phases that are spread evenly."""
        shares = scipy.stats.qmc.Halton(len(self.low), scramble=False).random(STARTS)
        phases = self.low + shares * (self.high - self.low)
        for clearance in self.clearances:
            self.budget.spend(len(phases) * CLEARANCE_ANGLES)
            phases = phases[clearance.may_be_held(phases, phases)]
        self.budget.spend(phases.size * len(GRID))
        peaks = np.abs(self.torque.on_grid(phases)).max(axis=1)
        for start in phases[np.argsort(peaks)[:DESCENTS]]:
            self.descend_from(start)

    def search(self) -> float:
        """Improve the best phases; return a proved lower bound of the least peak."""
        low, high, bounds, floor = self.low[None, :], self.high[None, :], np.zeros(1), inf
        while bounds.size and not self.budget.is_spent:
            order = np.argsort(bounds, kind="stable")
            now, later = order[:BATCH], order[BATCH:]
            box_low, box_high = low[now], high[now]
            self.budget.spend(len(now) * len(self.low) * (len(GRID) + 4 * MOST_PEAKS))
            found, rooms = self.torque.bounds(box_low, box_high)
            found = np.maximum(found, bounds[now])
            middles = 0.5 * (box_low + box_high)
            for place in np.argsort(found)[:1]:
                before = self.peak
                if self.try_phases(middles[place]) < before:
                    self.descend_from(middles[place])
            is_open = found < self.peak * (1.0 - PEAK_GAP)
            floor = min(floor, found[~is_open].min(initial=inf))
            for clearance in self.clearances:
                self.budget.spend(int(is_open.sum()) * CLEARANCE_ANGLES)
                is_open[is_open] = clearance.may_be_held(box_low[is_open], box_high[is_open])
            box_low, box_high, rooms = box_low[is_open], box_high[is_open], rooms[is_open]
            rows = np.arange(len(box_low))
            shares = (box_high - box_low) / np.maximum(self.high - self.low, TINY) * self.is_in_clearances
            widest = np.argmax(rooms / np.maximum(rooms.max(axis=1, keepdims=True), TINY) + shares, axis=1)
            upper, lower = box_high.copy(), box_low.copy()
            upper[rows, widest] = lower[rows, widest] = middles[is_open][rows, widest]
            low = np.concatenate([low[later], box_low, lower])
            high = np.concatenate([high[later], upper, box_high])
            bounds = np.concatenate([bounds[later], np.tile(found[is_open], 2)])
        return float(min(floor, bounds.min(initial=inf), self.peak))


def least_torque_phases(machine: Machine, stations: Sequence[ResolvedStation]) -> PhaseOptimum | None:
    """The phases of ``search.phase`` with the least peak torque on the shaft.

    They hold every clearance that depends on them. None if the machine has no such search, or no torque.
    """
    torques = {station.name: station.torque_at_phase(0.0) for station in stations}
    names = [station.name for station in stations if station.name in machine.search.phase]
    if not names or not any(torques.values()):
        return None
    origins = {station.name: radians(station.station.phase) for station in stations}
    moving = tuple(torques[name] or TurnCurve.constant(0.0) for name in names)
    still = [station.torque for station in stations if station.name not in names and station.torque is not None]
    torque = TorqueSum(sum_curves(still), moving)
    clearances = []
    for clearance in machine.clear:
        if any(name in names for name in clearance.between):
            variables = np.array([names.index(name) if name in names else -1 for name in clearance.between])
            start, width = radians(clearance.angles[0]), radians(clearance.angles[1] - clearance.angles[0])
            clearances.append(
                PhaseClearance(
                    clearance_form(machine, stations, clearance),
                    required_clearance(clearance),
                    start,
                    width,
                    variables,
                    np.array([origins.get(name, 0.0) for name in clearance.between]),
                )
            )
    low, high = np.radians([machine.search.phase[name] for name in names]).T
    search = PhaseBranchAndBound(torque, clearances, low, high)
    before = np.array([origins[name] for name in names])
    if ((low <= before) & (before <= high)).all():
        search.try_phases(before)
    search.descend_from_spread_phases()
    bound = search.search()
    phases = None if search.best is None else dict(zip(names, np.degrees(search.best).tolist(), strict=True))
    return PhaseOptimum(phases, torque.peak(before), search.peak, bound)
