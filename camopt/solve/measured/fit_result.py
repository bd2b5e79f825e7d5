"""The result of a fit: a scene with the measured motion, and its deviations from the points.

Stretches of a fit may stay on one side of the points by more than errors explain. The mean of m independent errors
is within σ/√m of 0 in two of three stretches. It is rarely six times as large in any stretch of a file. Such a
stretch shows a motion of large jerk: a corner, or a ramp that is too short for the dwell beside it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf, radians, sqrt
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.quantities import AT_FOLLOWER, DERIVATIVE_UNITS, QUANTITIES, displacement_unit, motion_peak_name
from camopt.core.quantities.display import Drawable
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.mechanisms.elements import OSCILLATING
from camopt.model.motion.programme import derivative_peak, derivative_root_mean_square
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.scene import Scene
from camopt.solve.measured.band_certificate import Deviation
from camopt.solve.measured.measured_points import TURN_DEG, MeasuredPoints, forward_angle_deg, shortened_list
from camopt.solve.measured.noise import LEAST_BAND, noise_band_factor
from camopt.solve.measured.outline import Doubt
from camopt.solve.measured.profile import FollowedProfile
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import Result, Table, table_of

JERK_ORDER = 3
MOST_WARNED_ROWS = 6  # rows named in a warning
FEWEST_POINTS, MOST_POINT_SHARE = 4, 0.25  # least number of points, and largest share of all points
LENGTH_RATIO = 1.2  # ratio of successive lengths of stretches
MEAN_SIGMAS = 6.0  # least mean of a stretch, in standard deviations of the mean


class OneSidedStretch(NamedTuple):
    """A stretch between two places of the points, and the mean deviation of the motion from them."""

    first: int
    last: int
    points: int
    mean: float


class OmittedPoint(NamedTuple):
    """A point that the fit leaves out: its row, angle [deg], lift, and the deviation of the motion from it."""

    row: int
    angle: float
    lift: float
    deviation: float


@dataclass(frozen=True)
class Fit(Result, Drawable):
    """The gentlest motion within a band of measured points, as a scene.

    Lifts, noise, band and deviations are in mm, deg when oscillating.

    Attributes
    ----------
    scene : Scene
        The cam with the fitted motion.
    points, outliers : Points
        The points of the fit, and the points left out: ``angles``, ``lifts`` and ``rows`` of the file.
    start : float
        The measured angle (deg) at which the turn of the scene starts.
    zero : float
        The lift there, the lowest.
    band : float
        Largest allowed deviation of the motion from a point.
    deviation : Deviation
        The deviation found: ``held`` (proved), ``at_points``, ``largest``, and ``between`` the points.
    least_square : float
        Lower bound of ∫ (y''')² dθ over the turn for any motion as near to the points; θ in rad.
    noise : float
        The standard deviation of the points' errors, estimated from the points.
    usual : bool
        Whether the band comes from the noise.
    profile : FollowedProfile or None
        The profile of the points, if they are one: their lifts are then positions of the follower.
    doubts : tuple of Doubt
        Dwells where the points also fit a motion without one: ``start`` and ``end`` (deg, measured angles), whether
        the motion ``rests`` there, and the ``segments`` of the other reading.

    Examples
    --------
    >>> lifts = [0.0] * 60 + [5.0 * k**3 * (20 - k) ** 3 / 1e6 for k in range(21)] + [0.0] * 39
    >>> cam = {"cam": {"form": "disc", "base_radius": 20}, "follower": {"motion": "translating", "contact": "flat"}}
    >>> fitted = camopt.fit(lifts, cam, band=0.01)
    >>> fitted.deviation.largest <= fitted.band, fitted.unit
    (True, 'mm')
    """

    picture = "pictures.measured"
    scene: Scene
    points: MeasuredPoints
    outliers: MeasuredPoints
    start: float
    zero: float
    band: float
    deviation: Deviation
    least_square: float
    noise: float = 0.0
    usual: bool = False
    profile: FollowedProfile | None = None
    doubts: tuple[Doubt, ...] = ()

    def __repr__(self) -> str:
        away = f"{self.deviation.largest:.4g} from {self.points.angles.size} points"
        return f"<Fit of {self.scene.name}: at most {away}, band {self.band:.4g}>"

    @cached_property
    def _problem(self) -> Problem:
        return resolve(self.scene)

    @property
    def unit(self) -> str:
        """Unit of the lifts."""
        return displacement_unit(angular=self._problem.given_motion_is_angle)

    @property
    def at_follower(self) -> bool:
        """Whether the points behind a train are of the follower's motion instead of the tool's."""
        return self._problem.programme.given_at_follower

    def quantity(self, derivative: str) -> str:
        """Name of the quantity that is the largest velocity, acceleration or jerk."""
        timed = self._problem.setup.omega is not None
        part = AT_FOLLOWER if self.at_follower else ""
        return motion_peak_name(derivative, part, angular=self._problem.given_motion_is_angle, timed=timed)

    def scale(self, order: int) -> Number:
        """Factor from a derivative of the motion to the unit of its quantity."""
        return motion_unit_factor(self._problem.setup, order, at_follower=self.at_follower)

    @property
    def _lift_to_programme_factor(self) -> float:
        """Factor from the unit of the lifts to that of a programme."""
        return radians(1.0) if self._problem.given_motion_is_angle else 1.0

    def table(self) -> Table:
        """A table of the segments of the motion."""
        segments = [{"law": "", **segment.model_dump(exclude_none=True)} for segment in self.scene.motion]
        names, units = ["segment", "angle", "lift", "law"], {"angle": "deg", "lift": self.unit}
        return table_of("The motion", segments, names, units=units)

    def sections(self) -> Iterator[Table | str]:
        """Deviations from the points, the segments, and peaks beside those of finite differences."""
        unit, deviation = self.unit, self.deviation
        lowest = f"its lowest {'position' if self.profile else 'lift'} is {with_unit(self.zero, unit)}"
        count = f"{self.points.angles.size:,} points, noise {with_unit(self.noise, unit)}"
        times = f" ({self.band / self.noise:.3g} times the noise)" if self.usual and self.noise else ""
        yield f"{self.scene.name}: {count}"
        yield f"Band {with_unit(self.band, unit)}{times}, proved at every point."
        largest, rms, between = (
            with_unit(value, unit) for value in (deviation.largest, self.deviation_rms, deviation.between)
        )
        yield (
            f"Largest deviation from the points {largest} (root mean square {rms}), "
            f"from the straight lines between points {between}."
        )
        yield f"The turn starts at the measured angle {self.start:g} deg; {lowest}."
        if self.scene.train:
            whose, other = ("follower", "tool") if self.at_follower else ("tool", "follower")
            yield f"The lift is that of the {whose}; the train of the scene gives the motion of the {other}."
        yield from self._profile_sections()
        yield ""
        yield self.table()
        before = self.before
        peaks = [
            {
                "largest": name,
                "by differences": to_shown_unit(before[name], unit),
                "of the motion": to_shown_unit(value, unit),
                "unit": unit_in_shown_system(unit),
            }
            for name, value in self.after.items()
            for unit in [QUANTITIES[self.quantity(name)].unit]
        ]
        yield table_of("Before and after", peaks, ["largest", "by differences", "of the motion", "unit"])
        jerk = QUANTITIES[self.quantity("jerk")].unit
        least = number_text(to_shown_unit(self.least_jerk_rms, jerk))
        yield f"Root mean square jerk: {with_unit(self.jerk_rms, jerk)}; least for any motion this near: {least}."

    def _profile_sections(self) -> Iterator[str]:
        """How a profile was measured, whose lift it gives, and the distances of its points from the fitted cam."""
        record = self._profile_record
        if self.profile is None or record is None:
            return
        follower = self.scene.follower
        numbers = {
            key: with_unit(record[f"{key}_mm"], "mm") for key in ("base_radius", "distance_max", "distance_rms")
        }
        radius = with_unit(self.profile.probe, "mm")
        probe = f"centres of a ball of {radius}" if self.profile.probe else "points on the profile itself"
        distances = f"{numbers['distance_max']}, root mean square {numbers['distance_rms']}"
        yield f"Measured: {probe}; the lift is that of the follower: {follower.motion}, {follower.contact}."
        yield f"Base radius {numbers['base_radius']}. Largest distance of the points from this cam: {distances}."

    @property
    def notes(self) -> tuple[str, ...]:
        """The warnings."""
        return self.warnings

    @property
    def deviation_rms(self) -> float:
        """Root mean square deviation of the motion from the points."""
        return float(np.sqrt(np.mean(np.square(self.deviation.at_points))))

    @cached_property
    def distances(self) -> FloatArray:
        """Distances of the points of a profile outside that of the scene [mm]; empty for measured lifts.

        They are along its normal, from an outline of the scene's profile that the fit itself does not use.
        """
        if self.profile is None:
            return np.empty(0)
        return self.profile.distances_outside_profile(self._problem, self.start, self.points.rows)

    @property
    def left_out(self) -> tuple[OmittedPoint, ...]:
        """The points that are left out, by row."""
        angles = np.radians(forward_angle_deg(self.start, self.outliers.angles))
        deviations = (
            self._problem.given_motion.motion_at(angles)[0] / self._lift_to_programme_factor
            + self.zero
            - self.outliers.lifts
        )
        rows = zip(self.outliers.rows, self.outliers.angles, self.outliers.lifts, deviations, strict=True)
        return tuple(
            sorted(
                OmittedPoint(int(row), float(angle), float(lift), float(deviation))
                for row, angle, lift, deviation in rows
            )
        )

    @property
    def jerk_rms(self) -> float:
        """Root mean square jerk over the turn, in the unit of the scene's jerks."""
        return float(derivative_root_mean_square(self._problem.given_motion, JERK_ORDER) * self.scale(JERK_ORDER))

    @property
    def least_jerk_rms(self) -> float:
        """Least root mean square jerk of any motion as near to the points, without dwells and turns."""
        return float(
            sqrt(self.least_square / radians(TURN_DEG)) * self._lift_to_programme_factor * self.scale(JERK_ORDER)
        )

    @property
    def price(self) -> float:
        """Root mean square jerk over the least one."""
        return self.jerk_rms / self.least_jerk_rms if self.least_jerk_rms else inf

    @property
    def after(self) -> dict[str, float]:
        """Largest velocity, acceleration and jerk of the motion."""
        orders = {name: order for order, name in enumerate(DERIVATIVE_UNITS, start=1)}
        programme = self._problem.given_motion
        return {
            name: derivative_peak(programme, order, ALL_STROKES) * self.scale(order)
            for name, order in orders.items()
        }

    @property
    def before(self) -> dict[str, float]:
        """Largest velocity, acceleration and jerk by finite differences of the points."""
        return {name: float(np.abs(rows[1]).max()) for name, rows in self.differences.items()}

    @cached_property
    def differences(self) -> Mapping[str, tuple[FloatArray, FloatArray]]:
        """Velocity, acceleration and jerk by divided differences of the points: cam angles [deg] and values."""
        angles, place = np.unique(forward_angle_deg(self.start, self.points.angles), return_inverse=True)
        lifts = np.bincount(place, self.points.lifts) / np.bincount(place) * self._lift_to_programme_factor
        count, theta = angles.size, np.radians(angles)
        derivatives, rows, factor = {}, lifts, 1.0
        around = np.concatenate([theta, theta[:JERK_ORDER] + radians(TURN_DEG)])
        for order, name in enumerate(DERIVATIVE_UNITS, start=1):
            rows = (np.roll(rows, -1) - rows) / (around[order : order + count] - theta)
            factor *= order
            middle = np.mean([around[k : k + count] for k in range(order + 1)], axis=0)
            derivatives[name] = np.degrees(middle) % TURN_DEG, rows * factor * self.scale(order)
        return derivatives

    @property
    def _noise_band(self) -> float:
        """The band that contains normal errors."""
        return self.noise * noise_band_factor(self.points.angles.size)

    @cached_property
    def one_sided(self) -> tuple[OneSidedStretch, ...]:
        """Stretches where the motion stays on one side of the points; none for a band wider than that of errors."""
        is_by_noise = self.usual or self.band < self._noise_band
        if not is_by_noise or self._noise_band < LEAST_BAND * float(np.ptp(self.points.lifts)):
            return ()
        return tuple(one_sided_stretches(np.array(self.deviation.at_points), self.noise))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings: a band that is narrow for the noise, and points that lie on one side or are left out."""
        sentences = []
        if self.unit == OSCILLATING.unit and not self.points.unit_said:
            most = with_unit(float(np.ptp(self.points.lifts)), self.unit)
            sentences.append(
                f"the lifts are read as angles, up to {most}; give the lift unit, {self.unit}, if they are angles"
            )
        if self.band < self._noise_band:
            noise, normal, band = (
                with_unit(value, self.unit) for value in (self.noise, self._noise_band, self.band)
            )
            what = f"narrower than the band of normal errors, {normal} for the noise {noise}"
            sentences.append(f"the band {band} is {what}: the motion may follow errors")
        for doubt in self.doubts[:MOST_WARNED_ROWS]:
            fits = f"from {doubt.start:g} to {doubt.end:g} deg the points fit with and without a dwell"
            change, kind = ("leave it out", "has one") if doubt.rests else ("add it", "has none")
            sentences.append(
                f"{fits}; the motion {kind}: to {change}, give the segments {','.join(doubt.segments)}"
            )
        for stretch in self.one_sided[:MOST_WARNED_ROWS]:
            first, last = self.points.angles[[stretch.first, stretch.last]]
            side, mean = "above" if stretch.mean > 0.0 else "below", abs(stretch.mean)
            how = f"{with_unit(mean, self.unit)} on average"
            how += f", {mean / self.noise:.2g} times the noise" if self.noise else ""
            sentences.append(
                f"from {first:g} to {last:g} deg the motion is {side} its {stretch.points} points by {how}"
            )
        if len(self.one_sided) > MOST_WARNED_ROWS:
            more = len(self.one_sided) - MOST_WARNED_ROWS
            sentences.append(f"the points of {more} more stretches are on one side of the motion")
        for point in self.left_out:
            what = "position" if self.profile else "lift"
            where = f"row {point.row} ({what} {with_unit(point.lift, self.unit)} at {point.angle:g} deg)"
            sentences.append(
                f"{where} is left out: the motion is {with_unit(abs(point.deviation), self.unit)} away"
            )
        if self.profile is not None and self.profile.unreached.size:
            rows = self.profile.unreached
            named = shortened_list(rows)
            sentences.append(f"the follower does not reach {rows.size} points in hollows: rows {named}")
        return tuple(sentences)

    @property
    def _profile_record(self) -> dict[str, Any] | None:
        if self.profile is None:
            return None
        return {
            "probe_radius_mm": self.profile.probe,
            "base_radius_mm": self.scene.cam.base_radius,
            "distance_max_mm": float(np.abs(self.distances).max()),
            "distance_rms_mm": float(np.sqrt(np.mean(self.distances**2))),
            "unreached_rows": self.profile.unreached.tolist(),
        }

    def values_for_json(self) -> dict[str, Any]:
        """Plain numbers and texts, without the points."""
        lengths = {
            "noise": self.noise,
            "band": self.band,
            "deviation_max": self.deviation.largest,
            "deviation_rms": self.deviation_rms,
            "deviation_from_lines_max": self.deviation.between,
            "zero": self.zero,
        }
        return {
            "name": self.scene.name,
            "points": int(self.points.angles.size),
            **{f"{name}_{self.unit}": value for name, value in lengths.items()},
            "band_over_noise": self.band / self.noise if self.usual and self.noise else None,
            "band_held": self.deviation.held,
            "start_deg": self.start,
            "jerk_rms": self.jerk_rms,
            "least_jerk_rms": self.least_jerk_rms,
            "before": {self.quantity(name): value for name, value in self.before.items()},
            "after": {self.quantity(name): value for name, value in self.after.items()},
            "profile": self._profile_record,
            "dwells_in_doubt": [
                {"from_deg": item.start, "to_deg": item.end, "rests": item.rests, "other_segments": item.segments}
                for item in self.doubts
            ],
            "one_sided": [
                {
                    "from_deg": float(self.points.angles[item.first]),
                    "to_deg": float(self.points.angles[item.last]),
                    "points": item.points,
                    f"mean_{self.unit}": item.mean,
                }
                for item in self.one_sided
            ],
            "left_out": [item._asdict() for item in self.left_out],
            "motion": [segment.model_dump(exclude_none=True) for segment in self.scene.motion],
        }


def one_sided_stretches(deviations: FloatArray, noise: float) -> list[OneSidedStretch]:
    """Separate stretches round the turn with deviations on one side, in their order."""
    sums = np.concatenate([[0.0], np.cumsum(np.concatenate([deviations, deviations]))])
    length, biased = FEWEST_POINTS, list[tuple[float, int, int]]()
    while length <= MOST_POINT_SHARE * deviations.size:  # means in their standard deviations
        means = np.abs(sums[length : length + deviations.size] - sums[: deviations.size]) / (
            noise * np.sqrt(length)
        )
        biased += [(float(means[k]), int(k), length) for k in np.flatnonzero(means > MEAN_SIGMAS)]
        length = max(length + 1, round(LENGTH_RATIO * length))
    is_taken, stretches = np.zeros(deviations.size, dtype=bool), []
    for _, first, count in sorted(biased, reverse=True):
        places = np.arange(first, first + count) % deviations.size
        if not is_taken[places].any():
            is_taken[places] = True
            stretches.append(OneSidedStretch(first, int(places[-1]), count, float(deviations[places].mean())))
    return sorted(stretches)
