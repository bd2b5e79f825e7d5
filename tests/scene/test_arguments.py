"""Arguments of the public functions: scenes by name or path, options by keyword, counts, sentences in the log."""

import inspect
import logging
from inspect import signature
from pathlib import Path

import pytest

import camopt
from camopt import BadInput, find_scene
from camopt.storage.files import write_text

NAME = "two-pauses"
OF_SCENES = {
    "construct": lambda scene: camopt.construct(scene).table().title,
    "cam_points": lambda scene: camopt.cam_points(scene, [0, 37.3])["profile_radius_mm"].tolist(),
    "evaluate_designs": lambda scene: camopt.evaluate_designs(scene, {"base_radius_mm": 47.3}).to_dict(),
    "evaluate": lambda scene: dict(camopt.evaluate(scene)),
    "certify": lambda scene: camopt.certify(scene),
    "sweep": lambda scene: camopt.sweep(scene).designs,
    "optimise": lambda scene: camopt.optimise(scene).best["base_radius_mm"],
    "harmonics": lambda scene: camopt.harmonics(scene, 3).mean,
    "sensitivities": lambda scene: [*camopt.sensitivities(scene)],
    "timing": lambda scene: camopt.timing(scene).table().title,
    "scene_of": lambda scene: camopt.scene_of({"base_radius_mm": 47.3}, scene=scene).to_toml(),
}
"""Those that are quick, each with what tells its answer."""
FUNCTIONS = [name for name in camopt.__all__ if inspect.isfunction(getattr(camopt, name))]
TAKE_SCENES = [name for name in FUNCTIONS if "scene" in signature(getattr(camopt, name)).parameters]


@pytest.mark.parametrize("name", OF_SCENES)
def test_a_scene_may_be_a_name_or_a_path(name, tmp_path):
    path, call = tmp_path / "own.toml", OF_SCENES[name]
    write_text(path, find_scene(NAME).to_toml())
    expected = call(find_scene(NAME))
    assert call(NAME) == call(path) == call(str(path)) == expected


def test_plot_takes_a_name():
    assert camopt.plot(NAME).axes


@pytest.mark.parametrize("name", TAKE_SCENES)
def test_what_is_no_scene_is_told(name):
    function = getattr(camopt, name)
    profile = camopt.MeasuredProfile([[0.0, 1.0]], "polar")
    others = {
        "points": [0.0, 1.0, 0.0],
        "profile": profile,
        "profiles": [profile] * 2,
        "designs": {},
        "path": "x.dxf",
    }
    others |= {"within": 1.0, "part": (1, 1), "table": {"base_radius_mm": 3.0}, "out": "x"}
    needed = [each.name for each in signature(function).parameters.values() if each.default is each.empty]
    required = {each: others[each] for each in needed if each in others}
    for wrong, told in ((7, "scene = 7: must be a Scene"), ("two-pause", "did you mean two-pauses")):
        with pytest.raises(BadInput, match=told):
            function(**{**required, "scene": wrong})


def test_no_function_takes_more_than_two_arguments_by_position():
    every = {name: signature(getattr(camopt, name)).parameters.values() for name in FUNCTIONS}
    places = {name: sum(each.kind is each.POSITIONAL_OR_KEYWORD for each in given) for name, given in every.items()}
    assert {name: count for name, count in places.items() if count > 2} == {}


def test_positions_are_still_read_with_a_warning(tmp_path):
    scene = find_scene(NAME)
    with pytest.warns(DeprecationWarning, match="sweep takes keep, workers by keyword") as told:
        swept = camopt.sweep(scene, tmp_path, "all", 1)
    assert told[0].filename == __file__
    assert len(swept.to_pandas("designs")) == swept.designs - swept.impossible
    with pytest.warns(DeprecationWarning, match="optimise takes progress, seconds by keyword"):
        camopt.optimise(scene, None, 3.0)
    with pytest.raises(TypeError, match="positional"):
        camopt.synthesise(scene, None, None)
    with pytest.raises(TypeError):
        camopt.sweep(scene, tmp_path, "all", keep="all")


COUNTS = {
    "block": lambda count: camopt.sweep(NAME, block=count),
    "workers": lambda count: camopt.sweep(NAME, workers=count),
    "points": lambda count: camopt.frontier(NAME, points=count),
    "seed": lambda count: camopt.sample_cams(
        find_scene(NAME).replace(**{"tolerances.profile": 0.02}), 3, seed=count
    ),
}


@pytest.mark.parametrize("name", COUNTS)
@pytest.mark.parametrize("count", [-1, 1.5, "x", float("nan"), True])
def test_a_count_is_a_whole_number(name, count):
    with pytest.raises(BadInput, match=rf"^camopt: {name} = .*: must be a whole number of at least [01]$"):
        COUNTS[name](count)


def test_sentences_go_to_the_log_where_nobody_hears_them(tmp_path, caplog):
    camopt.sweep(NAME, tmp_path)
    told: list[str] = []
    camopt.sweep(NAME, tmp_path, tell=told.append)
    assert not caplog.messages
    with caplog.at_level(logging.INFO, logger="camopt"):
        camopt.sweep(NAME, tmp_path)
    assert caplog.messages == told == [f"{Path(tmp_path)} is up to date; `again` computes it anew"]
