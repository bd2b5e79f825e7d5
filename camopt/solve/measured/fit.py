"""The front door of measured lift: from a file of points to a scene with the gentlest motion within a band."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, product
from math import inf, isfinite
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.mistakes import BadInput, Mistake, Unmet, Unsolved, printable
from camopt.model.mechanisms.elements import BODIES, DISC, FLAT, OSCILLATING, ROLLER, TRANSLATING
from camopt.scene.arguments import SceneSource, options_by_keyword, scene_from
from camopt.scene.mapping import MOTION_AT_FOLLOWER, given_at_follower
from camopt.scene.problem.problem import Problem, resolve, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.train import stages_in, tool_turns
from camopt.solve.measured.band_certificate import certify_band
from camopt.solve.measured.columns import LIFT_TABLE, MM_PER_UNIT, PROFILE_KINDS, TableColumns
from camopt.solve.measured.fit_result import Fit
from camopt.solve.measured.fitted_scene import LEVEL_DIGITS, FittedSegments, fitted_segments
from camopt.solve.measured.least_jerk import (
    AllowedDeviation,
    LeastJerkCurve,
    OutlineNode,
    least_band,
    least_jerk_curve,
    least_jerk_motion,
    outline_nodes,
)
from camopt.solve.measured.measured_points import MeasuredPoints, read_points
from camopt.solve.measured.noise import LEAST_BAND, ErrorSize, band_factor, find_outliers, point_errors, point_noise
from camopt.solve.measured.outline import LIKELY_DROP, read_outline
from camopt.solve.measured.profile import FollowedProfile, MeasuredProfile, follow_profile

BAND_MARGINS = (1e-6, 1e-2)  # of the band, the least and the largest, for rounding and a solver's error
SOLVER_SHARE = 1e-8  # of the range of the lifts: what a solver leaves of a limit
REPLACED_MOTION_KEYS = {
    "search": ("law", "law_rise", "law_return", "angle_rise", "angle_return", "angle_dwell"),
    "synthesis": ("points",),
}
"""Keys of tables that are about the motion which is replaced."""
ABNORMAL_FACTOR = 1.5  # times the largest error about, where it is no normal one: what the band is
CORNER_FACTOR = 3.5  # times the band of normal errors: further off is none of them, but a corner
MOST_JERK_PRICE = (
    1.25  # times the least jerk of all motions: what dwells and turns cost where they are not those measured
)
MOST_OUTLINE_NODES = 60  # dwells and turns: more are those of errors
MOST_ROWS_NAMED = 6  # rows at most
PLACEHOLDER_MOTION = [
    {"segment": kind, "angle": 180.0, "lift": 1e-9, "law": "cycloidal"} for kind in ("rise", "return")
]
"""The motion of a cam whose own is not known yet."""


@options_by_keyword
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

    The motion turns back where points differ by more than two bands, and goes one way in between. It rests where
    the points of a stretch are within the band of a constant and likelier with a dwell than without one. Each
    stroke is a quintic B-spline. That the band is held at each point is proved, in the numbers of the scene.

    The gentlest motion has the least mean-square jerk. Where the root mean square is limited too, a quarter of the
    mean magnitude of the jerk counts beside it, in units of the least root mean square of any motion: it levels
    peaks of the acceleration that errors raise.

    Parameters
    ----------
    points : str, os.PathLike, array_like or MeasuredProfile
        A file: text with any delimiter, decimal point or decimal comma, or a workbook (``camopt[excel]``). It has
        columns of angle and lift, or lifts alone, in equal steps round the turn. Or an array of such rows. Or a
        table (pandas, polars, Arrow) or a mapping of columns, whose names count as those of a file. Or a series of
        pandas, whose index is the cam angle unless it only counts rows. Or a ``MeasuredProfile`` of any of these:
        the lift is then that of the scene's follower on this profile.
    scene : Scene, str, os.PathLike or Mapping, optional
        The cam and the follower that the motion is for, and its limits, whose motion is replaced. Or a mapping of
        the tables ``cam`` and ``follower``, without a motion; the options below say what neither has. A profile
        gives the base radius, too. With a train lifts are the tool's, or the follower's if ``motion_at`` says so; a
        profile gives the follower's.
    band : float, optional
        How far the motion may be from a point, mm (deg when oscillating). It is a band of the lift of a profile,
        too: along the profile's normal it is cos β times as wide. If not given, both this and the root mean
        square are at most what the errors have in nineteen of twenty files, by the noise that the smoothing spline
        of generalised cross-validation leaves; the band is up to 3.5 times that of normal errors if one is larger.
        A narrower band limits the errors further; a wider one is room to use, and limits them alone.
    columns : sequence of str or int, optional
        Names or numbers (from 1) of the columns of angle and lift, angle and distance, or x and y, if the words
        above them do not say so.
    angle_unit : str, default "deg"
        "deg" or "rad".
    lift_unit : str, optional
        "mm" or "inch"; "deg" when oscillating. Of a profile, the unit of its lengths.
    turn : float, optional
        The angle of one turn of the cam in the file, such as 720 for degrees of a crankshaft that turns twice.
    keep_outliers : bool, default False
        Hold the band at single points too that are far off their neighbours, and which are left out otherwise.
    segments : sequence of str, optional
        "rise", "return" and "dwell" in the order of the motion, from anywhere in its turn. They decide where it
        rests. Without them it rests where the points are likelier with a dwell.
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
        If no motion holds the band, with the rows that stand in its way.
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
    profile = points if isinstance(points, MeasuredProfile) else None
    numbers = {"rpm": rpm, "base_radius": base_radius}
    scene = measured_cam(scene, numbers, follower, roller_radius, of_profile=profile is not None)
    # the tables of a scene but for its motion, and what is about that
    tables = scene.to_dict() if isinstance(scene, Scene) else dict(scene)
    tables = {key: value for key, value in tables.items() if key not in ("motion", "profile", "laws")}
    for name, keys in REPLACED_MOTION_KEYS.items():
        if isinstance(tables.get(name), Mapping):
            tables[name] = {key: value for key, value in tables[name].items() if key not in keys}
    _check_segments(segments)
    kind = PROFILE_KINDS[profile.form] if profile else LIFT_TABLE
    columns_ = TableColumns(columns, angle_unit, _lift_unit(tables, lift_unit, profile), turn, kind)
    measured = read_points(points.points if isinstance(points, MeasuredProfile) else points, columns_)
    measured = replace(measured, unit_said=measured.unit_said or lift_unit is not None)
    tables.setdefault("name", printable(Path(measured.file).stem))
    file = scene.file if isinstance(scene, Scene) else "scene"
    if profile and tables.get("train"):
        tables["motion_at"] = MOTION_AT_FOLLOWER
    seen = follow_measured_profile(profile, measured, tables, file, keep_outliers) if profile else None
    measured = seen.positions if seen else measured
    least = _narrowest_band(measured)
    # whether a band that is given can be one
    if band is not None and not (isinstance(band, Real) and isfinite(band) and band >= least):
        raise BadInput([Mistake("camopt", "band", band, f"at least {least:.3g}, {LEAST_BAND:g} of the lift")])
    lost = (
        seen.outlier_places
        if seen
        else []
        if keep_outliers
        else find_outliers(measured, point_noise(measured), band or least)
    )
    kept, left_out = measured.drop_places(lost), measured.pick_places(lost)
    errors = point_errors(kept)
    usual = _allowed_by_noise(kept, errors)
    room = usual if band is None else _allowed_by_band(float(band), usual)
    _check_repeats(kept, room.band)
    noise = max(errors.noise, least / CORNER_FACTOR)
    found = _fit_outlines(
        kept,
        room,
        usual.band,
        noise,
        segments,
        lambda parts: Scene.from_dict(tables | _fitted_tables(parts, tables, seen), file),
    )
    return replace(found, outliers=left_out, noise=errors.noise, usual=band is None, profile=seen)


def _fitted_tables(
    parts: FittedSegments, tables: Mapping[str, Any], seen: FollowedProfile | None
) -> dict[str, Any]:
    """What the tables of a scene have of a fit: the motion, its laws, and the base radius of a profile."""
    motion = {"motion": parts.motion, "laws": parts.laws}
    if seen is None:
        return motion
    radius = round(seen.base_radius(parts.zero), LEVEL_DIGITS)
    return {**motion, "cam": {**tables["cam"], "base_radius": radius}}


def _problem_at_rest(tables: Mapping[str, Any], radius: float, file: str) -> Problem:
    """The cam and follower of a profile before its motion is known, nearly at rest on its least radius, mm."""
    parts = {key: tables[key] for key in ("cam", "follower") if key in tables}
    whole = {key: dict(table) for key, table in parts.items() if isinstance(table, Mapping)}
    form = whole.get("cam", {}).get("form")
    if form in [*BODIES] and form != DISC.form:
        raise BadInput([Mistake(file, "cam.form", form, "disc: a profile is that of a disc cam")])
    whole.get("cam", {})["base_radius"] = radius
    whole.get("follower", {}).pop("dynamics", None)
    return resolve_design(Scene.from_dict({**parts, **whole, "name": "", "motion": PLACEHOLDER_MOTION}, file))


def follow_measured_profile(
    profile: MeasuredProfile,
    points: MeasuredPoints,
    tables: Mapping[str, Any],
    file: str,
    keep_outliers: bool,
    gaps_anywhere: bool = False,
) -> FollowedProfile:
    """The follower of a scene at the points of a profile."""
    profile.check(points)
    problem = _problem_at_rest(tables, float(points.lifts.min()) - profile.probe, file)
    lost = [] if keep_outliers else find_outliers(points, point_noise(points), _narrowest_band(points))
    kept = points.drop_places(lost)
    room = _allowed_by_noise(kept, point_errors(kept))
    _check_repeats(kept, room.band)
    return follow_profile(problem, profile, points, lost, room, gaps_anywhere)


def measured_cam(
    scene: SceneSource | Mapping[str, Any] | None,
    numbers: Mapping[str, float | None],
    follower: str | None,
    roller_radius: float | None,
    *,
    of_profile: bool,
) -> Scene | Mapping[str, Any]:
    """The cam and follower of a measured motion: a scene, or tables that options complete."""
    cam = {name: value for name, value in numbers.items() if value is not None}
    options = {"follower": follower, "roller_radius": roller_radius}
    if of_profile and "base_radius" in cam:
        why = "belongs to lifts: the profile itself has a base radius"
        raise BadInput([Mistake("camopt", "base_radius", cam["base_radius"], why, bare=True)])
    if scene is not None and not isinstance(scene, Mapping):
        why = "belongs to a fit without a scene: the scene has a follower"
        given = {name: value for name, value in options.items() if value is not None}
        if given:
            raise BadInput(Mistake("camopt", name, value, why, bare=True) for name, value in given.items())
        scene = scene_from(scene)
        return scene.replace(**{f"cam.{name}": value for name, value in cam.items()}) if cam else scene
    if scene is not None and not cam and not any(options.values()):
        return scene
    tables = dict(scene or {})
    own = {name: tables[name] if isinstance(tables.get(name), Mapping) else {} for name in ("cam", "follower")}
    known = {"form": DISC.form, **cam, **own["cam"]}
    sizes = {} if roller_radius is None else {"roller_radius": roller_radius}
    contact = {"motion": TRANSLATING.name, "contact": follower or FLAT.name, **sizes, **own["follower"]}
    if known.get("base_radius") is None and not of_profile:
        raise BadInput([Mistake("camopt", "base_radius", None, "missing; or name a scene", bare=True)])
    if contact["contact"] == ROLLER.name and contact.get("roller_radius") is None:
        raise BadInput([Mistake("camopt", "roller_radius", None, "missing; a roller has one", bare=True)])
    return {**tables, "cam": known, "follower": contact}


def _lift_unit(tables: Mapping[str, Any], given: str | None, profile: MeasuredProfile | None) -> str:
    """The unit of the lifts, or of a profile: that of the motion of follower or tool, or one that fits to it."""
    follower = tables.get("follower")
    swings = isinstance(follower, Mapping) and follower.get("motion") == OSCILLATING.name
    stages = [] if given_at_follower(tables) else stages_in(tables)
    angular = tool_turns(stages, swings) and not profile
    known = ("deg",) if angular else tuple(MM_PER_UNIT)
    if given is not None and given not in known:
        of = "a profile" if profile else f"{(OSCILLATING if angular else TRANSLATING).words} follower"
        if stages and not profile:  # whatever the follower does
            of = f"a tool that {'turns' if angular else 'slides'}"
        what = f"{' or '.join(known)} for {of}"
        raise BadInput([Mistake("camopt", "lift_unit", given, what)])
    return given or known[0]


def _narrowest_band(points: MeasuredPoints) -> float:
    """The least band of points."""
    return LEAST_BAND * float(np.ptp(points.lifts))


def _check_segments(segments: Sequence[str] | None) -> None:
    """Whether segments that are given are rises, returns and dwells, with a dwell between two of one kind."""
    if segments is None:
        return
    known = isinstance(segments, (list, tuple)) and all(each in ("rise", "return", "dwell") for each in segments)
    if not (known and {"rise", "return"} <= set(segments) and not any(a == b for a, b in pairwise(segments))):
        what = "rise, return and dwell in their order, with a dwell between two rises or two returns"
        shown = ",".join(map(str, segments)) if known and segments else segments
        raise BadInput([Mistake("camopt", "segments", shown, what)])


def _allowed_by_noise(points: MeasuredPoints, errors: ErrorSize) -> AllowedDeviation:
    """What normal errors leave in one file of twenty, and no less than numbers bear; more if one is larger."""
    least, normal = _narrowest_band(points), errors.noise * band_factor(points.rows.size)
    wide = min(ABNORMAL_FACTOR * errors.largest, CORNER_FACTOR * normal, float(np.ptp(points.lifts)) / 2.0 - least)
    band = wide if errors.largest > normal else normal
    return AllowedDeviation(max(band, least), max(errors.rms, least))


def _allowed_by_band(band: float, usual: AllowedDeviation) -> AllowedDeviation:
    """A band that is wider than errors take is room to use; a narrower one limits the errors further."""
    return AllowedDeviation(band) if band >= usual.band else usual._replace(band=band)


def _check_repeats(points: MeasuredPoints, band: float) -> None:
    """Whether lifts at one angle are within two bands of each other."""
    for place in np.flatnonzero(np.diff(points.angles) == 0.0):
        same = np.flatnonzero(points.angles == points.angles[place])
        low, high = same[points.lifts[same].argmin()], same[points.lifts[same].argmax()]
        apart = points.lifts[high] - points.lifts[low]
        if apart > 2.0 * band:
            rows = f"rows {points.rows[low]} and {points.rows[high]} are {apart:.4g} apart"
            least = f"a band below {apart / 2.0:.4g} cannot be held"
            raise Unmet(f"{points.file}: {rows}, both at {points.angles[place]:g} deg: {least}")


def _fit_outlines(
    points: MeasuredPoints,
    room: AllowedDeviation,
    usual: float,
    noise: float,
    segments: Sequence[str] | None,
    scene_with: Callable[[FittedSegments], Scene],
) -> Fit:
    """The fit with the dwells and turns that stand out from the noise, or else with more, or with shorter dwells.

    It is the first of these that costs little jerk, or the one that costs least. Where none of them is within the
    root mean square, the band alone is held.

    Raises
    ------
    Unmet
        If none of them holds the band.
    Unsolved
        If the convex solver fails.
    """
    refused: tuple[Sequence[OutlineNode], AllowedDeviation, float] | None = None
    bands = [
        each for each in dict.fromkeys((usual, room.band)) if 2.0 * max(each, room.band) < np.ptp(points.lifts)
    ]
    for within in dict.fromkeys((room, AllowedDeviation(room.band))):
        free = least_jerk_curve(points, within)
        found: list[Fit] = []
        for band, drop in product(bands or [room.band], (LIKELY_DROP, 4.0 * LIKELY_DROP, 16.0 * LIKELY_DROP)):
            outline, doubts = read_outline(points, band, max(band, room.band), noise, drop, segments)
            if len(outline) <= MOST_OUTLINE_NODES:
                nodes = outline_nodes(points, outline, free)
                if fitted := _certified_fit(points, nodes, within, free, scene_with):
                    fitted = replace(fitted, doubts=doubts)
                    if fitted.price <= MOST_JERK_PRICE:
                        return fitted
                    found.append(fitted)
                else:
                    refused = refused or (nodes, within, free.rms_jerk)
        if found:
            return min(found, key=lambda each: each.price)
    if refused:
        raise _band_error(points, *refused)
    what = f"turns back more than {MOST_OUTLINE_NODES} times by two bands of {room.band:.4g}: what is its noise?"
    raise Unmet(f"{points.file}: the lift {what}")


def _band_margins(band: float) -> Iterator[float]:
    """Margins of a band, as shares of it, tried until a motion lies within the whole band."""
    margin, most = max(BAND_MARGINS[0], SOLVER_SHARE / band), BAND_MARGINS[1]
    while margin <= most:
        yield margin
        margin *= 10.0


def _certified_fit(
    points: MeasuredPoints,
    nodes: Sequence[OutlineNode],
    room: AllowedDeviation,
    free: LeastJerkCurve,
    scene_with: Callable[[FittedSegments], Scene],
) -> Fit | None:
    """The fit whose scene, as it is written, is proved to hold the band; None if none of these nodes does."""
    for margin in _band_margins(room.band / float(np.ptp(points.lifts))):
        motion = least_jerk_motion(points, nodes, room.reduce_by(margin), free.rms_jerk)
        if motion is None:
            return None
        parts = fitted_segments(motion)
        scene = scene_with(parts)
        found = certify_band(resolve(scene).given_motion, points, parts.start, parts.zero, room.band)
        if found.held:
            return Fit(
                scene, points, points.pick_places([]), parts.start, parts.zero, room.band, found, free.square
            )
    return None


def _band_error(
    points: MeasuredPoints, nodes: Sequence[OutlineNode], room: AllowedDeviation, jerk: float
) -> Exception:
    """Why no motion of these dwells and turns is within a room."""
    least, places = least_band(points, nodes, jerk)
    if least < room.band:
        return Unsolved("the convex solver holds the band not closely enough")
    rows = ", ".join(map(str, sorted(points.rows[places])[:MOST_ROWS_NAMED])) + (
        " and others" if len(places) > MOST_ROWS_NAMED else ""
    )
    what = f"{points.file}: no motion with its dwells and turns is within {room.band:.4g} of all points"
    return Unmet(what if least == inf else f"{what}; {least:.4g} can be held; rows {rows} stand in the way")
