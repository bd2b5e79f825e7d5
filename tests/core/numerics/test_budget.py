"""Budgets count work, or read the clock if a user gives a time."""

from math import inf, nan

import pytest

from camopt.core.mistakes import BadInput
from camopt.core.numerics import budget as budgets
from camopt.core.numerics.budget import UNLIMITED, Budget, search_budget


def test_a_budget_ends_with_its_work():
    budget = Budget(10.0)
    budget.spend(9.0)
    assert not budget.is_spent
    budget.spend(1.0)
    assert budget.is_spent
    assert not UNLIMITED.is_spent


def test_what_a_share_leaves_is_free_for_the_next():
    whole = Budget(12.0)
    first = whole.share(3)
    assert first.end == 4.0
    first.spend(2.0)
    assert whole.share(2).end == 7.0
    whole.spend(20.0)
    assert whole.share(2).is_spent
    assert UNLIMITED.share(5).end == inf


def test_only_the_seconds_of_a_user_read_the_clock(monkeypatch):
    time = [100.0]
    monkeypatch.setattr(budgets, "monotonic", lambda: time[0])
    work, seconds = search_budget(None, 8.0), search_budget(5, 8.0)
    part = seconds.share(2)
    seconds.spend(1e9)
    assert (work.end, seconds.end, part.end) == (8.0, 105.0, 102.5)
    time[0] = 103.0
    assert (work.is_spent, seconds.is_spent, part.is_spent) == (False, False, True)
    time[0] = 105.0
    assert (work.is_spent, seconds.is_spent) == (False, True)


@pytest.mark.parametrize("seconds", [0, -1, nan, "ten"])
def test_seconds_are_a_number_above_zero(seconds):
    with pytest.raises(BadInput, match="must be a number above 0"):
        search_budget(seconds, 8.0)
