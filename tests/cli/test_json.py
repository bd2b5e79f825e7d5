"""Every ``--json`` document is made of plain Python values alone: numpy's are no JSON, or only some of them are."""

import pytest
from support.plain import places_of_objects
from support.smallest_cams import FREE

from camopt import optimise
from camopt.cli.main import main

COMMANDS = {
    "sweep": ["sweep", "SCENE", "--base-radius", "60:120:20", "--offset", "0", "--roller-radius", "10"],
    "optimise": ["optimise", "SCENE"],
    "optimise over angles": ["optimise", "FREED"],
    "evaluate": ["evaluate", "SCENE"],
    "certify": ["certify", "two-pauses"],
    "synthesise": ["synthesise", "two-pauses"],
    "effects": ["effects", "two-pauses"],
    "spectrum": ["effects", "two-pauses", "--spectrum"],
    "laws": ["laws"],
    "scenes": ["scenes"],
    "schema": ["schema"],
    "keys": ["keys"],
    "new": ["new", "valve"],
    "compare": ["compare", "SCENE", "two-pauses"],
    "scene": ["scenes", "two-pauses"],
}


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", COMMANDS)
def test_a_json_document_has_plain_values_alone(name, tmp_path, monkeypatch):
    found = []
    monkeypatch.setattr("camopt.cli.terminal.to_json", lambda document: found.append(document) or "")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "freed.toml").write_text(FREE["curvature binds"].to_toml(), encoding="utf-8")
    words = {"SCENE": "roller-1000rpm", "FREED": "freed.toml"}
    assert main([*(words.get(word, word) for word in COMMANDS[name]), "--json", "--quiet"]) in (0, 1)
    (document,) = found
    assert not places_of_objects(document)


def test_an_unproved_optimum_over_angles_is_of_plain_values():
    for row in optimise(FREE["curvature binds"], seconds=1e-3).by_law.values():
        assert not row["proved"]
        assert not places_of_objects(dict(row))
