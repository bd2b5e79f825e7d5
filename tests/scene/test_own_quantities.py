"""Quantities that a scene defines by expressions: what is read, what is refused, and what they are."""

import json
import math
import random
import re
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.depth import times
from support.expressions import random_expression

from camopt import BadInput, Scene, certify, evaluate, find_scene
from camopt.cli.main import main
from camopt.core.numerics.interval import Interval
from camopt.core.quantities.expression import FUNCTIONS, MOST_NODES, parse_expression
from camopt.model.effects.quantity_expression import RANGE_RULES
from camopt.scene.keys import find_keys
from camopt.scene.problem.problem import resolve
from camopt.show.reporting.sections import limits_table
from camopt.show.studies.cost_report import needed_effect_runs

BASE = find_scene("roller-1000rpm")
READ = "outer_radius_mm * pressure_angle_max_deg"
NAMES = ("a", "b", "c")
HOSTILE = {
    "__import__('os').system('true')": "is not allowed",
    "().__class__.__bases__": "is not allowed",
    "outer_radius_mm.real": "is not allowed",
    "[x for x in ()]": "is not allowed",
    "lambda: 1": "is not allowed",
    "outer_radius_mm if 1 else 2": "is not allowed",
    "'text'": "is not allowed",
    "True": "is not allowed",
    "1j": "is not allowed",
    "1 // 2": "is not allowed",
    "max(*outer_radius_mm)": "is not allowed",
    "sin(x=1)": "is not allowed",
    "eval(outer_radius_mm)": "eval is not a known function",
    "x" * 10**6: "has 1,000,000 characters; at most 4,000 are allowed",
    "(" * 1000 + "1" + ")" * 1000: "at most 200 nodes are allowed",
    "-" * 999 + "1": "has 1,000 nodes; at most 200 are allowed",
    "2 ** " * 400 + "2": "has 801 nodes; at most 200 are allowed",
    " + ".join(["1"] * 101): "has 201 nodes; at most 200 are allowed",
    "1 / 0": "divides by zero",
    "outer_radius_mm / (2 - 2)": "divides by zero",
    "9 ** 9 ** 9 ** 9": "has no finite value",
    "sqrt(-1)": "has no finite value",
    "1e999": "has a number beyond 1.8e308",
    "9" * 3999: "has a number beyond 1.8e308",
    "outer_radius": "outer_radius is not a quantity; did you mean outer_radius_mm?",
    "undercut + 1": "undercut cannot be used",
    "feasible": "feasible cannot be used",
    "relative_half_width": "relative_half_width cannot be used",
    "mine + 1": "mine must be defined above it in [quantities]",
    "sin": "sin is a function: give it arguments",
    "sin(1, 2)": "sin takes 1 argument, not 2",
    "max(1)": "max takes 2 or more arguments, not 1",
    "": "is not an expression, such as",
    "1 +": "is not an expression, such as",
    "a\0b": "is not an expression, such as",
    "import os": "is not an expression, such as",
}
CLASHES = {
    "torque_rms_N_m": "is a built-in quantity",
    "train_1_coupler_mm": "is a built-in quantity",
    "torque": "is the limit limits.torque",
    "force": "has another meaning already",
    "sin": "has another meaning already",
    "pi": "has another meaning already",
    "all": "has another meaning already",
    "binding": "has another meaning already",
    "lambda": "the name of a quantity must be",
    "a b": "the name of a quantity must be",
    "größe": "the name of a quantity must be",
    "x" * 61: "the name of a quantity must be",
    "2x": "the name of a quantity must be",
}


def mistakes(**changes):
    with pytest.raises(BadInput) as bad:
        evaluate(BASE.replace(**changes))
    return bad.value.mistakes


@pytest.mark.parametrize("text", HOSTILE, ids=lambda text: text[:30])
def test_a_hostile_expression_is_one_sentence(text):
    (mistake,) = mistakes(quantities={"mine": text})
    assert (mistake.key, mistake.value) == ("quantities.mine", text)
    assert HOSTILE[text] in str(mistake)
    assert len(str(mistake)) <= 1000


@pytest.mark.parametrize("name", CLASHES)
def test_a_name_that_has_another_meaning_is_one_sentence(name):
    (mistake,) = mistakes(quantities={name: "outer_radius_mm"})
    assert (mistake.key, mistake.value) == ("quantities", name)
    assert CLASHES[name] in str(mistake)


@pytest.mark.parametrize(
    ("changes", "key", "what"),
    [
        ({"quantities": {"x": 3}}, "quantities.x", "must be a table"),
        ({"quantities": {"x": {"unit": "mm"}}}, "quantities.x", "needs either a value or a function"),
        ({"quantities": {"x": {"value": "1", "unit": "a\nb"}}}, "quantities.x.unit", "a text of one line"),
        ({"quantities": {"x": {"value": "1", "units": "mm"}}}, "quantities.x.units", "not a known key"),
        ({"quantities": {f"x{k}": "1" for k in range(101)}}, "quantities", "at most 100 are allowed"),
        ({"quantities": {"x": {"function": [1], "columns": ["offset_mm"]}}}, "quantities.x.function", "a text"),
        ({"quantities": {"x": {"function": "f", "columns": [3]}}}, "quantities.x.columns.1", "must be a text"),
        ({"quantities": [3]}, "quantities", "must be a table"),
        ({"limits.mine": 3}, "limits.mine", "not a known key"),
        ({"limits.mine": "x"}, "limits.mine", "not a known key"),
        ({"quantities": {"mine": READ}, "limits.mine": "x"}, "limits.mine", "must be a number"),
        ({"quantities": {"mine": READ}, "search.minimise": ["mind"]}, "search.minimise.1", "did you mean mine?"),
        ({"quantities": {"mine": "torque_rms_N_m"}}, "quantities.mine", "torque_rms_N_m needs follower.dynamics"),
        ({"quantities": {"mine": "face_reach_max_mm"}}, "quantities.mine", "is not a quantity of this mechanism"),
    ],
)
def test_a_mistake_names_its_key(changes, key, what):
    (mistake,) = mistakes(**changes)
    assert mistake.key == key
    assert what in str(mistake)


def test_a_mistake_ends_a_command_with_exit_code_2_and_writes_nothing(tmp_path, capsys):
    (tmp_path / "mine.toml").write_text(BASE.to_toml() + '\n[quantities]\nmine = "__import__(1)"\n')
    assert main(["sweep", str(tmp_path / "mine.toml"), "--out", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert re.search(r"mine.toml: quantities.mine = '__import__\(1\)': __import__ is not a known function", line)
    assert not (tmp_path / "out").exists()


@given(st.text(max_size=60) | st.text(alphabet="()+-*/.,_ ab1e9sinmx", max_size=40))
def test_any_text_is_an_expression_or_a_sentence(text):
    def check_name(name):
        if name not in NAMES:
            raise ValueError("no name")

    with suppress(ValueError):
        assert set(parse_expression(text, check_name).names) <= set(NAMES)


def by_python(text, values):
    """The value by Python's own arithmetic; None where that has none."""
    functions = {name: getattr(math, name) for name in FUNCTIONS if hasattr(math, name)}
    try:
        found = eval(
            text, {"__builtins__": {}, "abs": abs, "min": min, "max": max, "pi": math.pi, **functions}, values
        )
    except (ValueError, ZeroDivisionError, OverflowError, TypeError):
        return None
    return found if isinstance(found, (int, float)) and math.isfinite(found) else None


@pytest.mark.one_in(6)
@pytest.mark.parametrize("seed", range(times(150, 3000)))
def test_an_expression_is_what_python_makes_of_it_and_ranges_hold_it(seed):
    chance = random.Random(seed)
    text = random_expression(chance, NAMES, 4)
    values = {name: chance.choice([-1.0, 1.0]) * 10.0 ** chance.uniform(-2.0, 2.0) for name in NAMES}
    expected = by_python(text, values)
    try:
        tree = parse_expression(text, lambda name: None)
    except ValueError:
        assert expected is None
        return
    arrays = {name: np.full(2, value) for name, value in values.items()}
    with np.errstate(all="ignore"):
        found = tree.evaluate(arrays) + np.zeros(2)
        if expected is None:
            return
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-12)
        width = 10.0 ** chance.uniform(-14.0, -1.0)
        ranges = {n: Interval(v - width * abs(v), v + width * abs(v)) for n, v in arrays.items()}
        made = tree.evaluate(ranges, RANGE_RULES)
        low, high = (made.low, made.high) if isinstance(made, Interval) else (made, made)
        for _ in range(20):
            near = {name: value * (1.0 + width * chance.uniform(-1.0, 1.0)) for name, value in values.items()}
            beside = by_python(text, near)
            assert beside is None or np.all((low <= beside) & (beside <= high)), (text, near)


def test_an_own_quantity_is_evaluated_and_calls_for_its_effects_alone():
    scene = find_scene("roller-1000rpm").replace(quantities={"mine": "cam_mass_kg"}, **{"part.thickness": 20})
    scene = scene.replace(**{"materials.cam": "steel", "cam.base_radius": 60, "outputs": ["sizes"]})
    assert [
        each.effect for each in needed_effect_runs(resolve(scene)) if "cam_mass_kg" in each.writes + each.reads
    ] == [
        "solid",
        "quantities.mine",
    ]
    without = scene.replace(quantities={"mine": "base_radius_mm / 2"})
    assert "solid" not in [each.effect for each in needed_effect_runs(resolve(without))]
    assert evaluate(without)["mine"] == 30.0


def test_own_quantities_read_those_above_them():
    scene = BASE.replace(
        quantities={"one": READ, "two": {"value": "sqrt(one) + one", "unit": "mm", "sentence": "Two."}}
    )
    found = evaluate(scene.replace(outputs=["all"]))
    one = found["outer_radius_mm"] * found["pressure_angle_max_deg"]
    assert (found["one"], found["two"]) == (one, np.sqrt(one) + one)
    (row,) = [row for row in found.table().rows if row[0].text == "two"]
    assert [cell.text for cell in row[2:]] == ["mm", "", "Two."]
    assert [*found].index("two") < [*found].index("feasible")


def test_a_scene_with_own_quantities_is_the_same_from_its_text():
    scene = BASE.replace(quantities={"mine": READ}, **{"limits.mine": 4000, "search.minimise": ["mine"]})
    again = Scene.embedded(scene.to_toml(), "again")
    assert (again, hash(again), again.limits.mine) == (scene, hash(scene), 4000.0)
    assert scene.with_values({"limits.mine": None}).limits.bounds_by_key == BASE.limits.bounds_by_key


@pytest.mark.parametrize(
    "text", ["0 / (offset_mm - 20)", "1 / (offset_mm - 20)", "-1 / (offset_mm - 20)", "sqrt(-offset_mm)"]
)
@pytest.mark.parametrize(
    "named", [{"search.minimise": ["mine"]}, {"search.maximise": ["mine"]}, {"limits.mine": 1e9}]
)
def test_a_value_that_is_no_finite_number_is_infinite_and_infeasible(text, named):
    assert BASE.follower.offset == 20
    scene = BASE.replace(quantities={"mine": text}, **named)
    found = evaluate(scene)
    assert (found["mine"], found["feasible"], found["violated"]) == (np.inf, False, "pressure_angle,mine")
    assert found.unbounded["mine"] == "its expression has no finite value here"
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["mine"] is None
    assert certify(scene)["mine"] == "broken"


def test_a_value_that_is_only_reported_decides_nothing():
    found = evaluate(BASE.replace(quantities={"mine": "1 / (offset_mm - 20)"}))
    assert (found["mine"], found["violated"]) == (np.inf, "pressure_angle")


@pytest.mark.parametrize("text", [READ, "-(outer_radius_mm ** 2)", "base_radius_mm + roller_radius_mm"])
def test_a_limit_is_decided_on_either_side_of_the_value(text):
    scene = BASE.replace(quantities={"mine": text})
    value = evaluate(scene)["mine"]
    for share in (1e-11, 1e-6, 0.3):
        for side, verdict in ((1.0, "held"), (-1.0, "broken")):
            limited = scene.replace(**{"limits.mine": value + side * share * abs(value)})
            assert certify(limited)["mine"] == verdict
            assert ("mine" in evaluate(limited)["violated"]) == (verdict == "broken")


@pytest.mark.parametrize("name", ["pressure_angle_max_at_deg", "pitch_circle_radius_mm"])
def test_an_expression_of_where_something_is_proves_nothing(name):
    scene = BASE.replace(
        quantities={"inner": name, "mine": "inner * 2"}, **{"limits.mine": 1e6, "limits.pressure_angle": 60}
    )
    found = evaluate(scene)
    assert (found["mine"], found["status"], certify(scene)["mine"]) == (2 * found["inner"], "sampled", "undecided")


def test_a_sum_of_sizes_may_be_at_its_limit():
    scene = BASE.replace(quantities={"mine": "base_radius_mm + roller_radius_mm"})
    assert certify(scene.replace(**{"limits.mine": evaluate(scene)["mine"]}))["mine"] == "held"


def test_keys_say_what_an_own_quantity_has():
    assert [key.key for key in find_keys("quantities")] == [
        f"quantities.NAME.{name}" for name in ("value", "function", "columns", "unit", "sentence")
    ]
    assert str(MOST_NODES) in (Scene.model_fields["quantities"].annotation.__args__[1].__args__[0].__doc__ or "")


@pytest.mark.parametrize("command", [["evaluate"], ["certify"], ["keys", "quantities"], ["compare"]])
def test_commands_take_a_scene_with_own_quantities(command, tmp_path, capsys):
    scene = BASE.replace(quantities={"mine": {"value": READ, "unit": "mm·deg"}}, **{"limits.mine": 9999.5})
    (tmp_path / "mine.toml").write_text(scene.to_toml())
    given = {"keys": [], "compare": [str(tmp_path / "mine.toml"), "roller-1000rpm"]}
    files = given.get(command[0], [str(tmp_path / "mine.toml")])
    main([*command, *files])
    out = capsys.readouterr()
    assert "Traceback" not in out.err
    assert "mine" in out.out or command[0] == "keys"


def test_a_report_says_how_own_limits_are_decided():
    scene = BASE.replace(
        quantities={"mine": READ, "other": "mine / 2"}, **{"limits.mine": 9999, "search.minimise": ["other"]}
    )
    rows = {
        row[0].text: [cell.text for cell in row[1:]] for row in limits_table(evaluate(scene), resolve(scene)).rows
    }
    assert rows["mine"][:2] == ["held", "≤ 9999"]
    assert rows["other"][:2] == ["held", "finite"]
    assert {rows[name][-1] for name in ("mine", "other")} == {"double precision"}
