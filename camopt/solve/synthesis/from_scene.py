"""The demand of a scene on new motion laws, from its limits, ``[synthesis]`` and ranges of sizes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, isnan, radians

from camopt.core.mistakes import BadInput, Mistake, Unmet
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import translating, translating_flat
from camopt.model.motion import LAWS
from camopt.model.motion.joints import with_moves
from camopt.model.motion.programme import PEAKS, Programme, law_peaks, span
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE, Condition, Stroke
from camopt.scene.mapping import FOLLOWER
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.settings import given_profile
from camopt.scene.problem.variables import not_varied
from camopt.scene.scene import Scene
from camopt.scene.synthesis import SynthesisSettings
from camopt.solve.smallest.closed_form import least_size
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.conditions import Ground, conditions_of, ground_of
from camopt.solve.synthesis.crossing_jerk import check_crossings
from camopt.solve.synthesis.demand import CROSSING_JERK, TERM_ORDERS, Demand, LowHigh, roller_of
from camopt.solve.synthesis.linear_constraints import floors_of, is_linear, means_of
from camopt.solve.synthesis.splines import Splines
from camopt.solve.synthesis.symmetry import mirrored, opposed
from camopt.solve.synthesis.through_train import about_tool, ratio_of, turned

PEAK_ORDERS = {"peak_acceleration": 2, "peak_jerk": 3}
LEAST_DISTANCE = 1e-4  # of a stroke: the least distance of points
AMPLE_FACTOR = 1.25  # times what a scene's own moves have of what it limits nowhere
GENTLE = "poly345"  # whose peaks hold where a scene limits neither acceleration nor jerk


def demand_of(scene: Scene, objective: Mapping[str, float] | None = None) -> Demand:
    """The demand of a scene, with its own objective or another.

    Raises
    ------
    BadInput
        If a point or a size cannot be met by any law.
    """
    return demand_on(resolve(scene), scene.synthesis, objective)


def demand_on(problem: Problem, asked: SynthesisSettings, objective: Mapping[str, float] | None = None) -> Demand:
    """As ``demand_of``, of a scene already resolved and its ``[synthesis]``."""
    objective = objective_in(asked) if objective is None else dict(objective)
    _check_rest(problem, asked, objective)
    _check_peaks(problem, asked)
    _check_train(problem, objective)
    if CROSSING_JERK in objective:
        check_crossings(problem)
    if given := given_profile(problem, "the motion"):
        raise BadInput(given)
    if problem.programme.given_at_follower:
        why = "free laws behind a train are the tool's: leave it out"
        raise BadInput([Mistake(problem.file, "motion_at", FOLLOWER, why, bare=True)])
    choices = problem.choices
    if freed := not_varied(problem.file, [*choices.angles, *choices.numbers], "free laws take"):
        raise BadInput(freed)
    if not any(stroke.is_free for stroke in problem.programme.tool.strokes):
        why = "has nothing to choose: it needs a rise, a return or a move"
        raise BadInput([Mistake(problem.file, "motion", None, why, bare=True)])
    ground = ground_of(problem)
    # the lowest position of a follower behind a train has to be known, whatever the free laws are
    moves = any(stroke.is_move and stroke.is_free for stroke in ground.strokes)
    if problem.setup.train is not None and moves and (ground.dip is not None or turned(problem)):
        reason = "free moves through a train need a lowest position of the follower that the motion gives"
        raise BadInput([Mistake(problem.file, "train", None, reason, bare=True)])
    strokes, body = ground.strokes, _body(problem)
    roller = roller_of(problem, body)
    size = _size(problem, objective)
    least = least_size(problem, {"size": size})
    # limits that leave no size, whatever the motion is
    limits = [limit for limit in problem.limits if limit.least_size > size[1] or limit.most_size < least]
    if limits:
        names = ", ".join(limit.name for limit in limits)
        raise Unmet(f"no motion: a cam of no size is within the limits ({names})")
    return Demand(
        problem=problem,
        splines=Splines(
            asked.degree, asked.pieces, asked.degree - 1 if asked.continuity is None else asked.continuity
        ),
        strokes=strokes,
        zero=ground.zero,
        dip=ground.dip,
        lead=_lead(problem),
        prime=(least + roller, size[1] + roller),
        body=body,
        ranges=tuple(_ranges(problem, asked, strokes, _orders(objective))),
        floors=tuple(floors_of(problem)),
        means=tuple(means_of(problem)),
        residual=_residual(problem),
        rest=asked.rest,
        monotone=asked.monotone or (isinstance(asked.peak_velocity, tuple) and asked.peak_velocity[0] == 0.0),
        conditions=(*conditions_of(ground), *_points(problem, asked, ground)),
        objective=objective,
        mirror=_mirror(problem, ground) if asked.symmetric else None,
        opposite=_opposite(problem, ground) if problem.setup.mechanism.drive.one_disc else None,
        window=radians(asked.crossing_window),
        smooth=asked.smooth,
    )


def by_offset(demand: Demand) -> list[Demand]:
    """The demand for each offset that a scene lists: between them there is no cam."""
    offset = demand.problem.choices.variables.get("offset")
    if offset is None or offset.is_free:
        return [demand]
    leads = [demand.problem.design.sense * each for each in offset.listed.tolist()]
    return [replace(demand, lead=(lead, lead)) for lead in leads]


def _check_rest(problem: Problem, asked: SynthesisSettings, objective: Mapping[str, float]) -> None:
    """A bounded or minimised jerk needs an acceleration that does not jump."""
    limited = any(isinstance(claim.curve, Derivative) and claim.curve.order == 3 for claim in problem.claims)
    bounded = limited or asked.peak_jerk is not None
    if asked.rest == 1 and (bounded or 3 in _orders(objective) or CROSSING_JERK in objective):
        what = "at least 2 where the jerk is limited or minimised: the acceleration may not jump then"
        raise BadInput([Mistake(problem.file, "synthesis.rest", asked.rest, what)])


def _check_peaks(problem: Problem, asked: SynthesisSettings) -> None:
    """The peaks of [synthesis] are for unit strokes."""
    given = [name for name in PEAKS if getattr(asked, name) is not None]
    if given and not any(stroke.kind in (RISE, RETURN) for stroke in problem.programme.tool.strokes):
        what = "is for the unit stroke of rises and returns, and this motion has none: give [limits]"
        key, value = f"synthesis.{given[0]}", getattr(asked, given[0])
        raise BadInput([Mistake(problem.file, key, value, what, bare=True)])


def _check_train(problem: Problem, objective: Mapping[str, float]) -> None:
    """A residual vibration is that of a train, at a speed, in a dwell."""
    setup = problem.setup
    key = "synthesis.minimise" if residual.TERM in objective else f"limits.{residual.TERM}"
    if residual.TERM not in objective and _residual(problem) is None:
        return
    speed = () if setup.omega is not None else ("cam.rpm",)
    train = () if setup.dynamics.natural_frequency is not None else ("follower.dynamics.natural_frequency",)
    what = None
    if speed or train:
        what = f"needs {', '.join((*speed, *train))}"
    elif residual.train_of(setup) is None:
        what = "has no bound: the undamped train resonates, it vibrates a whole number of times in a turn"
    elif all(stroke.kind != DWELL for stroke in problem.programme.tool.strokes):
        what = "needs a dwell"
    if what:
        raise BadInput([Mistake(problem.file, key, residual.TERM, what, bare=True)])


def _residual(problem: Problem) -> float | None:
    """The largest residual vibration that a limit allows, mm or deg."""
    return next((limit.bound for limit in problem.limits if limit.name == residual.TERM), None)


def objective_in(asked: SynthesisSettings) -> dict[str, float]:
    return {asked.minimise: 1.0} if isinstance(asked.minimise, str) else dict(asked.minimise)


def _size(problem: Problem, objective: Mapping[str, float]) -> LowHigh:
    """The range of the cam's radius: that of [search], or up to the scene's own where the objective is another."""
    if "size" in problem.choices.variables:
        return _ends(problem, "size")
    own = float(problem.design.size[0])
    if "size" in objective:
        return 0.0, inf
    if isnan(own):
        what = "missing; an objective other than the size needs the largest radius, there or in [search]"
        raise BadInput([Mistake(problem.file, problem.variables[0].key, None, what, bare=True)])
    return 0.0, own


def _mirror(problem: Problem, ground: Ground) -> tuple[int, ...]:
    """Which stroke mirrors which."""
    places = mirrored(ground.strokes)
    if places is None:
        what = "the segments are no mirror image of themselves, about whatever cam angle"
        raise BadInput([Mistake(problem.file, "synthesis.symmetric", True, what, bare=True)])
    return places


def _opposite(problem: Problem, ground: Ground) -> tuple[int, ...]:
    """Which stroke comes half a turn after which, where a yoke has both its contacts on one disc."""
    places = opposed(ground.strokes)
    if places is None:
        what = "the segments of the second half of the turn are not those of the first one, with rises for returns"
        raise BadInput([Mistake(problem.file, "motion", None, what, bare=True)])
    return places


def _points(problem: Problem, asked: SynthesisSettings, ground: Ground) -> Iterator[Condition]:
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
        elif any(abs(angle - a) < LEAST_DISTANCE * stroke.angle for a in (*taken, stroke.start, stroke.end)):
            what = f"at least {LEAST_DISTANCE:g} of the stroke's angle away from its ends and from other points"
        else:
            yield Condition(key, 0, angle, angle, y, y)
            taken.append(angle)
            continue
        mistakes.append(Mistake(problem.file, key, [given_angle, given], what))
    if mistakes:
        raise BadInput(mistakes)


def _body(problem: Problem) -> float:
    """The largest radius of the roller or spherical face; 0 for what has none."""
    own = float(problem.design.roller_radius[0])
    if problem.setup.is_knife or problem.setup.mechanism.flat_faced:
        return own
    return _ends(problem, "roller_radius")[1]


def _ends(problem: Problem, field: str) -> LowHigh:
    """The least and the largest value of a size that a scene allows."""
    own, searched = float(problem.design.sizes[field][0]), problem.choices.variables.get(field)
    return (own, own) if searched is None else searched.ends


def _lead(problem: Problem) -> LowHigh:
    """e, within the offsets that the scene allows."""
    if not problem.setup.mechanism.moves_as(translating.MECHANISM, translating_flat.MECHANISM):
        return 0.0, 0.0
    low, high = sorted(problem.design.sense * e for e in _ends(problem, "offset"))
    return low, high


def _ranges(
    problem: Problem, asked: SynthesisSettings, strokes: Sequence[Stroke], minimised: set[int]
) -> Iterator[dict[int, LowHigh]]:
    """The ranges of each stroke's derivatives: what [limits] say of the turn and [synthesis] of unit strokes.

    Derivatives that are minimised have none but these.
    """
    of_moves = _own_peaks(problem, asked, minimised) if any(s.is_move and s.is_free for s in strokes) else {}
    peaks = {name: value for name in PEAKS if (value := getattr(asked, name)) is not None}
    peaks |= dict.fromkeys(_unasked(problem, asked, minimised), GENTLE)
    of_unit = {PEAKS[name]: _peak(problem, name, value) for name, value in peaks.items()}
    for stroke in strokes:
        limits = _limits(problem, stroke.kind)
        if stroke.kind == DWELL:
            yield {}
        elif stroke.is_move:
            yield limits | (of_moves if stroke.is_free else {})
        else:
            yield _within_both(limits, of_unit, stroke)


def _limits(problem: Problem, kind: int) -> dict[int, LowHigh]:
    """The ranges that [limits] give to derivatives over strokes of a kind."""
    bounds: dict[int, LowHigh] = {}
    ratio = ratio_of(problem)
    for claim in (about_tool(problem, each) for each in problem.claims if is_linear(problem, each)):
        if isinstance(claim.curve, Derivative) and claim.kinds & kind:
            order, largest = claim.curve.order, claim.allowed()
            largest *= abs(ratio) if ratio and claim.curve.at_follower else 1.0
            bounds[order] = min(bounds.get(order, (-inf, inf)), (-largest, largest), key=lambda ends: ends[1])
    return bounds


def _within_both(limits: dict[int, LowHigh], of_unit: dict[int, LowHigh], stroke: Stroke) -> dict[int, LowHigh]:
    """The ranges of a rise or return: within those of the turn, and those of its unit stroke."""
    found = dict(limits)
    for order, ends in of_unit.items():
        per = (stroke.high - stroke.low) / stroke.angle**order
        low, high = sorted(end * per for end in ends)
        before = limits.get(order, (-inf, inf))
        found[order] = max(low, before[0]), min(high, before[1])
    return found


def _own_peaks(problem: Problem, asked: SynthesisSettings, minimised: set[int]) -> dict[int, LowHigh]:
    """What moves hold of derivatives that [limits] bound nowhere: little more than those of least jerk have.

    The peaks of [synthesis] are those of unit strokes, and not about moves.
    """
    freed = [
        replace(stroke, named=False) if stroke.is_move else stroke for stroke in problem.programme.tool.strokes
    ]
    own = Programme(tuple(stroke for stroke in with_moves(freed) if stroke.is_move))
    orders = [] if _bounded(problem) else [order for order in PEAK_ORDERS.values() if order not in minimised]
    orders = [order for order in orders if order <= asked.rest + 1]
    spans = {order: span(own, (0.0,) * order + (1.0,), ALL_STROKES) for order in orders}
    largest = {order: max(-least, most) for order, (least, most) in spans.items()}
    return {order: (-AMPLE_FACTOR * most, AMPLE_FACTOR * most) for order, most in largest.items() if most > 0.0}


def _bounded(problem: Problem) -> bool:
    """Whether [limits] bound an acceleration or a jerk."""
    return any(isinstance(claim.curve, Derivative) and claim.curve.order > 1 for claim in problem.claims)


def _unasked(problem: Problem, asked: SynthesisSettings, minimised: set[int]) -> list[str]:
    """The peaks that are held to those of a gentle law, because the scene bounds none of them."""
    if _bounded(problem) or any(getattr(asked, name) is not None for name in PEAK_ORDERS):
        return []
    return [name for name, order in PEAK_ORDERS.items() if order <= asked.rest + 1 and order not in minimised]


def default_peaks(scene: Scene, terms: Iterable[str] | None = None) -> dict[str, float]:
    """The peak factors that free laws hold by default, where the scene bounds neither acceleration nor jerk.

    ``terms`` are what is minimised, if not the objective of the scene.
    """
    objective = dict.fromkeys(terms, 1.0) if terms is not None else objective_in(scene.synthesis)
    names = _unasked(resolve(scene), scene.synthesis, _orders(objective))
    return {name: float(law_peaks(LAWS[GENTLE])[name]) for name in names}


def _orders(objective: Mapping[str, float]) -> set[int]:
    """The orders of the derivatives that an objective has."""
    return {TERM_ORDERS[term] for name in objective if (term := name.removesuffix("_rms")) in TERM_ORDERS}


def _peak(problem: Problem, name: str, value: float | str | tuple[float, float]) -> LowHigh:
    """The range of a derivative of the unit stroke: ± a number, a range, or what a known law has."""
    if isinstance(value, tuple):
        return value
    if isinstance(value, str):
        found = law_peaks(problem.laws[value])[name]
        if not isinstance(found, float) or found == inf:
            what = f"a law whose {name.replace('_', ' ')} is finite, or a number"
            raise BadInput([Mistake(problem.file, f"synthesis.{name}", value, what)])
        value = found
    return -value, value
