"""The tables of a page: limits with their proofs, sizes, quantities, and what ran."""

from collections.abc import Iterable, Iterator, Mapping
from math import isfinite
from typing import Any

from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.unit_systems import shown_unit, to_shown_unit
from camopt.model.effects import find_quantity
from camopt.scene.mapping import leaves
from camopt.scene.problem.limit import Limit, OwnQuantityLimit
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.scene import Scene
from camopt.scene.table_places import tables_by_place
from camopt.scene.units import in_shown_units
from camopt.show.studies.cost_report import effects_run
from camopt.solve.tables.cells import name_in_shown_unit, number_text, quantity_text
from camopt.solve.tables.designs import bounds_shown, is_zero_column
from camopt.solve.tables.result import ABOUT, NUMERIC, WORDS, Cell, Table
from camopt.solve.verdicts.certify import CONDITIONS, certify_problem
from camopt.solve.verdicts.evaluation import Evaluation
from camopt.solve.verdicts.verdict_words import ARM_UNCHECKED, BROKEN, HELD, UNDECIDED

IN_DOUBLES, IN_INTERVALS, BY_INTEGRALS, BY_SIZES = "double precision", "intervals", "integrals", "sizes"
UNPROVED = "not yet"
PROOFS = {
    IN_INTERVALS: "with room for every rounding, at every cam angle",
    IN_DOUBLES: "with margins for rounding, over the whole turn",
    BY_INTEGRALS: "by Gauss's rule, of which two orders agree",
    BY_SIZES: "sizes compared",
    UNPROVED: "double precision while controls move; proved where they rest",
}
"""How limits are proved, and what that means."""
INTEGRATED = ("section", "solid")
"""Effects whose quantities are integrals over the turn."""


def limits_sheet(found: Evaluation, problem: Problem) -> Table:
    """Each limit: its bound, the value reached, the margin, whether it is held, and how that was proved."""
    limits = {limit.name: limit for limit in problem.limits}
    verdicts = certify_problem(problem)
    proofs = {name: IN_INTERVALS if name == CONDITIONS else _proof_method(limits.get(name)) for name in verdicts}
    return verdicts_sheet(found, problem, verdicts, proofs)


def verdicts_sheet(
    found: Evaluation, problem: Problem, verdicts: Mapping[str, str], proofs: Mapping[str, str]
) -> Table:
    """As ``limits_sheet``, of verdicts by the names of limits, and how each was found."""
    limits = {limit.name: limit for limit in problem.limits}
    rows: list[list[Cell | str]] = []
    for name, verdict in verdicts.items():
        limit, how = limits.get(name), proofs[name]
        for bound, reached, margin in _limit_cells(limit, found, verdict):
            rows.append([_spaced_name(name), Cell(verdict, verdict), bound, reached, margin, Cell(how, "how")])
    numbers = (Cell(text, NUMERIC) for text in ("bound", "reached", "margin"))
    used = dict.fromkeys(proofs[name] for name in verdicts)
    note = "; ".join(f"{how}: {PROOFS[how]}" for how in used)
    if found.scene.mechanism.motion.angular:
        note += f". {ARM_UNCHECKED}"
    return Table.from_texts("Limits, at every cam angle", ["limit", "verdict", *numbers, "proved by"], rows, note)


def _spaced_name(name: str) -> str:
    return name.replace("_", " ")


def _proof_method(limit: Limit | None) -> str:
    if limit is None or limit.decider or isinstance(limit, OwnQuantityLimit):
        return IN_DOUBLES
    if limit.constraints:
        return IN_INTERVALS
    if limit.mean_constraint is not None or any(
        find_quantity(name, limit.setup).effect in INTEGRATED for name in limit.required_quantities
    ):
        return BY_INTEGRALS
    return IN_INTERVALS if limit.required_quantities else BY_SIZES


def _limit_cells(limit: Limit | None, found: Evaluation, verdict: str) -> Iterator[tuple[str, str, str]]:
    """Bound, value and margin of each quantity that a limit bounds, in words; a margin below 0 is exceeded."""
    base = found.scene.cam.base_radius
    if limit is not None and limit.is_on_base_circle and base:
        values = (limit.bound, 2.0 * base, 2.0 * base - limit.bound)
        least, diameter, left = (_with_unit(to_shown_unit(each, "mm"), shown_unit("mm")) for each in values)
        yield f"≥ {least}", diameter, left
        return
    names = [] if limit is None else [name for name in limit.shown_quantities if name in found]
    if limit is None or not names:
        yield "finite" if isinstance(limit, OwnQuantityLimit) else "none allowed", "", ""
        return
    for name in names:
        unit, value = find_quantity(name, limit.setup).unit, found[name]
        side = 1.0 if limit.relation in ("≤", "±") else -1.0
        margin = side * (limit.bound - (abs(value) if side > 0.0 else value))
        just = verdict == HELD and abs(margin) <= found.scene.accuracy.relative_error * abs(limit.bound)
        margin = 0.0 if just else margin
        words = f"{limit.relation} {to_shown_unit(limit.bound, unit):g} {shown_unit(unit)}".replace(
            "-", "−"
        ).strip()
        reached = f"{with_minus_sign(quantity_text(name, value))} {shown_unit(unit)}".strip()
        yield words, reached, _with_unit(float(f"{to_shown_unit(margin, unit):.3g}"), shown_unit(unit))


def _with_unit(value: float, unit: str) -> str:
    return f"{signed_text(value)} {unit}".strip() if isfinite(value) else signed_text(value)


def signed_text(value: Any) -> str:
    """A number as people read it, with a real minus sign."""
    return with_minus_sign(number_text(value)) if isinstance(value, float) else number_text(value)


def with_minus_sign(text: str) -> str:
    """A number with a real minus sign."""
    return text.replace("-", "−") if text[-1:].isdigit() else text


def verdict_line(sheet: Table, scene: Scene) -> Cell:
    """The verdict on a design in one sentence."""
    broken, undecided = (", ".join(_limits_with_verdict(verdict, sheet)) for verdict in (BROKEN, UNDECIDED))
    if broken:
        return Cell(f"Not feasible: {broken}.", "verdict broken")
    if undecided:
        return Cell(f"Not proved to be feasible; undecided: {undecided}.", "verdict undecided")
    if not scene.to_dict().get("limits"):
        return Cell("Feasible: the scene gives no limits, and what every cam must hold is proved.", "verdict held")
    return Cell("Feasible: every limit is proved to be held at every cam angle.", "verdict held")


def _limits_with_verdict(verdict: str, sheet: Table) -> Iterable[str]:
    """The limits of a sheet that have a verdict, each once."""
    place = [head.text for head in sheet.heads].index("verdict")
    return dict.fromkeys(row[0].text for row in sheet.rows if row[place].text == verdict)


def all_limits_held(sheet: Table) -> bool:
    """Whether every limit of a sheet is held."""
    return not any(_limits_with_verdict(verdict, sheet) for verdict in (BROKEN, UNDECIDED))


def quantities_sheet(found: list[Evaluation], problems: Iterable[Problem], labels: Iterable[str]) -> Table:
    """Every quantity of some designs side by side, with unit, limit and meaning."""
    names = dict.fromkeys(
        n for each in found for n in each if not is_zero_column(each.scene.search.sizes, n, [each])
    )
    first, *others = (bounds_shown(problem) for problem in problems)
    bounds = {name: bound for name, bound in first.items() if all(each.get(name) == bound for each in others)}
    heads: list[Cell | str] = [
        "quantity",
        "symbol",
        *(Cell(label, NUMERIC) for label in labels),
        "unit",
        "limit",
        "",
    ]
    rows: list[list[Cell | str]] = []
    for name in names:
        values = [
            with_minus_sign(quantity_text(name, each[name])).replace(",", ", ") if name in each else ""
            for each in found
        ]
        about = next(find_quantity(name, resolve(each.scene).setup) for each in found if name in each)
        reasons = dict.fromkeys(each.unbounded[name] for each in found if name in each.unbounded)
        meaning, called = "; ".join(reasons) or about.sentence, name_in_shown_unit(name, about.unit)
        unit, bound = shown_unit(about.unit), bounds.get(name, "")
        rows.append([called, about.symbol, *values, unit, bound, Cell(meaning, ABOUT)])
    return Table.from_texts("Every quantity that the scene calls for", heads, rows)


def _shown_tables(scene: Scene) -> dict[str, Any]:
    """What the scene gives, in the units in which results are shown."""
    return in_shown_units(scene.to_dict(), tables_by_place(Scene))


def motion_sheet(scene: Scene) -> Table:
    """The segments of the motion, or the arcs and lines of the profile."""
    data = _shown_tables(scene)
    unit, of = "deg" if scene.given_turns else shown_unit("mm"), "follower" if scene.given_at_follower else "tool"
    whose = f"Motion of the {of}" if scene.train else "Motion"
    title = f"{whose}, segment by segment (angles in deg, lifts in {unit})"
    if "motion" not in data:
        title = f"Profile, arc by arc (lengths in {unit})"
    parts = data.get("motion") or data.get("profile", [])
    keys = list(dict.fromkeys(key for part in parts for key in part))
    return Table.from_texts(title, keys, ([_cell_text(part.get(key, "")) for key in keys] for part in parts))


def train_sheets(scene: Scene) -> list[Table]:
    """The stages between the follower and its tool, if there are any."""
    stages = _shown_tables(scene).get("train", [])
    keys = list(dict.fromkeys(key for stage in stages for key in stage))
    title = f"Train, from the follower to the tool (lengths in {shown_unit('mm')}, angles in deg)"
    return (
        [Table.from_texts(title, keys, ([_cell_text(s.get(key, "")) for key in keys] for s in stages))]
        if stages
        else []
    )


def given_sheet(scene: Scene) -> Table:
    """Sizes, speed, materials and loads that the scene gives, by key."""
    units = {key: QUANTITIES[name] for key, name in scene.number_quantities.items()}
    given = leaves({name: table for name, table in _shown_tables(scene).items() if name in GIVEN_TABLES})
    rows: list[list[Cell | str]] = [
        [
            key,
            Cell(_cell_text(value), NUMERIC if isinstance(value, (int, float)) else WORDS),
            shown_unit(units[key].unit if key in units else "mm" if key in LENGTH_KEYS else ""),
            units[key].sentence if key in units else "",
        ]
        for key, value in given
    ]
    return Table.from_texts("What the scene gives", ["key", Cell("value", NUMERIC), "unit", ""], rows)


GIVEN_TABLES = ("cam", "follower", "materials", "part")
LENGTH_KEYS = {
    *(f"cam.{name}" for name in ("base_radius", "mean_radius")),
    *(f"follower.{name}" for name in ("roller_radius", "face_radius", "offset", "arm_length")),
    *("follower.centre_distance", "follower.face_offset"),
    *(f"part.{name}" for name in ("thickness", "bore", "hub_diameter", "hub_length", "groove_depth")),
    *("part.keyway_width", "part.keyway_depth", "part.profile_tolerance"),
}


def _cell_text(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        texts = [_cell_text(each) for each in value]
        return ", ".join(
            texts if len(texts) <= LISTED_NUMBERS else [*texts[:LISTED_NUMBERS], f"… ({len(texts)} in all)"]
        )
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_cell_text(inner)}" for key, inner in value.items())
    return signed_text(float(value)) if isinstance(value, float) else str(value)


LISTED_NUMBERS = 8  # numbers of a list that are shown


def effects_sheet(problem: Problem) -> Table:
    """The effects that ran, what called for them, and what they computed."""
    rows = [[each.effect, ", ".join(each.called_by), ", ".join(each.writes)] for each in effects_run(problem)]
    return Table.from_texts("Effects that ran", ["effect", "called for by", "computes"], rows)
