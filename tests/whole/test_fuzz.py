"""Scenes that went wrong at random: each is answered or refused in a line. ``benchmarks/fuzz.py`` tries more."""

import pytest
from support.fuzzed import case, misfit_case, outcome

SECONDS = 60.0  # of the processor; the slowest of 100,000 takes a tenth of it
FEW, MANY = 60, 3000


def run_numbers(numbers, made=case):
    outcomes = {number: outcome(*made(number), SECONDS) for number in numbers}
    assert {number: (each.faults, each.err[-500:]) for number, each in outcomes.items() if each.faults} == {}
    return outcomes.values()


@pytest.mark.slow
def test_some_scenes():
    codes = [each.code for each in run_numbers(range(10**6, 10**6 + FEW))]
    assert min(codes.count(0), codes.count(2)) > FEW / 10  # they are neither all cams nor all refused


@pytest.mark.slow
def test_some_scenes_with_lists_and_endless_numbers_where_words_belong():
    assert 2 in [each.code for each in run_numbers(range(FEW), misfit_case)]


@pytest.mark.long
def test_many_scenes_with_lists_and_endless_numbers_where_words_belong():
    run_numbers(range(FEW, FEW + MANY), misfit_case)


@pytest.mark.long
def test_many_scenes():
    run_numbers(range(2 * 10**6, 2 * 10**6 + MANY))
