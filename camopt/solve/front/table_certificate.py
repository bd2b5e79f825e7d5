"""Certify each row of a table that a sweep wrote."""

import os
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa

from camopt.core.engines.progress import Progress, report_progress
from camopt.core.mistakes import BadInput
from camopt.core.quantities import QUANTITIES
from camopt.core.storage.publishing import finish_publishing, revision
from camopt.core.storage.tables import no_table_error, write_table
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.settings import problems_by_motion
from camopt.scene.problem.space import DesignSpace
from camopt.solve.front.certified_front import PROOF_COLUMN
from camopt.solve.front.designs import check_designs
from camopt.solve.tables.result import Result
from camopt.solve.tables.table import read_quantities, scene_in, schema_of
from camopt.solve.verdicts.certify import certify_cams, exit_code_of, verdict_of_design
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED


class TableCertificate(Result, Counter[str]):
    """How many rows of a table are held, broken and undecided."""

    def sections(self) -> tuple[str]:
        """The counts."""
        return (", ".join(f"{count:,} {verdict}" for verdict, count in self.document().items()),)

    def document(self) -> dict[str, int]:
        """The counts by verdict."""
        return {verdict: self[verdict] for verdict in (HELD, BROKEN, UNDECIDED)}

    @property
    def exit_code(self) -> int:
        """0 all held; 1 a row is broken; 4 one is undecided."""
        return exit_code_of(self)


def certify_table(path: str | os.PathLike[str], progress: Progress | None = None) -> TableCertificate:
    """Prove or refute the limits of the scene for each row of a table, and add the verdict as the column ``proof``.

    With ``search.robust`` a row is held if every cam within the tolerances of its numbers holds each limit. Returns
    how many rows are held, broken and undecided.

    Raises
    ------
    BadInput
        If the file is no table of a sweep: it lacks columns that tell its designs, has numbers or laws there that
        are none of its scene, or is damaged.
    Stopped
        If ``progress``, called with (rows done, rows in all), returned False; the table stays as it was.
    OSError
        If there is no such file, it cannot be read or written, or another run writes to its folder.
    """
    finish_publishing(Path(path).parent)
    table = read_quantities(path)
    if PROOF_COLUMN in table.column_names:
        table = table.drop_columns([PROOF_COLUMN])
    scene = scene_in(table.schema, path)
    problem = resolve(scene)
    try:
        check_designs(scene, table.to_pandas())
    except BadInput as bad:
        raise no_table_error(path, f"its designs have mistakes, such as {bad.mistakes[0]}") from None
    rows = DesignRows({name: table[name].to_numpy() for name in table.column_names}, table.num_rows)
    space = DesignSpace(problem, problems_by_motion(problem), {})
    with revision(path) as place:
        verdicts = _row_verdicts(space, rows, progress)
        field = schema_of((QUANTITIES[PROOF_COLUMN],)).field(PROOF_COLUMN)
        write_table(table.append_column(field, pa.array(verdicts, type=pa.string())), place)
    return TableCertificate(verdicts)


def _row_verdicts(space: DesignSpace, rows: DesignRows, progress: Progress | None) -> list[str]:
    """The verdict on each row."""
    verdicts, done = [""] * rows.count, 0
    for each, index, designs in space.designs_by_setting(rows):
        for row, number in enumerate(index):
            one = replace(each, design=designs.take(np.array([row])))
            verdicts[number] = verdict_of_design(certify_cams(one))
            done += 1
            report_progress(progress, done, rows.count)
    return verdicts
