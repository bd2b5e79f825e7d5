"""Contents of a timing diagram: spans of segments and clearances, and curves, by the angle of the shaft [deg]."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.turn_curve import CurveExtreme, TurnCurve, extreme_of_larger_magnitude, sum_curves
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.motion.stroke import DWELL
from camopt.scene.machine import Clearance, Machine
from camopt.show.drawing.picture import STROKE_NAMES, four_digit_text, value_with_unit
from camopt.solve.machine.clearances import ClearanceResult
from camopt.solve.machine.evaluation import MachineEvaluation
from camopt.solve.machine.stations import ResolvedStation, clearance_unit, resolve_stations

CURVE_STEP = 0.5  # deg between points of a curve
ANGLE_DIGITS = 9  # decimals of angles [deg]: rounding errors of sums of angles are smaller
MOST_CLEARANCES = 12  # drawn; a note counts the others
CLEARANCE = "clearance"
MOVE = "move"


class Span(NamedTuple):
    """A range of the shaft's angle [deg], which may cross 360°."""

    start: float
    """From 0 to less than 360."""
    end: float
    name: str
    """Rise, return, dwell, move or clearance."""
    words: str = ""
    """The law of a segment, or the condition of a clearance."""

    @classmethod
    def from_start_and_width(cls, start: float, width: float, name: str, words: str = "") -> "Span":
        """A span from any angle."""
        first = round(float(start) % 360.0, ANGLE_DIGITS) % 360.0
        return cls(first, round(first + float(width), ANGLE_DIGITS), name, words)

    @property
    def ranges_within_turn(self) -> list[tuple[float, float]]:
        """The ranges from 0 to 360°: two if the span crosses 360°."""
        if self.end - self.start >= 360.0:
            return [(0.0, 360.0)]
        if self.end <= 360.0:
            return [(self.start, self.end)]
        return [(self.start, 360.0), (0.0, self.end - 360.0)]


def segment_spans(station: ResolvedStation) -> list[Span]:
    """The segments of a station's tool over a turn of the shaft. Dwells that follow each other are one span."""
    ratio, phase = station.station.ratio, station.station.phase
    tool = station.problem.programme.tool
    strokes = [*(stroke for stroke in tool.strokes if stroke.kind != DWELL), *tool.dwells]
    if len(strokes) == 1 and tool.dwells:
        return [Span.from_start_and_width(phase, 360.0, STROKE_NAMES[DWELL])]
    return sorted(
        Span.from_start_and_width(
            phase + (np.degrees(stroke.start) + 360.0 * turn) / ratio,
            np.degrees(stroke.angle) / ratio,
            STROKE_NAMES.get(stroke.kind, MOVE),
            stroke.law.NAME if stroke.law and stroke.law.NAME != MOVE else "",
        )
        for turn in range(ratio)
        for stroke in strokes
    )


def clearance_span(clearance: Clearance, unit: str, result: ClearanceResult | None = None) -> Span:
    """The range of angles in which a clearance must hold, with the least clearance if there is a result."""
    along, between = clearance.along, clearance.between
    what = f"distance {' – '.join(between)}" if along is None else linear_form_text(along, between)
    words = f"{what} ≥ {value_with_unit(clearance.at_least, unit)}"
    if result is not None:
        words += f", least {value_with_unit(result.displayed_upper_bound, unit)} at {angle_text(result.angle)}°"
    name = CLEARANCE if result is None else f"{CLEARANCE} {result.verdict}"
    start, end = clearance.angles
    return Span.from_start_and_width(start, end - start, name, words)


def linear_form_text(coefficients: Iterable[float], names: Iterable[str]) -> str:
    """A linear form in words, such as 2·a − b."""
    terms = [
        (factor < 0.0, name if abs(factor) == 1.0 else f"{four_digit_text(abs(factor))}·{name}")
        for factor, name in zip(coefficients, names, strict=True)
    ]
    (minus, first), *others = terms
    return ("−" if minus else "") + first + "".join(f" {'−' if less else '+'} {term}" for less, term in others)


def curve_angles_deg_and_values(curve: TurnCurve) -> tuple[FloatArray, FloatArray]:
    """Angles [deg] and values of a curve, on each panel from end to end, so that jumps stay sharp."""
    half = np.degrees(curve.half_width)
    counts = np.maximum(2, np.ceil(2.0 * half / CURVE_STEP).astype(int) + 1)
    panel = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(panel)) - np.repeat(np.cumsum(counts) - counts, counts)
    u = 2.0 * place / (counts[panel] - 1) - 1.0
    values = np.zeros(len(u))
    for row in curve.series[::-1]:
        values = values * u + row[panel]
    return np.degrees(curve.centre)[panel] + u * half[panel], values


class Torque(NamedTuple):
    """The torque of a station or of the whole shaft, in the shown unit."""

    curve: TurnCurve
    peak: CurveExtreme
    unit: str

    @classmethod
    def from_curve(cls, curve: TurnCurve) -> "Torque":
        """The torque, with its largest magnitude."""
        shown = curve * float(to_shown_unit(1.0, "N·m"))
        return cls(shown, extreme_of_larger_magnitude(shown.largest(), shown.least()), unit_in_shown_system("N·m"))

    @property
    def peak_words(self) -> str:
        """Value and angle of the peak."""
        return f"{four_digit_text(self.peak.value)} {self.unit} at {angle_text(np.degrees(self.peak.angle))}°"


@dataclass(frozen=True, eq=False)
class TimingData:
    """The contents of the timing diagram of a machine."""

    machine: Machine
    stations: tuple[ResolvedStation, ...]
    results: tuple[ClearanceResult | None, ...] = ()
    """The results of clearances; empty without an evaluation."""

    @classmethod
    def from_machine(cls, what: Machine | MachineEvaluation) -> "TimingData":
        """The contents for a machine, or for the result of its evaluation."""
        if isinstance(what, MachineEvaluation):
            return cls(what.machine, what.resolved, what.clearances)
        return cls(what, resolve_stations(what))

    @cached_property
    def spans(self) -> list[list[Span]]:
        """The segments of each station."""
        return [segment_spans(station) for station in self.stations]

    @cached_property
    def clearances(self) -> list[tuple[str, Span]]:
        """Title and range of the first ``MOST_CLEARANCES`` clearances."""
        results = self.results or [None] * len(self.machine.clear)
        shown = [*zip(self.machine.clear, results, strict=True)][:MOST_CLEARANCES]
        return [(c.title, clearance_span(c, clearance_unit(c, self.stations), result)) for c, result in shown]

    @cached_property
    def torques(self) -> list[Torque | None]:
        """The torque of each station on the shaft; None for a station without forces."""
        curves = [station.torque for station in self.stations]
        return [None if curve is None else Torque.from_curve(curve) for curve in curves]

    @cached_property
    def total_torque(self) -> Torque | None:
        """The torque of all stations; None without any."""
        curves = [station.torque for station in self.stations if station.torque is not None]
        return Torque.from_curve(sum_curves(curves)) if curves else None

    @property
    def seconds_per_turn(self) -> float | None:
        """Time of a turn of the shaft [s]; None without a speed."""
        return None if self.machine.shaft_rpm is None else 60.0 / self.machine.shaft_rpm


def angle_text(angle: float) -> str:
    """An angle in deg with at most two decimals."""
    return f"{angle:.2f}".rstrip("0").rstrip(".").replace("-", "−")


def phase_and_ratio_text(station: ResolvedStation) -> str:
    """Phase and ratio of a station."""
    turns = f", {station.station.ratio} turns" if station.station.ratio > 1 else ""
    return f"phase {angle_text(station.station.phase)}°{turns}"
