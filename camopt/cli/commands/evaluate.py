"""``camopt evaluate``."""

from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.cli.options import (
    ANIMATIONS,
    PICTURES,
    Command,
    Measure,
    OutputPlace,
    output_options,
    outputs_option,
    refuse_without,
    scene_options,
)


@click.command(cls=Command)
@click.argument("scene")
@scene_options
@outputs_option
@output_options
@click.option(
    "--plot",
    "picture",
    type=OutputPlace(*dict.fromkeys((*PICTURES, *ANIMATIONS))),
    help="Draw the cam and its diagrams: PNG, SVG, PDF; GIF and MP4 are animated.",
)
@click.option("--animate", "animation", type=OutputPlace(*ANIMATIONS), help="Draw the cam turning: GIF, MP4, SVG.")
@click.option("--points", type=OutputPlace(".csv", ".parquet", ".xlsx"), help="Write points: CSV, Parquet, Excel.")
@click.option(
    "--cutter-radius", type=Measure("mm"), help="With --points: also the path of a cutter of this radius, mm."
)
@click.option("--step", type=float, help="With --points: degrees between points; 1 by default.")
@click.option(
    "--chord",
    type=Measure("mm"),
    help="With --points: deviation of straight lines from the curve, mm.",
)
def evaluate(
    scene: Any,
    as_json: bool,
    quiet: bool,
    picture: Path | None,
    animation: Path | None,
    points: Path | None,
    **spacing: float | None,
) -> int:
    """Compute every quantity of one design."""
    if not points:
        refuse_without("--points", spacing)
    with cli.progress(quiet, ""):
        result = camopt.evaluate(scene)
    still = picture and picture.suffix.lower() in PICTURES
    for moving in filter(None, (animation, None if still else picture)):
        camopt.animate(scene, moving)
    if picture and still:
        camopt.plot(scene, picture)
    if points:
        library.write_points(scene, points, **spacing)
    if not quiet and scene.mechanism.further:
        cli.say_notes(library.notes_on_preload(scene))
    return cli.print_result(result, as_json, quiet, filter(None, (picture, animation, points)))
