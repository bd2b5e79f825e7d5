"""Tolerance classes of ISO 286: the tables against the formulas of the standard, limits in print, and its rules."""

from math import sqrt

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from camopt.scene.iso286 import (
    GRADE_WIDTHS,
    HALF_SIZE_STEPS,
    LARGEST_SIZE,
    SHAFT_LOWER_DEVIATIONS,
    SHAFT_UPPER_DEVIATIONS,
    SIZE_STEPS,
    limit_deviations,
)

MULTIPLES = {
    5: 7,
    6: 10,
    7: 16,
    8: 25,
    9: 40,
    10: 64,
    11: 100,
    12: 160,
    13: 250,
    14: 400,
    15: 640,
    16: 1000,
    17: 1600,
}
FORMULAS = {
    "d": lambda d: 16.0 * d**0.44,
    "e": lambda d: 11.0 * d**0.41,
    "f": lambda d: 5.5 * d**0.41,
    "g": lambda d: 2.5 * d**0.34,
    "h": lambda d: 0.0,
    "n": lambda d: 5.0 * d**0.34,
}
PUBLISHED = [
    ("h6", 30, -13, 0), ("g6", 25, -20, -7), ("f7", 40, -50, -25), ("e8", 60, -106, -60), ("d9", 100, -207, -120),
    ("js6", 50, -8, 8), ("k6", 50, 2, 18), ("m6", 20, 8, 21), ("n6", 30, 15, 28), ("p6", 65, 32, 51),
    ("r6", 70, 43, 62),
    ("s6", 85, 71, 93), ("c11", 45, -290, -130), ("H7", 30, 0, 21), ("H8", 50, 0, 39), ("G7", 25, 7, 28),
    ("F8", 40, 25, 64), ("JS9", 8, -18, 18), ("K7", 25, -15, 6), ("M7", 40, -25, 0), ("N7", 20, -28, -7),
    ("N9", 20, -52, 0), ("P7", 30, -35, -14), ("P9", 8, -51, -15), ("M6", 280, -41, -9), ("K6", 2.5, -6, 0),
]  # fmt: skip
"""Of tables of the standard in handbooks: class, size in mm, limits in µm."""


def middle_of(steps, place):
    """The geometric mean of a range's ends, mm."""
    return sqrt((steps[place - 1]) * steps[place])


@pytest.mark.parametrize("grade", MULTIPLES)
def test_grades_are_those_of_the_formula_but_for_its_rounding(grade):
    """i = 0.45·∛D + 0.001·D µm; up to 3 mm the standard has values of its own."""
    for place, width in [*enumerate(GRADE_WIDTHS[grade])][1:]:
        mean = middle_of(SIZE_STEPS, place)
        unit = 0.45 * mean ** (1 / 3) + 0.001 * mean
        assert width == pytest.approx(MULTIPLES[grade] * unit, rel=0.05, abs=0.7)


@pytest.mark.parametrize("letter", FORMULAS)
def test_letters_are_those_of_the_formulas_but_for_their_rounding(letter):
    for place, value in [*enumerate((SHAFT_UPPER_DEVIATIONS | SHAFT_LOWER_DEVIATIONS)[letter])][1:]:
        assert value == pytest.approx(FORMULAS[letter](middle_of(SIZE_STEPS, place)), rel=0.05, abs=0.7)


def test_other_letters_follow_from_grades():
    """m is IT7 − IT6; p is above IT7 by 0 to 5 µm; r is between p and s."""
    for place, size in [*enumerate(SIZE_STEPS)][1:]:
        assert SHAFT_LOWER_DEVIATIONS["m"][place] == pytest.approx(
            GRADE_WIDTHS[7][place] - GRADE_WIDTHS[6][place], abs=2
        )
        assert 0 <= SHAFT_LOWER_DEVIATIONS["p"][place] - GRADE_WIDTHS[7][place] <= 5
        fine = HALF_SIZE_STEPS.index(size)
        assert SHAFT_LOWER_DEVIATIONS["r"][fine] == pytest.approx(
            sqrt(SHAFT_LOWER_DEVIATIONS["p"][place] * SHAFT_LOWER_DEVIATIONS["s"][fine]), rel=0.04, abs=1
        )


@pytest.mark.parametrize(("name", "size", "lower", "upper"), PUBLISHED)
def test_limits_are_those_in_print(name, size, lower, upper):
    assert limit_deviations(name, size) == pytest.approx((lower / 1e3, upper / 1e3), abs=1e-12)


SIZES = st.floats(0.1, LARGEST_SIZE)


@given(st.sampled_from([*SHAFT_UPPER_DEVIATIONS]), st.integers(1, 18), SIZES)
def test_holes_with_play_are_the_shafts_mirrored(letter, grade, size):
    shaft, hole = limit_deviations(f"{letter}{grade}", size), limit_deviations(f"{letter.upper()}{grade}", size)
    assert (hole.lower, hole.upper) == pytest.approx((-shaft.upper, -shaft.lower))


@given(st.sampled_from([*SHAFT_LOWER_DEVIATIONS]), st.integers(5, 7), st.floats(3.1, LARGEST_SIZE))
def test_a_fine_hole_fits_the_shaft_as_the_shaft_fits_the_hole(letter, grade, size):
    """P7/h6 has the play of H7/p6, and so on; M6 from 250 to 315 mm is the exception of the standard."""
    assume((letter, grade) != ("m", 6) or not 250 < size <= 315)
    hole, shaft = limit_deviations(f"{letter.upper()}{grade}", size), limit_deviations(f"h{grade - 1}", size)
    basic_hole, other = limit_deviations(f"H{grade}", size), limit_deviations(f"{letter}{grade - 1}", size)
    assert hole.upper - shaft.lower == pytest.approx(basic_hole.upper - other.lower)
    assert hole.lower - shaft.upper == pytest.approx(basic_hole.lower - other.upper)


@pytest.mark.parametrize("name", ["", "h", "6", "q7", "h0", "h19", "Hh7", "h6 ", "K9", "P2"])
def test_what_is_no_class_is_told(name):
    with pytest.raises(ValueError, match=r"tolerance class of ISO 286|not a class of holes"):
        limit_deviations(name, 30)


@pytest.mark.parametrize("size", [0, -1, 500.1, float("inf")])
def test_sizes_beyond_the_tables_are_told(size):
    with pytest.raises(ValueError, match="up to 500 mm"):
        limit_deviations("h6", size)
