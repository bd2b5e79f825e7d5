"""The compared methods for extremes: sampling, sampling with a parabola, enclosures."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.extremes import Precision, extremes_of_curve
from camopt.core.numerics.piecewise import MotionTable
from camopt.core.numerics.sampling import write_sampled_extremes
from camopt.model.motion.programme import Programme

ANGLE_COUNTS = (36, 72, 180, 360, 720, 1800, 3600)
POLISHED_COUNTS = (36, 72, 180, 360)
RELATIVE_ERRORS = (1e-4, 1e-6, 1e-9, 1e-12)
Extremal = tuple[FloatArray, FloatArray]
"""Values and half-widths, (questions, designs)."""


@dataclass(frozen=True)
class Method:
    """A method for extremes at one setting: angles per turn, or a relative error."""

    name: str
    setting: float
    find_extremes: Callable[[Any, int, Programme, Any], Extremal]


def sampling_method(angle_count: int, polish: bool = False) -> Method:
    """Sampling; ``polish`` fits a parabola through the peak."""

    def sample_extremes(f: Any, count: int, programme: Programme, questions: Any) -> Extremal:
        value = np.empty((len(questions), count))
        write_sampled_extremes(f, count, sampling_motion_table(programme, angle_count), questions, polish, value)
        return value, np.zeros_like(value)

    return Method("sampling, polished" if polish else "sampling", angle_count, sample_extremes)


def enclosure_method(relative_error: float) -> Method:
    """Enclosures with a relative error."""

    def enclose_extremes(f: Any, count: int, programme: Programme, questions: Any) -> Extremal:
        result = extremes_of_curve(f, count, programme.table, questions, Precision(relative_error, np.inf))
        return result.value, result.width

    return Method("enclosure", relative_error, enclose_extremes)


METHODS = (
    *(sampling_method(angles) for angles in ANGLE_COUNTS),
    *(sampling_method(angles, polish=True) for angles in POLISHED_COUNTS),
    *(enclosure_method(relative_error) for relative_error in RELATIVE_ERRORS),
)


@lru_cache(maxsize=64)
def sampling_motion_table(programme: Programme, angle_count: int) -> MotionTable:
    """A table with nodes at even cam angles; only the fields that sampling reads are filled."""
    theta = np.linspace(0.0, 2 * np.pi, angle_count, endpoint=False)
    motion = programme.motion_at(theta).T.copy()
    ends = np.array([stroke.end for stroke in programme.strokes])
    stroke = np.minimum(np.searchsorted(ends, theta, side="right"), len(ends) - 1)
    counts = np.bincount(stroke, minlength=len(ends))
    kinds = np.array([s.kind for s in programme.strokes])[counts > 0]
    first = np.concatenate([[0], np.cumsum(counts[counts > 0] - 1)])
    blank = np.zeros((0, 1))
    return programme.table._replace(
        coefficients=blank, first_panel=first, kind=kinds, nodes=motion, low=blank, high=blank, load=None
    )
