"""Tables of designs: what was asked beside its limit, nothing that is 0 whatever the design, on any screen."""

from pathlib import Path

import pytest

from camopt import evaluate, find_scene, optimise, sweep
from camopt.cli.main import main
from camopt.cli.terminal import show, table_of
from camopt.problem.problem import resolve
from camopt.tables.columns import bounds_of, columns_of, is_nothing, with_law

FLAT = {
    "cam.rpm": 300,
    "follower.dynamics": {"mass": 0.5, "spring_rate": 5, "preload": 100},
    "materials": {"cam": "steel", "follower": "steel", "face_width": 10},
    "limits": {"contact_stress": 150, "jump_speed": 400, "face_reach": 30, "velocity": 2},
    "search.base_radius": [20, 40, 60],
}


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def flat():
    return find_scene("flat-reciprocating").replace(**FLAT)


def shown(capsys, scene, *command):
    Path("mine.toml").write_text(scene.to_toml(), encoding="utf-8")
    main([command[0], "mine.toml", "--quiet", *map(str, command[1:])])
    return capsys.readouterr().out


def test_limited_quantities_stand_beside_their_limits(capsys):
    bounds = {
        "velocity_max_m_s": "≤ 2",
        "face_reach_max_mm": "± 30",
        "face_reach_min_mm": "± 30",
        "profile_radius_min_mm": "> 0",
        "jump_speed_rpm": "≥ 400",
        "contact_stress_max_MPa": "≤ 150",
    }
    assert bounds_of(resolve(flat())) == bounds
    for command in ("optimise", "sweep"):
        text = shown(capsys, flat(), command)
        assert all(bound in text for bound in bounds.values())
        assert "pressure" not in text
        assert "offset" not in text


@pytest.mark.parametrize("name", ["knife-300rpm-offset", "flat-reciprocating"])
def test_no_column_is_zero_whatever_the_design(name):
    scene = find_scene(name).replace(**{"limits.pressure_angle": 40})
    row = evaluate(scene)
    zero = {"roller_radius_mm"} if name.startswith("knife") else {n for n in row if n.startswith("pressure_angle")}
    assert {n for n in row if n != "offset_mm" and n in row and not isinstance(row[n], (str, bool))
            and is_nothing(scene, n, [row])} == zero  # fmt: skip
    assert zero
    assert not zero & set(columns_of(resolve(scene), [row]))


def test_a_pressure_angle_is_no_objective_of_a_flat_face():
    assert sweep(flat()).scene.search.minimise == ("base_radius_mm", "acceleration_max_m_s2")
    roller = find_scene("roller-1000rpm").replace(search={"base_radius": [90, 100]})
    assert sweep(roller).scene.search.minimise[2:] == ("pressure_angle_max_deg",)


def test_an_angle_over_the_turn_is_one_column():
    scene = find_scene("roller-1000rpm").replace(limits={"pressure_angle": 40}, search={})
    problem, rows = resolve(scene), with_law([evaluate(scene)])
    parts = ["pressure_angle_max_rise_deg", "pressure_angle_max_return_deg"]
    assert [n for n in columns_of(problem, rows) if "pressure" in n] == parts
    whole = "pressure_angle_max_deg"
    assert [n for n in columns_of(problem, rows, [whole]) if "pressure" in n] == [whole]
    other = resolve(scene.replace(**{"limits.pressure_angle_return": 50}))
    assert {n for n in columns_of(other, rows, [whole]) if "pressure" in n} == {whole, *parts}


def test_outputs_have_columns(capsys):
    scene = flat().replace(outputs=["force"])
    rows = [*optimise(scene).by_law.values(), *sweep(scene).best.values()]
    assert all({"contact_force_max_N", "preload_required_N"} <= row.keys() for row in rows)
    for command in ("optimise", "sweep"):
        text = shown(capsys, scene, command)
        assert "preload" in text


def test_a_miss_shows_each_value_beside_its_limit(capsys):
    text = shown(capsys, flat().replace(**{"limits.contact_stress": 10}), "sweep")
    line = next(line for line in text.splitlines() if line.startswith("contact_stress_max_MPa"))
    assert line.split()[2:] == ["MPa", "≤", "10", "broken"]
    held = next(line for line in text.splitlines() if line.startswith("jump_speed_rpm"))
    assert held.split()[2:] == ["rpm", "≥", "400"]
    assert "It breaks contact_stress." in text


@pytest.mark.parametrize("width", [40, 80, 130])
def test_nothing_is_cut_off_at_any_width(capsys, monkeypatch, width):
    monkeypatch.setattr("camopt.cli.terminal.room_across", lambda: width)
    laws = ["modified-trapezoid", "cycloidal"]
    rows = [
        {"law": law, "base_radius_mm": 43.75, "binding": "pressure_angle, pressure_angle_return"} for law in laws
    ]
    title = "A title that is longer than its table, and than a narrow screen"
    show(table_of(title, rows, ["law", "base_radius_mm", "binding"], {"base_radius_mm": "≥ 20"}))
    text = capsys.readouterr().out
    assert title in text
    for word in (*laws, "43.75", "≥ 20", "pressure_angle,", "pressure_angle_return"):
        assert word in text
