"""The output of ``camopt synthesise``."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import camopt
from camopt.cli.commands.optimise_report import COSTS, price_in_words
from camopt.cli.options import check_folder
from camopt.cli.terminal import print_json, progress, say_notes, show
from camopt.problem.rows import finite
from camopt.storage.publishing import publication
from camopt.synthesis.cams import OWN_MOVES
from camopt.synthesis.compare import KnownLaws, known_laws_of
from camopt.synthesis.files import SCENE_FILE, SYNTHESIS, write_comparison, write_laws
from camopt.synthesis.from_scene import AMPLE_FACTOR, default_peaks
from camopt.synthesis.ramps import lost_ramps
from camopt.synthesis.told import bound_in_words, size_in_words, why_local
from camopt.synthesis.units import objective_unit
from camopt.tables.cells import with_unit
from camopt.tables.layout import table_of

SHOWN_ZERO = 5e-4  # a share that is shown as 0.0%


def publish_synthesis(
    scene: camopt.Scene, out: Path, picture: Path | None, quiet: bool
) -> tuple[camopt.Synthesis, KnownLaws, list[camopt.Price], list[Path]]:
    """Compute new laws, compare them with known ones, and write and draw both; also the files."""
    check_folder(scene, out, SCENE_FILE)
    if not quiet:
        say_notes(lost_ramps(scene))
    with publication(out, "synthesise", SYNTHESIS) as unit:
        with progress(quiet, "starts") as advance:
            result = camopt.synthesise(scene, advance)
            known = known_laws_of(scene)
            write_laws(result, unit.staging)
            write_comparison(result, known, unit.staging)
            (costs,) = camopt.prices(result).values()
        if picture:
            camopt.plot(result, picture, known=known)
    return result, known, costs, [*unit.files, *([picture] if picture else [])]


def show_synthesis(
    result: camopt.Synthesis, known: KnownLaws, prices: Iterable[camopt.Price], as_json: bool
) -> None:
    """The cam of the free laws beside the smallest of each known law, the bound, the gap, and what bounds cost."""
    defaults = default_peaks(result.asked)
    if as_json:
        return print_json(
            {
                **finite(result.design),
                "objective": result.objective,
                "bound": result.bound,
                "gap": result.gap,
                "convex": result.convex,
                "peaks": {name: finite(peaks) for name, peaks in result.peaks.items()},
                "default_peaks": defaults,
                "known_laws": {law: finite(row) for law, row in known.rows.items()},
                "own_law": known.own,
                "best_known_law": known.best,
                "prices": [price.to_json() for price in prices],
            }
        )
    show(result.table(known.rows))
    unit, what = objective_unit(result.asked), bound_in_words(result)
    if known.beyond:
        show(f"* breaks what the free laws hold: {broken_by_known(known.beyond)}")
    show_limits_of_motion(result.asked, defaults)
    if size := size_in_words(result):
        show(size)
    if robust := _robust_in_words(result.design):
        show(robust)
    show(_beside_known(result, known))
    show(what + ("" if result.convex else f" {why_local(result)}, so the laws are a local optimum."))
    rows = [price_in_words(price, unit) for price in prices]
    if rows:
        show("", table_of(COSTS, rows, ["bound", "as set", "price"]))
    return None


def broken_by_known(beyond: dict[str, str]) -> str:
    """What known laws break, with the names of those that break it where others break something else."""
    laws: dict[str, list[str]] = {}
    for law, broken in beyond.items():
        laws.setdefault(broken, []).append(law)
    if len(laws) == 1:
        return next(iter(laws))
    return "; ".join(f"{broken} ({', '.join(some)})" for broken, some in laws.items())


def show_limits_of_motion(scene: camopt.Scene, defaults: dict[str, float]) -> None:
    """The limits that were taken by default."""
    if not defaults:
        return
    kinds = {segment.segment for segment in scene.motion}
    peaks = " and ".join(f"{name.replace('_', ' ')} {value:.6g}" for name, value in defaults.items())
    limits = []
    if kinds & {"rise", "return"}:
        limits.append(f"the peaks of poly345 are the limits (for unit stroke and angle): {peaks}")
    if "move" in kinds:
        own = " and ".join(name.removeprefix("peak_") for name in defaults)
        limits.append(f"moves may have {AMPLE_FACTOR:g} times the largest {own} of those of least jerk")
    show(f"The scene limits neither acceleration nor jerk, so {'; '.join(limits)}.")


def _robust_in_words(design: Mapping[str, Any]) -> str:
    """Whether every cam within the tolerances holds the limits, and what that costs; "" where it is not asked."""
    if "every_cam" not in design:
        return ""
    told = f"The limits of every cam within the tolerances: {design['every_cam']}."
    if "nominal_mm" not in design:
        return told
    less, nominal = with_unit(design["safety_mm"], "mm"), with_unit(design["nominal_mm"], "mm")
    return f"{told} It is {less} larger for that: the nominal one alone would hold them at {nominal}."


def _beside_known(result: camopt.Synthesis, known: KnownLaws) -> str:
    """The best known law that holds the same limits, and the scene's own."""
    if known.best is None:
        return "No known law meets all these limits."
    value, unit = known.rows[known.best]["objective"], objective_unit(result.asked)
    what = f"The best known law that meets the same limits is {known.best}: {with_unit(value, unit)}"
    if known.best == OWN_MOVES:
        what = f"The scene's own moves meet the same limits: {with_unit(value, unit)}"
    share = 1.0 - result.objective / value if value else 0.0
    less = f"{share:.1%} less" if share > -SHOWN_ZERO else f"{-share:.1%} more"
    what += f"; the free laws need {less}." if value else "."
    own = "" if known.own in (None, known.best) else f" The scene's own, {known.own}: "
    return what + (own and f"{own}{with_unit(known.rows[str(known.own)]['objective'], unit)}.")
