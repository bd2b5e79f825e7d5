"""The rivals in C (``rival.c``).

The first looks at samples of a tabulated turn, as most programs do. What it finds is never too large, and misses
the truth by what lies between two samples; camopt encloses the extremes of the continuous turn to 1e-9.

The second computes each pitch curve once for all designs that share it, and polishes the best of few samples to
1e-9. It misses a peak that is not the highest at its samples.
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
CELL_SAMPLES, TERMS = 6, 12
"""Samples in a polynomial cell of the motion, and the polynomial's terms, as in ``rival.c``."""
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


Cells = tuple[Array, Array]
"""Samples and polynomials of a motion, as ``motion_cells`` gives them."""


@dataclass(frozen=True)
class Curves:
    """Pitch curves (of a flat face: profiles) that designs share."""

    sizes: Array
    """Sizes of a cam for each curve, (curves, 6) in the order of ``SIZES``, with a roller of no size."""
    curve_of: Array
    """The number of each design's curve."""


def shared_curves(mechanism: str, sizes: Array) -> Curves:
    """The different curves of designs: a disc's by the prime radius, a cylinder's by the mean radius alone."""
    sizes = sizes.copy()
    if mechanism.startswith("disc"):
        sizes[:, 0] += sizes[:, 1]
    sizes[:, 1] = 0.0
    _, first, curve_of = np.unique(np.round(sizes, 9), axis=0, return_index=True, return_inverse=True)
    return Curves(sizes[first], curve_of.ravel().astype(np.int32))


Work = Callable[..., None]


@dataclass(frozen=True)
class Rival:
    """A function for each mechanism, the numbers it takes, and what it is made with."""

    name: str
    number: Any
    sampling: dict[str, Work]
    """(sizes, sense, lift, motion, found), as ``rival.c`` describes them; fills ``found``."""
    polishing: dict[str, Work]
    """(sizes, sense, lift, motion, found, terms): the same with the cells' polynomials."""
    share_out: Work
    """(curves, curve_of, found): fills ``found`` with the numbers of each design's curve."""

    def extremes(
        self, mechanism: str, sizes: Array, sense: float, lift: float, motion: Array, threads: int = 1
    ) -> Array:
        """The largest |tan β|, and the least and the largest curvature (of a flat face: radius), (designs, 3).

        ``sizes`` is (designs, 6) in the order of ``SIZES``, ``motion`` (5, samples); mm and rad. The designs are
        shared out evenly between the threads: C does not hold Python's lock.
        """
        motion = np.ascontiguousarray(motion, self.number)
        return self._in_parts(threads, self.sampling[mechanism], sizes, sense, lift, motion)

    def polished_extremes(
        self, mechanism: str, curves: Curves, sense: float, lift: float, cells: Cells, threads: int = 1
    ) -> Array:
        """The extremes to 1e-9 for designs that share curves, (designs, 3)."""
        numbers = self._in_parts(threads, self.polishing[mechanism], curves.sizes, sense, lift, *cells)
        found = np.empty((len(curves.curve_of), 3), self.number)
        with ThreadPoolExecutor(threads) as pool:
            parts = (np.array_split(each, threads) for each in (curves.curve_of, found))
            list(pool.map(self.share_out, [numbers] * threads, *parts))
        return found

    def _in_parts(
        self, threads: int, work: Work, sizes: Array, sense: float, lift: float, motion: Array, *terms: Array
    ) -> Array:
        """The numbers of all cams."""
        found = np.empty((len(sizes), 3), self.number)
        parts = np.array_split(np.ascontiguousarray(sizes, self.number), threads)
        with ThreadPoolExecutor(threads) as pool:
            shared = ([value] * threads for value in (sense, lift, motion))
            list(
                pool.map(
                    work, parts, *shared, np.array_split(found, threads), *([each] * threads for each in terms)
                )
            )
        return found


@cache
def rival(number: str) -> Rival:
    """The rivals in C for a type of number."""
    compiler = c_compiler()
    if compiler is None:
        raise SystemExit("the rival needs a C compiler, cc or that of the variable CC")
    flags = [*FLAGS, f"-DNUMBER={number}"]
    library = c_library("rival.c", flags)
    sampling, polishing = (
        {
            each: _work(getattr(library, f"{each}_{kind}"), number, polishes=kind == "polished")
            for each in MECHANISMS
        }
        for kind in ("extremes", "polished")
    )
    name = f"C, {' '.join(flags)}, {compiler}"
    return Rival(name, NUMBERS[number], sampling, polishing, _share_out(library.share_out, number))


def _table(number: str) -> Any:
    return np.ctypeslib.ndpointer(NUMBERS[number], 2, flags="C")


def _work(function: Any, number: str, *, polishes: bool) -> Work:
    """A function of the library, for arrays."""
    table, one, count = _table(number), getattr(ctypes, f"c_{number}"), ctypes.c_long
    function.argtypes = [count, table, one, one, count, table, table, *[count, table, count] * polishes]
    function.restype = None

    def work(sizes: Any, sense: float, lift: float, motion: Any, found: Any, *terms: Any) -> None:
        cells = [argument for each in terms for argument in (len(each), each, CELL_SAMPLES)]
        function(len(sizes), sizes, sense, lift, motion.shape[1], motion, found, *cells)

    return work


def _share_out(function: Any, number: str) -> Work:
    indices = np.ctypeslib.ndpointer(np.int32, 1, flags="C")
    function.argtypes, function.restype = [ctypes.c_long, _table(number), indices, _table(number)], None
    return lambda curves, curve_of, found: function(len(found), curves, curve_of, found)
