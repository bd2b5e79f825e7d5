"""The smallest cam: the least size that holds every limit, proved.

Closed forms and cutting planes come first: the smallest cam under the limits that are linear. If it holds the
others too, it is the answer. Otherwise curvature or a load decides, and feasibility need not be monotone in the
size: a branch-and-bound over boxes of designs, from there on. What is left when it ends is the least feasible
size to within GAP.
"""

from camopt.motion.programme import Programme
from camopt.question import Question, exactly
from camopt.search.answer import Bounds, Smallest
from camopt.search.branch_and_bound import branch_and_bound
from camopt.search.closed_form import NUDGES, closed_form, least_size, nudged
from camopt.search.cutting_planes import Cut, by_cutting_planes


def smallest(question: Question, programme: Programme, bounds: Bounds) -> Smallest:
    """The design of least size within bounds that holds every limit of the question."""
    question = exactly(question)
    bounds = {**bounds, "size": (least_size(question, programme, bounds), bounds["size"][1])}
    start = closed_form(question, programme, bounds)
    if start is not None:
        floor = float(start.size[0]) * (1.0 - NUDGES[-1])
        found: Cut | None = Cut(nudged(question, programme, start, bounds["size"][1]), floor)
    else:
        found = by_cutting_planes(question, programme, bounds)
    if found is not None and found.design is not None:
        return Smallest(found.design, proved=True)
    return branch_and_bound(question, programme, bounds, found.floor if found else 0.0)
