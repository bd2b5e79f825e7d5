"""The command line: what it prints and writes, its exit codes, and that it never shows a traceback."""

import json
import os
import re
import subprocess
import sys
from math import isinf
from pathlib import Path

import pandas as pd
import pytest
import tomli_w

import camopt
from camopt import Scene, find_machine, find_scene, shipped_machines, shipped_scenes
from camopt.cli import commands
from camopt.cli.main import GROUPS, MODULE_BY_COMMAND, main
from camopt.cli.main import camopt as camopt_group
from camopt.core.quantities import QUANTITIES, quantity_name_by_number_key
from camopt.model.motion import LAWS

ROOT = Path(__file__).parents[2]
WORKED = json.loads((Path(__file__).parents[1] / "data" / "worked-examples.json").read_text())
SMALL = ["--base-radius", "40:120:5", "--offset", "0:20:10", "--roller-radius", "8", "--law", "harmonic"]
HOPELESS = ["--base-radius", "40:60:10", "--offset", "0", "--roller-radius", "5", "--law", "harmonic"]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def run(capsys):
    """Run a command: exit code, standard output, standard error."""

    def call(*arguments):
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        assert "Error(" not in out + err
        return code, out, err

    return call


@pytest.fixture
def run_json(run):
    """Run a command with --json: exit code and the one document on standard output."""

    def refuse(constant):
        raise AssertionError(f"{constant} in JSON")

    def call(*arguments):
        code, out, err = run(*arguments, "--json")
        assert all(re.match(r"camopt: (compiling|objectives|[\d,]+ of )|wrote ", line) for line in err.splitlines())
        return code, json.loads(out, parse_constant=refuse)

    return call


def files_here():
    return sorted(str(path) for path in Path().rglob("*") if path.is_file())


def scene_file(changes, base="roller-1000rpm", name="mine.toml"):
    Path(name).write_text(find_scene(base).replace(**changes).to_toml(), encoding="utf-8")
    return name


def broken_file(text, name="broken.toml"):
    Path(name).write_text(text, encoding="utf-8")
    return name


# ------------------------------------------------------------------------------------------ evaluate


@pytest.mark.parametrize("name", WORKED)
def test_evaluate_gives_the_numbers_of_the_sources(run_json, name):
    code, found = run_json("evaluate", name)
    assert code == 0
    for quantity, expected in WORKED[name]["expected"].items():
        if isinstance(expected, bool):
            assert found[quantity] is expected
        elif isinf(float(expected)):
            assert found[quantity] is None
            assert quantity in found["unbounded"]
        else:
            assert found[quantity] == pytest.approx(float(expected), rel=1e-12, abs=1e-12)


def test_evaluate_has_the_keys_of_the_contract(run_json):
    _, found = run_json("evaluate", "roller-1000rpm")
    motion = {f"{name}_max{stroke}_m_s{power}" for name, power in (("velocity", ""), ("acceleration", "2"), ("jerk", "3"))
              for stroke in ("_rise", "_return", "")}  # fmt: skip
    angles = {f"pressure_angle_max_{part}deg" for part in ("", "rise_", "return_", "at_")}
    sizes = {"law_rise", "law_return", "base_radius_mm", "roller_radius_mm", "prime_radius_mm", "offset_mm"}
    curvature = {"pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm", "profile_radius_min_mm", "undercut"}
    assert motion | angles | sizes | curvature | {"feasible", "violated", "unbounded"} <= set(found)
    assert found["violated"] == "pressure_angle"
    assert found["unbounded"]["jerk_max_m_s3"].startswith("the acceleration jumps at ")


def test_a_scene_without_rpm_gives_derivatives_by_cam_angle(run_json):
    _, linear = run_json("evaluate", "uniform-knife-radial")
    assert {"velocity_max_rise_mm_per_rad", "acceleration_max_mm_per_rad2", "jerk_max_mm_per_rad3"} <= set(linear)
    _, angular = run_json("evaluate", "oscillating-roller")
    assert {"velocity_max_rise_deg_per_rad", "acceleration_max_deg_per_rad2"} <= set(angular)
    assert not [name for name in (*linear, *angular) if name.endswith(("_m_s", "_rad_s", "_s2", "_s3"))]


def test_evaluate_shows_every_quantity(run, run_json):
    code, text, _ = run("evaluate", "roller-1000rpm")
    _, found = run_json("evaluate", "roller-1000rpm")
    assert code == 0
    assert not [name for name in found if name not in text and name != "unbounded"]
    assert "∞" in text


def test_what_is_not_checked_of_an_arm_is_said(run):
    said = "Whether the cam meets the arm or its pivot is not checked."
    assert said in run("evaluate", "oscillating-roller")[1]
    assert said not in run("evaluate", "roller-1000rpm")[1]


def test_overrides_reach_the_result(run_json):
    _, plain = run_json("evaluate", "roller-1000rpm")
    _, fast = run_json("evaluate", "roller-1000rpm", "--rpm", "2000")
    assert fast["velocity_max_m_s"] == pytest.approx(2 * plain["velocity_max_m_s"], rel=1e-14)
    assert fast["acceleration_max_m_s2"] == pytest.approx(4 * plain["acceleration_max_m_s2"], rel=1e-14)
    verdicts = {
        ("--max-pressure", "45"): "",
        ("--max-pressure", "20"): "pressure_angle,pressure_angle_return",
        ("--max-pressure-return", "20"): "pressure_angle,pressure_angle_return",
        ("--max-pressure", "45", "--max-pressure-return", "20"): "pressure_angle_return",
        ("--max-pressure", "45", "--min-curvature", "36"): "curvature_radius",
        ("--max-pressure", "45", "--min-curvature", "35"): "",
        ("--relative-error", "1e-12"): "pressure_angle",
    }
    for options, violated in verdicts.items():
        _, found = run_json("evaluate", "roller-1000rpm", *options)
        assert (found["violated"], found["feasible"]) == (violated, not violated), options


def test_a_file_of_the_user_is_evaluated(run_json):
    name = scene_file({"cam.base_radius": 95, "limits.pressure_angle": 31})
    code, found = run_json("evaluate", name)
    assert (code, found["base_radius_mm"], found["feasible"]) == (0, 95.0, True)


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_points_are_written(run, suffix):
    code, _, _ = run("evaluate", "two-pauses", "--points", f"curve.{suffix}")
    assert code == 0
    table = pd.read_csv("curve.csv") if suffix == "csv" else camopt.load("curve.parquet")
    assert len(table) == 361
    assert files_here() == [f"curve.{suffix}"]


# ------------------------------------------------------------------------------------------ sweep


def test_sweep_counts_writes_and_gives_the_best(run_json):
    code, found = run_json("sweep", *SMALL, "--out", "there")
    assert code == 0
    assert found["designs"] == 17 * 3
    assert 0 < found["pareto"] <= found["feasible"] < found["designs"]
    assert found["impossible"] == 0
    assert found["nearest_miss"] is None
    assert found["best"] == found["by_law"]["harmonic"]
    assert found["best"]["feasible"] is True
    files = ["there/designs.parquet", "there/pareto.parquet", "there/scene.toml"]
    assert sorted(Path(file).as_posix() for file in found["files"]) == files
    assert files_here() == sorted([*files, "there/.camopt/lock", "there/manifest.json"])
    assert len(pd.read_parquet("there/designs.parquet")) == found["feasible"]
    front = camopt.load("there/pareto.parquet")
    assert len(front) == found["pareto"]
    assert front["base_radius_mm"].min() == found["best"]["base_radius_mm"]
    assert front.attrs["units"]["base_radius_mm"] == "mm"


@pytest.mark.slow
@pytest.mark.usefixtures("_boxes")
def test_a_sweep_of_the_front_alone_tells_what_boxes_decided(run, run_json, tmp_path):
    axes = ("--base-radius", "40:90:0.5", "--offset", "-10:20:10", "--roller-radius", "5:20:5", "--quiet")
    front_only = ("sweep", *axes, "--keep", "front-only", "--out", str(tmp_path / "alone"))
    _, usual = run_json("sweep", *axes, "--out", str(tmp_path / "usual"))
    code, alone = run_json(*front_only)
    assert (code, alone["front"], alone["best"]) == (0, usual["front"], usual["best"])
    assert (alone["feasible"], alone["impossible"]) == (None, None)
    assert alone["evaluated"] < alone["designs"] <= alone["evaluated"] + alone["decided_by_boxes"]
    assert (usual["evaluated"], usual["decided_by_boxes"]) == (usual["designs"], 0)
    code, out, _ = run(*front_only)
    counts = f"{alone['decided_by_boxes']:,} decided by boxes, {alone['evaluated']:,} evaluated"
    assert (code, counts in out) == (0, True)
    code, out, _ = run(*front_only, "--max-pressure", "1")
    assert code == 1
    assert "No feasible design" in out


def test_the_scene_of_a_sweep_makes_the_same_sweep(run_json):
    _, first = run_json("sweep", *SMALL, "--rpm", "700", "--max-pressure", "35", "--out", "a")
    _, second = run_json("sweep", "a/scene.toml", "--out", "b")
    assert Scene.from_toml("a/scene.toml") == Scene.from_toml("b/scene.toml")
    assert Scene.from_toml("a/scene.toml").cam.rpm == 700.0
    assert {**first, "files": 0} == {**second, "files": 0}
    assert Path("a/pareto.parquet").read_bytes() == Path("b/pareto.parquet").read_bytes()


@pytest.mark.parametrize("keep", ["pareto", "feasible", "all"])
def test_keep_chooses_the_rows(run_json, keep):
    code, found = run_json("sweep", *SMALL, "--keep", keep)
    rows = {"pareto": found["pareto"], "feasible": found["feasible"], "all": found["designs"] - found["impossible"]}
    table = pd.read_parquet("camopt-out/designs.parquet")
    assert (code, len(table)) == (0, rows[keep])
    assert bool(table["feasible"].all()) == (keep != "all")
    assert not table.isna().any(axis=None)


def test_impossible_designs_are_counted_and_in_no_table(run_json):
    options = ["--base-radius", "10:100:10", "--offset", "30", "--roller-radius", "5", "--law", "harmonic"]
    _, found = run_json("sweep", *options, "--keep", "all")
    assert (found["designs"], found["impossible"]) == (10, 2)
    assert len(pd.read_parquet("camopt-out/designs.parquet")) == 8


def test_axes_take_ranges_and_values_and_laws_repeat(run_json):
    options = ["--base-radius", "90:100:4", "--offset", "-5", "--roller-radius", "4:6:1", "--law", "harmonic",
               "--law", "cycloidal"]  # fmt: skip
    _, found = run_json("sweep", *options, "--keep", "all")
    table = pd.read_parquet("camopt-out/designs.parquet")
    assert found["designs"] == len(table) == 3 * 3 * 2
    assert set(table["base_radius_mm"]) == {90.0, 94.0, 98.0}
    assert set(table["offset_mm"]) == {-5.0}
    assert set(table["roller_radius_mm"]) == {4.0, 5.0, 6.0}
    assert set(table["law_rise"]) == set(table["law_return"]) == {"harmonic", "cycloidal"}


def test_any_number_of_workers_gives_the_same_tables(run):
    for workers in ("1", "2", "5"):
        code, _, _ = run("sweep", *SMALL, "--keep", "all", "--workers", workers, "--out", workers)
        assert code == 0
    for name in ("designs.parquet", "pareto.parquet"):
        first = pd.read_parquet(f"1/{name}")
        for other in ("2", "5"):
            pd.testing.assert_frame_equal(first, pd.read_parquet(f"{other}/{name}"), check_exact=True)
            assert Path(f"1/{name}").read_bytes() == Path(f"{other}/{name}").read_bytes()


def test_without_a_feasible_design_the_nearest_miss_is_told(run, run_json):
    code, found = run_json("sweep", *HOPELESS)
    assert code == 1
    assert (found["feasible"], found["pareto"], found["best"], found["by_law"]) == (0, 0, None, {})
    assert found["nearest_miss"]["base_radius_mm"] == 60.0
    assert "pressure_angle_return" in found["nearest_miss"]["violated"]
    assert len(pd.read_parquet("camopt-out/pareto.parquet")) == 0
    code, text, _ = run("sweep", *HOPELESS)
    assert code == 1
    assert "nearest miss" in text
    assert "pressure_angle" in text


@pytest.mark.slow
def test_a_miss_that_is_found_when_time_is_over_is_told_as_the_least_so_far(run):
    code, text, _ = run("optimise", "roller-1000rpm", "--max-pressure", "3", "--seconds", "1e-9")
    assert code == 1
    assert "No feasible design before the search stopped. Nearest miss so far:" in text
    assert "more `seconds` may prove this cam" in text
    assert "nearest miss" not in text


def test_a_space_without_a_possible_design_is_told(run, run_json):
    options = ["--base-radius", "10:20:5", "--offset", "30", "--roller-radius", "5", "--law", "harmonic"]
    code, found = run_json("sweep", *options)
    assert (code, found["designs"], found["impossible"], found["nearest_miss"]) == (1, 3, 3, None)
    assert run("sweep", *options)[0] == 1


def test_a_sweep_needs_no_search_table(run_json):
    code, found = run_json("sweep", "harmonic-240rpm-radial", "--base-radius", "30:60:10")
    assert (code, found["designs"]) == (0, 4)
    assert Scene.from_toml("camopt-out/scene.toml").search.minimise[0] == "base_radius_mm"


# ------------------------------------------------------------------------------------------ optimise


@pytest.mark.slow
def test_optimise_gives_the_best_of_each_law_and_what_binds_it(run_json):
    code, found = run_json("optimise", "roller-1000rpm")
    assert code == 0
    assert set(found["by_law"]) | set(found["obstacles"]) == set(find_scene("roller-1000rpm").search.law)
    best = min(found["by_law"].values(), key=lambda row: row["base_radius_mm"])
    assert {key: found[key] for key in best} == best
    assert "pressure_angle" in found["binding"]
    _, evaluated = run_json("evaluate", "roller-1000rpm")
    assert set(evaluated) - {"unbounded"} <= set(found)


def test_optimise_says_what_bounds_cost(run, run_json):
    code, found = run_json("optimise", "two-pauses", "--max-pressure", "30")
    (price,) = found["prices"]["harmonic / parabolic"]
    assert code == 0
    assert price["key"] == "limits.pressure_angle"
    assert (price["bound"], price["unit"], price["relation"]) == (30.0, "deg", "≤")
    assert price["price"] == price["tightened"] == pytest.approx(-2.930, abs=1e-3)
    assert (price["size_without"], price["next"]) == (20.0, ["cam.shaft_diameter"])
    _, text, _ = run("optimise", "two-pauses", "--max-pressure", "30")
    for cell in ("limits.pressure_angle ", "≤ 30 deg", "−2.93 mm per deg", "20 mm", "40.8913 deg"):
        assert cell in text
    assert "—" not in text


def test_optimise_without_time_has_prices_alone(run):
    _, text, _ = run("optimise", "two-pauses", "--max-pressure", "30", "--seconds", "1e-6")
    assert "What each limit costs" in text
    assert "tightened" not in text
    assert "—" in text
    assert "— in the size without a limit or tolerance: not proved before the search stopped" in text


def test_optimise_shows_both_prices_where_one_bound_would_be_enough(run):
    turn = find_scene("two-pauses").to_dict()["motion"]
    motion = [{**each, "angle": 90, **({"law": "harmonic"} if "law" in each else {})} for each in turn]
    limits = {"pressure_angle": 30, "pressure_angle_return": 30}
    name = scene_file({"motion": motion, "limits": limits, "follower.offset": 0}, "two-pauses")
    _, text, _ = run("optimise", name)
    assert "tightened" in text


def test_optimize_is_optimise(run_json):
    name = scene_file({"search.law": "harmonic"})
    assert run_json("optimize", name) == run_json("optimise", name)


def test_optimise_takes_overrides(run_json):
    name = scene_file({"search.law": "harmonic"})
    sizes = [run_json("optimise", name, "--max-pressure", limit)[1]["base_radius_mm"] for limit in (25, 30, 35)]
    assert sizes == sorted(sizes, reverse=True)
    assert len(set(sizes)) == 3


def test_an_optimum_that_is_not_there_names_the_limit(run, run_json):
    name = scene_file({"search.law": "harmonic", "search.base_radius": [20], "search.roller_radius": [5]})
    code, found = run_json("optimise", name)
    assert (code, found["by_law"]) == (1, {})
    assert "pressure_angle" in found["obstacles"]["harmonic"]
    code, text, _ = run("optimise", name)
    assert code == 1
    assert "harmonic: no feasible design; stopped by pressure_angle" in text


# ------------------------------------------------------------------------------------------ laws, scenes


def test_laws_are_listed_with_their_peaks(run, run_json):
    code, found = run_json("laws")
    assert (code, [record["law"] for record in found]) == (0, list(LAWS))
    peaks = {record["law"]: record for record in found}
    assert peaks["cycloidal"]["peak_velocity"] == pytest.approx(2.0, rel=1e-12)
    assert peaks["uniform"]["peak_acceleration"] is None
    assert "peak_acceleration" in peaks["uniform"]["unbounded"]
    assert (peaks["uniform"]["joins"], peaks["uniform"]["peak_acceleration_inside"]) == ("G-G", 0.0)
    code, text, _ = run("laws")
    assert code == 0
    assert all(law in text for law in LAWS)
    assert "multiply these peaks by h/β, h/β² and h/β³" in " ".join(run("laws")[1].split())


def test_scenes_are_listed_and_printed(run, run_json):
    code, found = run_json("scenes")
    assert (code, [record["name"] for record in found]) == (0, [*shipped_scenes(), *shipped_machines()])
    assert {record["kind"] for record in found if record["name"] in shipped_machines()} == {"machine"}
    code, text, _ = run("scenes")
    assert code == 0
    assert all(name in text for name in (*shipped_scenes(), "Shipped machines", *shipped_machines()))
    code, text, _ = run("scenes", "two-pauses")
    assert code == 0
    Path("copy.toml").write_text(text, encoding="utf-8")
    assert Scene.from_toml("copy.toml") == find_scene("two-pauses")
    code, found = run_json("scenes", "two-pauses")
    assert found == {"name": "two-pauses", "toml": text}


def test_a_key_that_only_machines_have_is_found(run_json):
    code, found = run_json("keys", "clear.along")
    assert (code, [key["key"] for key in found]) == (0, ["clear.along"])


def test_a_shipped_machine_is_printed_and_its_copy_is_that_machine(run):
    code, text, _ = run("scenes", "pick-and-place")
    assert code == 0
    Path("copy.toml").write_text(text, encoding="utf-8")
    copy, shipped = find_machine("copy.toml"), find_machine("pick-and-place")
    assert (copy.scenes, copy.motors) == (shipped.scenes, shipped.motors)
    assert run("machine", "copy.toml")[0] == 0


# ------------------------------------------------------------------------------------------ bad input: 2

BAD_INPUT = [
    (["frobnicate"], "No such command 'frobnicate'"),
    (["sweep", "--frob"], "No such option"),
    (["sweep", "--rpm", "fast"], "'fast' is not a valid float"),
    (["sweep", "--rpm", "-1"], "camopt: --rpm = -1.0: must be at least"),
    (["sweep", "--rpm", "nan"], "--rpm = nan: must be a finite number"),
    (["evaluate", "two-pauses", "--rpm", "inf"], "--rpm = inf: must be a finite number"),
    (["sweep", "--max-pressure", "90"], "--max-pressure = 90.0: must be below 90"),
    (["sweep", "--max-pressure-return", "0"], "--max-pressure-return = 0.0: must be at least 1e-09"),
    (["optimise", "--min-curvature", "-1"], "--min-curvature = -1.0: must be at least 1e-09"),
    (["optimise", "--tolerance", "1"], "--relative-error = 1.0: must be at most 0.01"),
    (["sweep", "--base-radius", "20:150:1:2"], "'20:150:1:2' is neither START:STOP:STEP nor one number"),
    (["sweep", "--base-radius", "a:b:c"], "'a:b:c' is neither START:STOP:STEP nor one number"),
    (["sweep", "--base-radius", ""], "'' is neither START:STOP:STEP nor one number"),
    (["sweep", "--base-radius", "150:20:1"], "--base-radius = {'start': 150.0, 'stop': 20.0, 'step': 1.0}: must"),
    (["sweep", "--base-radius", "20:150:0"], "--base-radius = 0.0: must be at least 1e-09"),
    (["sweep", "--base-radius", "nan:1:1"], "--base-radius = nan: must be a finite number"),
    (["sweep", "--base-radius", "-5"], "--base-radius = [-5.0]: must be above 0"),
    (["sweep", "--law", "harmonik"], "--law = 'harmonik': must be a motion law; did you mean harmonic?"),
    (["sweep", "--keep", "some"], "'some' is not one of 'pareto', 'feasible', 'all'"),
    (["sweep", "--workers", "0"], "0 is not in the range x>=1"),
    (["sweep", "flat-reciprocating", "--roller-radius", "5"], "--roller-radius = [5.0]: a disc cam with a"),
    (["evaluate"], "Missing argument 'SCENE'"),
    (["report", "roler-1000rpm"], "WHAT = 'roler-1000rpm': must be a TOML file, a shipped scene, a table of designs"),
    (["certify", "roler-1000rpm"], "(.parquet); did you mean roller-1000rpm?"),
    (["evaluate", "roler-1000rpm"], "SCENE = 'roler-1000rpm': must be a TOML file, a shipped scene, or a table"),
    (["sweep", "two_pauses"], "did you mean two-pauses?"),
    (["optimise", "nowhere.toml"], "SCENE = 'nowhere.toml': must be a TOML file"),
    (["evaluate", "."], "SCENE = '.': must be a TOML file"),
    (["scenes", "exaust-valve"], "did you mean exhaust-valve?"),
    (["scenes", "packr"], "did you mean packer?"),
    (["optimise", "packer"], "packer is a machine: use camopt machine packer"),
    (["evaluate", "two-pauses", "extra"], "unexpected extra argument"),
    (["sweep", "--base-radius", "20:150:1e-9"], "a range of at most 10,000,000 values; this one has 130,000,000,000"),
    (["evaluate", "two-pauses", "--cutter-radius", "5"], "--cutter-radius = 5.0: needs --points"),
    (["evaluate", "exhaust-valve", "--points", "c.csv", "--cutter-radius", "90"], "above 0 and at most 66.8"),
    (["frontier", "exhaust-valve", "--pointz", "3"], "Did you mean --out?"),
    (["evaluate", "two-pauses", "--points", "curve.xyz"], "curve.xyz"),
    (["evaluate", "two-pauses", "--plot", "curve.xyz"], "curve.xyz"),
    (["evaluate", "two-pauses", "--points", "c.csv", "--cutter-radius", "-1"], "--cutter-radius = -1.0: must be above"),
    (["frontier", "two-pauses", "--axes", "size"], "--axes = 'size': must be two or three different axes"),
    (["frontier", "two-pauses", "--out", "new", "--scheduler", "x"], "--scheduler = 'x': must be the address of a Dask"),
    (["export", "two-pauses", "cam.xyz"], "FILE = 'cam.xyz': must be a file that ends in"),
    (["compare", "two-pauses", "two-pause"], "(.parquet) or a folder that a command wrote; did you"),
    (["report", "two-pauses", "--out", "page.txt"], "--out = 'page.txt': must be a file that ends in .html"),
]  # fmt: skip


@pytest.mark.parametrize("as_json", [[], ["--json"]])
@pytest.mark.parametrize(("arguments", "message"), BAD_INPUT)
def test_a_mistake_is_told_on_standard_error_and_nothing_is_written(run, arguments, message, as_json):
    code, out, err = run(*arguments, *as_json)
    assert (code, out, files_here()) == (2, "", [])
    assert not Path("camopt-out").exists()
    told = " ".join(err.split())
    assert message in told or message in told.replace("'", "")  # click quotes options since 8.4


@pytest.mark.parametrize("command", ["sweep", "optimise", "evaluate"])
def test_every_mistake_of_a_file_is_told_at_once(run, command):
    text = find_scene("roller-1000rpm").to_toml().replace("rpm = 1000.0", "rmp = 1000.0")
    text = text.replace("roller_radius = 5.0", "roller_radius = -5.0").replace("angle = 120.0", "angle = 110.0")
    name = broken_file(text)
    code, out, err = run(command, name)
    lines = err.strip().removeprefix("camopt: ").split("\n")
    assert (code, out, len(lines)) == (2, "", 3)
    assert all(line.startswith("broken.toml: ") for line in lines)
    assert "cam.rmp = 1000.0: not a known key; did you mean rpm?" in lines[0]
    assert "follower.roller_radius = -5.0: must be at least 1e-09" in lines[1]
    assert "the angles add up to 350 deg" in lines[2]
    assert files_here() == ["broken.toml"]


@pytest.mark.parametrize("command", ["evaluate", "certify", "report"])
def test_set_mends_and_completes_a_file_before_it_is_checked(run, command):
    text = find_scene("roller-1000rpm").to_toml().replace("rpm = 1000.0", "rpm = -1.0")
    name = broken_file(text.replace('contact = "roller"\n', "").replace("angle = 120.0", "angle = 110.0"))
    more = ("--out", "page.html") if command == "report" else ()
    mends = ("cam.rpm=730", "follower.contact=roller", "motion.1.angle=120")
    code, _, err = run(command, name, *more, *(word for each in mends for word in ("--set", each)))
    assert (code in (0, 1), err.count("must be")) == (True, 0)
    for left, line in (
        (mends[1:], "broken.toml: cam.rpm = -1.0: must be at least 1e-09"),
        (mends[::2], "broken.toml: follower.contact: missing"),
        (mends[:2], "broken.toml: motion.angle: the angles add up to 350 deg, not to 360"),
    ):
        code, out, err = run(command, name, *more, *(word for each in left for word in ("--set", each)))
        assert (code, out, len(err.splitlines())) == (2, "", 1)
        assert err.startswith(line)
    wrong = ("--set", "motion.9.lift=3", "--set", "part.thickness=-4")
    code, _, err = run(command, name, *more, *wrong, "--set", mends[0], "--set", mends[2])
    assert (code, sorted(line.partition(": ")[0] for line in err.splitlines())) == (
        2,
        ["broken.toml", "camopt", "camopt"],
    )
    assert "camopt: --set motion.9.lift = 3: there is no table 9: [[motion]] has" in err


def test_set_says_what_a_search_varies_of_a_file_that_it_mends(run_json):
    scene = find_scene("roller-1000rpm").to_dict()
    scene["search"] = {"cam": {"rpm": [100, 200]}, "base_radius": [170.0]}
    scene["cam"]["rpm"] = 100
    del scene["follower"]["contact"]
    name = broken_file(tomli_w.dumps(scene))
    code, _ = run_json("sweep", name, "--set", "follower.contact=roller", "--rpm", "730", "--out", "out")
    assert code == 0
    assert Scene.from_toml("out/scene.toml").search.numbers == {"cam.rpm": (730.0,)}


@pytest.mark.parametrize("value", ["4140", "'4140'"])
def test_a_material_is_a_text_even_if_it_is_a_number(run, value):
    code, _, err = run("evaluate", "two-pauses", "--set", f"part.material={value}")
    assert (code, err) == (0, "")


@pytest.mark.slow
def test_a_front_can_be_refined_and_thinned(run_json):
    code, grid = run_json("sweep", *SMALL, "--out", "grid")
    assert code == 0
    assert grid["front"]["points"] == grid["pareto"]
    assert set(grid["front"]["knee"]) >= {"law_rise", "base_radius_mm"}
    code, fine = run_json("sweep", *SMALL, "--refine", "--thin", "0.05", "--out", "fine")
    assert code == 0
    assert "fine/pareto-grid.parquet" in fine["files"]
    assert fine["front"]["grid_points"] == grid["pareto"]
    assert fine["front"]["hypervolume"] > fine["front"]["grid_hypervolume"]
    assert 10 <= fine["pareto"] <= 60
    search = Scene.from_toml("fine/scene.toml").search
    assert (search.refine, search.thin) == (True, 0.05)


@pytest.mark.slow
def test_the_screen_tells_hypervolume_and_knee(run):
    code, out, _ = run("sweep", *SMALL, "--refine")
    assert code == 0
    assert "Hypervolume of the Pareto front" in out
    assert "Its knee" in out


def test_a_thinning_beyond_its_range_names_the_option(run):
    code, out, err = run("sweep", *SMALL, "--thin", "2")
    assert (code, out) == (2, "")
    assert "camopt: --thin = 2.0: must be below 1" in err
    assert files_here() == []


def test_a_sweep_needs_steps_and_quantities_of_the_scene(run):
    name = scene_file({"search.offset": {"start": 0, "stop": 5}, "search.minimise": ["mean_radius_mm"]})
    code, out, err = run("sweep", name, *SMALL[:2], "--law", "harmonic")
    assert (code, out) == (2, "")
    assert "search.minimise = 'mean_radius_mm': must be a quantity of this scene" in err
    name = scene_file({"search.offset": {"start": 0, "stop": 5}})
    code, out, err = run("sweep", name, "--base-radius", "90", "--law", "harmonic")
    assert (code, out) == (2, "")
    assert "search.offset.step: must be above 0 for a sweep" in err
    assert files_here() == ["mine.toml"]


@pytest.mark.parametrize("command", ["evaluate", "optimise", "sweep"])
def test_an_output_that_the_mechanism_has_not_is_told(run, command):
    name = scene_file({"outputs": ["face_reach_max_mm"], "search.law": "harmonic", "search.base_radius": 90})
    code, out, err = run(command, name)
    assert (code, out) == (2, "")
    assert "face_reach_max_mm" in err


def test_outputs_without_the_size_can_be_optimised(run_json):
    name = scene_file({"outputs": ["undercut"], "search.minimise": None, "search.law": "harmonic"})
    code, found = run_json("optimise", name)
    assert code == 0
    assert found["undercut"] is False


@pytest.mark.slow
def test_a_limit_that_no_size_can_hold_stops_at_once(run_json):
    name = scene_file({"search.law": "harmonic", "limits.acceleration": 5})
    code, found = run_json("optimise", name)
    assert (code, found["obstacles"]) == (1, {"harmonic": "acceleration"})


# ------------------------------------------------------------------------------------------ file trouble: 3


@pytest.mark.parametrize("out", ["taken", "taken/inside", "/proc/nothing/inside"])
def test_a_folder_that_cannot_be_written_is_told(run, out):
    Path("taken").write_text("here first", encoding="utf-8")
    code, text, err = run("sweep", *SMALL, "--out", out)
    assert (code, text) == (3, "")
    assert err.startswith("camopt: ")
    assert files_here() == ["taken"]
    assert Path("taken").read_text(encoding="utf-8") == "here first"


@pytest.mark.parametrize("option", ["--points", "--plot"])
def test_a_file_that_cannot_be_written_is_told(run, option):
    suffix = "csv" if option == "--points" else "png"
    code, text, err = run("evaluate", "two-pauses", option, f"nowhere/curve.{suffix}")
    assert (code, text) == (3, "")
    assert "nowhere" in err
    assert files_here() == []


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("table", ["designs.parquet", "pareto.parquet", "pareto-grid.parquet", "scene.toml"])
def test_a_folder_in_place_of_a_table_is_told(run, table):
    Path("camopt-out", table).mkdir(parents=True)
    code, text, err = run("sweep", *SMALL, "--refine")
    assert (code, text) == (3, "")
    assert err.splitlines()[-1] == f"camopt: camopt-out/{table}: Is a directory"
    assert not [name for name in files_here() if "partial" in name]


# ------------------------------------------------------------------------------------------ processes


def process(*arguments, **options):
    command = [sys.executable, "-m", "camopt", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, **{"encoding": "utf-8", **options})


def test_a_process_gives_the_exit_code_and_one_document():
    done = process("evaluate", "roller-1000rpm", "--json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["prime_radius_mm"] == 55.0
    missed = process("sweep", *HOPELESS, "--json")
    assert missed.returncode == 1
    assert json.loads(missed.stdout)["best"] is None
    mistaken = process("evaluate", "nowhere")
    assert (mistaken.returncode, mistaken.stdout) == (2, "")
    assert "Traceback" not in mistaken.stderr


def test_quiet_says_nothing_on_standard_error():
    done = process("evaluate", "two-pauses", "--quiet", "--json")
    assert (done.returncode, done.stderr) == (0, "")


def test_the_help_lists_each_command_once_with_a_whole_sentence(run):
    _, out, _ = run("--help")
    listed = dict(re.findall(r"^  (\w+) +(\S.*)$", out.partition("\nStart:\n")[2], re.MULTILINE))
    assert [*listed] == [*MODULE_BY_COMMAND]
    assert {sentence for sentence in listed.values() if not sentence.endswith(".") or "..." in sentence} == set()
    assert re.findall(r"^(\w[\w ]*):$", out, re.MULTILINE)[1:] == [*GROUPS]


@pytest.mark.parametrize("name", MODULE_BY_COMMAND)
def test_the_help_of_a_command_has_each_option_once(run, name):
    _, out, _ = run(name, "--help")
    options = [option for given in camopt_group.commands[name].params for option in given.opts[:1]]
    groups = re.split(r"^\w[\w ]*:$", out, maxsplit=1, flags=re.MULTILINE)[1]
    shown = re.findall(r"^  (?:-h, )?(--[\w-]+)", groups, re.MULTILINE)
    hidden = {given.opts[0] for given in camopt_group.commands[name].params if getattr(given, "hidden", False)}
    assert sorted(shown) == sorted({"--help", *(each for each in options if each.startswith("-"))} - hidden)


def test_evaluate_says_its_verdict_first_and_meanings_if_asked(run):
    for scene, verdict in (
        ("valve-rod-radial", "Feasible: "),
        ("roller-1000rpm", "Not feasible: the design breaks pressure_angle "),
    ):
        _, short, _ = run("evaluate", scene)
        _, long, _ = run("evaluate", scene, "--long")
        assert short.startswith(verdict)
        assert long.startswith(verdict)
        assert "Largest pressure angle |β| over the turn." in long
        assert "Largest pressure angle |β| over the turn." not in short


def test_without_a_command_there_is_the_help(run):
    assert run() == run("--help")
    assert run()[0] == 0


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["sweep", "--help"]])
def test_help_imports_nothing_heavy(arguments):
    code = (
        "import sys\nfrom camopt.cli.main import main\ncode = main(sys.argv[1:])\n"
        "heavy = {'numpy', 'numba', 'pandas', 'pyarrow', 'scipy', 'pydantic', 'rich', 'matplotlib'} & set(sys.modules)\n"
        "assert not heavy, heavy\nsys.exit(code)"
    )
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "camopt" in done.stdout


def test_every_module_of_commands_is_known():
    modules = {path.stem for path in Path(commands.__file__).parent.glob("*.py")}
    assert modules == {"__init__", *MODULE_BY_COMMAND.values()}
    assert len(MODULE_BY_COMMAND) == sum(map(len, GROUPS.values()))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("command", MODULE_BY_COMMAND)
def test_a_command_imports_no_other_module_of_commands(command):
    code = (
        "import sys\nfrom camopt.cli.main import main\nmain(sys.argv[1:])\n"
        "found = [name for name in sys.modules if name.startswith('camopt.cli.commands.')]\n"
        "sys.exit(' '.join(found))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, command, "--help"], capture_output=True, text=True, timeout=60
    )
    assert done.stderr.strip() == f"camopt.cli.commands.{MODULE_BY_COMMAND[command]}"


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("command", ["evaluate", "certify", "laws", "scenes"])
def test_one_design_needs_no_compiler(command):
    """Its formulas run as they are written: numba takes half a second to import."""
    scene = [] if command in ("laws", "scenes") else ["exhaust-valve"]
    code = (
        "import sys\nfrom camopt.cli.main import main\nmain(sys.argv[1:])\n"
        "sys.exit(str({'numba', 'scipy', 'pandas', 'pyarrow', 'cvxpy', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code, command, *scene], capture_output=True, text=True, timeout=60)
    assert done.stderr.strip() == "set()"


def test_a_reader_that_goes_away_is_no_trouble():
    command = f'"{sys.executable}" -m camopt laws | head -n 1; exit "${{PIPESTATUS[0]}}"'
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60)
    assert "Traceback" not in done.stderr
    assert "Exception" not in done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such names")
def test_a_folder_whose_name_is_no_text_holds_results(run):
    folder = os.fsdecode(b"a\xff")
    assert run("sweep", "--out", folder, *SMALL)[0] == 0
    assert run("certify", f"{folder}/pareto.parquet")[0] == 0
    assert run("check", folder)[0] == 0
    assert run("compare", folder, folder, "--out", f"{folder}/differences.parquet")[0] == 0
    for part in ("1/2", "2/2"):
        assert run("sweep", "--part", part, "--out", f"{folder}/parts", *SMALL)[0] == 0
    assert run("merge", f"{folder}/parts", "--out", f"{folder}/whole")[0] == 0
    assert run("report", folder, "--out", f"{folder}/page.html")[0] == 0
    tables = [camopt.load(Path(folder, *whole, "designs.parquet")) for whole in ((), ("whole",))]
    assert len(tables[0]) == len(tables[1]) > 0


def test_a_sweep_does_not_overwrite_the_scene_it_reads(run):
    name = scene_file({}, name="scene.toml")
    before = Path(name).read_text(encoding="utf-8")
    code, out, err = run("sweep", name, *SMALL, "--out", ".")
    assert (code, out, files_here()) == (2, "", ["scene.toml"])
    assert "--out = '.': must be another folder" in err
    assert Path(name).read_text(encoding="utf-8") == before


@pytest.mark.slow
def test_a_law_with_corners_stops_a_roller_at_any_size(run_json):
    name = scene_file({"search.law": "uniform"})
    code, found = run_json("optimise", name)
    assert (code, found["obstacles"]) == (1, {"uniform": "curvature_radius, undercut"})
    assert found["nearest_miss"]["violated"] == "curvature_radius,undercut"


def test_one_limit_on_the_pressure_angle_has_one_price(run_json):
    """As option or as key of the scene: a cam that both strokes hold costs what both do."""
    stroke, dwell = {"angle": 90, "lift": 20, "law": "cycloidal"}, {"segment": "dwell", "angle": 90}
    motion = [{"segment": "rise", **stroke}, dwell, {"segment": "return", **stroke}, dwell]
    kept = {"motion": motion, "search": {"law": ["cycloidal"]}, "follower.offset": 0}
    _, keyed = run_json("optimise", scene_file(kept | {"limits": {"pressure_angle": 35}}))
    own = scene_file(kept | {"limits": {"pressure_angle_return": 20}})
    _, given = run_json("optimise", own, "--max-pressure", "35")
    assert keyed["base_radius_mm"] == given["base_radius_mm"]
    (price,) = keyed["prices"]["cycloidal"]
    assert given["prices"] == {"cycloidal": [price]}
    assert price["price"] < -1.0


def test_a_pressure_angle_limits_the_return_too(run_json):
    scene = {"limits": {"pressure_angle": 45}, "follower.offset": -20}
    _, found = run_json("evaluate", scene_file(scene))
    assert (found["violated"], found["pressure_angle_max_rise_deg"] < 45) == ("pressure_angle_return", True)
    _, found = run_json("evaluate", scene_file(scene | {"limits.pressure_angle_return": 60}))
    assert found["violated"] == ""


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
@pytest.mark.parametrize("arguments", [["laws"], ["evaluate", "exhaust-valve"]])
def test_a_narrow_encoding_is_no_trouble(encoding, arguments):
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "NUMBA_DISABLE_JIT": "1"}
    done = process(*arguments, env=environment, encoding=encoding)
    assert (done.returncode, "Traceback" in done.stderr) == (0, False)


@pytest.mark.slow
def test_nothing_is_cut_off_in_a_pipe():
    environment = {**os.environ, "COLUMNS": "60"}
    text = process("sweep", *SMALL, env=environment).stdout
    assert "pressure_angle" in text
    assert "held" in text
    assert "acceleration_max_rise_deg_per_rad2" in process("evaluate", "oscillating-roller", env=environment).stdout


@pytest.mark.parametrize("command", [["evaluate", "roller-1000rpm"], ["sweep", *SMALL]])
def test_a_tolerance_out_of_reach_is_told(run, command):
    code, out, err = run(*command, "--relative-error", "1e-14")
    assert (code, bool(out)) == (4, True)
    assert "relative error of 1e-14 not reached; values are exact to" in err
    assert run(*command)[0] == 0


def test_rows_say_how_exact_they_are(run):
    for tolerance in (1e-4, 1e-9, 1e-12):
        run("sweep", *SMALL, "--keep", "all", "--relative-error", tolerance)
        table = pd.read_parquet("camopt-out/designs.parquet")
        assert (table["status"] == "certified").all()
        assert (table["relative_half_width"] <= tolerance).all()


SPRING = {"spring_rate": 200, "preload": 5, "load": [[0, 1], [180, 2]], "damping": 0.1}
READ = {
    "valve-rod-radial": {"spring_rate": "200 N/mm", "preload": "5 N", "load": "2 rows N", "damping": "0.1 N·s/mm"},
    "oscillating-roller": {
        "spring_rate": "200 N·m/rad", "preload": "5 N·m", "load": "2 rows N·m", "damping": "0.1 N·m·s/rad",
    },
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_numbers_are_shown_with_the_unit_in_which_they_are_read(run, tmp_path, name):
    """One key has two units: a spring on an arm has a moment for a force."""
    scene = find_scene(name).replace(**{"follower.dynamics": SPRING, "cam.rpm": 100})
    (tmp_path / "mine.toml").write_text(scene.to_toml(), encoding="utf-8")
    for command in ("evaluate", "effects"):
        code, out, _ = run(command, tmp_path / "mine.toml")
        assert code == 0
        words = re.sub("[ =]+", " ", out)
        for key, text in READ[name].items():
            assert re.search(rf"follower\.dynamics\.{key} {re.escape(text)}\s", words)


PAGES = ("cheat-sheet.md", "how-to/limit-loads.md")
UNITS = re.findall(
    r"^\| (`[a-z_`, or]+) \| (\S+) \| (\S+) \|$",
    "\n".join((ROOT / "docs" / page).read_text(encoding="utf-8") for page in PAGES),
    re.MULTILINE,
)
"""The rows of the tables of units: keys, the unit of a translating follower, and that of an oscillating one."""


def test_the_pages_have_the_units_that_are_read():
    ways = {"mass": (False,), "inertia": (True,)}
    keys = [(key, units) for names, *units in UNITS for key in re.findall("`([a-z_]+)`", names)]
    assert len(keys) > 12
    for key, units in keys:
        for angular in ways.get(key, (False, True)):
            assert (
                QUANTITIES[
                    quantity_name_by_number_key(angular=angular, tool_turns=angular)[f"follower.dynamics.{key}"]
                ].unit
                == units[angular]
            )


def test_the_schema_is_printed(run_json):
    from camopt.scene.schema import scene_schema

    assert run_json("schema") == (0, scene_schema())


def test_a_shell_completes_commands(run, monkeypatch):
    monkeypatch.setenv("_CAMOPT_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "camopt sy")
    monkeypatch.setenv("COMP_CWORD", "1")
    assert run()[:2] == (0, "plain,synthesise\n")


def test_keys_are_listed_by_table_and_by_name(run, run_json):
    code, text, _ = run("keys", "cam")
    assert (code, "rev/min" in text, "follower" in text) == (0, True, False)
    code, found = run_json("keys", "rpm")
    assert (code, [key["key"] for key in found], found[0]["unit"]) == (0, ["cam.rpm"], "rev/min")
    code, found = run_json("keys")
    assert {"name", "limits.torque_rms_N_m", "laws.NAME.scca", "search.KEY.step"} <= {key["key"] for key in found}
    assert "did you mean rpm?" in run("keys", "rpmm")[2]


def test_a_new_scene_is_written_once(run):
    assert run("new", "feeder", "mine.toml")[0] == 0
    assert Scene.from_toml("mine.toml") == find_scene("feeder-with-stop")
    code, _, err = run("new", "--follower", "oscillating-flat", "mine.toml")
    assert (code, "this one exists" in err) == (2, True)
    assert run("new", "--follower", "oscillating-flat", "other.toml")[0] == 0
    assert run("evaluate", "other.toml")[0] == 0


SETTINGS = [
    (["cam.rpm=500", "follower.offset=5"], {"cam.rpm": 500, "follower.offset": 5}),
    (
        ["limits.pressure_angle=", "search.law=['cycloidal']"],
        {"limits.pressure_angle": None, "search.law": ["cycloidal"]},
    ),
    (
        ["follower.contact=knife", "follower.roller_radius="],
        {"follower.contact": "knife", "follower.roller_radius": None},
    ),
    (["search.offset={start=0,stop=4}"], {"search.offset": {"start": 0, "stop": 4}}),
    (["motion.2.angle=50", "motion.4.angle=40"], {"motion.2.angle": 50, "motion.4.angle": 40}),
]


@pytest.mark.parametrize(("given", "changes"), SETTINGS)
def test_any_key_is_set(run_json, given, changes):
    options = [word for each in given for word in ("--set", each)]
    _, found = run_json("evaluate", "two-pauses", *options)
    scene = find_scene("two-pauses").replace(**changes)
    assert found == json.loads(json.dumps(camopt.evaluate(scene).to_dict()))


@pytest.mark.parametrize("command", ["accuracy", "certify", "effects", "evaluate", "export", "frontier", "optimise",
                                     "report", "serve", "sweep", "synthesise"])  # fmt: skip
def test_every_command_that_takes_a_scene_takes_keys_of_it(run, command):
    words = ["cam.dxf"] if command == "export" else []
    code, _, err = run(command, "two-pauses", *words, "--set", "cam.rmp=3", "--set", "motion.9.angle=4")
    assert code == 2
    assert err.startswith("camopt: --set motion.9.angle = 4: there is no table 9")
    code, _, err = run(command, "two-pauses", *words, "--set", "cam.rmp=3", "--set", "follower.offset=wide")
    assert (code, len(err.splitlines())) == (2, 2)
    assert "camopt: --set cam.rmp = 3: not a known key; did you mean rpm?" in err
    assert "camopt: --set follower.offset = 'wide': must be a number" in err
    code, _, err = run(command, "two-pauses", *words, "--set", "tolerances.phase={plus=0.1,mius=0.1}")
    assert err.startswith("camopt: --set tolerances.phase.mius = 0.1: not a known key; did you mean minus?")
    code, _, err = run(command, "two-pauses", *words, "--rpm", "3", "--set", "cam.rpm=4")
    assert (code, err.strip()) == (2, "camopt: --set cam.rpm = 4: is already set by --rpm")


@pytest.mark.slow
def test_a_machine_is_exported_as_one_file(run, tmp_path):
    file = tmp_path / "packer.toml"
    assert run("export", "packer", file)[0] == 0
    assert camopt.evaluate_machine(file).to_dict() == camopt.evaluate_machine("packer").to_dict()
    assert run("export", "packer", tmp_path / "packer.pdf")[0] == 0
    assert (tmp_path / "packer.pdf").read_bytes().startswith(b"%PDF")
    for words, message in (([tmp_path / "x.dxf"], "camopt machine --out"), ([file, "--chord", "0.1"], "--chord")):
        code, _, told = run("export", "packer", *words)
        assert code == 2
        assert message in told
