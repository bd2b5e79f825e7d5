"""What tolerances do, on a page: a sentence while a control moves, and a section where they rest."""

from io import BytesIO
from math import isinf

from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.scene.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.scene.tolerances import Tolerances
from camopt.show.pictures.tolerances import draw
from camopt.show.reporting.page import data_url
from camopt.solve.tables.cells import with_unit
from camopt.solve.tolerances.batch import yield_of_cams
from camopt.solve.tolerances.tolerance import MotionError, MotionErrors, first_order_errors
from camopt.solve.tolerances.turn_errors import TurnErrors

YIELD_CAMS = 1024
"""Of the batch of which a page tells the yield."""
MOVING_CAMS, RESTING_CAMS = 256, 4096
"""Of those of which a line tells it, while a control moves and where it rests."""
DOTS_PER_INCH = 110


def has_tolerances(scene: Scene, problem: Problem) -> bool:
    """Whether there is something to tell: tolerances, of a cam that can be put together."""
    exists = problem.setup.mechanism.can_assemble(problem.design, problem.programme)[0]
    return bool(scene.tolerances != Tolerances() and exists)


def error_sentence(scene: Scene, problem: Problem) -> str:
    """How far the motion may be off, to first order; empty where nothing moves the tool."""
    turn = TurnErrors(scene, problem)
    if not turn.node_contributions:
        return ""
    told = ", ".join(map(_error_text, first_order_errors(turn)))
    return f"By its tolerances off by at most: {told} (root sum square in brackets)."


def yield_sentence(scene: Scene, problem: Problem, cams: int) -> str:
    """The share of some cams that holds the limits, with its interval; empty where no limit is touched."""
    found = yield_of_cams(scene, problem, cams)
    if found is None:
        return ""
    share, low, high = (100.0 * each for each in found)
    return f"Of {cams:,} cams drawn by its tolerances {share:.4g} % hold the limits ({low:.4g} to {high:.4g} %)."


def _error_text(error: MotionError) -> str:
    if isinf(error.worst):
        return f"{error.name} ∞"
    return f"{error.name} {with_unit(error.worst, error.unit)} ({to_shown_unit(error.three_sigma, error.unit):.3g})"


def errors_image(found: MotionErrors) -> str:
    """The picture of the errors as an address that holds it."""
    file = BytesIO()
    draw(found).savefig(file, format="png", dpi=DOTS_PER_INCH)
    return data_url(file.getvalue(), "image/png")
