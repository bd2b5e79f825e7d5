"""What measures is right itself: rivals, fronts, comparisons."""

import json
import sys
from importlib.util import module_from_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from camopt import evaluate_designs, optimise
from camopt.core.kernels import compile

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import callgrind
import differences
import history_picture
import measuring
import optimisers
import record
import rival_c
import sides
import speed
import tasks
from beside_c import all_rows
from c_library import c_compiler
from random_cams import QUANTITIES, by_numpy, random_cams
from rival_motion import ALL_LAWS, motion_table
from rival_numpy import LAWS as LAWS_IN_NUMPY
from smallest_cams import by_brentq, smallest_cam
from throughput import KEYS, Job, carried_job, jobs, loaded_job

from camopt.model.motion import LAWS


def test_imported_benchmarks_and_tests_leave_the_rule_for_compiling_as_it_is():
    """Otherwise all tests of a run compile each kernel at once."""
    fresh = module_from_spec(compile.__spec__)
    compile.__spec__.loader.exec_module(fresh)
    assert (compile.COMPILATION, compile.LOADING) == (fresh.COMPILATION, fresh.LOADING)


def test_the_rival_of_the_fronts_sees_the_cams_of_the_sweep(tmp_path):
    pytest.importorskip("pymoo")
    import fronts

    scene = fronts.find_scene("roller-1000rpm").replace(
        **{"search.base_radius": {"start": 20, "stop": 140, "step": 40}}
    )
    fronts.sweep(scene, tmp_path, keep="all")
    table = fronts.load(tmp_path / "designs.parquet").sample(500, random_state=0)
    rollers = list(scene.search.roller_radius)
    numbers = np.column_stack(
        [
            table.law_rise.map(list(scene.search.law).index),
            table.roller_radius_mm.map(rollers.index),
            table.offset_mm,
            table.base_radius_mm,
        ]
    ).astype(float)
    numbers[:, :2] += 0.5
    out = {}
    fronts.Cams(scene)._evaluate(numbers, out)
    assert out["F"] == pytest.approx(table[list(scene.search.minimise)].to_numpy(), rel=1e-8)
    assert np.all(out["G"] <= 0.0, axis=1).tolist() == table.feasible.tolist()
    assert 50 < table.feasible.sum() < 450


def test_the_excess_of_a_front_over_itself_is_nothing():
    pytest.importorskip("pymoo")
    import fronts

    angle = np.linspace(10.0, 30.0, 400)
    exact = np.column_stack([600.0 / angle, np.full(400, 5.0), angle])
    shifted = exact[100:-100:7] + np.array([0.25, 0.0, 0.003])
    expected = 0.25 + 600.0 / exact[100:-100:7, 2] - 600.0 / shifted[:, 2]
    assert fronts.excess(shifted, exact) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("law", ["cycloidal", "harmonic"])
def test_a_root_of_samples_is_next_to_the_smallest_radius(law):
    """The largest sample is never above the truth, so that the rival's cam is the smaller one."""
    radius = optimise(smallest_cam(law)).best["base_radius_mm"]
    assert by_brentq(law) == pytest.approx(radius, abs=1e-3)
    assert by_brentq(law) < radius


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", optimisers.PROBLEMS)
def test_the_smallest_cam_holds_what_the_rivals_see_and_no_smaller_one_does(name):
    scene, problem = optimisers.PROBLEMS[name]
    best = optimisers.by_camopt(scene)
    assert problem.excess(best) <= 1e-9
    assert problem.excess(np.array([best[0] * (1.0 - 1e-6), *best[1:]])) > 0.0


@pytest.mark.parametrize("law", LAWS_IN_NUMPY)
def test_numpy_agrees_on_random_cams(law):
    """Of the two curvatures relative to the larger one: the flattest place of a cam may have next to none."""
    scene, frame = random_cams(law, 2000)
    found, expected = evaluate_designs(scene, frame), by_numpy(law, frame)
    angle, *curvatures = (expected[name] for name in QUANTITIES)
    for name, scale in zip(QUANTITIES, (angle, *[np.max(np.abs(curvatures), axis=0)] * 2), strict=True):
        assert (np.abs(found[name].to_numpy() - expected[name]) <= 1e-9 * scale).all()


@pytest.mark.parametrize("job", [loaded_job, carried_job])
def test_a_sweep_of_the_record_has_designs_that_are_feasible_and_others(job):
    swept = job(9).swept(1)()
    assert swept.designs == job(9).designs == 100
    assert 0 < swept.feasible < swept.designs


@pytest.mark.parametrize("law", ALL_LAWS)
def test_the_motion_of_the_rivals_is_that_of_the_laws(law):
    x = np.linspace(0.0, 1.0, 1000)  # no node is at a jump of an acceleration
    own = (LAWS[law].displacement(x), LAWS[law].velocity(x), LAWS[law].acceleration(x))
    assert np.array(ALL_LAWS[law](x)) == pytest.approx(np.array(own), abs=1e-11)


CURVATURES = ("pitch_curvature_min_per_mm", "pitch_curvature_max_per_mm")
MISSED = 4e-3  # h²/8·f'' of samples h apart: f'' is up to a hundred, f being tan β or κ by its largest value


def gaps_to_camopt(job, found):
    """How far the rival's extremes stay within camopt's, (designs, 2 or 3)."""
    names = (
        "pressure_angle_max_deg",
        *(("profile_radius_min_mm",) if job.mechanism.endswith("flat") else CURVATURES),
    )
    keys = {**KEYS, "size": "base_radius" if job.mechanism.startswith("disc") else "mean_radius"}
    (law,) = job.raw["search"]["law"]
    frame = pd.DataFrame(job.sizes, columns=[f"{keys[name]}_mm" for name in rival_c.SIZES])
    frame = frame.loc[:, frame.any()].assign(law=law)
    own = evaluate_designs(job.scene.replace(outputs=list(names)), frame)[list(names)].to_numpy(copy=True)
    own[:, 0] = np.tan(np.radians(own[:, 0]))
    scale = np.array([1.0, *[np.abs(own[:, 1:]).max()] * (len(names) - 1)])
    return np.array([1.0, -1.0, 1.0])[: len(names)] * (own - found[:, : len(names)]) / scale


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.skipif(c_compiler() is None, reason="there is no C compiler")
@pytest.mark.parametrize("mechanism", rival_c.MECHANISMS)
def test_the_rival_in_c_comes_nearer_to_the_extremes_with_the_square_of_its_samples(mechanism):
    """A sample is never beyond an extreme of the continuous motion."""
    job, samples = jobs(8)[mechanism], rival_c.SAMPLES
    (single,) = job.sampled(rival_c.rival("float"), 3)()
    for count, allowed in ((samples, MISSED), (16 * samples, MISSED / 256)):
        (found,) = job.sampled(rival_c.rival("double"), 2, count)()
        gap = gaps_to_camopt(job, found)
        assert gap.min() >= -1e-9
        assert gap.max() <= allowed
        if count == samples:
            largest = np.maximum(np.abs(found).max(axis=0), 1e-30)
            assert single / largest == pytest.approx(found / largest, abs=1e-4)


@pytest.mark.one_in(6)
@pytest.mark.skipif(c_compiler() is None, reason="there is no C compiler")
@pytest.mark.parametrize("law", ALL_LAWS)
@pytest.mark.parametrize("mechanism", rival_c.MECHANISMS)
def test_the_polished_rival_in_c_agrees_with_camopt(mechanism, law):
    """It may miss the highest of two peaks of nearly the same height."""
    job = jobs(7)[mechanism]
    job = Job(mechanism, job.scene.replace(**{"search.law": [law]}))
    (found,) = job.polished(rival_c.rival("double"), 2)()
    gap = np.abs(gaps_to_camopt(job, found))
    assert np.mean(gap <= 1e-9) >= 0.95
    assert gap.max() <= MISSED


def test_the_rows_of_the_default_sweep_are_those_of_the_feasible_designs():
    job = Job("disc_translating", jobs(20)["disc_translating"].scene)
    assert sum(rows.count for rows in all_rows(job, 2)) == job.swept(1)().feasible


def test_a_motion_table_has_both_ends_of_every_segment():
    y, y1, y2, cosine, sine = motion_table("parabolic", [(120, 0.5), (60, 0.0), (90, -0.5), (90, 0.0)], 360)
    assert y.size == 360
    assert y[[0, 119, 120, 179, 180, 269, 270]] == pytest.approx([0.0, 0.5, 0.5, 0.5, 0.5, 0.0, 0.0])
    assert y2[[0, 119, 120]] == pytest.approx(np.array([4.0, -4.0, 0.0]) * 0.5 / np.radians(120) ** 2)
    assert y1[[119, 180]] == pytest.approx(0.0)
    assert cosine**2 + sine**2 == pytest.approx(1.0)


TIMES = {"cpu_seconds": 0.2, "rival_cpu_seconds": 0.1, "seconds": 0.2, "rival_seconds": 0.1}


def measures(**changed):
    """Of two tasks, the first with other numbers."""
    counts = {"instructions": 2e6, "kernel_instructions": 1e6}
    return {"sweep": {**TIMES, **counts, "designs": 100, **changed}, "smallest": {**TIMES, "designs": 1}}


@pytest.mark.parametrize(
    ("changed", "failed"),
    [
        ({}, []),
        ({"cpu_seconds": 0.2 * 1.09}, []),
        ({"cpu_seconds": 0.2 * 1.11}, ["ratio"]),
        ({"cpu_seconds": 0.2 / 2}, []),
        ({"seconds": 2.0}, []),
        ({"rival_cpu_seconds": 0.1 / 1.11}, ["ratio"]),
        ({"instructions": 2e6 * 1.031}, ["all instructions"]),
        ({"kernel_instructions": 1e6 * 1.029}, []),
        ({"kernel_instructions": 1e6 * 1.031, "instructions": 2.031e6}, ["those of kernels"]),
    ],
)
def test_what_costs_more_than_is_allowed_fails(changed, failed):
    found = record.changes(measures(), measures(**changed), slower=0.10, more=0.03)
    assert [each.what for each in found if each.failed] == failed
    assert [each.task for each in found] == ["sweep"] * 3 + ["smallest"]
    text = record.table(found)
    assert text.count("**fails**") == len(failed)
    assert len(text.splitlines()) == 2 + len(found)


@pytest.mark.parametrize(("factor", "doubtful"), [(1.11, True), (1.09, False), (1 / 1.09, False), (1 / 1.11, True)])
def test_what_differs_either_way_is_in_doubt(factor, doubtful):
    found = record.changes(measures(), measures(cpu_seconds=0.2 * factor), 0.1, 0.03)
    assert found[0].doubtful is doubtful


def test_what_only_one_side_has_is_not_compared():
    before = measures()
    after = {"sweep": {**TIMES, "designs": 100}, "new": {**TIMES, "designs": 1}}
    assert [each[:2] for each in record.changes(before, after, 0.1, 0.03)] == [("sweep", "ratio")]


def test_of_several_rounds_each_number_is_the_least():
    rounds = [
        measures(cpu_seconds=0.3, rival_cpu_seconds=0.05),
        measures(cpu_seconds=0.25),
        {"new": {"seconds": 1.0}},
    ]
    found = record.least(rounds)
    assert found["sweep"]["cpu_seconds"] == 0.25
    assert found["sweep"]["rival_cpu_seconds"] == 0.05
    assert found["new"] == {"seconds": 1.0}


def test_one_lucky_round_of_the_base_is_no_slower_head():
    steady, lucky = measures(), measures(cpu_seconds=0.1)
    assert speed.failing(speed.seen([[steady, lucky, steady], [steady] * 3])) == []
    assert speed.failing(speed.seen([[lucky] * 3, [steady] * 3])) == ["sweep"]
    assert speed.failing(speed.seen([[steady] * 3, [steady] * 3], [measures(), measures(instructions=9e6)])) == [
        "sweep"
    ]


def test_of_several_rounds_the_middle_is_the_median():
    found = record.middle(
        [measures(cpu_seconds=0.9), measures(), measures(cpu_seconds=0.1), {"new": {"seconds": 1.0}}]
    )
    assert found["sweep"]["cpu_seconds"] == 0.2
    assert found["new"] == {"seconds": 1.0}


def test_what_seems_slower_is_measured_again_until_it_is_not():
    asked, times = [], {"steady": [1.0] * 99, "noisy": [1.3] * speed.ROUNDS + [1.2, 1.05], "slower": [1.2] * 99}
    best = dict.fromkeys(times, 9.9)

    def measure(turn, names):
        asked.append(names)
        best.update({name: min(best[name], times[name][turn]) for name in names})

    speed.repeated(list(times), measure, lambda: [name for name in best if best[name] > 1.1])
    assert asked == [list(times)] * speed.ROUNDS + [["noisy", "slower"]] * 2 + [["slower"]] * (
        speed.MOST_ROUNDS - speed.ROUNDS - 2
    )


def test_records_are_files_in_the_order_of_their_commits(tmp_path):
    dates = ("2026-11-22T18:34:58+00:00", "2026-11-21T23:00:00+00:00")
    made = [{"commit": f"{k}" * 40, "date": date, "tasks": measures()} for k, date in enumerate(dates)]
    files = [record.written(each, tmp_path / "history") for each in made]
    assert [file.name for file in files] == ["20261122183458-000000000.json", "20261121230000-111111111.json"]
    assert record.records(tmp_path / "history") == made[::-1]


@pytest.mark.slow
def test_the_history_is_drawn_whatever_was_measured(tmp_path):
    tasks = [measures(), {"smallest": {**TIMES, "designs": 1}}, measures(cpu_seconds=0.1)]
    made = [{"commit": f"{k}" * 40, "date": "2026-11-22", "tasks": each} for k, each in enumerate(tasks)]
    assert history_picture.drawn(made, tmp_path / "history.png").stat().st_size > 10_000


def test_instructions_are_told_by_task_and_kernels_by_having_no_file(tmp_path):
    lines = [
        "desc: Trigger: Client Request: disc translating",
        "summary: 60",
        "ob=(1) /lib/libpython3.so",
        "fn=(1) evaluate",
        "12 10",
        "cob=(2) ???",
        "cfn=(2) 0x0000",
        "calls=1 0",
        "+3 30",
        "* 20",
        "ob=(2)",
        "-2 25",
        "ob=(1)",
        "7 5",
    ]
    (tmp_path / "out.1").write_text("\n".join(lines))
    assert callgrind.counts(tmp_path / "out") == {
        "disc translating": {"instructions": 60.0, "kernel_instructions": 25.0}
    }


@pytest.mark.slow
def test_a_package_in_the_place_of_another_is_refused(tmp_path):
    (tmp_path / "camopt").mkdir()
    with pytest.raises(RuntimeError, match="was measured in place of"):
        sides.Side("none", tmp_path / "elsewhere").warm([])


def test_a_slower_commit_fails_when_it_is_measured_in_turns_with_its_base(monkeypatch):
    def fake_times(side, names, verb):
        rounds.append(side.name)
        return {name: {"cpu_seconds": 0.2 * slower[side.name]} for name in names}

    slower, rounds = {"base": 1.0, "head": 1.2}, []
    base, head = (sides.Side(name, Path()) for name in slower)
    monkeypatch.setattr(sides.Side, "warm", lambda *arguments: None)
    monkeypatch.setattr(sides.Side, "timed", fake_times)
    assert speed.failing(speed.compared([base, head], ["sweep"], [])) == ["sweep"]
    assert rounds[:4] == ["base", "head", "head", "base"]
    assert len(rounds) == 2 * speed.MOST_ROUNDS
    assert speed.failing(speed.compared([base, base], ["sweep"], [])) == []
    assert len(rounds) == 2 * (speed.MOST_ROUNDS + speed.ROUNDS)


@pytest.mark.long
def test_every_task_of_the_record_is_measured(monkeypatch, capsys):
    monkeypatch.setattr(measuring, "TASKS", {"one": lambda: measuring.Task(dict, list, designs=3, runs=2)})
    measuring.main("time", "one")
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert set(told["tasks"]["one"]) == {*record.TIMES, "designs"}
    measuring.main("own", "one")
    own = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert set(own["tasks"]["one"]) == {"seconds", "cpu_seconds", "designs"}
    assert Path(told["package"]).name == "camopt"


def test_quick_tasks_are_the_first_of_all():
    assert list(tasks.TASKS)[: len(tasks.QUICK)] == list(tasks.QUICK)
    assert {*tasks.COUNTED} < {*tasks.TASKS} > {*tasks.QUICK} > {*tasks.SWEEPS}
    assert {*tasks.COLD} < {*tasks.TASKS}


ANSWER = {
    "code": 0,
    "out": {
        "radius_max_mm": 40.0,
        "radius_min_mm": 1e-9,
        "bound": 2.5,
        "error": 1.9,
        "gap": 3e-9,
        "verdict": "held",
    },
    "err": "camopt: 3 of 4",
    "files": {"cam.nc": "G1 X40.0 Y0.0", "out.csv": {"lift": [1.0, 0.0]}, "cam.toml": "rpm = 300"},
    "seconds": 1.0,
}


@pytest.mark.parametrize(
    ("before", "after", "places"),
    [
        ("40.0,", "40.00000000001,", [".out.radius_max_mm"]),
        ("1e-09", "1.003e-09", []),  # its curve goes to 40
        ("1e-09", "1e-08", [".out.radius_min_mm"]),
        ("2.5", "1.95", []),
        ("2.5", "1.85", [".out.bound"]),
        ("1.9", "2.6", [".out.bound", ".out.error"]),
        ("3e-09", "5.9e-09", []),
        ("3e-09", "6.1e-09", [".out.gap"]),
        ("held", "broken", [".out.verdict text"]),
        ("radius_min_mm", "least_radius_mm", ["keys"]),
        ("3 of 4", "3 of 5", [".err"]),
        ("camopt: 3 of 4", " 29%|##8       | 386k/1.35M [00:51<04:18, 3.73k designs/s]\\ncamopt: 3 of 4", []),
        ("3 of 4", "5 more searches for a motion, about 0:00:40 in all\\ncamopt: 3 of 4", []),
        ('"code": 0', '"code": 1', [".code"]),
        ("Y0.0", "Y0.000000000001", []),
        ("Y0.0", "Y0.00000000001", [".files.cam.nc points #1"]),
        ("lift", "height", ["keys"]),
        ("[1.0, 0.0]", "[1.0, 1e-12]", [".files.out.csv.lift[1]"]),
        ("[1.0, 0.0]", "[1.0, 1e-14]", []),
        ("300", "301", [".files.cam.toml #0"]),
    ],
)
def test_what_differs_between_two_answers_is_named(before, after, places):
    text = json.dumps(ANSWER)
    assert before in text
    sides = (json.loads(each) for each in (text, text.replace(before, after)))
    old, new = ({**each, "out": json.dumps(each["out"])} for each in sides)
    found = differences.differences("case 1", old, new, [])
    assert [each.place for each in found] == places
    accepted = [differences.Accepted("case *", "*", float("inf"), "a reason")]
    assert differences.differences("case 1", old, new, accepted) == []
    assert differences.differences("case 1", old, old, []) == []


def test_every_accepted_difference_has_its_reason(tmp_path):
    assert all(len(each.reason.split()) > 3 for each in differences.read_accepted())
    (tmp_path / "accepted.txt").write_text("# of cams and rollers\noptimise* *gap* inf\n")
    with pytest.raises(ValueError, match="not enough"):
        differences.read_accepted(tmp_path / "accepted.txt")
