"""The output of ``camopt optimise``."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from math import isfinite
from pathlib import Path

import camopt
from camopt.cli.commands.sweep_report import show_miss
from camopt.cli.options import check_folder
from camopt.cli.scenes import unused_of
from camopt.cli.terminal import print_json, progress, say_notes, show
from camopt.numerics.clock import now
from camopt.problem.problem import resolve
from camopt.problem.rows import finite
from camopt.quantities.unit_systems import computed, shown, shown_unit
from camopt.scene.oddities import no_wall
from camopt.storage.publishing import publication
from camopt.tables.cells import with_unit
from camopt.tables.designs import OPTIMUM, write_scenes
from camopt.tables.layout import table_of

NO_SECONDS = 1e-9  # over at once: where none are left, bounds have prices, and nothing is sought without them


def publish_optimum(
    scene: camopt.Scene, seconds: float, out: Path | None, quiet: bool
) -> tuple[camopt.Optimum, dict[str, list[camopt.Price]], tuple[Path, ...]]:
    """Find the smallest cam of each law and what bounds cost, and write the cams to a folder; also the files."""
    if out:
        check_folder(scene, out, OPTIMUM)
    if not quiet:
        say_notes((*unused_of(scene), *_other_objectives(scene)))
    written = publication(out, "optimise", (OPTIMUM,)) if out else nullcontext()
    with written as unit, progress(quiet, "laws") as advance:
        end = now() + seconds
        result = camopt.optimise(scene, advance, seconds)
        if unit:
            write_scenes(result.by_law, unit.staging)
        costs = camopt.prices(result, max(end - now(), NO_SECONDS))
    return result, costs, unit.files if unit else ()


def _other_objectives(scene: camopt.Scene) -> Iterator[str]:
    """What to know of objectives that are for sweeps: here the size alone is."""
    named = [*scene.search.minimise, *scene.search.maximise]
    if named and scene.mechanism.body.size_quantity not in named:
        yield f"search: optimise minimises the size, and not {', '.join(named)}, which sweep does"


def notes_of_optimum(result: camopt.Optimum) -> Iterator[str]:
    """What to know of the smallest cams: warnings, and walls that are thin."""
    yield from result.warnings
    if result.best:
        yield from no_wall(result.scene, result.best.get("base_radius_mm"))


def show_optimum(result: camopt.Optimum, costs: Mapping[str, list[camopt.Price]], as_json: bool) -> None:  # noqa: C901
    """The smallest cam of each law, with what binds it, and what that costs."""
    if as_json:
        by_law = {law: finite(row) for law, row in result.by_law.items()}
        best = next(iter(by_law.values()), {})
        miss = finite(result.nearest_miss) if result.nearest_miss else None
        about = {"by_law": by_law, "obstacles": result.obstacles, "nearest_miss": miss}
        prices = {law: [price.to_json() for price in each] for law, each in costs.items()}
        told = {"warnings": list(result.warnings)} if result.warnings else {}
        return print_json({**best, **about, "out_of_time": result.out_of_time, "prices": prices, **told})
    if result.by_law:
        show(result.table())
    for law, obstacle in result.obstacles.items():
        show(f"{law or result.scene.name}: no feasible design; stopped by {obstacle}")
    for law, row in result.by_law.items():
        if not row["proved"]:
            less = with_unit(row["gap_mm"], "mm")
            show(f"{law or result.scene.name}: not proved; a feasible cam may be smaller by up to {less}")
        if not row.get("nominal_proved", True):
            show(f"{law or result.scene.name}: the nominal optimum is not proved; a smaller one may exist")
    size_name = resolve(result.scene).size_name
    for law, row in result.by_law.items():
        if row["clear_above_mm"] > row[size_name]:
            clear = row["clear_above_mm"]
            tried = (
                f"above {with_unit(clear, 'mm')} none that was tried does" if isfinite(clear) else TO_THE_LARGEST
            )
            late = ", and not all were looked at in the time" if result.out_of_time else ""
            show(f"{law or result.scene.name}: larger cams may break a limit again{late}; {tried}.")
    if result.out_of_time:
        show("The search ran out of time; --seconds gives it more.")
    if any(costs.values()):
        _show_prices(costs)
        show(*_unknown(result, [price for each in costs.values() for price in each]))
    if result.nearest_miss and result.out_of_time:
        show_miss(result.nearest_miss, "No feasible design in the time given. The least miss found so far:")
    elif result.nearest_miss:
        show_miss(result.nearest_miss)
    return None


TO_THE_LARGEST = "the largest that was tried does, or cannot be assembled"


def _show_prices(prices: Mapping[str, list[camopt.Price]]) -> None:
    """The price of each bound, the size of the cam without it, and the limits that bind that cam."""
    rows = [{"law": law, **price_in_words(price)} for law, each in prices.items() for price in each]
    names = ["law"] if len(prices) > 1 else []
    names += ["bound", "as set", "price", *(["tightened"] if any(row["tightened"] for row in rows) else [])]
    names += ["size without it", "holds to", "then held by"]
    show("", table_of(COSTS, rows, names))


def _unknown(result: camopt.Optimum, prices: Sequence[camopt.Price]) -> Iterator[str]:
    """Why prices and cams without a limit are not known."""
    ranges = [price for price in prices if price.key.startswith("search.")]
    if any(price.price is None or price.tightened is None for price in prices):
        yield f"{UNKNOWN_PRICE} as a price: what has no bound, such as no undercut, holds the cam as well."
    if any(price.next is None and price not in ranges for price in prices):
        late = "that cam was not found and proved in the time; --seconds gives more"
        yield f"{UNKNOWN_PRICE} without a limit or tolerance: {late}."
    if any(price.next is None for price in ranges):
        yield f"{UNKNOWN_PRICE} without the end of a range: it is not sought."


COSTS, UNKNOWN_PRICE = "What each bound costs", "—"


def price_in_words(price: camopt.Price, of: str = "mm") -> dict[str, str]:
    """A price as a row of texts; ``of`` is the unit of what is minimised."""
    unit = f"{shown_unit(of)} per {shown_unit(price.unit) or 'unit'}".lstrip()

    def cost(value: float | None) -> str:
        if value is None:
            return UNKNOWN_PRICE
        return f"{computed(shown(value, of), price.unit):.4g} {unit}".replace("-", "−")

    def amount(value: float | None, unit: str) -> str:
        return UNKNOWN_PRICE if value is None else with_unit(value, unit).replace("-", "−")

    return {
        "bound": price.key,
        "as set": f"{price.relation} {amount(price.bound, price.unit)}",
        "price": cost(price.price),
        "tightened": "" if price.tightened == price.price else cost(price.tightened),
        "size without it": amount(price.size_without, "mm"),
        "holds to": amount(price.holds_to, price.unit),
        "then held by": UNKNOWN_PRICE if price.next is None else ", ".join(price.next) or "nothing",
    }
