"""A path that follows a curve of the cam within a given deviation, with the proof."""

from math import isfinite
from typing import NamedTuple

from camopt.contour.curve import CamCurve
from camopt.contour.deviation import deviation_bound
from camopt.contour.fit import FITS, fitted
from camopt.contour.path import ArcPath, CubicPath
from camopt.mistakes import BadInput, Mistake

CHORD = 0.001  # mm
SHORTEST_CHORD, LONGEST_CHORD = 1e-6, 10.0  # mm: a nanometre; what nobody takes for a cam any more
AIM, NEXT_AIM, PROOF_ROUNDS = (
    0.95,
    0.8,
    6,
)  # of the deviation asked for: what is aimed at, then if a proof needs more


class Followed(NamedTuple):
    """A path with its proved deviation, mm: no point of one is further from the other, path or curve."""

    path: ArcPath | CubicPath
    deviation: float


def follow(curve: CamCurve, kind: str = "arcs", chord: float = CHORD) -> Followed:
    """The path of a kind of ``FITS`` that is proved to be within ``chord`` mm of a curve (``check_kind``).

    Raises
    ------
    BadInput
        For a chord that needs over a million elements.
    """
    aim = AIM * chord
    for _ in range(PROOF_ROUNDS):
        path = fitted(curve, kind, aim)
        found = Followed(path, deviation_bound(curve, path, chord))
        if found.deviation <= chord:
            break
        aim *= NEXT_AIM
    return found


def check_kind(kind: str, chord: float) -> None:
    """BadInput for what users may not ask of ``follow``: another kind, or a chord outside 1e-6 to 10 mm."""
    mistakes = []
    if kind not in FITS:
        mistakes.append(Mistake("camopt", "curves", kind, f"one of {', '.join(FITS)}"))
    if not (isfinite(chord) and SHORTEST_CHORD <= chord <= LONGEST_CHORD):
        mistakes.append(Mistake("camopt", "chord", chord, f"from {SHORTEST_CHORD:g} to {LONGEST_CHORD:g} mm"))
    if mistakes:
        raise BadInput(mistakes)
