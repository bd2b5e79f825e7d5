"""Designs as scenes: sizes left to a search, the scene of each row, commands that take the row of a table."""

import json
from pathlib import Path

import pytest

import camopt
from camopt import BadInput, Scene, evaluate, find_scene, optimise, shipped_scenes, sweep
from camopt.cli.main import main
from camopt.model.motion import LAWS
from camopt.solve.tables.designs import Design, write_scenes

FEW = {
    "search.law": None,
    "search.base_radius": [40, 60, 80],
    "search.offset": [-6, 0, 6],
    "search.roller_radius": [5, 8],
    "search.law_rise": ["cycloidal", "poly345"],
    "search.law_return": ["harmonic", "cycloidal"],
    "limits.pressure_angle": 40,
}
CYCLOIDAL = {"search.law": "cycloidal", "limits.pressure_angle": 30, "search.roller_radius": [10]}
FREE = {"search.angle_rise": {"start": 60, "stop": 180}, "search.angle_dwell": {"start": 10, "stop": 180}}


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def without_size(scene, *more):
    """The scene without the size of its cam."""
    return scene.replace(**{"cam.base_radius": None, "cam.mean_radius": None}, **dict.fromkeys(more))


def assert_alike(row, cam, rel=0.0):
    """Whether an evaluation has every quantity of a row (but how exactly it is known), to a share of it."""
    shared = row.keys() & cam.keys() - {"relative_half_width"}
    assert {"base_radius_mm", "mean_radius_mm"} & shared
    assert {"law_rise", "feasible"} < shared
    near = {n: pytest.approx(row[n], rel=rel, abs=0.0) if isinstance(row[n], float) else row[n] for n in shared}
    return {n: cam[n] for n in shared} == near


# ------------------------------------------------------------------------------------------ sizes not given


@pytest.mark.parametrize("name", ["two-pauses", "flat-reciprocating", "oscillating-roller"])
def test_optimise_needs_no_size_of_the_cam(name):
    scene = find_scene(name).replace(**{"limits.curvature_radius": 3, "search": None})
    assert optimise(without_size(scene)).by_law == optimise(scene).by_law


def test_a_sweep_needs_no_size_that_its_search_has():
    scene = find_scene("roller-1000rpm").replace(**FEW)
    assert sweep(without_size(scene, "follower.roller_radius")).best == sweep(scene).best
    with pytest.raises(BadInput, match=r"^roller-1000rpm: cam\.base_radius: missing; only commands that find"):
        sweep(without_size(scene).replace(**{"search.base_radius": None}))


@pytest.mark.parametrize(
    "command", [evaluate, camopt.cam_points, camopt.certify, lambda s: camopt.plot(s, "x.svg")]
)
def test_one_design_needs_every_size(command):
    scene = without_size(find_scene("roller-1000rpm").replace(**FEW), "follower.roller_radius")
    with pytest.raises(BadInput) as error:
        command(scene)
    lines = [line.split(": missing")[0] for line in str(error.value).splitlines()]
    assert lines == ["roller-1000rpm: cam.base_radius", "roller-1000rpm: follower.roller_radius"]
    assert not list(Path().iterdir())


# ------------------------------------------------------------------------------------------ the scene of a design


@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", [name for name in shipped_scenes() if not find_scene(name).profile])
def test_the_scene_of_an_optimum_has_its_digits(name):
    scene = find_scene(name).replace(**{"search.law": ["cycloidal"], "limits.curvature_radius": 3})
    found = optimise(scene)
    for law, design in found.by_law.items():
        assert assert_alike(design, evaluate(design.scene))
        assert {s.law for s in design.scene.motion} - {None} == {law} - {""}  # a turn of moves has no law
        assert Scene.from_dict(design.scene.to_dict()) == design.scene


@pytest.mark.slow
def test_the_scene_of_an_optimum_has_its_angles():
    scene = find_scene("roller-1000rpm").replace(**FREE, **CYCLOIDAL)
    best = optimise(scene).best
    assert [segment.angle for segment in best.scene.motion] == best["angles_deg"]
    assert assert_alike(best, evaluate(best.scene))


@pytest.mark.slow
@pytest.mark.parametrize("change", [{}, {"follower.contact": "spherical", "follower.roller_radius": None,
                                         "follower.face_radius": 30, "search.roller_radius": None,
                                         "search.face_radius": [20, 30]}])  # fmt: skip
def test_rows_of_a_sweep_are_scenes(change):
    scene = find_scene("roller-1000rpm").replace(**{**FEW, **change})
    found = sweep(scene, ".")
    for design in [*found.best.values(), found.front.knee]:
        assert assert_alike(design, evaluate(design.scene), rel=2e-9)
    table = camopt.load("designs.parquet")
    for label in table.index[::7]:
        cam = evaluate(camopt.scene_of("designs.parquet", label))
        assert assert_alike(table.loc[label].to_dict(), cam, rel=2e-9)
    label = table[table.offset_mm == 6].index[-1]
    assert camopt.scene_of(table[table.offset_mm == 6], label) == camopt.scene_of("designs.parquet", label)


def test_laws_one_after_the_other_stay_those_of_the_scene():
    motion = [
        {"segment": "rise", "angle": 60, "lift": 5, "law": "cycloidal"},
        {"segment": "rise", "angle": 60, "lift": 5, "law": "harmonic"},
        {"segment": "return", "angle": 240, "lift": 10, "law": "poly345"},
    ]
    scene = find_scene("two-pauses").replace(motion=motion, **{"search.law_return": ["modified-sine"]})
    best = optimise(scene).best
    assert best["law_rise"] == "cycloidal+harmonic"
    assert [s.law for s in best.scene.motion] == ["cycloidal", "harmonic", "modified-sine"]
    assert assert_alike(best, evaluate(best.scene))


def test_a_nearest_miss_is_a_scene():
    scene = find_scene("roller-1000rpm").replace(**{**FEW, "limits.pressure_angle": 5})
    miss = sweep(scene).nearest_miss
    assert assert_alike(miss, evaluate(miss.scene), rel=2e-9)


def test_a_quantity_that_a_design_has_not_names_the_nearest():
    best = optimise(find_scene("two-pauses")).best
    with pytest.raises(KeyError) as error:
        best["presure_angle_max_deg"]
    assert str(error.value).startswith(
        "'presure_angle_max_deg' is not a quantity of this design; did you mean pressure_"
    )


def test_tables_without_a_scene_or_the_row_are_refused():
    sweep(find_scene("roller-1000rpm").replace(**FEW), ".")
    table = camopt.load("designs.parquet")
    with pytest.raises(
        BadInput, match=rf"row = {len(table)}: must be a row of designs.parquet, which has {len(table)}"
    ):
        camopt.scene_of("designs.parquet", len(table))
    table.attrs = {}
    with pytest.raises(BadInput, match="the table has lost it, as after a merge, or camopt did not write it"):
        camopt.scene_of(table, 0)


# ------------------------------------------------------------------------------------------ commands


def run(capsys, *arguments):
    code = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    return code, out, err


def test_optimise_writes_the_scene_of_each_law(capsys):
    Path("mine.toml").write_text(
        without_size(find_scene("roller-1000rpm")).replace(**FEW).to_toml(), encoding="utf-8"
    )
    code, out, err = run(capsys, "optimise", "mine.toml", "--out", "best", "--json")
    by_law = json.loads(out)["by_law"]
    files = {f"best/optimum-{law.replace(' / ', '-')}.toml": row for law, row in by_law.items()}
    assert code == 0
    assert len(files) == 4
    assert sorted(f"wrote {file}" for file in files) == sorted(err.splitlines())
    for file, row in files.items():
        cam = evaluate(Scene.from_toml(file)).to_dict()
        assert {n: cam[n] for n in cam if n != "unbounded"} == {n: row[n] for n in cam if n != "unbounded"}


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("Pusher A", "optimum-Pusher-A.toml"),
        ("../../etc/x", "optimum-..-..-etc-x.toml"),
        ("…", "optimum-moves.toml"),
        ("ö" * 500, f"optimum-{'ö' * 100}.toml"),
    ],
)
def test_a_cam_of_moves_has_a_file_with_the_name_of_its_scene(name, file, tmp_path):
    scene = find_scene("belt-matching").replace(name=name)
    assert optimise_by_law(scene, tmp_path) == [tmp_path / file]
    assert Scene.from_toml(tmp_path / file).name == name


def optimise_by_law(scene, folder):
    design = Design(evaluate(scene), scene)
    return write_scenes({"": design}, folder)


def test_no_two_cams_have_one_file(tmp_path):
    design = Design(evaluate(find_scene("two-pauses")), find_scene("two-pauses"))
    files = write_scenes(dict.fromkeys(("a / b", "a-b", "a-b~2", "a b"), design), tmp_path)
    assert len({*files}) == len([*tmp_path.iterdir()]) == 4


def test_optimise_does_not_write_over_its_own_scene(capsys):
    run(capsys, "optimise", "two-pauses", "--max-pressure", 30, "--out", "best")
    (own,) = Path("best").glob("*.toml")
    before = own.read_bytes()
    code, _, err = run(capsys, "optimise", own, "--out", "best")
    assert (code, own.read_bytes()) == (2, before)
    assert "--out = 'best': must be another folder" in err


@pytest.mark.slow
def test_commands_take_a_row_of_a_table(capsys):
    sweep(find_scene("roller-1000rpm").replace(**FEW), ".")
    row = camopt.load("designs.parquet").loc[3]
    target = ("designs.parquet", "--row", 3)
    _, out, _ = run(capsys, "evaluate", *target, "--json", "--plot", "cam.svg", "--points", "cam.csv")
    assert json.loads(out)["base_radius_mm"] == row.base_radius_mm
    assert Path("cam.svg").exists()
    assert Path("cam.csv").exists()
    before = Path("designs.parquet").read_bytes()
    assert run(capsys, "certify", *target, "--json")[0] == 0
    assert Path("designs.parquet").read_bytes() == before
    code, _, err = run(capsys, "evaluate", "designs.parquet")
    assert (code, err) == (2, "camopt: SCENE = 'designs.parquet': is a table: choose a row with --row\n")
    code, _, err = run(capsys, "evaluate", "roller-1000rpm", "--row", 3)
    assert (code, err) == (2, "camopt: --row = 3: needs a table; roller-1000rpm is a scene\n")


def test_every_law_has_a_file_of_its_own(capsys):
    laws = ["cycloidal", "harmonic"]
    Path("mine.toml").write_text(find_scene("roller-1000rpm").replace(**{"search.law": laws}).to_toml())
    run(capsys, "optimise", "mine.toml", "--out", "best", "--max-pressure", 30)
    assert sorted(path.name for path in Path("best").iterdir()) == [
        ".camopt",
        "manifest.json",
        *(f"optimum-{law}.toml" for law in laws),
    ]
    assert set(laws) < set(LAWS)
