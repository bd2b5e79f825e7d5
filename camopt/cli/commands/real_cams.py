"""Commands on real cams: tolerances, and points measured on a cam."""

import re
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import inf
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
    changed_values_by_key,
    name_options_in_mistakes,
    output_options,
    pop_overrides_as_changes,
    refuse_options_with,
    refuse_options_without,
    refuse_to_overwrite_scene_file,
    refuse_to_overwrite_scene_in_folder,
    scene_options,
    set_option,
    split_at_commas,
)
from camopt.core.mistakes import BadInput, Mistake

BARE_NUMBER = re.compile(r"[-+.\deE]+")
"""A number without a unit."""


TOLERANCE_OPTIONS = {
    "Files": ("picture", "out"),
    "Random cams": ("cams", "within", "seed"),
    "Grades": ("allocate", "costs", "only"),
    "A cam that was cut": (
        "measured",
        "profile",
        "probe",
        "columns",
        "layer",
        "lift_unit",
        "aligned",
        "keep_outliers",
    ),
}


@click.command(cls=Command, groups=TOLERANCE_OPTIONS)
@click.argument("scene")
@scene_options
@output_options
@click.option(
    "--plot", "picture", type=OutputPath(*PICTURE_SUFFIXES), help="Draw the errors over the turn: PNG, SVG, PDF."
)
@click.option(
    "--out",
    type=OutputPath(),
    help="Folder for the worst cams, and for the cam with the grades of --allocate, as scenes (TOML). With "
    "--cams also a table of the cams (Parquet) and histograms (SVG).",
)
@click.option(
    "--cams",
    type=click.IntRange(1, 2**24),
    help="Number of random cams to draw: shows the spread of their motion errors and the yield of each limit.",
)
@click.option(
    "--within",
    metavar="FLOAT",
    help="With --cams: show the share of cams whose tool error stays within this, mm (deg), or with a unit, "
    "such as '0.002 in'.",
)
@click.option(
    "--allocate",
    metavar="FLOAT",
    help="Find the cheapest grades that keep the tool error within ± this, mm (deg), or with a unit.",
)
@click.option(
    "--costs",
    type=OutputPath(),
    help="With --allocate: CSV file of costs. Its columns are grade, and either one column cost "
    "for all keys or one column for each key.",
)
@click.option(
    "--only",
    metavar="KEY",
    multiple=True,
    help="With --allocate: change only this tolerance, such as follower.offset. Repeatable.",
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    help="With --cams: seed of the random numbers; 0 by default.",
)
@click.option(
    "--measured",
    type=OutputPath(),
    multiple=True,
    help="File of points measured on a cut cam: shows the error of this cam in place of the tables. For a "
    "conjugate pair, give one file for each disc.",
)
@click.option(
    "--profile",
    type=click.Choice(("polar", "xy")),
    help="Coordinates of the measured points, as for fit: cam angle and distance from the axis, or x and y.",
)
@click.option(
    "--probe", type=UnitNumber("mm"), help="Radius of the probe ball, mm, if the points are centres of the ball."
)
@click.option("--columns", help="Names or numbers of the two columns to read, such as 1,3.")
@click.option("--layer", help="Layer of the profile, if the measured points are a drawing (DXF).")
@click.option("--lift-unit", help="Unit of the measured points: mm or inch.")
@click.option("--keep-outliers", is_flag=True, help="With --measured: count outliers in the motion error too.")
@click.option(
    "--aligned",
    is_flag=True,
    help="With --measured: take angle 0 of the points as cam angle 0, so that a phase error counts.",
)
def tolerance(
    scene: Any,
    as_json: bool,
    quiet: bool,
    picture: Path | None,
    out: Path | None,
    cams: int | None,
    seed: int | None,
    within: str | None,
    allocate: str | None,
    costs: Path | None,
    only: tuple[str, ...],
    measured: tuple[Path, ...],
    profile: str | None,
    probe: float | None,
    layer: str | None,
    **reading: Any,
) -> int:
    """Find how far the motion of a real cam may deviate.

    The first table shows the worst displacement, velocity and acceleration error within the tolerances of the
    scene. It gives the contribution of each tolerance, the root sum square of independent errors (three standard
    deviations), a proven upper bound, and a cam that comes near this bound. For each limit, the second table
    shows how near the worst cam comes to it, and whether all cams within the tolerances are proved to meet it.

    --cams draws random cams from the distributions of the tolerances. Its tables show the spread of their motions,
    the yield of each limit, and the tolerances that cause the spread. The motions are computed exactly, without a
    linear model.

    --allocate finds the cheapest grades of ISO 286 that keep the tool error within a limit.

    --measured compares points of a cut profile with the scene. Its tables show the motion error of this cam, how
    much of each tolerance it uses, and the amplitudes of the waves of its profile error. For a conjugate pair and a
    yoke they also show the variation of the distance between both contacts, and the smallest interference and
    preload.
    """
    if measured:
        others = {"plot": picture, "out": out, "cams": cams, "seed": seed, "allocate": allocate, "costs": costs}
        refuse_options_with("--measured", {**others, "within": within, "only": only or None})
        profiles = [camopt.MeasuredProfile(file, profile or "", probe or 0.0, layer) for file in measured]
        return _print_inspection(scene, profiles, reading, as_json, quiet)
    read_options = {name: value or None for name, value in reading.items()}  # an absent flag is False
    refuse_options_without("--measured", {"profile": profile, "probe": probe, "layer": layer, **read_options})
    if cams is None:
        refuse_options_without("--cams", {"seed": seed, "within": within})
    if allocate is None:
        refuse_options_without("--allocate", {"costs": costs, "only": only or None})
    if out:
        refuse_to_overwrite_scene_in_folder(scene, out, library.CAM_FILES[0])
    limit, goal = (_parse_tool_error(scene, *pair) for pair in (("--within", within), ("--allocate", allocate)))
    batch = None if cams is None else camopt.sample_cams(scene, cams, seed=seed or 0, within=limit)
    allocation = None if goal is None else camopt.allocate(scene, goal, costs=costs, only=only)
    result = replace(camopt.tolerance(scene), batch=batch, allocation=allocation)
    written = [picture] if picture else []
    if picture:
        camopt.plot(result, picture)
    if out:
        with library.publication(out, "tolerance", library.CAM_FILES) as unit:
            library.write_worst_cams_and_batch(result, unit)
            if result.batch:
                camopt.plot(result.batch, unit.staged_path(library.HISTOGRAM_FILE))
        written += unit.files
    return cli.print_result(result, as_json, quiet, written)


def _parse_tool_error(scene: Any, option: str, text: str | None) -> float | None:
    """The tool error that an option gives [mm or deg]; the text may have another unit."""
    if text is None:
        return None
    unit, value = "deg" if scene.tool_turns else "mm", 0.0
    with suppress(ValueError):
        value = float(text) if BARE_NUMBER.fullmatch(text.strip()) else library.convert_text_to_unit(text, unit)
    if not 0.0 < value < inf:
        why = f"a tool error above 0, in {unit} or with a unit, such as '0.02 {unit}'"
        raise BadInput([Mistake("camopt", option, text, why)])
    return value


def _print_inspection(
    scene: Any,
    profiles: "list[camopt.MeasuredProfile]",
    read_options: dict[str, Any],
    as_json: bool,
    quiet: bool,
) -> int:
    """Show a measured cam against its drawing."""
    columns = read_options.pop("columns")
    chosen = columns and [name.strip() for name in columns.split(",")]
    is_pair = scene.mechanism.further_contacts or len(profiles) > 1
    inspect: Any = partial(camopt.inspect_pair, profiles) if is_pair else partial(camopt.inspect, profiles[0])
    return cli.print_result(inspect(scene, columns=chosen, **read_options), as_json, quiet)


@click.command(cls=Command)
@click.argument("file", type=OutputPath())
@click.option("--scene", "target", help="Scene with the cam, follower and limits; its motion is replaced.")
@click.option(
    "--base-radius", type=UnitNumber("mm"), help="Base radius of the cam, mm; lifts without --scene need it."
)
@click.option(
    "--follower",
    type=click.Choice(("flat", "roller", "knife")),
    help="Contact of a translating follower, if there is no --scene; flat by default.",
)
@click.option("--roller-radius", type=UnitNumber("mm"), help="Radius of the roller, mm.")
@click.option("--rpm", type=float, help="Speed of the cam, rev/min.")
@set_option
@click.option(
    "--profile",
    help="Read points of a profile in place of lifts: polar (cam angle and distance from the axis) or xy.",
)
@click.option(
    "--probe",
    type=UnitNumber("mm"),
    help="Radius of the probe ball, mm, if the points are centres of the ball; by default they are on the profile.",
)
@click.option(
    "--band",
    type=float,
    help="Largest distance of the motion from a point, mm (deg if the follower oscillates); if not "
    "given, camopt estimates it from the noise of the points.",
)
@click.option(
    "--segments",
    callback=split_at_commas,
    help="Order of strokes and dwells, such as rise,dwell,return,dwell; by default found from the points.",
)
@click.option("--layer", help="Layer of the profile, if FILE is a drawing (DXF) with several curves.")
@click.option(
    "--columns", callback=split_at_commas, help="Names or numbers of the two columns to read, such as 1,3."
)
@click.option("--angle-unit", default="deg", show_default=True, help="Unit of the angles: deg or rad.")
@click.option(
    "--lift-unit",
    help="Unit of lifts and lengths: mm or inch, or deg for lifts of an oscillating follower; by default that of "
    "the heading or drawing, else that of --units.",
)
@click.option(
    "--turn", type=float, help="Angle of one cam turn in the file: 720 if the file has crankshaft degrees."
)
@click.option("--keep-outliers", is_flag=True, help="Keep the motion within the band at outliers too.")
@click.option("--out", type=OutputPath(".toml"), default="fitted.toml", show_default=True, help="Scene to write.")
@click.option("--plot", "picture", type=OutputPath(*PICTURE_SUFFIXES), help="Draw the fit: PNG, SVG, PDF.")
@output_options
def fit(
    file: Path,
    target: str | None,
    rpm: float | None,
    settings: tuple[tuple[str, Any], ...],
    out: Path,
    picture: Path | None,
    as_json: bool,
    quiet: bool,
    profile: str | None,
    probe: float | None,
    layer: str | None,
    **options: Any,
) -> int:
    """Fit the gentlest motion to measured points.

    The motion stays within a band around the points. camopt writes it as a scene. FILE is a text file or a workbook
    with columns of cam angle and lift, or with one column of lifts at equal steps. With --profile it has points of
    a profile. It may also be a drawing of the profile (DXF), or a lobe as grinders exchange it (S96).
    """
    refuse_to_overwrite_scene_file(target, out)
    is_profile = any((profile, layer, file.suffix.lower() == ".dxf"))
    if not is_profile:
        refuse_options_without("--profile", {"probe": probe})
    changes = pop_overrides_as_changes({"rpm": rpm, "settings": settings})
    if target:
        scene = cli.read_scene(target, None, changes, allowed_words=library.SCENE_WORDS)
    else:
        scene = library.nest_dotted_keys(changed_values_by_key(changes)) or None
    points = camopt.MeasuredProfile(file, profile or "xy", probe or 0.0, layer) if is_profile else file
    sizes = {"cam.base_radius": "--base-radius", "follower.roller_radius": "--roller-radius"}
    with name_options_in_mistakes({**changes, **{key: (option, None) for key, option in sizes.items()}}):
        result = camopt.fit(points, scene, **options)
    library.write_scene(out, result.scene)
    if picture:
        camopt.plot(result, picture)
    return cli.print_result(result, as_json, quiet, filter(None, (out, picture)))
