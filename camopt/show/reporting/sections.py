"""Tables of a page: limits with their proofs, quantities, inputs of the scene, effects."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from math import isfinite
from typing import Any

from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects import find_quantity
from camopt.scene.mapping import leaf_values_by_key
from camopt.scene.problem.limit import Limit, OwnQuantityLimit
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.scene import SCENE_TABLES, Scene
from camopt.scene.units import tables_in_shown_units
from camopt.show.studies.cost_report import needed_effect_runs
from camopt.solve.tables.cells import name_in_shown_unit, number_text, quantity_text
from camopt.solve.tables.designs import is_unsearched_zero_column, limit_texts_by_quantity
from camopt.solve.tables.result import ABOUT, NUMERIC, WORDS, Cell, Table
from camopt.solve.verdicts.certify import CONDITIONS, certify_limits_and_conditions
from camopt.solve.verdicts.evaluation import Evaluation
from camopt.solve.verdicts.verdict_words import ARM_UNCHECKED, BROKEN, HELD, UNDECIDED

IN_DOUBLES, IN_INTERVALS, BY_INTEGRALS, BY_SIZES = "double precision", "intervals", "integrals", "sizes"
UNPROVED = "not yet"
PROOFS = {
    IN_INTERVALS: "interval arithmetic at every cam angle, which includes all rounding",
    IN_DOUBLES: "double precision over the whole turn, with margins for rounding",
    BY_INTEGRALS: "Gauss's rule, in two orders that agree",
    BY_SIZES: "sizes are compared",
    UNPROVED: "double precision while controls move; the proof follows when they rest",
}
"""Methods of proof, and what each means."""
INTEGRATED = ("section", "solid")
"""Effects whose quantities are integrals over the turn."""


def limits_table(evaluation: Evaluation, problem: Problem) -> Table:
    """Each limit with its verdict, limit, value, margin and method of proof."""
    limits = {limit.name: limit for limit in problem.limits}
    verdicts = certify_limits_and_conditions(problem)
    proofs = {name: IN_INTERVALS if name == CONDITIONS else _proof_method(limits.get(name)) for name in verdicts}
    return verdicts_table(evaluation, problem, verdicts, proofs)


def verdicts_table(
    evaluation: Evaluation, problem: Problem, verdicts: Mapping[str, str], proofs: Mapping[str, str]
) -> Table:
    """``limits_table`` with these verdicts and methods of proof, by name of limit."""
    limits = {limit.name: limit for limit in problem.limits}
    rows: list[list[Cell | str]] = []
    for name, verdict in verdicts.items():
        limit, how = limits.get(name), proofs[name]
        for bound, reached, margin in _limit_cells(limit, evaluation, verdict):
            rows.append([name.replace("_", " "), Cell(verdict, verdict), bound, reached, margin, Cell(how, "how")])
    numbers = (Cell(text, NUMERIC) for text in ("limit", "value", "margin"))
    used = dict.fromkeys(proofs[name] for name in verdicts)
    note = "; ".join(f"{how}: {PROOFS[how]}" for how in used)
    if evaluation.scene.mechanism.motion.angular:
        note += f". {ARM_UNCHECKED}"
    return Table.from_texts(
        "Limits, at every cam angle", ["limit on", "verdict", *numbers, "proved by"], rows, note
    )


def _proof_method(limit: Limit | None) -> str:
    if limit is None or limit.single_design_decider or isinstance(limit, OwnQuantityLimit):
        return IN_DOUBLES
    if limit.constraints:
        return IN_INTERVALS
    if limit.mean_constraint is not None or any(
        find_quantity(name, limit.setup).effect in INTEGRATED for name in limit.required_quantities
    ):
        return BY_INTEGRALS
    return IN_INTERVALS if limit.required_quantities else BY_SIZES


def _limit_cells(limit: Limit | None, evaluation: Evaluation, verdict: str) -> Iterator[tuple[str, str, str]]:
    """Texts of bound, value and margin of each quantity of a limit. A margin below 0 breaks the limit."""
    base = evaluation.scene.cam.base_radius
    if limit is not None and limit.is_on_base_circle and base:
        values = (limit.bound, 2.0 * base, 2.0 * base - limit.bound)
        bound, diameter, margin = (
            _signed_text_with_unit(to_shown_unit(each, "mm"), unit_in_shown_system("mm")) for each in values
        )
        yield f"≥ {bound}", diameter, margin
        return
    names = [] if limit is None else [name for name in limit.shown_quantities if name in evaluation]
    if limit is None or not names:
        yield "finite" if isinstance(limit, OwnQuantityLimit) else "none allowed", "", ""
        return
    for name in names:
        unit, value = find_quantity(name, limit.setup).unit, evaluation[name]
        side = 1.0 if limit.relation in ("≤", "±") else -1.0
        distance = side * (limit.bound - (abs(value) if side > 0.0 else value))
        rounding = evaluation.scene.accuracy.relative_error * abs(limit.bound)
        distance = 0.0 if verdict == HELD and abs(distance) <= rounding else distance
        words = f"{limit.relation} {to_shown_unit(limit.bound, unit):g} {unit_in_shown_system(unit)}".replace(
            "-", "−"
        ).strip()
        reached = f"{with_minus_sign(quantity_text(name, value))} {unit_in_shown_system(unit)}".strip()
        yield (
            words,
            reached,
            _signed_text_with_unit(float(f"{to_shown_unit(distance, unit):.3g}"), unit_in_shown_system(unit)),
        )


def _signed_text_with_unit(value: float, unit: str) -> str:
    return (
        f"{number_text_with_minus_sign(value)} {unit}".strip()
        if isfinite(value)
        else number_text_with_minus_sign(value)
    )


def number_text_with_minus_sign(value: Any) -> str:
    """A number as text, with a real minus sign."""
    return with_minus_sign(number_text(value)) if isinstance(value, float) else number_text(value)


def with_minus_sign(text: str) -> str:
    """A text with a real minus sign, if it is a number."""
    return text.replace("-", "−") if text[-1:].isdigit() else text


def verdict_line(limits: Table, scene: Scene) -> Cell:
    """The verdict on a design as one sentence."""
    place, names = [head.text for head in limits.heads].index("verdict"), defaultdict[str, dict[str, None]](dict)
    for row in limits.rows:
        names[row[place].text][row[0].text] = None  # each once
    broken, undecided = (", ".join(names[verdict]) for verdict in (BROKEN, UNDECIDED))
    if broken:
        return Cell(f"Not feasible: {broken}.", "verdict broken")
    if undecided:
        return Cell(f"Not proved to be feasible; undecided limits: {undecided}.", "verdict undecided")
    if not scene.to_dict().get("limits"):
        return Cell(
            "Feasible: the scene gives no limits, and the conditions on every cam are proved.", "verdict held"
        )
    return Cell("Feasible: every limit is proved at every cam angle.", "verdict held")


def quantities_table(evaluations: list[Evaluation], problems: Iterable[Problem], labels: Iterable[str]) -> Table:
    """Every quantity of designs side by side, with unit, limit and meaning."""
    names = dict.fromkeys(
        n for each in evaluations for n in each if not is_unsearched_zero_column(each.scene.search.sizes, n, [each])
    )
    first, *others = (limit_texts_by_quantity(problem) for problem in problems)
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
            for each in evaluations
        ]
        about = next(find_quantity(name, resolve(each.scene).setup) for each in evaluations if name in each)
        reasons = dict.fromkeys(each.unbounded[name] for each in evaluations if name in each.unbounded)
        meaning, title = "; ".join(reasons) or about.sentence, name_in_shown_unit(name, about.unit)
        unit, bound = unit_in_shown_system(about.unit), bounds.get(name, "")
        rows.append([title, about.symbol, *values, unit, bound, Cell(meaning, ABOUT)])
    return Table.from_texts("Quantities", heads, rows)


def _scene_tables_in_shown_units(scene: Scene) -> dict[str, Any]:
    """The tables of a scene, in the units in which results are shown."""
    return tables_in_shown_units(scene.to_dict(), SCENE_TABLES)


def motion_table(scene: Scene) -> Table:
    """A table of the segments of the motion, or of the arcs and lines of the profile."""
    data = _scene_tables_in_shown_units(scene)
    unit = "deg" if scene.given_motion_is_angle else unit_in_shown_system("mm")
    body = "follower" if scene.given_at_follower else "tool"
    name = f"Motion of the {body}" if scene.train else "Motion"
    title = f"{name}, segment by segment (angles in deg, lifts in {unit})"
    if "motion" not in data:
        title = f"Profile, arc by arc (lengths in {unit})"
    parts = data.get("motion") or data.get("profile", [])
    keys = list(dict.fromkeys(key for part in parts for key in part))
    return Table.from_texts(title, keys, ([_cell_text(part.get(key, "")) for key in keys] for part in parts))


def train_tables(scene: Scene) -> list[Table]:
    """A table of the stages between follower and tool; none without a train."""
    stages = _scene_tables_in_shown_units(scene).get("train", [])
    keys = list(dict.fromkeys(key for stage in stages for key in stage))
    title = f"Train, from the follower to the tool (lengths in {unit_in_shown_system('mm')}, angles in deg)"
    return (
        [Table.from_texts(title, keys, ([_cell_text(s.get(key, "")) for key in keys] for s in stages))]
        if stages
        else []
    )


def inputs_table(scene: Scene) -> Table:
    """Sizes, speed, materials and loads of the scene, by key."""
    units = {key: QUANTITIES[name] for key, name in scene.number_quantities.items()}
    inputs = leaf_values_by_key(
        {name: table for name, table in _scene_tables_in_shown_units(scene).items() if name in INPUT_TABLES}
    )
    rows: list[list[Cell | str]] = [
        [
            key,
            Cell(_cell_text(value), NUMERIC if isinstance(value, (int, float)) else WORDS),
            unit_in_shown_system(units[key].unit if key in units else "mm" if key in LENGTH_KEYS else ""),
            units[key].sentence if key in units else "",
        ]
        for key, value in inputs
    ]
    return Table.from_texts("Inputs of the scene", ["key", Cell("value", NUMERIC), "unit", ""], rows)


INPUT_TABLES = ("cam", "follower", "materials", "part")
LENGTH_KEYS = {
    *(f"cam.{name}" for name in ("base_radius", "mean_radius")),
    *(f"follower.{name}" for name in ("roller_radius", "face_radius", "offset", "arm_length")),
    *("follower.centre_distance", "follower.face_offset"),
    *(f"part.{name}" for name in ("thickness", "bore", "hub_diameter", "hub_length", "groove_depth")),
    *("part.keyway_width", "part.keyway_depth", "part.profile_tolerance"),
}


def _cell_text(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        texts = [_cell_text(item) for item in value]
        return ", ".join(
            texts if len(texts) <= LISTED_NUMBERS else [*texts[:LISTED_NUMBERS], f"… ({len(texts)} in all)"]
        )
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_cell_text(inner)}" for key, inner in value.items())
    return number_text_with_minus_sign(float(value)) if isinstance(value, float) else str(value)


LISTED_NUMBERS = 8  # numbers of a list that are shown


def effects_table(problem: Problem) -> Table:
    """The effects that ran, why they ran, and what they computed."""
    rows = [
        [each.effect, ", ".join(each.called_by), ", ".join(each.writes)] for each in needed_effect_runs(problem)
    ]
    return Table.from_texts("Effects that ran", ["effect", "called for by", "computes"], rows)
