"""Limits: what a scene forbids, the quantities each limit calls for, and by how much a design exceeds it."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from math import inf, nan, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.effects import EFFECTS, Setup, hertz, lift_change, outline, solid, surface, thrust, wall
from camopt.effects.crossing import find_crossing
from camopt.effects.curvature import CUTTER
from camopt.effects.loads import drag_curve, driven, goal_of, normal_curve, torque_curve, ways
from camopt.mechanisms import Designs, Mechanism
from camopt.motion.programme import Programme
from camopt.motion.table import DWELL, RETURN, RISE, TURN
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.problem.claims import (
    BeyondBody,
    BodyRadiusPlus,
    ByCamAngle,
    Claim,
    Derivative,
    PerDegree,
    Plain,
    Tangent,
    size_of,
)
from camopt.problem.rows import Columns
from camopt.quantities import DERIVATIVES, QUANTITIES, motion_quantity
from camopt.scene.scene import Scene


def never(programme: Programme) -> bool:
    """For limits that no jump of the motion makes impossible."""
    return False


def at_corners(programme: Programme) -> bool:
    """Whether the velocity jumps, where an inertia would make a load infinite."""
    return bool(programme.corners)


def constant(value: float) -> Callable[[Columns, Designs], FloatArray]:
    """A function that has this value for all designs."""
    return lambda columns, designs: np.full(len(designs), value)


def unknown(columns: Columns, designs: Designs) -> FloatArray:
    """The derivative by a bound where there is none."""
    return np.full(len(designs), nan)


class LeastForce(NamedTuple):
    """A contact force that there has to be at every cam angle, if the cam turns at a speed."""

    omega: float
    """rad/s."""
    force: float
    """N, at the trace point."""


@dataclass(frozen=True)
class Limit:
    """One limit of a scene, under its key in ``[limits]``.

    ``excess`` is relative: held where ≤ 0, exceeded by 10 % at 0.1. Its sign is exact.
    """

    name: str
    bound: float
    """In the unit of its key."""
    needs: tuple[str, ...]
    excess: Callable[[Columns, Designs], FloatArray]
    claims: tuple[Claim, ...] = ()
    """The curves that decide it, for searches, proofs and pictures; none if it is not decided by curves."""
    infinite_at: Callable[[Programme], bool] = never
    """Whether jumps of a motion make infinite what it bounds, so that no design whatever meets it."""
    shown: tuple[str, ...] = ()
    """The quantities that people read beside the bound."""
    relation: str = "≤"
    """How each of them must compare with the bound; ± where its magnitude must be ≤."""
    decided: Callable[[Setup, Designs, Programme], bool | None] | None = None
    """Whether one design breaks it, None if that stays open; for a limit that is not decided by curves."""
    presumes: str = ""
    """Another limit that must be met first."""
    implies: LeastForce | None = None
    """The contact force without which it cannot be met."""
    asked: bool = True
    """Whether the scene asks for it; False for limits that every cam must meet."""
    by_bound: Callable[[Columns, Designs], FloatArray] = unknown
    """∂excess/∂bound of designs that just meet it; bound − excess/by_bound is the bound that a design meets."""
    given_by: str = ""
    """The key of the scene that gives its bound, if that is not ``[limits]`` with its name."""
    least_size: float = 0.0
    """A base (mean) radius below which no design meets it."""
    most_size: float = inf
    """And one above which none does."""
    of_base: bool = False
    """Whether its bound is the least diameter of the base circle."""
    of_motion: bool = False
    """Whether the motion and the speed decide it, whatever the design."""

    @property
    def key(self) -> str:
        """The key of the scene that gives its bound; the name of a limit that has none there."""
        return self.given_by or (f"limits.{self.name}" if self.asked else self.name)

    @property
    def last(self) -> bool:
        """Whether it is checked only for designs that meet all other limits."""
        return any(EFFECTS[QUANTITIES[name].effect].last for name in self.needs)


def _at_most(name: str, bound: float, *needs: str, claims: Iterable[Claim] = (), **more: Any) -> Limit:
    """The largest magnitude of some quantities is bounded."""

    def excess(columns: Columns, designs: Designs) -> FloatArray:
        largest = np.max([np.abs(columns[need]) + np.zeros(len(designs)) for need in needs], axis=0)
        result: FloatArray = (largest - bound) / bound
        return result

    shown = tuple(need for need in needs if need != "pressure_angle_max_dwell_deg")
    return Limit(name, bound, needs, excess, tuple(claims), by_bound=constant(-1.0 / bound), shown=shown, **more)


UNDERCUT, SELF_CROSSING = "undercut", "self_crossing"  # names of limits that every cam has to hold
MOST, LEAST_ALLOWED = 1.0, -1.0
LOADS = {
    "contact_force_min": ("contact_force_min_N", LEAST_ALLOWED),
    "jump_speed": ("jump_speed_rpm", LEAST_ALLOWED),
    "normal_force": ("normal_force_max_N", MOST),
    "side_thrust": ("side_thrust_max_N", MOST),
    "guide_reaction": ("guide_reaction_max_N", MOST),
    "stem_bending_stress": ("stem_bending_stress_max_MPa", MOST),
    "jamming_margin": ("jamming_margin", LEAST_ALLOWED),
    "contact_stress": ("contact_stress_max_MPa", MOST),
    "wear": ("wear_depth_max_um", MOST),
    "sliding_speed": ("sliding_speed_max_m_s", MOST),
    "film_ratio": ("film_ratio_min", LEAST_ALLOWED),
    "residual_vibration": ("residual_vibration_max_mm", MOST),
    "lash_speed": ("lash_speed_max_m_s", MOST),
    "contact_force_elastic": ("contact_force_elastic_min_N", LEAST_ALLOWED),
    "torque": ("torque_peak_N_m", MOST),
    "power": ("power_peak_W", MOST),
}
"""Limits on loads: the quantity that each bounds, from above (MOST) or from below."""
PART = {
    "lift_change": ("lift_change_max_mm_per_deg", MOST),
    "hub_wall": ("hub_wall_min_mm", LEAST_ALLOWED),
    "area": ("area_mm2", MOST),
    "cam_mass": ("cam_mass_kg", MOST),
    "cam_inertia": ("cam_inertia_kg_m2", MOST),
    "unbalance": ("unbalance_g_mm", MOST),
}
"""Limits on the cam as a part, likewise."""
ANGULAR = {"_mm_per_deg": "_deg_per_deg", "_mm": "_deg", "_m_s": "_rad_s"}
"""Units of the motion of a follower that oscillates in place of those of one that translates."""
WITHOUT_FORCE = ("jamming_margin", "sliding_speed")
"""Those on what no force enters, so that it stays finite where the velocity jumps."""


def load_quantity(name: str, setup: Setup) -> str:
    """The quantity that a limit on loads or on the part bounds; of a motion an angle where it oscillates."""
    quantity = {**LOADS, **PART}[name][0]
    for suffix, angular in ANGULAR.items() if setup.angular else ():
        swung = quantity.removesuffix(suffix) + angular
        if quantity.endswith(suffix) and swung in QUANTITIES:
            return swung
    return quantity


def _load(name: str, bound: float, setup: Setup) -> Limit:
    """A load is bounded from one side."""
    quantity, side, unit = load_quantity(name, setup), LOADS[name][1], abs(bound) or 1.0

    def excess(columns: Columns, designs: Designs) -> Any:
        return side * (columns[quantity] - bound) / unit + np.zeros(len(designs))

    by_arm = name.startswith("contact_force") and setup.angular  # a moment over the length of the arm
    needs = (quantity, "arm_length_mm") if by_arm else (quantity,)
    claims, relation = tuple(_load_claims(name, bound, setup)), "≤" if side == MOST else "≥"
    forced, implies = claims and name not in WITHOUT_FORCE, _least_force(name, bound, setup)
    jumps = at_corners if forced else never
    more: dict[str, Any] = {"relation": relation, "implies": implies, "by_bound": constant(-side / unit)}
    return Limit(name, bound, needs, excess, claims, jumps, shown=(quantity,), **more)


def _of_part(name: str, bound: float, setup: Setup) -> Limit:
    """A size or weight of the part is bounded from one side; a lift change as the velocity by the cam angle."""
    quantity, side = load_quantity(name, setup), PART[name][1]

    def excess(columns: Columns, designs: Designs) -> Any:
        return side * (columns[quantity] - bound) / bound + np.zeros(len(designs))

    claims: tuple[Claim, ...] = ()
    if QUANTITIES[quantity].effect == lift_change.EFFECT.name:
        claims = (Claim(Derivative(1), RISE | RETURN, LARGEST_MAGNITUDE, PerDegree(bound, setup.angular)),)
    least = wall.least_size(setup, bound) if quantity == wall.WALL else 0.0
    most = solid.most_size(setup, quantity, bound)
    relation, by_bound = "≤" if side == MOST else "≥", constant(-side / bound)
    more: dict[str, Any] = {"relation": relation, "by_bound": by_bound, "least_size": least, "most_size": most}
    return Limit(name, bound, (quantity,), excess, claims, shown=(quantity,), **more)


def _cutter(setup: Setup, bound: float) -> Limit:
    """A cutter, or a grinding wheel, of a radius R_c reaches every hollow flank: −κ_pitch·(R_c − R_r) ≤ 1.

    A hollow corner of the pitch curve stands in its way, whatever it is: the roller's own arc there is no flank.
    """
    mechanism, grooved = setup.mechanism, setup.mechanism.grooved
    assert mechanism.curvature is not None
    beyond = BeyondBody(bound)

    def deepest(columns: Columns, designs: Designs) -> FloatArray:
        most = np.asarray(-columns["pitch_curvature_min_per_mm"] + np.zeros(len(designs)))
        return np.maximum(most, columns["pitch_curvature_max_per_mm"]) if grooved else most

    def excess(columns: Columns, designs: Designs) -> FloatArray:
        hollowest = deepest(columns, designs)
        finite = np.isfinite(hollowest)
        return np.asarray(np.where(finite, np.where(finite, hollowest, 0.0) * beyond(designs), hollowest) - 1.0)

    def hollow(programme: Programme) -> bool:
        return any(grooved or corner.size > 0.0 for corner in programme.corners)

    goal, side = (LARGEST_MAGNITUDE, 1.0) if grooved else (LEAST, -1.0)
    claim = Claim(mechanism.curvature, TURN, goal, Plain(side), beyond)
    needs = ("pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm", CUTTER)
    return Limit("cutter_radius", bound, needs, excess, (claim,), hollow, (CUTTER,), "≥", by_bound=deepest)


def _least_force(name: str, bound: float, setup: Setup) -> LeastForce | None:
    """The contact force that a limit on loads implies: up to its jump speed a cam keeps contact."""
    if name == "jump_speed":
        return LeastForce(bound * pi / 30, 0.0)
    if name == "contact_force_min" and setup.omega is not None:
        return LeastForce(setup.omega, bound)
    return None


def _load_claims(name: str, bound: float, setup: Setup) -> Iterator[Claim]:
    """The curves that decide a limit on loads; none for one that the motion alone decides."""
    if name == "contact_stress" and not setup.pointed:  # that of a knife edge has no bound
        for *_, (make, kinds) in hertz.variants(setup):
            yield Claim(make, kinds, LARGEST, Plain(hertz.load_of(setup, bound)))
    elif name in ("wear", "sliding_speed", "film_ratio"):
        quantity = LOADS[name][0]
        for (make, kinds), goal in surface.variants(quantity, setup):
            yield Claim(make, kinds, goal, Plain(surface.ceiling(quantity, setup, bound)))
    elif name == "jamming_margin":
        yield Claim(partial(drag_curve, setup), driven(setup), LARGEST_MAGNITUDE, Plain(1.0 - bound))
    elif name == "normal_force":
        for way, kinds in ways(setup):
            yield Claim(partial(normal_curve, setup, way=way), kinds, goal_of(setup), Plain(bound))
    elif name in ("torque", "power"):
        assert setup.omega is not None
        per = 1.0 if name == "torque" else setup.omega
        for way, kinds in ways(setup):
            make, most = partial(torque_curve, setup, way=way), Plain(1e3 * bound / per)
            yield Claim(make, kinds, LARGEST_MAGNITUDE, most)
    elif name in ("side_thrust", "guide_reaction", "stem_bending_stress"):
        arm, reach, factor = thrust.levers(setup)[LOADS[name][0]]
        for way, kinds in ways(setup):
            make = partial(thrust.thrust_curve, setup, way=way, arm=arm, reach=reach)
            yield Claim(make, kinds, LARGEST_MAGNITUDE, Plain(bound / factor))


def _curvature(name: str, setup: Setup, bound: float) -> Limit:
    """Least convex radius of the profile: κ_pitch·(R_r + ρ_min) ≤ 1, no difference of radii.

    Undercut is the same with ρ_min = 0, but at the bound itself it is not held.
    """
    at_bound = np.finfo(float).tiny if bound == 0.0 else 0.0

    def flat(columns: Columns, designs: Designs) -> FloatArray:
        result: FloatArray = (bound - columns["profile_radius_min_mm"]) / (bound or designs.size)
        return np.where(result == 0.0, at_bound, result)

    def by_bound(columns: Columns, designs: Designs) -> FloatArray:
        return np.asarray(1.0 / (bound or designs.size) + np.zeros(len(designs)))

    def sharpest(columns: Columns, designs: Designs) -> FloatArray:
        most = np.asarray(columns["pitch_curvature_max_per_mm"] + np.zeros(len(designs)))
        return np.maximum(most, -columns["pitch_curvature_min_per_mm"]) if setup.mechanism.grooved else most

    def trace(columns: Columns, designs: Designs) -> FloatArray:
        result: FloatArray = sharpest(columns, designs) * (designs.roller_radius + bound) - 1.0
        return np.where(result == 0.0, at_bound, result)

    mechanism, shown, relation = setup.mechanism, ("profile_radius_min_mm",), ">" if bound == 0.0 else "≥"

    def pointed(programme: Programme) -> bool:
        return any(mechanism.grooved or corner.size < 0.0 for corner in programme.corners)

    if mechanism.curvature is None:
        assert mechanism.profile_radius is not None
        claim = Claim(mechanism.profile_radius, TURN, LEAST, Plain(bound), unit=size_of)
        return Limit(name, bound, shown, flat, (claim,), pointed, shown, relation, by_bound=by_bound)
    goal = LARGEST_MAGNITUDE if mechanism.grooved else LARGEST
    claim = Claim(mechanism.curvature, TURN, goal, Plain(1.0), BodyRadiusPlus(bound))
    needs = ("pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm", *shown)
    return Limit(name, bound, needs, trace, (claim,), pointed, shown, relation, by_bound=sharpest)


def _crossing() -> Limit:
    """The profile does not cross itself: held or not, without a measure of how far."""

    def excess(columns: Columns, designs: Designs) -> FloatArray:
        return np.asarray(columns[SELF_CROSSING] - 0.5 + np.zeros(len(designs)))

    def decided(setup: Setup, design: Designs, programme: Programme) -> bool | None:
        return find_crossing(setup, design, programme).shown

    needs = (SELF_CROSSING,)
    return Limit(SELF_CROSSING, 0.0, needs, excess, decided=decided, presumes=UNDERCUT, asked=False)


def _around(name: str, radius: float, key: str) -> Limit:
    """What is as wide as this lies within the base circle, the least radius of every profile."""

    def excess(columns: Columns, designs: Designs) -> FloatArray:
        result: FloatArray = (radius - designs.size) / radius
        return result

    more: dict[str, Any] = {"by_bound": constant(0.5 / radius), "given_by": key, "least_size": radius}
    return Limit(name, 2 * radius, (), excess, relation="≥", of_base=True, **more)


def _implied(setup: Setup) -> list[Limit]:
    """What every cam has to hold, asked or not: no undercut, no self-crossing, and room for its shaft and hub.

    Without undercut, only a round body can make a profile that crosses itself.
    """
    limits = []
    if not setup.pointed:
        limits.append(replace(_curvature(UNDERCUT, setup, 0.0), asked=False))
    if setup.shaft_radius is not None:
        limits.append(_around("shaft_diameter", setup.shaft_radius, "cam.shaft_diameter"))
    if setup.solid.hub_radius:
        limits.append(_around("hub_diameter", setup.solid.hub_radius, "part.hub_diameter"))
    if setup.mechanism.curvature is not None and not (setup.mechanism.grooved or setup.pointed):
        limits.append(_crossing())
    return limits


def pressure_limits(mechanism: Mechanism, on_rise: float | None, on_return: float | None) -> Iterator[Limit]:
    """The limits on the pressure angle in deg: one of rises and dwells, one of returns alone."""

    def limit(name: str, bound: float, kinds: int, *needs: str) -> Limit:
        claim = Claim(mechanism.pressure, kinds, LARGEST_MAGNITUDE, Tangent(bound))
        return _at_most(name, bound, *needs, claims=[claim])

    if on_rise is not None:
        rises = ("pressure_angle_max_rise_deg", "pressure_angle_max_dwell_deg")
        yield limit("pressure_angle", on_rise, RISE | DWELL, *rises)
    if on_return is not None:
        yield limit("pressure_angle_return", on_return, RETURN, "pressure_angle_max_return_deg")


def _derivative(name: str, order: int, bound: float, setup: Setup, rpm: float) -> Limit:
    """The largest magnitude of a derivative of the motion by time is bounded."""

    def jumps(programme: Programme) -> bool:
        return any(jump.order < order for jump in programme.jumps)

    quantity = motion_quantity(name, "", angular=setup.angular, timed=True)
    by_angle = ByCamAngle(bound, 1.0 if setup.angular else 1e3, order, rpm)
    claim = Claim(Derivative(order), RISE | RETURN, LARGEST_MAGNITUDE, by_angle)
    return _at_most(name, bound, quantity, claims=[claim], infinite_at=jumps)


def limits_of(scene: Scene, setup: Setup) -> tuple[Limit, ...]:
    """The limits of a scene, those that are asked last at the end, with those that every cam has to hold."""
    asked = scene.limits
    limits = []
    for order, derivative in enumerate(DERIVATIVES, start=1):
        if (bound := getattr(asked, derivative)) is not None:
            assert scene.cam.rpm is not None
            limits.append(_derivative(derivative, order, bound, setup, scene.cam.rpm))
    on_return = asked.pressure_angle if asked.pressure_angle_return is None else asked.pressure_angle_return
    for limit in pressure_limits(setup.mechanism, asked.pressure_angle, on_return):
        own = getattr(asked, limit.name) is not None
        limits.append(limit if own else replace(limit, given_by="limits.pressure_angle"))
    if asked.face_reach is not None and setup.mechanism.reach is not None:
        claim = Claim(setup.mechanism.reach, TURN, LARGEST_MAGNITUDE, Plain(asked.face_reach))
        ends = ("face_reach_max_mm", "face_reach_min_mm")
        limits.append(_at_most("face_reach", asked.face_reach, *ends, claims=[claim], relation="±"))
    if asked.outer_radius is not None and setup.mechanism.outline is not None:
        claim = Claim(setup.mechanism.outline, TURN, LARGEST, Plain(asked.outer_radius))
        limits.append(_at_most("outer_radius", asked.outer_radius, outline.RADIUS, claims=[claim]))
    if asked.curvature_radius is not None:
        limits.append(_curvature("curvature_radius", setup, asked.curvature_radius))
    if asked.cutter_radius is not None and setup.mechanism.curvature is not None:
        limits.append(_cutter(setup, asked.cutter_radius))
    limits += [_of_part(name, bound, setup) for name in PART if (bound := getattr(asked, name)) is not None]
    loads = [_load(name, bound, setup) for name in LOADS if (bound := getattr(asked, name)) is not None]
    found = (*limits, *_implied(setup), *loads)
    limited = [replace(limit, of_motion=_of_motion(limit, setup)) for limit in found]
    return tuple(sorted(limited, key=lambda limit: limit.last))


def _of_motion(limit: Limit, setup: Setup) -> bool:
    effects = [EFFECTS[QUANTITIES[name].effect] for name in limit.needs]
    return bool(effects) and all(effect.of_motion(setup) for effect in effects)
