"""Diagrams of contact loads: thrust, contact stress, sliding, wear and film."""

from collections.abc import Sequence
from functools import partial
from math import pi

import numpy as np

from camopt.model.effects import hertz, surface, thrust
from camopt.model.effects.loads import friction_signs_by_stroke_kind, normal_force_curve
from camopt.model.effects.peak import Variant
from camopt.show.drawing.limit_lines import stroke_kinds_and_limit_levels
from camopt.show.drawing.panels import Panel, PieceValues, has_finite_quantities, load_panel, merge_contact_panels
from camopt.show.drawing.picture import Picture


def load_panels(picture: Picture, *, with_unusual_forces: bool = False) -> list[Panel]:
    """Diagrams of thrust, stress and surface, if computed and finite.

    ``with_unusual_forces`` adds unusual forces.
    """

    def panels_of_contact(contact: Picture) -> list[Panel]:
        return [
            *_thrust_panels(contact, with_unusual_forces),
            *_stress_panels(contact),
            *_sliding_panels(contact),
            *_wear_panels(contact),
            *_film_panels(contact),
        ]

    return merge_contact_panels(picture, panels_of_contact)


def _thrust_panels(picture: Picture, with_unusual_forces: bool) -> list[Panel]:
    """Side thrust, or normal force for a follower without side thrust; other forces if they are limited."""
    setup = picture.problem.setup
    panels: list[Panel] = []
    main = "side_thrust_max_N" if setup.mechanism.curvature else "normal_force_max_N"
    for title, name in (
        ("Normal force", "normal_force_max_N"),
        ("Side thrust", "side_thrust_max_N"),
        ("Reaction at the near end of the guide", "guide_reaction_max_N"),
        ("Bending stress of the stem", "stem_bending_stress_max_MPa"),
    ):
        if not has_finite_quantities(picture, name) or not (
            with_unusual_forces or name == main or stroke_kinds_and_limit_levels(picture, name)
        ):
            continue
        normal = name == "normal_force_max_N"
        *_, factor = (1.0,) if normal else thrust.LEVERS[name](setup.dynamics)
        make = (
            partial(normal_force_curve, setup)
            if normal
            else partial(thrust.side_thrust_curve, setup, quantity_name=name)
        )
        variants: list[Variant] = [
            (partial(make, velocity_sign=way), kinds) for way, kinds in friction_signs_by_stroke_kind(setup)
        ]
        panels.append(
            load_panel(
                picture, title, name, [factor * value for value in largest_variant_values(picture, variants)]
            )
        )
    return panels


def _stress_panels(picture: Picture) -> list[Panel]:
    if not has_finite_quantities(picture, hertz.STRESS):
        return []
    setup = picture.problem.setup
    loads = largest_variant_values(
        picture, [variant for *_, variant in hertz.load_curves_by_flank_and_friction(setup)], clip_negative=True
    )
    values = [hertz.contact_stress(setup, load, picture.problem.design) for load in loads]
    return [load_panel(picture, "Contact stress", hertz.STRESS, values)]


def _sliding_panels(picture: Picture) -> list[Panel]:
    """Sliding speed of the follower on the cam, or speed of its roller."""
    problem = picture.problem
    setup, design = problem.setup, problem.design
    rolls = has_finite_quantities(picture, surface.ROLLER_SPEED)
    name = surface.ROLLER_SPEED if rolls else surface.SLIDING_SPEED
    if not has_finite_quantities(picture, name):
        return []
    assert setup.omega is not None
    factor = 30.0 / pi * setup.omega / float(design.roller_radius[0]) if rolls else setup.omega / 1e3
    *others, side = (flank.side for flank in setup.mechanism.flanks)  # the outer wall of a groove is faster
    curve = surface.sliding_speed_curve(setup, design, problem.programme, side)
    values = [factor * value for value in picture.curve_values(curve)]
    title = "Speed of the roller in its follower" if rolls else "Sliding speed"
    panel = load_panel(picture, title, name, values)
    if others:
        inner = surface.sliding_speed_curve(setup, design, problem.programme, others[0])
        panel.other = [factor * value for value in picture.curve_values(inner)]
        panel.note = f"thin: on the {setup.mechanism.flanks[0].display_name}"
    return [panel]


def _wear_panels(picture: Picture) -> list[Panel]:
    if not has_finite_quantities(picture, surface.WEAR_DEPTH):
        return []
    setup = picture.problem.setup
    loads = largest_variant_values(picture, surface.wear_or_film_curve_variants(surface.WEAR_DEPTH, setup))
    values = [surface.wear_depth_factor(setup) * np.maximum(np.abs(load), 0.0) for load in loads]
    return [load_panel(picture, "Wear of the profile in a million turns", surface.WEAR_DEPTH, values)]


def _film_panels(picture: Picture) -> list[Panel]:
    """Film thickness over roughness, or in µm without a roughness; 0 where nothing is entrained."""
    name = surface.FILM_RATIO if has_finite_quantities(picture, surface.FILM_RATIO) else surface.FILM_THICKNESS
    if not has_finite_quantities(picture, name):
        return []
    setup = picture.problem.setup
    thinness = largest_variant_values(picture, surface.wear_or_film_curve_variants(surface.FILM_RATIO, setup))
    factor = surface.film_thickness_factor(setup) / (setup.bodies.roughness or 1e-3)
    values = [np.where(value > 0.0, factor / value, 0.0) for value in thinness]
    title = "Film over roughness" if name == surface.FILM_RATIO else "Film thickness"
    return [load_panel(picture, title, name, values, least=True)]


def largest_variant_values(
    picture: Picture, variants: Sequence[Variant], *, clip_negative: bool = False
) -> PieceValues:
    """The variant of a load with the largest magnitude, at each sample.

    ``clip_negative`` sets negative values to 0.
    """
    problem = picture.problem
    variant_values = [
        (picture.curve_values(make(problem.design, problem.programme)), kinds) for make, kinds in variants
    ]
    values: PieceValues = []
    for k, kind in enumerate(problem.programme.table.kind):
        here = np.array([curves[k] for curves, kinds in variant_values if kinds & kind])
        here = np.maximum(here, 0.0) if clip_negative else here
        values.append(np.take_along_axis(here, np.abs(here).argmax(axis=0)[None], axis=0)[0])
    return values
