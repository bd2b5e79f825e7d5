"""Commands on one design: its quantities, pictures, files and proof."""

from pathlib import Path
from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.cli.options import (
    ANIMATION_SUFFIXES,
    DEFAULT_SCENE,
    PICTURE_SUFFIXES,
    Command,
    OutputPath,
    RenamedOption,
    UnitNumber,
    output_options,
    outputs_option,
    override_options,
    refuse_scene_file,
    refuse_without,
    row_option,
    scene_options,
    take_overrides,
)
from camopt.core.mistakes import BadInput, Mistake
from camopt.show.exporting.file_types import FILE_TYPES


@click.command(cls=Command)
@click.argument("scene")
@scene_options
@outputs_option
@output_options
@click.option("--long", is_flag=True, help="Print what each quantity is.")
@click.option(
    "--plot",
    "picture",
    type=OutputPath(*dict.fromkeys((*PICTURE_SUFFIXES, *ANIMATION_SUFFIXES))),
    help="Draw the cam and its diagrams: PNG, SVG, PDF; GIF and MP4 are animated.",
)
@click.option(
    "--animate", "animation", type=OutputPath(*ANIMATION_SUFFIXES), help="Draw the cam turning: GIF, MP4, SVG."
)
@click.option("--points", type=OutputPath(".csv", ".parquet", ".xlsx"), help="Write points: CSV, Parquet, Excel.")
@click.option(
    "--cutter-radius", type=UnitNumber("mm"), help="With --points: also the path of a cutter of this radius, mm."
)
@click.option("--step", type=float, help="With --points: degrees between points; 1 by default.")
@click.option(
    "--chord",
    type=UnitNumber("mm"),
    help="With --points: deviation of straight lines from the curve, mm.",
)
def evaluate(
    scene: Any,
    as_json: bool,
    quiet: bool,
    picture: Path | None,
    animation: Path | None,
    points: Path | None,
    long: bool,
    **spacing: float | None,
) -> int:
    """Compute the quantities of one design.

    The first line is the verdict: whether the design meets every limit. --long adds what each quantity is.
    """
    if not points:
        refuse_without("--points", spacing)
    with cli.progress(quiet, ""):
        result = camopt.evaluate(scene)
    still = picture and picture.suffix.lower() in PICTURE_SUFFIXES
    for moving in filter(None, (animation, None if still else picture)):
        camopt.animate(scene, moving)
    if picture and still:
        camopt.plot(scene, picture)
    if points:
        library.write_points(scene, points, **spacing)
    if not quiet and scene.mechanism.further_contacts:
        cli.print_notes(library.notes_on_preload(scene))
    return cli.print_result(result, as_json, quiet, filter(None, (picture, animation, points)), explained=long)


@click.command(cls=Command)
@click.argument("scene")
@click.argument("file", type=OutputPath(*dict.fromkeys((*PICTURE_SUFFIXES, *ANIMATION_SUFFIXES))))
@scene_options
@output_options
@click.option(
    "--construction",
    type=int,
    is_flag=False,
    flag_value=6,
    metavar="[N]",
    help="Draw how the cam is constructed, with N equal parts a stroke (6), and print the table by station.",
)
@click.option("--steps", is_flag=True, help="With --construction: a page of a PDF, or a frame of a GIF, a step.")
def plot(scene: Any, file: Path, as_json: bool, quiet: bool, construction: int | None, steps: bool) -> int:
    """Draw the cam with its diagrams.

    FILE is a PNG, SVG or PDF. A GIF or MP4 shows the cam turning. With --construction the drawing shows the
    construction of the cam with ruler and compasses, as lectures teach it.
    """
    document: dict[str, Any] = {"scene": scene.name, "file": str(file)}
    if construction is None:
        refuse_without("--construction", {"steps": steps or None})
    if construction is None and file.suffix.lower() not in PICTURE_SUFFIXES:
        camopt.animate(scene, file)
    elif construction is None:
        camopt.plot(scene, file)
    else:
        found = camopt.construct(scene, construction)
        camopt.plot(found, file, steps=steps)
        document |= found.to_dict()
        if not (quiet or as_json):
            cli.print_sections(found.table())
    return cli.print_files(document, as_json, quiet, [file])


@click.command(cls=Command)
@click.argument("target")
@override_options
@row_option
@output_options
def certify(target: str, as_json: bool, quiet: bool, row: int | None, **overrides: Any) -> int:
    """Prove that a design meets its limits.

    The proof holds at every cam angle; it uses interval arithmetic. TARGET is a scene, or a table written by a
    sweep. The verdict on a limit is "held" (proved to be met), "broken" (proved not to be met) or "undecided". For
    a table, camopt adds the verdict of each row as a column. With --row it checks that row alone and writes
    nothing.
    """
    changes = take_overrides(overrides)
    if not target.endswith(".parquet") or row is not None:
        allowed = "a TOML file, a shipped scene or a table of designs (.parquet)"
        scene = cli.read_scene(target, row, changes, "target", allowed)
        return cli.print_result(camopt.certify(scene), as_json, quiet)
    if changes:
        allowed = "is not possible with a table, which has the limits of its sweep"
        given = dict(reversed([*changes.values()]))  # of what an option changes, the first is its value
        raise BadInput([Mistake("camopt", name, value, allowed, bare=True) for name, value in given.items()])
    with cli.progress(quiet, "rows") as advance:
        result = library.certify_table(target, advance)
    return cli.print_result(result, as_json, quiet)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--lift",
    "lifts",
    type=float,
    multiple=True,
    help="A lift from the lowest position, mm (deg); repeatable. By default the lash, or else half of the largest.",
)
def timing(scene: Any, as_json: bool, quiet: bool, lifts: tuple[float, ...]) -> int:
    """Find where the follower passes a lift.

    An example is the opening and closing of a valve. For a scene with [tolerances] the table also shows the
    earliest and latest cam angle of a real cam, to first order. A second table shows proven bounds of these angles
    by exact contact, with the errors of a cam that comes near them.
    """
    return cli.print_result(camopt.timing(scene, lifts or None), as_json, quiet)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option("--orders", type=int, default=24, show_default=True, help="How many harmonics.")
@click.option("--plot", "picture", type=OutputPath(*PICTURE_SUFFIXES), help="Draw their amplitudes: PNG, SVG, PDF.")
def harmonics(scene: Any, as_json: bool, quiet: bool, orders: int, picture: Path | None) -> int:
    """Compute the harmonics of a motion and of its acceleration."""
    result = camopt.harmonics(scene, orders)
    if picture:
        camopt.plot(result, picture)
    return cli.print_result(result, as_json, quiet, [picture] if picture else [])


EXPORT_OPTIONS = {
    "Curves and points": ("chord", "curves", "cutter_radius", "step", "points"),
    "Cuts": ("depth", "depth_step", "roughing", "direction", "blank_diameter"),
    "Program": (
        "control",
        "feed",
        "roughing_feed",
        "spindle",
        "tool",
        "coolant",
        "decimals",
        "rotary",
        "largest_radius",
    ),
}


@click.command(cls=Command, groups=EXPORT_OPTIONS)
@click.argument("scene")
@click.argument("file", type=OutputPath(*FILE_TYPES))
@scene_options
@output_options
@click.option("--disc", type=int, help="Of a conjugate pair, the disc that is in the file alone: 1 or 2.")
@click.option("--chord", type=UnitNumber("mm"), help="Largest deviation from the true curve, mm; 0.001 by default.")
@click.option("--curves", help="What curves are made of: arcs (the default), spline or polyline.")
@click.option(
    "--cutter-radius", type=UnitNumber("mm"), help="Also the path of a cutter or grinding wheel of this radius, mm."
)
@click.option("--step", type=float, help="Points, or rows of a drawing's table, in even steps of the angle, deg.")
@click.option(
    "--point-count",
    "points",
    cls=RenamedOption,
    former="--points",
    type=int,
    help="Number of points of an electronic cam; 361 by default.",
)
@click.option("--feed", type=UnitNumber("mm/min"), help="Feed of a cutter, mm/min.")
@click.option(
    "--depth",
    type=UnitNumber("mm"),
    help="Depth of the cut below the top face, mm; the thickness and 1 by default.",
)
@click.option("--roughing", type=UnitNumber("mm"), help="A first cut that leaves so much, mm.")
@click.option("--direction", help="climb (the default) or conventional milling.")
@click.option("--control", help="Whose words a program has: iso, fanuc, siemens or heidenhain; by the ending.")
@click.option("--decimals", type=int, help="Decimals of its coordinates; those of the control by default.")
@click.option("--rotary", help="Axis about which a grooved cylinder turns: A (the default) or C.")
@click.option("--tool", type=int, help="Number of the cutter, for a tool call.")
@click.option("--spindle", type=float, help="Speed of the cutter, rev/min.")
@click.option("--coolant", is_flag=True, default=None, help="Switch the coolant on.")
@click.option(
    "--roughing-feed", type=UnitNumber("mm/min"), help="Feed of first cuts, mm/min; that of --feed by default."
)
@click.option("--depth-step", type=UnitNumber("mm"), help="Largest depth of one cut, mm.")
@click.option(
    "--blank-diameter", type=UnitNumber("mm"), help="Diameter of the blank, mm; as wide as the cam by default."
)
@click.option(
    "--largest-radius", type=UnitNumber("mm"), help="Arcs of a larger radius are lines, mm; 10000 by default."
)
def export(scene: Any, file: Path, as_json: bool, quiet: bool, **settings: Any) -> int:
    """Write the cam of one design to a file.

    The ending of FILE says what it is for: a machine, a person or another program. camopt proves how far the curves
    in the file are from the true ones, and prints it. An option that means nothing for a kind of file is refused.
    """
    refuse_scene_file(scene.file, file, "FILE")
    with cli.progress(quiet, ""):
        result = camopt.export(
            scene, file, **{name: value for name, value in settings.items() if value is not None}
        )
    return cli.print_result(result, as_json, quiet, [file])
