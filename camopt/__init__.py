"""camopt finds the smallest cam that gives a motion within your limits, and computes new motion laws for it.

A question is a ``Scene`` (``find_scene``, ``Scene.from_toml``, ``Scene.from_dict``). ``evaluate`` computes one
design, ``optimise`` finds the smallest, ``sweep`` evaluates a grid, ``synthesise`` and ``frontier`` compute new
motion laws, ``fit`` finds the motion of a measured cam, ``certify`` proves limits, ``check`` finds damaged files,
``plot`` draws, ``construct`` shows how a cam is drawn by hand, ``animate`` shows it turning. ``QUANTITIES`` lists
what can be reported, ``LAWS`` the motion laws.

Names are imported when they are first used, so that ``import camopt`` takes no time.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from camopt.quantities.shown import HasHtml
from camopt.storage.version import VERSION as __version__  # noqa: N811

if TYPE_CHECKING:
    from camopt.comparing.compare import Comparison, compare
    from camopt.drawing.animation import Animation, animate
    from camopt.drawing.construction.construct import Construction, construct
    from camopt.drawing.plot import plot
    from camopt.engines import cluster
    from camopt.exporting.cam_points import cam_points
    from camopt.exporting.export import export
    from camopt.exporting.exported import Export
    from camopt.front.designs import evaluate_designs
    from camopt.front.parts import SweepPart, merge, sweep_part
    from camopt.front.result import Sweep
    from camopt.front.sweep import sweep
    from camopt.measured.fit import fit
    from camopt.measured.fitted import Fit
    from camopt.measured.inspection import Inspection, ToleranceUse, inspect
    from camopt.measured.pair_inspection import PairInspection, inspect_pair
    from camopt.measured.profile import MeasuredProfile
    from camopt.measured.waves import ProfileWave
    from camopt.mistakes import BadInput, CamoptError, Stopped, UnknownName, Unmet, Unsolved
    from camopt.motion import LAWS
    from camopt.quantities import QUANTITIES
    from camopt.quantities.unit_systems import shown_in
    from camopt.reporting.report import report
    from camopt.scene.scene import Scene, find_scene
    from camopt.scene.sources import shipped_scenes
    from camopt.smallest.optimise import Optimum, optimise
    from camopt.smallest.prices import Price, prices
    from camopt.storage.checking import FileCheck, check
    from camopt.studies.harmonics import Harmonics, harmonics
    from camopt.studies.sensitivities import Sensitivities, Sensitivity, sensitivities
    from camopt.studies.spectrum import Spectrum, response_spectrum
    from camopt.studies.timing import Passage, Timing, timing
    from camopt.synthesis.frontier import frontier
    from camopt.synthesis.synthesise import synthesise
    from camopt.synthesis.synthesised import Synthesis
    from camopt.synthesis.traded import Frontier
    from camopt.tables.designs import Design, scene_of
    from camopt.tables.table import load
    from camopt.tolerances.allocation import Allocation, Allotted, allocate
    from camopt.tolerances.batch import Batch, ErrorSpread, Share, Spread, sample_cams
    from camopt.tolerances.held import Play
    from camopt.tolerances.margins import Margin
    from camopt.tolerances.tolerance import DwellError, MotionError, MotionErrors, tolerance
    from camopt.tolerances.worst_case import WorstCase
    from camopt.tolerances.worst_passing import WorstPassage
    from camopt.tolerances.worst_wobble import WorstWobble
    from camopt.verdicts.certify import certify
    from camopt.verdicts.evaluation import Evaluation, evaluate

_HOMES = {
    "Allocation": "tolerances.allocation",
    "Allotted": "tolerances.allocation",
    "Animation": "drawing.animation",
    "BadInput": "mistakes",
    "CamoptError": "mistakes",
    "FileCheck": "storage.checking",
    "Comparison": "comparing.compare",
    "Construction": "drawing.construction.construct",
    "Design": "tables.designs",
    "DwellError": "tolerances.tolerance",
    "Evaluation": "verdicts.evaluation",
    "Export": "exporting.exported",
    "Fit": "measured.fitted",
    "Frontier": "synthesis.traded",
    "Harmonics": "studies.harmonics",
    "Inspection": "measured.inspection",
    "LAWS": "motion",
    "Margin": "tolerances.margins",
    "MeasuredProfile": "measured.profile",
    "MotionError": "tolerances.tolerance",
    "MotionErrors": "tolerances.tolerance",
    "Optimum": "smallest.optimise",
    "PairInspection": "measured.pair_inspection",
    "Play": "tolerances.held",
    "Passage": "studies.timing",
    "Price": "smallest.prices",
    "ProfileWave": "measured.waves",
    "QUANTITIES": "quantities",
    "Scene": "scene.scene",
    "Spectrum": "studies.spectrum",
    "Stopped": "mistakes",
    "Sweep": "front.result",
    "SweepPart": "front.parts",
    "Synthesis": "synthesis.synthesised",
    "Timing": "studies.timing",
    "ToleranceUse": "measured.inspection",
    "UnknownName": "mistakes",
    "WorstCase": "tolerances.worst_case",
    "WorstPassage": "tolerances.worst_passing",
    "WorstWobble": "tolerances.worst_wobble",
    "Unmet": "mistakes",
    "Unsolved": "mistakes",
    "allocate": "tolerances.allocation",
    "animate": "drawing.animation",
    "cam_points": "exporting.cam_points",
    "certify": "verdicts.certify",
    "check": "storage.checking",
    "cluster": "engines",
    "compare": "comparing.compare",
    "construct": "drawing.construction.construct",
    "evaluate": "verdicts.evaluation",
    "evaluate_designs": "front.designs",
    "export": "exporting.export",
    "find_scene": "scene.scene",
    "fit": "measured.fit",
    "frontier": "synthesis.frontier",
    "harmonics": "studies.harmonics",
    "inspect": "measured.inspection",
    "inspect_pair": "measured.pair_inspection",
    "load": "tables.table",
    "merge": "front.parts",
    "optimise": "smallest.optimise",
    "plot": "drawing.plot",
    "prices": "smallest.prices",
    "report": "reporting.report",
    "response_spectrum": "studies.spectrum",
    "Sensitivities": "studies.sensitivities",
    "Sensitivity": "studies.sensitivities",
    "sensitivities": "studies.sensitivities",
    "scene_of": "tables.designs",
    "shipped_scenes": "scene.sources",
    "shown_in": "quantities.unit_systems",
    "sweep": "front.sweep",
    "sweep_part": "front.parts",
    "synthesise": "synthesis.synthesise",
    "timing": "studies.timing",
    "tolerance": "tolerances.tolerance",
    "Batch": "tolerances.batch",
    "ErrorSpread": "tolerances.batch",
    "Share": "tolerances.batch",
    "Spread": "tolerances.batch",
    "sample_cams": "tolerances.batch",
}

__all__ = [
    "LAWS",
    "QUANTITIES",
    "Allocation",
    "Allotted",
    "Animation",
    "BadInput",
    "Batch",
    "CamoptError",
    "Comparison",
    "Construction",
    "Design",
    "DwellError",
    "ErrorSpread",
    "Evaluation",
    "Export",
    "FileCheck",
    "Fit",
    "Frontier",
    "Harmonics",
    "Inspection",
    "Margin",
    "MeasuredProfile",
    "MotionError",
    "MotionErrors",
    "Optimum",
    "PairInspection",
    "Passage",
    "Play",
    "Price",
    "ProfileWave",
    "Scene",
    "Sensitivities",
    "Sensitivity",
    "Share",
    "Spectrum",
    "Spread",
    "Stopped",
    "Sweep",
    "SweepPart",
    "Synthesis",
    "Timing",
    "ToleranceUse",
    "UnknownName",
    "Unmet",
    "Unsolved",
    "WorstCase",
    "WorstPassage",
    "WorstWobble",
    "__version__",
    "allocate",
    "animate",
    "cam_points",
    "certify",
    "check",
    "cluster",
    "compare",
    "construct",
    "evaluate",
    "evaluate_designs",
    "export",
    "find_scene",
    "fit",
    "frontier",
    "harmonics",
    "inspect",
    "inspect_pair",
    "load",
    "merge",
    "optimise",
    "plot",
    "prices",
    "report",
    "response_spectrum",
    "sample_cams",
    "scene_of",
    "sensitivities",
    "shipped_scenes",
    "shown_in",
    "sweep",
    "sweep_part",
    "synthesise",
    "timing",
    "tolerance",
]


def _html(result: HasHtml) -> str:
    """What a notebook shows of a result."""
    return str(import_module("camopt.drawing.notebook").html_of(result))


HasHtml.html = _html


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'camopt' has no attribute {name!r}")
    value = getattr(import_module(f"camopt.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
