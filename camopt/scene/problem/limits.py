"""Limits of a scene, and the quantity that each key of ``[limits]`` bounds."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from math import inf, pi
from typing import Any

from camopt.core.numerics import LEAST
from camopt.core.quantities import BOUNDED, DERIVATIVES, motion_quantity
from camopt.core.quantities.limit_keys import ERROR_KEYS, LIMIT_KEYS, LOAD_KEYS, PART_KEYS
from camopt.model.effects import Setup, effect_of, force, hertz, offered, outline, rib, wall
from camopt.model.effects.contacts import peaks_at
from camopt.model.effects.curvature import CONVEX, CUTTER
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import Peak
from camopt.model.effects.train_peak import TrainPeak
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RISE
from camopt.scene.problem.claims import Claim, Plain
from camopt.scene.problem.limit import (
    NO_RIB,
    PIVOT_IN_CAM,
    SELF_CROSSING,
    UNDERCUT,
    Limit,
    OwnLimit,
    QuantityLimit,
    SelfCrossing,
    WithinBase,
)
from camopt.scene.scene import Scene

NO_FORCE = 1e-9  # N: less than nothing by so much is rounding
THINNEST = 1e-12  # of the base radius: the wall that a keyway or bore leaves, since a scene has to have one
LOAD_LIMITS, PART_LIMITS, ERROR_LIMITS = (
    {each.key: each.quantity for each in keys} for keys in (LOAD_KEYS, PART_KEYS, ERROR_KEYS)
)
"""Short keys of limits on loads, on the part, and on errors by tolerances: the quantity that each bounds."""
OF_QUANTITIES = LOAD_LIMITS | PART_LIMITS | ERROR_LIMITS | {name: name for name in BOUNDED}
"""All keys that bound just one quantity from one side."""


def limited_quantity(key: str, setup: Setup) -> str:
    """The quantity that a key of ``[limits]`` bounds: of a short key its quantity, else the key.

    By a short key, a quantity of the motion is that of an angle where what is asked to move, turns.
    """
    short = LIMIT_KEYS.get(key)
    return short.quantity_of(turns=setup.tool_turns) if short and short.quantity else key


def peaks_of(quantity: str, setup: Setup) -> tuple[Peak, ...]:
    """The peak behind a quantity, at each contact of the follower; none if it is no extreme of curves."""
    return tuple(peaks_at(effect_of(quantity, setup), setup, quantity))


def peak_of(quantity: str, setup: Setup) -> Peak | None:
    """The peak behind a quantity, at the first contact; None if it is no extreme of curves."""
    return next(iter(peaks_of(quantity, setup)), None)


def other_form_of(quantity: str, setup: Setup) -> Mean | TrainPeak | None:
    """The mean behind a quantity, or the peak of a train; None if it is neither."""
    effect = effect_of(quantity, setup)
    return effect.means(setup).get(quantity) or effect.train_peaks(setup).get(quantity)


def bound_on(name: str, bound: float, setup: Setup, *quantities: str) -> QuantityLimit:
    """The limit by which a quantity, or the largest magnitude of several, is bounded."""
    peaks = peaks_of(quantities[0], setup)
    form = peaks[0] if peaks else other_form_of(quantities[0], setup)
    others = tuple(_of_jump(quantities[0], bound, setup))
    return QuantityLimit(name, bound, setup, quantities=quantities, form=form, others=others, further=peaks[1:])


def _of_jump(quantity: str, bound: float, setup: Setup) -> Iterator[Claim]:
    """A jump speed for designs with numbers of their own: contact is kept at that speed."""
    speeds: dict[str, Callable[[Setup], Any]] = {
        "jump_speed_rpm": lambda own: bound * pi / 30,
        "jump_speed_ratio": lambda own: bound * own.omega,
    }
    if setup.free and quantity in speeds:
        yield Claim(
            partial(force.force_at_speed, setup, speed=speeds[quantity]), ALL_STROKES, LEAST, Plain(-NO_FORCE)
        )


def _implied(setup: Setup) -> list[Limit]:
    """The limits of every cam: no undercut or self-crossing, room for shaft, hub and pivot, within its edge, a rib.

    Without undercut, only a round body can make a profile that crosses itself.
    """
    limits: list[Limit] = []
    if not setup.is_knife:
        limits.append(replace(bound_on(UNDERCUT, 0.0, setup, CONVEX), asked=False))
    if setup.mechanism.ribbed:
        limits.append(replace(bound_on(NO_RIB, 0.0, setup, rib.THICKNESS), asked=False))
    if outline.CLEARANCE in offered(setup):
        limits.append(replace(bound_on(PIVOT_IN_CAM, 0.0, setup, outline.CLEARANCE), asked=False))
    limits += _within_base(setup)
    if setup.solid.outer_diameter is not None and setup.mechanism.outline is not None:
        edge = bound_on("outer_diameter", setup.solid.outer_diameter / 2.0, setup, outline.RADIUS)
        limits.append(replace(edge, given_by="part.outer_diameter"))
    if not setup.mechanism.flat_faced and setup.mechanism.body.closed and not setup.is_knife:
        limits.append(SelfCrossing(SELF_CROSSING, 0.0, setup, asked=False))
    return limits


def _within_base(setup: Setup) -> Iterator[WithinBase]:
    """The circles within the base circle: the shaft, the hub, and the bore with its thinnest wall."""
    bore = "keyway" if setup.solid.keyway_width else "bore"
    around = wall.size_for_wall(setup, 0.0) * (1.0 + THINNEST)
    shaft = setup.shaft_radius or 0.0
    for name, radius, key in (
        ("shaft_diameter", shaft, "cam.shaft_diameter"),
        ("hub_diameter", setup.solid.hub_radius, "part.hub_diameter"),
        (bore, around if setup.solid.bore_reach > shaft else 0.0, ""),
    ):
        if radius:
            yield WithinBase(name, 2 * radius, setup, asked=bool(key), given_by=key)


def pressure_limits(setup: Setup, on_rise: float | None, on_return: float | None) -> Iterator[Limit]:
    """The limits on the pressure angle in deg: one of rises and dwells, one of returns alone."""
    rises, dwells, returns = (f"pressure_angle_max_{kind}_deg" for kind in ("rise", "dwell", "return"))
    if on_rise is not None and peak_of(rises, setup):
        limit = bound_on("pressure_angle", on_rise, setup, rises, dwells)
        yield limit.about(lambda peak: peak.over(RISE | DWELL))
    if on_return is not None:
        yield bound_on("pressure_angle_return", on_return, setup, returns)


def _face_reach(bound: float, setup: Setup) -> Iterator[Limit]:
    """The reach along a flat face, to either side."""
    ends = ("face_reach_max_mm", "face_reach_min_mm")
    if peak_of(ends[0], setup) is not None:
        yield bound_on("face_reach", bound, setup, *ends).about(Peak.either_way)


def limits_of(scene: Scene, setup: Setup) -> tuple[Limit, ...]:
    """The limits of a scene with those of every cam; limits that are checked last are at the end."""
    asked, mechanism = scene.limits, setup.mechanism
    named = asked.given

    def of(quantities: Mapping[str, str]) -> list[Limit]:
        return [bound_on(key, named[key], setup, name) for key, name in quantities.items() if key in named]

    limits: list[Limit] = of(
        {each: motion_quantity(each, "", angular=setup.tool_turns, timed=True) for each in DERIVATIVES}
    )
    on_return = asked.pressure_angle if asked.pressure_angle_return is None else asked.pressure_angle_return
    for limit in pressure_limits(setup, asked.pressure_angle, on_return):
        limits.append(limit if limit.name in named else replace(limit, given_by="limits.pressure_angle"))
    limits += [] if asked.face_reach is None else _face_reach(asked.face_reach, setup)
    limits += of({"outer_radius": outline.RADIUS} if mechanism.outline is not None else {})
    limits += of({"curvature_radius": CONVEX})
    limits += of({"cutter_radius": CUTTER} if not (mechanism.flat_faced or mechanism.cut_as_by_roller) else {})
    limits += of({key: limited_quantity(key, setup) for key in (*PART_LIMITS, *ERROR_LIMITS)})
    limits += of({name: name for name in named if name in BOUNDED and name not in LOAD_LIMITS})
    limits += _implied(setup)
    limits += of({key: limited_quantity(key, setup) for key in LOAD_LIMITS})
    for name in setup.own:
        if name in named or name in scene.search.objectives:
            limits.append(OwnLimit(name, named.get(name, inf), setup, asked=name in named))
    return tuple(sorted(limits, key=lambda limit: limit.last))


TO_BUILD = {
    "pressure_angle": "pressure_angle_max_deg",
    "curvature_radius": CONVEX,
    "contact_stress": hertz.STRESS,
    "hub_wall": wall.WALL,
    rib.THICKNESS: rib.THICKNESS,
}
"""Limits that make a cam one to build, each with its quantity."""


def unset_limits(limits: Iterable[Limit], setup: Setup) -> list[str]:
    """Those of ``TO_BUILD`` that are not among some limits of a scene, and that can hold its cam."""
    flat = setup.mechanism.flat_faced and not setup.angular  # then the pressure angle is 0
    out = {limit.name for limit in limits} | ({"pressure_angle"} if flat else set())
    return [key for key, name in TO_BUILD.items() if name in offered(setup) and key not in out]
