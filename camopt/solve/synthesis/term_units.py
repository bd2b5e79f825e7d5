"""Units of objective terms and frontier axes."""

from camopt.core.quantities import DERIVATIVE_UNITS, QUANTITIES, motion_unit
from camopt.scene.scene import Scene
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.problem_from_scene import objective_weights
from camopt.solve.synthesis.synthesis_problem import LOST_AREA


def term_unit(axis: str, scene: Scene) -> str:
    """Unit of an objective term or quantity for a scene: m/s² with a speed, mm/rad² without."""
    if axis in QUANTITIES:
        return QUANTITIES[axis].unit
    angular, derivative = scene.tool_turns, axis.removesuffix("_rms").removeprefix("crossing_")
    if derivative in DERIVATIVE_UNITS:
        return motion_unit(derivative, angular=angular, timed=scene.cam.rpm is not None)
    if axis == LOST_AREA:
        return QUANTITIES["lift_area_deg_deg" if angular else "lift_area_mm_deg"].unit
    return "deg" if angular and axis == residual.RESIDUAL_TERM else "mm"


def objective_unit(scene: Scene) -> str:
    """Unit of a scene's objective; empty for a weighted sum."""
    weights = objective_weights(scene.synthesis)
    return "".join(term_unit(term, scene) for term in weights) if [*weights.values()] == [1.0] else ""
