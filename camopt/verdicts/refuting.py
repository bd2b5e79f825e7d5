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
from camopt.mechanisms.design import BoolArray
from camopt.numerics import FloatArray
from camopt.numerics.curves import curve
from camopt.numerics.piecewise import node_motion, of_all_rows
from camopt.problem.claims import Claim

MANY, FEW, NODES = 500, 16, 4  # designs that are worth it, those asked first, and nodes for each side of a claim
CLEAR = 1e-6  # relative, of what is further beyond a bound than rounding


@np.errstate(all="ignore")
def refuted(case: Case, claims: Iterable[Claim]) -> BoolArray:
    """Which designs of a case break one of some claims for certain; of few designs none are asked."""
    found = np.zeros(len(case.designs), dtype=bool)
    asked = [each for each in claims if not isinstance(each.curve, Derivative)] if found.size > MANY else []
    for made in {each.curve: None for each in asked}:
        record, table = made(case.designs, case.programme), case.programme.table
        for claim in (each for each in asked if each.curve is made):
            for node, side in _telling(case, claim):
                found |= _beyond(claim, side, curve(record, ..., node_motion(table, node))[0], case.designs)
    return found


def _telling(case: Case, claim: Claim) -> Iterator[tuple[int, float]]:
    """Nodes that show of the most of a few designs that they break a side of a claim, each with that side."""
    table, count = case.programme.table, len(case.designs)
    few = case.designs.take(np.linspace(0, count - 1, FEW).astype(int))
    pieces = np.repeat(table.kind, np.diff(table.first_panel) + 1)
    nodes = np.flatnonzero(pieces & claim.kinds)
    at = node_motion(of_all_rows(table), ...)
    values = curve(claim.curve(few, case.programme), ..., at)[0][nodes]
    for side in claim.sides:
        shown = _beyond(claim, side, values, few)
        for _ in range(NODES):
            best = int(np.argmax(shown.sum(axis=1))) if nodes.size else 0
            if not shown.any():
                break
            yield int(nodes[best]), side
            shown = shown & ~shown[best]


def _beyond(claim: Claim, side: float, values: FloatArray, designs: Designs) -> Any:
    """Which values of the curve of a claim are clearly beyond its bound."""
    allowed = claim.allowed()
    room = CLEAR * (abs(allowed) or claim.unit(designs))
    return side * claim.factor(designs) * values > allowed + room
