"""The result of a synthesis in a sentence."""

from camopt.problem.problem import resolve
from camopt.synthesis.conditions import ground_of
from camopt.synthesis.from_scene import objective_in
from camopt.synthesis.synthesised import Synthesis
from camopt.synthesis.units import objective_unit
from camopt.tables.cells import with_unit


def bound_in_words(result: Synthesis) -> str:
    """The minimised value, the lower bound for any motion, and the gap between them."""
    unit = objective_unit(result.asked)
    what = f"Minimised: {with_unit(result.objective, unit)}."
    if result.bound:
        what += f" No motion at all can have less than {with_unit(result.bound, unit)} within the convex limits:"
        what += f" a gap of {result.gap:.2%}."
    elif result.bound is None and ground_of(resolve(result.asked)).dip is not None:
        what += " There is no bound: the follower is lowest in a move, where the scene gives no position."
    return what


def size_in_words(result: Synthesis) -> str:
    """That the scene's own size is the largest, where something else is minimised and [search] has none."""
    problem = resolve(result.asked)
    if "size" in problem.choices.variables or "size" in objective_in(result.asked.synthesis):
        return ""
    size = problem.setup.mechanism.body.size
    own = with_unit(float(problem.design.size[0]), "mm")
    words = f"The {size.replace('_', ' ')} may be at most that of the scene, {own}"
    return f"{words}: search.{size} gives it a range."
