"""The output of ``camopt accuracy``."""

from pathlib import Path
from typing import Any

import camopt
from camopt.cli.terminal import print_json, progress, show
from camopt.storage.publishing import publication
from camopt.studies.accuracy import ACCURACY, Costs, measure, write_accuracy
from camopt.tables.layout import table_of


def publish_accuracy(scene: "camopt.Scene", out: Path, engine: Any, quiet: bool) -> tuple[Costs, tuple[Path, ...]]:
    """Measure cost and error of each method and write them as a table and pictures; also the files."""
    with publication(out, "accuracy", ACCURACY) as unit, progress(quiet, "laws") as advance:
        rows = measure(scene, advance, engine)
        write_accuracy(rows, scene, unit.staging)
    return rows, unit.files


def show_accuracy(rows: list[dict[str, Any]], scene: "camopt.Scene", as_json: bool) -> None:
    """Cost and error of each method."""
    if as_json:
        return print_json({"scene": scene.name, "methods": rows})
    names = list(rows[0])
    shown = [{name: f"{row[name]:.2g}" if name in names[4:] else row[name] for name in names} for row in rows]
    for row in shown:
        row |= {"setting": float(f"{row['setting']:.2g}"), "ns_per_design": float(f"{row['ns_per_design']:.3g}")}
    return show(table_of(f"{scene.name}: what accuracy costs", shown, names))
