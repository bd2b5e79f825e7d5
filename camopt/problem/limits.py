"""Limits: what a scene forbids, the quantities each limit calls for, and by how much a design exceeds it."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf, nan, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.effects import EFFECTS, Setup, force, outline, solid, wall
from camopt.effects.crossing import find_crossing
from camopt.effects.curvature import CONVEX, CUTTER, PITCH
from camopt.effects.mean import Mean
from camopt.effects.peak import BeyondBody, Peak, never
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import DWELL, RISE, TURN
from camopt.numerics import LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.problem.claims import Claim, MeanClaim, Plain, claims_of, mean_claim_of
from camopt.problem.rows import Columns
from camopt.quantities import AT_LEAST, BOUNDED, DERIVATIVES, QUANTITIES, motion_quantity
from camopt.scene.scene import Scene


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
    mean: MeanClaim | None = None
    """What decides it, if that is the mean of a curve."""
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


NO_FORCE = 1e-9  # N: less than nothing by so much is rounding
THINNEST = 1e-12  # of the base radius: the wall that a keyway or bore leaves, since a scene has to have one
UNDERCUT, SELF_CROSSING = "undercut", "self_crossing"  # names of limits that every cam has to hold
LOADS = {
    "contact_force_min": "contact_force_min_N",
    "jump_speed": "jump_speed_rpm",
    "normal_force": "normal_force_max_N",
    "side_thrust": "side_thrust_max_N",
    "guide_reaction": "guide_reaction_max_N",
    "stem_bending_stress": "stem_bending_stress_max_MPa",
    "jamming_margin": "jamming_margin",
    "contact_stress": "contact_stress_max_MPa",
    "wear": "wear_depth_max_um",
    "sliding_speed": "sliding_speed_max_m_s",
    "film_ratio": "film_ratio_min",
    "residual_vibration": "residual_vibration_max_mm",
    "lash_speed": "lash_speed_max_m_s",
    "contact_force_elastic": "contact_force_elastic_min_N",
    "torque": "torque_peak_N_m",
    "power": "power_peak_W",
}
"""Short keys of limits on loads: the quantity that each bounds."""
PART = {
    "lift_change": "lift_change_max_mm_per_deg",
    "hub_wall": wall.WALL,
    "area": "area_mm2",
    "cam_mass": "cam_mass_kg",
    "cam_inertia": "cam_inertia_kg_m2",
    "unbalance": "unbalance_g_mm",
}
"""Short keys of limits on the cam as a part, likewise."""
OF_QUANTITIES = LOADS | PART | {name: name for name in BOUNDED}
"""All keys that bound just one quantity from one side."""
ANGULAR = {"_mm_per_deg": "_deg_per_deg", "_mm": "_deg", "_m_s": "_rad_s"}
"""Units of the motion of a follower that oscillates in place of those of one that translates."""


def limited_quantity(key: str, setup: Setup) -> str:
    """The quantity that a key of ``[limits]`` bounds: by a short key, or by its own name.

    By a short key, a quantity of the motion is the angle of a follower that oscillates.
    """
    quantity = OF_QUANTITIES.get(key, key)
    for suffix, angular in ANGULAR.items() if setup.angular and key != quantity else ():
        swung = quantity.removesuffix(suffix) + angular
        if quantity.endswith(suffix) and swung in QUANTITIES:
            return swung
    return quantity


def peak_of(quantity: str, setup: Setup) -> Peak | None:
    """The extreme of curves that a quantity is, if it is one."""
    return EFFECTS[QUANTITIES[quantity].effect].peaks(setup).get(quantity)


def mean_of(quantity: str, setup: Setup) -> Mean | None:
    """The mean of a curve that a quantity is, if it is one."""
    return EFFECTS[QUANTITIES[quantity].effect].means(setup).get(quantity)


def _bounded(name: str, bound: float, quantity: str, setup: Setup) -> Limit:
    """A quantity is bounded, from the side that its list says."""
    if quantity in OF_CURVATURE:
        return OF_CURVATURE[quantity](name, bound, setup)
    unit, peak, side = abs(bound) or 1.0, peak_of(quantity, setup), QUANTITIES[quantity].side
    mean = mean_of(quantity, setup)

    def excess(columns: Columns, designs: Designs) -> Any:
        return side * (columns[quantity] - bound) / unit + np.zeros(len(designs))

    by_arm = quantity.startswith("contact_force") and setup.angular  # a moment over the length of the arm
    return Limit(
        name,
        bound,
        (quantity, "arm_length_mm") if by_arm else (quantity,),
        excess,
        claims_of(peak, bound) if peak else tuple(_of_jump(quantity, bound, setup)),
        mean_claim_of(mean, bound, side) if mean else None,
        peak.jumps if peak else mean.jumps if mean else never,
        (quantity,),
        QUANTITIES[quantity].relation,
        implies=_least_force(quantity, bound, setup),
        by_bound=constant(-side / unit),
        least_size=wall.least_size(setup, bound) if quantity == wall.WALL else 0.0,
        most_size=solid.most_size(setup, quantity, bound),
    )


def _magnitudes(name: str, bound: float, quantities: Sequence[str], claims: Iterable[Claim]) -> Limit:
    """The largest magnitude of some quantities is bounded; people read the first."""

    def excess(columns: Columns, designs: Designs) -> FloatArray:
        largest = np.max([np.abs(columns[each]) + np.zeros(len(designs)) for each in quantities], axis=0)
        result: FloatArray = (largest - bound) / bound
        return result

    by_bound, needs = constant(-1.0 / bound), tuple(quantities)
    return Limit(name, bound, needs, excess, tuple(claims), shown=needs[:1], by_bound=by_bound)


def _least_force(quantity: str, bound: float, setup: Setup) -> LeastForce | None:
    """The contact force that a limit implies: up to its jump speed a cam keeps contact."""
    if quantity == "jump_speed_rpm":
        return LeastForce(bound * pi / 30, 0.0)
    if quantity == "jump_speed_ratio" and setup.omega is not None:
        return LeastForce(bound * setup.omega, 0.0)
    if quantity == "contact_force_min_N" and setup.omega is not None:
        return LeastForce(setup.omega, bound)
    return None


def _of_jump(quantity: str, bound: float, setup: Setup) -> Iterator[Claim]:
    """What a jump speed says of designs that bring numbers of their own: at that speed contact is kept."""
    speeds: dict[str, Callable[[Setup], Any]] = {
        "jump_speed_rpm": lambda own: bound * pi / 30,
        "jump_speed_ratio": lambda own: bound * own.omega,
    }
    if setup.free and quantity in speeds:
        yield Claim(partial(force.force_at_speed, setup, speed=speeds[quantity]), TURN, LEAST, Plain(-NO_FORCE))


def _cutter(name: str, bound: float, setup: Setup) -> Limit:
    """A cutter, or a grinding wheel, of a radius R_c reaches every hollow flank: −κ_pitch·(R_c − R_r) ≤ 1.

    A hollow corner of the pitch curve stands in its way, whatever it is: the roller's own arc there is no flank.
    """
    grooved, beyond, peak = setup.mechanism.grooved, BeyondBody(bound), peak_of(CUTTER, setup)
    assert peak is not None

    def deepest(columns: Columns, designs: Designs) -> FloatArray:
        most = np.asarray(-columns["pitch_curvature_min_per_mm"] + np.zeros(len(designs)))
        return np.maximum(most, columns["pitch_curvature_max_per_mm"]) if grooved else most

    def excess(columns: Columns, designs: Designs) -> FloatArray:
        hollowest = deepest(columns, designs)
        finite = np.isfinite(hollowest)
        return np.asarray(np.where(finite, np.where(finite, hollowest, 0.0) * beyond(designs), hollowest) - 1.0)

    claims, needs = claims_of(peak, bound), (*PITCH, CUTTER)
    return Limit(name, bound, needs, excess, claims, None, peak.jumps, (CUTTER,), AT_LEAST, by_bound=deepest)


def _curvature(name: str, bound: float, setup: Setup) -> Limit:
    """Least convex radius of the profile: κ_pitch·(R_r + ρ_min) ≤ 1, no difference of radii.

    Undercut is the same with ρ_min = 0, but at the bound itself it is not held.
    """
    at_bound = np.finfo(float).tiny if bound == 0.0 else 0.0

    def flat(columns: Columns, designs: Designs) -> FloatArray:
        result: FloatArray = (bound - columns[CONVEX]) / (bound or designs.size)
        return np.where(result == 0.0, at_bound, result)

    def by_bound(columns: Columns, designs: Designs) -> FloatArray:
        return np.asarray(1.0 / (bound or designs.size) + np.zeros(len(designs)))

    def sharpest(columns: Columns, designs: Designs) -> FloatArray:
        most = np.asarray(columns["pitch_curvature_max_per_mm"] + np.zeros(len(designs)))
        return np.maximum(most, -columns["pitch_curvature_min_per_mm"]) if setup.mechanism.grooved else most

    def trace(columns: Columns, designs: Designs) -> FloatArray:
        result: FloatArray = sharpest(columns, designs) * (designs.roller_radius + bound) - 1.0
        return np.where(result == 0.0, at_bound, result)

    peak, relation = peak_of(CONVEX, setup), ">" if bound == 0.0 else AT_LEAST
    assert peak is not None
    traced, shown = setup.mechanism.curvature is not None, (CONVEX,)
    needs, excess, by = ((*PITCH, CONVEX), trace, sharpest) if traced else (shown, flat, by_bound)
    return Limit(name, bound, needs, excess, claims_of(peak, bound), None, peak.jumps, shown, relation, by_bound=by)


OF_CURVATURE: dict[str, Callable[[str, float, Setup], Limit]] = {CONVEX: _curvature, CUTTER: _cutter}
"""Radii, which are compared as curvatures."""


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
    """What every cam has to hold, asked or not: no undercut, no self-crossing, room for shaft, bore and hub.

    Without undercut, only a round body can make a profile that crosses itself.
    """
    limits = []
    if not setup.pointed:
        limits.append(replace(_curvature(UNDERCUT, 0.0, setup), asked=False))
    if setup.shaft_radius is not None:
        limits.append(_around("shaft_diameter", setup.shaft_radius, "cam.shaft_diameter"))
    if setup.solid.hub_radius:
        limits.append(_around("hub_diameter", setup.solid.hub_radius, "part.hub_diameter"))
    if setup.solid.bore_reach > (setup.shaft_radius or 0.0):
        name, beyond = "keyway" if setup.solid.keyway_width else "bore", wall.least_size(setup, 0.0)
        limits.append(replace(_around(name, beyond * (1.0 + THINNEST), ""), asked=False))
    if setup.mechanism.curvature is not None and not (setup.mechanism.grooved or setup.pointed):
        limits.append(_crossing())
    return limits


def pressure_limits(setup: Setup, on_rise: float | None, on_return: float | None) -> Iterator[Limit]:
    """The limits on the pressure angle in deg: one of rises and dwells, one of returns alone."""
    rises, dwells, returns = (f"pressure_angle_max_{kind}_deg" for kind in ("rise", "dwell", "return"))
    if on_rise is not None and (peak := peak_of(rises, setup)):
        claims = claims_of(peak.over(RISE | DWELL), on_rise)
        yield _magnitudes("pressure_angle", on_rise, [rises, dwells], claims)
    if on_return is not None and (peak := peak_of(returns, setup)):
        yield _magnitudes("pressure_angle_return", on_return, [returns], claims_of(peak, on_return))


def _face_reach(bound: float, setup: Setup) -> Limit:
    """The reach along a flat face, to either side."""
    assert setup.mechanism.reach is not None
    claim = Claim(setup.mechanism.reach, TURN, LARGEST_MAGNITUDE, Plain(bound))
    ends = ("face_reach_max_mm", "face_reach_min_mm")
    return replace(_magnitudes("face_reach", bound, ends, [claim]), relation="±", shown=ends)


def limits_of(scene: Scene, setup: Setup) -> tuple[Limit, ...]:
    """The limits of a scene, those that are asked last at the end, with those that every cam has to hold."""
    asked, mechanism = scene.limits, setup.mechanism
    named = asked.given

    def of(quantities: Mapping[str, str]) -> list[Limit]:
        return [_bounded(key, named[key], name, setup) for key, name in quantities.items() if key in named]

    limits = of({each: motion_quantity(each, "", angular=setup.angular, timed=True) for each in DERIVATIVES})
    on_return = asked.pressure_angle if asked.pressure_angle_return is None else asked.pressure_angle_return
    for limit in pressure_limits(setup, asked.pressure_angle, on_return):
        limits.append(limit if limit.name in named else replace(limit, given_by="limits.pressure_angle"))
    if asked.face_reach is not None and mechanism.reach is not None:
        limits.append(_face_reach(asked.face_reach, setup))
    limits += of({"outer_radius": outline.RADIUS} if mechanism.outline is not None else {})
    limits += of({"curvature_radius": CONVEX})
    limits += of({"cutter_radius": CUTTER} if mechanism.curvature is not None else {})
    limits += of({key: limited_quantity(key, setup) for key in PART})
    limits += of({name: name for name in named if name in BOUNDED and name not in LOADS})
    limits += _implied(setup)
    limits += of({key: limited_quantity(key, setup) for key in LOADS})
    limited = [replace(limit, of_motion=_of_motion(limit, setup)) for limit in limits]
    return tuple(sorted(limited, key=lambda limit: limit.last))


def _of_motion(limit: Limit, setup: Setup) -> bool:
    effects = [EFFECTS[QUANTITIES[name].effect] for name in limit.needs]
    return bool(effects) and not setup.free and all(effect.of_motion(setup) for effect in effects)
