"""Diagrams of loads.

Those of the whole cam: force along the motion, torque, joint forces, elastic train. Those of a contact: thrust,
contact stress, sliding, wear, film.
"""

from collections.abc import Sequence
from functools import partial
from math import degrees, pi

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.oscillator import Wave
from camopt.core.quantities import QUANTITIES
from camopt.model.effects import EvaluationBlock, clearance, hertz, joints, preload, surface, thrust, vibration
from camopt.model.effects.force import (
    contact_force_curve,
    divide_by_lever,
    force_weights_and_constant,
    least_and_largest_contact_force,
)
from camopt.model.effects.loads import (
    force_along_motion_curve,
    friction_signs_by_stroke_kind,
    normal_force_curve,
    torque_curve,
)
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.effects.peak import Variant
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES, DWELL
from camopt.show.drawing.panels import (
    MarkedPeak,
    Panel,
    PieceValues,
    extreme_peaks,
    extreme_quantity_peaks,
    has_finite_quantities,
    load_panel,
    magnitude_peak,
    merge_contact_panels,
    stroke_kinds_and_limit_levels,
)
from camopt.show.drawing.picture import Picture, value_with_unit


def load_panels(picture: Picture, *, with_unusual_forces: bool = False) -> list[Panel]:
    """Diagrams of force, torque, joints, vibration, thrust, stress and surface, if computed and finite.

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

    return [
        *_force_panels(picture),
        *_torque_panels(picture),
        *_joint_panels(picture),
        *_elastic_train_panels(picture),
        *merge_contact_panels(picture, panels_of_contact),
    ]


def _force_panels(picture: Picture) -> list[Panel]:
    problem, ends = picture.problem, ("contact_force_max_N", "contact_force_min_N")
    if problem.setup.mechanism.further_contacts:
        # no quantity is the extreme of the force at one of two contacts
        if not has_finite_quantities(picture, preload.preload_quantity_names(problem.setup)[1]):
            return []
        (panel,) = merge_contact_panels(picture, _one_contact_force_panels)
        panel.peaks += _flank_crossing_peaks(picture)
        return [panel]
    if not has_finite_quantities(picture, *ends):
        return []
    values = picture.curve_values(contact_force_curve(problem.setup, problem.design, problem.programme))
    peaks = [*extreme_quantity_peaks(picture, values, *ends), *_flank_crossing_peaks(picture)]
    limits, note = stroke_kinds_and_limit_levels(picture, ends[1]), _negative_force_note(picture)
    return [Panel(FORCE_TITLE, "N", values, peaks, limits, note=note, quantity=ends[0])]


FORCE_TITLE = "Force along the motion"


def _one_contact_force_panels(picture: Picture) -> list[Panel]:
    """The force along the motion that one of two contacts carries."""
    problem = picture.problem
    setup, designs = problem.setup, problem.design
    lever = float(designs.arm_length[0]) if setup.angular else 1.0
    ends = (
        divide_by_lever(end, lever)
        for end in least_and_largest_contact_force(EvaluationBlock(setup, problem.programme, designs))
    )
    extremes = [setup.mechanism.way * float(getattr(end, "value", end)) for end in ends]
    preload_force = (setup.dynamics.pair_preload or 0.0) / lever
    values = picture.curve_values(force_along_motion_curve(setup, designs, problem.programme))
    exact = tuple(preload.first_contact_force(force, preload_force) for force in (max(extremes), min(extremes)))
    return [Panel(FORCE_TITLE, "N", values, extreme_peaks(picture, values, exact))]


def _flank_crossing_peaks(picture: Picture) -> list[MarkedPeak]:
    """Peaks at the cam angles where the follower crosses to the other flank, with its landing speed."""
    if not has_finite_quantities(picture, clearance.CROSSING_SPEED):
        return []
    problem = picture.problem
    case = EvaluationBlock(problem.setup, problem.programme, problem.design)
    flights, followers = clearance.flights_and_followers_by_setting(case)
    _, speeds = clearance.find_landings_and_speeds(case, flights, followers)
    places = zip(np.degrees(flights.angle).tolist(), speeds.tolist(), strict=True)
    return [MarkedPeak(angle, 0.0, value_with_unit(speed, "m/s")) for angle, speed in places if speed]


def _negative_force_note(picture: Picture) -> str:
    """A note on the meaning of a contact force below 0."""
    pulls = picture.problem.setup.mechanism.can_pull_follower
    return "below 0: the other flank carries the load" if pulls else "below 0: contact is lost"


def _torque_panels(picture: Picture) -> list[Panel]:
    """The torque with its mean. A limit on power is drawn as a limit on torque at the cam's speed."""
    ends = ("torque_max_N_m", "torque_min_N_m")
    if not has_finite_quantities(picture, *ends):
        return []
    setup = picture.problem.setup
    assert setup.omega is not None
    variants: list[Variant] = [
        (partial(torque_curve, setup, velocity_sign=way), kinds)
        for way, kinds in friction_signs_by_stroke_kind(setup)
    ]
    values = [1e-3 * v for v in largest_variant_values(picture, variants)]
    peaks, limits = extreme_quantity_peaks(picture, values, *ends), stroke_kinds_and_limit_levels(picture, ends[0])
    mean = picture.quantity_values["torque_mean_N_m"]
    level, note = [np.full_like(value, mean) for value in values], f"dash-dot: mean {value_with_unit(mean, 'N·m')}"
    return [
        Panel("Torque of the camshaft", "N·m", values, peaks, limits, reference=level, note=note, quantity=ends[0])
    ]


def _joint_panels(picture: Picture) -> list[Panel]:
    """The force in the joint with the largest force; a note has the largest forces in the other joints."""
    if not has_finite_quantities(picture, joints.LARGEST_BY_KIND["joint"]):
        return []
    problem, speed = picture.problem, picture.problem.setup.omega or 0.0
    forces = [force for force in joints.setup_joint_forces(problem.setup) if force.kind == "joint"]
    worst = [float(joints.largest_joint_force(problem.programme, force, speed).value) for force in forces]
    highest = forces[int(np.argmax(worst))]
    turn = joints.programme_loaded_by_joint_force(problem.programme, highest.parts)
    values = [joints.joint_force_at(turn, angles, speed) for angles in picture.angles_of_pieces]
    others = [
        f"{f.name} of stage {f.stage} {value_with_unit(w, 'N')}"
        for f, w in zip(forces, worst, strict=True)
        if f != highest
    ]
    note = f"largest in other joints: {', '.join(others)}" if others else ""
    title = f"Force in a joint of the train: {highest.name} of stage {highest.stage}"
    return [
        load_panel(picture, title, joints.LARGEST_BY_KIND["joint"], values, stroke_kinds=ALL_STROKES, note=note)
    ]


def _elastic_train_panels(picture: Picture) -> list[Panel]:
    """The mass on the elastic train: its acceleration, its deviation from the motion, and the contact force."""
    setup, programme = picture.problem.setup, picture.problem.programme.tool
    dynamics = setup.dynamics
    length, second = ("deg", "rad_s2") if setup.tool_turns else ("mm", "m_s2")
    overshoot, acceleration = f"overshoot_max_{length}", f"acceleration_elastic_max_{second}"
    if not has_finite_quantities(picture, overshoot, acceleration):
        return []
    assert setup.omega is not None
    assert dynamics.natural_frequency is not None
    ratio = 2.0 * pi * dynamics.natural_frequency / setup.omega
    wave = vibration.steady_vibration_wave(programme, ratio, dynamics.damping_ratio)
    unit, factor = degrees(1.0) if setup.tool_turns else 1.0, motion_unit_factor(setup, 2)
    driven = _sample_wave(picture, programme, vibration.mass_acceleration_wave(wave, ratio), factor)
    mass = Panel(
        "Acceleration of the mass on its elastic train",
        QUANTITIES[acceleration].unit,
        driven,
        [magnitude_peak(picture, driven, acceleration)],
        reference=[rows[2] * factor for rows in picture.tool_motion],
        note="dash-dot: of the motion",
        quantity=acceleration,
    )
    deviation = _sample_wave(picture, programme, wave, unit)
    peaks, name = [magnitude_peak(picture, deviation, overshoot)], f"residual_vibration_max_{length}"
    limits = stroke_kinds_and_limit_levels(picture, name, DWELL)
    travel = Panel("Deviation of the mass from the motion", length, deviation, peaks, limits, quantity=overshoot)
    panels = [mass, travel]
    least = "contact_force_elastic_min_N"
    if has_finite_quantities(picture, least):
        lever = float(picture.problem.design.arm_length[0]) if setup.angular else 1.0
        factors = force_weights_and_constant(dynamics, setup.omega)
        pressed = vibration.elastic_contact_force_wave(programme, factors, ratio, dynamics.damping_ratio)
        values = _sample_wave(picture, programme, pressed, 1.0 / lever)
        peaks, note = extreme_quantity_peaks(picture, values, "", least), _negative_force_note(picture)
        title, limits = "Force with the elastic train", stroke_kinds_and_limit_levels(picture, least)
        panels.append(Panel(title, "N", values, peaks, limits, note=note, quantity=least))
    return panels


def _sample_wave(picture: Picture, programme: Programme, wave: Wave, factor: float) -> list[FloatArray]:
    """Values of a wave on each smooth piece of the motion."""
    table = programme.table
    starts = table.centre - table.half_width
    pieces = []
    for angles, first, end in zip(
        picture.angles_of_pieces, table.first_panel[:-1], table.first_panel[1:], strict=True
    ):
        panel = first + np.searchsorted(starts[first + 1 : end], angles, side="right")
        pieces.append(
            factor * wave.values_on_panels(panel, (angles - table.centre[panel]) / table.half_width[panel])[0]
        )
    return pieces


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
    panel = load_panel(picture, "Speed of the roller in its follower" if rolls else "Sliding speed", name, values)
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
