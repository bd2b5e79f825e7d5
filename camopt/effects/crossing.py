"""Global self-crossing: whether parts of the profile far apart along the turn cross.

Curvature says nothing of it. The profile is drawn as a closed polygon of a few thousand points and tested by
shapely; an undercut profile, which crosses itself at the undercut, counts too.
"""

from typing import Any

import numpy as np

from camopt.effects.case import Case, Effect, Subject
from camopt.geometry import profile_points

POINTS = 4096


def offers(subject: Subject) -> tuple[str, ...]:
    return () if subject.mechanism.grooved else ("self_crossing",)


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    from shapely import LinearRing

    angles = np.linspace(0.0, 2 * np.pi, POINTS, endpoint=False)
    crossing = np.empty(len(case.designs), dtype=bool)
    for i in range(len(case.designs)):
        points = profile_points(case.subject.mechanism, case.designs.take([i]), case.programme, angles)
        crossing[i] = not LinearRing(np.column_stack([points.real, points.imag])).is_simple
    return {"self_crossing": crossing}


EFFECT = Effect("crossing", offers, run)
