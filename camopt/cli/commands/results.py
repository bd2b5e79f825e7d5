"""Commands on results: an HTML page, a page with sliders, a comparison, a check of files."""

import sys
import webbrowser
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

import click

import camopt
from camopt import cli
from camopt.cli import interrupts
from camopt.cli.exits import print_message
from camopt.cli.options import (
    DEFAULT_SCENE,
    PICTURE_SUFFIXES,
    Command,
    OutputPath,
    output_options,
    outputs_option,
    override_options,
    pop_overrides_as_changes,
    refuse_to_overwrite_scene_file,
    row_option,
    scene_or_machine_options,
)


@click.command(cls=Command)
@click.argument("what", nargs=-1, required=True, metavar="WHAT...")
@row_option
@outputs_option
@override_options
@output_options
@click.option(
    "--out", type=OutputPath(".html"), default="camopt-report.html", show_default=True, help="Page to write."
)
@click.option("--full", is_flag=True, help="Print the effects and the scene too; the page has both, folded.")
@click.option(
    "--align-noses", is_flag=True, help="Draw the noses of all cams at the cam angle of the nose of the first."
)
@click.option("--turn", type=float, default=0.0, help="Draw the cams after the first later by this cam angle, deg.")
def report(
    what: tuple[str, ...],
    row: int | None,
    as_json: bool,
    quiet: bool,
    out: Path,
    full: bool,
    align_noses: bool,
    turn: float,
    **overrides: Any,
) -> int:
    """Write a result as one HTML page.

    The page needs only a browser: no network and no server. WHAT is a scene, or a folder or table that a command
    wrote. The page of a cam shows it turning, with diagrams, limits, proofs and files; up to four cams stand
    side by side. On the page of a table, designs can be filtered, sorted and clicked.
    """
    changes = pop_overrides_as_changes(overrides)
    shown = [cli.read_scene_or_result_path(target, row, changes) for target in what]
    for target in shown:
        if hasattr(target, "file"):
            refuse_to_overwrite_scene_file(target.file, out)
    with cli.progress(quiet, ""):
        camopt.report(shown, out, full=full, align_noses=align_noses, turn=turn)
    return cli.print_json_or_files({"file": str(out)}, as_json, quiet, [out])


@click.command(cls=Command)
@click.argument("scene", default=DEFAULT_SCENE)
@scene_or_machine_options
@output_options
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port to listen on; by default a free one.")
@click.option(
    "--folder",
    type=OutputPath(),
    help="Folder for saved scenes and exports; by default the folder of SCENE, or the current one.",
)
@click.option("--no-browser", is_flag=True, help="Print the address, and open no browser.")
def serve(scene: Any, as_json: bool, quiet: bool, port: int, folder: Path | None, no_browser: bool) -> int:
    """Show a cam or a machine with sliders in a browser.

    The sliders change sizes, laws and limits; those of a machine change its phases. Each move redraws the cam and
    its diagrams. When the sliders rest, camopt proves the limits. Only this machine can open the page. Ctrl-C stops
    the server.
    """
    from camopt.show.reporting.server import open_server

    place = Path(scene.file).parent if Path(scene.file).is_file() else Path()
    server = open_server(scene, folder or place, port, print_message)
    with suppress(KeyboardInterrupt), server:
        if as_json:
            cli.print_json({"address": server.address})
        else:
            click.echo(f"{server.address}\nCtrl-C stops the server.")
        sys.stdout.flush()
        if not no_browser:  # in a thread: some browsers run in this terminal until they are closed
            Thread(target=webbrowser.open, args=[server.one_time_address], daemon=True).start()
        server.serve_forever()
    return (
        0 if interrupts.exit_code_of_interrupt() == interrupts.CTRL_C_CODE else interrupts.exit_code_of_interrupt()
    )


@click.command(cls=Command)
@click.argument("a", metavar="A")
@click.argument("b", metavar="B")
@click.option("--out", type=OutputPath(".parquet", ".csv"), help="Write the designs that differ: Parquet, CSV.")
@click.option(
    "--plot", "picture", type=OutputPath(*PICTURE_SUFFIXES), help="Draw both Pareto fronts: PNG, SVG, PDF."
)
@output_options
def compare(a: str, b: str, as_json: bool, quiet: bool, out: Path | None, picture: Path | None) -> int:
    """Compare two results, or two cams.

    A and B are folders that a command wrote, tables of designs, or scenes. The comparison shows the designs that
    are only in A, only in B or changed, how the Pareto fronts differ, and which settings differ. If one is a scene
    and the other a table, camopt compares the scene with the one that made the table. Two scenes with all sizes are
    compared quantity by quantity.

    The exit code is 0 whether or not the results differ; the key "same" of --json says whether they do.
    """
    result = camopt.compare(a, b, out=out)
    if picture:
        camopt.plot(result, picture)
    return cli.print_result(result, as_json, quiet, filter(None, (out, picture)))


@click.command(cls=Command)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=OutputPath())
@output_options
def check(files: tuple[Path, ...], as_json: bool, quiet: bool) -> int:
    """Check that files are as camopt wrote them.

    FILE is a table, another file of a result, or a folder. camopt computes the digest of each
    file and compares it with the recorded one. Tables record their own digest; manifest.json records those of other
    files. camopt also reports missing files and files of another run.

    The exit code is 3 if a file is damaged, changed or missing, and 2 if a file has no digest.
    """
    with cli.progress(quiet, ""):
        result = camopt.check(*files)
    return cli.print_result(result, as_json, quiet)
