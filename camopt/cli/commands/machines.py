"""The command on machines: several cams on one shaft."""

from pathlib import Path

import click

import camopt
from camopt import cli
from camopt.cli.options import PICTURE_SUFFIXES, Command, OutputPath, output_options, refuse_with


@click.command(cls=Command)
@click.argument("machine")
@output_options
@click.option(
    "--plot", "picture", type=OutputPath(*PICTURE_SUFFIXES), help="Draw the timing diagram: PNG, SVG, PDF."
)
@click.option("--fastest", is_flag=True, help="Find the highest speed at which every station holds its limits.")
@click.option(
    "--lift",
    "lifts",
    type=float,
    multiple=True,
    help="Print when each tool is above this lift (mm or deg), and how long two are above it together. Repeatable.",
)
def machine(
    machine: str, as_json: bool, quiet: bool, picture: Path | None, fastest: bool, lifts: tuple[float, ...]
) -> int:
    """Evaluate several cams on one shaft.

    MACHINE is a TOML file with stations, each a scene with its phase, or the name of a machine that comes with
    camopt. The first line is the verdict on all limits and clearances. Tables show the stations, the torque of the
    shaft, the flywheel and the motors.
    """
    if fastest:
        refuse_with("--fastest", {"plot": picture, "lift": lifts or None})
        with cli.progress(quiet, ""):
            return cli.print_result(camopt.fastest_machine(machine), as_json, quiet)
    if lifts:
        refuse_with("--lift", {"plot": picture})
        return cli.print_result(camopt.machine_timing(machine, lifts), as_json, quiet)
    with cli.progress(quiet, ""):
        result = camopt.evaluate_machine(machine)
    if picture:
        camopt.plot(result, picture)
    return cli.print_result(result, as_json, quiet, filter(None, [picture]))
