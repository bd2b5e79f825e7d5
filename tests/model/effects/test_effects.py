"""The plan of effects: which effects run, which quantity needs them, and that no others run."""

import json
import re
from dataclasses import replace

import pandas as pd
import pytest
from support.pages import ALL

from camopt import BadInput, find_scene, optimise
from camopt.cli.main import main
from camopt.core.quantities import DISCIPLINES, GEOMETRY, QUANTITIES
from camopt.core.quantities.limit_keys import LIMIT_KEYS
from camopt.model.effects import EFFECTS, EvaluationBlock, quantities_to_compute_by_effect
from camopt.model.effects.effect import EnclosedValue, no_columns
from camopt.scene.problem.problem import resolve
from camopt.scene.tables import Dynamics, Materials
from camopt.show.studies.cost_report import cost_report
from camopt.solve.smallest.optimise import with_all_sizes
from camopt.solve.verdicts.effect_runs import run_effects

TRAIN = {
    "cam.rpm": 300,
    "follower.dynamics": {
        "mass": 1.5, "spring_rate": 15, "preload": 250, "guide_length": 90, "overhang": 80, "friction": 0.1,
        "stem_diameter": 16, "natural_frequency": 120, "damping_ratio": 0.05, "fluctuation": 0.02,
    },
    "materials": {"cam": "steel", "follower": "steel", "face_width": 10},
}  # fmt: skip
VALVE = find_scene("exhaust-valve").replace(**TRAIN)
OPEN = find_scene("roller-1000rpm").replace(**{"cam.base_radius": None, "search": {"law": ["cycloidal"]}})
"""A scene that leaves its base radius to be found."""


@pytest.fixture(autouse=True)
def _few_designs(monkeypatch):
    monkeypatch.setattr("camopt.show.studies.accuracy.subjects.DESIGN_COUNT", 16)


def test_every_discipline_is_an_effect():
    assert set(DISCIPLINES) == set(EFFECTS)
    assert {q.effect for q in QUANTITIES.values()} - set(EFFECTS) == {"limits", "proof"}


def test_no_effect_has_the_name_of_a_quantity():
    """A name among the outputs of a scene would mean both."""
    assert not EFFECTS.keys() & QUANTITIES.keys()


def test_without_outputs_motion_and_geometry_run_and_nothing_else():
    found, of_others = cost_report(VALVE), ("reach", "frame", "pair", "rib")
    assert [entry.effect for entry in found.entries] == [n for n in GEOMETRY if n not in of_others]
    assert {"force", "thrust", "hertz", "torque", "vibration"} <= found.idle.keys()
    assert found.idle["force"] == ()
    assert cost_report(find_scene("exhaust-valve")).idle["force"] == ("follower.dynamics.mass",)


def test_what_is_exact_has_no_enclosure():
    problem = resolve(VALVE)
    case = EvaluationBlock(problem.setup, problem.programme, problem.design)
    for effect in (each for each in EFFECTS.values() if each.exact):
        found = run_effects(case, effect.input_quantities(case.setup)).columns
        columns = effect.evaluate_columns(
            replace(case, columns=found), frozenset(effect.applicable_quantities(case.setup))
        )
        assert columns
        assert effect.evaluate_pitch_curve_columns is no_columns
        assert not any(isinstance(column, EnclosedValue) for column in columns.values())


@pytest.mark.slow
def test_all_calls_for_all_and_shares_add_up():
    found = cost_report(VALVE.replace(outputs=["all"]))
    of_others = {"reach", "face", "transmission", "joints", "frame", "pair", "rib", "preload", "clearance"}
    assert {entry.effect for entry in found.entries} == set(EFFECTS) - of_others - found.idle.keys()
    assert sum(entry.share for entry in found.entries) == pytest.approx(1.0)
    assert all(entry.called_by == ("outputs all",) or "outputs all" in entry.called_by for entry in found.entries)
    written = {name for entry in found.entries for name in entry.writes}
    assert written == set(resolve(VALVE.replace(outputs=["all"])).evaluated_quantities)


def test_a_limit_calls_for_what_it_needs_and_what_that_reads():
    scene = VALVE.replace(**{"limits.contact_stress": 900, "outputs": ["sizes"]})
    entries = {entry.effect: entry for entry in cost_report(scene).entries}
    assert "limits.contact_stress" in entries["hertz"].called_by
    assert "effect hertz" in entries["curvature"].called_by
    assert "undercut" in entries["hertz"].reads
    assert not {"force", "torque", "vibration"} & entries.keys()
    assert entries["crossing"].called_by == ("limits.self_crossing",)  # asked of every cam
    assert entries["pressure"].called_by == ("effect crossing",)
    problem = resolve(scene)
    assert list(quantities_to_compute_by_effect(problem.evaluated_quantities, problem.setup)) == list(entries)


def test_the_command_shows_the_tree_and_its_json(tmp_path, capsys):
    scene = tmp_path / "valve.toml"
    scene.write_text(VALVE.replace(**{"limits.jump_speed": 400}).to_toml(), encoding="utf-8")
    assert main(["effects", str(scene), "--quiet"]) == 0
    shown = capsys.readouterr().out
    assert "needed by limits.jump_speed" in shown
    assert "hertz  not run\n" in shown
    assert main(["effects", str(scene), "--json", "--quiet"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [entry["effect"] for entry in found["effects"]][:3] == ["sizes", "motion", "force"]
    assert found["not_called_for"]["hertz"] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"search.base_radius": {"start": 20.0, "stop": 90.0}},
        {"search.angle_dwell": {"start": 50.0, "stop": 100.0}},
    ],
    ids=["nothing", "a range without a step", "angles"],
)
def test_effects_take_a_scene_whose_size_is_to_be_found(changes):
    """What ``optimise`` takes has the same effects as the smallest cam for it."""
    scene = OPEN.replace(**changes)
    assert [each.effect for each in cost_report(scene).entries] == [
        each.effect for each in cost_report(with_all_sizes(OPEN)).entries
    ]


def test_a_scene_with_its_sizes_stays_as_it_is_and_another_gets_those_of_its_smallest_cam():
    assert with_all_sizes(VALVE) is VALVE
    assert with_all_sizes(OPEN).cam.base_radius == optimise(OPEN).best["base_radius_mm"]
    assert (
        with_all_sizes(OPEN.replace(**{"limits.outer_radius": 30})).cam.base_radius is not None
    )  # the nearest miss
    endless = find_scene("knife-300rpm-radial").replace(limits=None, search=None, **{"cam.base_radius": None})
    with pytest.raises(BadInput, match="nothing limits"):
        cost_report(endless)


@pytest.mark.slow
def test_the_command_writes_spectra(tmp_path, capsys):
    assert main(["effects", "--spectrum", "--out", str(tmp_path), "--quiet"]) == 0
    assert "cycloidal" in capsys.readouterr().out
    table = pd.read_parquet(tmp_path / "spectrum.parquet")
    quiet = table[(table.law == "cycloidal") & (table.period_ratio.round(6).isin([2.0, 3.0, 4.0]))]
    assert len(quiet) == 3
    assert quiet.residual.max() < 1e-15
    assert "<svg" in (tmp_path / "spectrum.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "names", [LIMIT_KEYS, Dynamics.model_fields, Materials.model_fields], ids=["limits", "dynamics", "materials"]
)
def test_the_pages_name_every_key(names):
    unnamed = [key for key in names if not re.search(rf"\b{key}\b", ALL)]
    assert unnamed == [], "a page of docs/how-to tells what each key is for"
