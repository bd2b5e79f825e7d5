"""Timing: at which cam angles the follower passes a given lift, on the way out and on the way back.

Where it does so is a root of the motion's polynomial on a panel, found to rounding. A follower that rests at the
lift is not above it. With tolerances, all cams within them pass it between two cam angles, to first order
(``tolerances.passing``) and proved by exact contact (``tolerances.dwells_and_passages``).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import degrees, radians
from numbers import Real
from typing import Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.panels import derivatives
from camopt.core.numerics.piecewise import sign_changes
from camopt.core.quantities import displacement_unit
from camopt.model.effects.motion import motion_scale, motion_table_unit
from camopt.model.motion.programme import Programme
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.scene.speed import TURNS_OF_CRANK
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.tolerances.dwells_and_passages import LevelPassages, NominalPassage, WorstPassage, worst_passages
from camopt.solve.tolerances.errors import error_unit
from camopt.solve.tolerances.turn_errors import TurnErrors

DEFAULT_SHARE = 0.5  # of the largest lift, where a scene gives no lash
EQUAL_LEVELS = 1e-12  # rad: roots nearer to each other are one, at the end of a panel


class Passage(NamedTuple):
    """A stretch of the turn over which the follower is above a lift.

    Examples
    --------
    >>> (above,) = camopt.timing(camopt.find_scene("bucket-valve"), [1.0]).passages
    >>> round(above.rises_at_deg, 4), round(above.falls_at_deg, 4)
    (34.1269, 149.8731)
    """

    lift: float
    """mm (deg), from the lowest position."""
    rises_at_deg: float
    """The cam angle where it passes the lift outward."""
    falls_at_deg: float
    """The cam angle where it passes the lift inward."""
    above_deg: float
    """The cam angle between the two, past the start of the turn if need be."""
    rising: float
    """The velocity where it passes outward, in ``Timing.velocity_unit``."""
    falling: float
    """The velocity where it passes inward, below 0."""
    rises_earliest_deg: float | None = None
    """With ``[tolerances]``: no cam within them passes it outward sooner, to first order; before the start of the
    turn if need be, and infinite where some cam does not pass it."""
    rises_latest_deg: float | None = None
    falls_earliest_deg: float | None = None
    falls_latest_deg: float | None = None


@dataclass(frozen=True)
class Timing(Result):
    """Where the follower is above given lifts.

    Attributes
    ----------
    scene : Scene
        What was asked.
    passages : tuple of Passage
        Lift by lift, each in the order of the turn.
    velocity_unit : str
        m/s (rad/s), or without rpm mm/rad (deg/rad).
    worst : tuple of WorstPassage
        With ``[tolerances]``, of each passage: before and after which cam angle no cam within them passes, proved
        by exact contact, and a cam that nearly does.

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

    def sections(self) -> Iterator[Table]:
        """The passages; with tolerances, when no cam within them passes."""
        yield self.table()
        yield from filter(None, (self.worst_table(),))

    def document(self) -> dict[str, Any]:
        """A record for each passage, and for each of its ends that is proved."""
        about = {"scene": self.scene.name, "velocity_unit": self.velocity_unit}
        return {**about, "passages": self.records(), "worst": self.worst}

    def records(self) -> list[dict[str, float]]:
        """A mapping for each passage; with angles of the crank, of a scene that gives its speed."""
        found = [
            {name: value for name, value in each._asdict().items() if value is not None} for each in self.passages
        ]
        return [each | self._crank_angles(each) for each in found]

    def table(self) -> Table:
        """A row for each passage."""
        rows = self.records()
        units = {
            **{name: "deg" for row in rows for name in row if name.endswith("_deg")},
            "lift": displacement_unit(angular=self.scene.tool_turns),
            "rising": self.velocity_unit,
            "falling": self.velocity_unit,
        }
        names = dict.fromkeys(name for row in rows for name in row)
        return table_of(f"{self.scene.name}: above a lift", rows, names, units=units)

    def worst_table(self) -> Table | None:
        """When no cam within the tolerances passes, with the errors of one that nearly does; None without any."""
        rows = [self._worst_row(each) for each in self.worst]
        units = dict.fromkeys(("bound_deg", "gap_deg"), "deg")
        units["lift"] = displacement_unit(angular=self.scene.tool_turns)
        title = f"{self.scene.name}: no cam within the tolerances passes sooner or later, proved"
        why = dict.fromkeys(each.unproved for each in self.worst if each.unproved)
        told = "".join(f"No bound is known where it is infinite: {each}. " for each in why).strip()
        return replace(table_of(title, rows, [*rows[0]], units=units), note=told) if rows else None

    def _worst_row(self, worst: WorstPassage) -> dict[str, Any]:
        """A row of it."""
        said = ", ".join(
            f"{key} {with_unit(each, error_unit(self.scene, key))}" for key, each in worst.errors.items()
        )
        about = {name: getattr(worst, name) for name in ("lift", "passage", "end", "bound_deg", "gap_deg")}
        return {**about, "a cam that nearly does": said}

    def _crank_angles(self, passage: dict[str, float]) -> dict[str, float]:
        """The cam angles as angles of the crank, which is at 0 with the cam, where the scene gives its speed."""
        angles = passage if self.scene.by_crank else {}
        suffix = "_deg"
        return {
            f"{name.removesuffix(suffix)}_crank{suffix}": TURNS_OF_CRANK * angle
            for name, angle in angles.items()
            if name.endswith(suffix)
        }


def timing(scene: SceneSource, lifts: float | Iterable[float] | None = None) -> Timing:
    """Find the cam angles at which the follower passes given lifts.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        Its sizes play no part, but for its ``[tolerances]``: with these, and sizes, the earliest and the latest cam
        angle of each passage are found too.
    lifts : float or iterable of float, optional
        From the lowest position, mm (deg), each above 0 and below the largest. By default the lash of the scene
        (``follower.dynamics.lash``), or else half of the largest lift.

    Returns
    -------
    Timing
        The stretches of the turn above each lift; cam angles right to rounding of the motion.

    Raises
    ------
    BadInput
        For a lift that is not passed.

    Examples
    --------
    >>> (above,) = camopt.timing(camopt.find_scene("knife-300rpm-radial")).passages
    >>> round(above.rises_at_deg, 6) < round(above.falls_at_deg, 6)
    True
    """
    scene = scene_from(scene)
    problem = resolve(scene)
    setup, programme = problem.setup, problem.programme.tool
    most = programme.lift / programme.unit
    if lifts is None:
        lash = scene.follower.dynamics and scene.follower.dynamics.lash
        lifts = (lash or DEFAULT_SHARE * most,)
    levels = [*lifts] if isinstance(lifts, Iterable) and not isinstance(lifts, str) else [lifts]
    unit = motion_table_unit(setup, 0)
    allowed = f"numbers above 0 and below the largest lift ({most:.6g} {unit})"
    wrong = [each for each in levels if isinstance(each, bool) or not isinstance(each, Real) or not 0 < each < most]
    if wrong:
        raise BadInput([Mistake(problem.file, "lift", each, allowed) for each in wrong])
    found = [each for lift in levels for each in _passages(programme, float(lift), motion_scale(setup, 1))]
    worst = list[WorstPassage]()
    if not problem.missing_variables and (turn := TurnErrors(scene, problem)).node_contributions:
        found = [_with_passing_range(each, LevelPassages(turn, each.lift * programme.unit)) for each in found]
        worst += worst_passages(turn, [asked for each in found for asked in _passage_events(each, programme.unit)])
    return Timing(scene, tuple(found), motion_table_unit(setup, 1), tuple(worst))


def _passage_events(passage: Passage, unit: float) -> Iterator[NominalPassage]:
    """The two events of a passage."""
    for name, angle in ("rises", passage.rises_at_deg), ("falls", passage.falls_at_deg):
        yield NominalPassage(passage.lift, passage.lift * unit, name, radians(angle))


def _with_passing_range(passage: Passage, passing: LevelPassages) -> Passage:
    """A passage with the cam angles between which all cams pass."""
    rises = passing.passage_range(radians(passage.rises_at_deg), outward=True)
    falls = passing.passage_range(radians(passage.falls_at_deg), outward=False)
    return passage._replace(
        rises_earliest_deg=degrees(rises.earliest),
        rises_latest_deg=degrees(rises.latest),
        falls_earliest_deg=degrees(falls.earliest),
        falls_latest_deg=degrees(falls.latest),
    )


def _passages(programme: Programme, lift: float, by_angle: float) -> list[Passage]:
    """The stretches of the turn above a lift; ``by_angle`` makes a velocity of a slope by the cam angle."""
    table, level = programme.table, lift * programme.unit
    series = table.coefficients.T.copy()
    series[0] -= level
    ends = table.centre - table.half_width
    roots = [table.centre[panel] + table.half_width[panel] * u for panel, u in sign_changes(series)]
    places = np.unique(np.concatenate([ends, roots, [programme.strokes[-1].end]]))
    places = places[np.diff(places, prepend=-np.inf) > EQUAL_LEVELS]
    above = _motion_at(programme, (places[:-1] + places[1:]) / 2)[0] > level
    outward, inward = (np.flatnonzero(above & ~np.roll(above, 1)), np.flatnonzero(~above & np.roll(above, 1)))
    found = []
    for start in places[outward]:
        later = (places[inward] - start) % (2 * np.pi)
        end = places[inward][np.argmin(later)]
        slopes = _motion_at(programme, np.array([start, end]))[1] * by_angle
        found.append(
            Passage(lift, degrees(start), degrees(end), degrees(later.min()), float(slopes[0]), float(slopes[1]))
        )
    return found


def _motion_at(programme: Programme, angles: FloatArray) -> Any:
    """The displacement and its derivatives at cam angles, as tabulated."""
    table = programme.table
    panels = np.searchsorted(table.centre + table.half_width, angles).clip(max=len(table.centre) - 1)
    return derivatives(table, panels, (angles - table.centre[panels]) / table.half_width[panels])
