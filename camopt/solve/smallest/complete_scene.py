"""A scene with every size and number; the smallest cam supplies those that the scene leaves open."""

from camopt.core.mistakes import Unmet
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.solve.smallest.optimise import optimise


def with_all_sizes(scene: Scene) -> Scene:
    """The scene itself if it gives all sizes and numbers; else that of the smallest cam, or of the nearest miss.

    Raises
    ------
    BadInput
        As ``optimise``.
    Unmet
        If no cam can be assembled.
    """
    problem = resolve(scene)
    if not problem.missing_variables:
        return scene
    optimum = optimise(scene)
    design = optimum.best or optimum.nearest_miss
    if design is None:
        obstacles = "; ".join(optimum.obstacles.values())
        raise Unmet(f"the scene omits sizes, and no cam can be assembled for them: {obstacles}")
    return design.scene
