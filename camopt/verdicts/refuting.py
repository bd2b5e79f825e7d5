"""Designs that a single cam angle shows to break a limit, before anything is searched.

A claim holds at every cam angle, so that any one refutes it. Designs that are alike are at their worst near the
same angles: so all are looked at where nodes of the motion show of most of a few designs that they break a claim.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from camopt.effects import Case
from camopt.effects.peak import Derivative
from camopt.mechanisms import Designs
from camopt.numerics import BoolArray, FloatArray
from camopt.numerics.curves import value_of
from camopt.numerics.piecewise import node_motion, of_all_rows
from camopt.problem.claims import Claim

MANY, FEW, NODES = 500, 16, 4  # designs that are worth it, those asked first, and nodes for each side of a claim
CLEAR = 1e-6  # relative, of what is further beyond a bound than rounding


@np.errstate(all="ignore")
def refuted(case: Case, claims: Iterable[Claim]) -> BoolArray:
    """Which designs of a case break one of some claims for certain; of few designs none are asked."""
    found, table = np.zeros(len(case.designs), dtype=bool), case.programme.table
    asked = [each for each in claims if not isinstance(each.curve, Derivative)] if found.size > MANY else []
    pieces = np.repeat(table.kind, np.diff(table.first_panel) + 1)
    for made in {each.curve: None for each in asked}:
        record = made(case.designs, case.programme)
        few = case.designs.take(np.linspace(0, found.size - 1, FEW).astype(int))
        values = value_of(made(few, case.programme), ..., node_motion(of_all_rows(table), ...))
        for claim in (each for each in asked if each.curve is made):
            for side in claim.sides:
                shown = _beyond(claim, side, values, few) & (pieces & claim.kinds != 0)[:, None]
                for node in _telling(shown):
                    found |= _beyond(claim, side, value_of(record, ..., node_motion(table, node)), case.designs)
    return found


def _telling(shown: BoolArray) -> Iterator[int]:
    """The nodes that show the most, one by one, of what (nodes, designs) show."""
    for _ in range(NODES):
        if not shown.any():
            break
        node = int(np.argmax(shown.sum(axis=1)))
        yield node
        shown = shown & ~shown[node]


def _beyond(claim: Claim, side: float, values: FloatArray, designs: Designs) -> Any:
    """Which values of the curve of a claim are clearly beyond its bound."""
    allowed = claim.allowed()
    room = CLEAR * (abs(allowed) or claim.unit(designs))
    return side * claim.factor(designs) * values > allowed + room
