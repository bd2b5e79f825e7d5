"""Compiles in advance the kernels that first runs of commands need."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from camopt.core.engines.progress import Advance
from camopt.core.kernels.compile_notice import READY_KERNELS
from camopt.core.kernels.compile_rule import compile_at_first_call
from camopt.core.kernels.kernel_cache import NO_FOLDER, kernel_folder
from camopt.core.numerics.dominance import Dominators
from camopt.scene.scene import find_scene
from camopt.scene.sources import shipped_scenes
from camopt.solve.front.sweep import sweep
from camopt.solve.smallest.optimise import optimise
from camopt.solve.verdicts.evaluation import evaluate


def compile_kernels_for_scenes(names: Sequence[str], advance: Advance) -> tuple[int, Path]:
    """Compile the kernels for scenes; return the number of kernels and their folder.

    ``names`` are scenes; by default all shipped scenes.

    Raises
    ------
    PermissionError
        If there is no folder for compiled kernels.
    """
    scenes, folder = [find_scene(name) for name in names or shipped_scenes()], kernel_folder()
    if folder == NO_FOLDER:
        raise PermissionError("there is no folder for compiled kernels; set NUMBA_CACHE_DIR to a folder")
    compile_at_first_call()
    sizes = {"start": 40.0, "stop": 90.0, "step": 5.0}  # the kernels of sweeps are the same for all scenes
    sweep(find_scene("roller-1000rpm").replace(search={"base_radius": sizes, "law": ["cycloidal"]}), workers=1)
    Dominators(np.zeros((1, 2))).mask_dominated_points(np.ones((1, 2)))
    for done, scene in enumerate(scenes, 1):
        if scene.cam.base_radius is None:
            optimise(scene)
        else:
            evaluate(scene)
        advance(done, len(scenes))
    return len(READY_KERNELS), folder
