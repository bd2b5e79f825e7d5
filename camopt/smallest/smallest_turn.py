"""The smallest cam over the angles of a turn as well: freed segments share out the degrees that they have together.

A few turns, and a descent by the closed form if it decides, give a small cam. Where the size is convex in the
angles, lines prove it at once (``convex_floor``); elsewhere boxes of sizes and angles prove it, or find a smaller
cam (``turn_boxes``). Where they run out, a descent over the angles looks for one more.
"""

from dataclasses import replace
from functools import reduce

from camopt.mechanisms.design import SizeBounds
from camopt.numerics.clock import now
from camopt.smallest.convex_floor import floor_if_convex
from camopt.smallest.nelder_mead import NelderMead
from camopt.smallest.result import Smallest
from camopt.smallest.smallest import smallest
from camopt.smallest.turn_boxes import TurnSearch
from camopt.smallest.turns import BestTurn, SegmentAngles, better


def smallest_of_turns(turns: SegmentAngles, bounds: SizeBounds) -> BestTurn:
    """The design of least size over the angles as well, with its proven gap."""
    none = BestTurn(Smallest(None, 0.0), turns.scene_angles)
    found = reduce(better, (NelderMead(each, bounds).few_turns() for each in turns.kinds), none)
    floors = []
    for each in turns.kinds:
        found = _searched(each, bounds, found)
        floors.append(found.answer.floor)
    found = _with_floor(found, min(floors))
    if found.answer.proved:
        return found
    descended = (NelderMead(each, bounds, found).run() for each in turns.kinds)
    return _with_floor(_exactly(turns, bounds, reduce(better, descended, found)), min(floors))


def _searched(turns: SegmentAngles, bounds: SizeBounds, found: BestTurn) -> BestTurn:
    """The smallest cam so far and of the turns that have the same segments, with a size that no cam undercuts."""
    convex = _with_floor(found, floor_if_convex(turns, bounds, found))
    return convex if convex.answer.proved else TurnSearch(turns, bounds, found).run()


def _exactly(turns: SegmentAngles, bounds: SizeBounds, found: BestTurn) -> BestTurn:
    """The smallest cam of a turn, which a descent only nears, if there is time."""
    if found.answer.design is None or now() > turns.until:
        return found
    return better(found, BestTurn(smallest(turns.problem_of(found.freed), bounds, turns.until), found.freed))


def _with_floor(found: BestTurn, floor: float) -> BestTurn:
    return BestTurn(replace(found.answer, floor=floor), found.freed)
