"""The shaft of a machine: the sum of its stations' torques, the flywheel and the motor that it needs.

With the torque T(θ) of the stations and its mean, the work beyond the mean is W(θ) = ∫(T − T_mean)dθ. The energy
fluctuates by ΔE = max W − min W, and a shaft of inertia I changes its speed by C = ΔE/(I·ω²), which is (highest −
lowest)/mean. All three are exact, since T is a polynomial on each panel.

Source: Norton, Design of Machinery, ch. 11 (flywheels) and 10 (equivalent inertia).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import NamedTuple

from camopt.core.numerics.turn_curve import CurveExtreme, TurnCurve, extreme_of_larger_magnitude, sum_curves
from camopt.scene.machine import Machine
from camopt.scene.motors import MotorData
from camopt.solve.machine.stations import ResolvedStation


@dataclass(frozen=True, eq=False)
class Shaft:
    """The torque of a machine's shaft over a turn, and what follows from it.

    Attributes
    ----------
    torque : TurnCurve
        Sum over the stations that have a torque [N·m].
    rpm : float
        Speed [rev/min].
    inertia : TurnCurve
        Moment of inertia of the moving masses at the shaft [kg·m²].
    cam_inertia : float
        Moment of inertia of the cams at the shaft [kg·m²], of those whose scenes give thickness and density.

    Examples
    --------
    >>> shaft = camopt.evaluate_machine("pick-and-place").shaft
    >>> round(shaft.peak, 3), round(shaft.mean, 3)
    (10.213, 0.167)
    """

    torque: TurnCurve
    rpm: float
    inertia: TurnCurve
    cam_inertia: float = 0.0

    @cached_property
    def largest(self) -> CurveExtreme:
        """Largest torque [N·m] and its angle [rad]."""
        return self.torque.largest()

    @cached_property
    def least(self) -> CurveExtreme:
        """Least torque [N·m], below 0 where the cams drive the shaft, and its angle [rad]."""
        return self.torque.least()

    @cached_property
    def energy_fluctuation(self) -> float:
        """Largest less least work beyond the mean [J]."""
        work = self.torque.plus_number(-self.torque.mean).integral_from_start()
        return work.largest().value - work.least().value

    @property
    def peak(self) -> float:
        """Largest magnitude of the torque [N·m]."""
        return max(self.largest.value, -self.least.value)

    @property
    def peak_angle(self) -> float:
        """The angle of the largest magnitude [rad]."""
        return extreme_of_larger_magnitude(self.largest, self.least).angle

    @property
    def mean(self) -> float:
        """Mean torque [N·m]."""
        return self.torque.mean

    @property
    def rms(self) -> float:
        """Root mean square of the torque [N·m]."""
        return self.torque.rms

    @property
    def omega(self) -> float:
        """Angular velocity [rad/s]."""
        return self.rpm * pi / 30.0

    @property
    def mean_power(self) -> float:
        """Mean power [W]."""
        return self.mean * self.omega

    @property
    def peak_power(self) -> float:
        """Largest magnitude of the power [W]."""
        return self.peak * self.omega

    def flywheel_inertia(self, speed_fluctuation: float) -> float:
        """Moment of inertia [kg·m²] at which the speed fluctuates by a given (highest − lowest)/mean."""
        return self.energy_fluctuation / (speed_fluctuation * self.omega**2)

    def speed_fluctuation(self, inertia: float) -> float:
        """The fluctuation of speed of a shaft with this moment of inertia, (highest − lowest)/mean."""
        return self.energy_fluctuation / (inertia * self.omega**2)


def shaft_of_machine(machine: Machine, stations: Sequence[ResolvedStation]) -> Shaft | None:
    """The shaft of a machine; None without a speed, or if no station has a torque."""
    torques = [torque for station in stations if (torque := station.torque) is not None]
    if machine.shaft_rpm is None or not torques:
        return None
    inertia = sum_curves([each for station in stations if (each := station.reflected_inertia) is not None])
    cams = sum(station.cam_inertia * station.station.ratio**2 for station in stations)
    return Shaft(sum_curves(torques), machine.shaft_rpm, inertia, cams)


class MotorUse(NamedTuple):
    """How far a machine uses a motor of the catalogue; shares above 1 are too much.

    Examples
    --------
    >>> uses = camopt.evaluate_machine("pick-and-place").motors
    >>> [use.name for use in uses if use.fits][0]
    'SM-130'
    """

    name: str
    rms_share: float
    """Root mean square of the torque as a share of the rated torque."""
    peak_share: float
    """Largest torque as a share of the motor's peak torque."""
    speed_share: float
    """Speed as a share of the rated speed."""
    inertia_ratio: float
    """Inertia of the load to that of the motor, at the motor."""
    fits: bool
    """Whether no share is above 1 and the ratio of inertias is allowed."""


def motor_uses(machine: Machine, shaft: Shaft) -> tuple[MotorUse, ...]:
    """The use of each motor of the catalogue, in its order.

    The torque at the motor is |T|/(gear·efficiency), at a constant speed of the shaft. The inertia of the load is
    that of the cams, the mean of the moving masses and the flywheel, divided by gear². Without an inertia of the
    flywheel, it is that which ``fluctuation`` needs.
    """
    motor, wheel = machine.motor, machine.flywheel
    if motor is None:
        return ()
    needed = 0.0 if wheel.fluctuation is None else shaft.flywheel_inertia(wheel.fluctuation)
    load = (
        shaft.inertia.mean + shaft.cam_inertia + (needed if wheel.inertia is None else wheel.inertia)
    ) / motor.gear**2
    at_motor = 1.0 / (motor.gear * motor.efficiency)

    def use_of_motor(data: MotorData) -> MotorUse:
        shares = (
            shaft.rms * at_motor / data.rated_torque,
            shaft.peak * at_motor / data.peak_torque,
            shaft.rpm * motor.gear / data.rated_speed,
        )
        ratio = load / data.inertia
        allowed = motor.inertia_ratio is None or ratio <= motor.inertia_ratio
        return MotorUse(data.name, *shares, ratio, allowed and max(shares) <= 1.0)

    return tuple(use_of_motor(data) for data in machine.motors)


def smallest_motor(machine: Machine, uses: Sequence[MotorUse]) -> MotorUse | None:
    """The motor that fits with the least rated torque; None if none fits."""
    rated = {data.name: data.rated_torque for data in machine.motors}
    return min((use for use in uses if use.fits), key=lambda use: rated[use.name], default=None)
