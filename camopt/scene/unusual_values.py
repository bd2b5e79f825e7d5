"""Notes on allowed but unlikely values: metres for millimetres, turns per second, noisy tables."""

from collections.abc import Iterator
from math import sqrt

from camopt.core.numerics.neighbours import derivative_noise_share
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.scene.checks import groove_length_of_scene
from camopt.scene.law_forms import LEAST_NOISE_POINTS, NEAR_END, reversal_word_to_reverse_at_end
from camopt.scene.scene import SCENE_TABLES, Scene
from camopt.scene.segments import following_segments
from camopt.scene.table_places import key_record

NARROW_HUB, USUAL_HUB = 1.5, 1.8
"""Diameter of a steel hub with a keyway, in diameters of its bore: below the first there is a note.

Tables for first designs recommend a wall of 0.25 to 0.5 shaft diameters in steel hubs, and hubs of 1.8 to 2
diameters with a key: H. Wittel et al., Roloff/Matek Maschinenelemente, hub sizes (cited from memory, not looked
up). The old workshop rule is 2 (Shop Practice, American Technical Society, on pulleys).
"""
THIN_SIDE = 0.5
"""Thickness of the wall beside a groove, in depths of the groove; below it there is a note.

The roller bends the wall as a cantilever. A force at the edge gives 6·h/t times the stress of the same force spread
over the thickness t of the wall, for a depth h: 12 times at this share.
"""
LARGE_NOISE_SHARE = 0.5  # share of noise in the acceleration or jerk of a table; above it there is a note
LIFT_RANGES = {"mm": (0.01, 2e3), "deg": (0.1, 180.0)}
"""Usual range of a lift, by its unit."""


def unusual_value_notes(scene: Scene) -> list[str]:
    """Sentences on values far outside the usual range of cams; they are no mistakes."""
    keys = (
        (f"{place}.{name}", key_record(table, name))
        for place, table in SCENE_TABLES.items()
        for name in table.model_fields
    )
    usual = {key: (*record.usual, record.unit) for key, record in keys if record.usual}
    lift_range = (*LIFT_RANGES[scene.mechanism.motion.unit], scene.mechanism.motion.unit)
    usual |= {f"motion.{k}.lift": lift_range for k, segment in enumerate(scene.motion, start=1) if segment.lift}
    values = {key: value for key, value in scene.numbers(usual).items() if isinstance(value, float)}
    notes = [
        f"{key} = {value:g} {unit}: is this what you mean? {least:g} to {most:g} {unit} is usual"
        for key, value in values.items()
        for least, most, unit in (usual[key],)
        if not least <= value <= most
    ]
    sources = (
        _noisy_law_table_notes,
        _default_rest_at_reversal_notes,
        _wide_contact_notes,
        _roller_over_pivot_notes,
        thin_wall_notes,
    )
    return [*notes, *(line for notes_of in sources for line in notes_of(scene))]


def _wide_contact_notes(scene: Scene) -> Iterator[str]:
    """A note on a contact that is wider than the disc, the depth of its groove or the height of its rib."""
    key = scene.mechanism.body.flank_height or "thickness"
    width, available = scene.materials.face_width, getattr(scene.part, key)
    if width and available and width > available:
        wide, limit = (
            f"{to_shown_unit(each, 'mm'):.4g} {unit_in_shown_system('mm')}" for each in (width, available)
        )
        more = (
            f"if only {limit} carries, the contact stress is {sqrt(width / available):.3g} times the computed one"
        )
        yield f"materials.face_width = {wide}: wider than part.{key} ({limit}); {more}"


def _roller_over_pivot_notes(scene: Scene) -> Iterator[str]:
    """A note on a roller with a radius of at least the length of its arm, which covers the pivot."""
    first, second = scene.follower, scene.drive
    rows = {"follower": (first.roller_radius, first.arm_length)}
    if scene.mechanism.second_contact_size_keys:
        rows["drive"] = second.roller_radius or first.roller_radius, second.arm_length or first.arm_length
    for table, (radius, arm) in rows.items():
        if radius and arm and radius >= arm:
            wide, long = (f"{to_shown_unit(each, 'mm'):.4g} {unit_in_shown_system('mm')}" for each in (radius, arm))
            of = " of the second disc" if table == "drive" else ""
            yield f"{table}.roller_radius = {wide}: the roller{of} covers the pivot of its arm ({long})"


def thin_wall_notes(scene: Scene) -> list[str]:
    """Sentences on walls of the cam that are unusually thin."""
    return [*missing_wall_notes(scene), *thin_hub_notes(scene), *thin_groove_side_notes(scene)]


def missing_wall_notes(scene: Scene, base: float | None = None) -> list[str]:
    """A sentence on a disc cam whose bore or keyway reaches its base circle, unless a limit sets a least wall.

    ``base`` is the base radius [mm] if not the scene's own. In a pair the smaller disc counts.
    """
    bases = filter(None, (base or scene.cam.base_radius, scene.drive.base_radius))
    base, reach = min(bases, default=None), scene.whole_part.bore_reach
    if not base or scene.limits.hub_wall is not None or base - reach > NEAR_END * base:
        return []
    what = "keyway" if scene.whole_part.keyway_width else "bore"
    hint = "limits.hub_wall, the least wall, is not set"
    return [f"the wall between {what} and base circle is 0 mm: {hint}"]


def thin_hub_notes(scene: Scene) -> list[str]:
    """A sentence on a keyway whose hub is narrower than ``NARROW_HUB`` bores, unless a limit sets a least wall.

    A cam without a hub is as wide as its base circle, or as the bottom of its groove.
    """
    part, cam = scene.whole_part, scene.cam
    size = cam.base_radius or cam.mean_radius
    body = scene.mechanism.body
    inwards = (getattr(part, body.flank_height) or 0.0) if body.developed else 0.0
    outer = part.hub_diameter or (size and 2 * size - inwards)
    if not outer or not part.bore or not part.keyway_width or scene.limits.hub_wall is not None:
        return []
    wall = outer / 2 - part.bore_reach
    if wall <= 0.0 or outer >= NARROW_HUB * part.bore:
        return []
    usual, actual, rest = (
        f"{to_shown_unit(each, 'mm'):.4g} {unit_in_shown_system('mm')}"
        for each in (USUAL_HUB * part.bore, outer, wall)
    )
    rule = f"a keyed hub of steel usually has {USUAL_HUB:g} times the diameter of its bore, {usual}"
    return [f"part.keyway_width: a wall of {rest} is left; {rule}; this one has {actual}"]


def thin_groove_side_notes(scene: Scene) -> list[str]:
    """A sentence on a groove that is nearer than ``THIN_SIDE`` of its depth to an end of its cylinder."""
    whole, depth = scene.part.thickness, scene.part.groove_depth
    run = groove_length_of_scene(scene) if whole and depth else None
    if not whole or not depth or run is None or whole - run >= 2.0 * THIN_SIDE * depth:
        return []
    rest, deep = (
        f"{to_shown_unit(each, 'mm'):.4g} {unit_in_shown_system('mm')}" for each in ((whole - run) / 2.0, depth)
    )
    rule = f"a wall thinner than {THIN_SIDE:g} times the groove's depth ({deep}) bends under the roller"
    return [f"part.thickness: a wall of {rest} is left beside the groove at either end; {rule}"]


def _noisy_law_table_notes(scene: Scene) -> Iterator[str]:
    """Notes on tables of laws whose acceleration or jerk is mostly noise or rounding of the points."""
    for name, law in scene.laws.items():
        if law.x is not None and law.s is not None and len(law.x) >= LEAST_NOISE_POINTS:
            shares = {
                what: derivative_noise_share(law.x, law.s, k) for what, k in (("acceleration", 2), ("jerk", 3))
            }
            what = next((each for each, share in shares.items() if share > LARGE_NOISE_SHARE), None)
            if what:
                noise = f"{min(shares[what], 1.0):.0%} of its {what} is noise or rounding of its points"
                yield f"laws.{name}: {noise}; camopt fit finds the gentlest motion within a band of such points"


def _default_rest_at_reversal_notes(scene: Scene) -> Iterator[str]:
    """Notes on tables that rest by default between a rise and a return without a dwell.

    A motion that rests there has larger accelerations and jerks than one that reverses.
    """
    rows = scene.motion
    for number, (row, after) in enumerate(zip(rows, following_segments(rows), strict=True), start=1):
        if {row.segment, after.segment} == {"rise", "return"} and {row.law, after.law} <= scene.laws.keys():
            where = f"the follower rests between motion.{number} and motion.{number % len(rows) + 1}"
            for name, end in ((row.law, 1), (after.law, 0)):
                if word := reversal_word_to_reverse_at_end(vars(scene.laws[str(name)]), end):
                    turns = f'set reversal = "{word}" to let it reverse with the acceleration of the points'
                    yield f"laws.{name}: {where}; {turns}; set rest to keep the rest without this note"
