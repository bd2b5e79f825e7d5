"""What the README prints as a scene is one: each block, put into the first, answers."""

import re
import tomllib
from functools import reduce
from math import isfinite
from pathlib import Path

import pytest

from camopt import LAWS, BadInput, Scene, evaluate, optimise, sweep, synthesise
from camopt.motion.law import pair_of

TEXT = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
BLOCKS = [tomllib.loads(block) for block in re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)]
WHOLE = BLOCKS[0]


def merged(under, over):
    """Two tables as one, the second above."""
    both = under.keys() & over.keys()
    tables = {key: merged(under[key], over[key]) for key in both if isinstance(over[key], dict)}
    return {**under, **over, **tables}


def scene_with(table):
    """The README's scene with one of its later blocks."""
    *tables, last = table.split(".")
    found = [block for block in BLOCKS[1:] if last in reduce(lambda inner, key: inner.get(key, {}), tables, block)]
    assert len(found) == 1
    return Scene.from_dict(merged(WHOLE, found[0]))


def test_the_scene_is_swept_as_written(tmp_path):
    assert sweep(Scene.from_dict(WHOLE), tmp_path).feasible


def test_the_scene_is_optimised_and_a_limit_holds_it():
    assert all(row["binding"] for row in optimise(Scene.from_dict(WHOLE)).by_law.values())


def test_free_angles_make_the_cam_smaller():
    free = scene_with("search.angle_rise")
    assert optimise(free).best["base_radius_mm"] < optimise(Scene.from_dict(WHOLE)).best["base_radius_mm"]
    with pytest.raises(BadInput, match=r"angle_rise: a sweep takes the angles of the scene"):
        sweep(free)


def test_its_own_laws_are_laws():
    own = scene_with("laws")
    own = own.replace(**{"search.law_rise": list(own.laws)})
    assert all(row["feasible"] for row in optimise(own).by_law.values())


def test_its_table_has_every_law_between_what_it_joins():
    (table,) = re.findall(r"(\| from .*?)\n\n", TEXT, re.DOTALL)
    letters, _, *rows = [[cell.strip() for cell in row.strip("|").split("|")] for row in table.splitlines()]
    cells = {f"{row[0]}-{to}": cell for row in rows for to, cell in zip(letters[1:], row[1:], strict=True)}
    for pair, cell in cells.items():
        named = {name for name in re.findall(r"`([a-z0-9-]+)`", cell) if name in LAWS and "`mirror`" not in cell}
        assert named == {name for name, law in LAWS.items() if pair_of(law) == pair}


def test_its_profile_is_that_of_a_cam():
    (block,) = [block for block in BLOCKS if "profile" in block]
    cam = {"form": "disc", "rpm": WHOLE["cam"]["rpm"]}
    found = evaluate(Scene.from_dict({"cam": cam, "follower": WHOLE["follower"], **block}))
    assert (found["base_radius_mm"], found["feasible"]) == (25.0, True)


def test_free_laws_hold_its_limits():
    free = synthesise(scene_with("synthesis").replace(**{"synthesis.pieces": 20}))
    assert evaluate(free.scene)["feasible"]


def test_its_loads_are_all_finite():
    loaded = evaluate(scene_with("follower").replace(outputs=["force", "thrust", "hertz", "surface", "vibration"]))
    assert all(isfinite(value) for value in loaded.values() if isinstance(value, float))
