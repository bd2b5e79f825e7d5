"""The limits of a scene, from its keys and from what every cam must meet."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from math import inf, pi
from typing import Any

from camopt.core.numerics import LEAST
from camopt.core.quantities import BOUNDED_QUANTITIES, DERIVATIVE_UNITS, motion_peak_name
from camopt.core.quantities.limit_keys import ERROR_KEYS, LIMIT_KEYS, LOAD_KEYS, PART_KEYS
from camopt.model.effects import (
    Setup,
    available_quantities,
    bore_wall_thickness,
    force,
    hertz,
    outline,
    require_effect,
    rib,
)
from camopt.model.effects.contacts import contact_peaks
from camopt.model.effects.curvature import CONVEX_RADIUS, CUTTER_RADIUS
from camopt.model.effects.peak import Peak
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RISE
from camopt.scene.problem.constraints import ConstantBound, Constraint
from camopt.scene.problem.limit import (
    NO_RIB,
    PIVOT_IN_CAM,
    SELF_CROSSING,
    UNDERCUT,
    BaseCircleLimit,
    Limit,
    OwnQuantityLimit,
    QuantityLimit,
    SelfCrossingLimit,
)
from camopt.scene.scene import Scene

FORCE_ROUNDING = 1e-9  # N: a force this far below 0 is rounding
THINNEST_WALL = 1e-12  # share of the base radius: least wall around a bore or keyway
LOAD_LIMITS, PART_LIMITS, ERROR_LIMITS = (
    {each.key: each.quantity for each in keys} for keys in (LOAD_KEYS, PART_KEYS, ERROR_KEYS)
)
"""The quantity of each short key on loads, on the part, and on motion errors by tolerances."""
SINGLE_QUANTITY_KEYS = LOAD_LIMITS | PART_LIMITS | ERROR_LIMITS | {name: name for name in BOUNDED_QUANTITIES}
"""The keys that bound one quantity from one side."""


def limited_quantity_name(key: str, setup: Setup) -> str:
    """The quantity that a key of ``[limits]`` bounds: the quantity of a short key, else the key itself.

    For a tool that turns, short keys of the motion mean angular quantities.
    """
    short = LIMIT_KEYS.get(key)
    return short.bounded_quantity_name(angular=setup.tool_turns) if short and short.quantity else key


def peaks_of_quantity(quantity: str, setup: Setup) -> tuple[Peak, ...]:
    """The peak behind a quantity at each contact of the follower; empty if it is no extreme of curves."""
    return tuple(contact_peaks(require_effect(quantity, setup), setup, quantity))


def peak_at_first_contact(quantity: str, setup: Setup) -> Peak | None:
    """The peak behind a quantity at the first contact; None if it is no extreme of curves."""
    return next(iter(peaks_of_quantity(quantity, setup)), None)


def quantity_limit(name: str, bound: float, setup: Setup, *quantities: str) -> QuantityLimit:
    """The limit on a quantity, or on the largest magnitude of several."""
    first, effect = quantities[0], require_effect(quantities[0], setup)
    peaks = peaks_of_quantity(first, setup)
    form = peaks[0] if peaks else effect.means(setup).get(first) or effect.train_peaks(setup).get(first)
    return QuantityLimit(
        name,
        bound,
        setup,
        quantities=quantities,
        peak_or_mean=form,
        other_constraints=tuple(_jump_speed_constraints(first, bound, setup)),
        further_peaks=peaks[1:],
    )


def _jump_speed_constraints(quantity: str, bound: float, setup: Setup) -> Iterator[Constraint]:
    """The constraint of a jump speed on designs with their own numbers: contact is kept at that speed."""
    speeds: dict[str, Callable[[Setup], Any]] = {
        "jump_speed_rpm": lambda own: bound * pi / 30,
        "jump_speed_ratio": lambda own: bound * own.omega,
    }
    if setup.free and quantity in speeds:
        yield Constraint(
            partial(force.force_curve_at_speed, setup, speed=speeds[quantity]),
            ALL_STROKES,
            LEAST,
            ConstantBound(-FORCE_ROUNDING),
        )


def _limits_of_every_cam(setup: Setup) -> list[Limit]:
    """The limits of every cam: no undercut, no self-crossing, room for shaft, hub, pivot and rib, inside the disc.

    A profile without undercut can cross itself only with a roller or a spherical face.
    """
    limits: list[Limit] = []
    if not setup.is_knife:
        limits.append(replace(quantity_limit(UNDERCUT, 0.0, setup, CONVEX_RADIUS), set_by_scene=False))
    if setup.mechanism.has_rib:
        limits.append(replace(quantity_limit(NO_RIB, 0.0, setup, rib.RIB_THICKNESS), set_by_scene=False))
    if outline.PIVOT_CLEARANCE in available_quantities(setup):
        limits.append(
            replace(quantity_limit(PIVOT_IN_CAM, 0.0, setup, outline.PIVOT_CLEARANCE), set_by_scene=False)
        )
    limits += _base_circle_limits(setup)
    if setup.solid.outer_diameter is not None and setup.mechanism.outline is not None:
        edge = quantity_limit("outer_diameter", setup.solid.outer_diameter / 2.0, setup, outline.OUTER_RADIUS)
        limits.append(replace(edge, bound_key="part.outer_diameter"))
    if not setup.mechanism.flat_faced and setup.mechanism.body.closed and not setup.is_knife:
        limits.append(SelfCrossingLimit(SELF_CROSSING, 0.0, setup, set_by_scene=False))
    return limits


def _base_circle_limits(setup: Setup) -> Iterator[BaseCircleLimit]:
    """The limits on the base circle: it holds the shaft, the hub, and the bore with its thinnest wall."""
    bore = "keyway" if setup.solid.keyway_width else "bore"
    around = bore_wall_thickness.cam_radius_for_wall(setup, 0.0) * (1.0 + THINNEST_WALL)
    shaft = setup.shaft_radius or 0.0
    for name, radius, key in (
        ("shaft_diameter", shaft, "cam.shaft_diameter"),
        ("hub_diameter", setup.solid.hub_radius, "part.hub_diameter"),
        (bore, around if setup.solid.bore_reach > shaft else 0.0, ""),
    ):
        if radius:
            yield BaseCircleLimit(name, 2 * radius, setup, set_by_scene=bool(key), bound_key=key)


def pressure_angle_limits(setup: Setup, on_rise: float | None, on_return: float | None) -> Iterator[Limit]:
    """The limits on the pressure angle [deg]: one on rises and dwells, one on returns."""
    rises, dwells, returns = (f"pressure_angle_max_{kind}_deg" for kind in ("rise", "dwell", "return"))
    if on_rise is not None and peak_at_first_contact(rises, setup):
        yield quantity_limit("pressure_angle", on_rise, setup, rises, dwells).with_changed_peaks(
            lambda peak: peak._replace(curves=tuple((make, RISE | DWELL) for make, _ in peak.curves))
        )
    if on_return is not None:
        yield quantity_limit("pressure_angle_return", on_return, setup, returns)


def limits_of_scene(scene: Scene, setup: Setup) -> tuple[Limit, ...]:
    """The limits of a scene and those of every cam; limits that are checked last come last."""
    given, mechanism = scene.limits, setup.mechanism
    named = given.bounds_by_key

    def limits_on_given_keys(quantity_name_by_key: Mapping[str, str]) -> list[Limit]:
        return [
            quantity_limit(key, named[key], setup, name)
            for key, name in quantity_name_by_key.items()
            if key in named
        ]

    limits: list[Limit] = limits_on_given_keys(
        {each: motion_peak_name(each, "", angular=setup.tool_turns, timed=True) for each in DERIVATIVE_UNITS}
    )
    on_return = given.pressure_angle if given.pressure_angle_return is None else given.pressure_angle_return
    for limit in pressure_angle_limits(setup, given.pressure_angle, on_return):
        limits.append(limit if limit.name in named else replace(limit, bound_key="limits.pressure_angle"))
    reaches = ("face_reach_max_mm", "face_reach_min_mm")  # along a flat face, to either side
    if given.face_reach is not None and peak_at_first_contact(reaches[0], setup) is not None:
        reach = quantity_limit("face_reach", given.face_reach, setup, *reaches)
        limits.append(reach.with_changed_peaks(Peak.as_magnitude))
    limits += limits_on_given_keys({"outer_radius": outline.OUTER_RADIUS} if mechanism.outline is not None else {})
    limits += limits_on_given_keys({"curvature_radius": CONVEX_RADIUS})
    limits += limits_on_given_keys(
        {"cutter_radius": CUTTER_RADIUS}
        if not (mechanism.flat_faced or mechanism.is_cut_by_roller_sized_cutter)
        else {}
    )
    limits += limits_on_given_keys(
        {key: limited_quantity_name(key, setup) for key in (*PART_LIMITS, *ERROR_LIMITS)}
    )
    limits += limits_on_given_keys(
        {name: name for name in named if name in BOUNDED_QUANTITIES and name not in LOAD_LIMITS}
    )
    limits += _limits_of_every_cam(setup)
    limits += limits_on_given_keys({key: limited_quantity_name(key, setup) for key in LOAD_LIMITS})
    for name in setup.own_quantities:
        if name in named or name in scene.search.objectives:
            limits.append(OwnQuantityLimit(name, named.get(name, inf), setup, set_by_scene=name in named))
    return tuple(sorted(limits, key=lambda limit: limit.is_deferred))


BUILD_LIMITS = {
    "pressure_angle": "pressure_angle_max_deg",
    "curvature_radius": CONVEX_RADIUS,
    "contact_stress": hertz.STRESS,
    "hub_wall": bore_wall_thickness.WALL,
    rib.RIB_THICKNESS: rib.RIB_THICKNESS,
}
"""Limits that a cam to be built should have, each with its quantity."""


def keys_of_unset_build_limits(limits: Iterable[Limit], setup: Setup) -> list[str]:
    """The ``BUILD_LIMITS`` that apply to a cam and are not among ``limits``."""
    flat = setup.mechanism.flat_faced and not setup.angular  # then the pressure angle is 0
    excluded = {limit.name for limit in limits} | ({"pressure_angle"} if flat else set())
    return [
        key for key, name in BUILD_LIMITS.items() if name in available_quantities(setup) and key not in excluded
    ]
