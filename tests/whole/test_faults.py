"""Killed or cut off anywhere, a command goes on to the same rows; ``benchmarks/faults.py`` tries it and judges."""

import re
import subprocess
import sys
from collections import Counter
from itertools import product

import pytest
from support.faults import make
from support.pages import ROOT

TOOL = ROOT / "benchmarks" / "faults.py"
EVERYDAY = ("sweep over an older one", "sweep --part", "merge", "certify", "optimise", "new")
SELDOM = ("sweep", "sweep --again", "sweep --keep front-only", "sweep --resume, of seconds", "sweep --refine")
FILES = ("report", *(f"export {ending}" for ending in (".dxf", ".step", ".csv", ".nc")))


def table(most, *cases):
    """How many tries of each fault were good, of how many, by case; and what went wrong."""
    command = [sys.executable, str(TOOL), str(most), *cases]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    heads, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in done.stdout.splitlines())
    return {row[0]: dict(zip(heads[1:], row[1:], strict=True)) for row in rows}, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("most", "cases"),
    [
        (0.5, EVERYDAY),  # together, since each process imports everything
        *(pytest.param(40, (case,), marks=pytest.mark.long) for case in (*EVERYDAY, *SELDOM, *FILES)),
    ],
)
def test_a_command_goes_on_to_the_same_rows_after_any_fault(most, cases):
    found, wrong = table(most, *cases)
    assert {*found} == {*cases}
    tries = Counter()
    for case, fault in product(cases, found[cases[0]]):
        good, tried = map(int, re.fullmatch(r"(\d+) of (\d+)", found[case][fault]).groups())
        # a table of another run in the place of one is read in silence by the store of today
        assert good == tried, (case, fault, wrong)
        tries[fault] += tried
    assert [fault for fault, tried in tries.items() if not tried and not fault.endswith((" work", " result"))] == []


def test_the_judge_finds_two_results_side_by_side(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(TOOL.parent)
    monkeypatch.chdir(tmp_path)
    import faults

    bench = faults.Bench(faults.CASES["sweep over an older one"], tmp_path)
    for tables in (["designs.parquet"], ["scene.toml", "pareto.parquet"]):
        make(tmp_path, bench.after | {f"out/{name}": bench.before[f"out/{name}"] for name in tables})
        with pytest.raises(AssertionError, match="side by side"):
            bench.judge()
    make(tmp_path, bench.after)
    bench.judge(is_done=True)


def test_every_case_is_tried(monkeypatch):
    monkeypatch.syspath_prepend(TOOL.parent)
    import faults

    assert {*faults.CASES} == {*EVERYDAY, *SELDOM, *FILES}
