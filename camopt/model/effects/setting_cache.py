"""A cache for results that depend only on the motion and a few numbers of the scene, not on sizes."""

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import Any

import numpy as np

from camopt.model.motion.programme import Programme

SETTING_BLOCK = 256  # settings computed together, so that memory is bounded
REMEMBERED_BLOCKS = 64  # cached results: blocks of designs often have the settings of earlier blocks


def once_per_setting(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator for a function of a programme and numbers, which is evaluated once for equal numbers.

    The decorated function takes arrays (settings,) and returns an array or a NamedTuple of arrays. Callers give
    numbers, or arrays (designs,), and get the same.
    """

    @lru_cache(maxsize=REMEMBERED_BLOCKS)
    def cached_values_of_settings(
        programme: Programme, number_bytes: bytes, setting_count: int
    ) -> tuple[type | None, Any]:
        table = np.frombuffer(number_bytes).reshape(-1, setting_count)
        parts = [
            function(programme, *table[:, k : k + SETTING_BLOCK]) for k in range(0, setting_count, SETTING_BLOCK)
        ]
        columns = np.concatenate([np.atleast_2d(np.array(part)) for part in parts], axis=1)
        return (type(parts[0]) if isinstance(parts[0], tuple) else None), columns

    @wraps(function)
    def values_by_design(programme: Programme, *numbers: Any) -> Any:
        table = np.array(np.broadcast_arrays(*numbers), dtype=float)
        settings, which = np.unique(table.reshape(len(table), -1), axis=1, return_inverse=True)
        if not settings.size:
            settings = np.full((len(table), 1), 0.5)  # without designs any setting will do
        kind, columns = cached_values_of_settings(programme, settings.tobytes(), settings.shape[1])
        values = columns[:, which.reshape(-1)] if table.ndim > 1 else columns[:, 0].tolist()
        return kind(*values) if kind else values[0]

    return values_by_design
