"""Units of what free laws minimise and trade off: terms of the objective, and quantities."""

from camopt.core.quantities import DERIVATIVES, QUANTITIES, motion_unit
from camopt.scene.scene import Scene
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.demand import LOST_AREA
from camopt.solve.synthesis.from_scene import objective_in


def unit_of(axis: str, scene: Scene) -> str:
    """The unit of a term of the objective, or of a quantity, for a scene: m/s² with a speed, mm/rad² without."""
    if axis in QUANTITIES:
        return QUANTITIES[axis].unit
    angular, derivative = scene.tool_turns, axis.removesuffix("_rms").removeprefix("crossing_")
    if derivative in DERIVATIVES:
        return motion_unit(derivative, angular=angular, timed=scene.cam.rpm is not None)
    if axis == LOST_AREA:
        return QUANTITIES["lift_area_deg_deg" if angular else "lift_area_mm_deg"].unit
    return "deg" if angular and axis == residual.TERM else "mm"


def objective_unit(scene: Scene) -> str:
    """The unit of what a scene minimises; "" of a weighted sum."""
    weights = objective_in(scene.synthesis)
    return "".join(unit_of(term, scene) for term in weights) if [*weights.values()] == [1.0] else ""
