"""The command on machines: several cams on one shaft."""

from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.cli.options import (
    PICTURE_SUFFIXES,
    Command,
    OutputPath,
    UnitNumber,
    output_options,
    refuse_options_with,
)


@click.command(cls=Command)
@click.argument("machine")
@output_options
@click.option(
    "--plot", "picture", type=OutputPath(*PICTURE_SUFFIXES), help="Draw the timing diagram: PNG, SVG, PDF."
)
@click.option("--fastest", is_flag=True, help="Find the highest speed at which every station holds its limits.")
@click.option(
    "--phases", is_flag=True, help="Find the phases in the ranges of [search.phase] with the least peak torque."
)
@click.option(
    "--out",
    type=OutputPath(),
    help="Folder for all files of the machine: drawings, points, solids, timing diagram, page, parts list.",
)
@click.option(
    "--lift",
    "lifts",
    type=UnitNumber("mm"),
    multiple=True,
    help="Print when each tool is above this lift (mm or deg), and how long two are above it together. Repeatable.",
)
def machine(
    machine: str,
    as_json: bool,
    quiet: bool,
    picture: Path | None,
    fastest: bool,
    phases: bool,
    out: Path | None,
    lifts: tuple[float, ...],
) -> int:
    """Evaluate several cams on one shaft.

    MACHINE is a TOML file with stations, each a scene with its phase, or the name of a machine that comes with
    camopt. The first line is the verdict on all limits and clearances. Tables show the stations, the torque of the
    shaft, the flywheel and the motors. With --phases, the files of --out are those of the machine with the new
    phases.
    """
    if fastest:
        refuse_options_with(
            "--fastest", {"plot": picture, "lift": lifts or None, "out": out, "phases": phases or None}
        )
        with cli.progress(quiet, ""):
            return cli.print_result(camopt.fastest_machine(machine), as_json, quiet)
    if lifts:
        refuse_options_with("--lift", {"plot": picture, "out": out, "phases": phases or None})
        return cli.print_result(camopt.machine_timing(machine, lifts), as_json, quiet)
    files = list[Path]()
    with cli.progress(quiet, ""):
        result: Any = camopt.optimise_phases(machine) if phases else camopt.evaluate_machine(machine)
        evaluation = result.evaluation if phases else result
        if picture and evaluation:
            camopt.plot(evaluation, picture)
            files.append(picture)
        if out and evaluation:
            written, notes = library.write_machine_folder(evaluation, out)
            files += written
    if out and evaluation and not quiet:
        cli.print_notes(notes)
    return cli.print_result(result, as_json, quiet, files)
