"""Fit a motion to measured lift: from a file of points to a scene with the gentlest motion within a band."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, product
from math import inf, isfinite
from numbers import Real
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.mistakes import BadInput, Mistake, Unmet, Unsolved, escape_unprintable
from camopt.model.mechanisms.elements import BODIES, DISC, FLAT, OSCILLATING, ROLLER, TRANSLATING
from camopt.scene.arguments import SceneSource, allow_positional_options, scene_from
from camopt.scene.mapping import MOTION_AT_FOLLOWER, is_motion_given_at_follower, tables_in_list
from camopt.scene.problem.problem import resolve, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.train import tool_turns
from camopt.solve.measured.band_certificate import certify_band
from camopt.solve.measured.columns import MM_PER_UNIT, TableReadingOptions
from camopt.solve.measured.drawing_points import is_drawing
from camopt.solve.measured.fit_result import Fit
from camopt.solve.measured.least_jerk import (
    AllowedDeviation,
    LeastJerkCurve,
    OutlineMotion,
    OutlineNode,
    least_band_and_active_points,
    least_jerk_curve,
    least_jerk_motion,
    outline_nodes,
)
from camopt.solve.measured.measured_points import (
    TURN_DEG,
    MeasuredPoints,
    forward_angle_deg,
    read_points,
    shortened_list,
)
from camopt.solve.measured.noise import (
    LEAST_BAND,
    ErrorSize,
    estimate_point_errors,
    find_outliers,
    noise_band_factor,
    noise_from_neighbours,
)
from camopt.solve.measured.outline import ANGLE_DIGITS, LIKELY_DROP, find_outline_and_doubtful_dwells
from camopt.solve.measured.profile import FollowedProfile, MeasuredProfile, base_radius_at, follower_on_profile
from camopt.solve.measured.spline_chain import CHAIN_DEGREE

BAND_MARGINS = (1e-6, 1e-2)  # least and largest margin for rounding and solver error, as a share of the band
SOLVER_SHARE = 1e-8  # error of the solver in a limit, as a share of the range of the lifts
REPLACED_MOTION_KEYS = {
    "search": ("law", "law_rise", "law_return", "angle_rise", "angle_return", "angle_dwell"),
    "synthesis": ("points",),
}
"""Keys of tables that concern the motion, which a fit replaces."""
ABNORMAL_FACTOR = 1.5  # band over the largest error, if that error is larger than normal ones
CORNER_FACTOR = 3.5  # largest band over that of normal errors: a larger deviation is a corner
MOST_JERK_PRICE = 1.25  # jerk over the least jerk of any motion: above it, dwells or turns are likely wrong
MOST_OUTLINE_NODES = 60  # dwells and turns: more of them come from errors
PLACEHOLDER_MOTION = [
    {"segment": kind, "angle": 180.0, "lift": 1e-9, "law": "cycloidal"} for kind in ("rise", "return")
]
"""Motion of a cam whose own is not known yet: nearly at rest."""
FITTED_LAW = "measured"
LEVEL_DIGITS = 9  # decimals of lifts; levels have fewer


class FittedSegments(NamedTuple):
    """Tables of a motion; ``start`` [deg] and ``zero`` are the measured angle and lift at its 0 and 0."""

    motion: list[dict[str, Any]]
    laws: dict[str, dict[str, Any]]
    start: float
    zero: float


@allow_positional_options
def fit(  # noqa: PLR0913
    points: str | os.PathLike[str] | ArrayLike | MeasuredProfile,
    scene: SceneSource | Mapping[str, Any] | None = None,
    *,
    band: float | None = None,
    columns: Sequence[str | int] | None = None,
    angle_unit: str = "deg",
    lift_unit: str | None = None,
    turn: float | None = None,
    keep_outliers: bool = False,
    segments: Sequence[str] | None = None,
    rpm: float | None = None,
    base_radius: float | None = None,
    follower: str | None = None,
    roller_radius: float | None = None,
) -> Fit:
    """Find the gentlest motion that stays within a band of measured points.

    The motion turns back if points differ by more than two bands, and is monotone in between. It rests if the
    points of a stretch are within the band of a constant and a dwell makes them likelier. Each stroke is a quintic
    B-spline. The fit proves, in the numbers of the scene, that the motion is within the band at each point.

    The gentlest motion has the least mean-square jerk. If the root mean square of deviations is limited too, a
    quarter of the mean magnitude of the jerk is added, in units of the least root mean square of any motion. It
    levels peaks of the acceleration that errors raise.

    Parameters
    ----------
    points : str, os.PathLike, array_like or MeasuredProfile
        A file: text with any delimiter, decimal point or decimal comma, a workbook (``camopt[excel]``), a
        drawing of the profile (DXF), or a lobe as grinders exchange it (S96). It has
        columns of angle and lift, or lifts alone, in equal steps round the turn. Or an array of such rows. Or a
        table (pandas, polars, Arrow) or a mapping of columns, whose names count as those of a file. Or a series of
        pandas, whose index is the cam angle unless it only counts rows. Or a ``MeasuredProfile`` of any of these:
        the lift is then that of the scene's follower on this profile.
    scene : Scene, str, os.PathLike or Mapping, optional
        The cam, the follower and the limits of the motion; the scene's own motion is replaced. Or a mapping of the
        tables ``cam`` and ``follower``, without a motion. The options below give what is missing. A profile gives
        the base radius. With a train, lifts are the tool's, or the follower's if ``motion_at`` says so; those of a
        profile are the follower's.
    band : float, optional
        Largest deviation of the motion from a point, mm (deg when oscillating). It applies to the lift of a
        profile,
        too: along the profile's normal it is cos β times as wide. By default, the band and the root mean square of
        deviations are what errors reach in one of twenty files, by the noise that a smoothing spline leaves
        (generalised cross-validation). The band is up to 3.5 times that of normal errors if one error is larger. A
        narrower band limits the deviations further. A wider band limits them alone, without the root mean square.
    columns : sequence of str or int, optional
        Names or numbers (from 1) of the columns of angle and lift, angle and distance, or x and y, if the words
        above them do not say so.
    angle_unit : str, default "deg"
        "deg" or "rad".
    lift_unit : str, optional
        "mm" or "inch"; "deg" when oscillating. Of a profile, the unit of its lengths. By default that of the
        heading or drawing; else that of the system that is shown, and mm for arrays.
    turn : float, optional
        The angle of one turn of the cam in the file, such as 720 for degrees of a crankshaft that turns twice.
    keep_outliers : bool, default False
        Whether single points far from their neighbours must be within the band too. They are left out by default.
    segments : sequence of str, optional
        "rise", "return" and "dwell" in the order of the motion, from any place in the turn. They decide where it
        rests. Without them it rests if the points are likelier with a dwell.
    rpm : float, optional
        Speed of the cam, rev/min, in place of the scene's.
    base_radius : float, optional
        Base radius of the cam, mm, in place of the scene's; a profile has its own.
    follower : str, optional
        "flat", "roller" or "knife": a translating follower, without a scene; flat by default.
    roller_radius : float, optional
        Radius of the roller, mm, without a scene.

    Returns
    -------
    Fit
        The scene, its deviations from the points, noise and band, peaks before and after.

    Raises
    ------
    BadInput
        If the points are no lift over one turn, or no profile that the follower can run on, with the row; with
        every mistake of the scene.
    Unmet
        If no motion is within the band, with the rows that prevent it.
    Unsolved
        If the convex solver fails.
    OSError
        If a file cannot be read.

    References
    ----------
    C. de Boor, A Practical Guide to Splines, ch. IX, X and XIV.
    G. Wahba, Spline Models for Observational Data, ch. 4.

    Examples
    --------
    >>> lifts = [0.0] * 60 + [5.0 * k**3 * (20 - k) ** 3 / 1e6 for k in range(21)] + [0.0] * 39
    >>> cam = {"cam": {"form": "disc", "base_radius": 20}, "follower": {"motion": "translating", "contact": "flat"}}
    >>> fitted = camopt.fit(lifts, cam, band=0.01)
    >>> [segment.segment for segment in fitted.scene.motion]
    ['dwell', 'rise', 'return', 'dwell']
    >>> fitted.deviation.held
    True
    >>> camopt.fit(lifts, base_radius=20, rpm=300, band=0.01).scene.cam.rpm
    300.0
    """
    if is_drawing(points):
        points = MeasuredProfile(points)
    profile = points if isinstance(points, MeasuredProfile) else None
    numbers = {"rpm": rpm, "base_radius": base_radius}
    scene = complete_scene_from_options(scene, numbers, follower, roller_radius, of_profile=profile is not None)
    # the tables of the scene without its motion and the keys that concern it
    tables = scene.to_dict() if isinstance(scene, Scene) else dict(scene)
    tables = {key: value for key, value in tables.items() if key not in ("motion", "profile", "laws")}
    for name, keys in REPLACED_MOTION_KEYS.items():
        if isinstance(tables.get(name), Mapping):
            tables[name] = {key: value for key, value in tables[name].items() if key not in keys}
    _check_segments(segments)
    table_columns = TableReadingOptions(columns, angle_unit, _lift_unit(tables, lift_unit, profile), turn)
    measured = (
        read_points(points.points, points.with_profile_kind_and_layer(table_columns))
        if isinstance(points, MeasuredProfile)
        else read_points(points, table_columns)
    )
    measured = replace(measured, unit_said=measured.unit_said or lift_unit is not None)
    tables.setdefault("name", escape_unprintable(Path(measured.file).stem))
    file = scene.file if isinstance(scene, Scene) else "scene"
    if profile and tables.get("train"):
        tables["motion_at"] = MOTION_AT_FOLLOWER
    followed = follow_measured_profile(profile, measured, tables, file, keep_outliers) if profile else None
    measured = followed.positions if followed else measured
    narrowest = _least_band_for_lift_range(measured)
    if band is not None and not (isinstance(band, Real) and isfinite(band) and band >= narrowest):
        raise BadInput([Mistake("camopt", "band", band, f"at least {narrowest:.3g}, {LEAST_BAND:g} of the lift")])
    outlier_places = (
        followed.outlier_places
        if followed
        else []
        if keep_outliers
        else find_outliers(measured, noise_from_neighbours(measured), band or narrowest)
    )
    kept_points, left_out = measured.drop_places(outlier_places), measured.pick_places(outlier_places)
    errors = estimate_point_errors(kept_points)
    usual = _deviation_allowed_by_noise(kept_points, errors)
    allowed = usual
    if band is not None:  # a band wider than that of errors limits deviations alone
        allowed = AllowedDeviation(float(band)) if band >= usual.band else usual._replace(band=float(band))
    _check_repeated_angles(kept_points, allowed.band)
    fitted = _fit_gentlest_outline(
        kept_points,
        allowed,
        usual.band,
        max(errors.noise, narrowest / CORNER_FACTOR),
        segments,
        lambda parts: Scene.from_dict(tables | _fitted_tables(parts, tables, followed), file),
    )
    return replace(fitted, outliers=left_out, noise=errors.noise, usual=band is None, profile=followed)


def _fitted_tables(
    parts: FittedSegments, tables: Mapping[str, Any], followed: FollowedProfile | None
) -> dict[str, Any]:
    """Tables of a scene that a fit replaces: the motion, its laws, and the base radius of a profile."""
    motion = {"motion": parts.motion, "laws": parts.laws}
    if followed is None:
        return motion
    lowest = np.radians(parts.zero) if followed.problem.setup.angular else parts.zero
    radius = round(base_radius_at(followed.problem, lowest), LEVEL_DIGITS)
    return {**motion, "cam": {**tables["cam"], "base_radius": radius}}


def follow_measured_profile(
    profile: MeasuredProfile,
    points: MeasuredPoints,
    tables: Mapping[str, Any],
    file: str,
    keep_outliers: bool,
    gaps_anywhere: bool = False,
) -> FollowedProfile:
    """The follower of a scene at the points of a profile, before its motion is known."""
    profile.check(points)
    given_tables = {key: tables[key] for key in ("cam", "follower") if key in tables}
    complete_tables = {key: dict(table) for key, table in given_tables.items() if isinstance(table, Mapping)}
    form = complete_tables.get("cam", {}).get("form")
    if form in [*BODIES] and form != DISC.form:
        raise BadInput([Mistake(file, "cam.form", form, "disc: a measured profile needs a disc cam")])
    complete_tables.get("cam", {})["base_radius"] = float(points.lifts.min()) - profile.probe
    complete_tables.get("follower", {}).pop("dynamics", None)
    placeholder = {**given_tables, **complete_tables, "name": "", "motion": PLACEHOLDER_MOTION}
    problem = resolve_design(Scene.from_dict(placeholder, file))
    outlier_places = (
        []
        if keep_outliers
        else find_outliers(points, noise_from_neighbours(points), _least_band_for_lift_range(points))
    )
    kept_points = points.drop_places(outlier_places)
    allowed = _deviation_allowed_by_noise(kept_points, estimate_point_errors(kept_points))
    _check_repeated_angles(kept_points, allowed.band)
    return follower_on_profile(problem, profile, points, outlier_places, allowed, gaps_anywhere)


def complete_scene_from_options(
    scene: SceneSource | Mapping[str, Any] | None,
    cam_numbers: Mapping[str, float | None],
    follower: str | None,
    roller_radius: float | None,
    *,
    of_profile: bool,
) -> Scene | Mapping[str, Any]:
    """The cam and follower of a measured motion: a scene, or tables completed by options."""
    cam = {name: value for name, value in cam_numbers.items() if value is not None}
    options = {"follower": follower, "roller_radius": roller_radius}
    if of_profile and "base_radius" in cam:
        why = "belongs to lifts: the profile itself has a base radius"
        raise BadInput([Mistake("camopt", "base_radius", cam["base_radius"], why, bare=True)])
    if scene is not None and not isinstance(scene, Mapping):
        why = "belongs to a fit without a scene: the scene has a follower"
        unused_options = {name: value for name, value in options.items() if value is not None}
        if unused_options:
            raise BadInput(Mistake("camopt", name, value, why, bare=True) for name, value in unused_options.items())
        scene = scene_from(scene)
        return scene.replace(**{f"cam.{name}": value for name, value in cam.items()}) if cam else scene
    if scene is not None and not cam and not any(options.values()):
        return scene
    tables = dict(scene or {})
    own_tables = {
        name: tables[name] if isinstance(tables.get(name), Mapping) else {} for name in ("cam", "follower")
    }
    cam_table = {"form": DISC.form, **cam, **own_tables["cam"]}
    sizes = {} if roller_radius is None else {"roller_radius": roller_radius}
    follower_table = {
        "motion": TRANSLATING.name,
        "contact": follower or FLAT.name,
        **sizes,
        **own_tables["follower"],
    }
    if cam_table.get("base_radius") is None and not of_profile:
        raise BadInput([Mistake("camopt", "base_radius", None, "missing; give it or a scene", bare=True)])
    if follower_table["contact"] == ROLLER.name and follower_table.get("roller_radius") is None:
        raise BadInput([Mistake("camopt", "roller_radius", None, "missing; a roller follower needs it", bare=True)])
    return {**tables, "cam": cam_table, "follower": follower_table}


def _lift_unit(tables: Mapping[str, Any], given_unit: str | None, profile: MeasuredProfile | None) -> str | None:
    """Unit of the lifts or of a profile: the given one, or deg if the follower or tool turns."""
    follower = tables.get("follower")
    oscillates = isinstance(follower, Mapping) and follower.get("motion") == OSCILLATING.name
    stages = [] if is_motion_given_at_follower(tables) else tables_in_list(tables.get("train"))
    angular = tool_turns(stages, oscillates) and not profile
    units = ("deg",) if angular else tuple(MM_PER_UNIT)
    if given_unit is not None and given_unit not in units:
        owner = "a profile" if profile else f"{(OSCILLATING if angular else TRANSLATING).words} follower"
        if stages and not profile:  # the tool counts, not the follower
            owner = f"a tool that {'turns' if angular else 'slides'}"
        raise BadInput([Mistake("camopt", "lift_unit", given_unit, f"{' or '.join(units)} for {owner}")])
    return "deg" if angular else given_unit


def _least_band_for_lift_range(points: MeasuredPoints) -> float:
    """Least band of points, in the unit of the lifts."""
    return LEAST_BAND * float(np.ptp(points.lifts))


def _check_segments(segments: Sequence[str] | None) -> None:
    """BadInput unless segments are rises, returns and dwells, with a dwell between two of one kind."""
    if segments is None:
        return
    are_kinds = isinstance(segments, (list, tuple)) and all(
        segment in ("rise", "return", "dwell") for segment in segments
    )
    if not (are_kinds and {"rise", "return"} <= set(segments) and not any(a == b for a, b in pairwise(segments))):
        what = "rise, return and dwell in their order, with a dwell between two rises or two returns"
        shown = ",".join(map(str, segments)) if are_kinds and segments else segments
        raise BadInput([Mistake("camopt", "segments", shown, what)])


def _deviation_allowed_by_noise(points: MeasuredPoints, errors: ErrorSize) -> AllowedDeviation:
    """The deviation that normal errors reach in one file of twenty; more if one error is larger.

    It is at least what the digits of the lifts allow.
    """
    least, normal = _least_band_for_lift_range(points), errors.noise * noise_band_factor(points.rows.size)
    wide = min(ABNORMAL_FACTOR * errors.largest, CORNER_FACTOR * normal, float(np.ptp(points.lifts)) / 2.0 - least)
    return AllowedDeviation(max(wide if errors.largest > normal else normal, least), max(errors.rms, least))


def _check_repeated_angles(points: MeasuredPoints, band: float) -> None:
    """Unmet if lifts at one angle differ by more than two bands."""
    for place in np.flatnonzero(np.diff(points.angles) == 0.0):
        same = np.flatnonzero(points.angles == points.angles[place])
        low, high = same[points.lifts[same].argmin()], same[points.lifts[same].argmax()]
        difference = points.lifts[high] - points.lifts[low]
        if difference > 2.0 * band:
            rows = f"rows {points.rows[low]} and {points.rows[high]} are {difference:.4g} apart"
            least = f"a band below {difference / 2.0:.4g} cannot be held"
            raise Unmet(f"{points.file}: {rows}, both at {points.angles[place]:g} deg: {least}")


def _fit_gentlest_outline(
    points: MeasuredPoints,
    allowed: AllowedDeviation,
    usual_band: float,
    noise: float,
    segments: Sequence[str] | None,
    build_scene: Callable[[FittedSegments], Scene],
) -> Fit:
    """The fit with the dwells and turns of the outline, or else with more or with shorter dwells.

    It is the first fit that costs little jerk, or the one that costs least. If none is within the root mean square,
    only the band applies.

    Raises
    ------
    Unmet
        If no fit is within the band.
    Unsolved
        If the convex solver fails.
    """
    failure: tuple[Sequence[OutlineNode], AllowedDeviation, float] | None = None
    bands = [
        candidate
        for candidate in dict.fromkeys((usual_band, allowed.band))
        if 2.0 * max(candidate, allowed.band) < np.ptp(points.lifts)
    ]
    for tried in dict.fromkeys((allowed, AllowedDeviation(allowed.band))):
        least_jerk = least_jerk_curve(points, tried)
        fits: list[Fit] = []
        for band, drop in product(bands or [allowed.band], (LIKELY_DROP, 4.0 * LIKELY_DROP, 16.0 * LIKELY_DROP)):
            outline, doubts = find_outline_and_doubtful_dwells(
                points, band, max(band, allowed.band), noise, drop, segments
            )
            if len(outline) <= MOST_OUTLINE_NODES:
                nodes = outline_nodes(points, outline, least_jerk)
                if result := _certified_fit(points, nodes, tried, least_jerk, build_scene):
                    result = replace(result, doubts=doubts)
                    if result.price <= MOST_JERK_PRICE:
                        return result
                    fits.append(result)
                else:
                    failure = failure or (nodes, tried, least_jerk.rms_jerk)
        if fits:
            return min(fits, key=lambda candidate: candidate.price)
    if failure:
        raise _unmet_band_error(points, *failure)
    what = f"turns back by two bands of {allowed.band:.4g} more than {MOST_OUTLINE_NODES} times: give a wider band"
    raise Unmet(f"{points.file}: the lift {what}")


def _certified_fit(
    points: MeasuredPoints,
    nodes: Sequence[OutlineNode],
    allowed: AllowedDeviation,
    least_jerk: LeastJerkCurve,
    build_scene: Callable[[FittedSegments], Scene],
) -> Fit | None:
    """The fit whose scene is proved to be within the band; None if these nodes have none."""
    margin = max(BAND_MARGINS[0], SOLVER_SHARE / (allowed.band / float(np.ptp(points.lifts))))
    while margin <= BAND_MARGINS[1]:
        factor = 1.0 - margin
        reduced = AllowedDeviation(factor * allowed.band, None if allowed.rms is None else factor * allowed.rms)
        motion = least_jerk_motion(points, nodes, reduced, least_jerk.rms_jerk)
        if motion is None:
            return None
        parts = fitted_segments(motion)
        scene = build_scene(parts)
        deviation = certify_band(resolve(scene).given_motion, points, parts.start, parts.zero, allowed.band)
        if deviation.held:
            return Fit(
                scene,
                points,
                points.pick_places([]),
                parts.start,
                parts.zero,
                allowed.band,
                deviation,
                least_jerk.square,
            )
        margin *= 10.0
    return None


def _unmet_band_error(
    points: MeasuredPoints, nodes: Sequence[OutlineNode], allowed: AllowedDeviation, usual_jerk: float
) -> Exception:
    """The error for dwells and turns without a motion within the allowed deviation."""
    least, places = least_band_and_active_points(points, nodes, usual_jerk)
    if least < allowed.band:
        return Unsolved("the convex solver is not accurate enough for the band")
    rows = shortened_list(sorted(points.rows[places]))
    what = f"{points.file}: no motion with these dwells and turns is within {allowed.band:.4g} of all points"
    remedy = f"the least band is {least:.4g} (mm, or deg if the follower turns), because of rows {rows}"
    return Unmet(what if least == inf else f"{what}; {remedy}; give a wider band, such as {1.1 * least:.2g}")


def fitted_segments(outline_motion: OutlineMotion) -> FittedSegments:
    """The segments of a motion from its lowest point.

    They begin at angle 0 if the motion rests there, else at the end of the lowest dwell or turning point.
    """
    nodes, count = outline_motion.nodes, len(outline_motion.nodes)
    first = min(range(count), key=lambda k: (nodes[k].level, nodes[k].start - nodes[k].end))
    lowest, zero = nodes[first], nodes[first].level
    dwell_angle = _round_angle(lowest.end - lowest.start)
    angle_before_0 = float(forward_angle_deg(lowest.start, 0.0))  # from the start of the dwell to angle 0
    rests_at_0 = 0.0 < angle_before_0 < dwell_angle
    start = 0.0 if rests_at_0 else lowest.end % TURN_DEG
    motion: list[dict[str, Any]] = [_dwell_segment(dwell_angle - angle_before_0)] if rests_at_0 else []
    laws = {}
    for number in range(count):
        k, following = (first + number) % count, (first + number + 1) % count
        lift = nodes[following].level - nodes[k].level
        name = f"{FITTED_LAW}-{number + 1}"
        segment = "rise" if lift > 0.0 else "return"
        angle, lift = _round_angle(outline_motion.strokes[k].angle), round(abs(lift), LEVEL_DIGITS)
        motion.append({"segment": segment, "angle": angle, "lift": lift, "law": name})
        knots, coefficients = (
            outline_motion.strokes[k].chain.clamped_knot_vector.tolist(),
            outline_motion.coefficients[k].tolist(),
        )
        laws[name] = {"degree": CHAIN_DEGREE, "knots": knots, "coefficients": coefficients}
        if nodes[following].is_dwell:
            is_last = following == first
            length = nodes[following].end - nodes[following].start
            motion.append(_dwell_segment(angle_before_0 if is_last and rests_at_0 else length))
    return FittedSegments(motion, laws, start, zero)


def _dwell_segment(angle: float) -> dict[str, Any]:
    return {"segment": "dwell", "angle": _round_angle(angle)}


def _round_angle(angle: float) -> float:
    return float(np.round(angle, ANGLE_DIGITS))
