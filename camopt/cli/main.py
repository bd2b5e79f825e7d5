"""The command line. Each command is one call of the library, and a printer of its result."""

import sys
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import click

from camopt.cli.exits import BAD_INPUT, FILE_TROUBLE, NOT_REACHED, NOTHING_FEASIBLE, run, say
from camopt.cli.options import (
    Axis,
    Command,
    FreeNumber,
    Place,
    Share,
    again_option,
    changed,
    check_file,
    check_folder,
    given_overrides,
    option_of,
    output_options,
    outputs_option,
    override_options,
    refuse_without,
    row_option,
    scene_at,
    scene_options,
    scheduler_option,
    target_at,
)
from camopt.exporting.endings import ENDINGS
from camopt.version import VERSION

DEFAULT_SCENE = "roller-1000rpm"
PICTURES = (".png", ".svg", ".pdf")
ANIMATIONS = (".gif", ".mp4", ".svg")


class Aliased(click.Group):
    """A group that also takes the American spelling."""

    command_class = Command

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        return super().get_command(
            ctx, cmd_name.removesuffix("ize") + "ise" if cmd_name.endswith("ize") else cmd_name
        )


@click.group(cls=Aliased, invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(VERSION, prog_name="camopt")
@click.pass_context
def camopt(context: click.Context) -> None:
    """Find the smallest cam that gives a motion within your limits, and what a smaller one would cost.

    SCENE is a TOML file, or the name of a scene that comes with camopt (`camopt scenes` lists them). Without one,
    commands take roller-1000rpm; evaluate and certify need one.

    Exit codes: 0 done; 1 no feasible design, or a limit is broken; 2 bad input; 3 trouble with a file or memory;
    4 the tolerance was not reached, or a limit is undecided; 70 an error of camopt itself; 129 its
    terminal was closed (SIGHUP); 130 interrupted; 141 the program that read the output has ended; 143 SIGTERM.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def _reached(scene: Any, half_width: float) -> int:
    """The exit code for the accuracy that was reached; a message if it is worse than the tolerance."""
    asked = scene.accuracy.tolerance
    if half_width <= asked:
        return 0
    say(f"camopt: tolerance {asked:g} not reached; values are exact to {half_width:.2g}")
    return NOT_REACHED


@camopt.command()
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@outputs_option
@output_options
@click.option("--base-radius", type=Axis(), help="Base radii to sweep, mm.")
@click.option("--offset", type=Axis(), help="Offsets to sweep, mm, positive to the right.")
@click.option("--roller-radius", type=Axis(), help="Roller radii to sweep, mm.")
@click.option(
    "--vary",
    type=FreeNumber(),
    multiple=True,
    help="Any other number to sweep, by its key, such as follower.dynamics.spring_rate=2:10:1 or arm_length=80.",
)
@click.option("--samples", type=int, help="Draw so many designs for each law, in place of a grid; no steps needed.")
@click.option("--law", multiple=True, help="Motion law to try; repeat the option for several laws.")
@click.option("--out", type=Place(), default="camopt-out", show_default=True, help="Folder for the tables.")
@click.option(
    "--keep", type=click.Choice(("pareto", "feasible", "all", "front-only")), default="feasible", show_default=True,
    help="Which designs to write to designs.parquet; front-only writes none, and decides whole boxes of designs.",
)  # fmt: skip
@click.option("--refine", is_flag=True, help="Move each design of the Pareto front off the grid, to an optimum.")
@click.option(
    "--thin",
    type=float,
    metavar="EPS",
    help="Shorten the Pareto front: leave out rows that are within EPS of one that stays, in every objective "
    "(normalised to 0 to 1).",
)
@click.option("--workers", type=click.IntRange(1), help="Number of threads; one per core by default.")
@click.option(
    "--resume",
    is_flag=True,
    help="Go on with the sweep in the folder, whatever it was asked, or begin. The same command does so anyway.",
)
@click.option(
    "--part", type=Share(), help="Evaluate one of N equal parts, on any machine; `camopt merge` puts them together."
)
@again_option
@scheduler_option
def sweep(
    scene: Any,
    as_json: bool,
    quiet: bool,
    out: Path,
    keep: str,
    workers: int | None,
    resume: bool,
    part: tuple[int, int] | None,
    again: bool,
    engine: Any,
    **asked: Any,
) -> int:
    """Evaluate every design of a grid, or a sample; write the feasible ones and the Pareto front as tables.

    An interrupted sweep keeps what it has done: the same command goes on from there. If it is done already, the
    same command says so.
    """
    from camopt.cli import reports, terminal
    from camopt.cli.resumed import resumed
    from camopt.front.parts import sweep_part
    from camopt.front.sweep import sweep as run

    scene = changed(scene, _searched(**asked))
    if resume:
        scene, keep = resumed(scene, keep, out, part)
    check_folder(scene, out)
    tell = terminal.say_lost if quiet else terminal.say_note
    unit = "boxes of designs" if keep == "front-only" else "designs"
    with terminal.progress(quiet, unit) as advance:
        if part:
            share = sweep_part(scene, part, out, keep, workers, advance, engine, tell, again)
        else:
            whole = run(scene, out, keep, workers, advance, engine=engine, tell=tell, again=again)
    if part:
        reports.show_part(share, as_json)
    else:
        reports.show_sweep(whole, as_json)
    if not quiet:
        terminal.say_unused(scene)
        made = share if part else whole
        terminal.say_written([] if made.already_done else [share.file] if part else whole.files)
    if part:
        return 0
    return _reached(scene, whole.reached) if whole.pareto else NOTHING_FEASIBLE


def _searched(
    law: tuple[str, ...], thin: float | None, refine: bool, vary: tuple[tuple[str, Any], ...], **axes: Any
) -> dict[str, tuple[str, Any]]:
    """What options change in [search]: keys, each with its option and value."""
    changes = {f"search.{key}": (option_of(key), value) for key, value in axes.items() if value is not None}
    changes |= {f"search.{key}": (f"--vary {key}", axis) for key, axis in vary}
    if law:
        changes |= {"search.law": ("--law", list(law))}
        changes |= {f"search.law_{stroke}": ("--law", None) for stroke in ("rise", "return")}
    if thin is not None:
        changes |= {"search.thin": ("--thin", thin)}
    if refine:
        changes |= {"search.refine": ("--refine", True)}
    return changes


@camopt.command()
@click.argument("parts", nargs=-1, required=True, metavar="FOLDER...")
@output_options
@click.option("--out", type=Place(), default="camopt-out", show_default=True, help="Folder for the tables.")
@again_option
def merge(parts: tuple[str, ...], as_json: bool, quiet: bool, out: Path, again: bool) -> int:
    """Put the parts of a sweep together: the tables that one run would have written.

    FOLDERs hold what `camopt sweep --part` wrote, in them or in folders inside them.
    """
    from camopt.cli import reports, terminal
    from camopt.front.parts import merge as run

    with terminal.progress(quiet, "designs") as advance:
        result = run(parts, out, advance, terminal.say_lost if quiet else terminal.say_note, again)
    reports.show_sweep(result, as_json)
    if not quiet:
        terminal.say_written([] if result.already_done else result.files)
    return _reached(result.scene, result.reached) if result.pareto else NOTHING_FEASIBLE


NO_TIME = 1e-3  # seconds: where none are left, bounds have prices, and nothing is sought without them


@camopt.command()
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@outputs_option
@output_options
@click.option("--out", type=Place(), help="Folder to write the smallest cam of each law to, as a scene (TOML).")
@click.option(
    "--seconds",
    type=click.FloatRange(0, min_open=True),
    default=60,
    show_default=True,
    help="Time for the searches. After it, the smallest cam so far is shown, and how much smaller one might be.",
)
@again_option
def optimise(scene: Any, as_json: bool, quiet: bool, out: Path | None, seconds: float, again: bool) -> int:
    """Find the smallest cam of each motion law that meets every limit."""
    from camopt.cli import reports, terminal
    from camopt.cli.once import Once, Told, once
    from camopt.numerics.clock import now
    from camopt.scene.oddities import no_wall
    from camopt.smallest.optimise import optimise as run
    from camopt.smallest.prices import prices
    from camopt.tables.designs import OPTIMUM, write_scenes

    def work(unit: Any) -> Told:
        with terminal.progress(quiet, "laws") as advance:
            end = now() + seconds
            result = run(scene, advance, seconds)
            if unit:
                write_scenes(result.by_law, unit.staging)
            costs = prices(result, max(end - now(), NO_TIME))
        code = _reached(scene, result.best["relative_half_width"]) if result.best else NOTHING_FEASIBLE
        walls = no_wall(scene, result.best.get("base_radius_mm")) if result.best else ()
        return Told(partial(reports.show_optimum, result, costs), code, (*result.warnings, *walls))

    if not quiet:
        terminal.say_unused(scene)
    if out:
        check_folder(scene, out, OPTIMUM)
        made = Once(out, "optimise", (OPTIMUM,), {"seconds": seconds})
        return once(made, scene, again, as_json, quiet, work)
    refuse_without("--out", {"again": again or None})
    told = work(None)
    told.show(as_json)
    if not quiet:
        terminal.say_notes(told.notes)
    return told.code


@camopt.command()
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--out", type=Place(), default="camopt-out", show_default=True, help="Folder for the scene and the laws."
)
@click.option(
    "--plot",
    "picture",
    type=Place(*PICTURES),
    help="Draw the cams of new and known laws: PNG, SVG, PDF.",
)
@again_option
def synthesise(scene: Any, as_json: bool, quiet: bool, out: Path, picture: Path | None, again: bool) -> int:
    """Compute new motion laws (B-splines) that allow the smallest cam."""
    from camopt.cli import reports, terminal
    from camopt.cli.once import Once, Told, once
    from camopt.synthesis.compare import compared
    from camopt.synthesis.files import SCENE, SYNTHESIS, write_comparison, write_laws
    from camopt.synthesis.prices import synthesis_prices
    from camopt.synthesis.synthesise import synthesise as run

    def work(unit: Any) -> Told:
        with terminal.progress(quiet, "starts") as advance:
            result = run(scene, advance)
            known = compared(scene)
            write_laws(result, unit.staging)
            write_comparison(result, known, unit.staging)
            costs = synthesis_prices(result)
        if picture:
            from camopt.drawing.synthesis import plot_synthesis

            plot_synthesis(result, picture, known)
        code = _reached(scene, result.design["relative_half_width"])
        return Told(partial(reports.show_synthesis, result, known, costs), code)

    check_folder(scene, out, SCENE)
    code = once(Once(out, "synthesise", SYNTHESIS, {}), scene, again or bool(picture), as_json, quiet, work)
    if picture and not quiet:
        terminal.say_written([picture])
    return code


@camopt.command()
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--axes",
    default="size,acceleration",
    show_default=True,
    help="What to trade off: two or three terms or loads.",
)
@click.option(
    "--points",
    type=click.IntRange(2, 500),
    default=24,
    show_default=True,
    help="Number of values for each axis but the first.",
)
@click.option(
    "--out", type=Place(), default="camopt-out", show_default=True, help="Folder for the table and the picture."
)
@click.option("--workers", type=click.IntRange(1), help="Number of processes; one per core by default.")
@again_option
@scheduler_option
def frontier(
    scene: Any,
    as_json: bool,
    quiet: bool,
    axes: str,
    points: int,
    out: Path,
    workers: int | None,
    again: bool,
    engine: Any,
) -> int:
    """Show the trade-off between size and acceleration, or other terms and loads, with new motion laws."""
    from camopt.cli import reports, terminal
    from camopt.cli.once import Once, Told, once
    from camopt.drawing.frontier import plot_frontier
    from camopt.synthesis.files import FRONTIER, PICTURE, write_frontier
    from camopt.synthesis.frontier import frontier as run

    traded = [axis.strip() for axis in axes.split(",")]

    def work(unit: Any) -> Told:
        with terminal.progress(quiet, "points") as advance:
            tell = None if quiet else terminal.say_note
            found = run(scene, traded, points, workers, advance, engine, tell)
            write_frontier(found, unit.staging)
            plot_frontier(found, unit.path(PICTURE))
        return Told(partial(reports.show_frontier, found), 0 if found.rows else NOTHING_FEASIBLE)

    made = Once(out, "frontier", (FRONTIER, PICTURE), {"axes": traded, "points": points})
    return once(made, scene, again, as_json, quiet, work)


@camopt.command()
@click.argument("scene")
@scene_options
@outputs_option
@output_options
@click.option(
    "--plot",
    "picture",
    type=Place(*dict.fromkeys((*PICTURES, *ANIMATIONS))),
    help="Draw the cam and its diagrams: PNG, SVG, PDF; GIF and MP4 are animated.",
)
@click.option("--animate", "animation", type=Place(*ANIMATIONS), help="Draw the cam turning: GIF, MP4, SVG.")
@click.option("--points", type=Place(".csv", ".parquet", ".xlsx"), help="Write points: CSV, Parquet, Excel.")
@click.option("--cutter-radius", type=float, help="With --points: also the path of a cutter of this radius, mm.")
@click.option("--step", type=float, help="With --points: degrees between points; 1 by default.")
@click.option(
    "--chord",
    type=float,
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
    from camopt.cli import reports, terminal
    from camopt.verdicts.evaluation import evaluate as run

    if not points:
        refuse_without("--points", spacing)
    with terminal.progress(quiet, ""):
        result = run(scene)
    still = picture and picture.suffix.lower() in PICTURES
    for moving in filter(None, (animation, None if still else picture)):
        from camopt.drawing.animation import animate

        animate(scene, moving)
    if picture and still:
        from camopt.drawing.figures import plot

        plot(scene, picture)
    if points:
        from camopt.points.points import write_points

        write_points(scene, points, **spacing)
    reports.show_evaluation(result, as_json)
    if not quiet:
        terminal.say_notes(result.warnings)
        terminal.say_unused(scene)
        terminal.say_written([file for file in (picture, animation, points) if file])
    return _reached(scene, result["relative_half_width"])


@camopt.command()
@click.argument("scene")
@click.argument("file", type=Place(*ENDINGS))
@scene_options
@output_options
@click.option("--chord", type=float, help="Largest deviation from the true curve, mm; 0.001 by default.")
@click.option("--curves", help="What curves are made of: arcs (the default), spline or polyline.")
@click.option("--cutter-radius", type=float, help="Also the path of a cutter or grinding wheel of this radius, mm.")
@click.option("--step", type=float, help="Points in even steps of the angle, deg.")
@click.option("--points", type=int, help="Number of points of an electronic cam; 361 by default.")
@click.option("--feed", type=float, help="Feed of a cutter, mm/min.")
@click.option(
    "--depth", type=float, help="Depth of the cut below the top face, mm; the thickness and 1 by default."
)
@click.option("--roughing", type=float, help="A first cut that leaves so much, mm.")
@click.option("--direction", help="climb (the default) or conventional milling.")
def export(scene: Any, file: Path, as_json: bool, quiet: bool, **settings: Any) -> int:
    """Write the cam of one design to FILE for a machine, a person or another program, as its ending says.

    How far the curves in the file are from the true ones is proved, and printed. Options that mean nothing for a
    kind of file are refused.
    """
    from camopt.cli import reports, terminal
    from camopt.exporting.export import export as run

    check_file(scene.file, file, "FILE")
    with terminal.progress(quiet, ""):
        result = run(scene, file, **{name: value for name, value in settings.items() if value is not None})
    reports.show_export(result, as_json)
    if not quiet:
        terminal.say_notes(result.notes)
        terminal.say_written([file])
    return 0


@camopt.command()
@click.argument("what", nargs=-1, required=True, metavar="WHAT...")
@row_option
@override_options
@output_options
@click.option("--out", type=Place(".html"), default="camopt-report.html", show_default=True, help="The page.")
def report(what: tuple[str, ...], row: int | None, as_json: bool, quiet: bool, out: Path, **overrides: Any) -> int:
    """Write one HTML page that shows a result to others: no network, no server, nothing to install.

    WHAT is a scene, or the folder or table that a command wrote. A cam turns under its follower, with diagrams,
    limits, proofs and files; up to four are shown side by side. Tables of designs can be filtered, sorted and
    clicked on.
    """
    from camopt.cli import terminal
    from camopt.reporting.report import report as run

    changes = given_overrides(overrides)
    shown = [target_at(target, row, changes) for target in what]
    for each in shown:
        if hasattr(each, "file"):
            check_file(each.file, out)
    with terminal.progress(quiet, ""):
        run(shown, out)
    if as_json:
        terminal.print_json({"file": str(out)})
    elif not quiet:
        terminal.say_written([out])
    return 0


@camopt.command()
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port to listen on; by default a free one.")
@click.option("--folder", type=Place(), help="Folder for what is saved; by default that of SCENE, or this one.")
@click.option("--no-browser", is_flag=True, help="Only print the address.")
def serve(scene: Any, as_json: bool, quiet: bool, port: int, folder: Path | None, no_browser: bool) -> int:
    """Show a cam with sliders for sizes, laws and limits, in a browser on this machine alone.

    Each move draws the cam and its diagrams anew; where the sliders rest, the limits are proved. Ctrl-C ends it.
    """
    import webbrowser
    from threading import Thread

    from camopt.cli import interrupts, terminal
    from camopt.serving.server import serving

    place = Path(scene.file).parent if Path(scene.file).is_file() else Path()
    server = serving(scene, folder or place, port, say)
    with suppress(KeyboardInterrupt), server:
        if as_json:
            terminal.print_json({"address": server.address})
        else:
            click.echo(f"{server.address}\nCtrl-C ends it.")
        sys.stdout.flush()
        if not no_browser:  # in a thread of its own, for some browsers run in this terminal until they are closed
            Thread(target=webbrowser.open, args=[server.first_address], daemon=True).start()
        server.serve_forever()
    return 0 if interrupts.code() == interrupts.CTRL_C else interrupts.code()


@camopt.command()
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--out", type=Place(), default="camopt-out", show_default=True, help="Folder for the table and the pictures."
)
@click.option("--workers", type=click.IntRange(1), help="Number of processes of --scheduler local.")
@again_option
@scheduler_option
def accuracy(
    scene: Any, as_json: bool, quiet: bool, out: Path, workers: int | None, again: bool, engine: Any
) -> int:
    """Measure how much time accuracy costs, as a table and a picture."""
    from camopt.cli import reports, terminal
    from camopt.cli.once import Once, Told, once
    from camopt.studies.accuracy import ACCURACY, measure, write_accuracy

    if engine is None:
        refuse_without("--scheduler", {"workers": workers})

    def work(unit: Any) -> Told:
        with terminal.progress(quiet, "laws") as advance:
            rows = measure(scene, advance, engine)
            write_accuracy(rows, scene, unit.staging)
        return Told(partial(reports.show_accuracy, rows, scene), 0)

    return once(Once(out, "accuracy", ACCURACY, {}), scene, again, as_json, quiet, work)


@camopt.command()
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@output_options
@click.option(
    "--spectrum",
    is_flag=True,
    help="Compute response spectra of the motion laws instead.",
)
@click.option(
    "--out", type=Place(), default="camopt-out", show_default=True, help="With --spectrum: folder for its files."
)
@again_option
def effects(scene: Any, as_json: bool, quiet: bool, spectrum: bool, out: Path, again: bool) -> int:
    """Show which computations (effects) a scene needs, why, and how long each takes."""
    from camopt.cli import reports, terminal

    if spectrum:
        from camopt.cli.once import Once, Told, once
        from camopt.studies.spectrum import SPECTRUM, write_spectrum
        from camopt.studies.spectrum import spectrum as spectra

        def work(unit: Any) -> Told:
            rows = spectra(scene)
            write_spectrum(rows, unit.staging)
            return Told(partial(reports.show_spectrum, rows), 0)

        return once(Once(out, "effects", SPECTRUM, {}), scene, again, as_json, quiet, work)
    refuse_without("--spectrum", {"again": again or None})
    from camopt.studies.cost_report import cost_report

    with terminal.progress(quiet, ""):
        result = cost_report(scene)
    reports.show_cost_report(result, as_json)
    return 0


@camopt.command()
@click.argument("target")
@override_options
@row_option
@output_options
def certify(target: str, as_json: bool, quiet: bool, row: int | None, **overrides: Any) -> int:
    """Prove that the limits are met at every cam angle, in ball arithmetic.

    TARGET is a scene, or a table written by a sweep. The verdict on a limit is "held" (it is proved to be met),
    "broken" (it is proved not to be met) or "undecided". To a table, the verdict on each row is added as a column;
    with --row, only that row is checked, and nothing is written.
    """
    from camopt.cli import reports, terminal

    changes = given_overrides(overrides)
    if target.endswith(".parquet") and row is None:
        from camopt.front.certified import certify_table
        from camopt.mistakes import BadInput, Mistake

        if changes:
            allowed = "is not possible with a table, which has the limits of its sweep"
            given = dict(changes.values())
            raise BadInput([Mistake("camopt", name, value, allowed, bare=True) for name, value in given.items()])
        with terminal.progress(quiet, "rows") as advance:
            counts = certify_table(target, advance)
        reports.show_counts(counts, as_json)
        verdicts = set(counts)
    else:
        from camopt.verdicts.certify import certify as prove

        found = prove(changed(scene_at(target, row), changes))
        reports.show_verdicts(found, as_json)
        verdicts = set(found.values())
    return NOTHING_FEASIBLE if "broken" in verdicts else NOT_REACHED if "undecided" in verdicts else 0


@camopt.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=Place())
@output_options
def check(files: tuple[Path, ...], as_json: bool, quiet: bool) -> int:
    """Check whether files are as camopt wrote them, bit for bit; of those that are not, say where.

    FILE is a table, any other file of a result, or a folder. Tables and parts of sweeps have digests of their own;
    other files of a result are known by manifest.json beside them, and so are files that are missing, or of another
    run.

    Ends with 3 if a file is damaged, changed or missing; else with 2 if there is nothing to check one by.
    """
    from camopt.checking import check as run
    from camopt.cli import reports, terminal

    with terminal.progress(quiet, ""):
        found = run(*files)
    reports.show_checked(found, as_json)
    states = {each.state for each in found}
    return FILE_TROUBLE if states - {"whole", "unknown"} else BAD_INPUT if "unknown" in states else 0


@camopt.command()
@click.argument("a", metavar="A")
@click.argument("b", metavar="B")
@click.option("--out", type=Place(".parquet", ".csv"), help="Table of the designs that differ: Parquet, CSV.")
@click.option("--plot", "picture", type=Place(*PICTURES), help="Draw the fronts: PNG, SVG, PDF.")
@output_options
def compare(a: str, b: str, as_json: bool, quiet: bool, out: Path | None, picture: Path | None) -> int:
    """Compare two results: which designs came, went or changed, how the fronts differ, which settings differ.

    A and B are folders that a command wrote, tables of designs, or scenes; a scene beside a table is compared with
    the scene in it. The exit code is 0 whether or not they differ; --json says it under "same".
    """
    from camopt.cli import terminal
    from camopt.cli.compare_report import show_compared
    from camopt.comparing.compare import compare as run

    result = run(a, b, out)
    if picture:
        from camopt.drawing.compared import plot_compared

        plot_compared(result, picture)
    show_compared(result, as_json)
    if not quiet:
        terminal.say_written([file for file in (out, picture) if file])
    return 0


@camopt.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--scene", "target", help="Scene whose cam, follower and limits to take; its motion is replaced.")
@click.option("--base-radius", type=float, help="Base radius of the cam, mm; of lifts, needed without --scene.")
@click.option(
    "--follower",
    type=click.Choice(("flat", "roller", "knife")),
    help="Translating follower, without --scene; flat by default.",
)
@click.option("--roller-radius", type=float, help="Radius of the roller, mm.")
@click.option("--rpm", type=float, help="Speed of the cam, rev/min.")
@click.option(
    "--profile",
    help="polar or xy: the points are those of a profile, by cam angle and distance from the axis, or x and y.",
)
@click.option(
    "--probe", type=float, help="Radius of the ball whose centres they are, mm; by default they are on the profile."
)
@click.option(
    "--band",
    type=float,
    help="Largest distance of the motion from a point, mm (deg when oscillating); by default from the noise.",
)
@click.option("--columns", help="Names or numbers of the two columns, such as 1,3.")
@click.option("--angle-unit", default="deg", show_default=True, help="Unit of the angles: deg or rad.")
@click.option("--lift-unit", help="Unit of lifts or lengths: mm or inch; deg of lifts when oscillating.")
@click.option(
    "--turn", type=float, help="Angle of one turn of the cam in the file: 720 for degrees of a crankshaft."
)
@click.option("--keep-outliers", is_flag=True, help="Hold the band at outliers too.")
@click.option("--out", type=Place(".toml"), default="fitted.toml", show_default=True, help="Scene to write.")
@click.option("--plot", "picture", type=Place(*PICTURES), help="Draw the fit: PNG, SVG, PDF.")
@output_options
def fit(
    file: Path,
    target: str | None,
    rpm: float | None,
    columns: str | None,
    out: Path,
    picture: Path | None,
    as_json: bool,
    quiet: bool,
    base_radius: float | None,
    follower: str | None,
    roller_radius: float | None,
    profile: str | None,
    probe: float | None,
    **reading: Any,
) -> int:
    """Find the gentlest motion within a band of measured points of a cam, as a scene.

    FILE has columns of cam angle and lift, lifts alone, or points of a --profile, in text or in a workbook.
    """
    from camopt.cli import terminal
    from camopt.cli.fit_report import show_fit
    from camopt.cli.options import measured_cam
    from camopt.files import write_text
    from camopt.measured.fit import fit as run
    from camopt.measured.profile import MeasuredProfile

    check_file(target, out)
    if profile is None:
        refuse_without("--profile", {"probe": probe})
    scene = measured_cam(target, rpm, base_radius, follower, roller_radius, profile)
    chosen = columns and [name.strip() for name in columns.split(",")]
    points = file if profile is None else MeasuredProfile(file, profile, probe or 0.0)
    result = run(points, scene, columns=chosen, **reading)
    write_text(out, result.scene.to_toml())
    if picture:
        from camopt.drawing.fit import plot_fit

        plot_fit(result, picture)
    show_fit(result, as_json)
    if not quiet:
        terminal.say_notes(result.warnings)
        terminal.say_written([out, picture] if picture else [out])
    return 0


@camopt.command()
@output_options
def laws(as_json: bool, quiet: bool) -> int:
    """List the motion laws with their peak velocity, acceleration and jerk."""
    from camopt.cli import reports, terminal

    with terminal.progress(quiet, ""):
        reports.show_laws(as_json)
    return 0


@camopt.command()
@click.argument("name", required=False)
@output_options
def scenes(name: str | None, as_json: bool, quiet: bool) -> int:
    """List the scenes that come with camopt; with a NAME, print that one as TOML."""
    from camopt.cli import reports

    reports.show_scenes(name, as_json)
    return 0


def main(arguments: list[str] | None = None) -> int:
    """Run a command; the exit code. A user's mistake is a message, never a traceback."""
    return run(lambda: camopt.main(arguments, prog_name="camopt", standalone_mode=False) or 0)
