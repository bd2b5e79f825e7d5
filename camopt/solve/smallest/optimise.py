"""``camopt.optimise``: the smallest cam of a scene over its laws and sizes, with its active limits."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.engines.progress import Progress, report_progress, with_progress_bar
from camopt.core.mistakes import BadInput, Mistake, Unmet, join_words
from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import Budget, search_budget
from camopt.core.quantities import in_column_order
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.arguments import SceneSource, allow_positional_options, scene_from
from camopt.scene.problem.limits import keys_of_unset_build_limits
from camopt.scene.problem.problem import Problem, resolve, with_rounding_relative_error
from camopt.scene.problem.settings import (
    given_profile_mistakes,
    law_pair_by_programme,
    problem_with_searched_numbers_per_design,
)
from camopt.scene.problem.space import describe_listed_values, search_boxes
from camopt.scene.problem.tolerance_zones import NumberErrors, entries_of_train_numbers
from camopt.scene.problem.variables import variation_mistakes
from camopt.scene.scene import Scene
from camopt.solve.smallest.closed_form import negligible_size
from camopt.solve.smallest.exchange import CAM_EXCHANGES, certify_robust_answer
from camopt.solve.smallest.free_variables import free_train_numbers
from camopt.solve.smallest.infeasibility import Infeasibility, find_infeasibility, join_names
from camopt.solve.smallest.multipliers import ACTIVE_DISTANCE
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.smallest.result import RELATIVE_GAP, SmallestCam
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.smallest.smallest_train import TrainOptimiser
from camopt.solve.smallest.smallest_turn import smallest_cam_over_turns
from camopt.solve.smallest.turns import SegmentAngles
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.designs import Design, DesignsByLaw, joined_laws
from camopt.solve.verdicts.design_warnings import warnings_of_design
from camopt.solve.verdicts.feasible_filter import feasible_designs
from camopt.solve.verdicts.limit_verdicts import (
    LAST_DESIGNS_AT_ONCE,
    evaluate_with_verdicts,
    excess_rank,
    violated_limit_names,
    worst_excesses_over_variants,
)
from camopt.solve.verdicts.verdict_words import UNDECIDED

OPTIMISE_WORK = 60e6  # default work of a search
NOMINAL_PARTS = 3  # a robust search gives one of this many parts of its budget to the nominal cam
MOST_LISTED_BOXES = 3  # boxes whose sizes a reason lists
CLEARANCE_SIZES = 48  # sizes above the optimum at which feasibility is evaluated


@allow_positional_options
@with_progress_bar("laws")
def optimise(scene: SceneSource, *, progress: Progress | None = None, seconds: float | None = None) -> Optimum:
    """Find the smallest base radius (mean radius of a cylindrical cam) that meets every limit of a scene.

    The base radius is free, within its range in ``[search]`` if it has one. For other sizes and numbers, such as a
    spring rate, a range in ``[search]`` allows any value in it, and a list allows its values only. Whatever
    ``[search]`` does not name keeps its value in the scene. If both discs of a pair have a range, camopt minimises
    the larger disc, then the smaller one by its own sizes. If the proof over ranges of the train's numbers takes
    too long, the answer is the best train of a sample of these ranges and of descents from it.

    With ``search.robust`` every cam within ``[tolerances]``, those of the train included, must meet the limits; the
    size is the nominal one. camopt then proves that no smaller cam is robust. It also proves over the whole box of
    tolerances, not only at its corners, that this cam is robust (``every_cam``).

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        Limits, and in ``[search]`` the laws to try and the free variables.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (laws done, laws in all). If it
        returns False, the search ends.
    seconds : float, optional
        Time for the search [s], shared between the laws. By default the search stops after a fixed amount of work,
        about a minute, and gives the same answer on every machine. If it stops before the proof, the answer is the
        smallest cam so far, with ``proved`` False and its gap.

    Returns
    -------
    Optimum
        The smallest cam of each law and of all laws (``best``), as designs with their scenes; for a law without a
        feasible cam, the limits that prevent one (``obstacles``).

    Raises
    ------
    BadInput
        If nothing limits the size from below, so that there is no smallest cam. If ``[search]`` varies the diameter
        of the shaft, or lets a number reach 0 that a quantity needs above 0.
    Stopped
        If ``progress`` returned False.

    References
    ----------
    Moore, Kearfott and Cloud, Introduction to Interval Analysis, ch. 8 and 11.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm").replace(**{"search.law": ["cycloidal"]})
    >>> best = camopt.optimise(scene).best
    >>> round(best["base_radius_mm"], 4), best["proved"]
    (54.5395, True)
    """
    scene = scene_from(scene)
    problem, end = with_rounding_relative_error(resolve(scene)), search_budget(seconds, OPTIMISE_WORK)
    shared = [number for number in problem.search_space.numbers if number.role == "shared"]
    why = (
        "cannot have a range while angles of the motion are free: give optimise a list of values, or fix the angles"
    )
    mistakes = [
        *given_profile_mistakes(problem, "the base radius"),
        *variation_mistakes(problem.file, shared, "optimise takes"),
        *(
            Mistake(problem.file, number.search_key, None, why, bare=True)
            for number in free_train_numbers(problem)
            if problem.search_space.angles
        ),
    ]
    if mistakes:
        raise BadInput(mistakes)
    problem = problem_with_searched_numbers_per_design(problem)
    quantities: dict[str, dict[str, Any]] = {}
    cams: dict[str, BoxOptimum] = {}
    misses: list[tuple[tuple[float, float], dict[str, Any]]] = []
    obstacles: dict[str, str] = {}
    out_of_time, programmes = False, law_pair_by_programme(problem)
    for done, (programme, pair) in enumerate(programmes.items()):
        report_progress(progress, done, len(programmes))
        laws = joined_laws(programme.law_names(RISE), programme.law_names(RETURN))
        until = end.share(len(programmes) - done)
        turns = SegmentAngles(problem, pair, budget=until)
        nominal = _nominal_optimum(problem.with_programme(programme), turns, until.share(NOMINAL_PARTS))
        answers, least = solve_all_trains_and_boxes(problem.with_programme(programme), turns, until)
        out_of_time |= until.is_spent or any(answer.out_of_time for answer in answers)
        if least is None:
            obstacles[laws] = _infeasibility_in_words(answers, end.share(len(programmes) - done))
            misses += [
                _excess_rank_and_quantities(each.problem, each.answer.nearest)
                for each in answers
                if each.answer.nearest
            ]
            continue
        assert least.answer.design is not None
        reduced, design = least.problem.absorb_untoleranced_numbers(least.answer.design)
        quantities[laws] = _optimum_quantities(reduced, replace(least.answer, design=design), until)
        if turns.freed_segments:
            quantities[laws]["angles_deg"] = turns.all_segment_angles(least.freed_angles)
        if nominal is not None:
            quantities[laws] |= {
                "nominal_mm": nominal.size,
                "nominal_proved": nominal.is_proved,
                "safety_mm": least.answer.size - nominal.size,
            }
        cams[laws] = least._replace(problem=replace(least.problem, design=least.answer.design))
    order = sorted(cams, key=lambda laws: cams[laws].answer.size)
    ranked = DesignsByLaw((laws, Design(quantities[laws], scene)) for laws in order)
    least_miss = None if quantities else min(misses, key=lambda miss: miss[0], default=None)
    nearest = least_miss and Design(least_miss[1], scene)
    best = next(iter(ranked.values()), None)
    warnings = tuple(_optimum_warnings(cams[order[0]].problem, best)) if best else ()
    return Optimum(scene, best, ranked, obstacles, nearest, out_of_time, warnings)


def with_all_sizes(scene: Scene) -> Scene:
    """The scene itself if it gives all sizes and numbers; else that of the smallest cam, or of the nearest miss.

    Raises
    ------
    BadInput
        As ``optimise``.
    Unmet
        If no cam can be assembled.
    """
    if not resolve(scene).missing_variables:
        return scene
    optimum = optimise(scene)
    design = optimum.best or optimum.nearest_miss
    if design is None:
        obstacles = "; ".join(optimum.obstacles.values())
        raise Unmet(f"the scene omits sizes, and no cam can be assembled for them: {obstacles}")
    return design.scene


class BoxOptimum(NamedTuple):
    """The smallest cam in one box of sizes, with its turn."""

    problem: Problem
    """The problem with the turn of this cam."""
    bounds: SizeBounds
    answer: SmallestCam
    freed_angles: FloatArray
    """The angles of freed segments, deg."""
    out_of_time: bool = False
    """Whether the search among trains stopped early."""


def solve_all_trains_and_boxes(
    problem: Problem, turns: SegmentAngles, budget: Budget
) -> tuple[list[BoxOptimum], BoxOptimum | None]:
    """The smallest cam of each train and box of sizes, and the smallest of all, if there is one, with its proof.

    If every cam within tolerances must meet the limits, the method is exchange (``smallest.exchange``).

    Raises
    ------
    BadInput
        If nothing limits the size.
    """
    corner_errors = problem.robust_errors
    if entries_of_train_numbers(problem.zones):  # few of the many trains at corners matter; the proof finds these
        problem, turns = _with_robust_errors(problem, turns, ())
    for _ in range(CAM_EXCHANGES if problem.zones else 1):
        answers = list(solve_each_train_and_box(problem, turns, budget))
        least = _smallest_of_boxes(problem, answers)
        if least is None or not problem.zones:
            break
        proved, violating = certify_robust_answer(least.problem, least.answer, least.bounds, budget)
        all_errors = [*corner_errors, *(error for error in problem.robust_errors if error not in corner_errors)]
        least = least._replace(answer=proved, problem=replace(least.problem, robust_errors=tuple(all_errors)))
        if proved.every_cam == UNDECIDED and proved.design is not None:
            # no proof decides these limits: doubles show which corners of the tolerances break them
            violating = [
                error
                for error in corner_errors
                if error not in problem.robust_errors
                and not feasible_designs(
                    replace(least.problem, robust_errors=(error,)), proved.design, include_undecided=True
                )[0]
            ]
        if not violating:
            break
        problem, turns = _with_robust_errors(problem, turns, (*problem.robust_errors, *violating))
    return answers, least


def _with_robust_errors(
    problem: Problem, turns: SegmentAngles, errors: tuple[NumberErrors, ...]
) -> tuple[Problem, SegmentAngles]:
    """The problem and its turns, in which cams with these errors must meet the limits too."""
    robust = replace(turns.problem, robust_errors=errors)
    return replace(problem, robust_errors=errors), replace(turns, problem=robust)


def solve_each_train_and_box(problem: Problem, turns: SegmentAngles, budget: Budget) -> Iterator[BoxOptimum]:
    """The smallest cam of each train that ``[search]`` lists, or of the best train in its ranges, in each box."""
    listed_numbers = [number for number in problem.search_space.trains if not number.has_range]
    trains = [*product(*(number.grid_values.tolist() for number in listed_numbers))]
    for done_trains, values in enumerate(trains):
        numbers = {number.key: value for number, value in zip(listed_numbers, values, strict=True)}
        listed = problem.with_numbers(numbers)
        listed_turns = replace(turns, problem=turns.problem.with_numbers(numbers))
        end, boxes = budget.share(len(trains) - done_trains), search_boxes(listed)
        for done, bounds in enumerate(boxes):
            until = end.share(len(boxes) - done)
            if listed.setup.mechanism.has_no_assembly:
                yield BoxOptimum(listed, bounds, SmallestCam(None, inf), turns.scene_angles)
            elif free_train_numbers(listed):
                best = TrainOptimiser(listed, bounds, until).find_smallest_cam()
                yield BoxOptimum(best.problem, bounds, best.answer, turns.scene_angles, best.out_of_time)
            elif not turns.freed_segments:
                answer = solve_smallest_cam(listed, bounds, until)
                yield BoxOptimum(listed, bounds, answer, turns.scene_angles)
            else:
                answer, freed = smallest_cam_over_turns(replace(listed_turns, budget=until), bounds)
                yield BoxOptimum(listed_turns.problem_with_angles(freed), bounds, answer, freed)


def _smallest_of_boxes(problem: Problem, answers: list[BoxOptimum]) -> BoxOptimum | None:
    """The smallest cam of all boxes, with the lower bound over all of them; None if there is none."""
    least = min(answers, key=lambda each: each.answer.size)
    if least.answer.design is None:
        return None
    if least.answer.size <= 2 * max(negligible_size(each.problem, each.bounds) for each in answers):
        wanted = "a limit that small cams break, such as pressure_angle or curvature_radius"
        raise BadInput([Mistake(problem.file, "limits", None, f"nothing limits the size: add {wanted}", bare=True)])
    return least._replace(answer=replace(least.answer, floor=min(each.answer.floor for each in answers)))


def _infeasibility_in_words(answers: list[BoxOptimum], budget: Budget) -> str:
    """Why no box of sizes holds a feasible design: each reason once, with the boxes that it applies to.

    A reason names the smallest cam beyond the range, over its boxes.
    """
    reasons = {
        describe_listed_values(box.problem, box.bounds): _infeasibility_of_box(
            box, budget.share(len(answers) - done)
        )
        for done, box in enumerate(answers)
    }
    boxes_by_cause: dict[tuple[str, str], list[str]] = {}
    for where, reason in reasons.items():
        boxes_by_cause.setdefault((reason.cause, reason.size_range), []).append(where)
    texts = []
    for (cause, size_range), boxes in boxes_by_cause.items():
        best = min(boxes, key=lambda where: reasons[where].size)
        where = f", if {join_words(boxes, MOST_LISTED_BOXES)}" if len(boxes_by_cause) > 1 else ""
        if size_range:
            cam = "the smallest feasible cam has" if reasons[best].is_smallest else "a feasible cam has"
            sizes = f"{with_unit(reasons[best].size, 'mm')}{f', with {best}' if best else ''}"
            where += f", for {size_range} ({cam} {sizes})"
        texts.append(f"{cause}{where}")
    return "; ".join(texts)


def _infeasibility_of_box(box: BoxOptimum, budget: Budget) -> Infeasibility:
    """The reason for one box; once the budget is spent, the limits that its nearest miss breaks."""
    mechanism = box.problem.setup.mechanism
    if mechanism.has_no_assembly:
        return Infeasibility(f"assembly: {mechanism.assembly}")
    if box.answer.is_proved and (not budget.is_spent or box.answer.nearest is None):
        return find_infeasibility(box.problem, box.bounds, budget)
    if box.answer.nearest is None:
        return Infeasibility("unknown limits (not proved)")
    rows = evaluate_with_verdicts(box.problem, box.answer.nearest, frozenset(), budget)
    return Infeasibility(f"{rows.records()[0]['violated'].replace(',', ', ')} (not proved)")


def _optimum_warnings(problem: Problem, best: Design) -> Iterator[str]:
    """Warnings on the smallest cam, which is the problem's design.

    They name trains without a proof, numbers that the size does not depend on, and a cam whose active limits are
    all built in, none from ``[limits]``.
    """
    reduced, design = problem.absorb_design_numbers(problem.design)
    yield from warnings_of_design(replace(reduced, design=design))
    if (ranges := free_train_numbers(problem)) and not best["proved"]:
        numbers = join_names(number.key for number in ranges)
        yield f"this is the best of the trains tried in the ranges of {numbers}; no proof covers the others"
    active = [limit for limit in problem.without_deferred_limits.limits if limit.name in best["binding"]]
    idle = []
    for number in problem.search_space.numbers:
        if number.is_searched_continuously:
            ends = problem.design.take([0, 0]).with_values({number.field: np.array(number.range_ends)})
            if np.array_equal(*worst_excesses_over_variants(problem, active, ends).T):
                idle.append(number.key)
    if idle:
        names = join_names(idle)
        remedy = f"sweep with {names} as an objective to find the best"
        yield f"the size does not depend on {names} here: camopt shows one feasible value of many; {remedy}"
    built_in = {limit.name for limit in problem.limits if not limit.set_by_scene}
    if best["binding"] and built_in.issuperset(best["binding"]):
        holds = f"only built-in limits hold the size of this cam: {join_names(best['binding'])}"
        unset = keys_of_unset_build_limits(problem.limits, problem.setup)
        yield f"{holds}; if you want to make it, also set [limits] such as {join_names(unset)}" if unset else holds


def _evaluated_quantities(problem: Problem, design: Designs) -> dict[str, Any]:
    """The quantities of a design by name, in the order of columns."""
    names = problem.evaluated_quantities | problem.size_quantity_names
    values = evaluate_with_verdicts(problem, design, names).records()[0]
    return {name: values[name] for name in in_column_order(values)}


def _excess_rank_and_quantities(problem: Problem, design: Designs) -> tuple[tuple[float, float], dict[str, Any]]:
    """The rank of a design by its excess over the limits, with all robust cams, and its quantities."""
    quantities = _evaluated_quantities(problem, design)
    excess = worst_excesses_over_variants(problem, problem.limits, design)
    if problem.robust_errors:
        quantities["violated"] = str(violated_limit_names(problem.limits, excess)[0])
    return excess_rank(excess[:, 0]), quantities


def _optimum_quantities(problem: Problem, answer: SmallestCam, budget: Budget) -> dict[str, Any]:
    """The quantities of an optimum, its active limits, its gap, and the size above which larger cams are clear."""
    design = answer.design
    assert design is not None
    excess = worst_excesses_over_variants(problem, problem.limits, design)[:, 0]
    smaller = answer.with_larger_sizes(-ACTIVE_DISTANCE * design.prime_radius)
    stopped = str(evaluate_with_verdicts(problem, smaller, frozenset(), budget).column("violated")[0]).split(",")
    binding = [
        limit.name
        for limit, over in zip(problem.limits, excess, strict=True)
        if over > -ACTIVE_DISTANCE or (limit.is_deferred and limit.name in stopped)
    ]
    return {
        **_evaluated_quantities(problem, design),
        "binding": binding,
        "proved": answer.is_proved,
        "gap_mm": answer.gap,
        "clear_above_mm": _size_above_which_cams_are_feasible(problem, answer, budget),
        **({"every_cam": answer.every_cam} if answer.every_cam else {}),
    }


def _nominal_optimum(problem: Problem, turns: SegmentAngles, budget: Budget) -> SmallestCam | None:
    """The smallest cam without tolerances, to compare a robust one with; None if the problem is not robust."""
    if not problem.zones:
        return None
    nominal_turns = replace(turns, problem=replace(turns.problem, zones={}, robust_errors=()), budget=budget)
    _, least = solve_all_trains_and_boxes(replace(problem, zones={}, robust_errors=()), nominal_turns, budget)
    return least and least.answer


def _size_above_which_cams_are_feasible(problem: Problem, answer: SmallestCam, budget: Budget) -> float:
    """Least size above which no larger cam of a geometric grid breaks a limit [mm]; infinite if the largest does.

    The other sizes are those of the optimum. If both discs of a pair are free, both grow by the same length, and
    the size is that of the first. The grid is searched downwards from ten times the prime radius. The first change
    is bisected, until the budget is spent. An infeasible gap narrower than the grid can be missed.
    """
    design = answer.design
    assert design is not None
    size, prime_radius = float(design.size[0]), float(design.prime_radius[0])
    sizes = size + prime_radius * np.geomspace(1e-6, 10.0, CLEARANCE_SIZES)

    def holds_limits(sizes: FloatArray) -> Any:
        budget.spend(problem.evaluation_work(sizes.size))
        return feasible_designs(problem, answer.with_larger_sizes(sizes - size), include_undecided=True)

    if not holds_limits(sizes[-1:])[0]:
        return inf
    broken, clear = -1, CLEARANCE_SIZES - 1
    while broken < clear - 1:
        if budget.is_spent:
            return float(sizes[clear])
        block = np.arange(max(clear - LAST_DESIGNS_AT_ONCE, broken + 1), clear)
        broken = int(np.max(block[~holds_limits(sizes[block])], initial=broken))
        clear = max(int(block[0]), broken + 1)
    if broken < 0:
        return size
    low, high = sizes[broken], sizes[clear]
    while high - low > RELATIVE_GAP * prime_radius and not budget.is_spent:
        middle = (low + high) / 2
        low, high = (low, middle) if holds_limits(np.array([middle]))[0] else (middle, high)
    return float(high)
