"""The results of ``synthesise`` and ``frontier`` in sentences."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.solve.synthesis.conditions import origin_at_lowest_position
from camopt.solve.synthesis.problem_from_scene import MOVE_PEAK_FACTOR, default_peak_factors, objective_weights
from camopt.solve.synthesis.term_units import objective_unit
from camopt.solve.synthesis.through_train import constant_tool_to_follower_ratio
from camopt.solve.tables.cells import with_unit

if TYPE_CHECKING:
    from camopt.solve.synthesis.known_law_cams import KnownLawCams
    from camopt.solve.synthesis.synthesis_result import Synthesis

OWN_MOVES = "own moves"
"""Name of a scene's own moves, beside the names of laws."""
SHOWN_ZERO = 5e-4  # smaller shares are shown as 0.0%


def bound_in_words(result: "Synthesis") -> str:
    """The minimised value, the lower bound for any motion, and the gap between them."""
    unit = objective_unit(result.asked)
    what = f"Minimised: {with_unit(result.objective, unit)}."
    if result.bound:
        what += f" Lower bound for any motion within the convex limits: {with_unit(result.bound, unit)},"
        what += f" a gap of {result.gap:.2%}."
    elif result.bound is None:
        scene_problem = resolve(result.asked)
        if origin_at_lowest_position(scene_problem).lowest_angle is not None:
            what += " There is no bound: the follower is lowest in a move, where the scene gives no position."
        elif not constant_tool_to_follower_ratio(scene_problem):
            what += " There is no bound: through a train whose ratio changes nothing convex bounds the size."
    return what


def own_size_limit_in_words(result: "Synthesis") -> str:
    """Sentence that the cam may not be larger than in the scene; empty if the size is searched or minimised."""
    scene_problem = resolve(result.asked)
    if "size" in scene_problem.search_space.variables or "size" in objective_weights(result.asked.synthesis):
        return ""
    size = scene_problem.setup.mechanism.body.size_key
    own = with_unit(float(scene_problem.design.size[0]), "mm")
    return f"The {size.replace('_', ' ')} may be at most that of the scene, {own}: search.{size} gives it a range."


def reason_for_local_optimum(result: "Synthesis") -> str:
    """Why laws are only a local optimum."""
    scene_problem = resolve(result.asked)
    if constant_tool_to_follower_ratio(scene_problem) is None:
        return "The limits of a cam behind a train whose ratio changes are not convex"
    swung = scene_problem.setup.angular
    return "The limits of an oscillating follower are not convex" if swung else "Curvature or a load decides too"


def default_limits_in_words(scene: Scene, defaults: Mapping[str, float]) -> Iterator[str]:
    """A sentence on the default limits."""
    if not defaults:
        return
    kinds = {segment.segment for segment in scene.motion}
    peaks = " and ".join(f"{name.replace('_', ' ')} {value:.6g}" for name, value in defaults.items())
    limits = []
    if kinds & {"rise", "return"}:
        limits.append(f"the peaks of poly345 are the limits (for unit stroke and angle): {peaks}")
    if "move" in kinds:
        own = " and ".join(name.removeprefix("peak_") for name in defaults)
        limits.append(f"moves may have {MOVE_PEAK_FACTOR:g} times the largest {own} of those of least jerk")
    yield f"The scene limits neither acceleration nor jerk, so {'; '.join(limits)}."


def broken_limits_in_words(broken_limits_by_law: Mapping[str, str]) -> str:
    """The limits that known laws break, with the names of the laws if they differ."""
    laws: dict[str, list[str]] = {}
    for law, broken in broken_limits_by_law.items():
        laws.setdefault(broken, []).append(law)
    if len(laws) == 1:
        return next(iter(laws))
    return "; ".join(f"{broken} ({', '.join(names)})" for broken, names in laws.items())


def robust_verdict_and_cost_in_words(design: Mapping[str, Any]) -> str:
    """Whether every cam within the tolerances meets the limits, and what that costs; empty if not robust."""
    if "every_cam" not in design:
        return ""
    verdict = f"The limits of every cam within the tolerances: {design['every_cam']}."
    if "nominal_mm" not in design:
        return verdict
    increase, nominal = with_unit(design["safety_mm"], "mm"), with_unit(design["nominal_mm"], "mm")
    return f"{verdict} They make the cam {increase} larger: the nominal cam alone meets the limits at {nominal}."


def best_known_in_words(result: "Synthesis", known: "KnownLawCams") -> str:
    """The best known law that meets the same limits, and the scene's own law."""
    if known.best is None:
        return "No known law meets all these limits."
    value, unit = known.rows[known.best]["objective"], objective_unit(result.asked)
    sentence = f"The best known law that meets the same limits is {known.best}: {with_unit(value, unit)}"
    if known.best == OWN_MOVES:
        sentence = f"The scene's own moves meet the same limits: {with_unit(value, unit)}"
    share = 1.0 - result.objective / value if value else 0.0
    change = f"{share:.1%} less" if share > -SHOWN_ZERO else f"{-share:.1%} more"
    sentence += f"; the free laws need {change}." if value else "."
    own_sentence = "" if known.own_law in (None, known.best) else f" The scene's own, {known.own_law}: "
    return sentence + (
        own_sentence and f"{own_sentence}{with_unit(known.rows[str(known.own_law)]['objective'], unit)}."
    )


def defaults_unlike_synthesise_in_words(scene: Scene, frontier_defaults: Mapping[str, float]) -> Iterator[str]:
    """Sentences on default limits that ``synthesise`` and a frontier of the same scene do not share."""
    why = "Axes and minimised terms have no default limit. So synthesise, which minimises"
    minimised, alone = " and ".join(objective_weights(scene.synthesis)), default_peak_factors(scene)
    more, fewer = alone.keys() - frontier_defaults.keys(), frontier_defaults.keys() - alone.keys()
    for peaks, words in ((more, "also limits"), (fewer, "does not limit")):
        if peaks:
            which = " and ".join(sorted(name.removeprefix("peak_") for name in peaks))
            yield f"{why} {minimised}, {words} {which}."
