"""The quantities of one design, with its verdict, and why quantities are infinite."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Any, overload
from warnings import warn

import numpy as np

from camopt.core.mistakes import UnknownName, suggest_names
from camopt.core.quantities import QUANTITIES, Flag, Word, displacement_unit, in_column_order
from camopt.core.quantities.display import Drawable
from camopt.core.quantities.unit_systems import MM, shown_in, to_shown_unit, unit_in_shown_system
from camopt.model.effects import EvaluationBlock, find_quantity
from camopt.model.effects.clearance import SKIDDING_TIME
from camopt.model.effects.contacts import CONTACT_NAMES
from camopt.model.effects.joints import JointRow, joint_force_rows
from camopt.model.effects.motion import MOVE_KINDS, motion_table_unit, motion_unit_factor
from camopt.model.effects.peak import Peak
from camopt.model.effects.peak_columns import peak_column
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.numbers_with_units import NumberWithUnit, numbers_with_units
from camopt.scene.problem.limit import QuantityLimit
from camopt.scene.problem.problem import Problem, resolve, resolve_design, with_rounding_relative_error
from camopt.scene.problem.scene_notes import notes_on_scene
from camopt.scene.scene import Scene
from camopt.scene.speed import TURNS_OF_CRANK
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.designs import design_table, is_unsearched_zero_column
from camopt.solve.tables.result import Cell, Result, Table, table_of
from camopt.solve.verdicts.design_warnings import farthest_point, warnings_of_design
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_verdicts import evaluate_with_verdicts
from camopt.solve.verdicts.verdict_words import ARM_UNCHECKED

PROOFS = {
    "certified": "proved at every cam angle",
    "sampled": "proved for the spline of a table",
    "undecided": "not proved",
}
"""The status of a verdict in words."""
TIE_SHARE = 1e-9
"""Relative difference below which two contacts are reported together."""


@dataclass(frozen=True)
class Evaluation(Result, Drawable, Mapping[str, Any]):
    """The quantities of one design: a mapping from name to value.

    Attributes
    ----------
    scene : Scene
        The evaluated scene.
    quantities : dict
        Values by name: numbers, texts, and for ``feasible`` and the like true or false.
    unbounded : dict
        Reason for each infinite value, by name.
    warnings : tuple of str
        Warnings about the cam, such as an elastic train that loses contact where a rigid one keeps it, or a motion
        that goes beyond the positions in the scene.

    Examples
    --------
    >>> cam = camopt.evaluate(camopt.find_scene("uniform-knife-radial"))
    >>> cam["feasible"], cam["base_radius_mm"]
    (True, 50.0)
    """

    picture = "drawing.figures"
    scene: Scene
    quantities: dict[str, float | bool | str]
    unbounded: dict[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    @overload
    def __getitem__(self, name: Flag, /) -> bool: ...  # type: ignore[overload-overlap]  # others are numbers
    @overload
    def __getitem__(self, name: Word, /) -> str: ...  # type: ignore[overload-overlap]  # others are numbers
    @overload
    def __getitem__(self, name: str, /) -> float: ...
    def __getitem__(self, name: str, /) -> float | bool | str:
        if name not in self.quantities:
            if name in QUANTITIES:
                raise UnknownName(f"{name!r} was not computed; add it to the outputs of the scene")
            raise UnknownName(f"{name!r} is not a quantity of this evaluation; {suggest_names(str(name), self)}")
        return self.quantities[name]

    def __contains__(self, name: object) -> bool:
        return name in self.quantities

    def __repr__(self) -> str:
        verdict = "feasible" if self.quantities.get("feasible") else f"breaks {self.quantities.get('violated')}"
        return f"<Evaluation of {self.scene.name}: {len(self)} quantities, {verdict}>"

    def __iter__(self) -> Iterator[str]:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)

    def table(self) -> Table:
        """One row for each quantity: value, unit, limit, and its meaning or the reason why it is infinite."""
        names = [name for name in self if not is_unsearched_zero_column(self.scene.search.sizes, name, [self])]
        reasons, problem = {name: Cell(reason) for name, reason in self.unbounded.items()}, resolve(self.scene)
        about = {name: reasons.get(name, find_quantity(name, problem.setup).sentence) for name in names}
        return design_table(self.scene.name, problem, self, about)

    def sections(self) -> Iterator[Table | str]:
        """The verdict, the quantities, the largest lift, the joint forces and the numbers of the scene."""
        yield self.verdict
        yield self.table()
        yield _largest_lift_and_angle_sentence(self.scene)
        if self.tightest:
            yield f"Tightest of both contacts: {self.tightest}."
        if self.scene.mechanism.motion.angular:
            yield f"{ARM_UNCHECKED}."
        if joints := [
            {name: "" if value is None else value for name, value in row._asdict().items()}
            for row in self.joint_forces
        ]:
            yield ""
            yield table_of(JOINTS_TITLE, joints, joints[0])
            yield JOINTS_NOTE
        if numbers := numbers_with_units(self.scene):
            rows = [
                {"key": number.key, "value": scene_number_text(number), "unit": unit_in_shown_system(number.unit)}
                for number in numbers
            ]
            yield ""
            yield table_of("Values that the scene gives with a unit", rows, ["key", "value", "unit"])
        if self.scene.is_speed_of_crank:
            yield _cam_vs_crankshaft_speed_sentence(self)

    @property
    def verdict(self) -> str:
        """A sentence on the limits: whether the design meets them, which it breaks, and whether that is proved."""
        proof = PROOFS[str(self["status"])]
        if self["feasible"]:
            return f"Feasible: the design meets every limit ({proof})."
        if self["violated"]:
            return f"Not feasible: the design breaks {str(self['violated']).replace(',', ', ')} ({proof})."
        return f"Undecided: whether the design meets its limits is {proof}."

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings about the cam, and notes on odd or unused keys of the scene."""
        return (*self.warnings, *notes_on_scene(self.scene))

    @property
    def relative_half_width(self) -> float:
        """Largest relative half-width of the values' enclosures."""
        return float(self["relative_half_width"])

    @property
    def joint_forces(self) -> list[JointRow]:
        """Forces in the joints of a train, if the scene's outputs include them.

        Each row has the stage, the joint, the smallest and largest force over the turn [N], and the cam angle of
        the largest magnitude with its direction there [deg]. Above 0, a coupler is pushed and a roller pressed on
        its face. For a pivot, it is the largest sum of the magnitudes of both forces on it.
        """
        problem = resolve(self.scene)
        has_joints = any(find_quantity(name, problem.setup).effect == "joints" for name in self)
        return joint_force_rows(problem.setup, problem.programme) if has_joints else []

    @property
    def tightest(self) -> str:
        """The contact nearest to its limit or furthest beyond it, for a follower with two contacts; else empty."""
        problem = with_rounding_relative_error(resolve_design(self.scene))
        case = EvaluationBlock(problem.setup, problem.programme, problem.design)
        contacts: list[tuple[float, str, str, str]] = []  # relative excess, limit, place, values in words
        for limit in problem.limits:
            if not (
                isinstance(limit, QuantityLimit)
                and isinstance(limit.peak_or_mean, Peak)
                and limit.further_peaks
                and limit.set_by_scene
            ):
                continue
            quantity = QUANTITIES[limit.quantities[0]]
            bound = f"{limit.relation} {with_unit(limit.bound, quantity.unit)}"
            for place, peak in zip(CONTACT_NAMES, (limit.peak_or_mean, *limit.further_peaks), strict=True):
                value = float(np.squeeze(peak_column(case, peak).value))
                excess = quantity.limit_sign * (value - limit.bound) / (abs(limit.bound) or 1.0)
                contacts.append((excess, limit.key, place, f"{with_unit(value, quantity.unit)}, {bound}"))
        if not contacts:
            return ""
        most, tightest, place, words = max(contacts)
        tied = [excess for excess, key, *_ in contacts if key == tightest and abs(excess - most) <= TIE_SHARE]
        where = "both contacts" if len(tied) > 1 else f"the {place} contact"
        return f"{tightest} at {where}: {words}"

    def to_json(self) -> dict[str, Any]:
        """Deprecated name of ``to_dict``."""
        warn("to_json is now to_dict", DeprecationWarning, stacklevel=2)
        return dict(self.to_dict())

    def values_for_json(self) -> dict[str, Any]:
        """The values, with reasons for infinite ones, joint forces, warnings and the tightest contact."""
        joints = [{name: v for name, v in row._asdict().items() if v is not None} for row in self.joint_forces]
        with shown_in(MM):  # the names of quantities have units in mm
            problem = with_rounding_relative_error(resolve_design(self.scene)) if self.unbounded else None
            unbounded = {name: _infinity_reason(name, problem) for name in self.unbounded if problem}
        about = {"unbounded": unbounded, "joint_forces": joints, "warnings": list(self.warnings)}
        about |= {"tightest": self.tightest}
        return self.quantities | {name: value for name, value in about.items() if value}


def _largest_lift_and_angle_sentence(scene: Scene) -> str:
    """Sentence on the largest lift and its cam angle."""
    programme, unit = resolve(scene).programme.tool, displacement_unit(angular=scene.tool_turns)
    angle = np.degrees(farthest_point(programme, 1.0).angle)
    whose, lift = (
        " of the tool" if scene.train else "",
        with_unit(programme.lift / programme.unit_in_mm_or_rad, unit),
    )
    return f"Largest lift{whose}: {lift}, reached at {number_text(float(angle))}°."


def _cam_vs_crankshaft_speed_sentence(result: Evaluation) -> str:
    """Sentence on the speeds in the results of a scene that gives the speed of a crankshaft."""
    speeds = "Speeds in these results are those of the cam, half those of the crankshaft"
    jump = result.get("jump_speed_rpm")
    at_crank = (
        ""
        if jump is None
        else f"; at the crankshaft, the jump speed is {number_text(TURNS_OF_CRANK * jump)} rev/min"
    )
    return f"{speeds}{at_crank}."


def scene_number_text(number: NumberWithUnit) -> str:
    """Text of a number of the scene; for a load that changes, its number of rows."""
    value = number.value
    return number_text(to_shown_unit(value, number.unit)) if isinstance(value, float) else f"{len(value):,} rows"


JOINTS_TITLE = "Forces in the joints of the train over the turn"
JOINTS_NOTE = (
    "Above 0, a coupler is pushed and a roller is pressed on its face; below 0, it is pulled or lifted off. For a "
    "pivot, the force is the sum of the magnitudes of both forces on it, an upper bound. Directions are of the "
    "largest force, from the motion of the slide, or from the line of a four-bar's pivots."
)


def evaluate(scene: SceneSource) -> Evaluation:
    """Compute all quantities in the scene's outputs and limits, for the sizes in the scene.

    Extremes are exact: they are computed from the continuous motion, with a relative error of at most 1e-13, or the
    scene's own accuracy if that is smaller. An infinite quantity, such as the acceleration of a uniform-velocity
    law, is ``inf``, and ``unbounded`` has the reason.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with sizes.

    Returns
    -------
    Evaluation
        The quantities by name (``QUANTITIES`` lists all), with ``feasible`` and ``violated`` among them.

    Raises
    ------
    BadInput
        If the scene lacks a size.

    References
    ----------
    R. L. Norton, Cam Design and Manufacturing Handbook, ch. 3 and 7 to 9.

    Examples
    --------
    >>> cam = camopt.evaluate(camopt.find_scene("roller-1000rpm"))
    >>> round(cam["pressure_angle_max_deg"], 3), cam["violated"]
    (41.626, 'pressure_angle')
    """
    scene = scene_from(scene)
    return evaluate_design(scene, resolve_design(scene))


def evaluate_design(scene: Scene, problem: Problem) -> Evaluation:
    """Evaluate a scene that is already resolved to a problem."""
    problem = with_rounding_relative_error(problem)
    (record,) = evaluate_with_verdicts(
        problem, problem.design, problem.evaluated_quantities | problem.size_quantity_names
    ).records()
    values = {name: record[name] for name in in_column_order(record)}
    unbounded = {name: _infinity_reason(name, problem) for name, value in values.items() if value in (inf, -inf)}
    return Evaluation(scene, values, unbounded, warnings_of_design(problem))


LOAD_EFFECTS = ("force", "torque", "joints", "thrust", "hertz", "surface")


def _infinite_load_reason(name: str, problem: Problem) -> str:
    """Reason why a load is infinite for a motion without corners."""
    effect, setup = QUANTITIES[name].effect, problem.setup
    if effect == "force":
        return "the force is too small at the follower's lowest position, where no spring rate adds to it"
    case = EvaluationBlock(setup, problem.programme, problem.design)
    shaped = effect in ("hertz", "surface") and not setup.is_knife
    if shaped and run_effects(case, ["undercut"]).column("undercut")[0]:
        return "the profile is undercut"
    if not setup.mechanism.flat_faced:
        return "the follower jams in its guide"
    return "the contact stands still" if effect == "surface" else "the contact passes the follower's pivot"


def _jump_text(problem: Problem, derivative_order: int, stroke_kinds: int) -> str:
    """Cam angles at which a derivative of the motion jumps, next to some kinds of stroke, and the largest jump."""
    jumps = [j for j in problem.programme.tool.jumps if j.order == derivative_order and j.kinds & stroke_kinds]
    if not jumps:
        return ""
    unit, size = (
        motion_table_unit(problem.setup, derivative_order),
        max(abs(j.size) for j in jumps) * motion_unit_factor(problem.setup, derivative_order),
    )
    most = "at most " if len(jumps) > 1 else ""
    return f"{', '.join(f'{np.degrees(j.at):g}°' for j in jumps)}, by {most}{with_unit(size, unit)}"


def _infinity_reason(name: str, problem: Problem) -> str:
    """Reason why a quantity is infinite."""
    if name in problem.setup.own_quantities:
        return "its expression has no finite value here"
    if QUANTITIES[name].effect == "vibration":
        return "the undamped train is in resonance: it vibrates a whole number of times in a turn"
    if name == SKIDDING_TIME and not problem.programme.corners:
        return "the follower crosses again before friction has turned the roller"
    kinds = next((kind for stroke, kind in MOVE_KINDS.items() if stroke and f"_{stroke}_" in name), ALL_STROKES)
    corners, jumps = (_jump_text(problem, order, kinds) for order in (1, 2))
    if name.startswith("jerk") and not corners:
        return f"the acceleration jumps at {jumps}"
    if name == "contact_stress_max_MPa" and problem.setup.is_knife:
        return "a knife edge has no width"
    if QUANTITIES[name].effect in LOAD_EFFECTS and not corners:
        return _infinite_load_reason(name, problem)
    if name.startswith(("acceleration", "jerk")) or QUANTITIES[name].effect in LOAD_EFFECTS:
        return f"the velocity jumps at {corners}"
    if name == "cutter_radius_max_mm":
        return "no flank of the profile is concave"
    if not corners and problem.setup.angular and problem.setup.mechanism.flat_faced:
        return "the face turns as fast as the cam"
    if not corners:
        return "no part of the profile is convex"
    return f"the pitch curve has corners where the velocity jumps, at {corners}"
