"""Threads of this process: what they give, and which of them are kept."""

from os import getpid

import pytest

from camopt.engines.threads import IDLE, Threads

KEPT = IDLE[getpid(), 3]


def test_threads_are_kept_and_work_within_work_has_others():
    def squares(some):
        return [n**2 for n in some], [*Threads(3).in_order(sum, range(4))]

    found = [*Threads(3).in_order(squares, range(20))]
    assert found == [([n**2], [0, 1, 2, 3]) for n in range(20)]
    kept = [*KEPT]
    assert kept
    assert [*Threads(3).in_order(len, range(4))] == [1] * 4
    assert kept == KEPT


def test_threads_that_an_error_leaves_at_work_end():
    assert [*Threads(3).in_order(len, range(4))] == [1] * 4
    kept = [*KEPT]
    with pytest.raises(ZeroDivisionError):
        list(Threads(3).in_order(lambda some: 1 // (some[0] - 2), range(9)))
    assert kept[:-1] == KEPT
