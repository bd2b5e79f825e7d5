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
    OptionWithFormerName,
    OutputPath,
    UnitNumber,
    output_options,
    outputs_option,
    override_options,
    pop_overrides_as_changes,
    refuse_options_with,
    refuse_options_without,
    refuse_to_overwrite_scene_file,
    row_option,
    scene_options,
    scene_or_machine_options,
)
from camopt.core.mistakes import BadInput, Mistake
from camopt.show.exporting.file_types import FILE_TYPES


@click.command(cls=Command)
@click.argument("scene")
@scene_options
@outputs_option
@output_options
@click.option("--long", is_flag=True, help="Print the meaning of each quantity.")
@click.option("--fastest", is_flag=True, help="Print the highest speed up to which each limit is held instead.")
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
    "--cutter-radius", type=UnitNumber("mm"), help="With --points: add the path of a cutter of this radius, mm."
)
@click.option("--step", type=float, help="With --points: angle between points, deg; 1 by default.")
@click.option(
    "--chord",
    type=UnitNumber("mm"),
    help="With --points: largest deviation of straight lines between points from the curve, mm.",
)
def evaluate(
    scene: Any,
    as_json: bool,
    quiet: bool,
    picture: Path | None,
    animation: Path | None,
    points: Path | None,
    long: bool,
    fastest: bool,
    **spacing: float | None,
) -> int:
    """Compute the quantities of one design.

    The first line is the verdict: whether the design meets every limit. --long adds the meaning of each quantity.
    --fastest prints the highest speed up to which the cam holds each limit, and what this speed gains with the
    bound.
    """
    if not points:
        refuse_options_without("--points", spacing)
    with cli.progress(quiet, ""):
        result = camopt.fastest(scene) if fastest else camopt.evaluate(scene)
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
@click.argument(
    "picture", metavar="FILE", type=OutputPath(*dict.fromkeys((*PICTURE_SUFFIXES, *ANIMATION_SUFFIXES)))
)
@scene_or_machine_options
@output_options
@click.option(
    "--construction",
    type=int,
    is_flag=False,
    flag_value=6,
    metavar="[N]",
    help="Draw the construction with N equal parts a stroke (6 by default), and print its table of stations.",
)
@click.option(
    "--steps", is_flag=True, help="With --construction: give each step its own page (PDF) or frame (GIF)."
)
def plot(scene: Any, picture: Path, as_json: bool, quiet: bool, construction: int | None, steps: bool) -> int:
    """Draw a cam with its diagrams, or a machine.

    FILE is a PNG, SVG or PDF. A GIF or MP4 shows the cam turning. --construction draws the construction of the cam
    with ruler and compasses, as lectures teach it. If a linkage cannot be assembled, FILE shows it as far as it
    goes, with the gap.
    """
    document: dict[str, Any] = {"scene": scene.name, "file": str(picture)}
    if construction is None:
        refuse_options_without("--construction", {"steps": steps or None})
        (camopt.plot if picture.suffix.lower() in PICTURE_SUFFIXES else camopt.animate)(scene, picture)
    else:
        result = camopt.construct(scene, construction)
        camopt.plot(result, picture, steps=steps)
        document |= result.to_dict()
        if not (quiet or as_json):
            cli.print_sections(result.table())
    return cli.print_json_or_files(document, as_json, quiet, [picture])


@click.command(cls=Command)
@click.argument("target")
@override_options
@row_option
@output_options
def certify(target: str, as_json: bool, quiet: bool, row: int | None, **overrides: Any) -> int:
    """Prove that a design meets its limits.

    The proof holds at every cam angle; it uses interval arithmetic. TARGET is a scene, or a table written by a
    sweep. The verdict on a limit is "held" (proved to be met), "broken" (proved not to be met) or "undecided".

    For a table, camopt adds a column with the verdict of each row. --row checks one row and writes nothing.
    """
    changes = pop_overrides_as_changes(overrides)
    if not target.endswith(".parquet") or row is not None:
        allowed = "a TOML file, a shipped scene or a table of designs (.parquet)"
        scene = cli.read_scene(target, row, changes, "target", allowed)
        return cli.print_result(camopt.certify(scene), as_json, quiet)
    if changes:
        why = "cannot be used with a table, which has the limits of its sweep"
        values = dict(reversed([*changes.values()]))  # an option may change several keys: the first has its value
        raise BadInput([Mistake("camopt", name, value, why, bare=True) for name, value in values.items()])
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
    type=UnitNumber("mm"),
    multiple=True,
    help="Lift above the lowest position, mm (deg if the follower oscillates). Repeatable. By default the lash, or "
    "without lash half of the largest lift.",
)
def timing(scene: Any, as_json: bool, quiet: bool, lifts: tuple[float, ...]) -> int:
    """Find where the follower passes a lift.

    An example is the opening and closing of a valve. For a scene with [tolerances] the table also shows the
    earliest and latest cam angle of a real cam, to first order. A second table shows proven bounds of these angles.
    Beside each bound it shows a cam whose errors nearly reach it. The bounds use exact contact, not first order.
    """
    return cli.print_result(camopt.timing(scene, lifts or None), as_json, quiet)


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option("--orders", type=int, default=24, show_default=True, help="Number of harmonics.")
@click.option("--plot", "picture", type=OutputPath(*PICTURE_SUFFIXES), help="Draw the amplitudes: PNG, SVG, PDF.")
def harmonics(scene: Any, as_json: bool, quiet: bool, orders: int, picture: Path | None) -> int:
    """Compute the harmonics of a motion and of its acceleration."""
    result = camopt.harmonics(scene, orders)
    if picture:
        camopt.plot(result, picture)
    return cli.print_result(result, as_json, quiet, [picture] if picture else [])


MACHINE_SUFFIXES = (".toml", ".pdf", ".svg")
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
@scene_or_machine_options
@output_options
@click.option("--disc", type=int, help="Write only this disc of a conjugate pair: 1 or 2.")
@click.option("--chord", type=UnitNumber("mm"), help="Largest deviation from the true curve, mm; 0.001 by default.")
@click.option("--curves", help="Form of curves: arcs (the default), spline or polyline.")
@click.option(
    "--cutter-radius", type=UnitNumber("mm"), help="Add the path of a cutter or grinding wheel of this radius, mm."
)
@click.option("--step", type=float, help="Angle between points, or between rows of a drawing's table, deg.")
@click.option(
    "--point-count",
    "points",
    cls=OptionWithFormerName,
    former="--points",
    type=int,
    help="Number of points of an electronic cam; 361 by default.",
)
@click.option("--feed", type=UnitNumber("mm/min"), help="Feed of a cutter, mm/min.")
@click.option(
    "--depth",
    type=UnitNumber("mm"),
    help="Depth of the cut below the top face, mm; by default 1 mm more than the thickness.",
)
@click.option("--roughing", type=UnitNumber("mm"), help="Add a roughing cut that leaves this much, mm.")
@click.option("--direction", help="Direction of milling: climb (the default) or conventional.")
@click.option(
    "--control",
    help="Control that the program is for: iso, fanuc, siemens or heidenhain; if not given, the ending "
    "of FILE decides.",
)
@click.option(
    "--decimals", type=int, help="Decimals of the coordinates in the program; by default those of the control."
)
@click.option("--rotary", help="Axis about which a grooved cylinder turns: A (the default) or C.")
@click.option("--tool", type=int, help="Tool number of the cutter; adds a tool call.")
@click.option("--spindle", type=float, help="Speed of the cutter, rev/min.")
@click.option("--coolant", is_flag=True, default=None, help="Switch the coolant on.")
@click.option(
    "--roughing-feed", type=UnitNumber("mm/min"), help="Feed of roughing cuts, mm/min; by default --feed."
)
@click.option("--depth-step", type=UnitNumber("mm"), help="Largest depth of one cut, mm.")
@click.option(
    "--blank-diameter", type=UnitNumber("mm"), help="Diameter of the blank, mm; by default that of the cam."
)
@click.option(
    "--largest-radius", type=UnitNumber("mm"), help="Write arcs of a larger radius as lines, mm; 10000 by default."
)
def export(scene: Any, file: Path, as_json: bool, quiet: bool, **settings: Any) -> int:
    """Write the cam of one design to a file.

    The ending of FILE decides what is written: a drawing, a solid, points or a program for a machine. camopt prints
    a proven bound on the distance between the curves in the file and the true curves. It refuses options that a
    kind of file cannot use. A machine gives its timing diagram (PDF, SVG) or one TOML file with its scenes inside.
    """
    if isinstance(scene, camopt.Machine):
        refuse_options_with("a machine", settings)
        if file.suffix.lower() not in MACHINE_SUFFIXES:
            why = f"{', '.join(MACHINE_SUFFIXES)} for a machine; camopt machine --out writes the files of its cams"
            raise BadInput([Mistake("camopt", "FILE", str(file), why)])
        refuse_to_overwrite_scene_file(scene.file, file, "FILE")
        if file.suffix.lower() == ".toml":
            library.write_text(file, scene.with_files_inside().to_toml())
        else:
            camopt.plot(scene, file)
        return cli.print_json_or_files({"machine": scene.name, "file": str(file)}, as_json, quiet, [file])
    refuse_to_overwrite_scene_file(scene.file, file, "FILE")
    with cli.progress(quiet, ""):
        result = camopt.export(
            scene, file, **{name: value for name, value in settings.items() if value is not None}
        )
    return cli.print_result(result, as_json, quiet, [file])
