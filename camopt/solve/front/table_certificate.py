"""Verdicts with proofs for each row of a table that a sweep wrote."""

import os
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa

from camopt.core.engines.progress import Progress, report_progress
from camopt.core.mistakes import BadInput
from camopt.core.quantities import QUANTITIES
from camopt.core.storage.publishing import finish_interrupted_publication, path_to_revise_file
from camopt.core.storage.tables import not_a_table_error, write_table
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.settings import problems_by_motion_and_setting
from camopt.scene.problem.space import DesignSpace
from camopt.solve.front.certified_front import PROOF_COLUMN
from camopt.solve.front.designs import check_columns_that_define_designs
from camopt.solve.tables.result import Result
from camopt.solve.tables.table import read_arrow_table_checking_types, read_scene_metadata, schema_of
from camopt.solve.verdicts.certify import certify_design_and_tolerance_box, exit_code_of_verdicts
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED, worst_verdict


class TableCertificate(Result, Counter[str]):
    """The numbers of rows of a table that are held, broken and undecided."""

    def sections(self) -> tuple[str]:
        """The counts in words."""
        return (", ".join(f"{count:,} {verdict}" for verdict, count in self.values_for_json().items()),)

    def values_for_json(self) -> dict[str, int]:
        """The counts by verdict."""
        return {verdict: self[verdict] for verdict in (HELD, BROKEN, UNDECIDED)}

    @property
    def exit_code(self) -> int:
        """0 if all rows are held; 1 if a row is broken; 4 if one is undecided."""
        return exit_code_of_verdicts(self)


def certify_table(path: str | os.PathLike[str], progress: Progress | None = None) -> TableCertificate:
    """Prove or refute the limits of the scene for each row of a table, and add the verdict as the column ``proof``.

    With ``search.robust`` a row is held if every cam within the tolerances of its numbers meets each limit. The
    result has the numbers of rows that are held, broken and undecided.

    Raises
    ------
    BadInput
        If the file is not a table of a sweep: it lacks columns that define its designs, has numbers or laws there
        that its scene does not allow, or is damaged.
    Stopped
        If ``progress``, called with (rows done, rows in all), returned False; the table stays as it was.
    OSError
        If there is no such file, it cannot be read or written, or another run writes to its folder.
    """
    finish_interrupted_publication(Path(path).parent)
    table = read_arrow_table_checking_types(path)
    if PROOF_COLUMN in table.column_names:
        table = table.drop_columns([PROOF_COLUMN])
    scene = read_scene_metadata(table.schema, path)
    problem = resolve(scene)
    try:
        check_columns_that_define_designs(scene, table.to_pandas())
    except BadInput as bad:
        raise not_a_table_error(path, f"its designs have mistakes, such as {bad.mistakes[0]}") from None
    rows = DesignRows({name: table[name].to_numpy() for name in table.column_names}, table.num_rows)
    space = DesignSpace(problem, problems_by_motion_and_setting(problem), {})
    verdicts, done = [""] * rows.count, 0
    with path_to_revise_file(path) as place:
        for row_problem, index, designs in space.designs_by_setting(rows):
            for row, number in enumerate(index):
                certified = replace(row_problem, design=designs.take(np.array([row])))
                verdicts[number] = worst_verdict(certify_design_and_tolerance_box(certified).values())
                done += 1
                report_progress(progress, done, rows.count)
        field = schema_of((QUANTITIES[PROOF_COLUMN],)).field(PROOF_COLUMN)
        write_table(table.append_column(field, pa.array(verdicts, type=pa.string())), place)
    return TableCertificate(verdicts)
