"""Arguments of the public functions: scenes by name or path, options by keyword, counts, sentences in the log."""

import inspect
import logging
from inspect import signature
from pathlib import Path

import pandas as pd
import pytest

import camopt
from camopt import BadInput, find_scene
from camopt.core.storage.files import write_text

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
    assert caplog.messages == told == [f"{Path(tmp_path)} is up to date; use `again` to recompute"]


SCENE = find_scene("roller-1000rpm").replace(
    search={"base_radius": [60, 90, 120], "law": ["cycloidal"]}, tolerances={"profile": 0.02}
)
FRONT = camopt.sweep(
    SCENE.replace(
        **{
            "search.law": ["cycloidal", "poly345"],
            "search.minimise": ["base_radius_mm", "pressure_angle_max_deg"],
            "limits.pressure_angle": 50,
        }
    )
).to_pandas()
MERGED = FRONT.merge(pd.DataFrame({"base_radius_mm": [60.0, 90.0, 120.0], "price": [1, 2, 3]}))
NOTHING = SCENE.replace(**{"limits.pressure_angle": 0.5, "search.base_radius": {"start": 20, "stop": 30}})


def set_name(scene):
    scene.name = "x"


def set_speed(scene):
    scene.cam.rpm = 3


@pytest.mark.parametrize(
    ("call", "told"),
    {
        "no angle": (lambda: camopt.cam_points(SCENE, []), "angles = []: must be one or more cam angles, deg"),
        "words for angles": (
            lambda: camopt.cam_points(SCENE, "ten"),
            "angles = 'ten': must be one or more cam angles, deg",
        ),
        "a word for a lift": (lambda: camopt.timing(SCENE, "10"), "lift = '10': must be above 0"),
        "a lift too large": (lambda: camopt.timing(SCENE, 50), "lift = 50: must be above 0"),
        "an option of no picture": (
            lambda: camopt.plot(SCENE, constrction=6),
            "constrction = 6: is not an option of this picture; did you mean construction?",
        ),
        "an option of figures": (
            lambda: camopt.plot(SCENE, figsize=(3, 3)),
            "figsize = (3, 3): is not an option of this",
        ),
        "axes that are none": (lambda: camopt.plot(SCENE, ax=3), "ax = 3: must be axes of matplotlib"),
        "an optimum to draw": (
            lambda: camopt.plot(camopt.optimise(SCENE)),
            "the design of an optimum is its attribute best",
        ),
        "a frame to load": (lambda: camopt.load(FRONT), "path = 'DataFrame': must be a path"),
        "a number to load": (lambda: camopt.load(3), "path = 'int': must be a path"),
        "a scene as a folder": (lambda: camopt.sweep(SCENE, SCENE), "out = 'Scene': must be a path"),
        "a name set": (lambda: set_name(SCENE), "scene: name = 'x': cannot be changed; make a changed copy"),
        "a speed set": (lambda: set_speed(SCENE), "cam: rpm = 3: cannot be changed; make a changed copy"),
        "changes by position": (lambda: SCENE.replace({"cam.rpm": 5}), 'scene.replace(**{"cam.rpm": 500})'),
        "one axis": (lambda: camopt.frontier(SCENE, "size"), "axes = 'size': must be two or three different axes"),
        "one name": (lambda: camopt.sensitivities(SCENE)["base_radius_mm"], "'base_radius_mm' is one name; a sens"),
        "a progress": (
            lambda: camopt.sweep(SCENE, progress="yes"),
            "progress = 'yes': must be a function, True, F",
        ),
        "no output": (
            lambda: camopt.evaluate(SCENE)["area_mm2"],
            "'area_mm2' was not computed; add it to the out",
        ),
        "an evaluation": (lambda: camopt.evaluate(camopt.evaluate(SCENE)), "use its attribute scene"),
        "a mapping": (lambda: camopt.evaluate(SCENE.to_dict()), "Scene.from_dict makes a scene from a mapping"),
        "a page of nothing": (
            lambda: camopt.report(camopt.optimise(NOTHING), "a.html"),
            "design; none was feasible",
        ),
        "a merged table": (
            lambda: camopt.report(MERGED, "a.html"),
            "restores them",
        ),
        "a row of no scene": (
            lambda: camopt.report(MERGED.iloc[0], "a.html"),
            "scene: missing",
        ),
    }.values(),
)
def test_a_wrong_argument_gets_one_sentence(call, told):
    with pytest.raises(camopt.CamoptError) as refused:
        call()
    assert told in str(refused.value)
    assert "\n" not in str(refused.value).replace("\ncamopt: axes = 'size'", "")


@pytest.mark.slow
def test_one_of_several_stands_alone(tmp_path):
    assert camopt.timing(SCENE, 25).passages == camopt.timing(SCENE, [25]).passages
    alone, listed = (camopt.allocate(SCENE, 0.1, only=only) for only in ("profile", ["profile"]))
    assert alone == listed
    camopt.report(FRONT.iloc[0], tmp_path / "row.html")


def test_a_frame_that_pandas_wrote_is_read_by_pandas(tmp_path):
    FRONT.to_parquet(tmp_path / "front.parquet")
    with pytest.raises(BadInput, match=r"read it with pandas\.read_parquet, and give the frame"):
        camopt.report(tmp_path / "front.parquet", tmp_path / "page.html")
    MERGED.to_parquet(tmp_path / "other.parquet")
    with pytest.raises(BadInput, match="another program"):
        camopt.load(tmp_path / "other.parquet")
