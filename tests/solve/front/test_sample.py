"""Sweeps of a sample of designs in place of a grid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.depth import times

from camopt import BadInput, evaluate_designs, find_scene, load, sweep
from camopt.cli.main import main
from camopt.scene.choices import StepRange
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.sample import SAMPLERS, sweep_space
from camopt.scene.problem.variables import Variable

FREE = {
    "base_radius": {"start": 30, "stop": 90},
    "offset": {"start": -10, "stop": 20},
    "roller_radius": [5, 8, 20],
    "law": ["harmonic", "cycloidal"],
}
ARM = {
    "base_radius": {"start": 20, "stop": 60},
    "arm_length": {"start": 100, "stop": 120},
    "centre_distance": {"start": 120, "stop": 140},
    "roller_radius": {"start": 5, "stop": 15},
    "law": ["poly345"],
}

GROOVE = find_scene("roller-1000rpm").replace(
    cam={"form": "cylindrical", "mean_radius": 40, "rpm": 300},
    follower={"motion": "translating", "contact": "roller", "roller_radius": 5},
    search={"mean_radius": {"start": 60, "stop": 200}, "roller_radius": {"start": 2, "stop": 8}},
)


def sampled_scene(samples, sampler="sobol", name="roller-1000rpm", search=FREE, **more):
    return find_scene(name).replace(search={**search, "samples": samples, "sampler": sampler, **more})


@pytest.mark.parametrize("sampler", SAMPLERS)
@given(exponent=st.integers(0, 9), axes=st.integers(1, 8), seed=st.integers(0, 2**32 - 1))
@settings(max_examples=times(4, deep=200))
def test_each_layer_of_each_axis_has_one_point(sampler, exponent, axes, seed):
    """Of 2ᵏ Sobol points and 2ᵏ layers, as of any Latin hypercube."""
    count = 2**exponent
    points = SAMPLERS[sampler](axes, count, seed)
    assert points.shape == (count, axes)
    for column in points.T:
        assert sorted(np.floor(column * count)) == list(range(count))


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize(("name", "search"), [("roller-1000rpm", FREE), ("oscillating-roller", ARM)])
def test_rows_are_those_of_the_designs_drawn(name, search, sampler, tmp_path):
    scene = sampled_scene(50, sampler, name, search)
    swept = sweep(scene, tmp_path, keep="all")
    rows, laws = load(tmp_path / "designs.parquet"), len(search["law"])
    assert swept.designs == 50 * laws == len(rows) + swept.impossible
    sizes = [f"{key}_mm" for key in search if key != "law"]
    for key in set(search) - {"law"}:
        choice, column = search[key], rows[f"{key}_mm"]
        assert column.isin(choice).all() if isinstance(choice, list) else column.between(*choice.values()).all()
    alike = {tuple(map(tuple, each[sizes].to_numpy())) for _, each in rows.groupby("law_rise")}
    assert len(alike) == 1  # the same designs for each law
    asked = rows[sizes].assign(law=rows["law_rise"])
    found = evaluate_designs(scene, asked)
    assert (found["feasible"].to_numpy() == rows["feasible"].to_numpy()).all()
    np.testing.assert_allclose(
        found["pressure_angle_max_deg"], rows["pressure_angle_max_deg"], rtol=4 * scene.accuracy.relative_error
    )


@given(
    samples=st.integers(1, 60),
    sampler=st.sampled_from(list(SAMPLERS)),
    block=st.sampled_from([1, 7, 32768]),
    workers=st.integers(1, 3),
)
@settings(max_examples=times(4, deep=100))
def test_a_sample_is_the_same_however_it_is_cut(samples, sampler, block, workers):
    scene = sampled_scene(samples, sampler)
    one, other = sweep(scene), sweep(scene, workers=workers, block=block)
    counts = [(each.designs, each.impossible, each.feasible, each.pareto, each.best) for each in (one, other)]
    assert counts[0] == counts[1]


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_a_seed_decides_the_designs(sampler):
    spaces = [sweep_space(resolve(sampled_scene(20, sampler, seed=seed))) for seed in (0, 0, 1)]
    sizes = [space.drawn_values["offset"].tolist() for space in spaces]
    assert sizes[0] == sizes[1] != sizes[2]


def test_more_samples_find_no_larger_cam():
    """Sobol points go on where fewer of them ended, so that the best of more is no worse."""
    best = [sweep(sampled_scene(count)).best["harmonic"]["base_radius_mm"] for count in (64, 256, 1024)]
    assert best == sorted(best, reverse=True)
    assert best[-1] < best[0]


def test_the_front_is_the_same_whatever_is_kept(tmp_path):
    scene, rows = sampled_scene(200), []
    for keep in ("pareto", "all", "front-only"):
        sweep(scene, tmp_path / keep, keep=keep)
        rows.append(load(tmp_path / keep / "pareto.parquet"))
    assert rows[0].equals(rows[1])
    assert rows[0].equals(rows[2])
    assert "samples = 200" in rows[0].attrs["scene"]


def test_a_sample_of_grooves_is_the_same_whatever_is_kept(tmp_path):
    """Of a grid they share pitch curves, whatever the roller; of a sample hardly any two do."""
    scene, rows = GROOVE.replace(**{"search.samples": 64}), []
    for keep in ("feasible", "all"):
        sweep(scene, tmp_path / keep, keep=keep)
        rows.append(load(tmp_path / keep / "pareto.parquet"))
    assert rows[0].equals(rows[1])
    assert len(rows[0]) > 1


def test_a_sample_has_each_value_of_a_list_as_often():
    def values_of_choice(choice, shares):
        return Variable("", "size", "", "", choice=choice).values_at_shares(shares)

    shares = SAMPLERS["sobol"](1, 1024, 3)[:, 0]
    found, counts = np.unique(values_of_choice((5.0, 8.0, 8.0, 20.0), shares), return_counts=True)
    assert found.tolist() == [5.0, 8.0, 20.0]
    assert counts.min() >= 341
    ends = values_of_choice(StepRange(start=1.0, stop=3.0), np.array([0.0, 1.0 - 2.0**-53]))
    assert 1.0 == ends[0] < ends[1] <= 3.0


def test_what_a_cam_one_per_cent_smaller_would_exceed_is_said():
    near = {
        "base_radius": {"start": 35.3, "stop": 35.5},
        "offset": [5.93],
        "roller_radius": [20],
        "law": ["harmonic"],
    }
    (best,) = sweep(sampled_scene(16, search=near)).best.values()
    assert "pressure_angle" in best["held_by"]


@pytest.mark.parametrize(
    ("search", "message"),
    [
        ({"samples": 0}, "search.samples = 0: must be at least 1"),
        ({"samples": 2**22 + 1}, "search.samples = 4194305: must be at most"),
        ({"samples": 1.5}, "search.samples = 1.5: must be a whole number"),
        ({"seed": 1}, "search.seed = 1: needs search.samples, which is missing"),
        ({"sampler": "sobol"}, "search.sampler = 'sobol': needs search.samples, which is missing"),
        ({"samples": 9, "sampler": "halton"}, "search.sampler = 'halton': must be one of"),
        ({"samples": 9, "seed": -1}, "search.seed = -1: must be at least 0"),
    ],
)
def test_a_sample_that_cannot_be_drawn_is_a_mistake(search, message):
    with pytest.raises(BadInput) as caught:
        find_scene("roller-1000rpm").replace(**{f"search.{key}": value for key, value in search.items()})
    assert message in str(caught.value)
    assert len(caught.value.mistakes) == 1


def test_a_sample_needs_a_free_size():
    with pytest.raises(BadInput, match=r"search\.samples = 8: needs a range or a list for a size"):
        sweep(find_scene("roller-1000rpm").replace(search={"samples": 8, "law": ["harmonic"]}))


def test_the_command_draws_a_sample(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["sweep", "--samples", "40", "--base-radius", "40:90", "--offset", "0:10", "--quiet"]) == 0
    assert "280 designs" in capsys.readouterr().out
    assert main(["sweep", "--base-radius", "40:90", "--quiet"]) == 2
    assert "above 0 for a sweep of a grid, unless search.samples is given" in capsys.readouterr().err
