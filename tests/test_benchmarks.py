"""What measures is right itself: rivals, prices, fronts."""

import sys
from pathlib import Path

import numpy as np
import pytest

from camopt.mechanisms import MECHANISMS

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
import prices
import rival_c
import rival_numba
from rival_motion import ALL_LAWS, motion_table
from throughput import jobs

from camopt.motion import LAWS


def test_the_price_list_has_a_line_for_every_mechanism(monkeypatch):
    for name, value in {"DESIGNS": 32, "PROVED": 1, "RUNS": 1}.items():
        monkeypatch.setattr(prices, name, value)
    heads, _, *rows = prices.lines()
    assert "proved in balls" in heads
    assert len(rows) == len(prices.SCENES) >= len(MECHANISMS)
    for row in rows:
        numbers = [float(cell) for cell in row.strip("| ").split("|")[1:]]
        assert all(number > 0.0 for number in numbers)


@pytest.mark.parametrize("name", prices.SCENES)
def test_every_price_is_of_a_cam_that_can_be_assembled(name):
    cam, follower = prices.SCENES[name]
    problem = prices.resolve(prices.Scene.from_dict({"cam": cam, "follower": follower, "motion": prices.MOTION}))
    assert len(prices.random_designs(problem)) > prices.DESIGNS // 2


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


@pytest.mark.parametrize("law", ALL_LAWS)
def test_the_motion_of_the_rivals_is_that_of_the_laws(law):
    x = np.linspace(0.0, 1.0, 1000)  # no node is at a jump of an acceleration
    own = (LAWS[law].displacement(x), LAWS[law].velocity(x), LAWS[law].acceleration(x))
    assert np.array(ALL_LAWS[law](x)) == pytest.approx(np.array(own), abs=1e-11)


@pytest.mark.parametrize("mechanism", rival_c.MECHANISMS)
def test_the_rivals_in_c_and_in_numba_agree(mechanism, monkeypatch):
    job = jobs(12)[mechanism]
    in_c = {number: rival_c.rival(number) for number in rival_c.NUMBERS}
    monkeypatch.setenv("CC", "no-such-compiler")
    in_numba = rival_c.rival.__wrapped__("float")
    assert in_numba.name == rival_numba.NAME
    (expected,), (double,), (single,) = (
        job.sampled(each, threads)() for each, threads in ((in_numba, 1), (in_c["double"], 2), (in_c["float"], 3))
    )
    scale = np.maximum(np.abs(expected).max(axis=0), 1e-30)
    assert double / scale == pytest.approx(expected / scale, abs=1e-13)
    assert single / scale == pytest.approx(expected / scale, abs=1e-4)


def test_a_motion_table_has_both_ends_of_every_segment():
    y, y1, y2, cosine, sine = motion_table("parabolic", [(120, 0.5), (60, 0.0), (90, -0.5), (90, 0.0)], 360)
    assert y.size == 360
    assert y[[0, 119, 120, 179, 180, 269, 270]] == pytest.approx([0.0, 0.5, 0.5, 0.5, 0.5, 0.0, 0.0])
    assert y2[[0, 119, 120]] == pytest.approx(np.array([4.0, -4.0, 0.0]) * 0.5 / np.radians(120) ** 2)
    assert y1[[119, 180]] == pytest.approx(0.0)
    assert cosine**2 + sine**2 == pytest.approx(1.0)
