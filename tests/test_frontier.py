"""The frontier of free laws: a front, above its bound, of cams that hold every limit."""

import numpy as np
import pytest

from camopt import BadInput, Scene, certify, evaluate, find_scene, frontier, load, synthesise
from camopt.mistakes import Unmet
from camopt.search.optimise import optimise
from camopt.synthesis.files import write_frontier

COARSE = {
    "synthesis.pieces": 20,
    "search.roller_radius": [5],
    "search.law": ["poly345", "modified-sine", "harmonic"],
}


@pytest.fixture(scope="module")
def scene():
    return find_scene("roller-1000rpm").replace(**COARSE)


@pytest.fixture(scope="module")
def found(scene):
    return frontier(scene, points=6, workers=1)


def test_rows_are_a_front_above_its_bound(found):
    sizes, accelerations = (np.array([row[axis] for row in found.rows]) for axis in found.axes)
    assert len(found.rows) == 6
    assert np.all(np.diff(sizes) > 0.0)
    assert np.all(np.diff(accelerations) < 0.0)
    for row in found.rows:
        assert row["base_radius_mm"] == row["size"]
        assert row["acceleration_max_m_s2"] == pytest.approx(row["acceleration"], rel=1e-12)
        assert 0.9 * row["size"] < row["bound"] <= row["size"]


def test_known_laws_are_not_below_the_bound(found):
    """The bound falls with the acceleration, so that of the next larger acceleration holds too."""
    compared = 0
    for known in found.known:
        looser = [row["bound"] for row in found.rows if row["acceleration"] >= known["acceleration"]]
        if known["within"] and looser:
            compared += 1
            assert known["size"] >= max(looser)
    assert compared
    assert {row["law_rise"]: row["within"] for row in found.known} == {
        "poly345": True,
        "modified-sine": False,  # a jerk of 69.5 where 60 is allowed
        "harmonic": False,
    }


def test_ends_are_those_of_single_objectives(scene, found):
    least = synthesise(scene.replace(**{"synthesis.peak_jerk": "poly345"})).objective
    assert found.rows[0]["size"] == pytest.approx(least, rel=2e-3)
    gentlest = synthesise(scene.replace(**{"synthesis.minimise": "acceleration", "cam.base_radius": 1000}))
    assert found.least["acceleration"][0] == pytest.approx(gentlest.objective, rel=3e-4)
    for free, bound in found.least.values():
        assert bound <= free


def test_the_table_has_each_cam(found, tmp_path):
    table, picture = write_frontier(found, tmp_path)
    assert picture.read_bytes().startswith(b"\x89PNG")
    frame = load(table)
    assert frame.attrs["units"]["base_radius_mm"] == "mm"
    free = frame[frame["free"]]
    assert len(free) == len(found.rows)
    assert frame.loc[~frame["free"], ["bound", "scene"]].isna().all(axis=None)
    for number in (0, -1):
        row = free.iloc[number]
        path = tmp_path / "cam.toml"
        path.write_text(row["scene"])
        cam = Scene.from_toml(path)
        assert evaluate(cam)["base_radius_mm"] == row["base_radius_mm"]
        assert set(certify(cam).values()) == {"held"}
        assert optimise(cam).best["base_radius_mm"] == pytest.approx(row["base_radius_mm"], abs=1e-6)


def test_three_axes_and_quantities(scene):
    three = frontier(scene, ("size", "acceleration", "jerk"), points=3, workers=2)
    values = np.array([[row[axis] for axis in three.axes] for row in three.rows])
    worse = (values[:, None] >= values[None]).all(axis=2) & (values[:, None] > values[None]).any(axis=2)
    assert len(three.rows) > 3
    assert not worse.any()
    pressed = frontier(scene, ("size", "velocity_max_m_s"), points=3, workers=1)
    assert {"size", "velocity_max_m_s"} <= pressed.rows[0].keys()


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        (("size",), "two or three different axes"),
        (("size", "size"), "two or three different axes"),
        (("size", "velocity", "jerk", "acceleration"), "two or three different axes"),
        (("size", "acceleratoin"), "acceleration"),
        (("size", "profile_radius_min_mm"), "less of is better"),
        (("size", "torque_peak_N_m"), "a quantity that the scene calls for and less of is better"),
    ],
)
def test_axes_that_are_none(scene, axes, message):
    with pytest.raises(BadInput) as error:
        frontier(scene, axes)
    assert message in str(error.value)


def test_freed_angles_are_for_optimise(scene):
    free = {"start": 80, "stop": 130}
    freed = scene.replace(**{"search.angle_rise": free, "search.angle_return": free})
    for ask in (synthesise, frontier):
        with pytest.raises(BadInput, match=r"search\.angle_rise"):
            ask(freed)


def test_strokes_that_meet_have_finite_peak_factors():
    motion = [
        {"segment": "rise", "angle": 120, "lift": 20, "law": "poly345"},
        {"segment": "return", "angle": 120, "lift": 20, "law": "poly345"},
        {"segment": "dwell", "angle": 120},
    ]
    met = synthesise(find_scene("exhaust-valve").replace(motion=motion, **{"limits.pressure_angle": 30}))
    for peaks in met.peaks.values():
        assert peaks["peak_jerk"] <= 60.0


def test_a_frontier_of_nothing(scene):
    with pytest.raises(Unmet):
        frontier(scene.replace(**{"limits.velocity": 2.0}), points=2, workers=1)
