"""Numbers of the scene that are no sizes, such as a spring rate, varied by a sweep."""

from functools import cache
from itertools import product
from typing import get_type_hints

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import hostile
from support.cams import CONTACTS, GUIDED, WORN, cam_with
from support.depth import is_deep, times

from camopt import (
    BadInput,
    Scene,
    certify,
    evaluate,
    evaluate_designs,
    find_scene,
    load,
    optimise,
    scene_of,
    sweep,
    synthesise,
)
from camopt.cli.main import main
from camopt.core.numerics.extremes import extremes_of_curve
from camopt.core.quantities import QUANTITIES, quantity_name_by_number_key
from camopt.core.storage.tables import read_table
from camopt.model.effects import available_quantities, effect
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.sample import sweep_space
from camopt.scene.problem.scene_notes import unused_value_notes
from camopt.scene.problem.settings import MOST_SETTINGS
from camopt.scene.sizes import SEARCH_SIZES
from camopt.scene.tables import Cam, Dynamics, Materials
from camopt.solve.front import front_search
from camopt.solve.front.table_certificate import certify_table

TABLES = {"cam": Cam, "follower.dynamics": Dynamics, "materials": Materials}
NUMBERS = {
    f"{table}.{key}"
    for table, model in TABLES.items()
    for key, hint in get_type_hints(model, include_extras=True).items()
    if key in model.model_fields and key not in {*SEARCH_SIZES, *model.read_as} and "float" in str(hint)
}
"""The keys of all numbers of the scene that are no sizes, as the tables declare them."""
VALVE = find_scene("exhaust-valve").replace(
    **{
        "cam.rpm": 500,
        "follower.dynamics": {"mass": 0.8, "spring_rate": 20, "preload": 300},
        "materials": {"cam": "steel", "follower": "steel", "face_width": 20},
        "limits": {"pressure_angle": 35, "contact_force_min": 10, "contact_stress": 1500},
        "search": {
            "base_radius": {"start": 40, "stop": 120, "step": 10},
            "follower": {
                "dynamics": {
                    "spring_rate": {"start": 10, "stop": 20, "step": 10},
                    "preload": [100, 300],
                }
            },
            "law": ["poly345", "cycloidal"],
            "minimise": ["base_radius_mm", "spring_rate_N_per_mm", "contact_stress_max_MPa"],
        },
    }
)


@cache
def loaded_scene(contact):
    """A scene of a contact with every load, and the numbers that it gives."""
    dynamics = None if CONTACTS[contact]["motion"] == "oscillating" else GUIDED
    train = {"natural_frequency": 90.0, "damping_ratio": 0.05, "fluctuation": 0.02}
    scene = Scene.from_dict(cam_with(contact, "poly345", dynamics, materials=WORN))
    scene = scene.replace(**{f"follower.dynamics.{key}": value for key, value in train.items()})
    return scene, {key: value for key, value in scene.numbers(sorted(NUMBERS)).items() if isinstance(value, float)}


def question(contact, seed):
    """A random space of numbers, sizes and laws of a contact; a grid or a sample."""
    rng = np.random.default_rng(seed)
    scene, numbers = loaded_scene(contact)
    given_sizes = [*scene.cam, *scene.follower]
    sizes = {key: value for key, value in given_sizes if key in SEARCH_SIZES and value}
    own = {**numbers, **sizes}
    free = [str(key) for key in rng.permutation([*numbers])[: rng.integers(1, 3)]]
    free += [str(key) for key in rng.permutation([*sizes])[: rng.integers(0, 2)]]
    search = {"search": {"law": rng.permutation(["poly345", "cycloidal"])[: rng.integers(1, 3)].tolist()}}
    if rng.random() < 0.5:
        search["search"] |= {"samples": int(rng.integers(1, 7)), "seed": int(rng.integers(100))}
    for key in free:
        low, high = own[key] * (1.0 - 0.1 * rng.random()), own[key] * (1.0 + 0.1 * rng.random())
        values = rng.permutation([low, high])[: rng.integers(1, 3)].tolist()
        search[f"search.{key}"] = values if rng.random() < 0.5 else {"start": low, "stop": high, "step": high - low}
    offers = [name for name in available_quantities(resolve(scene).setup) if QUANTITIES[name].kind is float]
    names = [name for name in offers if is_deep() or QUANTITIES[name].effect != "surface"]
    angular = scene.follower.motion == "oscillating"
    search["search.minimise"] = [quantity_name_by_number_key(angular=angular, tool_turns=angular)[free[0]]]
    search["search.maximise"] = rng.permutation(names)[:1].tolist()
    limits = {"pressure_angle": 60} if rng.random() < 0.5 else {}
    return scene.replace(**search, limits=limits, outputs=["sizes", *rng.permutation(names)[:2].tolist()])


def rows_agree(row, cam, tolerance):
    """Whether a row of a table has what ``evaluate`` says, to a tolerance."""
    for name in set(row.index) - {"relative_half_width"}:
        expected = cam[name]
        close = pytest.approx(expected, rel=tolerance, abs=tolerance) if isinstance(expected, float) else expected
        assert row[name] == close, name


@pytest.mark.one_in(3)
@pytest.mark.parametrize("contact", CONTACTS)
@given(seed=st.integers(0, 10**6), block=st.sampled_from([1, 7, 32768]), workers=st.integers(1, 2))
@settings(max_examples=times(1, deep=60))
def test_each_row_is_what_evaluate_says_of_the_scene_with_its_numbers(
    contact, seed, block, workers, tmp_path_factory
):
    scene, out = question(contact, seed), tmp_path_factory.mktemp("swept")
    swept = sweep(scene, out, keep="all", workers=workers, block=block)
    designs, front = load(out / "designs.parquet"), load(out / "pareto.parquet")
    assert len(designs) + swept.impossible == swept.designs == len(sweep_space(resolve(scene)))
    columns = {each.key: each.quantity for each in resolve(scene).search_space.numbers}
    for key, name in columns.items():
        choice = scene.search.numbers[key]
        within = (choice.start, choice.stop) if not isinstance(choice, tuple) else (min(choice), max(choice))
        assert designs[name].between(*within).all()
    for row in np.random.default_rng(seed).permutation(len(designs))[:1].tolist():
        one = scene_of(designs, row)
        assert list(one.numbers(columns).values()) == designs.loc[row, list(columns.values())].tolist()
        rows_agree(designs.loc[row], evaluate(one), 1e-8)
    for row in range(min(len(front), 1)):
        rows_agree(front.loc[row], evaluate(scene_of(front, row)), 0.0)
    again = out / "again"
    sweep(scene, again, keep="all")
    assert (out / "designs.parquet").read_bytes() == (again / "designs.parquet").read_bytes()


def test_a_grid_has_every_combination_once(tmp_path):
    swept = sweep(VALVE, tmp_path, keep="all")
    rows = load(tmp_path / "designs.parquet")
    names = ["law_rise", "base_radius_mm", "spring_rate_N_per_mm", "preload_N"]
    expected = product(["poly345", "cycloidal"], range(40, 121, 10), [10, 20], [100, 300])
    assert sorted(rows[names].itertuples(index=False, name=None)) == sorted(expected)
    assert swept.designs == len(rows) == 2 * 9 * 4
    assert rows.attrs["units"]["spring_rate_N_per_mm"] == "N/mm"


@pytest.mark.slow
@pytest.mark.parametrize("more", [{}, {"search.samples": 40}], ids=["grid", "sample"])
def test_a_sweep_is_the_sweeps_of_all_settings_together(more, tmp_path):
    """Front and feasible designs are those of the scenes with one setting each, joined by hand."""
    scene = VALVE.replace(**more)
    swept, feasible = sweep(scene, tmp_path), 0
    rows = load(tmp_path / "designs.parquet")
    columns = {each.key: each.quantity for each in resolve(scene).search_space.numbers}
    for values, some in rows.groupby(list(columns.values())):
        one = scene.replace(**dict(zip(columns, values, strict=True)))
        found = [evaluate(scene_of(rows, row)) for row in some.index[:1]]
        assert all(each["feasible"] for each in found)
        if not more:
            sizes = {f"search.{key}": [value] for key, value in zip(columns, values, strict=True)}
            alone = sweep(one.replace(**sizes), tmp_path / "alone", keep="feasible")
            feasible += alone.feasible
            alike = load(tmp_path / "alone" / "designs.parquet")
            assert alike.equals(some.reset_index(drop=True))
    costs = rows[list(scene.search.minimise)].to_numpy()
    better = [np.any(np.all(costs <= own, axis=1) & np.any(costs < own, axis=1)) for own in costs]
    assert swept.pareto == len(rows) - sum(better)
    assert more or feasible == swept.feasible == len(rows)


RUBBING = {
    "follower.dynamics": {"mass": 1, "guide_length": 60, "overhang": 50, "friction": 0.0},
    "search.follower.dynamics": {"friction": [0.0, 0.1], "preload": [300]},
    "search.law": ["cycloidal"],
    "limits": {"pressure_angle": 35},
}


FAST = {
    "search.cam.rpm": {"start": 300, "stop": 900, "step": 100},
    "follower.dynamics.natural_frequency": 150,
    "search.follower.dynamics.natural_frequency": [100, 150, 160],
}


@pytest.mark.one_in(4)
@pytest.mark.usefixtures("_boxes")
@pytest.mark.parametrize(
    ("minimise", "more"),
    [
        (["base_radius_mm", "preload_N"], {}),
        (["base_radius_mm", "torque_mean_N_m"], RUBBING),
        (["base_radius_mm", "contact_force_max_N", "acceleration_max_m_s2"], FAST | {"search.maximise": ["rpm"]}),
        (["base_radius_mm"], FAST | {"search.maximise": ["jump_speed_rpm", "rpm"]}),
        (["base_radius_mm", "residual_vibration_max_mm"], FAST),
        (["torque_rms_N_m", "contact_stress_max_MPa"], FAST),
    ],
)
def test_boxes_give_the_front_of_the_full_sweep(minimise, more, tmp_path, monkeypatch):
    """Boxes span numbers too; vibrations and jump speeds are known of one setting, not of ranges."""
    monkeypatch.setattr(front_search, "FEW_DESIGNS", 2)
    for keep in ("pareto", "front-only"):
        scene = VALVE.replace(**{**more, "search.minimise": minimise, "search.base_radius.step": 8})
        sweep(scene, tmp_path / keep, keep=keep)
    assert load(tmp_path / "pareto/pareto.parquet").equals(load(tmp_path / "front-only/pareto.parquet"))


def test_a_refined_front_keeps_the_numbers_of_its_rows(tmp_path):
    """Each setting has its own smallest cam: that of ``optimise`` for the scene with these numbers."""
    scene = VALVE.replace(**{"search.refine": True, "search.minimise": ["base_radius_mm", "preload_N"]})
    scene = scene.replace(**{"search.follower.dynamics.spring_rate": [10], "limits.contact_stress": None})
    sweep(scene, tmp_path)
    rows = load(tmp_path / "pareto.parquet")
    assert set(rows["preload_N"]) <= {100.0, 300.0}
    for _, row in rows.iterrows():
        numbers = {"follower.dynamics.preload": row["preload_N"], "follower.dynamics.spring_rate": 10}
        best = optimise(scene.replace(**numbers, **{"search.follower": None, "search.minimise": None})).best
        assert row["base_radius_mm"] == pytest.approx(best["base_radius_mm"], rel=1e-9)


@pytest.mark.slow
@pytest.mark.usefixtures("_few_levels")
def test_a_refined_front_moves_numbers_in_their_ranges(tmp_path):
    """Its smallest cam is that of ``optimise``, which frees the spring too; no row of the grid is better.

    A weak spring lets go of the cam, and a strong one presses more on it than is needed.
    """
    objectives = ["base_radius_mm", "contact_stress_max_MPa"]
    scene = VALVE.replace(**{"cam.rpm": 900, "search.refine": True, "search.minimise": objectives})
    scene = scene.replace(**{"search.follower.dynamics.spring_rate": {"start": 5, "stop": 80, "step": 25}})
    scene = scene.replace(limits={"pressure_angle": 35, "jump_speed_ratio": 1.2, "contact_stress": 1000})
    sweep(scene, tmp_path)
    rows, grid = load(tmp_path / "pareto.parquet"), load(tmp_path / "pareto-grid.parquet")
    best = optimise(scene.replace(**{"search.minimise": None})).best
    assert rows["base_radius_mm"].min() == pytest.approx(best["base_radius_mm"], rel=1e-9)
    assert not set(rows["spring_rate_N_per_mm"]) <= {5.0, 30.0, 55.0, 80.0}
    assert rows["spring_rate_N_per_mm"].between(5.0, 80.0).all()
    for _, row in grid.iterrows():
        assert rows[objectives].le(row[objectives] * (1.0 + 1e-8)).all(axis=1).any()
    for row in np.linspace(0, len(rows) - 1, 5).astype(int).tolist():
        assert evaluate(scene_of(rows, row))["feasible"]


def test_the_rows_of_a_table_are_certified_with_their_numbers(tmp_path):
    scene = VALVE.replace(**{"search.base_radius": [60, 80], "search.follower.dynamics.spring_rate": [10]})
    swept = sweep(scene, tmp_path, keep="all")
    counts = certify_table(tmp_path / "designs.parquet")
    rows = load(tmp_path / "designs.parquet")
    assert (rows["proof"] == "held").tolist() == rows["feasible"].tolist()
    assert counts["held"] == swept.feasible
    assert 0 < swept.feasible < swept.designs
    broken = rows.index[rows["proof"] != "held"][0]
    assert "broken" in certify(scene_of(rows, broken)).values()


def test_a_table_of_designs_may_have_numbers(tmp_path):
    """The rows of a sweep, given as a table to a scene that searches nothing, have the same quantities."""
    sweep(VALVE, tmp_path, keep="all")
    rows = load(tmp_path / "designs.parquet")
    columns = ["base_radius_mm", "preload_N", "spring_rate_N_per_mm"]
    alone = VALVE.replace(search=None, outputs=["sizes", "contact_force_min_N", "contact_stress_max_MPa"])
    found = evaluate_designs(alone, rows[columns].assign(law=rows["law_rise"]).iloc[::-1]).iloc[::-1]
    assert (found["violated"] == rows["violated"]).all()
    for name in [*columns, "contact_force_min_N", "contact_stress_max_MPa"]:
        np.testing.assert_allclose(found[name], rows[name], rtol=1e-8)
    assert evaluate_designs(alone, {"base_radius_mm": [], "preload_N": []}).empty


@pytest.mark.parametrize(
    ("column", "message"),
    [
        ({"preload_N": [3, -1]}, "designs: preload_N[1] = -1: must be at least 0"),
        ({"preload_N": [3, "x"]}, "designs: preload_N[1] = 'x': must be a number"),
        ({"preload_N": [3, float("nan")]}, "designs: preload_N[1] = nan: must be a finite number"),
        ({"preload": [3, 1]}, "designs: preload: this mechanism has no such size, number or law; did you mean"),
        ({"overhang_mm": [90, 3]}, "designs: overhang_mm = [3.0, 90.0]: must be at least the lift (37.5)"),
        ({"inertia_kg_m2": [3, 1]}, "designs: inertia_kg_m2 = [1.0, 3.0]: a disc cam with a translating roller"),
    ],
)
def test_numbers_that_no_design_has_are_mistakes(column, message):
    with pytest.raises(BadInput) as caught:
        evaluate_designs(VALVE, {"base_radius_mm": [60, 70], **column}, strict=True)
    assert message in str(caught.value)
    assert len(caught.value.mistakes) == 1


def test_numbers_that_nothing_uses_are_named():
    scene = find_scene("exhaust-valve").replace(**{"search.follower.dynamics.preload": [1, 2]})
    assert unused_value_notes(scene) == ["preload: not used without follower.dynamics.mass"]
    assert unused_value_notes(VALVE) == []


@pytest.mark.parametrize("value", [-1.0, 1e300, float("inf"), float("nan")])
def test_a_table_with_numbers_that_no_scene_has_is_refused(value, tmp_path):
    sweep(VALVE.replace(**{"search.base_radius": [80]}), tmp_path)
    table, path = read_table(tmp_path / "designs.parquet"), tmp_path / "alone" / "t.parquet"
    path.parent.mkdir()
    path.write_bytes(hostile.in_bytes(hostile.replace_first_value(table, "preload_N", value)))
    with pytest.raises(BadInput, match=r"its designs have mistakes, such as designs: preload_N"):
        certify_table(path)


def test_numbers_that_only_the_search_has_are_missing_elsewhere():
    scene = VALVE.replace(**{"cam.rpm": None, "search.cam.rpm": [400, 500]})
    assert sweep(scene).best["poly345"]["rpm"] in (400.0, 500.0)
    with pytest.raises(BadInput, match=r"cam\.rpm: missing; only sweep and optimise work without it") as caught:
        evaluate(scene)
    assert len(caught.value.mistakes) == 1


def test_commands_that_take_the_scene_s_own_numbers_say_so():
    what = r"search\.follower\.dynamics\.preload: .* only sweep and optimise can vary it"
    with pytest.raises(BadInput, match=what) as caught:
        synthesise(VALVE)
    assert len(caught.value.mistakes) == 2
    with pytest.raises(BadInput, match=r"search\.cam\.shaft_diameter: .* only sweep can vary it"):
        optimise(VALVE.replace(**{"search.cam.shaft_diameter": [20, 30]}))


@pytest.mark.parametrize("key", sorted(NUMBERS))
@pytest.mark.parametrize("angular", [False, True])
def test_every_number_of_the_scene_is_a_quantity(key, angular):
    quantity = QUANTITIES[quantity_name_by_number_key(angular=angular, tool_turns=angular)[key]]
    assert quantity.name.startswith(key.rpartition(".")[2])
    assert quantity.sentence


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"search.cam.base_radius": [3]}, "search.cam.base_radius = [3]: is a size: write search.base_radius"),
        (
            {"search.follower.roller_radius": 3},
            "search.follower.roller_radius = 3: is a size: write search.roller_",
        ),
        ({"search.cam.form": "disc"}, "search.cam.form = 'disc': not a number of this table; did you mean rpm?"),
        (
            {"search.follower.dynamics.mas": 1},
            "search.follower.dynamics.mas = 1: not a number of this table; did you",
        ),
        ({"search.follower.dynamics": 1}, "search.follower.dynamics = 1: must be a table"),
        ({"search.cam": 1}, "search.cam = 1: must be a table"),
        ({"search.cam.rpm": []}, "search.cam.rpm = []: must be a list of at least one value"),
        ({"search.cam.rpm": "fast"}, "search.cam.rpm = 'fast': must be a number, a list of numbers, or a table"),
        ({"search.cam.rpm": [300, 0]}, "search.cam.rpm.2 = 0.0: must be at least 1e-09; set the sense of rotation"),
        ({"search.cam.rpm": float("nan")}, "search.cam.rpm.1 = nan: must be a finite number"),
        ({"search.cam.rpm": {"start": 9, "stop": 3}}, "must be a range whose stop is not below its start"),
        ({"search.cam.rpm": {"start": 3}}, "search.cam.rpm.stop: missing"),
        ({"search.cam.rpm": {"start": 3, "stop": 9, "step": 0}}, "search.cam.rpm.step = 0: must be at least 1e-15"),
        (
            {"search.follower.dynamics.damping_ratio": {"start": 0, "stop": 1}},
            "search.follower.dynamics.damping_ratio.stop = 1.0: must be below 1",
        ),
        ({"search.materials.cam_poisson": [0.5]}, "search.materials.cam_poisson.1 = 0.5: must be below 0.5"),
        (
            {"search.materials.cam": ["steel"]},
            "search.materials.cam = ['steel']: not a number of this table; did you mean cam_modulus",
        ),
        (
            {"search.motion": {"lift": 3}},
            "search.motion = {'lift': 3}: all designs have one motion; only its",
        ),
        ({"search.limits": {"jerk": 3}}, "search.limits = {'jerk': 3}: all designs have the same limits"),
        ({"search.follower.dynamics.inertia": [3]}, "inertia = [3]: a disc cam with a translating roller follower"),
        ({"search.follower.dynamics.overhang": [3, 90]}, "overhang = [3, 90]: must be at least the lift (37.5)"),
        (
            {"follower.dynamics.load": [[0, 3], [90, 4]], "search.follower.dynamics.load": 3},
            "search.follower.dynamics.load = 3: follower.dynamics.load changes over the turn",
        ),
    ],
)
def test_numbers_that_cannot_be_searched_are_mistakes(changes, message):
    with pytest.raises(BadInput) as caught:
        VALVE.replace(**changes)
    assert message in str(caught.value)
    assert len(caught.value.mistakes) == 1


def test_many_springs_ask_the_kernels_as_often_as_few(monkeypatch):
    """Numbers are arrays of the designs, as sizes are: no search of extremes is for one setting alone."""
    asked = []
    monkeypatch.setattr(
        effect, "extremes_of_curve", lambda *given: asked.append(given[1]) or extremes_of_curve(*given)
    )
    limited = VALVE.replace(
        **{"limits.torque": 500, "limits.side_thrust": 5000, "search.follower": None, "search.minimise": None}
    )
    calls = []
    for count in (16, 1024):
        asked.clear()
        springs = np.linspace(10.0, 20.0, count)
        found = evaluate_designs(limited, {"base_radius_mm": springs + 40.0, "spring_rate_N_per_mm": springs})
        assert len(found) == count
        calls.append(len(asked))
    assert calls[0] == calls[1] > 0


TOO_MANY = f"search: must be ranges and lists with at most {MOST_SETTINGS:,} combinations of train numbers"
JAMMING = {"mass": 1, "guide_length": 50, "overhang": 50, "friction": 0.1}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"search.cam.rpm": {"start": 3, "stop": 9}},
            "search.cam.rpm.step: must be above 0 for a sweep of",
        ),
        (
            {"search.cam.shaft_diameter": {"start": 1, "stop": 2}, "search.samples": MOST_SETTINGS + 1},
            TOO_MANY,
        ),
        (
            {
                "follower.dynamics": JAMMING,
                "limits.jamming_margin": 0.1,
                "search.follower.dynamics": {"friction": [0.1, 0]},
                "search.minimise": None,
            },
            "search.follower.dynamics.friction = 0.0: must be above 0: jamming_margin needs it",
        ),
    ],
)
def test_spaces_that_cannot_be_swept_are_mistakes(changes, message, tmp_path):
    with pytest.raises(BadInput) as caught:
        sweep(VALVE.replace(**changes), tmp_path / "out")
    assert message in str(caught.value)
    assert len(caught.value.mistakes) == 1
    assert not (tmp_path / "out").exists()


def test_a_scene_with_searched_numbers_is_the_same_in_toml():
    scene = VALVE.replace(**{"search.cam.rpm": {"start": 100, "stop": 900}, "search.materials.wear_rate": 1e-11})
    assert Scene.from_dict(scene.to_dict()) == scene
    assert list(scene.search.numbers) == sorted(scene.search.numbers)
    cleared = scene.replace(**{f"search.{key}": None for key in scene.search.numbers})
    assert cleared == VALVE.replace(**{"search.follower": None})


def test_the_command_varies_numbers(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    spring = "follower.dynamics.spring_rate=2:10:1"
    options = ["--rpm", "500", "--vary", spring, "--vary", "follower.dynamics.preload=250", "--quiet"]
    assert main(["sweep", "exhaust-valve", "--base-radius", "60:80:10", "--max-pressure", "60", *options]) == 0
    assert "27 designs" in capsys.readouterr().out
    assert sorted(set(load("camopt-out/pareto.parquet")["spring_rate_N_per_mm"])) == [*range(2, 11)]
    again = ["--vary", "cam.rpm=200:400:100", "--outputs", "sizes"]
    assert main(["sweep", "camopt-out/scene.toml", *again, "--out", "speeds", "--quiet"]) == 0
    assert set(load("speeds/designs.parquet")["rpm"]) == {200.0, 300.0, 400.0}
    assert main(["sweep", "speeds/scene.toml", "--rpm", "450", "--out", "one-speed", "--quiet"]) == 0
    assert set(load("one-speed/designs.parquet")["rpm"]) == {450.0}
    capsys.readouterr()
    assert main(["sweep", "exhaust-valve", "--vary", "cam.rmp=3"]) == 2
    assert "--vary cam.rmp = " in capsys.readouterr().err
    assert main(["sweep", "exhaust-valve", "--vary", "cam.rpm"]) == 2
    assert "'cam.rpm' is not KEY=START:STOP:STEP" in capsys.readouterr().err
