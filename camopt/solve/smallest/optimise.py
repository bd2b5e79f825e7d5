"""Optimise: the smallest cam of a scene over its laws and sizes, with what holds it."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.engines.progress import Progress, report_progress, with_progress_bar
from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import now, share
from camopt.core.quantities import in_order
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.arguments import SceneSource, options_by_keyword, scene_from
from camopt.scene.problem.limits import unset_limits
from camopt.scene.problem.problem import Problem, exactly, resolve
from camopt.scene.problem.settings import freed_of, given_profile, laws_of
from camopt.scene.problem.space import boxes_of, choices
from camopt.scene.problem.variables import not_varied
from camopt.scene.problem.zones import Off, of_train
from camopt.solve.smallest.closed_form import negligible
from camopt.solve.smallest.exchange import EXCHANGES, broken_at, with_proof
from camopt.solve.smallest.multipliers import BINDS
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.smallest.reasons import Reason, in_one_sentence, listed, reason
from camopt.solve.smallest.result import GAP, Smallest
from camopt.solve.smallest.smallest import smallest
from camopt.solve.smallest.smallest_train import TrainSearch, free_of_train, listed_trains
from camopt.solve.smallest.smallest_turn import smallest_of_turns
from camopt.solve.smallest.turns import SegmentAngles
from camopt.solve.tables.designs import ByLaw, Design, joined_laws
from camopt.solve.verdicts.judging import LAST_AT_ONCE, by_excess, evaluate_rows, violations, worst_excesses
from camopt.solve.verdicts.screening import feasible
from camopt.solve.verdicts.warned import warnings_of
from camopt.solve.verdicts.words import UNDECIDED

SECONDS = 60.0  # of a search, unless told
NOMINAL = 3  # of so many parts of the time, one is for the nominal cam beside a robust one
RADII = 48  # sizes above the optimum at which feasibility is looked at


@options_by_keyword
@with_progress_bar("laws")
def optimise(scene: SceneSource, *, progress: Progress | None = None, seconds: float = SECONDS) -> Optimum:
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
    problem, end = exactly(resolve(scene)), end_of(seconds)
    shared = [each for each in problem.choices.numbers if each.enters == "shared"]
    fixed = [*not_varied(problem.file, shared, "optimise takes"), *_both_free(problem)]
    if fixed := [*given_profile(problem, "the base radius"), *fixed]:
        raise BadInput(fixed)
    problem = freed_of(problem)
    found: dict[str, dict[str, Any]] = {}
    cams: dict[str, Problem] = {}
    sizes: dict[str, float] = {}
    misses: list[tuple[tuple[float, float], dict[str, Any]]] = []
    obstacles: dict[str, str] = {}
    out_of_time, programmes = False, laws_of(problem)
    for done, (programme, pair) in enumerate(programmes.items()):
        report_progress(progress, done, len(programmes))
        laws = joined_laws(programme.law_names(RISE), programme.law_names(RETURN))
        until = share(end, len(programmes) - done)
        turns = SegmentAngles(problem, pair, until=until)
        nominal = _nominal(problem.with_programme(programme), turns, share(until, NOMINAL))
        answers, least = least_of_all(problem.with_programme(programme), turns, until)
        out_of_time |= now() > until or any(each.cut for each in answers)
        if least is not None:
            assert least.answer.design is not None
            alone, design = least.problem.settled(least.answer.design)
            found[laws] = _described(alone, replace(least.answer, design=design), until) | least.angles
            found[laws] |= _beside(least.answer, nominal)
            cams[laws], sizes[laws] = replace(least.problem, design=least.answer.design), least.answer.size
            continue
        obstacles[laws] = _obstacle(answers, max(until, share(end, len(programmes) - done)))
        misses += [_missed(each.problem, each.answer.nearest) for each in answers if each.answer.nearest]
    order = sorted(found, key=lambda laws: sizes[laws])
    ranked = ByLaw((laws, Design(found[laws], scene)) for laws in order)
    least_miss = None if found else min(misses, key=lambda miss: miss[0], default=None)
    nearest = least_miss and Design(least_miss[1], scene)
    best = next(iter(ranked.values()), None)
    warnings = tuple(_warnings(cams[order[0]], best)) if best else ()
    return Optimum(scene, best, ranked, obstacles, nearest, out_of_time, warnings)


def end_of(seconds: float) -> float:
    """The time (``clock.now``) at which a search of given seconds must stop.

    Raises
    ------
    BadInput
        If they are no number above 0.
    """
    if not (isinstance(seconds, int | float) and seconds > 0.0):
        raise BadInput([Mistake("camopt", "seconds", seconds, "a number above 0")])
    return now() + seconds


class Answered(NamedTuple):
    """The answer for one box of sizes: with the turn of the cam and, where angles are free, what it chooses."""

    problem: Problem
    """With the turn that was chosen."""
    bounds: SizeBounds
    answer: Smallest
    freed: FloatArray
    """The angles of freed segments, deg."""
    angles: dict[str, Any]
    cut: bool = False
    """Whether the time was over before a search among trains was."""


def least_of_all(problem: Problem, turns: SegmentAngles, until: float) -> tuple[list[Answered], Answered | None]:
    """The smallest cam of each train and box of sizes, and that of all, if there is one, with what is proved of it.

    Where every cam within tolerances has to hold the limits, by exchange (``smallest.exchange``).

    Raises
    ------
    BadInput
        If nothing limits the size.
    """
    every = problem.offs
    if of_train(problem.zones):  # of many trains few matter, which the proof finds
        problem, turns = _with_offs(problem, turns, ())
    for _ in range(EXCHANGES if problem.zones else 1):
        answers = list(answers_of(problem, turns, until))
        least = _least_of(problem, answers)
        if least is None or not problem.zones:
            break
        proved, offs = with_proof(least.problem, least.answer, least.bounds, until)
        known = [*every, *(off for off in problem.offs if off not in every)]
        least = least._replace(answer=proved, problem=replace(least.problem, offs=tuple(known)))
        if proved.every_cam == UNDECIDED and proved.design is not None:
            offs = broken_at(least.problem, proved.design, [off for off in every if off not in problem.offs])
        if not offs:
            break
        problem, turns = _with_offs(problem, turns, (*problem.offs, *offs))
    return answers, least


def _with_offs(problem: Problem, turns: SegmentAngles, offs: tuple[Off, ...]) -> tuple[Problem, SegmentAngles]:
    """The problem, and its turns, where the cams that are off so have to hold the limits."""
    return replace(problem, offs=offs), replace(turns, problem=replace(turns.problem, offs=offs))


def answers_of(problem: Problem, turns: SegmentAngles, until: float) -> Iterator[Answered]:
    """The smallest cam of each train of which ``[search]`` lists the numbers, and of each box of sizes."""
    trains = listed_trains(problem)
    for done, numbers in enumerate(trains):
        end, here = share(until, len(trains) - done), problem.with_numbers(numbers)
        if here.setup.mechanism.is_apart:
            yield from (Answered(here, box, Smallest(None, inf), turns.scene_angles, {}) for box in boxes_of(here))
        else:
            yield from _answers_of_train(here, replace(turns, problem=turns.problem.with_numbers(numbers)), end)


def _answers_of_train(problem: Problem, turns: SegmentAngles, until: float) -> Iterator[Answered]:
    """The smallest cam of each box of sizes, with one train, or with the best train in its ranges."""
    boxes = boxes_of(problem)
    for done, bounds in enumerate(boxes):
        end = share(until, len(boxes) - done)
        if free_of_train(problem):
            best = TrainSearch(problem, bounds, end).run()
            yield Answered(best.problem, bounds, best.answer, turns.scene_angles, {}, best.cut)
            continue
        if not turns.freed:
            yield Answered(problem, bounds, smallest(problem, bounds, end), turns.scene_angles, {})
            continue
        answer, freed = smallest_of_turns(replace(turns, until=end), bounds)
        angles = {"angles_deg": turns.angles(freed)}
        yield Answered(turns.problem_of(freed), bounds, answer, freed, angles)


def _least_of(problem: Problem, answers: list[Answered]) -> Answered | None:
    """The smallest cam of all boxes, with what is proved of it; None if there is none."""
    least = min(answers, key=lambda each: each.answer.size)
    if least.answer.design is None:
        return None
    if least.answer.size <= 2 * max(negligible(each.problem, each.bounds) for each in answers):
        wanted = "a limit that small cams break, such as pressure_angle or curvature_radius"
        what = f"nothing limits the size: add {wanted}"
        raise BadInput([Mistake(problem.file, "limits", None, what, bare=True)])
    return least._replace(answer=replace(least.answer, floor=min(each.answer.floor for each in answers)))


def _obstacle(answers: list[Answered], until: float) -> str:
    """Why no box of sizes holds a feasible design; box by box, where the reasons differ."""
    reasons = {}
    for done, each in enumerate(answers):
        reasons[choices(each.problem, each.bounds)] = _why(each, share(until, len(answers) - done))
    return in_one_sentence(reasons)


def _why(each: Answered, until: float) -> Reason:
    """The reason for one box; after ``until`` what its nearest miss breaks."""
    mechanism = each.problem.setup.mechanism
    if mechanism.is_apart:
        return Reason(f"assembly: {mechanism.assembly}")
    if each.answer.proved and (now() <= until or each.answer.nearest is None):
        return reason(each.problem, each.bounds, until)
    if each.answer.nearest is None:
        return Reason("nothing that was found (not proved)")
    rows = evaluate_rows(each.problem, each.answer.nearest, frozenset(), until)
    return Reason(f"{rows.records()[0]['violated'].replace(',', ', ')} (not proved)")


def _both_free(problem: Problem) -> Iterator[Mistake]:
    """A mistake for each number of the train that has a range where angles have one too."""
    for each in free_of_train(problem) if problem.choices.angles else ():
        why = "optimise takes a list of it where angles of the motion are free, or the angles of the scene"
        yield Mistake(problem.file, each.searched, None, why, bare=True)


def _idle(problem: Problem, binding: Sequence[str]) -> Iterator[str]:
    """The keys of numbers with a range that change no limit which holds the problem's own design."""
    limits = [limit for limit in problem.without_last.limits if limit.name in binding]
    for each in problem.choices.numbers:
        if each.is_free:
            ends = problem.design.take([0, 0]).with_values({each.field: np.array(each.ends)})
            low, high = worst_excesses(problem, limits, ends).T
            if np.array_equal(low, high):
                yield each.key


def _warnings(problem: Problem, best: Design) -> Iterator[str]:
    """What to know of the smallest cam, which is the problem's design.

    Numbers that do not hold its size; whether no limit that was set does; and where no proof covers trains that
    were not tried.
    """
    alone, design = problem.alone(problem.design)
    yield from warnings_of(replace(alone, design=design))
    if (ranges := free_of_train(problem)) and not best["proved"]:
        numbers = listed(each.key for each in ranges)
        yield f"the best of the trains that were tried in the ranges of {numbers}: no proof covers the others"
    if idle := [*_idle(problem, best["binding"])]:
        given = (
            "one value of many that hold the limits is given; a sweep with it among its objectives finds the best"
        )
        yield f"the size does not depend on {listed(idle)} here: {given}"
    unasked = {limit.name for limit in problem.limits if not limit.asked}
    if best["binding"] and unasked.issuperset(best["binding"]):
        holds = f"only {listed(best['binding'])} holds this cam"
        unset = unset_limits(problem.limits, problem.setup)
        yield f"{holds}: [limits] such as {listed(unset)} make it one to build" if unset else holds


def _missed(problem: Problem, design: Designs) -> tuple[tuple[float, float], dict[str, Any]]:
    """The excess of a design over its limits, of the worst cam that has to hold them, and its quantities."""
    rows = evaluate_rows(problem, design, problem.wanted | problem.sizes)
    excess = worst_excesses(problem, problem.limits, design)
    values = rows.records()[0]
    if problem.offs:
        values["violated"] = str(violations(problem.limits, excess)[0])
    return by_excess(excess[:, 0]), {name: values[name] for name in in_order(values)}


def _described(problem: Problem, answer: Smallest, until: float) -> dict[str, Any]:
    """The quantities of an optimum, the limits that bind it, and where feasibility is clear above it."""
    design = answer.design
    assert design is not None
    rows = evaluate_rows(problem, design, problem.wanted | problem.sizes)
    excess = worst_excesses(problem, problem.limits, design)[:, 0]
    values = rows.records()[0]
    quantities = {name: values[name] for name in in_order(values)}
    smaller = answer.moved(-BINDS * design.prime_radius)
    stopped = str(evaluate_rows(problem, smaller, frozenset(), until).column("violated")[0]).split(",")
    binding = [
        limit.name
        for limit, over in zip(problem.limits, excess, strict=True)
        if over > -BINDS or (limit.last and limit.name in stopped)
    ]
    clear = _clear_above(problem, answer, until)
    return {
        **quantities,
        "binding": binding,
        "proved": answer.proved,
        "gap_mm": answer.gap,
        "clear_above_mm": clear,
        **({"every_cam": answer.every_cam} if answer.every_cam else {}),
    }


def _nominal(problem: Problem, turns: SegmentAngles, until: float) -> Smallest | None:
    """The smallest cam that holds the limits itself, to stand beside a robust one; none where all do so."""
    if not problem.zones:
        return None
    alone = replace(turns, problem=replace(turns.problem, zones={}, offs=()), until=until)
    _, least = least_of_all(replace(problem, zones={}, offs=()), alone, until)
    return least and least.answer


def _beside(robust: Smallest, nominal: Smallest | None) -> dict[str, Any]:
    """The size of the smallest nominal cam, whether it is proved, and by how much a robust one is larger."""
    if nominal is None:
        return {}
    larger = robust.size - nominal.size
    return {"nominal_mm": nominal.size, "nominal_proved": nominal.proved, "safety_mm": larger}


def _clear_above(problem: Problem, answer: Smallest, until: float) -> float:
    """The least size above which no size looked at is shown to break a limit, the other sizes being the optimum's.

    Of a pair both discs are larger by as much, where both are free, and the size is that of the first. Feasibility
    is looked at on a geometric grid, from ten times the prime radius down, and the last change found is bisected,
    until the time is over. An infeasible gap narrower than the grid can be missed.
    """
    design = answer.design
    assert design is not None
    size, prime_radius = float(design.size[0]), float(design.prime_radius[0])
    sizes = size + prime_radius * np.geomspace(1e-6, 10.0, RADII)

    def held(sizes: FloatArray) -> Any:
        return feasible(problem, answer.moved(sizes - size), perhaps=True)

    if not held(sizes[-1:])[0]:
        return inf
    bad, clear = -1, RADII - 1
    while bad < clear - 1:
        if now() > until:
            return float(sizes[clear])
        some = np.arange(max(clear - LAST_AT_ONCE, bad + 1), clear)
        bad = int(np.max(some[~held(sizes[some])], initial=bad))
        clear = max(int(some[0]), bad + 1)
    if bad < 0:
        return size
    low, high = sizes[bad], sizes[clear]
    while high - low > GAP * prime_radius and now() <= until:
        middle = (low + high) / 2
        low, high = (low, middle) if held(np.array([middle]))[0] else (middle, high)
    return float(high)
