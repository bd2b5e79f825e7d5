"""Pictures in axes of one's own, and the picture of a sweep."""

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import camopt
from camopt import find_scene

SCENE = find_scene("two-pauses").replace(
    search={
        "base_radius": [60, 70, 80],
        "law": ["cycloidal", "poly345", "harmonic"],
        "minimise": ["base_radius_mm", "pressure_angle_max_deg", "jerk_max_mm_per_rad3"],
    },
    limits={},
    tolerances={"profile": 0.01},
)


@pytest.fixture(scope="module")
def swept():
    return camopt.sweep(SCENE)


def points_of(axes):
    """The points of all scatters but that of the knee."""
    return np.concatenate([each.get_offsets() for each in axes.collections if each.get_label() != "knee"])


def test_a_sweep_shows_its_front(swept, tmp_path):
    figure = camopt.plot(swept, tmp_path / "sweep.svg")
    front = swept.to_pandas()
    names = [*SCENE.search.minimise]
    pairs = [(0, 1), (0, 2), (1, 2)]
    assert len(figure.axes) == len(pairs)
    for axes, pair in zip(figure.axes, pairs, strict=True):
        expected = front[[names[k] for k in pair]].to_numpy()
        assert sorted(map(tuple, points_of(axes).tolist())) == sorted(map(tuple, expected.tolist()))
        knee = next(each for each in axes.collections if each.get_label() == "knee")
        assert knee.get_offsets().tolist() == [[swept.front.knee[names[k]] for k in pair]]
    assert (tmp_path / "sweep.svg").exists()


@pytest.mark.slow
def test_a_table_of_designs_is_drawn_as_its_sweep_is(swept):
    front = swept.to_pandas()
    figure, other = camopt.plot(front), camopt.plot(swept)
    for axes, same in zip(figure.axes, other.axes, strict=True):
        assert points_of(axes).tolist() == points_of(same).tolist()
    half = camopt.plot(front.iloc[::2])
    assert len(points_of(half.axes[0])) == len(front.iloc[::2])
    with pytest.raises(camopt.BadInput, match="must be a scene"):
        camopt.plot(pd.DataFrame({"a": [1]}))


def test_a_front_of_one_objective_has_no_picture():
    one = SCENE.replace(**{"search.minimise": ["base_radius_mm"]})
    with pytest.raises(camopt.BadInput, match="two objectives that vary"):
        camopt.plot(camopt.sweep(one))


MADE = {
    "scene": lambda: SCENE,
    "design": lambda: next(iter(camopt.sweep(SCENE).best.values())),
    "groove": lambda: find_scene("barrel-traverse"),
    "tolerance": lambda: camopt.tolerance(SCENE),
    "harmonics": lambda: camopt.harmonics(SCENE),
}


@pytest.mark.parametrize("kind", [*MADE, "sweep"])
def test_the_main_diagram_is_drawn_in_axes_of_ones_own(kind, swept):
    settings = dict(matplotlib.rcParams)
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert camopt.plot(swept if kind == "sweep" else MADE[kind](), ax=right) is figure
    assert right.has_data()
    assert not left.has_data()
    assert dict(matplotlib.rcParams) == settings


@pytest.mark.parametrize(
    ("what", "path"), [(lambda: camopt.response_spectrum("cycloidal", [1.0]), None), (lambda: SCENE, "cam.svg")]
)
def test_what_has_no_main_diagram_is_refused_in_a_sentence(what, path):
    axes = Figure().subplots()
    with pytest.raises(camopt.BadInput, match="must be a scene, a design"):
        camopt.plot(what(), path, ax=axes)
