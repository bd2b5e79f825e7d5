"""``camopt optimise``."""

from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import click

from camopt.cli.exits import NOTHING_FEASIBLE, reached
from camopt.cli.options import (
    DEFAULT_SCENE,
    Command,
    OutputPlace,
    check_folder,
    former_again_option,
    output_options,
    outputs_option,
    scene_options,
)

NO_SECONDS = 1e-9  # over at once: where none are left, bounds have prices, and nothing is sought without them


@click.command(cls=Command)
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
@former_again_option
def optimise(scene: Any, as_json: bool, quiet: bool, out: Path | None, seconds: float) -> int:
    """Find the smallest cam of each motion law that meets every limit."""
    from camopt.cli import terminal
    from camopt.cli.commands.optimise_report import show_optimum
    from camopt.numerics.clock import now
    from camopt.scene.oddities import no_wall
    from camopt.smallest.optimise import optimise as run
    from camopt.smallest.prices import prices
    from camopt.storage.publishing import publication
    from camopt.tables.designs import OPTIMUM, write_scenes

    if out:
        check_folder(scene, out, OPTIMUM)
    if not quiet:
        terminal.say_notes((*terminal.unused_of(scene), *_other_objectives(scene)))
    written = publication(out, "optimise", (OPTIMUM,)) if out else nullcontext()
    with written as unit, terminal.progress(quiet, "laws") as advance:
        end = now() + seconds
        result = run(scene, advance, seconds)
        if unit:
            write_scenes(result.by_law, unit.staging)
        costs = prices(result, max(end - now(), NO_SECONDS))
    show_optimum(result, costs, as_json)
    if not quiet:
        walls = no_wall(scene, result.best.get("base_radius_mm")) if result.best else ()
        terminal.say_notes((*result.warnings, *walls))
        terminal.say_written(unit.files if unit else ())
    return reached(scene, result.best["relative_half_width"]) if result.best else NOTHING_FEASIBLE


def _other_objectives(scene: Any) -> Iterator[str]:
    """What to know of objectives that are for sweeps: here the size alone is."""
    named = [*scene.search.minimise, *scene.search.maximise]
    if named and scene.mechanism.body.size_quantity not in named:
        yield f"search: optimise minimises the size, and not {', '.join(named)}, which sweep does"
