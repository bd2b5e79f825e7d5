"""Effects of tolerances on a page: sentences while a control moves, a section when the controls rest."""

from math import isinf

from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.scene.tolerances import Tolerances
from camopt.show.pictures.tolerances import draw
from camopt.show.reporting.page import figure_url
from camopt.solve.tables.cells import with_unit
from camopt.solve.tolerances.batch import yield_of_cams
from camopt.solve.tolerances.tolerance import MotionError, MotionErrors, first_order_errors
from camopt.solve.tolerances.turn_errors import TurnErrors

YIELD_CAMS = 1024
"""Cams drawn for the yield on a page."""
MOVING_CAMS, RESTING_CAMS = 256, 4096
"""Cams drawn for the yield in a sentence, while a control moves and when it rests."""


def has_tolerances(scene: Scene, problem: Problem) -> bool:
    """Whether a scene has tolerances and its cam can be assembled."""
    exists = problem.setup.mechanism.can_assemble(problem.design, problem.programme)[0]
    return bool(scene.tolerances != Tolerances() and exists)


def error_sentence(scene: Scene, problem: Problem) -> str:
    """A sentence on the largest motion errors, to first order; empty if no tolerance moves the tool."""
    turn = TurnErrors(scene, problem)
    if not turn.node_contributions:
        return ""
    errors = ", ".join(map(_error_text, first_order_errors(turn)))
    return f"Largest error within the tolerances: {errors} (root sum square in brackets)."


def yield_sentence(scene: Scene, problem: Problem, cams: int) -> str:
    """A sentence on the yield of random cams, with its interval; empty if tolerances touch no limit."""
    proportion = yield_of_cams(scene, problem, cams)
    if proportion is None:
        return ""
    share, low, high = (100.0 * value for value in proportion)
    return f"Yield: {share:.4g} % of {cams:,} random cams meet the limits ({low:.4g} to {high:.4g} %)."


def _error_text(error: MotionError) -> str:
    if isinf(error.worst):
        return f"{error.name} ∞"
    return f"{error.name} {with_unit(error.worst, error.unit)} ({to_shown_unit(error.three_sigma, error.unit):.3g})"


def errors_image_url(errors: MotionErrors) -> str:
    """The picture of the errors over the turn, as a data URL."""
    return figure_url(draw(errors))
