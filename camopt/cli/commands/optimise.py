"""``camopt optimise``."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import click

from camopt.cli.exits import NOTHING_FEASIBLE, reached
from camopt.cli.once import Once, OnceCommand, Report, once
from camopt.cli.options import (
    DEFAULT_SCENE,
    OutputPlace,
    again_option,
    check_folder,
    output_options,
    outputs_option,
    refuse_without,
    scene_options,
)

NO_SECONDS = 1e-9  # over at once: where none are left, bounds have prices, and nothing is sought without them


@click.command(cls=OnceCommand, place=lambda out, **_: out and (out, "optimise"))
@click.argument("scene", default=DEFAULT_SCENE)
@scene_options
@outputs_option
@output_options
@click.option(
    "--out", type=OutputPlace(), help="Folder to write the smallest cam of each law to, as a scene (TOML)."
)
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
    from camopt.cli import terminal
    from camopt.cli.commands.optimise_report import show_optimum
    from camopt.numerics.clock import now
    from camopt.scene.oddities import no_wall
    from camopt.smallest.optimise import optimise as run
    from camopt.smallest.prices import prices
    from camopt.tables.designs import OPTIMUM, write_scenes

    def work(unit: Any) -> Report:
        with terminal.progress(quiet, "laws") as advance:
            end = now() + seconds
            result = run(scene, advance, seconds)
            if unit:
                write_scenes(result.by_law, unit.staging)
            costs = prices(result, max(end - now(), NO_SECONDS))
        code = reached(scene, result.best["relative_half_width"]) if result.best else NOTHING_FEASIBLE
        walls = no_wall(scene, result.best.get("base_radius_mm")) if result.best else ()
        return Report(partial(show_optimum, result, costs), code, (*result.warnings, *walls))

    before = (*terminal.unused_of(scene), *_other_objectives(scene))
    if out:
        check_folder(scene, out, OPTIMUM)
        made = Once(out, "optimise", (OPTIMUM,), {"seconds": seconds}, before)
        return once(made, scene, again, as_json, quiet, work)
    refuse_without("--out", {"again": again or None})
    terminal.say_notes(() if quiet else before)
    report = work(None)
    report.show(as_json)
    if not quiet:
        terminal.say_notes(report.notes)
    return report.code


def _other_objectives(scene: Any) -> Iterator[str]:
    """What to know of objectives that are for sweeps: here the size alone is."""
    named = [*scene.search.minimise, *scene.search.maximise]
    if named and scene.mechanism.body.size_quantity not in named:
        yield f"search: optimise minimises the size, and not {', '.join(named)}, which sweep does"
