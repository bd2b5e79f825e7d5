"""Phases with the least peak torque on the shaft, all clearances held, and a proved lower bound of that peak.

A branch and bound over boxes of phases. At one angle of the shaft the torque of each station has a range over a
box. So the sum has one, and the peak is nowhere in the box below its least magnitude. The largest such bound at
some angles is that of the box. A box in which a clearance is broken at some angle, whatever the phases, is dropped.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, radians
from typing import Any, NamedTuple

import numpy as np
import scipy

from camopt.core.mistakes import NOTHING_FEASIBLE, BadInput, Mistake
from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.budget import Budget
from camopt.core.numerics.turn_curve import EQUAL_ENDS, TURN, TurnCurve, sum_curves
from camopt.scene.machine import Machine, MachineSource, machine_from
from camopt.solve.machine.clearances import ClearanceForm, clearance_form, jumps_at_panel_ends
from camopt.solve.machine.evaluation import MachineEvaluation, evaluate_machine
from camopt.solve.machine.outlines import TINY
from camopt.solve.machine.stations import ResolvedStation, resolve_stations
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.result import Result, Table, table_of

GRID: FloatArray = np.arange(360.0) * (TURN / 360.0)
"""Angles at which a torque is looked at for its peaks [rad]."""
MOST_PEAKS = 10  # angles at which the torque of a box is bounded
LEAST_JUMP, BESIDE_JUMP = 1e-6, 1e-9  # a jump relative to the largest torque, and angles beside it [rad]
CLEARANCE_ANGLES = 49  # angles at which a clearance is looked at
STEPS = 12  # steps from phases that are better than all before
BATCH, TRIED = 64, 16  # boxes that are bounded at once, and those in which phases are tried
LEAST_GAIN = 1e-5  # relative gain of the peak for which its exact value is computed
MEAN_ROUNDING = 1e-13  # rounding of a mean of torques, relative to the largest
PEAK_GAP = 1e-4  # relative gap at which the least peak is enclosed closely enough
PHASE_WORK, BOX_WORK, EXACT_WORK = 3_000_000, 150, 4_000  # of a search, of a phase of a box, of an exact peak
PHASE_DECIMALS = 9  # of phases in deg
CLEARANCE_WORK = 100_000  # of a least clearance for some phases


@dataclass(frozen=True)
class PhaseOptimum(Result):
    """Phases with the least peak torque that was found, and what it cannot be below.

    Attributes
    ----------
    machine : Machine
        The machine of the search.
    phases : Mapping or None
        Phases of the stations of the search by name [deg]; None if no phases that hold the clearances were found.
    peak_before : float
        Largest magnitude of the torque with the phases of the machine [N·m].
    peak : float
        Largest magnitude of the torque with the found phases [N·m]; infinite without any.
    bound : float
        A proved lower bound of the peak for all phases in their ranges that hold the clearances [N·m]. It is
        infinite if no such phases exist.

    Examples
    --------
    >>> found = camopt.optimise_phases("packer")
    >>> round(found.peak_before, 2), round(found.peak, 2), found.relative_gap < 1e-4
    (11.76, 9.67, True)
    """

    machine: Machine
    phases: Mapping[str, float] | None
    peak_before: float
    peak: float
    bound: float

    @property
    def best(self) -> Machine | None:
        """The machine with the found phases; None without any."""
        return None if self.phases is None else self.machine.with_phases(self.phases)

    @cached_property
    def evaluation(self) -> MachineEvaluation | None:
        """The evaluation of the machine with the found phases; None without any."""
        return None if self.best is None else evaluate_machine(self.best)

    @property
    def exit_code(self) -> int:
        """0, or 1 if no phases hold the clearances."""
        return NOTHING_FEASIBLE if self.phases is None else 0

    def sections(self) -> Iterator[Table | str]:
        """The answer in a sentence, tables of the phases, and the clearances and the shaft with these phases."""
        if self.phases is None:
            end = "." if self.bound == inf else ", as far as the search went."
            yield f"No phases in their ranges hold every clearance{end}"
            return
        before, after, bound = (with_unit(x, "N·m") for x in (self.peak_before, self.peak, self.bound))
        yield (
            f"The peak torque falls from {before} to {after}. No phases in their ranges that hold the clearances "
            f"have less than {bound}."
        )
        yield self.table()
        assert self.evaluation is not None
        tables = self.evaluation.clearance_table(), self.evaluation.slack_table(), self.evaluation.shaft_table()
        yield from filter(None, tables)

    def table(self) -> Table:
        """A row for each phase of the search: before and after."""
        given = {station.name: station.phase for station in self.machine.station}
        rows = [
            {"station": name, "before_deg": given[name], "after_deg": after}
            for name, after in (self.phases or {}).items()
        ]
        names = ("station", "before_deg", "after_deg")
        return table_of(f"{self.machine.name}: phases", rows, names, units=dict.fromkeys(names[1:], "deg"))

    def values_for_json(self) -> dict[str, Any]:
        """The phases, the peaks and the bound."""
        names = ("phases", "peak_before", "peak", "bound", "relative_gap")
        return {"machine": self.machine.name, **{name: getattr(self, name) for name in names}}

    @property
    def relative_gap(self) -> float:
        """Share of the peak by which other phases may at most be better."""
        return 1.0 - self.bound / self.peak if 0.0 < self.peak < inf else 0.0


class PeakBounds(NamedTuple):
    """Bounds of the peak torque over boxes of phases."""

    lower: FloatArray  # what the peak is nowhere below in the box (N,) [N·m]
    rooms: FloatArray  # what each phase may change where the torque is largest in the middle (N, phases) [N·m]
    promising: FloatArray  # phases in the box where the peak is about least (N, phases) [rad]


@dataclass(frozen=True, eq=False)
class TorqueSum:
    """The torque on the shaft as a function of its angle and of some phases [rad]."""

    still: TurnCurve  # the sum for the stations whose phases stay
    moving: tuple[TurnCurve, ...]  # the torques of the others at the phase 0

    def torques_at_angles(self, angles: FloatArray, phases: FloatArray) -> FloatArray:
        """Torques at angles (N, angles) for several phases (N, phases)."""
        moving = zip(self.moving, phases.T, strict=True)
        return self.still.value(angles) + sum(curve.value(angles - phase[:, None]) for curve, phase in moving)

    def largest_torque_angles_and_sizes(
        self, phases: FloatArray, half_widths: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Angles near the largest magnitudes of the torque for phases (N, phases), and these, the largest first.

        Some angles are the tops of parabolas through three angles of the grid. The others are beside the jumps, so
        that no phase of a box with the half widths ``half_widths`` has a jump there.
        """
        size = np.abs(self.torques_at_angles(GRID[None, :], phases))
        before, after = np.roll(size, 1, axis=1), np.roll(size, -1, axis=1)
        tops = np.where((size >= before) & (size >= after), size, -1.0)
        places = np.argpartition(-tops, MOST_PEAKS, axis=1)[:, :MOST_PEAKS]
        here, left, right = (np.take_along_axis(each, places, axis=1) for each in (size, before, after))
        bend = np.maximum(2.0 * here - left - right, TINY)
        angles = [GRID[places] + np.clip(0.5 * (right - left) / bend, -0.5, 0.5) * GRID[1]]
        starts, widths = (np.pad(each, ((0, 0), (1, 0))) for each in (phases, half_widths + BESIDE_JUMP))
        for jumps, start, width in zip(self.jump_angles, starts.T, widths.T, strict=True):
            angles += [jumps + (start - width)[:, None], jumps + (start + width)[:, None]]
        candidates = np.concatenate(angles, axis=1)
        sizes = np.abs(self.torques_at_angles(candidates, phases))
        largest = np.argsort(-sizes, axis=1)[:, :MOST_PEAKS]
        return np.take_along_axis(candidates, largest, axis=1), np.take_along_axis(sizes, largest, axis=1)

    @cached_property
    def jump_angles(self) -> list[FloatArray]:
        """Angles of the jumps of each curve, the still one first."""
        curves = (self.still, *self.moving)
        least = [LEAST_JUMP * np.abs(curve.series).max() for curve in curves]
        return [
            curve.ends[1:][jumps_at_panel_ends(curve) > size] for curve, size in zip(curves, least, strict=True)
        ]

    def peak_upper_bound(self, phases: FloatArray) -> float:
        """An upper bound of the peak for some phases, exact to rounding."""
        turned = [curve.shifted(float(phase)) for curve, phase in zip(self.moving, phases, strict=True)]
        total = sum_curves([self.still, *turned])
        most, least = total.largest(), total.least()
        return max(most.value + most.room, least.room - least.value)

    def bound_peak_over_phase_boxes(self, low: FloatArray, high: FloatArray) -> PeakBounds:
        """Bounds of the peak over boxes of phases (N, phases).

        The torque of a station at an angle is linear in its phase but for a remainder, which the range of its slope
        and its jumps bound. A mean of the torques at several angles, with weights of any sign, is nowhere above
        the peak. The weights are those of the linear programme for the least peak in the box.
        """
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        angles, _ = self.largest_torque_angles_and_sizes(middle, half)
        still = self.still.range_over(angles, angles)
        value, room = 0.5 * (still.low + still.high), 0.5 * (still.high - still.low)
        slopes, reaches = [], []
        for curve, phase, first, last, width in zip(self.moving, middle.T, low.T, high.T, half.T, strict=True):
            begin, end = angles - last[:, None], angles - first[:, None]
            torque, slope = curve.range_over(begin, end), curve.derivative.range_over(begin, end)
            by_range, centre = 0.5 * (torque.high - torque.low), 0.5 * (torque.low + torque.high)
            by_slope = 0.5 * (slope.high - slope.low) * width[:, None] + curve.error
            by_slope += jump_sums_over_angle_ranges(curve, begin, end)
            is_linear = by_slope < by_range
            value = value + np.where(is_linear, curve.value(angles - phase[:, None]), centre)
            slopes.append(np.where(is_linear, -0.5 * (slope.low + slope.high) * width[:, None], 0.0))
            reaches.append(np.minimum(by_range, by_slope))
        tilts, remainders = np.sign(value) * np.array(slopes), np.array(reaches)
        rounding = MEAN_ROUNDING * (np.abs(value).max() + np.abs(tilts).max())
        least = np.abs(value) - room - remainders.sum(axis=0) - rounding
        weights, steps = minimax_weights_and_steps(least, tilts)
        lower = (weights * least).sum(axis=1) - np.abs((weights * tilts).sum(axis=2)).sum(axis=0)
        return PeakBounds(np.maximum(lower, 0.0), (np.abs(tilts) + remainders)[:, :, 0].T, middle + half * steps)


def jump_sums_over_angle_ranges(curve: TurnCurve, low: FloatArray, high: FloatArray) -> FloatArray:
    """Sums of the sizes of a curve's jumps in ranges of angles [rad]."""
    sums, ends = np.append(0.0, np.cumsum(jumps_at_panel_ends(curve))), curve.ends[1:]
    low, high = low - EQUAL_ENDS, high + EQUAL_ENDS
    before = np.floor(low / TURN) * sums[-1] + sums[np.searchsorted(ends, np.mod(low, TURN), side="left")]
    after = np.floor(high / TURN) * sums[-1] + sums[np.searchsorted(ends, np.mod(high, TURN), side="right")]
    return np.asarray(after - before)


def minimax_weights_and_steps(offsets: FloatArray, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The weights (N, values) and steps (N, phases) of N linear programmes that are solved as one.

    Each minimises the largest of ``offsets`` plus ``slopes`` (phases, N, values) times steps from −1 to 1. Weights
    are those of the dual, not below 0 and with the sum 1.
    """
    (phases, boxes, values), scale = slopes.shape, np.abs(offsets).max() + np.abs(slopes).max() + TINY
    rows, first = np.arange(boxes * values), np.repeat(np.arange(boxes), values) * (phases + 1)
    columns = first[:, None] + np.arange(phases + 1)
    entries = np.concatenate([slopes.reshape(phases, -1).T / scale, np.full((len(rows), 1), -1.0)], axis=1)
    matrix = scipy.sparse.csr_array((entries.ravel(), (np.repeat(rows, phases + 1), columns.ravel())))
    cost = np.tile(np.append(np.zeros(phases), 1.0), boxes)
    ranges = np.tile(np.append(np.tile([[-1.0, 1.0]], (phases, 1)), [[-inf, inf]], axis=0), (boxes, 1))
    found = scipy.optimize.linprog(cost, matrix, -offsets.ravel() / scale, bounds=ranges, method="highs")
    if found.status != 0:  # the best weights of one angle
        single = np.argmax(offsets - np.abs(slopes).sum(axis=0), axis=1)
        return np.eye(values)[single], np.zeros((boxes, phases))
    weights = np.maximum(-found.ineqlin.marginals.reshape(boxes, values), 0.0)
    return weights / weights.sum(axis=1, keepdims=True), found.x.reshape(boxes, -1)[:, :phases]


@dataclass(frozen=True, eq=False)
class PhaseClearance:
    """A clearance as a function of the phases of a search."""

    form: ClearanceForm
    variables: IntArray  # the phase of the search that each part of the clearance has; −1 for a part that stays
    origins: FloatArray  # the phase of each part in the machine [rad]

    def part_shifts_at_phases(self, phases: FloatArray) -> FloatArray:
        """Shifts of the parts (parts, N) for several phases (N, phases)."""
        return np.where(self.variables >= 0, phases[:, self.variables] - self.origins, 0.0).T

    def is_held(self, phases: FloatArray) -> bool:
        """Whether the clearance is proved to be held for some phases."""
        if not self.may_be_held(phases[None, :], phases[None, :])[0]:
            return False
        shifts = self.part_shifts_at_phases(phases[None, :])[:, 0].tolist()
        curves = tuple(curve.shifted(shift) for curve, shift in zip(self.form.curves, shifts, strict=True))
        form, required = replace(self.form, curves=curves), self.form.required
        return form.enclose_least_clearance(Budget(CLEARANCE_WORK), required).lower >= required

    def may_be_held(self, low: FloatArray, high: FloatArray) -> BoolArray:
        """Whether some phases of each box (N, phases) may hold the clearance; if not, none does."""
        angles = self.form.start + self.form.width * np.linspace(0.0, 1.0, CLEARANCE_ANGLES)
        shifts = [np.repeat(self.part_shifts_at_phases(each), len(angles), axis=1) for each in (low, high)]
        highest = self.form.clearance_bounds_over_shifts(np.tile(angles, len(low)), *shifts)
        return np.asarray((highest.reshape(-1, CLEARANCE_ANGLES) >= self.form.required).all(axis=1))


@dataclass(eq=False)
class PhaseBranchAndBound:
    """The search for the phases of least peak torque between ``low`` and ``high`` [rad]."""

    torque: TorqueSum
    clearances: Sequence[PhaseClearance]
    low: FloatArray
    high: FloatArray
    budget: Budget = field(default_factory=lambda: Budget(PHASE_WORK))
    best: FloatArray = field(default_factory=lambda: np.zeros(0))
    peak: float = inf

    def try_phases(self, phases: FloatArray) -> float:
        """The peak for some phases; they are kept if they are the best so far and hold all clearances."""
        self.budget.spend(len(GRID) * len(phases))
        estimate = float(
            self.torque.largest_torque_angles_and_sizes(phases[None, :], np.zeros((1, len(phases))))[1][0, 0]
        )
        if estimate >= self.peak * (1.0 - LEAST_GAIN):
            return estimate
        self.budget.spend(EXACT_WORK * (1 + len(self.clearances)))
        if not all(clearance.is_held(phases) for clearance in self.clearances):
            return inf
        peak = self.torque.peak_upper_bound(phases)
        if peak < self.peak:
            self.best, self.peak = phases, peak
        return peak

    def improve_best_phases_from(self, phases: FloatArray) -> None:
        """Try phases, and from them the steps of linear programmes in boxes that shrink without success."""
        before, half = self.peak, 0.1 * (self.high - self.low)
        if not self.try_phases(phases) < before * (1.0 - PEAK_GAP):
            return
        for _ in range(STEPS):
            self.budget.spend(BOX_WORK * len(phases))
            box = (np.clip(self.best + way * half, self.low, self.high)[None, :] for way in (-1.0, 1.0))
            before = self.peak
            self.try_phases(self.torque.bound_peak_over_phase_boxes(*box).promising[0])
            half = half if self.peak < before else 0.5 * half

    def search(self) -> float:
        """Improve the best phases; return a proved lower bound of the least peak."""
        low, high, bounds, floor = self.low[None, :], self.high[None, :], np.zeros(1), inf
        in_clearances = {row for clearance in self.clearances for row in clearance.variables.tolist()}
        is_in_clearances = np.array([row in in_clearances for row in range(len(self.low))])
        while bounds.size and not self.budget.is_spent:
            order = np.argsort(bounds, kind="stable")
            now, later = order[:BATCH], order[BATCH:]
            box_low, box_high = low[now], high[now]
            self.budget.spend(BOX_WORK * box_low.size)
            found, rooms, promising = self.torque.bound_peak_over_phase_boxes(box_low, box_high)
            found = np.maximum(found, bounds[now])
            nearest = np.argsort(found)[:TRIED]
            trials = np.concatenate([promising[nearest], 0.5 * (box_low + box_high)[nearest]])
            self.improve_best_phases_from(
                trials[np.argmin(self.torque.largest_torque_angles_and_sizes(trials, 0.0 * trials)[1][:, 0])]
            )
            is_open = found < self.peak * (1.0 - PEAK_GAP)
            floor = min(floor, found[~is_open].min(initial=inf))
            for clearance in self.clearances:
                self.budget.spend(int(is_open.sum()) * CLEARANCE_ANGLES)
                is_open[is_open] = clearance.may_be_held(box_low[is_open], box_high[is_open])
            box_low, box_high, rooms = box_low[is_open], box_high[is_open], rooms[is_open]
            rows = np.arange(len(box_low))
            shares = (box_high - box_low) / np.maximum(self.high - self.low, TINY) * is_in_clearances
            widest = np.argmax(rooms / np.maximum(rooms.max(axis=1, keepdims=True), TINY) + shares, axis=1)
            upper, lower = box_high.copy(), box_low.copy()
            upper[rows, widest] = lower[rows, widest] = 0.5 * (box_low + box_high)[rows, widest]
            low = np.concatenate([low[later], box_low, lower])
            high = np.concatenate([high[later], upper, box_high])
            bounds = np.concatenate([bounds[later], np.tile(found[is_open], 2)])
        return float(min(floor, bounds.min(initial=inf), self.peak))


def least_torque_phases(machine: Machine, stations: Sequence[ResolvedStation]) -> PhaseOptimum | None:
    """The phases of ``search.phase`` with the least peak torque of the shaft.

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
            phases = np.array([origins.get(name, 0.0) for name in clearance.between])
            clearances.append(PhaseClearance(clearance_form(machine, stations, clearance), variables, phases))
    low, high = np.radians([machine.search.phase[name] for name in names]).T
    if not still and not clearances and (high - low >= TURN - EQUAL_ENDS).all():
        low[0] = high[0] = origins[names[0]]  # a shift of all phases changes nothing
    search = PhaseBranchAndBound(torque, clearances, low, high)
    before = np.array([origins[name] for name in names])
    search.improve_best_phases_from(np.clip(before, low, high))
    bound = search.search()
    found = np.round(np.degrees(search.best), PHASE_DECIMALS).tolist() if search.peak < inf else []
    best = dict(zip(names, found, strict=True)) if found else None
    return PhaseOptimum(machine, best, torque.peak_upper_bound(before), search.peak, bound)


def optimise_phases(machine: MachineSource) -> PhaseOptimum:
    """Find the phases within ``search.phase`` with the least peak torque of the shaft, with all clearances held.

    Parameters
    ----------
    machine : Machine, str or os.PathLike
        A machine with a speed, at least one station with a torque, and ``search.phase``.

    Returns
    -------
    PhaseOptimum
        The phases, the peaks before and after, and a proved lower bound of the least peak.

    Raises
    ------
    BadInput
        If the machine has no ``search.phase``, no speed or no torque.

    Examples
    --------
    >>> found = camopt.optimise_phases("packer")
    >>> camopt.evaluate_machine(found.best).verdict
    'held'
    """
    machine = machine_from(machine)
    found = least_torque_phases(machine, resolve_stations(machine))
    if found is None:
        why = "ranges of phases by station, with a torque: a speed, and masses or springs in the scenes"
        raise BadInput([Mistake(machine.file, "search.phase", None, f"missing; needs {why}", bare=True)])
    return found
