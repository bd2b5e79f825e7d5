"""Optimise: the smallest cam of a scene over its laws and sizes, with what holds it."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.engines.progress import Progress, report_progress, with_progress_bar
from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import clock_seconds, time_share
from camopt.core.quantities import in_column_order
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.arguments import SceneSource, options_by_keyword, scene_from
from camopt.scene.problem.limits import unset_build_limits
from camopt.scene.problem.problem import Problem, at_rounding_error, resolve
from camopt.scene.problem.settings import given_profile_mistakes, law_choices, problem_with_free_numbers
from camopt.scene.problem.space import describe_listed_values, search_boxes
from camopt.scene.problem.tolerance_zones import NumberErrors, train_entries
from camopt.scene.problem.variables import variation_mistakes
from camopt.solve.smallest.closed_form import negligible_size
from camopt.solve.smallest.exchange import CAM_EXCHANGES, certify_answer, violating_cams
from camopt.solve.smallest.infeasibility import Infeasibility, find_infeasibility, join_infeasibilities, join_names
from camopt.solve.smallest.multipliers import ACTIVE_DISTANCE
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.smallest.result import RELATIVE_GAP, SmallestCam
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.smallest.smallest_train import TrainOptimiser, free_train_numbers, listed_trains
from camopt.solve.smallest.smallest_turn import smallest_over_turns
from camopt.solve.smallest.turns import SegmentAngles
from camopt.solve.tables.designs import Design, DesignsByLaw, joined_laws
from camopt.solve.verdicts.design_warnings import warnings_of
from camopt.solve.verdicts.feasible_filter import feasible_designs
from camopt.solve.verdicts.limit_verdicts import (
    LAST_DESIGNS_AT_ONCE,
    evaluate_rows,
    excess_rank,
    violations,
    worst_excesses,
)
from camopt.solve.verdicts.verdict_words import UNDECIDED

OPTIMISE_SECONDS = 60.0  # of a search, unless told
NOMINAL_PARTS = 3  # of so many parts of the time, one is for the nominal cam beside a robust one
CLEARANCE_SIZES = 48  # sizes above the optimum at which feasibility is looked at


@options_by_keyword
@with_progress_bar("laws")
def optimise(scene: SceneSource, *, progress: Progress | None = None, seconds: float = OPTIMISE_SECONDS) -> Optimum:
    """Find the smallest base radius (mean radius of a cylindrical cam) with which every limit of a scene is met.

    The base radius is free, within the range that ``[search]`` gives it, if any. For other sizes and numbers, such
    as a spring rate, a range in ``[search]`` means any value in it, and a list one of its values; what ``[search]``
    does not name stays as it is in the scene. Of two discs that both have a range the larger one is made least, and
    then the other one beside it, by its own sizes. Where the proof for ranges of numbers of the train takes too
    long, the answer is the best of the trains that were tried all over them and on the way down from there.

    With ``search.robust`` every cam whose numbers are within ``[tolerances]``, those of its train too, has to hold
    the limits, as one of its own; the size that is found is nominal. It is proved that no smaller cam is robust;
    that this one is, is proved over the whole box of numbers, not at its corners alone (``every_cam``).

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        Limits, and in ``[search]`` the laws to try and what is free.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (laws done, laws in all). If it
        returns False, the search ends.
    seconds : float, default 60
        Time for the search, shared between the laws. If it runs out, the answer is the smallest cam found so far,
        with ``proved`` False and its gap.

    Returns
    -------
    Optimum
        The smallest cam of each law, and of all (``best``), as designs with their scenes; or what is in the way.

    Raises
    ------
    BadInput
        If nothing limits the size from below, so that there is no smallest cam; if ``[search]`` varies the diameter
        of the shaft, or a number that a quantity needs above 0 down to 0.
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
    problem, end = at_rounding_error(resolve(scene)), search_end(seconds)
    shared = [each for each in problem.search_space.numbers if each.role == "shared"]
    fixed = [*variation_mistakes(problem.file, shared, "optimise takes"), *_train_range_mistakes(problem)]
    if fixed := [*given_profile_mistakes(problem, "the base radius"), *fixed]:
        raise BadInput(fixed)
    problem = problem_with_free_numbers(problem)
    found: dict[str, dict[str, Any]] = {}
    cams: dict[str, Problem] = {}
    sizes: dict[str, float] = {}
    misses: list[tuple[tuple[float, float], dict[str, Any]]] = []
    obstacles: dict[str, str] = {}
    out_of_time, programmes = False, law_choices(problem)
    for done, (programme, pair) in enumerate(programmes.items()):
        report_progress(progress, done, len(programmes))
        laws = joined_laws(programme.law_names(RISE), programme.law_names(RETURN))
        until = time_share(end, len(programmes) - done)
        turns = SegmentAngles(problem, pair, until=until)
        nominal = _nominal_optimum(problem.with_programme(programme), turns, time_share(until, NOMINAL_PARTS))
        answers, least = solve_all_boxes(problem.with_programme(programme), turns, until)
        out_of_time |= clock_seconds() > until or any(each.out_of_time for each in answers)
        if least is not None:
            assert least.answer.design is not None
            alone, design = least.problem.absorb_fixed_numbers(least.answer.design)
            found[laws] = _optimum_quantities(alone, replace(least.answer, design=design), until) | least.angles
            found[laws] |= _nominal_comparison(least.answer, nominal)
            cams[laws], sizes[laws] = replace(least.problem, design=least.answer.design), least.answer.size
            continue
        obstacles[laws] = _infeasibility_in_words(answers, max(until, time_share(end, len(programmes) - done)))
        misses += [_miss_quantities(each.problem, each.answer.nearest) for each in answers if each.answer.nearest]
    order = sorted(found, key=lambda laws: sizes[laws])
    ranked = DesignsByLaw((laws, Design(found[laws], scene)) for laws in order)
    least_miss = None if found else min(misses, key=lambda miss: miss[0], default=None)
    nearest = least_miss and Design(least_miss[1], scene)
    best = next(iter(ranked.values()), None)
    warnings = tuple(_optimum_warnings(cams[order[0]], best)) if best else ()
    return Optimum(scene, best, ranked, obstacles, nearest, out_of_time, warnings)


def search_end(seconds: float) -> float:
    """The time (``clock.now``) at which a search of given seconds must stop.

    Raises
    ------
    BadInput
        If they are no number above 0.
    """
    if not (isinstance(seconds, int | float) and seconds > 0.0):
        raise BadInput([Mistake("camopt", "seconds", seconds, "a number above 0")])
    return clock_seconds() + seconds


class BoxOptimum(NamedTuple):
    """The answer for one box of sizes: with the turn of the cam and, where angles are free, what it chooses."""

    problem: Problem
    """With the turn that was chosen."""
    bounds: SizeBounds
    answer: SmallestCam
    freed_angles: FloatArray
    """The angles of freed segments, deg."""
    angles: dict[str, Any]
    out_of_time: bool = False
    """Whether the time was over before a search among trains was."""


def solve_all_boxes(
    problem: Problem, turns: SegmentAngles, until: float
) -> tuple[list[BoxOptimum], BoxOptimum | None]:
    """The smallest cam of each train and box of sizes, and that of all, if there is one, with what is proved of it.

    Where every cam within tolerances has to hold the limits, by exchange (``smallest.exchange``).

    Raises
    ------
    BadInput
        If nothing limits the size.
    """
    every = problem.robust_errors
    if train_entries(problem.zones):  # of many trains few matter, which the proof finds
        problem, turns = _with_extra_cams(problem, turns, ())
    for _ in range(CAM_EXCHANGES if problem.zones else 1):
        answers = list(solve_each_train(problem, turns, until))
        least = _smallest_of_boxes(problem, answers)
        if least is None or not problem.zones:
            break
        proved, offs = certify_answer(least.problem, least.answer, least.bounds, until)
        known = [*every, *(off for off in problem.robust_errors if off not in every)]
        least = least._replace(answer=proved, problem=replace(least.problem, robust_errors=tuple(known)))
        if proved.every_cam == UNDECIDED and proved.design is not None:
            offs = violating_cams(
                least.problem, proved.design, [off for off in every if off not in problem.robust_errors]
            )
        if not offs:
            break
        problem, turns = _with_extra_cams(problem, turns, (*problem.robust_errors, *offs))
    return answers, least


def _with_extra_cams(
    problem: Problem, turns: SegmentAngles, offs: tuple[NumberErrors, ...]
) -> tuple[Problem, SegmentAngles]:
    """The problem, and its turns, where the cams that are off so have to hold the limits."""
    return replace(problem, robust_errors=offs), replace(turns, problem=replace(turns.problem, robust_errors=offs))


def solve_each_train(problem: Problem, turns: SegmentAngles, until: float) -> Iterator[BoxOptimum]:
    """The smallest cam of each train of which ``[search]`` lists the numbers, and of each box of sizes."""
    trains = listed_trains(problem)
    for done, numbers in enumerate(trains):
        end, here = time_share(until, len(trains) - done), problem.with_numbers(numbers)
        if here.setup.mechanism.has_no_assembly:
            yield from (
                BoxOptimum(here, box, SmallestCam(None, inf), turns.scene_angles, {}) for box in search_boxes(here)
            )
        else:
            yield from _solve_each_box(here, replace(turns, problem=turns.problem.with_numbers(numbers)), end)


def _solve_each_box(problem: Problem, turns: SegmentAngles, until: float) -> Iterator[BoxOptimum]:
    """The smallest cam of each box of sizes, with one train, or with the best train in its ranges."""
    boxes = search_boxes(problem)
    for done, bounds in enumerate(boxes):
        end = time_share(until, len(boxes) - done)
        if free_train_numbers(problem):
            best = TrainOptimiser(problem, bounds, end).run()
            yield BoxOptimum(best.problem, bounds, best.answer, turns.scene_angles, {}, best.out_of_time)
            continue
        if not turns.freed_segments:
            yield BoxOptimum(problem, bounds, solve_smallest_cam(problem, bounds, end), turns.scene_angles, {})
            continue
        answer, freed = smallest_over_turns(replace(turns, until=end), bounds)
        angles = {"angles_deg": turns.all_angles(freed)}
        yield BoxOptimum(turns.problem_of(freed), bounds, answer, freed, angles)


def _smallest_of_boxes(problem: Problem, answers: list[BoxOptimum]) -> BoxOptimum | None:
    """The smallest cam of all boxes, with what is proved of it; None if there is none."""
    least = min(answers, key=lambda each: each.answer.size)
    if least.answer.design is None:
        return None
    if least.answer.size <= 2 * max(negligible_size(each.problem, each.bounds) for each in answers):
        wanted = "a limit that small cams break, such as pressure_angle or curvature_radius"
        what = f"nothing limits the size: add {wanted}"
        raise BadInput([Mistake(problem.file, "limits", None, what, bare=True)])
    return least._replace(answer=replace(least.answer, floor=min(each.answer.floor for each in answers)))


def _infeasibility_in_words(answers: list[BoxOptimum], until: float) -> str:
    """Why no box of sizes holds a feasible design; box by box, where the reasons differ."""
    reasons = {}
    for done, each in enumerate(answers):
        reasons[describe_listed_values(each.problem, each.bounds)] = _infeasibility_of_box(
            each, time_share(until, len(answers) - done)
        )
    return join_infeasibilities(reasons)


def _infeasibility_of_box(each: BoxOptimum, until: float) -> Infeasibility:
    """The reason for one box; after ``until`` what its nearest miss breaks."""
    mechanism = each.problem.setup.mechanism
    if mechanism.has_no_assembly:
        return Infeasibility(f"assembly: {mechanism.assembly}")
    if each.answer.is_proved and (clock_seconds() <= until or each.answer.nearest is None):
        return find_infeasibility(each.problem, each.bounds, until)
    if each.answer.nearest is None:
        return Infeasibility("nothing that was found (not proved)")
    rows = evaluate_rows(each.problem, each.answer.nearest, frozenset(), until)
    return Infeasibility(f"{rows.records()[0]['violated'].replace(',', ', ')} (not proved)")


def _train_range_mistakes(problem: Problem) -> Iterator[Mistake]:
    """A mistake for each number of the train that has a range where angles have one too."""
    for each in free_train_numbers(problem) if problem.search_space.angles else ():
        why = "optimise takes a list of it where angles of the motion are free, or the angles of the scene"
        yield Mistake(problem.file, each.search_key, None, why, bare=True)


def _idle_numbers(problem: Problem, binding: Sequence[str]) -> Iterator[str]:
    """The keys of numbers with a range that change no limit which holds the problem's own design."""
    limits = [limit for limit in problem.without_deferred_limits.limits if limit.name in binding]
    for each in problem.search_space.numbers:
        if each.is_free:
            ends = problem.design.take([0, 0]).with_values({each.field: np.array(each.range_ends)})
            low, high = worst_excesses(problem, limits, ends).T
            if np.array_equal(low, high):
                yield each.key


def _optimum_warnings(problem: Problem, best: Design) -> Iterator[str]:
    """What to know of the smallest cam, which is the problem's design.

    Numbers that do not hold its size; whether no limit that was set does; and where no proof covers trains that
    were not tried.
    """
    alone, design = problem.absorb_design_numbers(problem.design)
    yield from warnings_of(replace(alone, design=design))
    if (ranges := free_train_numbers(problem)) and not best["proved"]:
        numbers = join_names(each.key for each in ranges)
        yield f"the best of the trains that were tried in the ranges of {numbers}: no proof covers the others"
    if idle := [*_idle_numbers(problem, best["binding"])]:
        given = (
            "one value of many that hold the limits is given; a sweep with it among its objectives finds the best"
        )
        yield f"the size does not depend on {join_names(idle)} here: {given}"
    unasked = {limit.name for limit in problem.limits if not limit.set_by_scene}
    if best["binding"] and unasked.issuperset(best["binding"]):
        holds = f"only {join_names(best['binding'])} holds this cam"
        unset = unset_build_limits(problem.limits, problem.setup)
        yield f"{holds}: [limits] such as {join_names(unset)} make it one to build" if unset else holds


def _miss_quantities(problem: Problem, design: Designs) -> tuple[tuple[float, float], dict[str, Any]]:
    """The excess of a design over its limits, of the worst cam that has to hold them, and its quantities."""
    rows = evaluate_rows(problem, design, problem.evaluated_quantities | problem.size_names)
    excess = worst_excesses(problem, problem.limits, design)
    values = rows.records()[0]
    if problem.robust_errors:
        values["violated"] = str(violations(problem.limits, excess)[0])
    return excess_rank(excess[:, 0]), {name: values[name] for name in in_column_order(values)}


def _optimum_quantities(problem: Problem, answer: SmallestCam, until: float) -> dict[str, Any]:
    """The quantities of an optimum, the limits that bind it, and where feasibility is clear above it."""
    design = answer.design
    assert design is not None
    rows = evaluate_rows(problem, design, problem.evaluated_quantities | problem.size_names)
    excess = worst_excesses(problem, problem.limits, design)[:, 0]
    values = rows.records()[0]
    quantities = {name: values[name] for name in in_column_order(values)}
    smaller = answer.with_larger_sizes(-ACTIVE_DISTANCE * design.prime_radius)
    stopped = str(evaluate_rows(problem, smaller, frozenset(), until).column("violated")[0]).split(",")
    binding = [
        limit.name
        for limit, over in zip(problem.limits, excess, strict=True)
        if over > -ACTIVE_DISTANCE or (limit.is_deferred and limit.name in stopped)
    ]
    clear = _clear_size(problem, answer, until)
    return {
        **quantities,
        "binding": binding,
        "proved": answer.is_proved,
        "gap_mm": answer.gap,
        "clear_above_mm": clear,
        **({"every_cam": answer.every_cam} if answer.every_cam else {}),
    }


def _nominal_optimum(problem: Problem, turns: SegmentAngles, until: float) -> SmallestCam | None:
    """The smallest cam that holds the limits itself, to stand beside a robust one; none where all do so."""
    if not problem.zones:
        return None
    alone = replace(turns, problem=replace(turns.problem, zones={}, robust_errors=()), until=until)
    _, least = solve_all_boxes(replace(problem, zones={}, robust_errors=()), alone, until)
    return least and least.answer


def _nominal_comparison(robust: SmallestCam, nominal: SmallestCam | None) -> dict[str, Any]:
    """The size of the smallest nominal cam, whether it is proved, and by how much a robust one is larger."""
    if nominal is None:
        return {}
    larger = robust.size - nominal.size
    return {"nominal_mm": nominal.size, "nominal_proved": nominal.is_proved, "safety_mm": larger}


def _clear_size(problem: Problem, answer: SmallestCam, until: float) -> float:
    """The least size above which no size looked at is shown to break a limit, the other sizes being the optimum's.

    Of a pair both discs are larger by as much, where both are free, and the size is that of the first. Feasibility
    is looked at on a geometric grid, from ten times the prime radius down, and the last change found is bisected,
    until the time is over. An infeasible gap narrower than the grid can be missed.
    """
    design = answer.design
    assert design is not None
    size, prime_radius = float(design.size[0]), float(design.prime_radius[0])
    sizes = size + prime_radius * np.geomspace(1e-6, 10.0, CLEARANCE_SIZES)

    def holds_limits(sizes: FloatArray) -> Any:
        return feasible_designs(problem, answer.with_larger_sizes(sizes - size), perhaps=True)

    if not holds_limits(sizes[-1:])[0]:
        return inf
    bad, clear = -1, CLEARANCE_SIZES - 1
    while bad < clear - 1:
        if clock_seconds() > until:
            return float(sizes[clear])
        some = np.arange(max(clear - LAST_DESIGNS_AT_ONCE, bad + 1), clear)
        bad = int(np.max(some[~holds_limits(sizes[some])], initial=bad))
        clear = max(int(some[0]), bad + 1)
    if bad < 0:
        return size
    low, high = sizes[bad], sizes[clear]
    while high - low > RELATIVE_GAP * prime_radius and clock_seconds() <= until:
        middle = (low + high) / 2
        low, high = (low, middle) if holds_limits(np.array([middle]))[0] else (middle, high)
    return float(high)
