"""S96: the lift of a lobe as grinders of camshafts exchange it.

A file has 396 rows of one number with eight decimals: the lift of the tappet [inch] at each degree of the lobe. The
last 36 rows repeat the first.

Source: L&M Engines, Custom Cam Design (description of the format, which is Harvey Crane's).
"""

from dataclasses import replace

import numpy as np

from camopt.solve.measured.columns import LIFT_TABLE, TableReadingOptions
from camopt.solve.measured.number_table import NumberTable, file_mistake

S96_SUFFIX = ".s96"
S96_ROWS, S96_REPEATED = 396, 36
S96_UNIT, S96_DECIMALS = "inch", 8
MOST_REPEAT_DIFFERENCE = 2e-4  # inch: more than what measuring a point twice changes


def lifts_of_s96_turn(
    file: str, table: NumberTable, reading_options: TableReadingOptions
) -> tuple[NumberTable, TableReadingOptions]:
    """The lifts of one turn of an S96 file, and columns that say so.

    Raises
    ------
    BadInput
        If the file has another form.
    """
    if reading_options.kind is not LIFT_TABLE:
        raise file_mistake(file, "file", None, "an S96 file has lifts, not points of a profile")
    if reading_options.lift_unit == "deg":
        raise file_mistake(file, "file", None, "an S96 file has lifts of a translating follower, in inch")
    rows, width = table.numbers.shape
    if (rows, width) != (S96_ROWS, 1):
        numbers = f"{rows} rows of {width} number{'s' * (width > 1)}"
        what = f"an S96 file has {S96_ROWS} lifts, of which the last {S96_REPEATED} repeat the first"
        raise file_mistake(file, "rows", numbers, what)
    turn = S96_ROWS - S96_REPEATED
    differences = np.abs(table.numbers[turn:, 0] - table.numbers[:S96_REPEATED, 0])
    if differences.max() > MOST_REPEAT_DIFFERENCE:
        row, first = (int(table.rows[differences.argmax() + k]) for k in (turn, 0))
        what = f"must repeat row {first}: the last {S96_REPEATED} rows are the first again"
        raise file_mistake(file, f"row {row}", float(table.numbers[turn + differences.argmax(), 0]), what)
    lifts = NumberTable(table.numbers[:turn], table.rows[:turn], table.names)
    return lifts, replace(reading_options, lift_unit=reading_options.lift_unit or S96_UNIT)
