"""Commands that publish a folder, given again: each says that it is done, and prints what it printed before."""

import pytest

SPECTRUM = "camopt.studies.spectrum.spectrum"
COMMANDS = {
    "optimise": (["optimise", "two-pauses", "--out", "out"], "camopt.smallest.optimise.optimise"),
    "effects": (["effects", "--spectrum", "--out", "out"], SPECTRUM),
    "synthesise": (["synthesise", "--out", "out"], "camopt.synthesis.synthesise.synthesise"),
}


def never(*_):
    raise AssertionError("it is computed again")


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_that_is_done_prints_what_it_printed(name, command, tmp_path, monkeypatch):
    arguments, work = COMMANDS[name]
    code, text, err = command(*arguments)
    assert "wrote out/" in err
    before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "out").iterdir()}
    with monkeypatch.context() as patched:
        patched.setattr(work, never)
        assert command(*arguments)[:2] == (code, text)
        document = command(*arguments, "--json", "--quiet")
        said = command(*arguments)[2]
    assert "wrote" not in said
    assert said.endswith(
        "camopt: already done: out has the whole result of the same question and version; "
        "`again` computes it anew\n"
    )
    assert document[2] == ""
    assert {path.name: path.stat().st_mtime_ns for path in (tmp_path / "out").iterdir()} == before
    (tmp_path / "out" / next(iter(before.keys() - {"manifest.json"}))).unlink()
    code, again, err = command(*arguments, "--json", "--quiet")
    assert (code, again) == document[:2]


def test_it_computes_for_another_question_and_for_who_asks_it_to(command):
    asked = COMMANDS["optimise"][0]
    command(*asked)
    for more in (["--again"], ["--seconds", "59"], ["--rpm", "99"]):
        assert "wrote out/" in command(*asked, *more)[2], more
    assert command("optimise", "two-pauses", "--again")[0] == 2
