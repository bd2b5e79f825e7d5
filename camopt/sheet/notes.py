"""The notes of a drawing: purpose, sense of rotation, contents of the table, and computed results."""

from collections.abc import Iterable, Iterator
from math import degrees, isfinite, pi

from camopt.contour.hole import keyway_turn
from camopt.effects.curvature import CUTTER
from camopt.motion.stroke import Stroke
from camopt.motion.table import RETURN, RISE
from camopt.sheet.cam import TrueCam
from camopt.sheet.marks import MEDIUM, Marks, Words, cut_lines, decimal, wrapped

FLANK_RADIUS = 100.0  # of the cam's size: the radius of a hollow that is a straight flank to any cutter
LINE_STEP = 4.2  # mm from line to line
INDENT = 6.0  # mm
NOTE_LINES = 2  # lines of one note
SENSES = {"cw": "clockwise", "ccw": "counter-clockwise"}


def notes(texts: Iterable[str], width: float) -> Marks:
    """Numbered notes of a width (mm), from their lower left corner."""
    lines: list[tuple[float, str]] = []
    for k, note in enumerate(texts, start=1):
        first, *more = cut_lines(wrapped(note, width - INDENT, MEDIUM), NOTE_LINES, width - INDENT, MEDIUM)
        lines += [(0.0, f"{k}"), (INDENT, first), *((INDENT, text) for text in more)]
    marks: Marks = []
    down = sum(1 for x, _ in lines if x)
    for x, text in lines:
        marks.append(Words(complex(x, (down - 1) * LINE_STEP + 1.0), text, MEDIUM))
        down -= x > 0.0
    return marks


def texts_of(cam: TrueCam) -> Iterator[str]:
    """The texts of the notes on a cam."""
    yield "Dimensions in mm. Projection method 1."
    yield f"For {_follower(cam)}."
    yield from _turning(cam)
    yield from _keyway(cam)
    yield from _motion(cam)
    yield from _columns(cam)
    yield from _computed(cam)


def _follower(cam: TrueCam) -> str:
    scene, design = cam.scene, cam.problem.design
    words = f"{scene.mechanism.motion.words} follower"
    radius = cam.roller
    contact = {
        "roller": f"with a roller Ø{decimal(2 * radius)}",
        "spherical": f"with a spherical face R{decimal(radius)}",
        "flat": "with a flat face",
        "knife": "with a knife edge",
    }[scene.tip.name]
    sizes = {
        "arm": float(design.arm_length[0]),
        "distance of the pivot from the cam's axis": float(design.centre_distance[0]),
        "distance of the face from the pivot": float(design.face_offset[0]),
    }
    more = [f"{name} {decimal(value)}" for name, value in sizes.items() if value]
    offset = float(design.offset[0])
    if offset:
        more.append(f"its axis offset by {decimal(abs(offset))} to the {'right' if offset > 0 else 'left'}")
    return ", ".join([f"{words} {contact}", *more])


def _turning(cam: TrueCam) -> Iterator[str]:
    scene = cam.scene
    speed = "" if scene.cam.rpm is None else f" at {decimal(scene.cam.rpm)} rpm"
    if cam.problem.setup.mechanism.body.developed:
        yield f"The surface moves as the arrow shows{speed}." if speed else "The surface moves as the arrow shows."
        return
    yield f"Turns {SENSES[scene.cam.rotation]}{speed}, as seen in the front view, which is at cam angle 0."
    yield f"Angles round the cam: from 0°, the direction of the {_trace_point(cam)} at cam angle 0."


def _trace_point(cam: TrueCam) -> str:
    setup = cam.problem.setup
    if setup.spherical:
        return "centre of the face"
    return "roller's centre" if cam.roller else "point of contact"


def _keyway(cam: TrueCam) -> Iterator[str]:
    """The angle of the keyway, if not at the timing mark; and its sizes that no view shows."""
    part = cam.part
    if not part.keyway_width:
        return
    angle = round(degrees(cam.sense * (pi / 2 - keyway_turn(part))) % 360.0, 3) % 360.0
    if cam.problem.setup.mechanism.body.developed:
        where = ", where the section is" if part.groove_depth else ""
        yield f"The keyway is at cam angle {decimal(angle)}°{where}."
        return
    if angle:
        yield f"Middle of the keyway at φ {decimal(angle)}°."
    if not part.thickness:
        yield f"Bore and keyway: {decimal((part.bore or 0.0) + (part.keyway_depth or 0.0))}."


def _motion(cam: TrueCam) -> Iterator[str]:
    problem = cam.problem
    laws = {name: problem.programme.law_names(kind) for name, kind in (("rise", RISE), ("return", RETURN))}
    lift = problem.programme.lift
    shown = f"{decimal(degrees(lift))}°" if problem.setup.angular else decimal(lift)
    named = [f"{name} {law}" for name, law in laws.items() if law]
    named += [_steady(stroke) for stroke in problem.programme.strokes if stroke.is_move and not stroke.is_free]
    yield "; ".join([f"Lift {shown}", *named]) + "."


def _steady(stroke: Stroke) -> str:
    """A stretch at constant velocity, which is often what a cam is for."""
    assert stroke.given
    velocity = stroke.given.change / stroke.given.angle
    unit = "°/°" if stroke.given.angular else " mm/°"
    ends = (decimal(degrees(angle)) for angle in (stroke.start, stroke.end))
    return f"θ {'° to '.join(ends)}° at constant velocity {decimal(velocity, 5)}{unit}"


def _columns(cam: TrueCam) -> Iterator[str]:
    setup = cam.problem.setup
    if setup.mechanism.body.developed:
        point = " ".join(cam.scene.tip.trace)
        yield f"Table: cam angle θ, lift s; {point} x round the mean radius, y along the axis."
        return
    radius = float(cam.problem.design.roller_radius[0])
    centre = "" if not radius else f" centre: of the roller, or of a cutter R{decimal(radius)}."
    if setup.spherical:
        centre = f" centre: of the spherical face R{decimal(radius)}."
    yield (
        "Table: cam angle θ, lift s; polar angle φ from the timing mark against the rotation, radius r."
        + (f" Profile: contact;{centre}" if centre else "")
    )


def _computed(cam: TrueCam) -> Iterator[str]:
    said = []
    for name, words, unit in (
        ("pressure_angle_max_deg", "largest pressure angle", "°"),
        ("profile_radius_min_mm", "least convex radius of the profile", ""),
        (CUTTER, "cutter or wheel in hollow flanks at most R", ""),
        ("cam_mass_kg", "mass", " kg"),
    ):
        value = cam.quantity(name)
        straight = name == CUTTER and value is not None and value > FLANK_RADIUS * cam.size
        if value is not None and isfinite(value) and value > 0.0 and not straight:
            said.append(f"{words} {decimal(value)}{unit}".replace("R ", "R"))
    if said:
        text = "; ".join(said)
        yield f"{text[0].upper()}{text[1:]}."
