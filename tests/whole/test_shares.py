"""Each test has its turn, as its commit says."""

import pytest
from support.depth import TURNS, has_turn, is_shared


@pytest.mark.parametrize("share", [1, 2, 3, 4, 6, 12])
def test_every_case_of_a_slow_test_runs_at_some_commit(share):
    for case in range(share):
        name = f"test[{case}]"
        commits = [n for n in range(TURNS * share) if has_turn(name, n) and is_shared(case, share, n)]
        assert len(commits) == 1


def test_each_commit_runs_one_case_of_a_share():
    for commit in range(100):
        assert sum(is_shared(case, 7, commit) for case in range(7)) == 1
