"""What the README and the recipes say is so: scenes answer, commands print what is printed there, Python runs.

A page is a session: it runs from top to bottom in an empty folder. Parts of scenes go into that of write-a-scene.
TOML whose first line names a file is added to this file.
"""

import contextlib
import io
import re
import shlex
import tomllib
from functools import reduce
from math import isfinite
from pathlib import Path

import pytest
from support.pages import ALL, PAGES, ROOT, blocks, commands, file_of, prints

from camopt import LAWS, BadInput, Scene, evaluate, export, find_scene, optimise, sweep, synthesise
from camopt.cli.main import main
from camopt.model.motion.law import vdi_motion_task
from camopt.scene.problem.problem import resolve
from camopt.show.drawing import style

SCENES = {
    page.stem: [tomllib.loads(b.text) for b in blocks(page) if b.language == "toml" and not file_of(b)]
    for page in PAGES
}
(WHOLE,) = SCENES.pop("write-a-scene")
WITHOUT_MOTION = {"cam": {"form": "disc", "rpm": 600}, "follower": WHOLE["follower"]}
BLOCKS = [block for page in SCENES.values() for block in page]
TIMED = ("camopt accuracy",)  # prints times, and takes a minute
SLOW = {
    "ask-the-motion-at-the-tool",
    "check-cams-that-were-made",
    "choose-tolerances",
    "compute-new-laws",
    "construct-a-cam",
    "drive-by-a-pair-of-discs",
    "make-the-drawing",
    "put-several-cams-on-one-shaft",
    "read-a-pareto-front",
    "see-what-tolerances-do",
    "show-results",
    "use-another-optimiser",
}
SESSIONS = [page for page in PAGES if any(b.language == "python" or commands(b) for b in blocks(page))]


def printed_output(line):
    """What a command line prints, messages after results; those of files that were written do not count."""
    arguments, _, file = (part.strip() for part in line.partition(" > "))
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(shlex.split(arguments)[1:])
    assert code in (0, 1), err.getvalue()
    if file:
        Path(file).write_text(out.getvalue(), encoding="utf-8")
    told = [line for line in err.getvalue().splitlines() if not line.startswith(("wrote ", "camopt: compiling"))]
    return "\n".join([out.getvalue().rstrip(), *told])


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=pytest.mark.slow if page.stem in SLOW else (), id=page.stem) for page in SESSIONS],
)
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_page_runs_from_top_to_bottom(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(style, "_figure_bytes", lambda figures, suffix: b"")  # of pictures that are drawn, no files
    (tmp_path / "tests").symlink_to(ROOT / "tests")
    names: dict[str, object] = {}
    for block in blocks(page):
        if block.language == "python":
            exec(block.text, names)
        if file := file_of(block):
            with Path(file).open("a", encoding="utf-8") as written:
                written.write(block.text)
        for line, expected in commands(block):
            if line in TIMED:
                continue
            printed = printed_output(line)
            assert not expected or prints(expected, printed), printed


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_of_a_page_lead_to_files(page):
    links = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    assert [link for link in links if "://" not in link and not (page.parent / link).exists()] == []


def test_what_a_page_prints_is_compared():
    assert prints("a …\n…\nlast", "a b \nc\nd\nlast\n")
    assert not prints("a 1.5", "a 125")
    assert not prints("a …\nlast", "a b\nc\nlast")
    assert not prints("first\n…", "second")


@pytest.mark.parametrize("page", SCENES)
def test_a_scene_of_a_page_is_one(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for block in SCENES[page]:
        if drawn := block.get("profile") if "follower" in block else None:
            export(find_scene("three-arc-valve"), drawn)
            resolve(Scene.from_dict(block))
        else:
            resolve(Scene.from_dict(merge_tables(whole_scene_for(block), block)))


def whole_scene_for(block):
    """A scene that a part of another can be added to: one with a rib, or a train whose numbers are searched."""
    if block.get("drive", {}).get("kind") == "rib":
        return find_scene("bottle-filler-by-rib").to_dict()
    if "train" in block.get("search", {}):
        return find_scene("slide-by-bell-crank").to_dict()
    return WITHOUT_MOTION if "profile" in block else WHOLE


def merge_tables(under, over):
    """Two tables as one, the second above."""
    both = under.keys() & over.keys()
    tables = {key: merge_tables(under[key], over[key]) for key in both if isinstance(over[key], dict)}
    return {**under, **over, **tables}


def scene_with(table):
    """The whole scene with the one block that has a table."""
    *tables, last = table.split(".")
    found = [block for block in BLOCKS if last in reduce(lambda inner, key: inner.get(key, {}), tables, block)]
    assert len(found) == 1
    return Scene.from_dict(merge_tables(WHOLE, found[0]))


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
    (table,) = re.findall(r"(\| from .*?)\n\n", ALL, re.DOTALL)
    letters, _, *rows = [[cell.strip() for cell in row.strip("|").split("|")] for row in table.splitlines()]
    cells = {f"{row[0]}-{to}": cell for row in rows for to, cell in zip(letters[1:], row[1:], strict=True)}
    for pair, cell in cells.items():
        named = {name for name in re.findall(r"`([a-z0-9-]+)`", cell) if name in LAWS and "`mirror`" not in cell}
        assert named == {name for name, law in LAWS.items() if vdi_motion_task(law) == pair}


def test_its_profile_is_that_of_a_cam():
    (block,) = [block for block in BLOCKS if "profile" in block and "follower" not in block]
    found = evaluate(Scene.from_dict(merge_tables(WITHOUT_MOTION, block)))
    assert (found["base_radius_mm"], found["feasible"]) == (25.0, True)


def test_free_laws_hold_its_limits():
    free = synthesise(scene_with("synthesis.rest").replace(**{"synthesis.pieces": 20}))
    assert evaluate(free.scene)["feasible"]


def test_its_loads_are_all_finite():
    loaded = evaluate(
        scene_with("limits.contact_stress").replace(outputs=["force", "thrust", "hertz", "surface", "vibration"])
    )
    assert all(isfinite(value) for value in loaded.values() if isinstance(value, float))
