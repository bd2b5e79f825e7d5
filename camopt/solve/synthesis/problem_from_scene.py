"""Build the ``SynthesisProblem`` of a scene from its limits, ``[synthesis]`` and ranges of sizes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, isnan, radians

from camopt.core.mistakes import BadInput, Mistake, Unmet
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms import translating, translating_flat
from camopt.model.motion import LAWS
from camopt.model.motion.move_joints import strokes_with_move_laws
from camopt.model.motion.programme import LAW_PEAKS, Programme, law_peaks, weighted_derivative_range
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE, Condition, Stroke
from camopt.scene.mapping import MOTION_AT_FOLLOWER
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.settings import given_profile_mistakes
from camopt.scene.problem.variables import variation_mistakes
from camopt.scene.scene import Scene
from camopt.scene.synthesis import SynthesisSettings
from camopt.solve.smallest.closed_form import size_lower_bound
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.conditions import (
    DisplacementOrigin,
    conditions_on_free_moves,
    origin_at_lowest_position,
)
from camopt.solve.synthesis.crossing_jerk import check_crossing_jerk_applies
from camopt.solve.synthesis.linear_constraints import convex_mean_constraints, is_linear, linear_constraints_of
from camopt.solve.synthesis.splines import Splines
from camopt.solve.synthesis.symmetry import find_mirror_strokes, find_opposed_strokes
from camopt.solve.synthesis.synthesis_problem import (
    CROSSING_JERK,
    TERM_ORDERS,
    LowHigh,
    SynthesisProblem,
    prime_less_cam_radius,
)
from camopt.solve.synthesis.through_train import (
    constant_tool_to_follower_ratio,
    constraint_with_tool_stroke_kinds,
    reverses_motion,
)

PEAK_ORDERS = {"peak_acceleration": 2, "peak_jerk": 3}
LEAST_POINT_DISTANCE = 1e-4  # least distance between points, as a share of the stroke
MOVE_PEAK_FACTOR = 1.25  # default peaks of free moves, as a multiple of those of the scene's own moves
PIECES = 48  # of a stroke, if the scene gives no number
GENTLE_LAW = "poly345"  # its peaks are the default limits of a scene without limits on acceleration and jerk


def build_synthesis_problem(scene: Scene, objective: Mapping[str, float] | None = None) -> SynthesisProblem:
    """The synthesis problem of a scene, with the scene's own objective or another.

    Raises
    ------
    BadInput
        If no law can meet a point or a size.
    """
    return problem_from_settings(resolve(scene), scene.synthesis, objective)


def problem_from_settings(
    scene_problem: Problem, settings: SynthesisSettings, objective: Mapping[str, float] | None = None
) -> SynthesisProblem:
    """As ``build_synthesis_problem``, for a resolved scene and its ``[synthesis]``."""
    objective = objective_weights(settings) if objective is None else dict(objective)
    _check_rest_for_finite_jerk(scene_problem, settings, objective)
    _check_peaks_have_rise_or_return(scene_problem, settings)
    _check_residual_vibration_applies(scene_problem, objective)
    if CROSSING_JERK in objective:
        check_crossing_jerk_applies(scene_problem)
    if profile_mistakes := given_profile_mistakes(scene_problem, "the motion"):
        raise BadInput(profile_mistakes)
    if scene_problem.programme.given_at_follower:
        why = "free laws behind a train are the tool's: leave it out"
        raise BadInput([Mistake(scene_problem.file, "motion_at", MOTION_AT_FOLLOWER, why, bare=True)])
    space = scene_problem.search_space
    if variable_mistakes := variation_mistakes(
        scene_problem.file, [*space.angles, *space.numbers], "free laws take"
    ):
        raise BadInput(variable_mistakes)
    if not any(stroke.is_law_replaceable for stroke in scene_problem.programme.tool.strokes):
        why = "has nothing to choose: it needs a rise, a return or a move"
        raise BadInput([Mistake(scene_problem.file, "motion", None, why, bare=True)])
    origin = origin_at_lowest_position(scene_problem)
    # behind a train, the lowest position of the follower must not depend on the free laws
    has_free_moves = any(stroke.is_move and stroke.is_law_replaceable for stroke in origin.strokes)
    if (
        scene_problem.setup.train is not None
        and has_free_moves
        and (origin.lowest_angle is not None or reverses_motion(scene_problem))
    ):
        reason = "free moves through a train need a lowest position of the follower that the motion gives"
        raise BadInput([Mistake(scene_problem.file, "train", None, reason, bare=True)])
    strokes, largest_roller = origin.strokes, float(scene_problem.design.roller_radius[0])
    if not (scene_problem.setup.is_knife or scene_problem.setup.mechanism.flat_faced):
        largest_roller = _range_of_size(scene_problem, "roller_radius")[1]
    roller = prime_less_cam_radius(scene_problem, largest_roller)
    size = _searched_or_own_size_range(scene_problem, objective)
    smallest = size_lower_bound(scene_problem, {"size": size})
    # limits that no size meets, for any motion
    limits = [limit for limit in scene_problem.limits if limit.least_size > size[1] or limit.most_size < smallest]
    if limits:
        names = ", ".join(limit.name for limit in limits)
        raise Unmet(f"no motion: no cam of any size meets the limits ({names})")
    why = "the segments are not symmetric about any cam angle"
    asymmetry = Mistake(scene_problem.file, "synthesis.symmetric", True, why, bare=True)
    why = "the second half of the turn must repeat the first one, with rises for returns"
    unlike_halves = Mistake(scene_problem.file, "motion", None, why, bare=True)
    return SynthesisProblem(
        scene_problem=scene_problem,
        splines=Splines(
            settings.degree,
            settings.pieces or PIECES,
            settings.degree - 1 if settings.continuity is None else settings.continuity,
        ),
        strokes=strokes,
        zero=origin.zero,
        lowest_angle=origin.lowest_angle,
        lead_range=_lead_range(scene_problem),
        prime_range=(smallest + roller, size[1] + roller),
        largest_roller=largest_roller,
        derivative_ranges=tuple(
            _derivative_ranges_by_stroke(
                scene_problem, settings, strokes, _derivative_orders_in_objective(objective)
            )
        ),
        linear_constraints=tuple(linear_constraints_of(scene_problem)),
        mean_constraints=tuple(convex_mean_constraints(scene_problem)),
        residual_limit=_residual_vibration_limit(scene_problem),
        rest=settings.rest,
        monotone=settings.monotone
        or (isinstance(settings.peak_velocity, tuple) and settings.peak_velocity[0] == 0.0),
        conditions=(*conditions_on_free_moves(origin), *_point_conditions(scene_problem, settings, origin)),
        objective=objective,
        mirror_strokes=_require_partners(find_mirror_strokes(strokes), asymmetry) if settings.symmetric else None,
        opposed_strokes=_require_partners(find_opposed_strokes(strokes), unlike_halves)
        if scene_problem.setup.mechanism.drive.one_disc
        else None,
        crossing_window=radians(settings.crossing_window),
        smooth=settings.smooth,
    )


def split_by_listed_offset_or_arm(problem: SynthesisProblem) -> list[SynthesisProblem]:
    """One problem for each offset or arm that the scene lists; a single one for a range of them."""
    scene_problem = problem.scene_problem
    variables, design = scene_problem.search_space.variables, scene_problem.design
    size = variables.get("arm_length" if scene_problem.setup.angular else "offset")
    if size is None or size.is_searched_continuously:
        return [problem]
    values = size.listed_values
    leads = values - design.arm_length if scene_problem.setup.angular else design.sense * values
    return [replace(problem, lead_range=(lead, lead)) for lead in leads.tolist()]


def _check_rest_for_finite_jerk(
    scene_problem: Problem, settings: SynthesisSettings, objective: Mapping[str, float]
) -> None:
    """BadInput if the jerk is limited or minimised but the acceleration may jump."""
    limited = any(
        isinstance(constraint.curve, MotionDerivative) and constraint.curve.order == 3
        for constraint in scene_problem.constraints
    )
    minimised = 3 in _derivative_orders_in_objective(objective) or CROSSING_JERK in objective
    if settings.rest == 1 and (limited or settings.peak_jerk is not None or minimised):
        what = "at least 2 where the jerk is limited or minimised: the acceleration may not jump then"
        raise BadInput([Mistake(scene_problem.file, "synthesis.rest", settings.rest, what)])


def _check_peaks_have_rise_or_return(scene_problem: Problem, settings: SynthesisSettings) -> None:
    """BadInput if ``[synthesis]`` limits peaks of unit strokes and the motion has no rise or return."""
    peaks = [name for name in LAW_PEAKS if getattr(settings, name) is not None]
    if peaks and not any(stroke.kind in (RISE, RETURN) for stroke in scene_problem.programme.tool.strokes):
        what = "is for the unit stroke of rises and returns, and this motion has none: give [limits]"
        value = getattr(settings, peaks[0])
        raise BadInput([Mistake(scene_problem.file, f"synthesis.{peaks[0]}", value, what, bare=True)])


def _check_residual_vibration_applies(scene_problem: Problem, objective: Mapping[str, float]) -> None:
    """BadInput if residual vibration counts but the scene has no train, speed or dwell for it."""
    setup = scene_problem.setup
    key = "synthesis.minimise" if residual.RESIDUAL_TERM in objective else f"limits.{residual.RESIDUAL_TERM}"
    if residual.RESIDUAL_TERM not in objective and _residual_vibration_limit(scene_problem) is None:
        return
    speed = () if setup.omega is not None else ("cam.rpm",)
    frequency = () if setup.dynamics.natural_frequency is not None else ("follower.dynamics.natural_frequency",)
    what = None
    if speed or frequency:
        what = f"needs {', '.join((*speed, *frequency))}"
    elif residual.train_frequency_and_damping(setup) is None:
        what = "has no bound: the undamped train resonates, it vibrates a whole number of times in a turn"
    elif all(stroke.kind != DWELL for stroke in scene_problem.programme.tool.strokes):
        what = "needs a dwell"
    if what:
        raise BadInput([Mistake(scene_problem.file, key, residual.RESIDUAL_TERM, what, bare=True)])


def _residual_vibration_limit(scene_problem: Problem) -> float | None:
    """Largest residual vibration that the limits allow [mm or deg]; None if it is not limited."""
    return next((limit.bound for limit in scene_problem.limits if limit.name == residual.RESIDUAL_TERM), None)


def objective_weights(settings: SynthesisSettings) -> dict[str, float]:
    """Weight of each objective term, by its name."""
    return {settings.minimise: 1.0} if isinstance(settings.minimise, str) else dict(settings.minimise)


def _searched_or_own_size_range(scene_problem: Problem, objective: Mapping[str, float]) -> LowHigh:
    """Range of the cam radius [mm].

    It is that of [search]. Without one, it has no upper bound if the size is minimised; otherwise it ends at the
    scene's own size.
    """
    if "size" in scene_problem.search_space.variables:
        return _range_of_size(scene_problem, "size")
    own_size = float(scene_problem.design.size[0])
    if "size" in objective:
        return 0.0, inf
    if isnan(own_size):
        what = "missing; an objective other than the size needs the largest radius, there or in [search]"
        raise BadInput([Mistake(scene_problem.file, scene_problem.variables[0].key, None, what, bare=True)])
    return 0.0, own_size


def _require_partners(numbers: tuple[int, ...] | None, mistake: Mistake) -> tuple[int, ...]:
    """The number of each stroke's partner; BadInput if there are none."""
    if numbers is None:
        raise BadInput([mistake])
    return numbers


def _point_conditions(
    scene_problem: Problem, settings: SynthesisSettings, origin: DisplacementOrigin
) -> Iterator[Condition]:
    """The points through which the motion passes.

    Each point lies inside a stroke; in a rise or return, its displacement is between the ends of the stroke.
    """
    mistakes: list[Mistake] = []
    angles_taken: list[float] = []
    for number, (angle_deg, position) in enumerate(settings.points, start=1):
        angle, y = radians(angle_deg), (position - origin.zero) * origin.unit
        stroke = next((s for s in origin.strokes if s.start < angle < s.end and s.is_law_replaceable), None)
        key = f"synthesis.points.{number}"
        if stroke is None:
            what = "a cam angle inside a rise, return or move"
        elif not stroke.is_move and not min(stroke.low, stroke.high) <= y <= max(stroke.low, stroke.high):
            low, high = (origin.zero + end / origin.unit for end in (stroke.low, stroke.high))
            what = f"a displacement from {low:g} to {high:g} there"
        elif any(
            abs(angle - other) < LEAST_POINT_DISTANCE * stroke.angle
            for other in (*angles_taken, stroke.start, stroke.end)
        ):
            what = (
                f"at least {LEAST_POINT_DISTANCE:g} of the stroke's angle away from its ends and from other points"
            )
        else:
            yield Condition(key, 0, angle, angle, y, y)
            angles_taken.append(angle)
            continue
        mistakes.append(Mistake(scene_problem.file, key, [angle_deg, position], what))
    if mistakes:
        raise BadInput(mistakes)


def _range_of_size(scene_problem: Problem, field: str) -> LowHigh:
    """Least and largest value that the scene allows for a size [mm]."""
    own_value, variable = (
        float(scene_problem.design.sizes[field][0]),
        scene_problem.search_space.variables.get(field),
    )
    return (own_value, own_value) if variable is None else variable.range_ends


def _lead_range(scene_problem: Problem) -> LowHigh:
    """Least and largest lead e for the offsets that the scene allows, or change of the arm [mm]."""
    arm = scene_problem.search_space.variables.get("arm_length")
    if arm is not None:
        own_length = float(scene_problem.design.arm_length[0])
        if isnan(own_length):
            what = "missing; free laws start from this length, among those of [search]"
            raise BadInput([Mistake(scene_problem.file, arm.key, None, what, bare=True)])
        return arm.range_ends[0] - own_length, arm.range_ends[1] - own_length
    if not scene_problem.setup.mechanism.moves_as(translating.MECHANISM, translating_flat.MECHANISM):
        return 0.0, 0.0
    low, high = sorted(scene_problem.design.sense * e for e in _range_of_size(scene_problem, "offset"))
    return low, high


def _derivative_ranges_by_stroke(
    scene_problem: Problem, settings: SynthesisSettings, strokes: Sequence[Stroke], minimised: set[int]
) -> Iterator[dict[int, LowHigh]]:
    """The ranges of each stroke's derivatives, from [limits] and from the unit-stroke peaks of [synthesis].

    Derivatives that are minimised have no default range.
    """
    move_ranges = (
        _default_move_ranges(scene_problem, settings, minimised)
        if any(free_stroke.is_move and free_stroke.is_law_replaceable for free_stroke in strokes)
        else {}
    )
    peaks = {name: value for name in LAW_PEAKS if (value := getattr(settings, name)) is not None}
    peaks |= dict.fromkeys(_default_peak_names(scene_problem, settings, minimised), GENTLE_LAW)
    unit_ranges = {LAW_PEAKS[name]: _peak_range(scene_problem, name, value) for name, value in peaks.items()}
    for stroke in strokes:
        limits = _derivative_limits(scene_problem, stroke.kind)
        if stroke.kind == DWELL:
            yield {}
        elif stroke.is_move:
            yield limits | (move_ranges if stroke.is_law_replaceable else {})
        else:
            for order, unit_range in unit_ranges.items():
                scale, limit = (stroke.high - stroke.low) / stroke.angle**order, limits.get(order, (-inf, inf))
                low, high = sorted(end * scale for end in unit_range)
                limits[order] = max(low, limit[0]), min(high, limit[1])
            yield limits


def _derivative_limits(scene_problem: Problem, stroke_kind: int) -> dict[int, LowHigh]:
    """The ranges that [limits] set for derivatives, over strokes of one kind."""
    bounds: dict[int, LowHigh] = {}
    ratio = constant_tool_to_follower_ratio(scene_problem)
    for constraint in (
        constraint_with_tool_stroke_kinds(scene_problem, candidate)
        for candidate in scene_problem.constraints
        if is_linear(scene_problem, candidate)
    ):
        if isinstance(constraint.curve, MotionDerivative) and constraint.kinds & stroke_kind:
            order, largest = constraint.curve.order, constraint.upper_bound_of_each_side()
            largest *= abs(ratio) if ratio and constraint.curve.at_follower else 1.0
            bounds[order] = min(bounds.get(order, (-inf, inf)), (-largest, largest), key=lambda ends: ends[1])
    return bounds


def _default_move_ranges(
    scene_problem: Problem, settings: SynthesisSettings, minimised: set[int]
) -> dict[int, LowHigh]:
    """Default ranges of free moves for derivatives without a limit: a little above those of least jerk.

    The peaks of [synthesis] are for unit strokes and do not apply to moves.
    """
    strokes = [
        replace(stroke, named=False) if stroke.is_move else stroke
        for stroke in scene_problem.programme.tool.strokes
    ]
    least_jerk_moves = Programme(
        tuple(stroke for stroke in strokes_with_move_laws(tuple(strokes)) if stroke.is_move)
    )
    orders = (
        []
        if _has_acceleration_or_jerk_limits(scene_problem)
        else [order for order in PEAK_ORDERS.values() if order not in minimised]
    )
    orders = [order for order in orders if order <= settings.rest + 1]
    peak_ranges = {
        order: weighted_derivative_range(least_jerk_moves, (0.0,) * order + (1.0,), ALL_STROKES) for order in orders
    }
    largest = {order: MOVE_PEAK_FACTOR * max(-least, most) for order, (least, most) in peak_ranges.items()}
    return {order: (-peak, peak) for order, peak in largest.items() if peak > 0.0}


def _has_acceleration_or_jerk_limits(scene_problem: Problem) -> bool:
    """Whether [limits] bounds an acceleration or a jerk."""
    return any(
        isinstance(constraint.curve, MotionDerivative) and constraint.curve.order > 1
        for constraint in scene_problem.constraints
    )


def _default_peak_names(scene_problem: Problem, settings: SynthesisSettings, minimised: set[int]) -> list[str]:
    """The peaks that a gentle law limits by default, because the scene limits none of them."""
    if _has_acceleration_or_jerk_limits(scene_problem) or any(
        getattr(settings, name) is not None for name in PEAK_ORDERS
    ):
        return []
    return [name for name, order in PEAK_ORDERS.items() if order <= settings.rest + 1 and order not in minimised]


def default_peak_factors(scene: Scene, terms: Iterable[str] | None = None) -> dict[str, float]:
    """Default peak factors of free laws, for a scene that limits neither acceleration nor jerk.

    ``terms`` are the minimised terms, in place of the scene's objective.
    """
    objective = dict.fromkeys(terms, 1.0) if terms is not None else objective_weights(scene.synthesis)
    names = _default_peak_names(resolve(scene), scene.synthesis, _derivative_orders_in_objective(objective))
    return {name: float(law_peaks(LAWS[GENTLE_LAW])[name]) for name in names}


def _derivative_orders_in_objective(objective: Mapping[str, float]) -> set[int]:
    """The orders of the derivatives in an objective."""
    return {TERM_ORDERS[term] for name in objective if (term := name.removesuffix("_rms")) in TERM_ORDERS}


def _peak_range(scene_problem: Problem, name: str, value: float | str | tuple[float, float]) -> LowHigh:
    """The range of a derivative of the unit stroke, from a number (±), a range or the name of a known law."""
    if isinstance(value, tuple):
        return value
    if isinstance(value, str):
        peak = law_peaks(scene_problem.laws[value])[name]
        if not isinstance(peak, float) or peak == inf:
            what = f"a law whose {name.replace('_', ' ')} is finite, or a number"
            raise BadInput([Mistake(scene_problem.file, f"synthesis.{name}", value, what)])
        value = peak
    return -value, value
