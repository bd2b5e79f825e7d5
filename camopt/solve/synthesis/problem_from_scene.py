"""The demand of a scene on new motion laws, from its limits, ``[synthesis]`` and ranges of sizes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, isnan, radians

from camopt.core.mistakes import BadInput, Mistake, Unmet
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import translating, translating_flat
from camopt.model.motion import LAWS
from camopt.model.motion.move_joints import join_moves
from camopt.model.motion.programme import LAW_PEAKS, Programme, law_peaks, weighted_range
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE, Condition, Stroke
from camopt.scene.mapping import MOTION_AT_FOLLOWER
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.settings import given_profile_mistakes
from camopt.scene.problem.variables import variation_mistakes
from camopt.scene.scene import Scene
from camopt.scene.synthesis import SynthesisSettings
from camopt.solve.smallest.closed_form import least_size
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.conditions import DisplacementOrigin, displacement_origin, motion_conditions
from camopt.solve.synthesis.crossing_jerk import check_crossings
from camopt.solve.synthesis.linear_constraints import is_linear, linear_constraints_of, mean_constraints_of
from camopt.solve.synthesis.splines import Splines
from camopt.solve.synthesis.symmetry import find_mirror_strokes, find_opposed_strokes
from camopt.solve.synthesis.synthesis_problem import (
    CROSSING_JERK,
    TERM_ORDERS,
    LowHigh,
    SynthesisProblem,
    traced_roller_radius,
)
from camopt.solve.synthesis.through_train import constant_train_ratio, constraint_about_tool, reverses_motion

PEAK_ORDERS = {"peak_acceleration": 2, "peak_jerk": 3}
LEAST_POINT_DISTANCE = 1e-4  # of a stroke: the least distance of points
MOVE_PEAK_FACTOR = 1.25  # times what a scene's own moves have of what it limits nowhere
GENTLE_LAW = "poly345"  # whose peaks hold where a scene limits neither acceleration nor jerk


def build_synthesis_problem(scene: Scene, objective: Mapping[str, float] | None = None) -> SynthesisProblem:
    """The demand of a scene, with its own objective or another.

    Raises
    ------
    BadInput
        If a point or a size cannot be met by any law.
    """
    return problem_from_settings(resolve(scene), scene.synthesis, objective)


def problem_from_settings(
    scene_problem: Problem, asked: SynthesisSettings, objective: Mapping[str, float] | None = None
) -> SynthesisProblem:
    """As ``synthesis_problem``, of a scene already resolved and its ``[synthesis]``."""
    objective = objective_weights(asked) if objective is None else dict(objective)
    _check_rest(scene_problem, asked, objective)
    _check_peaks(scene_problem, asked)
    _check_train(scene_problem, objective)
    if CROSSING_JERK in objective:
        check_crossings(scene_problem)
    if given := given_profile_mistakes(scene_problem, "the motion"):
        raise BadInput(given)
    if scene_problem.programme.given_at_follower:
        why = "free laws behind a train are the tool's: leave it out"
        raise BadInput([Mistake(scene_problem.file, "motion_at", MOTION_AT_FOLLOWER, why, bare=True)])
    choices = scene_problem.search_space
    if freed := variation_mistakes(scene_problem.file, [*choices.angles, *choices.numbers], "free laws take"):
        raise BadInput(freed)
    if not any(stroke.is_free for stroke in scene_problem.programme.tool.strokes):
        why = "has nothing to choose: it needs a rise, a return or a move"
        raise BadInput([Mistake(scene_problem.file, "motion", None, why, bare=True)])
    ground = displacement_origin(scene_problem)
    # the lowest position of a follower behind a train has to be known, whatever the free laws are
    moves = any(stroke.is_move and stroke.is_free for stroke in ground.strokes)
    if (
        scene_problem.setup.train is not None
        and moves
        and (ground.lowest_angle is not None or reverses_motion(scene_problem))
    ):
        reason = "free moves through a train need a lowest position of the follower that the motion gives"
        raise BadInput([Mistake(scene_problem.file, "train", None, reason, bare=True)])
    strokes, body = ground.strokes, _largest_roller(scene_problem)
    roller = traced_roller_radius(scene_problem, body)
    size = _size_range(scene_problem, objective)
    least = least_size(scene_problem, {"size": size})
    # limits that leave no size, whatever the motion is
    limits = [limit for limit in scene_problem.limits if limit.least_size > size[1] or limit.most_size < least]
    if limits:
        names = ", ".join(limit.name for limit in limits)
        raise Unmet(f"no motion: a cam of no size is within the limits ({names})")
    return SynthesisProblem(
        scene_problem=scene_problem,
        splines=Splines(
            asked.degree, asked.pieces, asked.degree - 1 if asked.continuity is None else asked.continuity
        ),
        strokes=strokes,
        zero=ground.zero,
        lowest_angle=ground.lowest_angle,
        lead_range=_lead_range(scene_problem),
        prime_range=(least + roller, size[1] + roller),
        largest_roller=body,
        derivative_ranges=tuple(_stroke_ranges(scene_problem, asked, strokes, _derivative_orders(objective))),
        linear_constraints=tuple(linear_constraints_of(scene_problem)),
        mean_constraints=tuple(mean_constraints_of(scene_problem)),
        residual_limit=_residual_limit(scene_problem),
        rest=asked.rest,
        monotone=asked.monotone or (isinstance(asked.peak_velocity, tuple) and asked.peak_velocity[0] == 0.0),
        conditions=(*motion_conditions(ground), *_point_conditions(scene_problem, asked, ground)),
        objective=objective,
        mirror_strokes=_mirror_places(scene_problem, ground) if asked.symmetric else None,
        opposed_strokes=_opposed_places(scene_problem, ground)
        if scene_problem.setup.mechanism.drive.one_disc
        else None,
        crossing_window=radians(asked.crossing_window),
        smooth=asked.smooth,
    )


def split_by_offset(problem: SynthesisProblem) -> list[SynthesisProblem]:
    """The demand for each offset that a scene lists: between them there is no cam."""
    offset = problem.scene_problem.search_space.variables.get("offset")
    if offset is None or offset.is_free:
        return [problem]
    leads = [problem.scene_problem.design.sense * each for each in offset.listed_values.tolist()]
    return [replace(problem, lead_range=(lead, lead)) for lead in leads]


def _check_rest(scene_problem: Problem, asked: SynthesisSettings, objective: Mapping[str, float]) -> None:
    """A bounded or minimised jerk needs an acceleration that does not jump."""
    limited = any(
        isinstance(constraint.curve, Derivative) and constraint.curve.order == 3
        for constraint in scene_problem.constraints
    )
    bounded = limited or asked.peak_jerk is not None
    if asked.rest == 1 and (bounded or 3 in _derivative_orders(objective) or CROSSING_JERK in objective):
        what = "at least 2 where the jerk is limited or minimised: the acceleration may not jump then"
        raise BadInput([Mistake(scene_problem.file, "synthesis.rest", asked.rest, what)])


def _check_peaks(scene_problem: Problem, asked: SynthesisSettings) -> None:
    """The peaks of [synthesis] are for unit strokes."""
    given = [name for name in LAW_PEAKS if getattr(asked, name) is not None]
    if given and not any(stroke.kind in (RISE, RETURN) for stroke in scene_problem.programme.tool.strokes):
        what = "is for the unit stroke of rises and returns, and this motion has none: give [limits]"
        key, value = f"synthesis.{given[0]}", getattr(asked, given[0])
        raise BadInput([Mistake(scene_problem.file, key, value, what, bare=True)])


def _check_train(scene_problem: Problem, objective: Mapping[str, float]) -> None:
    """A residual vibration is that of a train, at a speed, in a dwell."""
    setup = scene_problem.setup
    key = "synthesis.minimise" if residual.RESIDUAL_TERM in objective else f"limits.{residual.RESIDUAL_TERM}"
    if residual.RESIDUAL_TERM not in objective and _residual_limit(scene_problem) is None:
        return
    speed = () if setup.omega is not None else ("cam.rpm",)
    train = () if setup.dynamics.natural_frequency is not None else ("follower.dynamics.natural_frequency",)
    what = None
    if speed or train:
        what = f"needs {', '.join((*speed, *train))}"
    elif residual.train_frequency_and_damping(setup) is None:
        what = "has no bound: the undamped train resonates, it vibrates a whole number of times in a turn"
    elif all(stroke.kind != DWELL for stroke in scene_problem.programme.tool.strokes):
        what = "needs a dwell"
    if what:
        raise BadInput([Mistake(scene_problem.file, key, residual.RESIDUAL_TERM, what, bare=True)])


def _residual_limit(scene_problem: Problem) -> float | None:
    """The largest residual vibration that a limit allows, mm or deg."""
    return next((limit.bound for limit in scene_problem.limits if limit.name == residual.RESIDUAL_TERM), None)


def objective_weights(asked: SynthesisSettings) -> dict[str, float]:
    return {asked.minimise: 1.0} if isinstance(asked.minimise, str) else dict(asked.minimise)


def _size_range(scene_problem: Problem, objective: Mapping[str, float]) -> LowHigh:
    """The range of the cam's radius: that of [search], or up to the scene's own where the objective is another."""
    if "size" in scene_problem.search_space.variables:
        return _range_of_size(scene_problem, "size")
    own = float(scene_problem.design.size[0])
    if "size" in objective:
        return 0.0, inf
    if isnan(own):
        what = "missing; an objective other than the size needs the largest radius, there or in [search]"
        raise BadInput([Mistake(scene_problem.file, scene_problem.variables[0].key, None, what, bare=True)])
    return 0.0, own


def _mirror_places(scene_problem: Problem, ground: DisplacementOrigin) -> tuple[int, ...]:
    """Which stroke mirrors which."""
    places = find_mirror_strokes(ground.strokes)
    if places is None:
        what = "the segments are no mirror image of themselves, about whatever cam angle"
        raise BadInput([Mistake(scene_problem.file, "synthesis.symmetric", True, what, bare=True)])
    return places


def _opposed_places(scene_problem: Problem, ground: DisplacementOrigin) -> tuple[int, ...]:
    """Which stroke comes half a turn after which, where a yoke has both its contacts on one disc."""
    places = find_opposed_strokes(ground.strokes)
    if places is None:
        what = "the segments of the second half of the turn are not those of the first one, with rises for returns"
        raise BadInput([Mistake(scene_problem.file, "motion", None, what, bare=True)])
    return places


def _point_conditions(
    scene_problem: Problem, asked: SynthesisSettings, ground: DisplacementOrigin
) -> Iterator[Condition]:
    """The points that the motion goes through; each lies in a stroke, and of a rise or return between its ends."""
    mistakes: list[Mistake] = []
    taken: list[float] = []
    for number, (given_angle, given) in enumerate(asked.points, start=1):
        angle, y = radians(given_angle), (given - ground.zero) * ground.unit
        stroke = next((s for s in ground.strokes if s.start < angle < s.end and s.is_free), None)
        key = f"synthesis.points.{number}"
        if stroke is None:
            what = "a cam angle inside a rise, return or move"
        elif not stroke.is_move and not min(stroke.low, stroke.high) <= y <= max(stroke.low, stroke.high):
            low, high = (ground.zero + end / ground.unit for end in (stroke.low, stroke.high))
            what = f"a displacement from {low:g} to {high:g} there"
        elif any(abs(angle - a) < LEAST_POINT_DISTANCE * stroke.angle for a in (*taken, stroke.start, stroke.end)):
            what = (
                f"at least {LEAST_POINT_DISTANCE:g} of the stroke's angle away from its ends and from other points"
            )
        else:
            yield Condition(key, 0, angle, angle, y, y)
            taken.append(angle)
            continue
        mistakes.append(Mistake(scene_problem.file, key, [given_angle, given], what))
    if mistakes:
        raise BadInput(mistakes)


def _largest_roller(scene_problem: Problem) -> float:
    """The largest radius of the roller or spherical face; 0 for what has none."""
    own = float(scene_problem.design.roller_radius[0])
    if scene_problem.setup.is_knife or scene_problem.setup.mechanism.flat_faced:
        return own
    return _range_of_size(scene_problem, "roller_radius")[1]


def _range_of_size(scene_problem: Problem, field: str) -> LowHigh:
    """The least and the largest value of a size that a scene allows."""
    own, searched = float(scene_problem.design.sizes[field][0]), scene_problem.search_space.variables.get(field)
    return (own, own) if searched is None else searched.range_ends


def _lead_range(scene_problem: Problem) -> LowHigh:
    """e, within the offsets that the scene allows."""
    if not scene_problem.setup.mechanism.moves_as(translating.MECHANISM, translating_flat.MECHANISM):
        return 0.0, 0.0
    low, high = sorted(scene_problem.design.sense * e for e in _range_of_size(scene_problem, "offset"))
    return low, high


def _stroke_ranges(
    scene_problem: Problem, asked: SynthesisSettings, strokes: Sequence[Stroke], minimised: set[int]
) -> Iterator[dict[int, LowHigh]]:
    """The ranges of each stroke's derivatives: what [limits] say of the turn and [synthesis] of unit strokes.

    Derivatives that are minimised have none but these.
    """
    of_moves = (
        _default_move_peaks(scene_problem, asked, minimised)
        if any(s.is_move and s.is_free for s in strokes)
        else {}
    )
    peaks = {name: value for name in LAW_PEAKS if (value := getattr(asked, name)) is not None}
    peaks |= dict.fromkeys(_default_peak_names(scene_problem, asked, minimised), GENTLE_LAW)
    of_unit = {LAW_PEAKS[name]: _peak_range(scene_problem, name, value) for name, value in peaks.items()}
    for stroke in strokes:
        limits = _derivative_limits(scene_problem, stroke.kind)
        if stroke.kind == DWELL:
            yield {}
        elif stroke.is_move:
            yield limits | (of_moves if stroke.is_free else {})
        else:
            yield _intersect_ranges(limits, of_unit, stroke)


def _derivative_limits(scene_problem: Problem, kind: int) -> dict[int, LowHigh]:
    """The ranges that [limits] give to derivatives over strokes of a kind."""
    bounds: dict[int, LowHigh] = {}
    ratio = constant_train_ratio(scene_problem)
    for constraint in (
        constraint_about_tool(scene_problem, each)
        for each in scene_problem.constraints
        if is_linear(scene_problem, each)
    ):
        if isinstance(constraint.curve, Derivative) and constraint.kinds & kind:
            order, largest = constraint.curve.order, constraint.upper_bound()
            largest *= abs(ratio) if ratio and constraint.curve.at_follower else 1.0
            bounds[order] = min(bounds.get(order, (-inf, inf)), (-largest, largest), key=lambda ends: ends[1])
    return bounds


def _intersect_ranges(
    limits: dict[int, LowHigh], of_unit: dict[int, LowHigh], stroke: Stroke
) -> dict[int, LowHigh]:
    """The ranges of a rise or return: within those of the turn, and those of its unit stroke."""
    found = dict(limits)
    for order, ends in of_unit.items():
        per = (stroke.high - stroke.low) / stroke.angle**order
        low, high = sorted(end * per for end in ends)
        before = limits.get(order, (-inf, inf))
        found[order] = max(low, before[0]), min(high, before[1])
    return found


def _default_move_peaks(
    scene_problem: Problem, asked: SynthesisSettings, minimised: set[int]
) -> dict[int, LowHigh]:
    """What moves hold of derivatives that [limits] bound nowhere: little more than those of least jerk have.

    The peaks of [synthesis] are those of unit strokes, and not about moves.
    """
    freed = [
        replace(stroke, named=False) if stroke.is_move else stroke
        for stroke in scene_problem.programme.tool.strokes
    ]
    own = Programme(tuple(stroke for stroke in join_moves(freed) if stroke.is_move))
    orders = (
        []
        if _has_motion_limits(scene_problem)
        else [order for order in PEAK_ORDERS.values() if order not in minimised]
    )
    orders = [order for order in orders if order <= asked.rest + 1]
    spans = {order: weighted_range(own, (0.0,) * order + (1.0,), ALL_STROKES) for order in orders}
    largest = {order: max(-least, most) for order, (least, most) in spans.items()}
    return {
        order: (-MOVE_PEAK_FACTOR * most, MOVE_PEAK_FACTOR * most) for order, most in largest.items() if most > 0.0
    }


def _has_motion_limits(scene_problem: Problem) -> bool:
    """Whether [limits] bound an acceleration or a jerk."""
    return any(
        isinstance(constraint.curve, Derivative) and constraint.curve.order > 1
        for constraint in scene_problem.constraints
    )


def _default_peak_names(scene_problem: Problem, asked: SynthesisSettings, minimised: set[int]) -> list[str]:
    """The peaks that are held to those of a gentle law, because the scene bounds none of them."""
    if _has_motion_limits(scene_problem) or any(getattr(asked, name) is not None for name in PEAK_ORDERS):
        return []
    return [name for name, order in PEAK_ORDERS.items() if order <= asked.rest + 1 and order not in minimised]


def default_peaks(scene: Scene, terms: Iterable[str] | None = None) -> dict[str, float]:
    """The peak factors that free laws hold by default, where the scene bounds neither acceleration nor jerk.

    ``terms`` are what is minimised, if not the objective of the scene.
    """
    objective = dict.fromkeys(terms, 1.0) if terms is not None else objective_weights(scene.synthesis)
    names = _default_peak_names(resolve(scene), scene.synthesis, _derivative_orders(objective))
    return {name: float(law_peaks(LAWS[GENTLE_LAW])[name]) for name in names}


def _derivative_orders(objective: Mapping[str, float]) -> set[int]:
    """The orders of the derivatives that an objective has."""
    return {TERM_ORDERS[term] for name in objective if (term := name.removesuffix("_rms")) in TERM_ORDERS}


def _peak_range(scene_problem: Problem, name: str, value: float | str | tuple[float, float]) -> LowHigh:
    """The range of a derivative of the unit stroke: ± a number, a range, or what a known law has."""
    if isinstance(value, tuple):
        return value
    if isinstance(value, str):
        found = law_peaks(scene_problem.laws[value])[name]
        if not isinstance(found, float) or found == inf:
            what = f"a law whose {name.replace('_', ' ')} is finite, or a number"
            raise BadInput([Mistake(scene_problem.file, f"synthesis.{name}", value, what)])
        value = found
    return -value, value
