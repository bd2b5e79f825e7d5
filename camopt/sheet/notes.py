"""The notes of a drawing: what the cam is for, how it turns, what the table lists, and what was computed."""

from collections.abc import Iterator
from math import degrees, isfinite

import numpy as np

from camopt.drawing.picture import Picture
from camopt.effects import Case, offered
from camopt.motion.table import RETURN, RISE
from camopt.sheet.hole import keyway_turn
from camopt.sheet.marks import MEDIUM, Marks, Words, number, wrapped
from camopt.verdicts.judging import run_effects

STEP = 4.2  # mm from line to line
SENSES = {"cw": "clockwise", "ccw": "counter-clockwise"}


def notes(picture: Picture, width: float) -> Marks:
    """Numbered notes of a width (mm), from their lower left corner."""
    lines: list[tuple[float, str]] = []
    for k, note in enumerate(_texts(picture), start=1):
        first, *more = wrapped(note, width - 6.0, MEDIUM)
        lines += [(0.0, f"{k}"), (6.0, first), *((6.0, text) for text in more)]
    marks: Marks = []
    down = sum(1 for x, _ in lines if x)
    for x, text in lines:
        marks.append(Words(complex(x, (down - 1) * STEP + 1.0), text, MEDIUM))
        down -= x > 0.0
    return marks


def _texts(picture: Picture) -> Iterator[str]:
    yield "Dimensions in mm. Projection method 1."
    yield f"For {_follower(picture)}."
    yield from _turning(picture)
    yield from _keyway(picture)
    yield from _motion(picture)
    yield from _columns(picture)
    yield from _computed(picture)


def _follower(picture: Picture) -> str:
    follower, design = picture.problem.scene.follower, picture.problem.design
    words = f"{'an' if follower.motion == 'oscillating' else 'a'} {follower.motion} follower"
    radius = float(design.roller_radius[0])
    contact = {
        "roller": f"with a roller Ø{number(2 * radius)}",
        "spherical": f"with a spherical face R{number(radius)}",
        "flat": "with a flat face",
        "knife": "with a knife edge",
    }[follower.contact]
    sizes = {
        "arm": float(design.arm_length[0]),
        "distance of the pivot from the cam's axis": float(design.centre_distance[0]),
        "distance of the face from the pivot": float(design.face_offset[0]),
    }
    more = [f"{name} {number(value)}" for name, value in sizes.items() if value]
    offset = float(design.offset[0])
    if offset:
        more.append(f"its axis offset by {number(abs(offset))} to the {'right' if offset > 0 else 'left'}")
    return ", ".join([f"{words} {contact}", *more])


def _turning(picture: Picture) -> Iterator[str]:
    scene = picture.problem.scene
    speed = "" if scene.cam.rpm is None else f" at {number(scene.cam.rpm)} rpm"
    if picture.problem.setup.mechanism.grooved:
        yield f"The surface moves as the arrow shows{speed}." if speed else "The surface moves as the arrow shows."
        return
    flat = picture.problem.setup.mechanism.curvature is None
    towards = "point of contact" if flat or picture.problem.setup.pointed else "roller's centre"
    towards = "centre of the face" if picture.problem.setup.spherical else towards
    yield (
        f"Turns {SENSES[scene.cam.rotation]}{speed}, as seen in the front view; drawn at cam angle 0, "
        f"where the timing mark is towards the {towards}."
    )


def _keyway(picture: Picture) -> Iterator[str]:
    """Where the keyway is, if not at the timing mark."""
    problem, part = picture.problem, picture.problem.scene.whole_part
    if not part.keyway_width or problem.setup.mechanism.grooved:
        return
    start = float(np.angle(picture.curves[0].pitch[0]))
    angle = round(degrees(problem.design.sense * (start - keyway_turn(part))) % 360.0, 3) % 360.0
    if angle:
        yield f"Middle of the keyway at φ {number(angle)}°."


def _motion(picture: Picture) -> Iterator[str]:
    problem = picture.problem
    laws = {name: problem.programme.law_names(kind) for name, kind in (("rise", RISE), ("return", RETURN))}
    lift = problem.programme.lift
    shown = f"{number(degrees(lift))}°" if problem.setup.angular else number(lift)
    named = [f"{name} {law}" for name, law in laws.items() if law]
    yield "; ".join([f"Lift {shown}", *named]) + "."


def _columns(picture: Picture) -> Iterator[str]:
    setup = picture.problem.setup
    if setup.mechanism.grooved:
        yield "Table: cam angle θ, lift s; roller centre x round the mean radius, y along the axis."
        return
    radius = float(picture.problem.design.roller_radius[0])
    centre = "" if not radius else f" centre: of the roller, or of a cutter R{number(radius)}."
    if setup.spherical:
        centre = f" centre: of the spherical face R{number(radius)}."
    yield (
        "Table: cam angle θ, lift s; polar angle φ from the timing mark against the rotation, radius r."
        + (f" Profile: contact;{centre}" if centre else "")
    )


def _computed(picture: Picture) -> Iterator[str]:
    values = {**picture.values, **_mass(picture)}
    said = []
    for name, words, unit in (
        ("pressure_angle_max_deg", "largest pressure angle", "°"),
        ("profile_radius_min_mm", "least convex radius of the profile", ""),
        ("cutter_radius_max_mm", "cutter or wheel in hollow flanks at most R", ""),
        ("cam_mass_kg", "mass", " kg"),
    ):
        value = values.get(name)
        if isinstance(value, float) and isfinite(value) and value > 0.0:
            said.append(f"{words} {number(value)}{unit}".replace("R ", "R"))
    if said:
        text = "; ".join(said)
        yield f"{text[0].upper()}{text[1:]}."


def _mass(picture: Picture) -> dict[str, float]:
    """The mass of the part, if its sizes and its density are known."""
    setup = picture.problem.setup
    if "cam_mass_kg" not in offered(setup):
        return {}
    case = Case(setup, picture.problem.programme, picture.problem.design)
    return {"cam_mass_kg": float(run_effects(case, ["cam_mass_kg"]).column("cam_mass_kg")[0])}
