"""What accuracy costs: the command measures, draws and writes, and enclosures keep their promise."""

import json

import numpy as np
import pandas as pd
import pytest

from camopt import Scene, find_scene
from camopt.cli.main import main
from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST
from camopt.core.numerics.curves import Linear
from camopt.core.numerics.sampling import write_sampled_extremes
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES, RETURN
from camopt.scene.problem.problem import resolve
from camopt.show.studies import accuracy

MOTION = [
    {"segment": "rise", "angle": 120, "lift": 20, "law": "cycloidal"},
    {"segment": "dwell", "angle": 50},
    {"segment": "return", "angle": 110, "lift": 20, "law": "modified-sine"},
    {"segment": "dwell", "angle": 80},
]
DISC, DRUM = {"form": "disc", "base_radius": 45}, {"form": "cylindrical", "mean_radius": 60}
SCENES = {
    "roller": (DISC, {"motion": "translating", "contact": "roller", "roller_radius": 8, "offset": 5}),
    "flat": (DISC, {"motion": "translating", "contact": "flat"}),
    "swinging roller": (
        DISC,
        {
            "motion": "oscillating",
            "contact": "roller",
            "roller_radius": 8,
            "arm_length": 90,
            "centre_distance": 110,
        },
    ),
    "swinging face": (DISC, {"motion": "oscillating", "contact": "flat", "centre_distance": 120, "face_offset": 5}),
    "groove": (DRUM, {"motion": "translating", "contact": "roller", "roller_radius": 6}),
    "swinging groove": (
        DRUM,
        {"motion": "oscillating", "contact": "roller", "roller_radius": 6, "arm_length": 90},
    ),
}


@pytest.fixture(autouse=True)
def _few_designs(monkeypatch):
    monkeypatch.setattr(accuracy.subjects, "DESIGN_COUNT", 128)
    for module in (accuracy.subjects, accuracy.table):
        monkeypatch.setattr(module, "REFERENCE_COUNT", 4)
    monkeypatch.setattr(accuracy.table, "TIMED_RUNS", 1)


@pytest.mark.parametrize(
    "name",
    [name if name == "roller" else pytest.param(name, marks=pytest.mark.long) for name in SCENES],
)
def test_enclosures_keep_their_promise_for_every_mechanism(name):
    cam, follower = SCENES[name]
    rows = accuracy.measure_accuracy_costs(
        Scene.from_dict({"cam": cam, "follower": follower, "motion": MOTION})
    ).methods
    enclosures = [row for row in rows if row["method"] == "enclosure"]
    assert len(enclosures) == len(accuracy.methods.RELATIVE_ERRORS) * len({row["quantity"] for row in rows}) > 0
    for row in enclosures:
        assert row["false_accept"] == 0.0
        assert row["error_max"] <= max(row["setting"], row["achieved"])
        assert row["achieved"] <= row["setting"] or row["setting"] < 1e-9  # a radius near zero has few digits
        assert row["undecided"] == 0.0 or row["setting"] > accuracy.table.BEYOND_LIMIT / 2
    coarse, fine = ([r for r in rows if r["method"] == "sampling" and r["setting"] == n] for n in (36, 3600))
    for one, two in zip(coarse, fine, strict=True):
        assert two["error_max"] <= max(one["error_max"], 1e-14)


@pytest.fixture
def twice_as_many(monkeypatch):
    """The arithmetic of 100 digits, in place of 50."""
    monkeypatch.setattr(accuracy.reference, "DECIMAL_DIGITS", 2 * accuracy.reference.DECIMAL_DIGITS)
    accuracy.reference.fifty_digit_context.cache_clear()
    yield
    accuracy.reference.fifty_digit_context.cache_clear()


@pytest.mark.parametrize("name", ["roller", "swinging face", "swinging groove"])
def test_the_reference_is_stable_when_its_digits_are_doubled(name, request):
    cam, follower = SCENES[name]
    problem = resolve(Scene.from_dict({"cam": cam, "follower": follower, "motion": MOTION}))
    subjects = [each for each in accuracy.subjects.subjects_of(problem) if each.name != "smallest radius"]
    assert subjects
    designs = [each.designs.take([0]) for each in subjects]
    found = [str(each.extreme_with_50_digits(design)) for each, design in zip(subjects, designs, strict=True)]
    request.getfixturevalue("twice_as_many")
    for each, design, before in zip(subjects, designs, found, strict=True):
        finer = each.extreme_with_50_digits(design)
        assert abs(finer / accuracy.reference.fifty_digit_context().mpf(before) - 1) < 1e-30


def test_the_root_of_a_slope_takes_few_evaluations():
    """Each evaluation with 50 digits takes as long as a thousand designs in doubles."""
    places = []

    def value_and_slope(u):
        places.append(u)
        return None, accuracy.reference.fifty_digit_context().exp(
            u
        ) - 1 - u / 3 - accuracy.reference.fifty_digit_context().mpf(1) / 1000

    low, high = (accuracy.reference.fifty_digit_context().mpf(end) for end in ("-0.001", "0.002"))
    (root,) = accuracy.reference._root_of_slope(value_and_slope, low, high)
    assert abs(value_and_slope(root)[1]) < accuracy.reference.EQUAL_DIGITS
    assert len(places) < 15
    assert accuracy.reference._root_of_slope(value_and_slope, low, low) == []


@pytest.mark.one_in(2)
@pytest.mark.parametrize("goal", [LARGEST, LEAST, LARGEST_MAGNITUDE])
@pytest.mark.parametrize("kinds", [ALL_STROKES, RETURN])
def test_sampling_is_the_best_of_the_samples_and_polish_the_vertex_of_a_parabola(goal, kinds):
    """By numpy, sample by sample; designs beyond one tile."""
    turn = Programme.from_segments(
        [(s["segment"], s["angle"], s.get("lift", 0), s.get("law")) for s in MOTION], angular=False
    )
    rng, count = np.random.default_rng(2), 300
    f = Linear(*rng.normal(size=(4, count)) * [[1.0], [1.0], [1.0], [30.0]])
    plain, polished = np.empty((2, 1, count))
    table, questions = accuracy.methods.sampling_motion_table(turn, 90), np.array([(kinds, goal)])
    write_sampled_extremes(f, count, table, questions, False, plain)
    write_sampled_extremes(f, count, table, questions, True, polished)
    stroke = np.repeat([0, 1, 2, 3], np.diff([0, 30, 43, 70, 90]))
    y = turn.motion_at(np.linspace(0, 2 * np.pi, 90, endpoint=False))
    asked = (stroke == 2) | (kinds == ALL_STROKES)
    beyond = 0
    for i in range(count):
        values = f.constant[i] + f.displacement[i] * y[0] + f.velocity[i] * y[1] + f.acceleration[i] * y[2]
        oriented = {LARGEST: values, LEAST: -values, LARGEST_MAGNITUDE: np.abs(values)}[goal]
        t = np.flatnonzero(asked)[np.argmax(oriented[asked])]
        sign = -1.0 if goal == LEAST else 1.0
        assert plain[0, i] == pytest.approx(sign * oriented[t], rel=1e-13)
        vertex = oriented[t]
        if 0 < t < 89 and stroke[t - 1] == stroke[t] == stroke[t + 1]:
            a, b, c = np.polyfit([-1, 0, 1], oriented[t - 1 : t + 2], 2)
            vertex = c - b * b / (4 * a) if a < -1e-9 and max(oriented[t - 1], oriented[t + 1]) <= c else vertex
        beyond += vertex > oriented[t]
        assert polished[0, i] == pytest.approx(sign * vertex, rel=1e-9)
    assert beyond > count / 10


@pytest.mark.slow
def test_the_command_writes_table_and_pictures(tmp_path, capsys):
    scene = find_scene("roller-1000rpm").replace(**{"search.law": ["cycloidal"]})
    (tmp_path / "scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    assert main(["accuracy", str(tmp_path / "scene.toml"), "--out", str(tmp_path), "--json", "--quiet"]) == 0
    found = json.loads(capsys.readouterr().out)
    table = pd.read_parquet(tmp_path / "accuracy.parquet")
    assert len(table) == len(found["methods"]) == 3 * (len(accuracy.methods.METHODS) + 1)
    assert {"sampling", "sampling, polished", "enclosure", "50 digits"} == set(table["method"])
    assert (tmp_path / "accuracy.png").read_bytes().startswith(b"\x89PNG")
    assert "enclosure" in (tmp_path / "accuracy.svg").read_text(encoding="utf-8")
