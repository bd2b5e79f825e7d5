"""``fastest_machine``: the highest speed of a machine's shaft up to which every station holds its limits."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import Any, ClassVar

from camopt.core.mistakes import NOTHING_FEASIBLE
from camopt.scene.machine import Machine, MachineSource, machine_from, scene_at_speed
from camopt.solve.machine.stations import resolve_stations
from camopt.solve.tables.cells import number_text
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.verdicts.fastest import Fastest, SpeedLimit, fastest

LOWER_SHARE = 0.5  # share of the least highest speed from which all stations are asked, if the machine is faster


@dataclass(frozen=True)
class MachineFastest(Result):
    """The highest speed of a machine, with the highest speed of each limit of each station.

    Attributes
    ----------
    machine : Machine
        The machine.
    stations : dict of Fastest
        The highest speed of each station's cam, by name.

    Examples
    --------
    >>> found = camopt.fastest_machine("pick-and-place")
    >>> round(found.rpm, 1), found.deciding_station, found.deciding_limit
    (123.1, 'swing', 'contact_force_min')
    """

    machine: Machine
    stations: dict[str, Fastest]
    main_rows: ClassVar[str] = "limits"

    @property
    def rpm(self) -> float | None:
        """Highest speed of the shaft up to which all stations hold all limits [rev/min].

        It is infinite if no speed breaks a limit, None if no speed was found that holds all.
        """
        ends = [
            (each.from_rpm / turns, each.rpm / turns)
            for each, turns in self._stations_with_turns
            if each.rpm is not None and each.from_rpm is not None
        ]
        if len(ends) < len(self.stations):
            return None
        lowest, highest = max(low for low, _ in ends), min(high for _, high in ends)
        return highest if lowest <= highest else None

    @property
    def speed_below_all_highest(self) -> float | None:
        """A speed of the shaft well below the highest speed of every station; None if a station has none."""
        ends = [None if each.rpm is None else each.rpm / turns for each, turns in self._stations_with_turns]
        known = [end for end in ends if end is not None and end != inf]
        return None if None in ends or not known else min(known) * LOWER_SHARE

    @property
    def from_rpm(self) -> float:
        """Speed of the shaft from which all stations hold all limits [rev/min]."""
        return max((each.from_rpm or 0.0) / turns for each, turns in self._stations_with_turns)

    @property
    def _stations_with_turns(self) -> Iterator[tuple[Fastest, int]]:
        return zip(self.stations.values(), (station.ratio for station in self.machine.station), strict=True)

    @property
    def deciding_station(self) -> str:
        """Name of the station whose limit is broken above the highest speed; empty without one."""
        return "" if self.rpm in (None, inf) else self._station_limits_by_shaft_speed[0][0]

    @property
    def deciding_limit(self) -> str:
        """Name of the limit that is broken above the highest speed; empty without one."""
        return "" if self.rpm in (None, inf) else self._station_limits_by_shaft_speed[0][2].limit

    @property
    def _station_limits_by_shaft_speed(self) -> list[tuple[str, int, SpeedLimit]]:
        """Every limit with its station and the turns of its cam, by the speed of the shaft."""
        rows = [
            (name, turns, limit)
            for (name, each), (_, turns) in zip(self.stations.items(), self._stations_with_turns, strict=True)
            for limit in each.limits
        ]
        return sorted(rows, key=lambda row: -inf if row[2].rpm is None else row[2].rpm / row[1])

    @property
    def exit_code(self) -> int:
        """0 if the highest speed is proved, 1 if no speed holds all limits, 4 if a limit is not proved."""
        return NOTHING_FEASIBLE if self.rpm is None else max(each.exit_code for each in self.stations.values())

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes on each station."""
        return tuple(f"{name}: {note}" for name, each in self.stations.items() for note in each.notes)

    def sections(self) -> Iterator[Table | str]:
        """The answer in a sentence, and the table of all limits."""
        if self.rpm is None:
            yield "No speed was found at which every station holds its limits."
        elif self.rpm == inf:
            yield "Every station holds its limits at any speed."
        else:
            yield (
                f"Every station holds its limits from {number_text(self.from_rpm)} to {number_text(self.rpm)} "
                f"rev/min. Above this speed {self.deciding_station} breaks {self.deciding_limit}."
            )
        yield self.table()

    def records(self) -> list[dict[str, Any]]:
        """A record for each limit; speeds are those of the machine's shaft."""

        def shaft_rpm_from_cam_rpm(cam_rpm: float | None, turns: int) -> float | None:
            return None if cam_rpm is None else cam_rpm / turns

        return [
            {
                "station": name,
                **vars(limit),
                "rpm": shaft_rpm_from_cam_rpm(limit.rpm, turns),
                "rpm_per_unit": shaft_rpm_from_cam_rpm(limit.rpm_per_unit, turns),
                "rpm_per_percent": shaft_rpm_from_cam_rpm(limit.rpm_per_percent, turns),
            }
            for name, turns, limit in self._station_limits_by_shaft_speed
        ]

    def table(self) -> Table:
        """A row for each limit of each station, from the lowest highest speed upwards."""
        gains = ((row, row["rpm_per_percent"]) for row in self.records())
        rows = [
            {
                "station": row["station"],
                "limit": row["limit"],
                "highest speed": {None: "none", inf: "any"}.get(row["rpm"]) or number_text(row["rpm"]),
                "gain per 1 %": "" if gain is None else f"{gain:.4g}".replace("-", "−"),
                "proof": row["proof"],
            }
            for row, gain in gains
        ]
        names = ("station", "limit", "highest speed", "gain per 1 %", "proof")
        note = "Speeds are those of the machine's shaft in rev/min."
        return replace(table_of(f"{self.machine.name}: highest speed of each limit", rows, names), note=note)

    def values_for_json(self) -> dict[str, Any]:
        """The answer, and a record for each limit; speeds are those of the machine's shaft."""
        about = {"machine": self.machine.name, "rpm": self.rpm, "from_rpm": self.from_rpm}
        deciding = {"deciding_station": self.deciding_station, "deciding_limit": self.deciding_limit}
        return {**about, **deciding, "limits": self.records()}


def fastest_machine(machine: MachineSource) -> MachineFastest:
    """Find the highest speed up to which every station of a machine holds its limits.

    The speeds of all cams are those of the shaft times their ratios. Clearances do not depend on the speed.

    Parameters
    ----------
    machine : Machine, str or os.PathLike
        A machine with a speed.

    Returns
    -------
    MachineFastest
        The highest speed of the shaft, with that of each limit of each station, proved as in ``fastest``.

    Raises
    ------
    BadInput
        If a scene lacks a size, or if there is no speed.

    Examples
    --------
    >>> found = camopt.fastest_machine("pick-and-place").to_pandas()
    >>> found.station[0], found.limit[0]
    ('swing', 'contact_force_min')
    """
    machine = machine_from(machine)
    stations = {each.name: each for each in resolve_stations(machine)}
    found = MachineFastest(machine, {name: fastest(each.scene) for name, each in stations.items()})
    if found.rpm is None and (lower := found.speed_below_all_highest) is not None:  # below the speed of the machine
        scenes = {name: scene_at_speed(each.scene, lower * each.station.ratio) for name, each in stations.items()}
        found = MachineFastest(machine, {name: fastest(scene) for name, scene in scenes.items()})
    return found
