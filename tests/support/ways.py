"""Which way a front is found, in tests of spaces that are small."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def boxes_for_front_only() -> Iterator[None]:
    """Boxes of designs find the front of a space of any size if "front-only" is kept; blocks do, if "pareto"."""
    from camopt.solve.front import plan

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plan, "boxes_are_faster", lambda asked: asked.keep == plan.FRONT_ONLY)
        yield
