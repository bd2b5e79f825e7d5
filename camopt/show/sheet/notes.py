"""Notes of a drawing: purpose, sense of rotation, contents of the table, computed results."""

from collections.abc import Iterable, Iterator
from itertools import chain
from math import degrees, isfinite, pi

from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects import find_quantity
from camopt.model.effects.curvature import CUTTER_RADIUS
from camopt.model.effects.pressure import BOTTOM_ANGLE
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.stroke import RETURN, RISE
from camopt.show.sheet.marks import MEDIUM, Marks, Words, decimal_text, truncate_lines_with_ellipsis, wrap_text
from camopt.show.sheet.sizes import groove_clearance, keyway_depth_text
from camopt.show.sheet.standards import length_text, sheet_standard
from camopt.show.sheet.true_cam import TrueCam, constant_velocity_strokes
from camopt.show.sheet.two_contacts import contact_notes
from camopt.solve.contour.hole import keyway_direction_angle
from camopt.solve.tables.cells import with_unit
from camopt.solve.verdicts.evaluation import evaluate_design

FLANK_RADIUS = 1e3  # sizes of the cam: a hollow flank with a larger radius is straight for any cutter
LINE_STEP = 4.2  # mm from line to line
NOTE_INDENT = 6.0  # mm
NOTE_LINES = 20  # longer notes are cut; only very long names or hundreds of segments need more
ROTATION_WORDS = {"cw": "clockwise", "ccw": "counter-clockwise"}


def numbered_notes(texts: Iterable[str], width: float) -> Marks:
    """Numbered notes of a width (mm), from their lower left corner."""
    room = width - NOTE_INDENT
    rows = [
        ("" if place else f"{number}", text)
        for number, note in enumerate(texts, start=1)
        for place, text in enumerate(
            truncate_lines_with_ellipsis(wrap_text(note, room, MEDIUM), NOTE_LINES, room, MEDIUM)
        )
    ]
    marks: Marks = []
    for row, (number, text) in enumerate(rows, start=1):
        foot = 1j * ((len(rows) - row) * LINE_STEP + 1.0)
        marks += [Words(foot, number, MEDIUM)] if number else []
        marks.append(Words(NOTE_INDENT + foot, text, MEDIUM))
    return marks


def note_texts(cam: TrueCam) -> Iterator[str]:
    """Texts of the notes of a cam, broken limits first."""
    return chain(
        _broken_limits(cam),
        filter(None, [_general_note(cam)]),
        _follower_notes(cam),
        contact_notes(cam),
        _rotation_notes(cam),
        _keyway_notes(cam),
        _motion_notes(cam),
        _table_notes(cam),
        _groove_notes(cam),
        _computed_notes(cam),
    )


def _broken_limits(cam: TrueCam) -> Iterator[str]:
    """A note on broken limits, with their values and bounds; a limit without a number has its name."""
    evaluation, broken = evaluate_design(cam.scene, cam.problem), []
    for limit in cam.problem.limits:
        if limit.name in evaluation["violated"].split(","):
            what = limit.name.replace("_", " ")
            names = [name for name in limit.shown_quantities if name in evaluation]
            units = {name: find_quantity(name, limit.setup).unit for name in names}
            broken += [
                f"{what} {with_unit(evaluation[name], unit)} ({limit.relation} {with_unit(limit.bound, unit)})"
                for name, unit in units.items()
            ] or [what]
    if broken:
        yield cam.translate("Breaks limits of its design: {}.").format("; ".join(broken))
    elif not evaluation["feasible"]:
        yield cam.translate("Not proved to meet the limits of its design.")


def _general_note(cam: TrueCam) -> str:
    """A note on edges, and on what the title block does not have: unit, projection, tolerances, surfaces."""
    part, translate = cam.part, cam.translate
    edges = [f"{to_shown_unit(value, 'mm'):+.3g}" for value in part.edges or ()]
    notes = [translate("Edges ISO 13715: outer {}, inner {}.").format(*edges)] if edges else []
    if sheet_standard().has_tolerance_block:
        basic = "Values of the table and radii of the profile are basic."
        return " ".join([*([] if part.profile_tolerance is None else [basic]), *notes])
    tolerances, roughness = part.general_tolerances, part.other_roughness
    return " ".join(
        [
            translate("Dimensions in mm. Projection method 1."),
            *([translate("General tolerances {}.").format(tolerances)] if tolerances else []),
            *notes,
            *([] if roughness is None else [translate("Other surfaces Ra {}.").format(f"{roughness:.3g}")]),
        ]
    )


def _follower_notes(cam: TrueCam) -> Iterator[str]:
    """Notes on the follower of each disc."""
    if not cam.is_disc_pair:
        yield cam.translate("For {}.").format(_follower_text(cam, cam.problem.design))
        return
    for k, disc in enumerate(cam.discs, start=1):
        yield cam.translate("Disc {}: for {}.").format(k, _follower_text(cam, disc.problem.design))


def _follower_text(cam: TrueCam, design: Designs) -> str:
    scene = cam.scene
    contact = {
        ("roller", False): "with a roller Ø{}",
        ("roller", True): "with two rollers Ø{}",
        ("spherical", False): "with a spherical face R{}",
        ("flat", False): "with a flat face",
        ("flat", True): "with two flat faces",
        ("knife", False): "with a knife edge",
    }[scene.tip.name, scene.mechanism.drive.one_disc or cam.is_ribbed]
    radius = float(design.roller_radius[0]) * (2.0 if scene.tip.name == "roller" else 1.0)
    who = "a yoke {}" if scene.mechanism.drive.one_disc else f"{scene.mechanism.motion.words} follower {{}}"
    offset = float(design.offset[0])
    sizes = {
        "distance of the rollers {}": float(design.roller_spacing[0]),
        "arm {}": float(design.arm_length[0]),
        "distance of the pivot from the cam's axis {}": float(design.centre_distance[0]),
        "distance of the face from the pivot {}": float(design.face_offset[0]),
        f"its axis offset by {{}} to the {'right' if offset > 0 else 'left'}": abs(offset),
    }
    return ", ".join(
        [
            cam.translate(who).format(cam.translate(contact).format(length_text(radius))),
            *(cam.translate(text).format(length_text(value)) for text, value in sizes.items() if value),
        ]
    )


def _rotation_notes(cam: TrueCam) -> Iterator[str]:
    scene = cam.scene
    speed = "" if scene.cam.rpm is None else cam.translate(" at {} rev/min").format(decimal_text(scene.cam.rpm))
    if cam.problem.setup.mechanism.body.developed:
        # cam angles grow to the right; on a cam that turns ccw this is the view from inside
        side = {"cw": "outside", "ccw": "inside"}[scene.cam.rotation]
        what = "rib" if cam.is_ribbed else "groove"
        view = f"The {what} is developed at the mean radius, as seen from {side}: the cam turns"
        turn = f"{ROTATION_WORDS[scene.cam.rotation]}, as seen from above; the surface moves as the arrow shows"
        yield cam.translate(f"{view} {turn}{{}}.").format(speed)
        return
    turns = f"Turns {ROTATION_WORDS[scene.cam.rotation]}{{}} in the front view, which shows cam angle 0."
    yield cam.translate(turns).format(speed)
    tip = "roller's centre" if cam.roller_radius else "point of contact"
    point = "centre of the face" if cam.problem.setup.spherical else tip
    angles = cam.translate(f"Angles round the cam start at the direction of the {point} at cam angle 0.")
    yield angles + (
        cam.translate(" Bent lines lead to the point of contact on the profile.")
        if any(cam.contact_direction_offsets_from_rays)
        else ""
    )


def _keyway_notes(cam: TrueCam) -> Iterator[str]:
    """Notes on the angle of the keyway, if not at the timing mark, and on sizes that no view shows."""
    part = cam.part
    if not part.keyway_width:
        return
    angle = round(degrees(cam.sense * (pi / 2 - keyway_direction_angle(part))) % 360.0, 3) % 360.0
    if cam.problem.setup.mechanism.body.developed:
        where = ", where the section is" if cam.flank_height else ""
        yield cam.translate(f"The keyway is at cam angle {{}}°{where}.").format(decimal_text(angle))
        return
    if angle:
        yield cam.translate("Middle of the keyway at φ {}°.").format(decimal_text(angle))
    if not part.thickness:
        yield cam.translate("Bore and keyway: {}.").format(keyway_depth_text(part))


def _motion_notes(cam: TrueCam) -> Iterator[str]:
    """A note on the motion of the follower, or of the tool with a train, whose lift differs."""
    follower, tool = cam.problem.programme, cam.problem.programme.tool
    laws = {name: tool.law_names(kind) for name, kind in (("rise", RISE), ("return", RETURN))}
    words, before = "Lift {}", ""
    if tool is not follower:
        shown = _lift_text(follower.lift, cam.problem.setup.angular)
        words, before = (
            "Tool at the end of the train: lift {}",
            f"{cam.translate('s: lift of the follower, {}.').format(shown)} ",
        )
    named = [f"{cam.translate(name)} {law}" for name, law in laws.items() if law]
    for stroke in constant_velocity_strokes(tool):
        assert stroke.given
        velocity = stroke.given.change / stroke.given.angle
        unit = "deg/deg" if stroke.given.angular else "mm/deg"
        per = f"{'' if stroke.given.angular else ' '}{unit_in_shown_system(unit).replace('deg', '°')}"
        ends = (decimal_text(degrees(angle)) for angle in (stroke.start, stroke.end))
        text = cam.translate("θ {}° to {}° at constant velocity {}{}")
        named.append(text.format(*ends, decimal_text(to_shown_unit(velocity, unit), 5), per))
    lift = cam.translate(words).format(_lift_text(tool.lift, cam.problem.setup.tool_turns))
    yield before + "; ".join([lift, *named]) + "."


def _lift_text(lift: float, angular: bool) -> str:
    return f"{decimal_text(degrees(lift))}°" if angular else length_text(lift)


def _table_notes(cam: TrueCam) -> Iterator[str]:
    setup = cam.problem.setup
    if setup.mechanism.body.developed:
        if cam.is_ribbed:
            yield cam.translate(
                "Table: cam angle θ, lift s; centres of rollers 1, beyond the rib, and 2: x round the mean radius, "
                "y along the axis."
            )
            return
        point = cam.translate(cam.scene.tip.trace)
        lift = ", lift s; {} x" if setup.angular else "; {} x"
        along = "y along the axis." if setup.angular else "y along the axis is the lift s."
        yield cam.translate(f"Table: cam angle θ{lift} round the mean radius, {along}").format(point)
        return
    radius = cam.roller_radius
    text = cam.translate(
        "Table: cam angle θ, lift s; polar angle φ from the timing mark against the rotation, radius r."
    )
    if setup.spherical:
        text += cam.translate(" Profile: contact; centre: of the spherical face R{}.").format(length_text(radius))
    elif cam.is_ribbed:
        text += cam.translate(" Centres of rollers 1, outside of the rib, and 2, within it.")
    elif not setup.mechanism.body.bounded:
        text += cam.translate(" Centre: of the roller, or of a cutter as wide as the groove.")
    elif radius:
        text += cam.translate(" Profile: contact; centre: of the roller, or of a cutter R{}.").format(
            length_text(radius)
        )
    yield text


def _groove_notes(cam: TrueCam) -> Iterator[str]:
    """Notes on the clearance of a roller in its groove, or of a rib between rollers, and on chamfers."""
    if cam.problem.setup.mechanism.body.bounded:
        return
    if cam.is_ribbed:
        gap = 2 * (cam.problem.wall_distance_from_pitch_curve - cam.roller_radius)
        if gap:
            yield cam.translate("Clearance of the rib between its rollers {}.").format(length_text(gap, 4))
        return
    room = groove_clearance(cam)
    if room.given is not None or room.ends:
        given = f" {length_text(room.given, 4)}" if room.given is not None else ""
        ends = (
            cam.translate(", from {} to {}").format(*(length_text(end, 4) for end in room.ends))
            if room.ends
            else ""
        )
        yield cam.translate("Clearance of the roller Ø{} in its groove{}{}.").format(
            length_text(2 * cam.roller_radius), given, ends
        )
    if cam.part.groove_chamfer:
        yield cam.translate("Edges of the groove chamfered {} × 45°.").format(length_text(cam.part.groove_chamfer))


def _computed_notes(cam: TrueCam) -> Iterator[str]:
    """A note on computed results; a mass has four digits, since densities are not known better."""
    cutter = "cutter at most Ø{}", 2 * cam.problem.wall_distance_from_pitch_curve
    if not cam.problem.setup.mechanism.has_flanks_on_both_sides:
        widest = cam.quantity(CUTTER_RADIUS) or 0.0
        straight = widest > FLANK_RADIUS * cam.base_or_mean_radius
        cutter = "cutter or wheel in hollow flanks at most R{}", 0.0 if straight else widest
    results: list[tuple[str, float | None, str]] = [
        ("largest pressure angle {}°", cam.quantity("pressure_angle_max_deg"), "deg"),
        (f"at {cam.problem.setup.mechanism.body.foot} {{}}°", cam.quantity(BOTTOM_ANGLE), "deg"),
        ("smallest convex radius of the profile {}", cam.quantity("profile_radius_min_mm"), "mm"),
        ("rib at least {} thick", cam.quantity("rib_thickness_min_mm"), "mm"),
        (*cutter, "mm"),
        ("mass {}", cam.mass, "kg"),
    ]
    texts = []
    for words, value, unit in results:
        if value is not None and isfinite(value) and value > 0.0:
            mass = f"{to_shown_unit(value, unit):.4g} {unit_in_shown_system(unit)}"
            number = length_text(value) if unit == "mm" else decimal_text(value) if unit == "deg" else mass
            texts.append(cam.translate(words).format(number))
    if texts:
        text = "; ".join(texts)
        yield f"{text[0].upper()}{text[1:]}."
