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
import tomli_w
from answers import write_case
from support import loaded_scenes
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
TOLERANCE = "--set tolerances.profile=0.0173 --json"
PART = {"thickness": 32.5, "bore": 17.3, "groove_depth": 7.9}
EVERY_SCENE = ("evaluate {} --outputs all --json", "certify {} --json")
FEW_SCENES = (
    *("evaluate {}", "optimise {} --json --seconds 1000", "export {} cam.dxf --json", "timing {} --json"),
    *(f"tolerance {{}} {TOLERANCE}", "sweep {} --samples 5 --json --out out"),
)
"""What shipped scenes are asked, the worked cams among them; the second of each sixth one in quick cases."""
COMMANDS = (
    *("laws --json", "keys --json", "scenes --json", "schema --json", "effects exhaust-valve --json"),
    "sweep --base-radius 40:120:7.3 --offset 0:20:9.1 --roller-radius 8.7 --json",
    "sweep --max-pressure 31.3 --base-radius 20:150:0.37 --keep front-only --json",
    "fit {data}/inlet-lift.csv --base-radius 18 --json",
    "tolerance {data}/cam-as-drawn.toml --measured {data}/worn-cam.csv --profile xy --json",
    "synthesise roller-1000rpm --max-pressure 29.3 --json",
)
MORE_COMMANDS = (
    "sweep --base-radius 40:120:7.3 --roller-radius 8.7 --refine --json",
    "fit {data}/inlet-profile.csv --profile xy --json",
    "frontier roller-1000rpm --values 4 --json",
    *("synthesise two-pauses --json", "synthesise valve-rod-offset --json"),
    f"tolerance exhaust-valve --cams 50 {TOLERANCE}",
)


def write_cases(folder: Path, quick: bool) -> None:
    """All cases, as files."""

    def ask(group: str, text: str, name: str = "", scene: dict[str, Any] | None = None) -> None:
        words = [word.format(name, data=TESTS / "data" / "measured") for word in text.split()]
        files = {name: tomli_w.dumps(scene).encode()} if scene else {}
        write_case(folder, f"{group} {words[0]} {'' if scene else Path(words[1]).name}".strip(), files, argv=words)

    for text in COMMANDS + (() if quick else MORE_COMMANDS):
        ask("other", text)
    for number, name in enumerate(camopt.shipped_scenes()):
        for text in EVERY_SCENE + (() if quick and number % 6 else FEW_SCENES):
            ask("shipped", text, name)
    for name, entry in REFERENCE.items():
        ask(f"reference {name}", EVERY_SCENE[0], "cam.toml", entry["scene"])
    for name, scene in loaded_scenes.named_scenes().items():
        ask(f"slow {name}", FEW_SCENES[1], "cam.toml", scene)
    for number, scene in enumerate(random_scenes(FEW if quick else SCENES)):
        for changes, text in random_questions(number, scene):
            ask(f"random {number}", text, "cam.toml", scene | changes)
    run = [sys.executable, "-m", "pytest", "-p", "recording", "-q", "-n", "auto", *(KNOWN if quick else ".")]
    environment = {**os.environ, "CASES": str(folder), "PYTHONPATH": str(HERE)}
    subprocess.run(run, cwd=TESTS, env=environment, stdout=sys.stderr, check=False)  # as refused where tests fail


def random_questions(number: int, scene: dict[str, Any]) -> tuple[tuple[dict[str, Any], str], ...]:
    """What a random scene is asked, with changes: all its values, and one thing more."""
    size = "base_radius" if "base_radius" in scene["cam"] else "mean_radius"
    here, limited = scene["cam"].get(size, 50.0), {"limits": {"pressure_angle": 35.7}}
    search = {"search": {size: {"start": here, "stop": 1.7 * here}}}
    questions: list[tuple[dict[str, Any], str]] = [
        ({}, "certify {} --json"),
        (limited, "optimise {} --json --seconds 1000"),
        ({**limited, **search}, "sweep {} --samples 7 --keep all --json --out out"),
        ({"part": PART}, "export {} cam.dxf --json"),
        ({"part": PART}, "export {} cam.step --json"),
        ({"part": PART}, "export {} cam.nc --cutter-radius 4 --feed 200 --json"),
        ({"limits": {}}, f"tolerance {{}} {TOLERANCE}"),
        ({}, "evaluate {} --points points.csv --step 3.7"),
        ({}, "harmonics {} --json"),
        ({}, "evaluate {} --units inch"),
    ]
    return ({}, EVERY_SCENE[0]), questions[number % len(questions)]


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
            _, data = loaded_scenes.random_scene(seed)
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
