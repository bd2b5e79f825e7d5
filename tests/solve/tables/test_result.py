"""Results: one object a command, which terminal, notebook and JSON print alike."""

import json
from dataclasses import dataclass, replace
from html import unescape
from inspect import isclass
from math import inf

import numpy as np
import pandas as pd
import pytest
from support.plain import places_of_objects

import camopt
from camopt import Design, find_scene
from camopt.cli.main import main
from camopt.cli.terminal import print_result, print_sections
from camopt.show.comparing.compare import Comparison
from camopt.show.reporting.listings import list_keys, list_laws, list_scenes
from camopt.show.studies.accuracy import AccuracyCosts
from camopt.show.studies.cost_report import cost_report
from camopt.show.studies.spectrum import spectra_of
from camopt.solve.front.table_certificate import TableCertificate
from camopt.solve.tables.result import NUMERIC, Branch, Cell, Listing, Result, Table, to_json_values

SCENE = find_scene("two-pauses").replace(
    search={"base_radius": [60, 70], "law": ["cycloidal", "poly345"], "minimise": ["base_radius_mm"]},
    limits={"pressure_angle": 30},
    tolerances={"profile": 0.01, "follower": {"offset": 0.02}},
)


PUBLIC = {name for name in camopt.__all__ if isclass(kind := getattr(camopt, name)) and issubclass(kind, Result)}
INNER = {"CostReport", "AccuracyCosts", "Listing", "Spectra", "TableCertificate"}
ELSEWHERE = {"PairInspection", "Result"}  # two measured discs have a test of their own
SHOWN = sorted((PUBLIC | INNER) - ELSEWHERE)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    best = camopt.optimise(SCENE)
    swept = camopt.sweep(SCENE, folder / "sweep")
    points = camopt.cam_points(SCENE, range(0, 360, 2))
    profile = camopt.MeasuredProfile(np.column_stack([points["profile_x_mm"], points["profile_y_mm"]]), "xy")
    angles = np.arange(0.0, 360.0, 10.0)
    lifts = np.column_stack([angles, 5 * (1 - np.cos(np.radians(angles)))])
    flat = {"motion": "translating", "contact": "flat"}
    allocation = camopt.allocate(SCENE.replace(tolerances={"follower": {"offset": "js7"}}), 0.05)
    batch = camopt.sample_cams(SCENE, cams=256)
    trade = {"size": 60.0, "acceleration": 3.0, "bound": None, "within": True}
    rows = [Design({**best.best, **trade, "base_radius_mm": 60.0 + k}, SCENE) for k in range(3)]
    found = [
        camopt.evaluate(SCENE),
        replace(best, prices=camopt.prices(best)),
        best.best,
        swept,
        camopt.sweep_part(SCENE, (1, 2), out=folder / "parts"),
        camopt.Synthesis(SCENE, best.best.scene, best.best, 60.0, 59.0),
        camopt.Frontier(SCENE, ("size", "acceleration"), rows, rows[:1], {"size": (60.0, 59.0)}),
        camopt.fit(lifts, {"name": "lifts", "cam": {"form": "disc", "base_radius": 30.0}, "follower": flat}),
        replace(camopt.tolerance(SCENE), batch=batch, allocation=allocation),
        allocation,
        batch,
        camopt.inspect(profile, SCENE),
        camopt.timing(SCENE),
        camopt.harmonics(SCENE, 3),
        camopt.certify(SCENE),
        camopt.check(folder / "sweep"),
        camopt.export(SCENE, folder / "cam.svg"),
        camopt.compare(SCENE, SCENE.replace(**{"cam.base_radius": 61})),
        camopt.construct(SCENE, 4),
        cost_report(SCENE),
        spectra_of(SCENE),
        AccuracyCosts(
            SCENE, [{"quantity": "q", "method": "m", "setting": 1.0, "ns_per_design": 3.0, "error_max": 4.0}]
        ),
        TableCertificate(["held", "broken"]),
        list_keys("cam"),
        camopt.sensitivities(SCENE),
        camopt.cam_points(SCENE, [0, 90, 180]),
        camopt.response_spectrum("cycloidal", [1.0, 2.0]),
        camopt.fastest("valve-with-rocker"),
        camopt.evaluate_machine("pick-and-place"),
        camopt.fastest_machine("camshaft"),
        camopt.machine_timing("camshaft", 1.0),
        camopt.optimise_phases("pick-and-place"),
    ]
    return {type(each).__name__: each for each in found}


@pytest.mark.slow
def test_every_kind_of_result_is_tried(results):
    assert {*results} == {*SHOWN}


@pytest.mark.parametrize("kind", SHOWN)
def test_a_result_prints_the_same_in_a_terminal_in_a_notebook_and_for_programs(results, kind, capsys):
    result = results[kind]
    parts = [*result.sections()]
    assert parts
    assert result.tables() == tuple(each for each in parts if isinstance(each, Table))
    assert result.table() is None or result.table() in result.tables()
    code = print_result(result, as_json=False, quiet=True)
    assert code == result.exit_code
    printed = {*capsys.readouterr().out.split()}
    page = unescape(result._repr_html_())
    assert "scene=" not in page  # a heading, not the fields of an object
    for text in (text for part in parts for text in texts_of(part)):
        assert {*text.split()} <= printed
        assert text in page
    print_result(result, as_json=True, quiet=True)
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert not places_of_objects(result.to_dict())


def texts_of(part):
    """The texts of a table's cells, of a tree's lines, or of a sentence."""
    if isinstance(part, Branch):
        return [part.text, *(text for each in part.branches for text in texts_of(each))]
    return [cell.text for row in part.rows[:40] for cell in row] if isinstance(part, Table) else [str(part)]


@pytest.mark.parametrize("kind", SHOWN)
def test_a_result_has_rows_for_pandas(results, kind):
    result = results[kind]
    frame = result.to_pandas()
    assert isinstance(frame, pd.DataFrame)
    assert len(frame) > 0
    units = frame.attrs["units"]
    assert all(camopt.QUANTITIES[n].unit == unit for n, unit in units.items() if n in camopt.QUANTITIES)
    document = result.values_for_json()
    if isinstance(document, dict):
        with pytest.raises(camopt.UnknownName, match="has no rows named"):
            result.to_pandas("no such rows")


def test_rows_have_names_of_their_own(results):
    errors = results["MotionErrors"]
    assert errors.to_pandas()["worst"].tolist() == [each.worst for each in errors.errors]
    assert errors.to_pandas("margins")["limit"].tolist() == [each.limit for each in errors.margins]
    laws = results["Optimum"].to_pandas()
    assert laws.index.tolist() == [*results["Optimum"].by_law]
    assert laws["base_radius_mm"].tolist() == [row["base_radius_mm"] for row in results["Optimum"].by_law.values()]
    assert laws.attrs["units"]["base_radius_mm"] == "mm"
    assert results["Listing"].to_pandas()["key"].tolist() == [key.key for key in list_keys("cam").records]


@dataclass(frozen=True)
class Loose(Result):
    """A result whose numbers are less exact than its scene asks."""

    scene: camopt.Scene
    relative_half_width: float = 0.0

    def sections(self):
        return ("loose",)

    def values_for_json(self):
        return {"value": inf, "inner": [{"value": -inf, "name": "a", "array": np.array([1.0, inf])}]}


def test_infinite_numbers_are_none_and_named():
    document = Loose(SCENE).to_dict()
    assert document["value"] is None
    assert document["unbounded"] == ["value"]
    assert document["inner"] == [{"value": None, "name": "a", "array": [1.0, None], "unbounded": ["value"]}]
    assert to_json_values({"value": inf, "unbounded": {"value": "why"}}) == {
        "value": None,
        "unbounded": {"value": "why"},
    }


def test_former_names_are_read_with_a_warning():
    loose = Loose(SCENE, 0.25)
    with pytest.warns(DeprecationWarning, match="document is now values_for_json"):
        assert loose.document()["value"] == inf
    with pytest.warns(DeprecationWarning, match="half_width is now relative_half_width"):
        assert loose.half_width == 0.25


def test_a_result_that_is_less_exact_than_asked_ends_with_4(capsys):
    asked = SCENE.accuracy.relative_error
    assert print_result(Loose(SCENE, asked), as_json=False, quiet=True) == 0
    assert capsys.readouterr().err == ""
    assert print_result(Loose(SCENE, 2.0 * asked), as_json=False, quiet=True) == 4
    assert "not reached" in capsys.readouterr().err


def test_old_names_are_read_for_a_version(results):
    for each in (results["Evaluation"], results["Optimum"].prices["cycloidal"][0]):
        with pytest.warns(DeprecationWarning, match="to_dict"):
            assert each.to_json() == each.to_dict()


@pytest.mark.parametrize("made", [list_laws, list_scenes])
def test_lists_are_results(made, capsys):
    found = made()
    assert isinstance(found, Listing)
    assert len(found.to_pandas()) == len(found.records)
    print_sections(*found.sections())
    assert found.records[0]["title"].split()[0] in capsys.readouterr().out


def test_a_comparison_is_a_result(tmp_path):
    camopt.sweep(SCENE, tmp_path / "a")
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "a"), "--quiet"]) == 0
    found = camopt.compare(tmp_path / "a", tmp_path / "a")
    assert isinstance(found, Comparison)
    assert {*found.by_table} == {"designs.parquet", "pareto.parquet"}


def test_results_of_many_numbers_show_a_line_of_them():
    points = camopt.cam_points(find_scene("roller-1000rpm"))
    names = "cam_angle_deg, displacement_mm, velocity_m_s, acceleration_m_s2"
    assert repr(points) == f"<Columns: 361 rows of {names} and {len(points) - 4} more columns>"
    spectrum = repr(camopt.response_spectrum("cycloidal", [1.25]))
    assert spectrum.startswith("<Spectrum: 1 row of law, period_ratio, damping_ratio, ")
    assert repr(camopt.harmonics(find_scene("two-pauses"), 7)).endswith(": 7 orders>")


def test_a_table_is_text():
    lines = str(
        Table.from_texts("Some", ["name", Cell("lift\nmm", NUMERIC)], [["a", "1.5"], ["longer", "12"]], "Told.")
    ).split("\n")
    assert lines == ["Some", "name    lift mm", "a           1.5", "longer       12", "Told."]
    assert str(Table.from_texts("Empty", ["", ""], [])) == "Empty"


def test_the_samples_of_a_batch_are_a_frame():
    batch = camopt.sample_cams(find_scene("bucket-valve").replace(**{"tolerances.profile": 0.01}), cams=1024)
    frame = batch.to_pandas("samples")
    assert all((frame[name] == each.values).all() for name, each in batch.samples.items())
    assert frame.attrs["units"]["position_error_max_mm"] == "mm"
    with pytest.raises(camopt.UnknownName, match="did you mean samples"):
        batch.to_pandas("sample")


def test_notes_are_the_same_whenever_they_are_read():
    optimum = camopt.optimise(find_scene("belt-matching"))
    for result in (optimum, camopt.evaluate(optimum.best.scene)):
        assert isinstance(result.notes, tuple)
