"""What the commands print of their results: tables for people, one JSON document for programs."""

import sys
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from math import isfinite
from typing import TYPE_CHECKING, Any

from rich.table import Table
from rich.tree import Tree

from camopt.cli.terminal import print_json, room_across, show, show_lines, table_of
from camopt.mistakes import BadInput, Mistake, nearest, printable
from camopt.motion import LAWS
from camopt.motion.law import pair_of
from camopt.problem.problem import Problem, resolve
from camopt.problem.rows import Rows, finite
from camopt.quantities import QUANTITIES
from camopt.scene.read import numbers_read
from camopt.tables.cells import number, quantity
from camopt.tables.columns import bounds_of, columns_of, is_nothing, joined_laws, laws_shown, sizes_shown, with_law

if TYPE_CHECKING:  # a report imports what it shows from the command that made it
    from camopt.checking import Checked
    from camopt.exporting.exported import Exported
    from camopt.front.parts import SweepPart
    from camopt.front.sweep import Sweep
    from camopt.scene.scene import Scene
    from camopt.smallest.optimise import Optimum
    from camopt.smallest.prices import Price
    from camopt.studies.cost_report import CostReport
    from camopt.synthesis.compare import Comparison
    from camopt.synthesis.frontier import Frontier
    from camopt.synthesis.synthesised import Synthesised
    from camopt.tables.designs import Design
    from camopt.verdicts.evaluation import Evaluation

SLIGHT = 5e-4  # a share that is shown as 0.0%


def show_evaluation(result: "Evaluation", as_json: bool) -> None:
    """Every quantity of a design, one a line."""
    if as_json:
        return print_json(result.to_json())
    names = [name for name in result if not is_nothing(result.scene, name, [result])]
    explained = room_across() >= ROOM_TO_EXPLAIN
    about = {n: result.unbounded.get(n) or (QUANTITIES[n].sentence if explained else "") for n in names}
    show(_down(result.scene.name, resolve(result.scene), result, about))
    if read := numbers_read(result.scene):
        rows = [{"key": each.key, "value": _as_read(each.value), "unit": each.unit} for each in read]
        show("", table_of("Numbers of the scene, as they are read", rows, ["key", "value", "unit"]))
    return None


def _as_read(value: Any) -> str:
    """A number of the scene; of a load that changes, how many rows it has."""
    return number(value) if isinstance(value, float) else f"{len(value):,} rows"


ROOM_TO_EXPLAIN = 110  # columns of a screen: on a narrower one each sentence would be a column of single words


def _down(title: str, problem: Problem, design: Mapping[str, Any], about: Mapping[str, str]) -> Table:
    """One design as a table down the page: name, value, unit, limit, and a word about each quantity."""
    table = Table(title=title, title_justify="left", show_header=False, box=None, pad_edge=False)
    bounds = bounds_of(problem)
    table.add_column(no_wrap=True)
    table.add_column(style="bold", justify="right")
    table.add_column(no_wrap=True)
    if bounds:
        table.add_column(no_wrap=True)
    table.add_column(style="dim")
    for name, text in about.items():
        limit = [bounds.get(name, "")] if bounds else []
        unit = QUANTITIES[name].unit if name in QUANTITIES else ""
        table.add_row(name, quantity(name, design[name]).replace(",", ", "), unit, *limit, text)
    return table


def show_sweep(result: "Sweep", as_json: bool) -> None:
    """Counts, the best design of each law, and the files."""
    if as_json:
        best = {law: finite(row) for law, row in result.best.items()}
        return print_json(
            {
                "scene": result.scene.name,
                "designs": result.designs,
                "evaluated": result.evaluated,
                "decided_by_boxes": result.decided_by_boxes,
                "impossible": result.impossible,
                "feasible": result.feasible,
                "undecided": result.effort.undecided,
                "looked_at_again": result.effort.again,
                "decided_in_balls": result.effort.balls - result.effort.undecided,
                "pareto": result.pareto,
                "front": result.front.to_dict() if result.front else None,
                "files": [str(file) for file in result.files],
                "best": next(iter(best.values()), None),
                "by_law": best,
                "nearest_miss": finite(result.nearest_miss) if result.nearest_miss else None,
                **({"obstacle": result.obstacle} if result.obstacle else {}),
            }
        )
    undecided = f"{result.effort.undecided:,} undecided, " if result.effort.undecided else ""
    pareto = f"{result.pareto:,} on the Pareto front"
    show(f"{result.scene.name}: {result.designs:,} designs, {_counts(result)}{undecided}{pareto}")
    if result.best:
        problem, search, rows = resolve(result.scene), result.scene.search, with_law(result.best.values())
        names, bounds = columns_of(problem, rows, (*search.minimise, *search.maximise)), bounds_of(problem)
        where = " on the front" if result.feasible is None else ""
        where += " of the grid" if search.refine and where else " on the grid" if search.refine else ""
        show(
            "",
            table_of(
                f"The best design{' of each law' if laws_shown(rows) else ''}{where}",
                rows,
                [*names, "held_by"],
                bounds,
            ),
        )
        _show_front(result, names, bounds)
    elif result.nearest_miss:
        _show_miss(result.nearest_miss)
    elif result.obstacle:
        show(f"No design can be assembled: {result.obstacle}.")
    else:
        show("No feasible design. A sweep with another --keep shows the nearest miss.")
    return None


def show_part(result: "SweepPart", as_json: bool) -> None:
    """Counts of a part of a sweep."""
    if as_json:
        return print_json(
            {
                "scene": result.scene.name,
                "part": result.part,
                "parts": result.parts,
                "designs": result.designs,
                "impossible": result.impossible,
                "feasible": result.feasible,
                "undecided": result.effort.undecided,
                "looked_at_again": result.effort.again,
                "decided_in_balls": result.effort.balls - result.effort.undecided,
                "files": [str(result.file)],
            }
        )
    where = f"part {result.part} of {result.parts}"
    show(f"{result.scene.name}, {where}: {result.designs:,} designs, {result.feasible:,} feasible")
    return None


def _counts(result: "Sweep") -> str:
    """How many designs are impossible and feasible; or, where nobody counted them, how the front was found."""
    if result.feasible is None:
        return f"{result.decided_by_boxes:,} decided by boxes, {result.evaluated:,} evaluated, "
    return f"{result.impossible:,} impossible, {result.feasible:,} feasible, "


def _show_front(result: "Sweep", names: list[str], bounds: Mapping[str, str]) -> None:
    """How much the front dominates, and its knee."""
    front = result.front
    assert front is not None
    volume = f"{'' if front.exact else 'about '}{front.hypervolume:.6g}"
    if front.grid_points is not None:
        volume += f"; of the grid's {front.grid_points:,} points, {front.grid_hypervolume:.6g}"
    show(f"Hypervolume of the Pareto front, as a share: {volume}")
    names = [*laws_shown([front.knee]), *(name for name in names if not name.startswith("law"))]
    show("", table_of("Its knee", with_law([front.knee]), names, bounds))


def _show_miss(miss: "Design") -> None:
    """The design that comes nearest to holding every limit: its sizes, and each limited value beside its limit."""
    problem = resolve(miss.searched)
    (row,) = with_law([miss])
    violated = miss["violated"].split(",")
    broken = {name for limit in problem.limits if limit.name in violated for name in limit.shown}
    about = {name: "broken" if name in broken else "" for name in columns_of(problem, [row])}
    show("", _down("No feasible design. The nearest miss:", problem, row, about))
    show("", f"It breaks {', '.join(violated)}.")


def show_optimum(result: "Optimum", prices: "Mapping[str, list[Price]]", as_json: bool) -> None:
    """The smallest cam of each law, with what binds it, and what that costs."""
    if as_json:
        by_law = {law: finite(row) for law, row in result.by_law.items()}
        best = next(iter(by_law.values()), {})
        miss = finite(result.nearest_miss) if result.nearest_miss else None
        about = {"by_law": by_law, "obstacles": result.obstacles, "nearest_miss": miss}
        costs = {law: [price.to_json() for price in each] for law, each in prices.items()}
        told = {"warnings": list(result.warnings)} if result.warnings else {}
        return print_json({**best, **about, "out_of_time": result.out_of_time, "prices": costs, **told})
    if result.by_law:
        problem, rows = (
            resolve(result.scene),
            [{**row, **_in_words(row)} for row in with_law(result.by_law.values())],
        )
        title = f"{result.scene.name}: the smallest cam{' of each law' if laws_shown(rows) else ''}"
        show(table_of(title, rows, _optimum_columns(problem, rows), bounds_of(problem)))
    for law, obstacle in result.obstacles.items():
        show(f"{law or result.scene.name}: no feasible design; stopped by {obstacle}")
    for law, row in result.by_law.items():
        if not row["proved"]:
            less = f"{number(row['gap_mm'])} mm"
            show(f"{law or result.scene.name}: not proved; a feasible cam may be smaller by up to {less}")
    for law, row in result.by_law.items():
        if row["clear_above_mm"] > row[resolve(result.scene).size_name]:
            upto = (
                f"up to {number(row['clear_above_mm'])} mm" if isfinite(row["clear_above_mm"]) else "large ones do"
            )
            show(f"{law or result.scene.name}: larger cams than this one may break a limit again, {upto}")
    if result.out_of_time:
        show("The search ran out of time; --seconds gives it more.")
    if any(prices.values()):
        _show_prices(prices)
    if result.nearest_miss:
        _show_miss(result.nearest_miss)
    return None


def _show_prices(prices: "Mapping[str, list[Price]]") -> None:
    """What each bound costs, the size of the cam without it, and what holds that cam."""
    rows = [{"law": law, **_price_in_words(price)} for law, each in prices.items() for price in each]
    names = ["law"] if len(prices) > 1 else []
    names += ["bound", "as set", "price", *(["tightened"] if any(row["tightened"] for row in rows) else [])]
    names += ["size without it", "holds to", "then held by"]
    show("", table_of(COSTS, rows, names))


COSTS, UNKNOWN = "What each bound costs", "—"


def _price_in_words(price: "Price", of: str = " mm") -> dict[str, str]:
    """A price as a row of texts; ``of`` is the unit of what is minimised, after a space."""
    unit = f" {price.unit}".rstrip()

    def cost(value: float | None) -> str:
        return UNKNOWN if value is None else f"{value:.4g}{of} per {price.unit or 'unit'}".replace("-", "−")

    def amount(value: float | None, unit: str) -> str:
        return UNKNOWN if value is None else f"{number(value)}{unit}".replace("-", "−")

    return {
        "bound": price.key,
        "as set": f"{price.relation} {amount(price.bound, unit)}",
        "price": cost(price.price),
        "tightened": "" if price.tightened == price.price else cost(price.tightened),
        "size without it": amount(price.size_without, " mm"),
        "holds to": amount(price.holds_to, unit),
        "then held by": UNKNOWN if price.next is None else ", ".join(price.next) or "nothing",
    }


def show_export(result: "Exported", as_json: bool) -> None:
    """The curves in a file with their proved deviations, and its other numbers."""
    if as_json:
        curves = {name: curve._asdict() for name, curve in result.curves.items()}
        return print_json({"file": str(result.file), "curves": curves, **result.about, "notes": list(result.notes)})
    for name, curve in result.curves.items():
        words = f"{curve.elements:,} {curve.what}, within {number(curve.deviation_mm)} mm (proved)"
        show(f"{name.replace('_', ' ')}: {words}")
    for name, value in result.about.items():
        show(f"{name}: {number(value) if isinstance(value, float) else value}")
    return None


def show_synthesis(result: "Synthesised", known: "Comparison", prices: "Iterable[Price]", as_json: bool) -> None:
    """The cam of the free laws beside the smallest of each known law, the bound, the gap, and what bounds cost."""
    from camopt.synthesis.from_scene import default_peaks
    from camopt.synthesis.synthesised import peaks_of
    from camopt.synthesis.told import bound_in_words
    from camopt.synthesis.units import objective_unit

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
    problem = resolve(result.scene)
    every = [_named(row, law) for law, row in known.rows.items()] + [_named(result.design, "free moves")]
    rows = [{**row, **peaks_of(row, result), "binding": ", ".join(row["binding"])} for row in with_law(every)]
    for row in rows:
        beyond = {} if row.get("within", True) else {name: f"{row[name]} *" for name in ("law", "law_rise")}
        row.update(beyond)
    names = [*columns_of(problem, rows), *(name for name in rows[0] if name.startswith("peak_"))]
    title = f"{result.scene.name}: free laws, and the smallest cam of each known law"
    show(table_of(title, rows, [*names, "binding"], bounds_of(problem)))
    unit, what = objective_unit(result.asked), bound_in_words(result)
    swung = result.scene.follower.motion == "oscillating"
    why = "The limits of an oscillating follower are not convex" if swung else "Curvature or a load decides too"
    _show_limits_of_motion(result.asked, known.rows.values(), defaults)
    show(_beside_known(result, known))
    show(what + ("" if result.convex else f" {why}, so the laws are a local optimum."))
    rows = [_price_in_words(price, unit) for price in prices]
    if rows:
        show("", table_of(COSTS, rows, ["bound", "as set", "price"]))
    return None


def _named(row: Mapping[str, Any], name: str) -> dict[str, Any]:
    """A row, with a name in place of the laws of rises and returns where it has neither."""
    named = row["law_rise"] or row["law_return"]
    return dict(row) if named else {**row, "law_rise": name, "law_return": name}


def _show_limits_of_motion(scene: "Scene", known: Iterable[dict[str, Any]], defaults: dict[str, float]) -> None:
    """The limits that were taken by default, and what a star means."""
    from camopt.synthesis.from_scene import AMPLE

    if not all(row["within"] for row in known):
        show("* breaks a limit on the motion that the free laws meet")
    if not defaults:
        return
    kinds = {segment.segment for segment in scene.motion}
    peaks = " and ".join(f"{name.replace('_', ' ')} {value:.6g}" for name, value in defaults.items())
    limits = []
    if kinds & {"rise", "return"}:
        limits.append(f"the peaks of poly345 are the limits (for unit stroke and angle): {peaks}")
    if "move" in kinds:
        own = " and ".join(name.removeprefix("peak_") for name in defaults)
        limits.append(f"moves may have {AMPLE:g} times the largest {own} of those of least jerk")
    show(f"The scene limits neither acceleration nor jerk, so {'; '.join(limits)}.")


def _beside_known(result: "Synthesised", known: "Comparison") -> str:
    """The best known law that holds the same limits, and the scene's own."""
    from camopt.synthesis.compare import OWN_MOVES
    from camopt.synthesis.units import objective_unit

    if known.best is None:
        return "No known law meets all these limits."
    value, unit = known.rows[known.best]["objective"], objective_unit(result.asked)
    what = f"The best known law that meets the same limits is {known.best}: {number(value)}{unit}"
    if known.best == OWN_MOVES:
        what = f"The scene's own moves meet the same limits: {number(value)}{unit}"
    share = 1.0 - result.objective / value if value else 0.0
    less = f"{share:.1%} less" if share > -SLIGHT else f"{-share:.1%} more"
    what += f"; the free laws need {less}." if value else "."
    own = "" if known.own in (None, known.best) else f" The scene's own, {known.own}: "
    return what + (own and f"{own}{number(known.rows[str(known.own)]['objective'])}{unit}.")


def show_frontier(found: "Frontier", as_json: bool) -> None:
    """The free laws along the frontier, the known laws, and the least value of each axis."""
    from camopt.synthesis.compare import OWN_MOVES
    from camopt.synthesis.from_scene import default_peaks
    from camopt.synthesis.units import unit_of

    defaults = default_peaks(found.scene, found.axes)
    if as_json:
        ends = {
            term: {"free_laws": least, "any_motion": bound, "local": term in found.local}
            for term, (least, bound) in found.least.items()
        }
        every = {"rows": found.rows, "known_laws": found.known}
        tables = {name: [finite(row) for row in rows] for name, rows in every.items()}
        names = {"axes": found.axes, "local": found.local, "default_peaks": defaults}
        return print_json({"scene": found.scene.name, **names, "least": ends, **tables})
    rows = [{**row, "law": "free"} for row in found.rows]
    for row in found.known:
        laws = joined_laws(row["law_rise"], row["law_return"]) or OWN_MOVES
        rows.append({**row, "law": laws if row["within"] else f"{laws} *"})
    sizes = [name for name in sizes_shown(found.scene, rows) if not name.startswith("law")]
    shown = [{**row, "bound": "" if row.get("bound") is None else row["bound"]} for row in rows]
    units = {axis: unit_of(axis, found.scene) for axis in found.axes}
    units["bound"] = units[found.axes[0]]
    columns = ["law", *found.axes, "bound", *sizes]
    show(table_of(f"{found.scene.name}: the frontier", shown, columns, units=units))
    show("The known laws are on the smallest cams that the limits allow them.")
    _show_limits_of_motion(found.scene, found.known, defaults)
    for term, (least, bound) in found.least.items():
        most = "" if not bound else f"; no motion within the other limits has less than {number(bound)}"
        local = " (a local optimum)" if term in found.local else ""
        show(f"Least {term}: {f'{number(least)} {units[term]}'.rstrip()}{local}{most}")
    return None


def _in_words(row: dict[str, Any]) -> dict[str, str]:
    """The lists of a row as texts."""
    angles = " ".join(f"{angle:.6g}" for angle in row.get("angles_deg", ()))
    return {"binding": ", ".join(row["binding"]), **({"angles_deg": angles} if angles else {})}


def _optimum_columns(problem: Problem, rows: list[dict[str, Any]]) -> list[str]:
    """What a design shows, and what binds it; whether proved, only where it matters."""
    names = [*columns_of(problem, rows), "binding"]
    if any("angles_deg" in row for row in rows):
        names.append("angles_deg")
    return names if all(row["proved"] for row in rows) else [*names, "proved", "gap_mm"]


def show_verdicts(verdicts: dict[str, str], as_json: bool) -> None:
    """The verdict on each limit."""
    if as_json:
        return print_json(verdicts)
    records = [{"limit": name, "verdict": verdict} for name, verdict in verdicts.items()]
    return show(table_of("At every cam angle", records, ["limit", "verdict"]))


def show_checked(found: "Iterable[Checked]", as_json: bool) -> None:
    """What is known of each file, one a line."""
    if as_json:
        files = [{**asdict(each), "file": str(each.file)} for each in found]
        return print_json({"whole": all(each.is_whole for each in found), "files": files})
    return show_lines(printable(f"{each.file}: {each.told}") for each in found)


def show_counts(counts: dict[str, int], as_json: bool) -> None:
    """How many rows of a table are held, broken and undecided."""
    every = {verdict: counts.get(verdict, 0) for verdict in ("held", "broken", "undecided")}
    if as_json:
        return print_json(every)
    return show(", ".join(f"{count:,} {verdict}" for verdict, count in every.items()))


def show_accuracy(rows: list[dict[str, Any]], scene: "Scene", as_json: bool) -> None:
    """Cost and error of each method."""
    if as_json:
        return print_json({"scene": scene.name, "methods": rows})
    names = list(rows[0])
    shown = [{name: f"{row[name]:.2g}" if name in names[4:] else row[name] for name in names} for row in rows]
    for row in shown:
        row |= {"setting": float(f"{row['setting']:.2g}"), "ns_per_design": float(f"{row['ns_per_design']:.3g}")}
    return show(table_of(f"{scene.name}: what accuracy costs", shown, names))


def show_cost_report(result: "CostReport", as_json: bool) -> None:
    """The effects that run as a tree, what called for each, and what it costs."""
    if as_json:
        entries = [{**asdict(entry), "share": round(entry.share, 6)} for entry in result.entries]
        return print_json({"scene": result.scene.name, "effects": entries, "not_called_for": result.idle})
    whole = sum(entry.ns_per_design for entry in result.entries)
    tree = Tree(f"{result.scene.name}: {whole:,.0f} ns per design, over {result.designs:,} designs, one thread")
    if read := numbers_read(result.scene):
        given = tree.add("read from the scene")
        for each in read:
            given.add(f"{each.key} = {_as_read(each.value)} {each.unit}".rstrip())
    for entry in result.entries:
        branch = tree.add(f"{entry.effect}  {entry.ns_per_design:,.0f} ns per design, {entry.share:.1%}")
        branch.add(f"called for by {', '.join(entry.called_by)}")
        if entry.reads:
            branch.add(f"reads {', '.join(entry.reads)}")
        branch.add(f"writes {', '.join(entry.writes)}")
    for name, keys in result.idle.items():
        needs = f", and needs {', '.join(keys)}" if keys else ""
        tree.add(f"{name}  not called for{needs}")
    return show(tree)


SHOWN_RATIOS = (0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)


def show_spectrum(rows: Rows, as_json: bool) -> None:
    """The residual amplitude in the dwell after each law, at a few period ratios."""
    if as_json:
        return print_json([finite(record) for record in rows.records()])
    laws: dict[str, dict[str, Any]] = {}
    for record in rows.records():
        ratio = round(record["period_ratio"], 9)
        if ratio in SHOWN_RATIOS:
            row = laws.setdefault(record["law"], {"law": record["law"]})
            row[f"{ratio:g}"] = f"{record['residual']:.2g}"
    title = "Residual vibration as a share of the lift, at ratios t₁/Tₙ of the rise time to the natural period"
    return show(table_of(title, list(laws.values()), ["law", *(f"{ratio:g}" for ratio in SHOWN_RATIOS)]))


def show_laws(as_json: bool) -> None:
    """The motion laws with what they join and the peaks of their unit stroke."""
    from camopt.motion.programme import PEAKS, law_peaks, peaks_inside

    records: list[dict[str, Any]] = [
        {
            "law": name,
            "title": law.TITLE,
            "pair": pair_of(law),
            **law_peaks(law),
            **{f"{peak}_inside": value for peak, value in peaks_inside(law).items()},
            "source": law.SOURCE,
        }
        for name, law in LAWS.items()
    ]
    if as_json:
        return print_json([finite(record) for record in records])
    names = ["law", "title", "pair", *PEAKS, "jumps"]
    title = "Motion laws between dwells (stroke 1, angle 1); they join rest R, constant velocity G, reversal U"
    show(table_of(title, records, names))
    jumping = [{**each, **{peak: each[f"{peak}_inside"] for peak in PEAKS}} for each in records if each["jumps"]]
    return show(table_of("Inside the stroke, of those with a jump beside a dwell", jumping, names[:-1]))


def show_scenes(name: str | None, as_json: bool) -> None:
    """The shipped scenes, or one of them as TOML."""
    from camopt.scene.scene import shipped_scenes, shipped_toml

    if name is not None:
        if name not in shipped_scenes():
            raise BadInput([Mistake("camopt", "NAME", name, f"a shipped scene; {nearest(name, shipped_scenes())}")])
        text = shipped_toml(name)
        if as_json:
            return print_json({"name": name, "toml": text})
        sys.stdout.write(text)
        return None
    records = [{"name": each, "title": tomllib.loads(shipped_toml(each))["name"]} for each in shipped_scenes()]
    if as_json:
        return print_json(records)
    return show(table_of("Shipped scenes", records, ["name", "title"]))
