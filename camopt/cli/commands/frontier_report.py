"""The output of ``camopt frontier``."""

from pathlib import Path
from typing import Any

import camopt
from camopt.cli import terminal
from camopt.cli.commands.synthesise_report import show_limits_of_motion
from camopt.cli.terminal import print_json, show
from camopt.problem.rows import finite
from camopt.quantities.unit_systems import shown
from camopt.storage.publishing import publication
from camopt.synthesis.files import FRONTIER, PICTURE, write_frontier
from camopt.synthesis.from_scene import default_peaks, objective_in
from camopt.synthesis.ramps import lost_ramps
from camopt.tables.cells import number, with_unit


def publish_frontier(
    scene: "camopt.Scene", axes: list[str], points: int, workers: int | None, engine: Any, out: Path, quiet: bool
) -> tuple[camopt.Frontier, tuple[Path, ...]]:
    """Compute a frontier and write it as a table and a picture; also the files."""
    if not quiet:
        terminal.say_notes(lost_ramps(scene))
    with publication(out, "frontier", (FRONTIER, PICTURE)) as unit, terminal.progress(quiet, "points") as advance:
        found = camopt.frontier(scene, axes, points, workers, advance, engine, None if quiet else terminal.say_note)
        write_frontier(found, unit.staging)
        camopt.plot(found, unit.path(PICTURE))
    return found, unit.files


def show_frontier(found: camopt.Frontier, as_json: bool) -> None:
    """The free laws along the frontier, the known laws, and the least value of each axis."""
    defaults = default_peaks(found.scene, found.axes)
    if as_json:
        ends = {
            term: {"free_laws": least, "any_motion": bound, "local": term in found.local}
            for term, (least, bound) in found.least.items()
        }
        every = {"rows": found.rows, "known_laws": found.known}
        tables = {name: [finite(row) for row in rows] for name, rows in every.items()}
        names = {"axes": found.axes, "local": found.local, "default_peaks": defaults}
        return print_json({"scene": found.scene.name, **names, "least": ends, **tables})
    show(found.table() or f"{found.scene.name}: the frontier")
    show("The known laws are on the smallest cams that the limits allow them.")
    if not all(row["within"] for row in found.known):
        show("* breaks what the free laws hold")
    show_limits_of_motion(found.scene, defaults)
    show_other_limits_of_synthesise(found, defaults)
    for term, (least, bound) in found.least.items():
        unit = found.units[term]
        below = "no motion within the other limits has less than"
        most = f"; {below} {number(shown(bound, unit))}" if bound else ""
        local = " (a local optimum)" if term in found.local else ""
        show(f"Least {term}: {with_unit(least, unit)}{local}{most}")
    return None


def show_other_limits_of_synthesise(found: camopt.Frontier, defaults: dict[str, float]) -> None:
    """What ``synthesise`` limits by default for the same scene and this does not, or the other way round."""
    why = "An axis has no limit by default, and neither has what is minimised: synthesise, which minimises"
    minimised, alone = " and ".join(objective_in(found.scene.synthesis)), default_peaks(found.scene)
    more, fewer = alone.keys() - defaults.keys(), defaults.keys() - alone.keys()
    for peaks, words in ((more, "also limits"), (fewer, "does not limit")):
        if peaks:
            which = " and ".join(sorted(name.removeprefix("peak_") for name in peaks))
            show(f"{why} {minimised}, {words} {which}.")
