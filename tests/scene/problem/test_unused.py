"""What a scene gives and nothing reads is said; --outputs calls for it."""

import json
from pathlib import Path

import pytest

from camopt import evaluate, find_scene, load
from camopt.cli.main import main
from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.scene_numbers import PRESS_EFFECTS
from camopt.scene.problem.scene_notes import (
    PRESSING_NUMBERS,
    READING_EFFECTS,
    constant_objective_notes,
    empty_output_notes,
    unused_value_notes,
)
from camopt.scene.tables import Dynamics, Materials

READING = (*(each for each in PRESS_EFFECTS if each != "clearance"), "lash")
GIVEN = {
    "cam.rpm": 600,
    "follower.dynamics": {
        "mass": 1.5, "spring_rate": 15, "preload": 250, "damping": 0.02, "load": 40, "gravity": 9.81,
        "guide_length": 90, "overhang": 80, "friction": 0.1, "stem_diameter": 16, "natural_frequency": 123,
        "damping_ratio": 0.05, "fluctuation": 0.02, "lash": 0.2, "lash_variation": 0.05,
    },
    "materials": {
        "cam_modulus": 200, "cam_poisson": 0.3, "follower_modulus": 110, "follower_poisson": 0.25, "face_width": 10,
        "wear_rate": 1e-10, "viscosity": 0.02, "pressure_viscosity": 18, "roughness": 0.3,
    },
    "outputs": READING,
}  # fmt: skip


@pytest.fixture(scope="session")
def loaded():
    """Two scenes that together have every load: rollers have a film, knives wear; without and with a swing."""
    roller = find_scene("two-pauses").replace(**GIVEN)
    flat = find_scene("flat-reciprocating").replace(**{**GIVEN, "outputs": (*READING, "face")})
    return {scene: evaluate(scene) for scene in (roller, flat)}


def test_each_key_of_loads_and_materials_has_its_readers():
    keys = {*Dynamics.model_fields, *Materials.model_fields}
    assert keys - {*READING_EFFECTS} == set(), (
        "READING_EFFECTS in camopt/scene/problem/scene_notes.py tells which effects read it"
    )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("key", sorted({*READING_EFFECTS} - {"inertia", "spring_at", "cam", "follower"}))
def test_a_key_changes_quantities_of_the_effects_that_read_it(loaded, key):
    table = "materials" if key in GIVEN["materials"] else "follower.dynamics"
    changed = set()
    for scene, before in loaded.items():
        after = evaluate(scene.replace(**{f"{table}.{key}": 1.1 * GIVEN[table][key]}))
        changed |= {QUANTITIES[n].effect for n in before if after[n] != before[n]} & {*READING, "face"}
    assert changed <= {*READING_EFFECTS[key]}
    assert changed


MASS = {"mass": 1, "spring_rate": 2}
NO_MASS = {"preload": 100, "natural_frequency": 90}
WHY = "no limit, objective or output uses"
EVERY = f"{', '.join([*GIVEN['follower.dynamics'], *GIVEN['materials']])}: {WHY} them; --outputs lash,force,torque,"


@pytest.mark.parametrize(
    ("outputs", "dynamics", "materials", "expected"),
    [
        (READING, GIVEN["follower.dynamics"], GIVEN["materials"], []),
        (["pressure"], GIVEN["follower.dynamics"], GIVEN["materials"], [EVERY]),
        ([], MASS, {}, [f"mass, spring_rate: {WHY} them; --outputs force,torque,thrust shows what they do"]),
        (
            ["force"],
            {"mass": 1, "friction": 0.1},
            {},
            [f"friction: {WHY} it; --outputs torque,thrust shows what it"],
        ),
        ([], {"preload": 100}, {}, ["preload: not used without follower.dynamics.mass"]),
        (["vibration"], NO_MASS, {}, ["preload: not used without follower.dynamics.mass"]),
        (["force"], {"mass": 1}, {"roughness": 0.3}, ["roughness: not used without "]),
        ([], None, {}, []),
    ],
)
def test_what_nothing_uses_is_named(outputs, dynamics, materials, expected):
    tables = {"follower.dynamics": dynamics, "materials": materials}
    found = unused_value_notes(find_scene("two-pauses").replace(**{**GIVEN, **tables, "outputs": outputs}))
    assert len(found) == len(expected)
    assert all(line.startswith(start) for line, start in zip(found, expected, strict=True))


def test_pressing_keys_are_those_of_the_force():
    assert {key for key, effects in READING_EFFECTS.items() if "force" in effects} == {*PRESSING_NUMBERS}


def test_the_line_is_an_error_output_that_quiet_stops(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = find_scene("two-pauses").replace(**{"cam.rpm": 300, "follower.dynamics": {"mass": 1}})
    Path("mine.toml").write_text(scene.to_toml(), encoding="utf-8")
    line = "camopt: mass: no limit, objective or output uses it; --outputs force,torque,thrust shows what it does\n"
    for command in ("evaluate", "optimise", "sweep"):
        assert main([command, "mine.toml", "--json"]) == 0
        out, err = capsys.readouterr()
        assert line in err
        assert "contact_force_max_N" not in json.loads(out)
        main([command, "mine.toml", "--quiet"])
        assert capsys.readouterr().err == ""
    main(["evaluate", "mine.toml", "--json", "--outputs", "force,torque_peak_N_m"])
    out, err = capsys.readouterr()
    assert {"contact_force_max_N", "torque_peak_N_m", "feasible"} < json.loads(out).keys()
    assert "torque_mean_N_m" not in json.loads(out)
    assert err == ""
    main(["evaluate", "mine.toml", "--json", "--outputs", "all"])
    assert {"torque_mean_N_m", "pressure_angle_max_deg"} < json.loads(capsys.readouterr().out).keys()


def test_an_output_that_is_none_is_refused(capsys):
    assert main(["evaluate", "two-pauses", "--outputs", "hurtz"]) == 2
    assert (
        "--outputs = 'hurtz': must be a quantity, an effect (camopt effects lists them) or all; did you mean hertz?"
        in capsys.readouterr().err
    )


def test_outputs_that_lack_data_are_told(capsys):
    assert main(["evaluate", "exhaust-valve", "--outputs", "solid,wall,hertz,motion"]) == 0
    told = capsys.readouterr().err
    for effect, key in (("solid", "part.thickness"), ("wall", "part.bore"), ("hertz", "materials.cam")):
        assert f"outputs: {effect} shows nothing without " in told
        assert key in told
    assert "motion shows" not in told


@pytest.mark.parametrize("name", ["valve-rod-radial", "feeder-with-stop"])
def test_outputs_that_are_shown_are_not(name):
    assert empty_output_notes(find_scene(name).replace(outputs=["solid", "wall", "motion"])) == []
    assert empty_output_notes(find_scene(name).replace(outputs=["all"])) == []


@pytest.mark.parametrize(
    ("varied", "told"),
    [
        ({"law": ["cycloidal"]}, {"acceleration_max_m_s2", "roller_radius_mm"}),
        ({"law": ["cycloidal", "poly345"]}, {"roller_radius_mm"}),
        ({"cam": {"rpm": [500, 1000]}}, {"roller_radius_mm"}),
        ({"roller_radius": [5, 10]}, {"acceleration_max_m_s2"}),
    ],
)
def test_objectives_that_are_the_same_for_all_designs_are_told(varied, told, tmp_path, capsys, monkeypatch):
    """Those of which the table of all designs has one value."""
    monkeypatch.chdir(tmp_path)
    names = ("base_radius_mm", "acceleration_max_m_s2", "pressure_angle_max_deg", "roller_radius_mm")
    search = {"base_radius": [90, 120], "minimise": names, **varied}
    scene = find_scene("roller-1000rpm").replace(search=search)
    Path("mine.toml").write_text(scene.to_toml(), encoding="utf-8")
    main(["sweep", "mine.toml", "--keep", "all", "--out", "out"])
    table = load(tmp_path / "out" / "designs.parquet")
    assert {name for name in names if table[name].nunique() == 1} == told
    (line,) = constant_objective_notes(scene)
    assert {word.strip(",") for word in line.split()} & {*names} == told
    assert line in capsys.readouterr().err


def test_stresses_told_of_each_contact_use_masses_and_materials():
    assert (
        unused_value_notes(
            find_scene("press-feed-by-pair").replace(outputs=("pair",), limits={"pressure_angle": 40})
        )
        == []
    )


def test_options_name_the_objectives_in_place_of_the_scenes(tmp_path, capsys):
    sizes = ("--base-radius", "90", "--offset", "0", "--roller-radius", "5")
    small = ["sweep", *sizes, "--out", str(tmp_path / "out")]
    assert main([*small, "--minimise", "profile_radius_min_mm,base_radius_mm", "--json"]) == 0
    ideal = json.loads(capsys.readouterr().out)["front"]["ideal"]
    assert ideal.keys() == {"profile_radius_min_mm", "base_radius_mm"}
    assert main([*small, "--maximise", "pressure_angle_max_deg", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["front"]["ideal"].keys() == {"pressure_angle_max_deg"}
    assert main([*small, "--minimise", "speed"]) == 2
    assert "--minimise = 'speed': must be a quantity" in capsys.readouterr().err
