"""The stations of a machine as curves over a turn of its shaft: motion of the tool, and torque on the shaft."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import isfinite, radians

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics.turn_curve import EQUAL_ENDS, TURN, TurnCurve
from camopt.core.quantities import displacement_unit
from camopt.model.effects import EvaluationBlock, available_quantities, missing_keys_by_quantity
from camopt.model.effects.force import force_factors_with_train, force_weights_and_constant
from camopt.model.effects.guided_torque import guided_torque_polynomials
from camopt.model.effects.loads import has_guide_friction
from camopt.model.effects.torque import torque_polynomials_by_panel
from camopt.scene.machine import Clearance, Machine, Station
from camopt.scene.problem.problem import Problem, missing_variable_mistakes, resolve
from camopt.scene.scene import Scene
from camopt.solve.verdicts.effect_runs import run_effects

TORQUE, CAM_INERTIA = "torque_peak_N_m", "cam_inertia_kg_m2"
TORQUE_ERROR, GUIDED_TORQUE_ERROR = 1e-12, 1e-9
"""Relative errors of the torque's polynomials, exact or interpolated."""


@dataclass(frozen=True, eq=False)
class ResolvedStation:
    """A station with its problem, and its curves over a turn of the machine's shaft."""

    station: Station
    scene: Scene
    problem: Problem

    @property
    def name(self) -> str:
        """The name of the station."""
        return self.station.name

    @property
    def tool_turns(self) -> bool:
        """Whether the tool turns."""
        return self.scene.tool_turns

    @property
    def unit(self) -> str:
        """Unit of the tool's lift: mm or deg."""
        return displacement_unit(angular=self.tool_turns)

    @cached_property
    def lift_by_cam_angle(self) -> TurnCurve:
        """Lift of the tool above its lowest position by the cam angle [mm or deg]."""
        programme = self.problem.programme.tool
        return programme.lift_curve * (1.0 / programme.unit_in_mm_or_rad)

    @cached_property
    def lift(self) -> TurnCurve:
        """Lift of the tool above its lowest position by the angle of the shaft [mm or deg]."""
        return self.lift_at_phase(self.station.phase)

    def lift_at_phase(self, phase: float) -> TurnCurve:
        """The lift with another phase [deg]."""
        return self.lift_by_cam_angle.sped_up(self.station.ratio).shifted(radians(phase))

    @cached_property
    def missing_torque_reason(self) -> str:
        """Why the station has no torque, or an infinite one; empty if it has a torque."""
        if missing := missing_keys_by_quantity(self.problem.setup).get(TORQUE, ()):
            return f"its scene lacks {', '.join(missing)}"
        if isfinite(peak_torque(self.problem)):
            return ""
        return "it is infinite, since the motion has corners or the follower jams in its guide"

    @cached_property
    def shaft_torque_by_cam_angle(self) -> TurnCurve | None:
        """Torque on the machine's shaft by the cam angle [N·m]; None if ``missing_torque_reason`` says why.

        The torque of the cam times the ratio, since both have the same power.
        """
        if self.missing_torque_reason:
            return None
        problem, error = self.problem, TORQUE_ERROR
        if has_guide_friction(problem.setup):
            half_width, series = guided_torque_polynomials(problem.setup, problem.design, problem.programme)
            error = GUIDED_TORQUE_ERROR
        else:
            dynamics, omega = problem.setup.dynamics, problem.setup.omega
            assert omega is not None
            factors = force_factors_with_train(dynamics, omega)
            half_width, series = (
                problem.programme.table.half_width,
                torque_polynomials_by_panel(problem.programme, factors)[:, 0],
            )
        ends = np.concatenate([[0.0], np.cumsum(2.0 * half_width)])
        assert abs(ends[-1] - TURN) < 1e3 * EQUAL_ENDS
        ends[-1] = TURN
        to_shaft = 1e-3 * self.station.ratio
        return TurnCurve(ends, series * to_shaft, error * to_shaft * float(np.abs(series).max()))

    @cached_property
    def reflected_inertia(self) -> TurnCurve | None:
        """Moment of inertia that the moving masses have at the shaft, by its angle [kg·m²]; None without torque.

        The masses have the kinetic energy I·ω²/2 at a speed ω of the shaft. Their torque is ω²·C with
        C = (dI/dθ)/2, so I = 2·∫C dθ, and I = 0 where the follower stands still.
        """
        if self.missing_torque_reason:
            return None
        programme, (_, _, mass, _) = (
            self.problem.programme,
            force_weights_and_constant(self.problem.setup.dynamics, 1.0),
        )
        inertial, loads = (
            torque_polynomials_by_panel(programme, factors)[:, 0]
            for factors in ((0.0, 0.0, mass, 0.0, 1.0), (0.0,) * 5)
        )
        half = TurnCurve(programme.lift_curve.ends, 2e-3 * self.station.ratio**2 * (inertial - loads))
        own = half.integral_from_start()
        own = own.plus_number(-own.least().value)
        return own.sped_up(self.station.ratio).shifted(radians(self.station.phase))

    @cached_property
    def cam_inertia(self) -> float:
        """Moment of inertia of the cam about its axis [kg·m²]; 0 if the scene gives no thickness or density."""
        if CAM_INERTIA not in available_quantities(self.problem.setup):
            return 0.0
        block = EvaluationBlock(self.problem.setup, self.problem.programme, self.problem.design)
        inertia = float(run_effects(block, [CAM_INERTIA]).column(CAM_INERTIA)[0])
        return inertia if isfinite(inertia) else 0.0

    @cached_property
    def torque(self) -> TurnCurve | None:
        """Torque of the station on the machine's shaft by its angle [N·m]; None if the scene has no forces."""
        return self.torque_at_phase(self.station.phase)

    def torque_at_phase(self, phase: float) -> TurnCurve | None:
        """The torque with another phase [deg]."""
        own = self.shaft_torque_by_cam_angle
        return None if own is None else own.sped_up(self.station.ratio).shifted(radians(phase))


def peak_torque(problem: Problem) -> float:
    """Largest magnitude of the torque on the camshaft of a scene [N·m]."""
    columns = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), [TORQUE])
    return float(columns.column(TORQUE)[0])


def clearance_unit(clearance: Clearance, stations: Iterable[ResolvedStation]) -> str:
    """Unit of a clearance: mm between outlines, else that of the lifts in it; empty if these differ in unit."""
    if clearance.along is None:
        return "mm"
    units = {station.unit for station in stations if station.name in clearance.between}
    return units.pop() if len(units) == 1 else ""


def resolve_stations(machine: Machine) -> tuple[ResolvedStation, ...]:
    """The stations of a machine with their problems.

    Raises
    ------
    BadInput
        For each size or number that a scene leaves to its search.
    """
    stations, mistakes = list[ResolvedStation](), list[Mistake]()
    for station in machine.station:
        scene = machine.scenes[station.name]
        try:
            stations.append(ResolvedStation(station, scene, resolve(scene)))
            mistakes += missing_variable_mistakes(stations[-1].problem)
        except BadInput as refused:
            mistakes += refused.mistakes
    if mistakes and machine.shaft_rpm is None:
        why = "missing; without it the scenes have no speed"
        mistakes.insert(0, Mistake(machine.file, "rpm", None, why, bare=True))
    if mistakes:
        raise BadInput(mistakes)
    return tuple(stations)
