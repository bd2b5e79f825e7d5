"""Certify each row of a table that a sweep wrote."""

import os
import tomllib
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from camopt.files import whole_file
from camopt.mechanisms import SIZES
from camopt.mistakes import BadInput, Mistake
from camopt.proof.certify import certify_design, summary
from camopt.question import Question, resolve
from camopt.scene import Scene
from camopt.search.answer import Progress
from camopt.table import schema

COLUMN = "proof"


def certify_table(path: str | os.PathLike[str], progress: Progress | None = None) -> Counter[str]:
    """Prove or refute the limits of the scene for each row of a table, and add the verdict as the column ``proof``.

    Returns how many rows are held, broken and undecided.

    Raises
    ------
    BadInput
        If the file is no table of a sweep.
    """
    try:
        table = pq.read_table(os.fspath(path), page_checksum_verification=True)
        text = table.schema.metadata[b"camopt_scene"].decode()
    except (FileNotFoundError, IsADirectoryError, pa.ArrowInvalid, KeyError, TypeError):
        allowed = "a Parquet table that camopt sweep wrote"
        raise BadInput([Mistake("camopt", "TARGET", os.fspath(path), allowed)]) from None
    question = resolve(Scene.from_dict(tomllib.loads(text), os.fspath(path)))
    verdicts = []
    for done, row in enumerate(table.to_pylist()):
        if progress:
            progress(done, table.num_rows)
        verdicts.append(summary(_certify_row(question, row)))
    if COLUMN in table.column_names:
        table = table.drop_columns([COLUMN])
    field = schema((COLUMN,), text).field(COLUMN)
    table = table.append_column(field, pa.array(verdicts, type=pa.string()))
    with whole_file(Path(path)) as partial:
        pq.write_table(table, partial, compression="zstd", write_page_checksum=True)
    return Counter(verdicts)


def _certify_row(question: Question, row: dict[str, Any]) -> dict[str, str]:
    named: dict[str, Any] = {name: np.array([row[f"{name}_mm"]]) for name in SIZES if f"{name}_mm" in row}
    design = replace(question.design, **{**named, "size": np.array([row[question.size_name]])})
    laws = [None if "+" in row[name] else row[name] for name in ("law_rise", "law_return")]
    return certify_design(question, question.with_laws(*laws), design)
