"""Free laws on disk: the scene that has them, a table of each, what they are seen against; a frontier."""

import csv
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa

from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.unit_systems import INCH, MM, shown_in
from camopt.core.storage.files import whole_file, write_text
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
"""The result in a sentence, in each system of units, by its key in the summary."""


def write_laws(result: "Synthesis", folder: str | os.PathLike[str]) -> list[Path]:
    """Write the scene with the free laws (TOML) and their tables (CSV): unit displacement to jerk; the files.

    Of a move the displacement is from its start, in mm, or deg when oscillating.
    """
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    write_scene(out / SCENE_FILE, result.scene)
    x = np.linspace(0.0, 1.0, LAW_POINTS)
    with whole_file(out / LAWS_FILE) as partial, partial.open("w", newline="", encoding="utf-8") as text:
        rows = csv.writer(text)
        rows.writerow(("law", "x", "s", "velocity", "acceleration", "jerk"))
        for name, law in result.laws.items():
            columns = (x, law.displacement(x), law.velocity(x), law.acceleration(x), law.jerk(x))
            rows.writerows((name, *map(repr, map(float, row))) for row in zip(*columns, strict=True))
    return [out / SCENE_FILE, out / LAWS_FILE]


def write_comparison(result: "Synthesis", known: "KnownLawCams", folder: str | os.PathLike[str]) -> list[Path]:
    """Write the smallest cam of the best known law, if one holds the same limits, and a summary (JSON); the files.

    The summary has the objective, its bound and the gap, the known law, and all of it as a sentence.
    """
    out, about = Path(folder), {"objective": result.objective, "bound": result.bound, "gap": result.gap}
    files = [out / KNOWN_FILE] if known.best else []
    for file in files:
        write_scene(file, known.rows[known.best or ""].scene)
    summary = {**about, "known_law": known.best}
    for system, key in SENTENCE_KEYS.items():
        with shown_in(system):
            summary[key] = bound_in_words(result)
    write_text(out / SUMMARY_FILE, json.dumps(summary, indent=2, allow_nan=False))
    return [*files, out / SUMMARY_FILE]


def write_frontier(found: "Frontier", folder: str | os.PathLike[str]) -> Path:
    """Write ``frontier.parquet``; the file."""
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    write_table(frontier_table(found), out / FRONTIER)
    return out / FRONTIER


def frontier_table(found: "Frontier") -> pa.Table:
    """The free laws, each with its scene, and the known laws, whose ``bound`` and ``scene`` are null, as a table.

    Its metadata name the axes along which the front is of local optima (``camopt_local``).
    """
    rows = [{"free": True, **row} for row in found.rows] + [{"free": False, **row} for row in found.known]
    names = dict.fromkeys(("free", *found.axes, "bound", "law_rise", "law_return", *(n for r in rows for n in r)))
    columns = {name: [row.get(name) for row in rows] for name in names if name != "scene"}
    columns["scene"] = [row.get("scene") for row in rows]
    fields = [
        pa.field(n, pa.array(v).type, metadata=_frontier_column_metadata(n, found)) for n, v in columns.items()
    ]
    about = {
        "camopt_version": VERSION,
        "camopt_scene": found.scene.to_toml(),
        "camopt_local": ",".join(found.local),
    }
    return pa.table([pa.array(v) for v in columns.values()], schema=pa.schema(fields, metadata=about))


def _frontier_column_metadata(name: str, found: "Frontier") -> dict[str, str]:
    """What a column says of itself: of a quantity all, of the axes and the bound the unit."""
    quantity = QUANTITIES.get(name)
    if quantity:
        return {"unit": quantity.unit, "symbol": quantity.symbol, "description": quantity.sentence}
    axis = found.axes[0] if name == "bound" else name
    return {"unit": term_unit(axis, found.scene)} if axis in found.axes else {}
