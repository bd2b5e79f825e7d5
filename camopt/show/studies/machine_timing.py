"""``machine_timing``: when the tools of a machine pass a lift, and for how long two of them are above it together.

For a camshaft these are the openings of the valves, the separation of the lobes and the overlap of two valves.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, ClassVar, NamedTuple

from camopt.core.quantities import displacement_unit
from camopt.scene.machine import Machine, MachineSource, machine_from
from camopt.scene.speed import TURNS_OF_CRANK
from camopt.show.studies.timing import timing
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.result import Result, Table, table_of


class StationPassage(NamedTuple):
    """A range of the machine's angle in which the tool of a station is above a lift.

    Examples
    --------
    >>> first = camopt.machine_timing("camshaft", 1.0).passages[0]
    >>> first.station, round(first.above_deg, 2)
    ('exhaust 1', 115.71)
    """

    station: str
    lift: float
    """Lift above the lowest position [mm or deg]."""
    rises_at_deg: float
    """Angle of the machine's shaft at which the tool passes the lift outward [deg]."""
    falls_at_deg: float
    above_deg: float
    """Angle between both [deg]."""
    centre_deg: float
    """Angle in the middle between both, the centre line of a lobe [deg]."""


class Overlap(NamedTuple):
    """The places of two stations' lobes to each other.

    Examples
    --------
    >>> first = camopt.machine_timing("camshaft", 1.0).overlaps[0]
    >>> first.station, first.other, round(first.separation_deg, 6)
    ('exhaust 1', 'inlet 1', 110.0)
    """

    station: str
    other: str
    lift: float
    """Lift above the lowest position [mm or deg]."""
    separation_deg: float
    """Angle from the centre line of the first to that of the other, from −180 to 180 [deg]."""
    overlap_deg: float
    """Angle in which both are above the lift [deg]."""


@dataclass(frozen=True)
class MachineTiming(Result):
    """The passages of all stations, and the overlaps of every two.

    Attributes
    ----------
    machine : Machine
        The machine.
    passages : tuple of StationPassage
        Passages by station and lift, in the order of the turn.
    overlaps : tuple of Overlap
        The separation and overlap of every two stations with one passage each.

    Examples
    --------
    >>> found = camopt.machine_timing("camshaft", 1.0)
    >>> len(found.passages), [each.overlap_deg > 0 for each in found.overlaps][:2]
    (4, [True, False])
    """

    machine: Machine
    passages: tuple[StationPassage, ...]
    overlaps: tuple[Overlap, ...]
    main_rows: ClassVar[str] = "passages"

    def sections(self) -> Iterator[Table]:
        """Tables of the passages and of the overlaps."""
        yield self.table()
        if self.overlaps:
            yield self._table_in_shown_angles("two stations above the lift together", self.overlaps)

    def table(self) -> Table:
        """A table with a row for each passage."""
        return self._table_in_shown_angles("above a lift", self.passages)

    def _table_in_shown_angles(self, title: str, rows: Iterable[StationPassage | Overlap]) -> Table:
        """A table with crank angles if the scenes give the speed of a crank, which turns twice as fast."""
        records, note, turns = [], "Angles are those of the machine's shaft.", 1.0
        if all(scene.is_speed_of_crank for scene in self.machine.scenes.values()):
            note, turns = "Angles are those of the crankshaft.", TURNS_OF_CRANK
        for row in rows:
            unit = displacement_unit(angular=self.machine.scenes[row.station].tool_turns)
            angles = {
                name: turns * value if name != SEPARATION else value
                for name, value in row._asdict().items()
                if name.endswith("_deg")
            }
            records.append({**row._asdict(), **angles, "lift": with_unit(row.lift, unit)})
        names = records[0] if records else ()
        if SEPARATION in names and turns != 1.0:
            note += " Separations are angles of the camshaft."
        table = table_of(
            f"{self.machine.name}: {title}", records, names, units=dict.fromkeys(names, "deg") | NO_UNITS
        )
        return replace(table, note=note)

    def values_for_json(self) -> dict[str, Any]:
        """A record for each passage and each overlap; angles are those of the machine's shaft."""
        return {"machine": self.machine.name, "passages": self.passages, "overlaps": self.overlaps}


SEPARATION = "separation_deg"
ANGLE_DECIMALS = 9  # of a separation in deg, so that half a turn is 180 and not −180
NO_UNITS = dict.fromkeys(("station", "other", "lift"), "")


def machine_timing(machine: MachineSource, lifts: float | Iterable[float] | None = None) -> MachineTiming:
    """Find when the tools of a machine pass a lift, and for how long two of them are above it together.

    Parameters
    ----------
    machine : Machine, str or os.PathLike
        The machine.
    lifts : float or iterable of float, optional
        Lifts above the lowest position [mm or deg], as for ``timing``.

    Returns
    -------
    MachineTiming
        Angles of the machine's shaft, exact to rounding of the motion.

    Raises
    ------
    BadInput
        For a lift out of the range of a station.

    Examples
    --------
    >>> round(camopt.machine_timing("camshaft", 1.0).overlaps[0].overlap_deg, 3)
    5.728
    """
    machine = machine_from(machine)
    lifts = lifts if lifts is None or isinstance(lifts, int | float) else [*lifts]
    passages = dict[str, list[StationPassage]]()
    for station in machine.station:
        passages[station.name] = sorted(
            StationPassage(
                station.name,
                each.lift,
                rises := (station.phase + (each.rises_at_deg + 360.0 * turn) / station.ratio) % 360.0,
                (rises + each.above_deg / station.ratio) % 360.0,
                each.above_deg / station.ratio,
                (rises + 0.5 * each.above_deg / station.ratio) % 360.0,
            )
            for each in timing(machine.scenes[station.name], lifts).passages
            for turn in range(station.ratio)
        )
    overlaps = [
        _overlap(at_lift, others_at_lift)
        for one, other in combinations(passages, 2)
        for lift in dict.fromkeys(each.lift for each in passages[one])
        if (at_lift := [each for each in passages[one] if each.lift == lift])
        and (others_at_lift := [each for each in passages[other] if lifts is None or each.lift == lift])
    ]
    return MachineTiming(machine, tuple(each for rows in passages.values() for each in rows), tuple(overlaps))


def _overlap(passages: list[StationPassage], other_passages: list[StationPassage]) -> Overlap:
    """The separation of the first passages of two stations, and the sum of their overlaps."""
    one, other = passages[0], other_passages[0]
    overlap = sum(
        max(0.0, min(a.above_deg, start + b.above_deg) - max(0.0, start))
        for a in passages
        for b in other_passages
        for start in (
            (b.rises_at_deg - a.rises_at_deg) % 360.0,
            (b.rises_at_deg - a.rises_at_deg) % 360.0 - 360.0,
        )
    )
    separation = 180.0 - round((one.centre_deg - other.centre_deg + 180.0) % 360.0, ANGLE_DECIMALS) % 360.0
    return Overlap(one.station, other.station, one.lift, separation, overlap)
