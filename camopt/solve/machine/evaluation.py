"""What a machine does: the verdicts on stations and clearances, the torque of the shaft, flywheel and motors."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import degrees
from typing import Any, ClassVar

import numpy as np

from camopt.core.quantities.display import Drawable
from camopt.scene.machine import Clearance, Machine, MachineSource, machine_from
from camopt.solve.machine.clearances import ClearanceResult, clearances_of_machine
from camopt.solve.machine.shaft import MotorUse, Shaft, motor_uses, shaft_of_machine, smallest_motor
from camopt.solve.machine.stations import ResolvedStation, clearance_unit, resolve_stations
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.verdicts.certify import exit_code_of_verdicts
from camopt.solve.verdicts.evaluation import Evaluation, evaluate_design
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED, worst_verdict


@dataclass(frozen=True, eq=False)
class MachineEvaluation(Result, Drawable):
    """A machine's stations, clearances, shaft and motors.

    Attributes
    ----------
    machine : Machine
        The evaluated machine.
    resolved : tuple of ResolvedStation
        The stations with their curves over a turn of the shaft.
    stations : dict of Evaluation
        The quantities of each station by name, at the speed of its cam.
    clearances : tuple of ClearanceResult
        The least of each clearance, with the slacks of its phases.
    shaft : Shaft or None
        The torque of the shaft; None if no station has a torque.
    motors : tuple of MotorUse
        The motors of the catalogue.

    Examples
    --------
    >>> found = camopt.evaluate_machine("pick-and-place")
    >>> found.verdict, [*found.stations]
    ('held', ['lift', 'swing', 'grip', 'feed'])
    """

    picture: ClassVar[str] = "machines.timing_sheet"
    main_rows: ClassVar[str] = "stations"
    machine: Machine
    resolved: tuple[ResolvedStation, ...]
    stations: dict[str, Evaluation]
    clearances: tuple[ClearanceResult, ...]
    shaft: Shaft | None
    motors: tuple[MotorUse, ...] = ()

    def __repr__(self) -> str:
        return f"<MachineEvaluation of {self.machine.name}: {len(self.stations)} stations, {self.verdict}>"

    @property
    def verdict(self) -> str:
        """Whether all limits of all stations and all clearances are "held", "broken" or "undecided"."""
        stations = map(station_verdict, self.stations.values())
        return worst_verdict([*stations, *(clearance.verdict for clearance in self.clearances)])

    @property
    def exit_code(self) -> int:
        """Exit code of the command: 0 all held, 1 a limit or clearance is broken, 4 one is undecided."""
        return exit_code_of_verdicts([self.verdict])

    @property
    def notes(self) -> Iterator[str]:
        """Replaced speeds, stations without a torque, sums of mm and deg, and the warnings of each station."""
        yield from self.machine.speed_notes
        for _, found, unit in self._clearances_with_units:
            if not unit:
                yield f"the clearance {found.title} adds lifts in mm and in deg"
        for station in self.resolved:
            if station.missing_torque_reason:
                yield f"{station.name} has no torque: {station.missing_torque_reason}"
        for name, evaluation in self.stations.items():
            yield from (f"{name}: {warning}" for warning in evaluation.warnings)

    def sections(self) -> Iterator[Table | str]:
        """The verdict, and tables of the stations, the shaft and the motors."""
        yield self.verdict_sentence
        yield self.table()
        yield from filter(
            None, (self.clearance_table(), self.slack_table(), self.shaft_table(), self.motor_table())
        )

    @property
    def verdict_sentence(self) -> str:
        """A sentence on what holds and what does not."""
        broken = [
            f"{name} breaks {str(each['violated']).replace(',', ', ')}"
            for name, each in self.stations.items()
            if each["violated"]
        ]
        broken += [
            f"the clearance {found.title} is {with_unit(found.displayed_upper_bound, unit)} "
            f"at {number_text(found.angle)}°"
            + ", where the tools touch or overlap"
            * (given.along is None and found.displayed_upper_bound == 0.0)
            for given, found, unit in self._clearances_with_units
            if found.verdict == BROKEN
        ]
        if broken:
            return f"Not feasible: {'; '.join(broken)}."
        return {
            HELD: f"Feasible: every limit of every station{' and every clearance' * bool(self.clearances)} is met.",
            UNDECIDED: "Undecided: whether every limit and clearance is met is not proved.",
        }[self.verdict]

    def values_for_json(self) -> dict[str, Any]:
        """The verdict, a record for each station, the shaft and the motors."""
        about = {"machine": self.machine.name, "rpm": self.machine.shaft_rpm, "verdict": self.verdict}
        return {
            **about,
            "stations": self.records(),
            "clearances": [vars(each) for each in self.clearances],
            "slacks": self.slack_records(),
            "shaft": self.shaft_record(),
            "motors": [
                {"smallest": use == smallest_motor(self.machine, self.motors), **use._asdict()}
                for use in self.motors
            ],
        }

    def records(self) -> list[dict[str, Any]]:
        """A record for each station: its place in the cycle, its lift, its verdict, its share of the torque."""
        return [self._record_of_station(station) for station in self.resolved]

    def _record_of_station(self, station: ResolvedStation) -> dict[str, Any]:
        evaluation, torque = self.stations[station.name], station.torque
        record: dict[str, Any] = {
            "station": station.name,
            "scene": station.scene.name,
            "phase_deg": station.station.phase,
            "ratio": station.station.ratio,
            "cam_rpm": station.scene.cam.rpm,
            "lift": station.problem.programme.tool.lift / station.problem.programme.tool.unit_in_mm_or_rad,
            "lift_unit": station.unit,
            "limits": station_verdict(evaluation),
            "violated": evaluation["violated"],
        }
        if torque is not None and self.shaft is not None:
            at_peak = torque.value(np.array(self.shaft.peak_angle))
            record |= {
                "torque_peak_N_m": max(torque.largest().value, -torque.least().value),
                "torque_at_peak_N_m": float(at_peak),
                "torque_mean_N_m": torque.mean,
            }
        return {name: value for name, value in record.items() if value is not None}

    def table(self) -> Table:
        """A table with a row for each station."""
        rows = self.records()
        for row in rows:
            row["lift"] = with_unit(row["lift"], row.pop("lift_unit"))
        names = dict.fromkeys(name for row in rows for name in row)
        units = {"phase_deg": "deg", "cam_rpm": "rev/min"}
        units |= {name: "N·m" for name in names if name.endswith("_N_m")}
        note = "The torques are those on the machine's shaft." if "torque_peak_N_m" in names else ""
        return replace(table_of(f"{self.machine.name}: stations", rows, names, units=units), note=note)

    @property
    def _clearances_with_units(self) -> Iterator[tuple[Clearance, ClearanceResult, str]]:
        """Each clearance of the machine with its result and its unit."""
        for clearance, found in zip(self.machine.clear, self.clearances, strict=True):
            yield clearance, found, clearance_unit(clearance, self.resolved)

    def clearance_table(self) -> Table | None:
        """A table of the clearances with their verdicts; None without any."""
        rows = [
            {
                "clearance": found.title,
                "least": with_unit(found.displayed_upper_bound, unit),
                "proved": with_unit(found.displayed_lower_bound, unit),
                "at_deg": found.angle,
                "required": with_unit(found.at_least, unit),
                "verdict": found.verdict,
            }
            for _, found, unit in self._clearances_with_units
        ]
        return (
            table_of(f"{self.machine.name}: clearances", rows, rows[0], units={"at_deg": "deg"}) if rows else None
        )

    def slack_records(self) -> list[dict[str, Any]]:
        """By how much each phase may move earlier and later with all clearances held, and what ends it."""
        records = []
        for station in self.machine.station:
            slacks = [
                (slack, each.title)
                for each in self.clearances
                for slack in each.slacks
                if slack.station == station.name
            ]
            if slacks and not any(each.verdict != HELD for each in self.clearances if station.name in each.between):
                earlier, before = min((slack.earlier[0], title) for slack, title in slacks)
                later, after = min((slack.later[0], title) for slack, title in slacks)
                ends = {"earlier_by_deg": earlier, "before_it": before, "later_by_deg": later, "after_it": after}
                records.append({"station": station.name, **ends})
        return records

    def slack_table(self) -> Table | None:
        """A table of the slack of each phase, with the clearances that end it; None without clearances."""
        rows = [
            {
                "station": record["station"],
                "earlier by": number_text(record["earlier_by_deg"]) + "°",
                "until": record["before_it"],
                "later by": number_text(record["later_by_deg"]) + "°",
                "until ": record["after_it"],
            }
            if min(record["earlier_by_deg"], record["later_by_deg"]) < 180.0
            else {"station": record["station"], "earlier by": "any", "until": "", "later by": "any", "until ": ""}
            for record in self.slack_records()
        ]
        note = (
            "Each phase may move so far while the others stay, with every clearance held; this is proved. Phases "
            "whose clearances are not held now have no row."
        )
        return (
            replace(table_of(f"{self.machine.name}: slack of phases", rows, rows[0]), note=note) if rows else None
        )

    def shaft_record(self) -> dict[str, Any]:
        """The numbers of the shaft by name; empty without a torque."""
        shaft, wheel = self.shaft, self.machine.flywheel
        if shaft is None:
            return {}
        record = {
            "torque_max_N_m": shaft.largest.value,
            "torque_max_at_deg": degrees(shaft.largest.angle),
            "torque_min_N_m": shaft.least.value,
            "torque_min_at_deg": degrees(shaft.least.angle),
            "torque_mean_N_m": shaft.mean,
            "torque_rms_N_m": shaft.rms,
            "power_mean_W": shaft.mean_power,
            "power_peak_W": shaft.peak_power,
            "energy_fluctuation_J": shaft.energy_fluctuation,
            "inertia_of_cams_kg_m2": shaft.cam_inertia,
            "inertia_of_masses_mean_kg_m2": shaft.inertia.mean,
            "inertia_of_masses_max_kg_m2": shaft.inertia.largest().value,
        }
        if wheel.fluctuation is not None:
            record["flywheel_inertia_kg_m2"] = shaft.flywheel_inertia(wheel.fluctuation)
        if wheel.inertia is not None:
            record["speed_fluctuation"] = shaft.speed_fluctuation(wheel.inertia)
        return record

    def shaft_table(self) -> Table | None:
        """A table of the shaft, line by line; None without a torque."""
        record, wheel = self.shaft_record(), self.machine.flywheel
        if not record:
            return None

        def torque_at(name: str) -> str:
            return f"{with_unit(record[f'{name}_N_m'], 'N·m')} at {number_text(record[f'{name}_at_deg'])}°"

        lines = {
            "largest torque": torque_at("torque_max"),
            "least torque": torque_at("torque_min"),
            "mean torque": with_unit(record["torque_mean_N_m"], "N·m"),
            "root mean square torque": with_unit(record["torque_rms_N_m"], "N·m"),
            "mean power": with_unit(record["power_mean_W"], "W"),
            "peak power": with_unit(record["power_peak_W"], "W"),
            "fluctuation of energy": with_unit(record["energy_fluctuation_J"], "J"),
            "inertia of the cams": with_unit(record["inertia_of_cams_kg_m2"], "kg·m²"),
            "inertia of the masses, mean": with_unit(record["inertia_of_masses_mean_kg_m2"], "kg·m²"),
            "inertia of the masses, largest": with_unit(record["inertia_of_masses_max_kg_m2"], "kg·m²"),
        }
        if "flywheel_inertia_kg_m2" in record:
            text = with_unit(record["flywheel_inertia_kg_m2"], "kg·m²")
            lines[f"flywheel for a fluctuation of {number_text(wheel.fluctuation)}"] = text
        if "speed_fluctuation" in record:
            lines["fluctuation of speed with the flywheel"] = number_text(record["speed_fluctuation"])
        return Table.from_texts(f"{self.machine.name}: shaft", ["", ""], lines.items())

    def motor_table(self) -> Table | None:
        """A table of the motors; None without a catalogue."""
        smallest = smallest_motor(self.machine, self.motors)
        rows = [use._asdict() for use in self.motors]
        if not rows:
            return None
        chosen = (
            "no motor of the catalogue fits" if smallest is None else f"the smallest that fits is {smallest.name}"
        )
        note = (
            "Shares are of what the motor allows, at a constant speed; above 1 is too much. The ratio of inertias "
            "has the cams, the masses and the flywheel."
        )
        return replace(table_of(f"{self.machine.name}: motors; {chosen}", rows, rows[0]), note=note)


def station_verdict(evaluation: Evaluation) -> str:
    """The verdict on the limits of a station."""
    if evaluation["violated"]:
        return BROKEN
    return HELD if evaluation["feasible"] else UNDECIDED


def evaluate_machine(machine: MachineSource) -> MachineEvaluation:
    """Evaluate a machine: limits, clearances, and the torque of its shaft with flywheel and motors.

    Clearances are enclosed by branch and bound over the shaft's angle. The slack of a phase is the range in which
    it may move, while the others stay, with the clearance held at every phase of the range.

    Parameters
    ----------
    machine : Machine, str or os.PathLike
        A machine, the name of a shipped one, or the path of its TOML file.

    Returns
    -------
    MachineEvaluation
        Its ``verdict`` is about all limits of all stations and all clearances.

    Raises
    ------
    BadInput
        If a scene lacks a size.

    References
    ----------
    R. L. Norton, Design of Machinery, ch. 11.

    Examples
    --------
    >>> round(camopt.evaluate_machine("pick-and-place").shaft.energy_fluctuation, 3)
    11.004
    """
    machine = machine_from(machine)
    stations = resolve_stations(machine)
    shaft = shaft_of_machine(machine, stations)
    evaluations = {each.name: evaluate_design(each.scene, each.problem) for each in stations}
    motors = () if shaft is None else motor_uses(machine, shaft)
    return MachineEvaluation(
        machine, stations, evaluations, clearances_of_machine(machine, stations), shaft, motors
    )
