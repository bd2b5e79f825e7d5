"""Exercises for students: a problem with round numbers and a cam that can be made, and its scene."""

from random import Random
from textwrap import wrap
from typing import Any

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.mechanisms.elements import (
    CYLINDER,
    DISC,
    FLAT,
    KNIFE,
    OSCILLATING,
    ROLLER,
    SPHERICAL,
    TRANSLATING,
    Body,
    FollowerMotion,
    Tip,
)
from camopt.scene.scene import Scene
from camopt.solve.verdicts.evaluation import evaluate

LARGEST_PRESSURE_ANGLE = 30.0  # deg
LAW_WORDS = {
    "uniform": "uniform velocity",
    "harmonic": "simple harmonic motion",
    "parabolic": "uniform acceleration and retardation",
    "cycloidal": "cycloidal motion",
}
"""Names of the laws that have a construction."""
TIP_WORDS = {KNIFE: "knife-edge", SPHERICAL: "spherical-faced", FLAT: "flat-faced", ROLLER: "roller"}
EXERCISE_KINDS: dict[str, tuple[Body, FollowerMotion, Tip]] = {
    "knife": (DISC, TRANSLATING, KNIFE),
    "offset-knife": (DISC, TRANSLATING, KNIFE),
    "roller": (DISC, TRANSLATING, ROLLER),
    "offset-roller": (DISC, TRANSLATING, ROLLER),
    "spherical": (DISC, TRANSLATING, SPHERICAL),
    "flat": (DISC, TRANSLATING, FLAT),
    "oscillating-roller": (DISC, OSCILLATING, ROLLER),
    "oscillating-flat": (DISC, OSCILLATING, FLAT),
    "barrel": (CYLINDER, TRANSLATING, ROLLER),
    "barrel-arm": (CYLINDER, OSCILLATING, ROLLER),
}
"""Kinds of exercises: body of the cam, motion of the follower, and its tip."""


def make_exercise(kind: str, seed: int) -> tuple[str, Scene]:
    """The text of a problem and its scene, without undercut and with a pressure angle of at most 30°.

    Raises
    ------
    BadInput
        If there is no such kind.
    """
    if kind not in EXERCISE_KINDS:
        raise BadInput([Mistake("camopt", "exercise", kind, f"one of {', '.join(EXERCISE_KINDS)}")])
    random = Random(f"{kind} {seed}")
    while True:
        scene = Scene(**_random_scene_tables(kind, random))
        try:
            values = evaluate(scene)
        except BadInput:
            continue
        faulty = values["undercut"] or values.get("self_crossing", False)
        if not faulty and float(values["pressure_angle_max_deg"]) <= LARGEST_PRESSURE_ANGLE:
            return _problem_text(kind, scene), scene


def exercise_toml(kind: str, seed: int) -> str:
    """The TOML of an exercise: its problem as comments, then its scene."""
    problem, scene = make_exercise(kind, seed)
    return "".join(f"# {line}\n" for line in wrap(problem, 100)) + "\n" + scene.to_toml()


def _random_scene_tables(kind: str, random: Random) -> dict[str, Any]:
    body, motion, tip = EXERCISE_KINDS[kind]
    base = random.randrange(30, 105, 5)
    follower: dict[str, Any] = {"motion": motion.name, "contact": tip.name}
    if tip.radius:
        follower[tip.radius] = random.choice([7.5, 8, 10, 12.5, 15])
    if kind.startswith("offset"):
        follower["offset"] = random.choice([10, 12, 15, 20])
    if motion.angular and body.developed:
        follower["arm_length"] = random.randrange(60, 125, 5)
    elif motion.angular:
        centre, difference = base + random.randrange(50, 105, 5), random.choice([5, 10, 15])
        size = {"face_offset": 0} if tip is FLAT else {"arm_length": centre - difference}
        follower |= {"centre_distance": centre, **size}
    rise, dwell, fall = (random.randrange(*ends, 10) for ends in ((90, 160), (20, 70), (90, 140)))
    lift = random.choice([10, 12, 15, 18, 20] if motion.angular else [15, 20, 25, 30, 40])
    laws = random.choices([law for law in LAW_WORDS if law != "uniform" or tip is not FLAT], k=2)
    moves = [
        {"segment": "rise", "angle": rise, "lift": lift, "law": laws[0]},
        {"segment": "dwell", "angle": dwell},
        {"segment": "return", "angle": fall, "lift": lift, "law": laws[1]},
        {"segment": "dwell", "angle": 360 - rise - dwell - fall},
    ]
    rpm, rotation = random.choice([100, 150, 200, 240, 300, 500, 600]), random.choice(["cw", "ccw"])
    cam = {"form": body.form, "rotation": rotation, "rpm": rpm, body.size_key: base}
    return {"name": f"Exercise: {kind}", "cam": cam, "follower": follower, "motion": moves}


def _follower_sentences(body: Body, motion: FollowerMotion, tip: Tip, rotation: str) -> list[str]:
    """Sentences on the position of the follower, so that the problem has one solution."""
    if body.developed and motion.angular:
        return [
            "Develop the cylinder so that the follower moves over it to the right.",
            "The arm is square to the axis of the cylinder in the middle of its swing, and outwards is upwards.",
            f"Its pivot is to the {'right' if rotation == 'ccw' else 'left'} of the roller.",
        ]
    if body.developed:
        return ["Develop the cylinder so that the follower moves over it to the right; outwards is upwards."]
    if motion.angular and tip is FLAT:
        return [
            "The pivot is level with the cam's axis.",
            "The line of the face passes through the pivot, above the cam.",
        ]
    if motion.angular:
        return ["The pivot is level with the cam's axis, and the arm lies above the line between them."]
    face = " The face is square to the line of stroke." if tip is FLAT else ""
    return [f"The line of stroke is vertical, and the follower is above the cam.{face}"]


def _problem_text(kind: str, scene: Scene) -> str:
    """The text of the problem."""
    cam, follower, (rise, dwell, fall, rest) = scene.cam, scene.follower, scene.motion
    body, motion, tip = EXERCISE_KINDS[kind]
    unit, way = "°" if motion.angular else " mm", "clockwise" if cam.rotation == "cw" else "anticlockwise"
    sizes = {
        "roller_radius": "The radius of the roller is {:g} mm.",
        "face_radius": "The radius of its face is {:g} mm.",
        "offset": "Its line of stroke is offset by {:g} mm to the right of the cam's axis.",
        "arm_length": "Its arm, from the pivot to the centre of the roller, is {:g} mm long.",
        "centre_distance": "The pivot is {:g} mm to the right of the cam's axis.",
    }
    size_sentences = [
        words.format(value) for key, words in sizes.items() if (value := getattr(follower, key, None))
    ]
    size = "mean radius of the cylinder" if body.developed else "smallest radius of the cam"
    sentences = [
        f"A {body.words} turns {way} at {cam.rpm:g} rev/min and drives {motion.words} {TIP_WORDS[tip]} follower.",
        f"The {size} is {getattr(cam, body.size_key):g} mm.",
        *size_sentences,
        *_follower_sentences(body, motion, tip, cam.rotation),
        f"The follower moves outwards by {rise.lift:g}{unit} during {rise.angle:g}° "
        f"with {LAW_WORDS[str(rise.law)]}, rests during {dwell.angle:g}°, "
        f"comes back during {fall.angle:g}° with {LAW_WORDS[str(fall.law)]}, "
        f"and rests during the remaining {rest.angle:g}°.",
        "Divide each stroke into six equal parts, and construct the displacement diagram and the profile of "
        "the cam.",
        "Find the largest velocity and acceleration of the follower on both strokes.",
    ]
    return " ".join(sentences)
