"""Two cams side by side: what each quantity is in one and in the other, and by how much it differs."""

from math import isfinite
from typing import Any, NamedTuple

from camopt.comparing.designs import ERROR_BOUND
from camopt.problem.problem import missing, resolve
from camopt.quantities import in_order
from camopt.scene.scene import Scene
from camopt.verdicts.evaluation import evaluate


class Values(NamedTuple):
    """A quantity of two cams."""

    a: Any
    """In A; None where A does not call for it."""
    b: Any
    """In B."""
    difference: float | None
    """B less A; None where one is no number, or infinite."""


def is_cam(scene: Scene) -> bool:
    """Whether a scene gives all sizes and numbers of its cam, and leaves none to a search."""
    return not missing(resolve(scene))


def compared_cams(a: Scene, b: Scene) -> dict[str, Values]:
    """The quantities that either calls for and that differ by more than the relative errors of both."""
    one, other = evaluate(a), evaluate(b)
    pairs = {name: (one.get(name), other.get(name)) for name in in_order({**one, **other}) if name != ERROR_BOUND}
    errors = a.accuracy.relative_error, b.accuracy.relative_error
    return {name: Values(*pair, _apart(*pair)) for name, pair in pairs.items() if _differ(*pair, *errors)}


def _are_numbers(*values: Any) -> bool:
    return all(isinstance(value, float) and isfinite(value) for value in values)


def _apart(a: Any, b: Any) -> float | None:
    return b - a if _are_numbers(a, b) else None


def _differ(a: Any, b: Any, error_a: float, error_b: float) -> bool:
    return bool(abs(b - a) > error_a * abs(a) + error_b * abs(b)) if _are_numbers(a, b) else a != b
