"""Tables of designs: what was asked beside its limit, nothing that is 0 whatever the design, on any screen."""

import re
from pathlib import Path

import pytest

from camopt import evaluate, find_scene, optimise, sweep
from camopt.cli.main import main
from camopt.cli.terminal import print_sections
from camopt.core.quantities import QUANTITIES
from camopt.scene.problem.problem import resolve
from camopt.show.drawing.picture import four_digit_text
from camopt.show.reporting.sections import limits_table, number_text_with_minus_sign
from camopt.show.sheet.marks import decimal_text as sheet_number
from camopt.solve.tables.cells import number_text, quantity_text
from camopt.solve.tables.designs import (
    design_table_columns,
    is_unsearched_zero_column,
    limit_texts_by_quantity,
    with_rise_law_as_law_column,
)
from camopt.solve.tables.result import ABOUT, NUMERIC, VALUE, Cell, Table, table_of

ZEROS = [
    ("pressure_angle_max_deg", 4.97e-13, "0"),
    ("pressure_angle_max_deg", -0.0, "0"),
    ("offset_mm", -1e-12, "0"),
    ("contact_force_min_N", 1e-10, "0"),
    ("offset_mm", -1e-8, "-1e-08"),
    ("cam_inertia_kg_m2", 4.97e-13, "4.97e-13"),  # of a cam as small as that
    ("gap_mm", 8e-11, "8e-11"),
    ("law_rise", "cycloidal", "cycloidal"),
]
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


def printed_table(capsys, scene, *command):
    Path("mine.toml").write_text(scene.to_toml(), encoding="utf-8")
    main([command[0], "mine.toml", "--quiet", *map(str, command[1:])])
    return capsys.readouterr().out


@pytest.mark.parametrize(("name", "value", "text"), ZEROS)
def test_what_rounding_leaves_of_zero_is_shown_as_zero(name, value, text):
    assert quantity_text(name, value) == text


@pytest.mark.parametrize("value", [0.0, -0.0])
def test_zero_has_no_sign(value):
    assert (
        number_text(value),
        number_text_with_minus_sign(value),
        four_digit_text(value),
        sheet_number(value),
    ) == ("0", "0", "0", "0")


@pytest.mark.parametrize("beyond", [0.0, 1e-12, -1e-12, 1e-3, -1e-3])
def test_a_limit_that_is_just_held_has_a_margin_of_zero(beyond):
    """By rounding it is ±10⁻¹¹; where the limit is broken, by how much is told."""
    scene = find_scene("two-pauses")
    largest = evaluate(scene)["pressure_angle_max_return_deg"]
    limited = scene.replace(**{"limits.pressure_angle_return": largest * (1 + beyond)})
    cells = {row[0].text: row for row in limits_table(evaluate(limited), resolve(limited)).rows}
    _, verdict, _, _, margin, _ = (cell.text for cell in cells["pressure angle return"])
    if verdict == "held":
        assert (margin == "0 deg") == (abs(beyond) < 1e-9)
    else:
        assert margin.startswith("−") or beyond == 0.0
    assert verdict == "held" or beyond <= 0.0


def test_sentences_are_no_longer_than_a_line(capsys):
    """What is shown of a design: a hundred columns in a file, no word lost."""
    text = printed_table(capsys, find_scene("two-pauses"), "evaluate", "--long")
    assert max(map(len, text.splitlines())) <= 100
    sentence = QUANTITIES["pressure_angle_max_at_deg"].sentence
    assert all(word in text.split() for word in sentence.split())
    print_sections("word " * 60, "x" * 150)
    assert max(map(len, capsys.readouterr().out.splitlines()[:-1])) <= 100


def test_no_cell_of_a_table_is_cut_on_a_narrow_screen(capsys, monkeypatch):
    """A table of words too wide for the screen comes row by row."""
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "56")
    rows = [{"limit": "limits.pressure_angle", "price": "−0.8901 mm per deg", "next limit": "limits.hub_wall"}]
    print_sections(table_of("What each limit costs", rows, rows[0]))
    text = capsys.readouterr().out
    assert all(word in text for pair in rows[0].items() for word in pair)
    assert "…" not in text


def test_larger_cams_that_fail_are_told_in_a_sentence(capsys):
    scene = find_scene("oscillating-roller").replace(limits={"pressure_angle": 35, "pressure_angle_return": 40})
    best = optimise(scene).best
    text = " ".join(printed_table(capsys, scene, "optimise").split())
    assert not re.search(r"\bclear\b|∞", text)
    assert best["clear_above_mm"] > best["base_radius_mm"]
    assert "larger cams may break a limit again" in text


def test_limited_quantities_stand_beside_their_limits(capsys):
    bounds = {
        "velocity_max_m_s": "≤ 2",
        "face_reach_max_mm": "± 30",
        "face_reach_min_mm": "± 30",
        "profile_radius_min_mm": "> 0",
        "jump_speed_rpm": "≥ 400",
        "contact_stress_max_MPa": "≤ 150",
    }
    assert limit_texts_by_quantity(resolve(flat())) == bounds
    for command in ("optimise", "sweep"):
        text = printed_table(capsys, flat(), command)
        assert all(bound in text for bound in bounds.values())
        assert "pressure" not in text
        assert "offset" not in text


@pytest.mark.parametrize("name", ["knife-300rpm-offset", "flat-reciprocating"])
def test_no_column_is_zero_whatever_the_design(name):
    scene = find_scene(name).replace(**{"limits.pressure_angle": 40})
    row = evaluate(scene)
    zero = {"roller_radius_mm"} if name.startswith("knife") else {n for n in row if n.startswith("pressure_angle")}
    assert {n for n in row if n != "offset_mm" and n in row and not isinstance(row[n], (str, bool))
            and is_unsearched_zero_column(scene.search.sizes, n, [row])} == zero  # fmt: skip
    assert zero
    assert not zero & set(design_table_columns(resolve(scene), [row]))


def test_a_pressure_angle_is_no_objective_of_a_flat_face():
    assert sweep(flat()).scene.search.minimise == ("base_radius_mm", "acceleration_max_m_s2")
    roller = find_scene("roller-1000rpm").replace(search={"base_radius": [90, 100]})
    assert sweep(roller).scene.search.minimise[2:] == ("pressure_angle_max_deg",)


def test_an_angle_over_the_turn_is_one_column():
    scene = find_scene("roller-1000rpm").replace(limits={"pressure_angle": 40}, search={})
    problem, rows = resolve(scene), with_rise_law_as_law_column([evaluate(scene)])
    parts = ["pressure_angle_max_rise_deg", "pressure_angle_max_return_deg"]
    assert [n for n in design_table_columns(problem, rows) if "pressure" in n] == parts
    whole = "pressure_angle_max_deg"
    assert [n for n in design_table_columns(problem, rows, [whole]) if "pressure" in n] == [whole]
    other = resolve(scene.replace(**{"limits.pressure_angle_return": 50}))
    assert {n for n in design_table_columns(other, rows, [whole]) if "pressure" in n} == {whole, *parts}


def test_outputs_have_columns(capsys):
    scene = flat().replace(outputs=["force"])
    rows = [*optimise(scene).by_law.values(), *sweep(scene).best.values()]
    assert all({"contact_force_max_N", "preload_required_N"} <= row.keys() for row in rows)
    for command in ("optimise", "sweep"):
        text = printed_table(capsys, scene, command)
        assert "preload" in text


def test_a_miss_shows_each_value_beside_its_limit(capsys):
    text = printed_table(capsys, flat().replace(**{"limits.contact_stress": 10}), "sweep")
    line = next(line for line in text.splitlines() if line.startswith("contact_stress_max_MPa"))
    assert line.split()[2:] == ["MPa", "≤", "10", "broken"]
    held = next(line for line in text.splitlines() if line.startswith("jump_speed_rpm"))
    assert held.split()[2:] == ["rev/min", "≥", "400"]
    assert "The design breaks contact_stress." in text


@pytest.mark.parametrize("width", [40, 80, 130])
def test_nothing_is_cut_off_at_any_width(capsys, monkeypatch, width):
    monkeypatch.setattr("camopt.cli.terminal.table_width_limit", lambda: width)
    laws = ["modified-trapezoid", "cycloidal"]
    rows = [
        {"law": law, "base_radius_mm": 43.75, "binding": "pressure_angle, pressure_angle_return"} for law in laws
    ]
    title = "A title that is longer than its table, and than a narrow screen"
    print_sections(table_of(title, rows, ["law", "base_radius_mm", "binding"], {"base_radius_mm": "≥ 20"}))
    text = capsys.readouterr().out
    assert title in text
    for word in (*laws, "43.75", "≥ 20", "pressure_angle,", "pressure_angle_return"):
        assert word in text


@pytest.mark.parametrize("width", [60, 80])
def test_no_word_is_cut_off_where_several_columns_wrap(capsys, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    words = "sinusoidal [given] trapezoidal, cycloidal, :star: polynomials of harmonics"
    heads = [
        Cell(text, kind)
        for text, kind in zip(("key", "lift", "value", "about"), ("", NUMERIC, VALUE, ABOUT), strict=True)
    ]
    print_sections(Table.from_texts("title", heads, [["motion.1.law", "12.5", words, words]]))
    text = capsys.readouterr().out
    assert all(text.count(word) == 2 for word in words.split())
