"""Tolerance classes of ISO 286, such as h6, H7 or js9: the limit deviations of a size.

The letter of a class gives the position of its zone (upper case for holes), the grade its width. The standard
rounds its formulas by rules of its own, so the tables are the source here. Zones of holes mirror those of shafts
from A to H; JS is centred; K to S are mirrored and, in fine grades, moved by Δ = IT(n) − IT(n − 1), so that H7/p6
and P7/h6 have the same clearance.

Source: ISO 286-1:2010, tables 1 to 5.
"""

import re
from bisect import bisect_left
from typing import NamedTuple

LARGEST_SIZE = 500.0
SIZE_STEPS = (3.0, 6.0, 10.0, 18.0, 30.0, 50.0, 80.0, 120.0, 180.0, 250.0, 315.0, 400.0, 500.0)
"""The largest size of each range, mm."""
HALF_SIZE_STEPS = (
    3.0, 6.0, 10.0, 18.0, 30.0, 40.0, 50.0, 65.0, 80.0, 100.0, 120.0, 140.0, 160.0, 180.0, 200.0, 225.0, 250.0,
    280.0, 315.0, 355.0, 400.0, 450.0, 500.0,
)  # fmt: skip
"""The largest size of each half range, for the letters c, r and s, mm."""
GRADE_WIDTHS = {
    1: (0.8, 1, 1, 1.2, 1.5, 1.5, 2, 2.5, 3.5, 4.5, 6, 7, 8),
    2: (1.2, 1.5, 1.5, 2, 2.5, 2.5, 3, 4, 5, 7, 8, 9, 10),
    3: (2, 2.5, 2.5, 3, 4, 4, 5, 6, 8, 10, 12, 13, 15),
    4: (3, 4, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20),
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20, 23, 25, 27),
    6: (6, 8, 9, 11, 13, 16, 19, 22, 25, 29, 32, 36, 40),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46, 52, 57, 63),
    8: (14, 18, 22, 27, 33, 39, 46, 54, 63, 72, 81, 89, 97),
    9: (25, 30, 36, 43, 52, 62, 74, 87, 100, 115, 130, 140, 155),
    10: (40, 48, 58, 70, 84, 100, 120, 140, 160, 185, 210, 230, 250),
    11: (60, 75, 90, 110, 130, 160, 190, 220, 250, 290, 320, 360, 400),
    12: (100, 120, 150, 180, 210, 250, 300, 350, 400, 460, 520, 570, 630),
    13: (140, 180, 220, 270, 330, 390, 460, 540, 630, 720, 810, 890, 970),
    14: (250, 300, 360, 430, 520, 620, 740, 870, 1000, 1150, 1300, 1400, 1550),
    15: (400, 480, 580, 700, 840, 1000, 1200, 1400, 1600, 1850, 2100, 2300, 2500),
    16: (600, 750, 900, 1100, 1300, 1600, 1900, 2200, 2500, 2900, 3200, 3600, 4000),
    17: (1000, 1200, 1500, 1800, 2100, 2500, 3000, 3500, 4000, 4600, 5200, 5700, 6300),
    18: (1400, 1800, 2200, 2700, 3300, 3900, 4600, 5400, 6300, 7200, 8100, 8900, 9700),
}
"""Width of the zone of each grade by size range, µm."""
SHAFT_UPPER_DEVIATIONS = {
    "c": (
        60, 70, 80, 95, 110, 120, 130, 140, 150, 170, 180, 200, 210, 230, 240, 260, 280, 300, 330, 360, 400,
        440, 480,
    ),
    "d": (20, 30, 40, 50, 65, 80, 100, 120, 145, 170, 190, 210, 230),
    "e": (14, 20, 25, 32, 40, 50, 60, 72, 85, 100, 110, 125, 135),
    "f": (6, 10, 13, 16, 20, 25, 30, 36, 43, 50, 56, 62, 68),
    "g": (2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 18, 20),
    "h": (0,) * 13,
}  # fmt: skip
"""Distance of the upper end of a shaft's zone below the size, by size range, µm."""
SHAFT_LOWER_DEVIATIONS = {
    "k": (0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5),
    "m": (2, 4, 6, 7, 8, 9, 11, 13, 15, 17, 20, 21, 23),
    "n": (4, 8, 10, 12, 15, 17, 20, 23, 27, 31, 34, 37, 40),
    "p": (6, 12, 15, 18, 22, 26, 32, 37, 43, 50, 56, 62, 68),
    "r": (10, 15, 19, 23, 28, 34, 34, 41, 43, 51, 54, 63, 65, 68, 77, 80, 84, 94, 98, 108, 114, 126, 132),
    "s": (14, 19, 23, 28, 35, 43, 43, 53, 59, 71, 79, 92, 100, 108, 122, 130, 140, 158, 170, 190, 208, 232, 252),
}
"""Distance of the lower end of a shaft's zone above the size, by size range, µm."""
CENTRED_LETTER = "js"
ZONE_LETTERS = (*SHAFT_UPPER_DEVIATIONS, CENTRED_LETTER, *SHAFT_LOWER_DEVIATIONS)
CLASS_PATTERN = re.compile(r"([a-z]+|[A-Z]+)(\d+)")


class Deviations(NamedTuple):
    """Limit deviations of a size [mm]."""

    lower: float
    upper: float


def limit_deviations(tolerance_class: str, size: float) -> Deviations:
    """Limit deviations of a tolerance class at a size [mm], for sizes up to 500 mm.

    Raises a ValueError that says what is allowed, for a class or a size outside the tables.
    """
    parts = CLASS_PATTERN.fullmatch(tolerance_class)
    letter, grade = (parts[1], int(parts[2])) if parts else ("", 0)
    if letter.lower() not in ZONE_LETTERS or grade not in GRADE_WIDTHS:
        letters = f"a letter ({', '.join(ZONE_LETTERS)}, in capitals for holes)"
        raise ValueError(f"must be a tolerance class of ISO 286: {letters} and a grade, 1 to 18")
    if not 0.0 < size <= LARGEST_SIZE:
        raise ValueError(f"is for sizes above 0 and up to {LARGEST_SIZE:g} mm, not for {size:g} mm")
    width = _value_for_size_step(GRADE_WIDTHS[grade], size)
    if letter.lower() == CENTRED_LETTER:
        return Deviations(-width / 2e3, width / 2e3)
    if letter.isupper():
        lower = _hole_lower_deviation(letter.lower(), grade, size)
    elif letter in SHAFT_UPPER_DEVIATIONS:
        lower = -_value_for_size_step(SHAFT_UPPER_DEVIATIONS[letter], size) - width
    elif letter == "k" and not 4 <= grade <= 7:
        lower = 0.0
    else:
        lower = _value_for_size_step(SHAFT_LOWER_DEVIATIONS[letter], size)
    return Deviations(lower / 1e3, (lower + width) / 1e3)


def _value_for_size_step(values: tuple[float, ...], size: float) -> float:
    """The value in a row of a table for a size."""
    return values[bisect_left(SIZE_STEPS if len(values) == len(SIZE_STEPS) else HALF_SIZE_STEPS, size)]


def _hole_lower_deviation(letter: str, grade: int, size: float) -> float:
    """Lower deviation of a hole [µm]."""
    if letter in SHAFT_UPPER_DEVIATIONS:
        return _value_for_size_step(SHAFT_UPPER_DEVIATIONS[letter], size)
    width, small = _value_for_size_step(GRADE_WIDTHS[grade], size), size <= SIZE_STEPS[0]
    coarse = grade > (8 if letter in "kmn" else 7)
    if grade < 3 or (letter == "k" and coarse and not small):
        raise ValueError("is not a class of holes: the standard has K in grades 3 to 8, and M to S from grade 3")
    if letter == "n" and coarse and not small:
        return -width
    if letter == "m" and grade == 6 and 250.0 < size <= 315.0:
        return -9.0 - width  # an exception of the standard
    change = 0.0 if coarse or small else width - _value_for_size_step(GRADE_WIDTHS[grade - 1], size)
    return change - _value_for_size_step(SHAFT_LOWER_DEVIATIONS[letter], size) - width
