"""The output of ``camopt effects``."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.tree import Tree

import camopt
from camopt.cli.commands.evaluate_report import as_read
from camopt.cli.terminal import print_json, progress, show
from camopt.problem.rows import Rows, finite
from camopt.quantities.unit_systems import shown_unit
from camopt.scene.read import numbers_read
from camopt.storage.publishing import publication
from camopt.studies.cost_report import cost_report
from camopt.studies.spectrum import SPECTRUM, spectrum, write_spectrum
from camopt.tables.layout import table_of


def show_cost_report(scene: camopt.Scene, as_json: bool, quiet: bool) -> None:
    """The effects that run as a tree, what called for each, and what it costs."""
    with progress(quiet, ""):
        result = cost_report(scene)
    if as_json:
        entries = [{**asdict(entry), "share": round(entry.share, 6)} for entry in result.entries]
        return print_json({"scene": result.scene.name, "effects": entries, "not_called_for": result.idle})
    whole = sum(entry.ns_per_design for entry in result.entries)
    tree = Tree(f"{result.scene.name}: {whole:,.0f} ns per design, over {result.designs:,} designs, one thread")
    if read := numbers_read(result.scene):
        given = tree.add("read from the scene")
        for each in read:
            given.add(f"{each.key} = {as_read(each)} {shown_unit(each.unit)}".rstrip())
    for entry in result.entries:
        branch = tree.add(f"{entry.effect}  {entry.ns_per_design:,.0f} ns per design, {entry.share:.1%}")
        branch.add(f"called for by {', '.join(entry.called_by)}")
        if entry.reads:
            branch.add(f"reads {', '.join(entry.reads)}")
        branch.add(f"writes {', '.join(entry.writes)}")
    for name, keys in result.idle.items():
        needs = f", and needs {', '.join(keys)}" if keys else ""
        tree.add(f"{name}  not called for{needs}")
    return show(tree)


SHOWN_RATIOS = (0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)


def publish_spectrum(scene: camopt.Scene, out: Path) -> tuple[Rows, tuple[Path, ...]]:
    """Compute the response spectra of the laws and write them as a table and a picture; also the files."""
    with publication(out, "effects", SPECTRUM) as unit:
        rows = spectrum(scene)
        write_spectrum(rows, unit.staging)
    return rows, unit.files


def show_spectrum(rows: Rows, as_json: bool) -> None:
    """The residual amplitude in the dwell after each law, at a few period ratios."""
    if as_json:
        return print_json([finite(record) for record in rows.records()])
    laws: dict[str, dict[str, Any]] = {}
    for record in rows.records():
        ratio = round(record["period_ratio"], 9)
        if ratio in SHOWN_RATIOS:
            row = laws.setdefault(record["law"], {"law": record["law"]})
            row[f"{ratio:g}"] = f"{record['residual']:.2g}"
    title = "Residual vibration as a share of the lift, at ratios t₁/Tₙ of the rise time to the natural period"
    return show(table_of(title, list(laws.values()), ["law", *(f"{ratio:g}" for ratio in SHOWN_RATIOS)]))
