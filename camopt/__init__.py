"""camopt finds the smallest cam that gives a motion within your limits, and computes new motion laws for it.

A question is a ``Scene`` (``find_scene``, ``Scene.from_toml``, ``Scene.from_dict``). ``evaluate`` computes one
design, ``optimise`` finds the smallest, ``sweep`` evaluates a grid, ``synthesise`` and ``frontier`` compute new
motion laws, ``certify`` proves limits, ``plot`` draws. ``QUANTITIES`` lists what can be reported, ``LAWS`` the
motion laws.

Names are imported when they are first used, so that ``import camopt`` takes no time.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from camopt.version import VERSION as __version__  # noqa: N811

if TYPE_CHECKING:
    from camopt.designs import Design, scene_of
    from camopt.drawing.accuracy import plot_accuracy
    from camopt.drawing.frontier import plot_frontier
    from camopt.drawing.spectrum import plot_spectrum
    from camopt.drawing.synthesis import plot_synthesis
    from camopt.evaluation import Evaluation, evaluate
    from camopt.figures import plot
    from camopt.mistakes import BadInput, UnknownName, Unmet, Unsolved
    from camopt.motion import LAWS
    from camopt.points import cam_points
    from camopt.proof.certify import certify
    from camopt.quantities import QUANTITIES
    from camopt.scene import Scene, find_scene, shipped_scenes
    from camopt.search.optimise import Optimum, optimise
    from camopt.search.sweep import Sweep, sweep
    from camopt.spectrum import response_spectrum
    from camopt.synthesis.frontier import Frontier, frontier
    from camopt.synthesis.synthesise import synthesise
    from camopt.synthesis.synthesised import Synthesised
    from camopt.table import load

_HOMES = {
    "BadInput": "mistakes",
    "Design": "designs",
    "Evaluation": "evaluation",
    "Frontier": "synthesis.frontier",
    "LAWS": "motion",
    "Optimum": "search.optimise",
    "QUANTITIES": "quantities",
    "Scene": "scene",
    "Sweep": "search.sweep",
    "Synthesised": "synthesis.synthesise",
    "UnknownName": "mistakes",
    "Unmet": "mistakes",
    "Unsolved": "mistakes",
    "cam_points": "points",
    "certify": "proof.certify",
    "evaluate": "evaluation",
    "find_scene": "scene",
    "frontier": "synthesis.frontier",
    "load": "table",
    "optimise": "search.optimise",
    "plot": "figures",
    "plot_accuracy": "drawing.accuracy",
    "plot_frontier": "drawing.frontier",
    "plot_spectrum": "drawing.spectrum",
    "plot_synthesis": "drawing.synthesis",
    "response_spectrum": "spectrum",
    "scene_of": "designs",
    "shipped_scenes": "scene",
    "sweep": "search.sweep",
    "synthesise": "synthesis.synthesise",
}

__all__ = [
    "LAWS",
    "QUANTITIES",
    "BadInput",
    "Design",
    "Evaluation",
    "Frontier",
    "Optimum",
    "Scene",
    "Sweep",
    "Synthesised",
    "UnknownName",
    "Unmet",
    "Unsolved",
    "__version__",
    "cam_points",
    "certify",
    "evaluate",
    "find_scene",
    "frontier",
    "load",
    "optimise",
    "plot",
    "plot_accuracy",
    "plot_frontier",
    "plot_spectrum",
    "plot_synthesis",
    "response_spectrum",
    "scene_of",
    "shipped_scenes",
    "sweep",
    "synthesise",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'camopt' has no attribute {name!r}")
    value = getattr(import_module(f"camopt.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
