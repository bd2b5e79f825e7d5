"""The price list of the benchmarks is made for every mechanism."""

import sys
from pathlib import Path

import pytest

from camopt.mechanisms import MECHANISMS

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
import prices


def test_the_price_list_has_a_line_for_every_mechanism(monkeypatch):
    for name, value in {"DESIGNS": 32, "PROVED": 1, "RUNS": 1}.items():
        monkeypatch.setattr(prices, name, value)
    heads, _, *rows = prices.lines()
    assert "proved in balls" in heads
    assert len(rows) == len(prices.SCENES) >= len(MECHANISMS)
    for row in rows:
        numbers = [float(cell) for cell in row.strip("| ").split("|")[1:]]
        assert all(number > 0.0 for number in numbers)


@pytest.mark.parametrize("name", prices.SCENES)
def test_every_price_is_of_a_cam_that_can_be_assembled(name):
    cam, follower = prices.SCENES[name]
    question = prices.resolve(prices.Scene.from_dict({"cam": cam, "follower": follower, "motion": prices.MOTION}))
    assert len(prices.random_designs(question)) > prices.DESIGNS // 2
