"""What all designs of a scene share, in inside units: mm, s, N, t, rad."""

from dataclasses import replace
from math import pi, radians
from typing import Any

from camopt.effects import Bodies, Dynamics, Setup, Solid
from camopt.mechanisms import mechanism_for
from camopt.quantities import number_quantity
from camopt.scene.load import constant_and_changing
from camopt.scene.materials import MATERIALS
from camopt.scene.scene import Scene


def setup_of(scene: Scene) -> Setup:
    """The setup of a scene. What presses the follower on the cam is 0 where the scene does not say."""
    cam, follower = scene.cam, scene.follower
    angular = follower.motion == "oscillating"
    return Setup(
        mechanism=mechanism_for(cam.form, follower.motion, follower.contact),
        angular=angular,
        pointed=follower.contact == "knife",
        rpm=cam.rpm,
        shaft_radius=None if cam.shaft_diameter is None else cam.shaft_diameter / 2,
        tolerance=scene.accuracy.tolerance,
        dynamics=_dynamics(scene),
        bodies=_bodies(scene),
        solid=_solid(scene),
        spherical=follower.contact == "spherical",
        numbers=tuple(
            (number_quantity(key, angular=angular), value)
            for key, value in scene.numbers(scene.search.numbers).items()
            if value is not None
        ),
    )


def _dynamics(scene: Scene) -> Dynamics:
    """The follower's dynamics in inside units: N, mm, s, t."""
    given = scene.follower.dynamics
    if given is None:
        return Dynamics()
    angular = scene.follower.motion == "oscillating"
    mass, torque = (given.inertia, 1e3) if angular else (given.mass, 1.0)
    constant, _ = constant_and_changing(*load_and_unit(scene))
    mass = None if mass is None else mass * (1e3 if angular else 1e-3)  # kg·m² to t·mm², kg to t
    return Dynamics(
        mass=mass,
        damping=(given.damping or 0.0) * torque,
        stiffness=(given.spring_rate or 0.0) * torque,
        preload=(given.preload or 0.0) * torque,
        load=constant + (mass or 0.0) * (given.gravity or 0.0) * 1e3,
        friction=given.friction or 0.0,
        guide_length=given.guide_length,
        overhang=given.overhang,
        stem_diameter=given.stem_diameter,
        natural_frequency=given.natural_frequency,
        damping_ratio=given.damping_ratio or 0.0,
        fluctuation=given.fluctuation,
        lash=None if given.lash is None else given.lash * (pi / 180 if angular else 1.0),
        lash_variation=(given.lash_variation or 0.0) * (pi / 180 if angular else 1.0),
    )


def load_and_unit(scene: Scene) -> tuple[Any, float]:
    """The external load as the scene gives it, and its unit in N (N·mm)."""
    given = scene.follower.dynamics
    return given and given.load, 1e3 if scene.follower.motion == "oscillating" else 1.0


def _bodies(scene: Scene) -> Bodies:
    """The bodies in contact; their modulus is known if both are."""
    given, compliance = scene.materials, 0.0
    bodies = Bodies(
        face_width=given.face_width,
        wear_rate=given.wear_rate,
        viscosity=None if given.viscosity is None else given.viscosity * 1e-6,
        pressure_viscosity=None if given.pressure_viscosity is None else given.pressure_viscosity * 1e-3,
        roughness=None if given.roughness is None else given.roughness * 1e-3,
    )
    for body in ("cam", "follower"):
        name = getattr(given, body)
        listed = MATERIALS[name] if name else None
        modulus = getattr(given, f"{body}_modulus") or (listed and listed.modulus)
        poisson = getattr(given, f"{body}_poisson")
        poisson = listed.poisson if poisson is None and listed else poisson
        if modulus is None or poisson is None:
            return bodies
        compliance += (1.0 - poisson**2) / (1e3 * modulus)
    return replace(bodies, modulus=1.0 / compliance)


def _solid(scene: Scene) -> Solid:
    """The cam as a solid, with what ``[part]`` leaves to other tables."""
    part = scene.whole_part
    return Solid(
        thickness=part.thickness,
        density=None if part.density is None else part.density * 1e-12,  # kg/m³ to t/mm³
        bore_radius=(part.bore or 0.0) / 2,
        bore_reach=part.bore_reach,
        keyway_width=part.keyway_width or 0.0,
        keyway_depth=part.keyway_depth or 0.0,
        keyway_angle=radians(part.keyway_angle or 0.0),
        hub_radius=(part.hub_diameter or 0.0) / 2,
        hub_length=part.hub_length or 0.0,
        groove_depth=part.groove_depth,
    )
