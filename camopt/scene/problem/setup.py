"""The setup: values that all designs of a scene share, in inside units: mm, s, N, t, rad."""

from collections.abc import Iterator
from math import radians
from typing import Any

from camopt.core.numerics.taylor import Taylor
from camopt.core.quantities import NUMBER_COLUMNS
from camopt.model.effects import SceneNumbers, Setup, SolidSizes, ToleranceBands
from camopt.model.effects.effect_numbers import ErrorBand
from camopt.model.mechanisms import FIELDS
from camopt.model.trains.train import Train
from camopt.scene.load import split_constant_and_changing_load
from camopt.scene.materials import MATERIALS
from camopt.scene.own_quantities import own_quantities
from camopt.scene.problem.variables import is_train_key, variables_of_scene
from camopt.scene.scene import Scene
from camopt.scene.sizes import FOLLOWER_SIZES
from camopt.scene.tolerances import does_error_move_tool, tolerance_zone
from camopt.scene.train import build_train, build_trains


def setup_of(scene: Scene) -> Setup:
    """The setup of a scene."""
    angular, part = scene.mechanism.motion.angular, scene.whole_part
    return Setup(
        mechanism=scene.mechanism,
        tip=scene.tip,
        relative_error=scene.accuracy.relative_error,
        given=SceneNumbers(_setup_numbers(scene), angular, scene.tool_turns),
        solid=SolidSizes(
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
            rib_height=part.rib_height,
            outer_diameter=part.outer_diameter,
        ),
        train=build_train(scene.train, angular=angular),
        errors=_error_bands_from_tolerances(scene),
        own_quantities=own_quantities(scene.quantities),
        varied={
            each.key: each.quantity
            for each in variables_of_scene(scene)
            if each.is_scene_number and each.is_searched
        },
    )


def _setup_numbers(scene: Scene) -> dict[str, float | None]:
    """The numbers of a scene by key, with those of named materials."""
    of_train = filter(is_train_key, (*scene.search.numbers, *scene.tolerances.numbers))
    numbers, given = scene.numbers((*NUMBER_COLUMNS, *of_train)), scene.materials
    load, _ = split_constant_and_changing_load(external_load_and_its_unit(scene)[0], 1.0)
    numbers["follower.dynamics.load"] = load
    for body in ("cam", "follower"):
        listed = MATERIALS.get(getattr(given, body))
        for name in ("modulus", "poisson") if listed else ():
            key = f"materials.{body}_{name}"
            numbers[key] = getattr(listed, name) if numbers[key] is None else numbers[key]
    return numbers


def _error_bands_from_tolerances(scene: Scene) -> ToleranceBands | None:
    """The error bands from ``[tolerances]``; None without any."""
    given = scene.tolerances
    zones = {
        key: tolerance_zone(given.numbers[f"follower.{key}"], key, getattr(scene.follower, key) or 0.0)
        for key in FOLLOWER_SIZES
        if f"follower.{key}" in given.numbers
    }
    angles = {
        key: tolerance_zone(each, key, 0.0).scale_by(radians(1.0))
        for key, each in (("phase", given.phase), ("tilt", given.face_tilt), ("disc_phase", given.disc_phase))
        if each
    }
    second, links = dict(_second_contact_error_bands(scene)), dict(_train_error_bands_and_series(scene))
    if not (zones or angles or given.profile or given.bore_eccentricity or second or links):
        return None
    return ToleranceBands(
        {FIELDS[key]: ErrorBand(each.lower, each.upper) for key, each in zones.items()},
        profile=given.profile or 0.0,
        waves=given.waves,
        bore=given.bore_eccentricity or 0.0,
        is_square=not (scene.mechanism.motion.angular or scene.follower.offset or scene.search.offset),
        second=second,
        links=links,
        **{key: ErrorBand(each.lower, each.upper) for key, each in angles.items()},
    )


def _second_contact_error_bands(scene: Scene) -> Iterator[tuple[str, ErrorBand]]:
    """The bands of sizes of a second contact that move the tool, by key."""
    for key in scene.mechanism.second_contact_size_keys:
        if (given := scene.tolerances.numbers.get(key)) is None or not does_error_move_tool(key):
            continue
        name = key.partition(".")[2]
        size = getattr(scene.drive, name)
        zone = tolerance_zone(given, name, getattr(scene.follower, name) or 0.0 if size is None else size)
        yield key, ErrorBand(zone.lower, zone.upper)


def _train_error_bands_and_series(scene: Scene) -> Iterator[tuple[str, tuple[ErrorBand, Train]]]:
    """The bands of numbers of the train that move the tool, by key, each with the train as a series in it."""
    angular = scene.mechanism.motion.angular
    for key, given in scene.tolerances.numbers.items():
        if is_train_key(key) and does_error_move_tool(key) and (nominal := scene.numbers((key,))[key]) is not None:
            zone = tolerance_zone(given, key.rpartition(".")[2], nominal)
            made = build_trains(scene.train, {key: Taylor([nominal, 1.0])}, angular=angular)
            yield key, (ErrorBand(zone.lower, zone.upper), made)


def external_load_and_its_unit(scene: Scene) -> tuple[Any, float]:
    """The external load in the scene's unit, and that unit in N (N·mm)."""
    given = scene.follower.dynamics
    return given and given.load, 1e3 if scene.mechanism.motion.angular else 1.0
