"""Files of a synthesis and of a frontier.

A synthesis writes the scene with its laws, a table of the laws, and a comparison with known laws.
"""

import csv
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa

from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.unit_systems import INCH, MM, shown_in
from camopt.core.storage.files import atomically_written_file, write_text
from camopt.core.storage.tables import write_table
from camopt.core.storage.version import VERSION
from camopt.scene.scene_file import write_scene
from camopt.solve.synthesis.result_sentences import bound_in_words
from camopt.solve.synthesis.term_units import term_unit

if TYPE_CHECKING:
    from camopt.solve.synthesis.frontier_result import Frontier
    from camopt.solve.synthesis.known_law_cams import KnownLawCams
    from camopt.solve.synthesis.synthesis_result import Synthesis

SCENE_FILE, LAWS_FILE, KNOWN_FILE, SUMMARY_FILE = SYNTHESIS = (
    "synthesised.toml",
    "laws.csv",
    "known.toml",
    "synthesis.json",
)
FRONTIER, PICTURE = FRONTIER_FILES = "frontier.parquet", "frontier.png"
LAW_POINTS = 361
SENTENCE_KEYS = {MM: "told", INCH: "told_in_inch"}
"""Keys of the result sentence in the summary, one for each system of units."""


def write_scene_and_laws(result: "Synthesis", folder: str | os.PathLike[str]) -> list[Path]:
    """Write the scene with the free laws (TOML) and a table of them (CSV), and return the files.

    The table has unit displacement to jerk. The displacement of a move is from its start [mm, or deg if
    oscillating].
    """
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    write_scene(out / SCENE_FILE, result.scene)
    x = np.linspace(0.0, 1.0, LAW_POINTS)
    with (
        atomically_written_file(out / LAWS_FILE) as partial,
        partial.open("w", newline="", encoding="utf-8") as text,
    ):
        rows = csv.writer(text)
        rows.writerow(("law", "x", "s", "velocity", "acceleration", "jerk"))
        for name, law in result.laws.items():
            columns = (x, law.displacement(x), law.velocity(x), law.acceleration(x), law.jerk(x))
            rows.writerows((name, *map(repr, map(float, row))) for row in zip(*columns, strict=True))
    return [out / SCENE_FILE, out / LAWS_FILE]


def write_known_cam_and_summary(
    result: "Synthesis", known: "KnownLawCams", folder: str | os.PathLike[str]
) -> list[Path]:
    """Write the cam of the best known law, if one meets the limits, and a summary (JSON), and return the files.

    The summary has the objective, its bound and gap, the known law, and a sentence with all of them.
    """
    out, numbers = Path(folder), {"objective": result.objective, "bound": result.bound, "gap": result.gap}
    files = [out / KNOWN_FILE] if known.best else []
    for file in files:
        write_scene(file, known.rows[known.best or ""].scene)
    summary = {**numbers, "known_law": known.best}
    for system, key in SENTENCE_KEYS.items():
        with shown_in(system):
            summary[key] = bound_in_words(result)
    write_text(out / SUMMARY_FILE, json.dumps(summary, indent=2, allow_nan=False))
    return [*files, out / SUMMARY_FILE]


def write_frontier(found: "Frontier", folder: str | os.PathLike[str]) -> Path:
    """Write ``frontier.parquet`` and return the file."""
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    write_table(frontier_table(found), out / FRONTIER)
    return out / FRONTIER


def frontier_table(result: "Frontier") -> pa.Table:
    """A table of the free laws, each with its scene, and of the known laws, whose ``bound`` and ``scene`` are null.

    Its metadata name the axes along which the front consists of local optima (``camopt_local``).
    """
    rows = [{"free": True, **row} for row in result.rows] + [{"free": False, **row} for row in result.known]
    names = dict.fromkeys(
        ("free", *result.axes, "bound", "law_rise", "law_return", *(name for row in rows for name in row))
    )
    columns = {name: [row.get(name) for row in rows] for name in names if name != "scene"}
    columns["scene"] = [row.get("scene") for row in rows]
    fields = [
        pa.field(name, pa.array(values).type, metadata=_frontier_column_metadata(name, result))
        for name, values in columns.items()
    ]
    about = {
        "camopt_version": VERSION,
        "camopt_scene": result.scene.to_toml(),
        "camopt_local": ",".join(result.local),
    }
    return pa.table([pa.array(values) for values in columns.values()], schema=pa.schema(fields, metadata=about))


def _frontier_column_metadata(name: str, result: "Frontier") -> dict[str, str]:
    """Metadata of a column: unit, symbol and description of a quantity, or the unit of an axis or bound."""
    quantity = QUANTITIES.get(name)
    if quantity:
        return {"unit": quantity.unit, "symbol": quantity.symbol, "description": quantity.sentence}
    axis = result.axes[0] if name == "bound" else name
    return {"unit": term_unit(axis, result.scene)} if axis in result.axes else {}
