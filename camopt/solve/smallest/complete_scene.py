"""A scene with every size and number: its own, or those of its smallest cam where it leaves some to be found."""

from camopt.core.mistakes import Unmet
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.solve.smallest.optimise import optimise


def with_all_sizes(scene: Scene) -> Scene:
    """The scene itself if it gives all sizes and numbers; else that of the smallest cam, or the nearest miss.

    Raises
    ------
    BadInput
        As ``optimise``.
    Unmet
        If no cam can be put together.
    """
    problem = resolve(scene)
    if not problem.missing_variables:
        return scene
    found = optimise(scene)
    design = found.best or found.nearest_miss
    if design is None:
        raise Unmet(f"no cam gives the sizes that the scene leaves open: {'; '.join(found.obstacles.values())}")
    return design.scene
