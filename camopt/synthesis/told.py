"""The result of a synthesis in a sentence."""

from camopt.problem.problem import Problem, resolve
from camopt.synthesis.conditions import ground_of
from camopt.synthesis.from_scene import objective_in
from camopt.synthesis.synthesised import Synthesis
from camopt.synthesis.through_train import ratio_of
from camopt.synthesis.units import objective_unit
from camopt.tables.cells import with_unit


def bound_in_words(result: Synthesis) -> str:
    """The minimised value, the lower bound for any motion, and the gap between them."""
    unit = objective_unit(result.asked)
    what = f"Minimised: {with_unit(result.objective, unit)}."
    if result.bound:
        what += f" No motion at all can have less than {with_unit(result.bound, unit)} within the convex limits:"
        what += f" a gap of {result.gap:.2%}."
    elif result.bound is None and (why := _unbounded(resolve(result.asked))):
        what += f" There is no bound: {why}."
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


def why_local(result: Synthesis) -> str:
    """Why laws are no more than a local optimum."""
    problem = resolve(result.asked)
    if ratio_of(problem) is None:
        return "The limits of a cam behind a train whose ratio changes are not convex"
    swung = problem.setup.angular
    return "The limits of an oscillating follower are not convex" if swung else "Curvature or a load decides too"


def _unbounded(problem: Problem) -> str:
    """What leaves no bound on the size, unless it is that the follower oscillates."""
    if ground_of(problem).dip is not None:
        return "the follower is lowest in a move, where the scene gives no position"
    return "" if ratio_of(problem) else "through a train whose ratio changes nothing convex bounds the size"
