"""``camopt fit``."""

from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.cli.options import (
    PICTURES,
    Command,
    Measure,
    OutputPlace,
    check_file,
    given_overrides,
    options_named,
    output_options,
    refuse_without,
    set_option,
    values_of,
)


@click.command(cls=Command)
@click.argument("file", type=OutputPlace())
@click.option("--scene", "target", help="Scene whose cam, follower and limits to take; its motion is replaced.")
@click.option(
    "--base-radius", type=Measure("mm"), help="Base radius of the cam, mm; of lifts, needed without --scene."
)
@click.option(
    "--follower",
    type=click.Choice(("flat", "roller", "knife")),
    help="Translating follower, without --scene; flat by default.",
)
@click.option("--roller-radius", type=Measure("mm"), help="Radius of the roller, mm.")
@click.option("--rpm", type=float, help="Speed of the cam, rev/min.")
@set_option
@click.option(
    "--profile",
    help="polar or xy: the points are those of a profile, by cam angle and distance from the axis, or x and y.",
)
@click.option(
    "--probe",
    type=Measure("mm"),
    help="Radius of the ball whose centres they are, mm; by default they are on the profile.",
)
@click.option(
    "--band",
    type=float,
    help="Largest distance of the motion from a point, mm (deg when oscillating); by default from the noise.",
)
@click.option(
    "--segments",
    help="Order of the motion, such as rise,dwell,return,dwell: decides where it rests; by default the points do.",
)
@click.option("--columns", help="Names or numbers of the two columns, such as 1,3.")
@click.option("--angle-unit", default="deg", show_default=True, help="Unit of the angles: deg or rad.")
@click.option("--lift-unit", help="Unit of lifts or lengths: mm or inch; deg of lifts when oscillating.")
@click.option(
    "--turn", type=float, help="Angle of one turn of the cam in the file: 720 for degrees of a crankshaft."
)
@click.option("--keep-outliers", is_flag=True, help="Hold the band at outliers too.")
@click.option("--out", type=OutputPlace(".toml"), default="fitted.toml", show_default=True, help="Scene to write.")
@click.option("--plot", "picture", type=OutputPlace(*PICTURES), help="Draw the fit: PNG, SVG, PDF.")
@output_options
def fit(
    file: Path,
    target: str | None,
    rpm: float | None,
    settings: tuple[tuple[str, Any], ...],
    columns: str | None,
    segments: str | None,
    out: Path,
    picture: Path | None,
    as_json: bool,
    quiet: bool,
    profile: str | None,
    probe: float | None,
    **options: Any,
) -> int:
    """Find the gentlest motion within a band of measured points of a cam, as a scene.

    FILE has columns of cam angle and lift, lifts alone, or points of a --profile, in text or in a workbook.
    """
    check_file(target, out)
    if profile is None:
        refuse_without("--profile", {"probe": probe})
    changes = given_overrides({"rpm": rpm, "settings": settings})
    if target:
        scene = cli.scene_at(target, None, changes, allowed=library.SCENES)
    else:
        scene = library.unfolded(values_of(changes)) or None
    chosen, order = (given and [name.strip() for name in given.split(",")] for given in (columns, segments))
    points = file if profile is None else camopt.MeasuredProfile(file, profile, probe or 0.0)
    sizes = {"cam.base_radius": "--base-radius", "follower.roller_radius": "--roller-radius"}
    with options_named({**changes, **{key: (option, None) for key, option in sizes.items()}}):
        result = camopt.fit(points, scene, columns=chosen, segments=order, **options)
    library.write_scene(out, result.scene)
    if picture:
        camopt.plot(result, picture)
    return cli.print_result(result, as_json, quiet, filter(None, (out, picture)))
