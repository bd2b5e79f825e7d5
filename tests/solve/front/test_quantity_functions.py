"""Python functions as quantities: beside the same expression, in threads and processes, and what is refused."""

import sys
from textwrap import dedent

import numpy as np
import pytest
from support.quantity_functions import COLUMNS, TEXT, compactness

from camopt import BadInput, Scene, certify, evaluate, find_scene, frontier, load, quantity, sweep
from camopt.cli.main import main
from camopt.core.engines.processes import processes
from camopt.core.quantities.function import installed_quantities, load_installed_quantity
from camopt.solve.front.plan import sweep_plan

BASE = find_scene("roller-1000rpm").replace(
    search={
        "base_radius": {"start": 41, "stop": 78, "step": 3.7},
        "offset": {"start": -7, "stop": 21, "step": 4},
        "law": ["cycloidal", "harmonic"],
        "minimise": ["mine", "pressure_angle_max_deg"],
    },
    limits={"curvature_radius": 1, "mine": 1700},
    quantities={"mine": {"value": TEXT, "unit": "mm"}},
)
MINE = {"name": "mine", "unit": "mm"}


def with_function(function, columns=COLUMNS, **about):
    return BASE.replace(quantities=[quantity(function, columns, **{**MINE, **about})])


def mistake_text(scene):
    with pytest.raises(BadInput) as bad:
        evaluate(scene)
    (mistake,) = bad.value.mistakes
    return str(mistake)


@pytest.fixture(scope="module")
def expected_tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("expression")
    sweep(BASE, out=folder)
    return load(folder / "designs.parquet"), load(folder / "pareto.parquet")


@pytest.mark.parametrize("function", [compactness, lambda radius, angle: compactness(radius, angle)])
def test_a_function_is_what_the_same_expression_is(function, expected_tables, tmp_path):
    scene = with_function(function)
    sweep(scene, out=tmp_path)
    for name, rows in zip(("designs", "pareto"), expected_tables, strict=True):
        found = load(tmp_path / f"{name}.parquet")
        assert found["mine"].to_numpy() == pytest.approx(rows["mine"].to_numpy(), rel=1e-15)
        same = ["law_rise", "base_radius_mm", "offset_mm", "feasible"]
        assert found[same].equals(rows[same])
        assert found.attrs["units"]["mine"] == "mm"
        assert {*found["status"]} == {"sampled"}
    assert Scene.embedded(scene.to_toml(), "again") == scene


@pytest.mark.slow
def test_other_processes_import_a_function(expected_tables, tmp_path):
    with processes(2) as engine:
        sweep(with_function(compactness), out=tmp_path, engine=engine, block=64)
    found = load(tmp_path / "pareto.parquet")
    assert found["mine"].to_numpy() == pytest.approx(expected_tables[1]["mine"].to_numpy(), rel=1e-15)


def test_other_processes_take_no_function_that_they_cannot_import():
    with processes(2) as engine, pytest.raises(BadInput, match="is a function that other processes cannot import"):
        sweep(with_function(lambda *columns: columns[0]), engine=engine)


@pytest.mark.slow
def test_a_frontier_takes_a_function_along():
    coarse = BASE.replace(quantities={}, search={}, limits={}, **{"synthesis.pieces": 12})
    sizes = [row["size"] for row in frontier(coarse, points=2, workers=1).rows]
    scene = coarse.replace(quantities=[quantity(compactness, COLUMNS, **MINE)], outputs=["mine"])
    assert [row["size"] for row in frontier(scene, points=2, workers=2).rows] == sizes


def test_a_frontier_in_processes_takes_no_function_that_they_cannot_import():
    scene = BASE.replace(quantities=[quantity(lambda one: one, COLUMNS[:1], **MINE)], limits={}, outputs=["mine"])
    with pytest.raises(BadInput, match="is a function that other processes cannot import"):
        frontier(scene.replace(**{"synthesis.pieces": 12}), points=2, workers=2)


def fails(*columns):
    raise ZeroDivisionError("no\nsuch thing")


@pytest.mark.parametrize(
    ("function", "columns", "what"),
    [
        (fails, COLUMNS, "fails: ZeroDivisionError: no"),
        (lambda one: one, COLUMNS, "fails: TypeError"),
        (lambda one: "text", COLUMNS[:1], "fails: ValueError"),
        (lambda one: np.ones(3), COLUMNS[:1], "must return an array of 1 numbers, not one of shape (3,)"),
    ],
)
def test_what_a_function_does_wrong_is_one_sentence(function, columns, what):
    message = mistake_text(with_function(function, columns))
    assert "quantities.mine.function = " in message
    assert what in message


@pytest.mark.parametrize(
    ("function", "columns", "key"),
    [(3, COLUMNS, "function"), (compactness, [], "columns"), (compactness, [1], "columns")],
)
def test_what_is_no_function_of_columns_is_one_sentence(function, columns, key):
    with pytest.raises(BadInput) as bad:
        quantity(function, columns)
    assert [mistake.key for mistake in bad.value.mistakes] == [key]


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"quantities.mine.columns": ["outer_radius"]}, "quantities.mine.columns.1"),
        ({"quantities.mine.columns": ["mine"]}, "quantities.mine.columns.1"),
        ({"quantities.mine.columns": None}, "quantities.mine.columns"),
        ({"quantities.mine.value": "1"}, "quantities.mine"),
    ],
)
def test_a_mistake_about_columns_names_its_key(changes, key):
    with pytest.raises(BadInput) as bad:
        with_function(compactness).replace(**changes)
    assert key in [mistake.key for mistake in bad.value.mistakes]


def test_a_file_makes_nothing_import(tmp_path, capsys):
    text = BASE.to_toml().replace(
        f'value = "{TEXT}"', 'function = "antigravity:fly"\ncolumns = ["outer_radius_mm"]'
    )
    (tmp_path / "mine.toml").write_text(text)
    assert main(["evaluate", str(tmp_path / "mine.toml")]) == 2
    assert "'antigravity:fly': is not registered: give it to camopt.quantity" in capsys.readouterr().err
    assert "antigravity" not in sys.modules


def test_a_value_that_is_no_number_is_infeasible():
    found = evaluate(with_function(lambda radius, angle: np.where(angle > 0.0, np.nan, 1.0)))
    assert (found["mine"], found["violated"]) == (np.inf, "mine")


def test_a_number_of_a_function_proves_nothing():
    scene = with_function(compactness).replace(**{"limits.mine": 1e9})
    assert certify(scene)["mine"] == "undecided"
    assert evaluate(scene)["status"] == "sampled"


def test_a_changed_function_is_not_answered_by_what_is_in_the_folder(tmp_path):
    def shift_compactness(by):
        return lambda radius, angle: compactness(radius, angle) + by

    assert (
        len(
            {
                sweep_plan(with_function(shift_compactness(by)), "pareto").quantity_function_calls[0].digest
                for by in (1.0, 2.0, 1.0)
            }
        )
        == 2
    )
    found = [sweep(with_function(shift_compactness(by)), out=tmp_path) for by in (0.0, 1.0)]
    assert [each.already_done for each in found] == [False, False]
    importable = [sweep(with_function(compactness), out=tmp_path) for _ in range(2)]
    assert [each.already_done for each in importable] == [False, True]


@pytest.fixture
def installed_package(tmp_path, monkeypatch):
    """A package with entry points, as an installer leaves it."""
    (tmp_path / "shop-1.0.dist-info").mkdir()
    (tmp_path / "shop-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: shop\nVersion: 1.0\n")
    names = "mine = shop:mine\nbroken = shop:broken\nodd = shop:sum\n"
    (tmp_path / "shop-1.0.dist-info" / "entry_points.txt").write_text(f"[camopt.quantities]\n{names}")
    code = """
        import camopt
        from support.quantity_functions import COLUMNS, compactness

        mine = camopt.quantity(compactness, COLUMNS, name="mine", unit="mm", sentence="Of a shop.")
        sum = sum
    """
    (tmp_path / "shop.py").write_text(dedent(code))
    monkeypatch.syspath_prepend(tmp_path)
    for kept in (installed_quantities, load_installed_quantity):
        kept.cache_clear()
    yield
    for kept in (installed_quantities, load_installed_quantity):
        kept.cache_clear()
    sys.modules.pop("shop", None)


@pytest.mark.slow
def test_every_scene_knows_the_quantities_of_installed_packages(installed_package, expected_tables, tmp_path):
    scene = BASE.to_dict()
    del scene["quantities"]
    scene = Scene.from_dict(scene)
    assert scene.to_dict()["quantities"]["mine"]["sentence"] == "Of a shop."
    with processes(2) as engine:
        sweep(scene, out=tmp_path / "out", engine=engine, block=64)
    found = load(tmp_path / "out" / "pareto.parquet")
    assert found["mine"].to_numpy() == pytest.approx(expected_tables[1]["mine"].to_numpy(), rel=1e-15)
    assert evaluate(find_scene("roller-1000rpm").replace(quantities={"x": "2 * mine"}))["x"] > 0.0


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("broken", "the entry point of shop 1.0 fails: AttributeError"),
        ("odd", "must be a result of camopt.quantity, not builtin_function_or_method"),
        ("absent", "is not an entry point of the group camopt.quantities"),
    ],
)
def test_an_entry_point_that_is_no_quantity_is_one_sentence(installed_package, name, what):
    table = {"function": name, "columns": ["base_radius_mm"]}
    assert what in mistake_text(find_scene("roller-1000rpm").replace(quantities={"x": table}))
