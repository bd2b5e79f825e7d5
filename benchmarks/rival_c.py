"""The rival in C (``rival.c``).

It looks at samples of a tabulated turn, as most programs do. What it finds is never too large, and misses the truth
by what lies between two samples; camopt encloses the extremes of the continuous turn to 1e-9.
"""

import ctypes
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from c_library import c_compiler, c_library
from rival_numpy import Array

SAMPLES = 360
FLAGS = ("-O3", "-march=native", "-ffast-math")
MECHANISMS = (
    "disc_translating",
    "disc_translating_flat",
    "disc_oscillating",
    "disc_oscillating_flat",
    "cylindrical_translating",
    "cylindrical_oscillating",
)
SIZES = ("size", "roller_radius", "offset", "arm_length", "centre_distance", "face_offset")
NUMBERS = {"float": np.float32, "double": np.float64}
"""The types of number that the rival is made for, by their names in C."""


@dataclass(frozen=True)
class Rival:
    """A function for each mechanism, the numbers it takes, and what it is made with."""

    name: str
    number: Any
    works: dict[str, Callable[[Any, float, float, Any, Any], None]]
    """(sizes, sense, lift, motion, found), as ``rival.c`` describes them; fills ``found``."""

    def extremes(
        self, mechanism: str, sizes: Array, sense: float, lift: float, motion: Array, threads: int = 1
    ) -> Array:
        """The largest |tan β|, and the least and the largest curvature (of a flat face: radius), (designs, 3).

        ``sizes`` is (designs, 6) in the order of ``SIZES``, ``motion`` (5, samples); mm and rad. The designs are
        shared out evenly between the threads: C does not hold Python's lock.
        """
        found, motion = np.empty((len(sizes), 3), self.number), np.ascontiguousarray(motion, self.number)
        parts = np.array_split(np.ascontiguousarray(sizes, self.number), threads)
        with ThreadPoolExecutor(threads) as pool:
            shared = ([value] * threads for value in (sense, lift, motion))
            list(pool.map(self.works[mechanism], parts, *shared, np.array_split(found, threads)))
        return found


@cache
def rival(number: str) -> Rival:
    """The rival in C for a type of number."""
    compiler = c_compiler()
    if compiler is None:
        raise SystemExit("the rival needs a C compiler, cc or that of the variable CC")
    flags = [*FLAGS, f"-DNUMBER={number}"]
    library = c_library("rival.c", flags)
    works = {each: _work(getattr(library, f"{each}_extremes"), number) for each in MECHANISMS}
    return Rival(f"C, {' '.join(flags)}, {compiler}", NUMBERS[number], works)


def _work(function: Any, number: str) -> Callable[..., None]:
    """A function of the library, for arrays."""
    table, one = np.ctypeslib.ndpointer(NUMBERS[number], 2, flags="C"), getattr(ctypes, f"c_{number}")
    function.argtypes, function.restype = [ctypes.c_long, table, one, one, ctypes.c_long, table, table], None

    def work(sizes: Any, sense: float, lift: float, motion: Any, found: Any) -> None:
        function(len(sizes), sizes, sense, lift, motion.shape[1], motion, found)

    return work
