"""Numbers and closed forms of published sources (``support.published``): camopt says the same.

No worked number was found for wear and for the film of line contact: ``tests/model/effects/test_surface.py`` holds
these against the formulas of their sources alone.
"""

from pathlib import Path

import pytest
from support.hard_cases import HARD_CASES
from support.published import CASES
from support.second_answers import SECOND_ANSWERS


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_others_printed(case):
    off = [
        f"{answer.what}: {answer.printed} by its source, {value}"
        for answer, value in zip(case.answers, case.ours(), strict=True)
        if not abs(value - answer.value) <= answer.allowed_error
    ]
    assert off == []


def test_what_nobody_has_seen_in_print_is_called_so():
    """Lecture notes were at hand, with two cams of Khurmi, and one page of the web."""
    read = {case.name: case.second_answer_text for case in CASES if case.read}
    assert sorted(read) == [
        "Knife edge in simple harmonic motion",
        "Knife edge with uniform acceleration and retardation",
        "Sphere on a rigid plane",
    ]
    assert all(words.startswith("Read in ") for words in read.values())
    assert {case.second_answer_text for case in CASES if not case.read} == {
        "Quoted from memory, not seen in print."
    }


NAMED = [*(tests for _, tests in SECOND_ANSWERS.values()), *HARD_CASES.values()]


@pytest.mark.parametrize("test", sorted({test for tests in NAMED for test in tests}))
def test_a_test_that_the_site_names_is_there(test):
    file, name = test.split("::")
    assert f"\ndef {name}(" in (Path(__file__).parents[1] / file).read_text(encoding="utf-8")


def test_each_hard_case_has_its_tests():
    assert len(HARD_CASES) == 18
    assert all(HARD_CASES.values())
