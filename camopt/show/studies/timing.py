"""``timing``: the cam angles at which the follower passes a lift, on its way out and back.

The cam angle is a root of the motion's polynomial on a panel, exact to rounding. A follower that rests at the lift
is not above it. With tolerances, all cams within them pass the lift between two cam angles. These are computed to
first order, and proved by exact contact (``tolerances.dwells_and_passages``).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import degrees, radians
from numbers import Real
from typing import Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics.turn_curve import TURN
from camopt.core.quantities import displacement_unit
from camopt.model.effects.motion import motion_table_unit, motion_unit_factor
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.scene.speed import TURNS_OF_CRANK
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.tolerances.dwells_and_passages import NominalPassage, WorstPassage, passage_range, worst_passages
from camopt.solve.tolerances.errors import error_unit
from camopt.solve.tolerances.turn_errors import TurnErrors

LASH = "follower.dynamics.lash"
DEFAULT_SHARE = 0.5  # default lift as share of the largest, if the scene has no lash


class Passage(NamedTuple):
    """A range of cam angles in which the follower is above a lift.

    Examples
    --------
    >>> (above,) = camopt.timing(camopt.find_scene("bucket-valve"), [1.0]).passages
    >>> round(above.rises_at_deg, 4), round(above.falls_at_deg, 4)
    (34.1269, 149.8731)
    """

    lift: float
    """Lift above the lowest position [mm or deg]."""
    rises_at_deg: float
    """Cam angle at which the follower passes the lift outward [deg]."""
    falls_at_deg: float
    """Cam angle at which it passes the lift inward [deg]."""
    above_deg: float
    """Angle between both, also across the start of the turn [deg]."""
    rising: float
    """Velocity outward at the lift, in ``Timing.velocity_unit``."""
    falling: float
    """Velocity inward at the lift, below 0."""
    rises_earliest_deg: float | None = None
    """Earliest cam angle outward of all cams within ``[tolerances]``, to first order [deg].

    It may be below 0. It is infinite if some cam does not pass the lift.
    """
    rises_latest_deg: float | None = None
    falls_earliest_deg: float | None = None
    falls_latest_deg: float | None = None


@dataclass(frozen=True)
class Timing(Result):
    """The ranges of cam angles in which the follower is above given lifts.

    Attributes
    ----------
    scene : Scene
        The scene of the motion.
    passages : tuple of Passage
        Passages by lift, in the order of the turn.
    velocity_unit : str
        m/s or rad/s; without rpm mm/rad or deg/rad.
    worst : tuple of WorstPassage
        With ``[tolerances]``, for each end of a passage: proven bounds of the cam angle over all cams within them,
        by exact contact, and a cam that comes near the bound.

    Examples
    --------
    >>> found = camopt.timing(camopt.find_scene("bucket-valve"), [1.0])
    >>> len(found.passages), found.passages[0].above_deg > 90
    (1, True)
    """

    scene: Scene
    passages: tuple[Passage, ...]
    velocity_unit: str
    worst: tuple[WorstPassage, ...] = ()
    main_rows: ClassVar[str] = "passages"

    @property
    def notes(self) -> tuple[str, ...]:
        """A note on tolerances of the lash, which change the lift at which a valve opens and not its cam angle."""
        if LASH not in self.scene.tolerances.numbers:
            return ()
        return (
            f"the lifts are fixed: earliest and latest cam angles are without the tolerance of {LASH}; "
            "give the lifts at both ends of it",
        )

    def sections(self) -> Iterator[Table]:
        """Tables of the passages and, with tolerances, of their proven bounds, with a cam near each."""
        yield self.table()
        if not self.worst:
            return
        rows = []
        for worst in self.worst:
            row = {name: getattr(worst, name) for name in ("lift", "passage", "end", "bound_deg", "gap_deg")}
            errors = (f"{key} {with_unit(each, error_unit(self.scene, key))}" for key, each in worst.errors.items())
            rows.append({**row, "errors of a cam near the bound": ", ".join(errors)})
        units = dict.fromkeys(("bound_deg", "gap_deg"), "deg")
        units["lift"] = displacement_unit(angular=self.scene.tool_turns)
        title = f"{self.scene.name}: proven bounds of the cam angle, over all cams within the tolerances"
        reasons = dict.fromkeys(each.unproved for each in self.worst if each.unproved)
        note = "".join(f"An infinite bound is not proved: {reason}. " for reason in reasons).strip()
        yield replace(table_of(title, rows, [*rows[0]], units=units), note=note)

    def values_for_json(self) -> dict[str, Any]:
        """A record for each passage, and for each proven bound."""
        about = {"scene": self.scene.name, "velocity_unit": self.velocity_unit}
        return {**about, "passages": self.records(), "worst": self.worst}

    def records(self) -> list[dict[str, float]]:
        """A record for each passage; with crank angles if the scene gives the speed of the crank."""
        records = []
        for each in self.passages:
            record = {name: value for name, value in each._asdict().items() if value is not None}
            if self.scene.is_speed_of_crank:
                record |= {
                    f"{name.removesuffix('_deg')}_crank_deg": TURNS_OF_CRANK * angle
                    for name, angle in record.items()
                    if name.endswith("_deg")
                }
            records.append(record)
        return records

    def table(self) -> Table:
        """A table with a row for each passage."""
        rows = self.records()
        units = {
            **{name: "deg" for row in rows for name in row if name.endswith("_deg")},
            "lift": displacement_unit(angular=self.scene.tool_turns),
            "rising": self.velocity_unit,
            "falling": self.velocity_unit,
        }
        names = dict.fromkeys(name for row in rows for name in row)
        return table_of(f"{self.scene.name}: above a lift", rows, names, units=units)


def timing(scene: SceneSource, lifts: float | Iterable[float] | None = None) -> Timing:
    """Find the cam angles at which the follower passes given lifts.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        The scene. Its sizes matter only with ``[tolerances]``: then the earliest and the latest cam angle of each
        passage are computed too.
    lifts : float or iterable of float, optional
        Lifts above the lowest position [mm or deg], above 0 and below the largest lift. Default: the lash of the
        scene (``follower.dynamics.lash``), or without lash half of the largest lift.

    Returns
    -------
    Timing
        The ranges above each lift; cam angles are exact to rounding of the motion.

    Raises
    ------
    BadInput
        For a lift out of range.

    Examples
    --------
    >>> (above,) = camopt.timing(camopt.find_scene("knife-300rpm-radial")).passages
    >>> round(above.rises_at_deg, 6) < round(above.falls_at_deg, 6)
    True
    """
    scene = scene_from(scene)
    problem = resolve(scene)
    setup, programme = problem.setup, problem.programme.tool
    largest = programme.lift / programme.unit_in_mm_or_rad
    if lifts is None:
        lash = scene.follower.dynamics and scene.follower.dynamics.lash
        lifts = (lash or DEFAULT_SHARE * largest,)
    levels = [*lifts] if isinstance(lifts, Iterable) and not isinstance(lifts, str) else [lifts]
    allowed = f"above 0 and below the largest lift ({largest:.6g} {motion_table_unit(setup, 0)})"
    wrong = [
        level
        for level in levels
        if isinstance(level, bool) or not isinstance(level, Real) or not 0 < level < largest
    ]
    if wrong:
        raise BadInput([Mistake(problem.file, "lift", each, allowed) for each in wrong])
    passages, velocity_per_slope = [], motion_unit_factor(setup, 1)
    for lift in map(float, levels):
        for start, end in programme.lift_curve.spans_above(lift * programme.unit_in_mm_or_rad):
            slopes = programme.lift_curve.derivative.value(np.mod([start, end], TURN)) * velocity_per_slope
            angles = degrees(start), degrees(end % TURN), degrees(end - start)
            passages.append(Passage(lift, *angles, *map(float, slopes)))
    worst = list[WorstPassage]()
    if not problem.missing_variables and (turn := TurnErrors(scene, problem)).node_contributions:
        passages = [
            _with_earliest_and_latest_angles(each, turn, each.lift * programme.unit_in_mm_or_rad)
            for each in passages
        ]
        worst += worst_passages(
            turn, [event for each in passages for event in _passage_ends(each, programme.unit_in_mm_or_rad)]
        )
    return Timing(scene, tuple(passages), motion_table_unit(setup, 1), tuple(worst))


def _passage_ends(passage: Passage, unit_factor: float) -> Iterator[NominalPassage]:
    """Both ends of a passage."""
    for name, angle in ("rises", passage.rises_at_deg), ("falls", passage.falls_at_deg):
        yield NominalPassage(passage.lift, passage.lift * unit_factor, name, radians(angle))


def _with_earliest_and_latest_angles(passage: Passage, turn: TurnErrors, level: float) -> Passage:
    """A passage of a level [mm or rad] with the earliest and latest cam angles of all cams, to first order."""
    rises = passage_range(turn, level, radians(passage.rises_at_deg), outward=True)
    falls = passage_range(turn, level, radians(passage.falls_at_deg), outward=False)
    return passage._replace(
        rises_earliest_deg=degrees(rises.earliest),
        rises_latest_deg=degrees(rises.latest),
        falls_earliest_deg=degrees(falls.earliest),
        falls_latest_deg=degrees(falls.latest),
    )
