"""One design: every quantity that a scene calls for."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple, overload
from warnings import warn

import numpy as np

from camopt.core.mistakes import UnknownName, suggest_names
from camopt.core.quantities import QUANTITIES, Flag, Word, displacement_unit, in_column_order
from camopt.core.quantities.display import Drawable
from camopt.core.quantities.unit_systems import MM, shown_in, shown_unit, to_shown_unit
from camopt.model.effects import EvaluationBlock, find_quantity
from camopt.model.effects.clearance import SKIDDING_TIME
from camopt.model.effects.contacts import CONTACT_NAMES
from camopt.model.effects.joints import JointRow, joint_rows
from camopt.model.effects.motion import MOVE_KINDS, motion_scale, motion_table_unit
from camopt.model.effects.peak import Peak
from camopt.model.effects.peak_columns import peak_column
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.numbers_with_units import NumberWithUnit, numbers_with_units
from camopt.scene.problem.limit import QuantityLimit
from camopt.scene.problem.problem import Problem, at_rounding_error, resolve, resolve_design
from camopt.scene.problem.scene_notes import notes_on_scene
from camopt.scene.scene import Scene
from camopt.scene.speed import TURNS_OF_CRANK
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.designs import design_table, is_zero_column
from camopt.solve.tables.result import Cell, Result, Table, table_of
from camopt.solve.verdicts.design_warnings import farthest_point, warnings_of
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_verdicts import evaluate_rows
from camopt.solve.verdicts.verdict_words import ARM_UNCHECKED

PROOFS = {
    "certified": "proved at every cam angle",
    "sampled": "proved for the spline of a table",
    "undecided": "not proved",
}
"""What the status of a design says of its verdict."""


@dataclass(frozen=True)
class Evaluation(Result, Drawable, Mapping[str, Any]):
    """The quantities of one design: a mapping from name to value.

    Attributes
    ----------
    scene : Scene
        What was evaluated.
    quantities : dict
        The values by name: numbers, but for ``feasible`` and the like, which are true or false, and texts.
    unbounded : dict
        For each value that is infinite, why it is.
    warnings : tuple of str
        What to know of the cam unasked: that an elastic train loses contact where a rigid one keeps it, and that
        moves go beyond every position that was asked.

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
                raise UnknownName(f"{name!r} was not computed; name it in the outputs of the scene")
            raise UnknownName(f"{name!r} is no quantity of this evaluation; {suggest_names(str(name), self)}")
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
        """Every quantity with its unit, limit and meaning, or the reason why it is infinite: a row each."""
        names = [name for name in self if not is_zero_column(self.scene.search.sizes, name, [self])]
        reasons, problem = {name: Cell(reason) for name, reason in self.unbounded.items()}, resolve(self.scene)
        about = {name: reasons.get(name, find_quantity(name, problem.setup).sentence) for name in names}
        return design_table(self.scene.name, problem, self, about)

    def sections(self) -> Iterator[Table | str]:
        """The verdict, every quantity, the largest lift, the forces in joints and the numbers of the scene."""
        yield self.verdict
        yield self.table()
        yield _lift_sentence(self.scene)
        if self.tightest:
            yield f"Tightest of both contacts: {self.tightest}."
        if self.scene.mechanism.motion.angular:
            yield f"{ARM_UNCHECKED}."
        if joints := [
            {name: "" if value is None else value for name, value in each._asdict().items()}
            for each in self.joint_forces
        ]:
            yield ""
            yield table_of(JOINTS_TITLE, joints, joints[0])
            yield JOINTS_NOTE
        if read := numbers_with_units(self.scene):
            rows = [
                {"key": each.key, "value": scene_number_text(each), "unit": shown_unit(each.unit)} for each in read
            ]
            yield ""
            yield table_of("Numbers of the scene, as they are read", rows, ["key", "value", "unit"])
        if self.scene.by_crank:
            yield _crank_speed_sentence(self)

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
        """Warnings, and what of the scene is odd or unused."""
        return (*self.warnings, *notes_on_scene(self.scene))

    @property
    def half_width(self) -> float:
        """The relative half-width of the values' enclosures."""
        return float(self["relative_half_width"])

    @property
    def joint_forces(self) -> list[JointRow]:
        """The forces in each joint of a train, if the scene calls for them.

        Of each the stage, the joint, the least and the largest force over the turn, N, and the cam angle of the
        largest magnitude, deg, with its direction there. Above 0 a coupler is pushed and a roller pressed on its
        face. On a pivot the largest sum of the magnitudes of both forces on it.
        """
        problem = resolve(self.scene)
        called = any(find_quantity(name, problem.setup).effect == "joints" for name in self)
        return joint_rows(problem.setup, problem.programme) if called else []

    @property
    def tightest(self) -> str:
        """Of a follower with two contacts, the one that a limit holds the closest; else empty."""
        problem = resolve_design(self.scene)
        return tightest_contact(at_rounding_error(problem)) if problem.setup.mechanism.further_contacts else ""

    def to_json(self) -> dict[str, Any]:
        """The old name of ``to_dict``."""
        warn("to_json is now to_dict", DeprecationWarning, stacklevel=2)
        return dict(self.to_dict())

    def document(self) -> dict[str, Any]:
        """The values; the reasons of infinite ones under ``unbounded``, and ``warnings``, if any."""
        joints = [{name: v for name, v in row._asdict().items() if v is not None} for row in self.joint_forces]
        with shown_in(MM):  # whatever is shown, as the names of quantities say
            unbounded = (
                _infinity_reasons(self.unbounded, at_rounding_error(resolve_design(self.scene)))
                if self.unbounded
                else {}
            )
        about = {"unbounded": unbounded, "joint_forces": joints, "warnings": list(self.warnings)}
        about |= {"tightest": self.tightest}
        return self.quantities | {name: value for name, value in about.items() if value}


def _lift_sentence(scene: Scene) -> str:
    """The largest lift, and where it is."""
    programme, unit = resolve(scene).programme.tool, displacement_unit(angular=scene.tool_turns)
    angle = np.degrees(farthest_point(programme, 1.0).angle)
    whose, lift = " of the tool" if scene.train else "", with_unit(programme.lift / programme.unit, unit)
    return f"Largest lift{whose}: {lift}, reached at {number_text(float(angle))}°."


def _crank_speed_sentence(result: Evaluation) -> str:
    """The sentence on speeds in the results of a scene that gives the speed of a crankshaft."""
    what = "Results are at the speed of the cam, and speeds among them are the cam's, half those of the crankshaft"
    jump = result.get("jump_speed_rpm")
    return what + (
        "." if jump is None else f": a jump speed of {number_text(TURNS_OF_CRANK * jump)} rev/min there."
    )


def scene_number_text(read: NumberWithUnit) -> str:
    """A number of the scene, as it is shown; of a load that changes, how many rows it has."""
    value = read.value
    return number_text(to_shown_unit(value, read.unit)) if isinstance(value, float) else f"{len(value):,} rows"


JOINTS_TITLE = "Forces in the joints of the train over the turn"
JOINTS_NOTE = (
    "Above 0 a coupler is pushed and a roller pressed on its face, below 0 pulled and lifted off. On a pivot: the "
    "sum of the magnitudes of both forces on it, the largest that it can be. Directions, of the largest, are from "
    "the motion of the slide, those of a four-bar's coupler from the line of its pivots."
)


def evaluate(scene: SceneSource) -> Evaluation:
    """Compute every quantity that a scene calls for, for the sizes that the scene gives.

    Extremes are those of the continuous motion, with a relative error of at most 1e-13, or the scene's own if
    that is smaller. An infinite quantity (such as the acceleration of a uniform-velocity law) is ``inf``, and
    ``unbounded`` says why.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with sizes of its own.

    Returns
    -------
    Evaluation
        The quantities by name (``QUANTITIES`` lists all), with ``feasible`` and ``violated`` among them.

    Raises
    ------
    BadInput
        If the scene lacks a size of its own.

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
    """As ``evaluate``, for a scene already resolved to a problem."""
    problem = at_rounding_error(problem)
    (found,) = evaluate_rows(problem, problem.design, problem.evaluated_quantities | problem.size_names).records()
    values = {name: found[name] for name in in_column_order(found)}
    unbounded = _infinity_reasons((n for n, v in values.items() if v in (inf, -inf)), problem)
    return Evaluation(scene, values, unbounded, warnings_of(problem))


def _infinity_reasons(names: Iterable[str], problem: Problem) -> dict[str, str]:
    """Why quantities are infinite, by name."""
    return {name: _infinity_reason(name, problem) for name in names}


LOAD_EFFECTS = ("force", "torque", "joints", "thrust", "hertz", "surface")


def _infinite_load_reason(name: str, problem: Problem) -> str:
    """Why a load of a motion without corners is infinite."""
    effect, setup = QUANTITIES[name].effect, problem.setup
    if effect == "force":
        return "the force is too low where the follower is at its lowest, and no spring rate adds to it there"
    case = EvaluationBlock(setup, problem.programme, problem.design)
    shaped = effect in ("hertz", "surface") and not setup.is_knife
    if shaped and run_effects(case, ["undercut"]).column("undercut")[0]:
        return "the profile is undercut"
    if not setup.mechanism.flat_faced:
        return "the follower jams in its guide"
    return "the contact stands still" if effect == "surface" else "the contact passes the follower's pivot"


def _jump_text(problem: Problem, order: int, kinds: int) -> str:
    """Where a derivative of the asked motion jumps, beside strokes of some kinds, and by how much at most."""
    found = [j for j in problem.programme.tool.jumps if j.order == order and j.kinds & kinds]
    if not found:
        return ""
    unit, size = (
        motion_table_unit(problem.setup, order),
        max(abs(j.size) for j in found) * motion_scale(problem.setup, order),
    )
    most = "at most " if len(found) > 1 else ""
    return f"{', '.join(f'{np.degrees(j.at):g}°' for j in found)}, by {most}{with_unit(size, unit)}"


def _infinity_reason(name: str, problem: Problem) -> str:
    """Why a quantity is infinite."""
    if name in problem.setup.own_quantities:
        return "its expression has no finite value here"
    if QUANTITIES[name].effect == "vibration":
        return "the undamped train resonates: it vibrates a whole number of times in a turn"
    if name == SKIDDING_TIME and not problem.programme.corners:
        return "friction has not turned the roller before the follower crosses again"
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


TIE_SHARE = 1e-9
"""Relative: two contacts this near to each other are told as one."""


class ContactExcess(NamedTuple):
    """The contact that is the nearest to a bound, or the furthest beyond it."""

    excess: float
    """Relative."""
    limit: str
    place: str
    words: str


def tightest_contact(problem: Problem) -> str:
    """The contact that the limits of a problem hold the closest, for its own design; empty if there is only one."""
    found = [
        each
        for limit in problem.limits
        if isinstance(limit, QuantityLimit)
        for each in _contact_excesses(problem, limit)
    ]
    if not found:
        return ""
    most = max(found)
    others = [each for each in found if each != most and each.limit == most.limit]
    alike = any(abs(each.excess - most.excess) <= TIE_SHARE for each in others)
    place = "both contacts" if alike else f"the {most.place} contact"
    return f"{most.limit} at {place}: {most.words}"


def _contact_excesses(problem: Problem, limit: QuantityLimit) -> Iterator[ContactExcess]:
    """The contacts that a limit bounds."""
    if not limit.further_peaks or not limit.set_by_scene or not isinstance(limit.peak_or_mean, Peak):
        return
    case, quantity = (
        EvaluationBlock(problem.setup, problem.programme, problem.design),
        QUANTITIES[limit.quantities[0]],
    )
    for place, peak in zip(CONTACT_NAMES, (limit.peak_or_mean, *limit.further_peaks), strict=True):
        value = float(np.squeeze(peak_column(case, peak).value))
        excess = quantity.side * (value - limit.bound) / (abs(limit.bound) or 1.0)
        bound = f"{limit.relation} {with_unit(limit.bound, quantity.unit)}"
        yield ContactExcess(excess, limit.key, place, f"{with_unit(value, quantity.unit)}, {bound}")
