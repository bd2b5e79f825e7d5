"""What ``camopt tolerance`` prints."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import camopt
from camopt.cli import terminal
from camopt.cli.commands.tolerance import WORST
from camopt.problem.rows import finite
from camopt.scene.written import write_scene
from camopt.storage.publishing import Publication, publication
from camopt.tolerances.turn import NAMES

ALLOCATED, CAMS, HISTOGRAM = "allocated.toml", "cams.parquet", "cams.svg"
FILES = (WORST.format("*"), ALLOCATED, CAMS, HISTOGRAM)
"""The scenes of the worst motions, of the worst cam of each limit and of --allocate; what each cam of a batch has,
and its picture."""


def publish_cams(
    out: Path, result: camopt.MotionErrors, allocation: camopt.Allocation | None, batch: camopt.Batch | None
) -> tuple[Path, ...]:
    """Write the cams with the worst motions, that of each limit, the one with allocated tolerances, and a batch."""
    with publication(out, "tolerance", FILES) as unit:
        _write(unit, result, allocation, batch)
    return unit.files


def _write(
    unit: Publication, result: camopt.MotionErrors, allocation: camopt.Allocation | None, batch: camopt.Batch | None
) -> None:
    """Write them to a result that is being written."""
    motions = dict(zip(NAMES, ("motion", "motion-velocity", "motion-acceleration"), strict=True))
    for (name, file), each in zip(motions.items(), result.worst_cases, strict=True):
        if each.errors:
            write_scene(unit.path(WORST.format(file)), result.worst_motion(name))
    for margin in result.margins:
        if margin.quantity and margin.worst != margin.nominal:
            write_scene(unit.path(WORST.format(margin.limit)), result.worst_cam(margin.limit))
    if allocation:
        write_scene(unit.path(ALLOCATED), allocation.scene)
    if batch:
        batch.write(unit.path(CAMS))
        camopt.plot(batch, unit.path(HISTOGRAM))


def show_tolerance(
    result: camopt.MotionErrors, batch: camopt.Batch | None, allocation: camopt.Allocation | None
) -> None:
    """Print the tables."""
    tables = [result.table(), result.plays_table(), result.margins_table()]
    if batch:
        tables += [batch.table(), batch.limits_table()]
    if allocation:
        tables.append(allocation.table())
    for table in filter(None, tables):
        terminal.show(table)


def print_tolerance(
    scene: camopt.Scene,
    result: camopt.MotionErrors,
    batch: camopt.Batch | None,
    allocation: camopt.Allocation | None,
) -> None:
    """Print all as JSON."""
    about: dict[str, Any] = {
        "scene": scene.name,
        "errors": [{**finite(each), "shares": finite(each["shares"])} for each in result.records()],
        "worst_case": finite(result.worst_case._asdict()),
        "worst_cases": [
            {"name": each.name, "unit": each.unit, **finite(worst._asdict())}
            for each, worst in zip(result.errors, result.worst_cases, strict=True)
        ],
        "dwells": [{**each._asdict(), "worst_case": finite(each.worst_case._asdict())} for each in result.dwells],
        "reason": result.reason,
        "plays": [finite(each._asdict()) for each in result.plays],
        "margins": [finite(each._asdict()) for each in result.margins],
    }
    if batch:
        about["batch"] = {
            "cams": batch.cams,
            "seed": batch.seed,
            "outside": batch.outside,
            "held": batch.held._asdict(),
            "errors": [
                {**finite(each._asdict()), "held": each.held and each.held._asdict()} for each in batch.errors
            ],
            "limits": [finite(each) for each in batch.records()],
        }
    if allocation:
        about["allocation"] = {
            "within": allocation.within,
            "tolerances": allocation.records(),
            "others": allocation.others,
            "cost": allocation.cost,
            "least_cost": allocation.least_cost,
            "worst_case": allocation.worst_case._asdict(),
        }
    terminal.print_json(about)


def show_measured(found: "Sequence[camopt.Inspection | camopt.PairInspection]") -> None:
    """Print the tables of a measured cam."""
    for each in found:
        terminal.show(each.table())


def print_inspection(found: "camopt.Inspection") -> None:
    """Print what was found of a measured cam as JSON."""
    terminal.print_json(_of_disc(found))


def print_pair(found: "camopt.PairInspection") -> None:
    """Print what was found of a measured cam with two contacts as JSON."""
    discs = [_of_disc(each) for each in found.discs]
    terminal.print_json({"scene": found.scene.name, "discs": discs, "pair": found.records()})


def _of_disc(found: "camopt.Inspection") -> dict[str, Any]:
    return {
        "scene": found.scene.name,
        "error": found.error,
        "at_deg": found.at_deg,
        "unit": found.unit,
        "within": found.within,
        "noise": found.noise,
        "phase_deg": found.phase_deg,
        "size": found.size,
        "eccentricity": found.eccentricity,
        "used": [finite(each) for each in found.records()],
        "waves": [each._asdict() for each in found.waves],
        "outliers": [each._asdict() for each in found.outliers],
        "gaps_deg": found.gaps,
        "unreached_rows": found.unreached,
        "not_counted": found.not_counted,
    }
