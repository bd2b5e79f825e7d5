"""The cases that two commits are asked: all shipped scenes, random ones, and what the tests know to be refused."""

import math
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import slow_scenes
import tomli_w
from answers import write_case
from support.cams import cam_with
from support.pairs import pair, yoke
from support.references import REFERENCE
from support.trains import random_train

import camopt

HERE = Path(__file__).resolve().parent
TESTS = HERE.parent / "tests"
SCENES, FEW = 500, 60  # random scenes, of all cases and of quick ones
KNOWN = ("whole/test_bad_input.py", "scene/test_scene.py", "cli/test_cli.py")
"""Tests of bad input, for quick cases."""
TOLERANCE = "tolerances.profile=0.0173"
PART = {"thickness": 32.5, "bore": 17.3, "groove_depth": 7.9}
Command = tuple[str, ...]


def write_cases(folder: Path, quick: bool) -> None:
    """All cases, as files."""
    for command in (*shipped_commands(quick), *motion_commands(quick)):
        write_case(folder, " ".join(Path(word).name for word in command[:2]), {}, argv=command)
    scenes = {f"reference {name}": entry["scene"] for name, entry in REFERENCE.items()}
    asked = [(name, scene, ("evaluate", "--json")) for name, scene in scenes.items()]
    for number, scene in enumerate(random_scenes(FEW if quick else SCENES)):
        asked += [(f"random {number}", *each) for each in random_questions(number, scene)]
    for name, scene, (command, *rest) in asked:
        files = {"cam.toml": tomli_w.dumps(scene).encode()}
        write_case(folder, f"{name} {command}", files, argv=[command, "cam.toml", *rest])
    run = [sys.executable, "-m", "pytest", "-p", "recording", "-q", "-n", "auto", *(KNOWN if quick else ".")]
    environment = {**os.environ, "CASES": str(folder), "PYTHONPATH": str(HERE)}
    subprocess.run(run, cwd=TESTS, env=environment, stdout=sys.stderr, check=False)  # as refused where tests fail


# --------------------------------------------------------------------------- commands


def shipped_commands(quick: bool) -> Iterator[Command]:
    """What shipped scenes are asked; the worked cams are among them."""
    for number, name in enumerate(camopt.shipped_scenes()):
        yield ("evaluate", name, "--outputs", "all", "--json")
        yield ("certify", name, "--json")
        if not quick or number % 6 == 0:
            yield ("evaluate", name)
            yield ("optimise", name, "--json", "--seconds", "1000")
            yield ("export", name, "cam.dxf", "--json")
            yield ("timing", name, "--json")
            yield ("tolerance", name, "--set", TOLERANCE, "--json")
            yield ("sweep", name, "--samples", "5", "--json", "--out", "out")


def motion_commands(quick: bool) -> Iterator[Command]:
    """Fronts, new motions, measured ones, and lists."""
    data = TESTS / "data" / "measured"
    drawn, worn = str(data / "cam-as-drawn.toml"), str(data / "worn-cam.csv")
    yield from ((name, "--json") for name in ("laws", "keys", "scenes", "schema"))
    yield ("sweep", "--base-radius", "40:120:7.3", "--offset", "0:20:9.1", "--roller-radius", "8.7", "--json")
    yield ("sweep", "--max-pressure", "31.3", "--base-radius", "20:150:0.37", "--keep", "front-only", "--json")
    yield ("effects", "exhaust-valve", "--json")
    yield ("fit", str(data / "inlet-lift.csv"), "--base-radius", "18", "--json")
    yield ("tolerance", drawn, "--measured", worn, "--profile", "xy", "--json")
    yield ("synthesise", "roller-1000rpm", "--max-pressure", "29.3", "--json")
    if not quick:
        yield ("sweep", "--base-radius", "40:120:7.3", "--roller-radius", "8.7", "--refine", "--json")
        yield ("fit", str(data / "inlet-profile.csv"), "--profile", "xy", "--json")
        yield ("frontier", "roller-1000rpm", "--values", "4", "--json")
        yield from (("synthesise", name, "--json") for name in ("two-pauses", "valve-rod-offset"))
        yield ("tolerance", "exhaust-valve", "--set", TOLERANCE, "--cams", "50", "--json")


def random_questions(number: int, scene: dict[str, Any]) -> Iterator[tuple[dict[str, Any], Command]]:
    """What a random scene is asked, with changes: all its values, and one thing more."""
    yield scene, ("evaluate", "--outputs", "all", "--json")
    size = "base_radius" if "base_radius" in scene["cam"] else "mean_radius"
    here, limited = scene["cam"].get(size, 50.0), {"limits": {"pressure_angle": 35.7}}
    search = {"search": {size: {"start": here, "stop": 1.7 * here}}}
    questions: list[tuple[dict[str, Any], Command]] = [
        ({}, ("certify", "--json")),
        (limited, ("optimise", "--json", "--seconds", "1000")),
        ({**limited, **search}, ("sweep", "--samples", "7", "--keep", "all", "--json", "--out", "out")),
        ({"part": PART}, ("export", "cam.dxf", "--json")),
        ({"part": PART}, ("export", "cam.step", "--json")),
        ({"part": PART}, ("export", "cam.nc", "--cutter-radius", "4", "--feed", "200", "--json")),
        ({"limits": {}}, ("tolerance", "--set", TOLERANCE, "--json")),
        ({}, ("evaluate", "--points", "points.csv", "--step", "3.7")),
        ({}, ("harmonics", "--json")),
        ({}, ("evaluate", "--units", "inch")),
    ]
    changes, command = questions[number % len(questions)]
    yield {**scene, **changes}, command


# --------------------------------------------------------------------------- random scenes


def random_scenes(count: int) -> Iterator[dict[str, Any]]:
    """Random scenes of cams that can be made, with limits next to two of their values."""
    random = Random(56)
    while count:
        try:
            scene = camopt.Scene.from_dict({**random_scene(random), "search": {}, "outputs": ["all"]})
            found = camopt.evaluate(scene)
        except camopt.CamoptError:
            continue
        count -= 1
        finite = (name for name, value in found.items() if isinstance(value, float) and math.isfinite(value))
        numbers = [name for name in finite if found[name]]
        for name in random.sample(numbers, min(4, len(numbers))):
            beside = random.choice((-1.0, 1.0)) * 10.0 ** random.uniform(-12.0, -8.5)
            with suppress(camopt.BadInput):  # it is a size, or has no bound
                scene = scene.replace(**{f"limits.{name}": found[name] * (1.0 + beside)})
        yield scene.to_dict()


def random_scene(random: Random) -> dict[str, Any]:
    """A scene with random loads, train or drive, or a shipped one with other numbers; it may have no cam."""
    rng, seed = np.random.default_rng(random.getrandbits(64)), random.getrandbits(32)
    match random.choice(("loads", "train", "drive", "shipped")):
        case "loads":
            _, data = slow_scenes.random_scene(seed)
        case "train":
            stages, _, angular = random_train(rng)
            data = cam_with("arm" if angular else random.choice(("roller", "flat", "groove")))
            data["train"] = [{"stage": name, **keys} for name, keys in stages]
        case "drive":
            kind = random.choice(("translating", "oscillating", "breadth", "diameter"))
            data = (pair if kind.endswith("ating") else yoke)(rng, kind)
        case _:
            data = scaled(camopt.find_scene(random.choice(camopt.shipped_scenes())).to_dict(), random)
    for each in data.get("motion", ()):
        each |= {"law": random.choice(list(camopt.LAWS))} if "law" in each and random.random() < 0.3 else {}
    return data


def scaled(value: Any, random: Random) -> Any:
    """Numbers within tables, each a few per cent larger or smaller; a motion stays as it is."""
    if isinstance(value, dict):
        return {key: each if key == "motion" else scaled(each, random) for key, each in value.items()}
    return value * random.uniform(0.94, 1.06) if isinstance(value, float) else value
