"""The smallest cam: the least size that holds every limit, proved.

Closed forms first. If the cam they give holds all other limits too, it is the answer. Otherwise curvature decides,
and feasibility need not be monotone in the size: a branch-and-bound over boxes of designs. What is left when it
ends is the least feasible size to within GAP.
"""

from camopt.motion.programme import Programme
from camopt.question import Question, exactly
from camopt.search.answer import Bounds, Smallest
from camopt.search.branch_and_bound import branch_and_bound
from camopt.search.closed_form import closed_form, least_size, nudged


def smallest(question: Question, programme: Programme, bounds: Bounds) -> Smallest:
    """The design of least size within bounds that holds every limit of the question."""
    question = exactly(question)
    bounds = {**bounds, "size": (least_size(question, programme, bounds), bounds["size"][1])}
    start = closed_form(question, programme, bounds)
    if start is not None:
        start = nudged(question, programme, start, bounds["size"][1])
        if start is not None:
            return Smallest(start, proved=True)
    return branch_and_bound(question, programme, bounds)
