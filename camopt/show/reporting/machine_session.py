"""Requests of the page of a machine with sliders for its phases, and their answers, without the network."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.storage.files import write_text
from camopt.scene.machine import Machine
from camopt.show.reporting.controls import Control
from camopt.show.reporting.machine import machine_page_data_and_template_values
from camopt.show.reporting.page import render_page
from camopt.show.reporting.session import Answer, PageAnswer, file_stem, save_in_folder
from camopt.solve.machine.evaluation import evaluate_machine

PHASE_STEP = 0.5  # deg


@dataclass(frozen=True)
class MachineSession:
    """A machine with a slider for each phase, and the folder for saved machines."""

    machine: Machine
    folder: Path

    @property
    def answers(self) -> Mapping[str, Answer]:
        """Answers to requests, by the last part of their address."""
        return {"move": self.check_phases, "settle": self.machine_answer, "save": self.save_machine}

    def close(self) -> None:
        """Nothing works in the background."""

    @cached_property
    def controls(self) -> list[Control]:
        """A slider for each phase: over its range in ``search.phase``, or over a turn."""
        controls = []
        for station in self.machine.station:
            low, high = self.machine.search.phase.get(station.name, (0.0, 360.0))
            ends = min(low, station.phase), max(high, station.phase)
            controls.append(Control(station.name, "Phases", station.name, "deg", station.phase, *ends, PHASE_STEP))
        return controls

    def machine_of_request(self, request: Mapping[str, Any]) -> Machine:
        """The machine with the phases of a request."""
        known = {control.key for control in self.controls}
        mistakes = [
            Mistake("page", name, None, f"not a station; {suggest_names(name, known)}", bare=True)
            if name not in known
            else Mistake("page", name, value, "a number")
            for name, value in request["values"].items()
            if name not in known or not isinstance(value, float)
        ]
        if mistakes:
            raise BadInput(mistakes)
        return self.machine.with_phases(request["values"])

    def page(self) -> str:
        """The HTML of the page as it opens."""
        data, parts = machine_page_data_and_template_values(evaluate_machine(self.machine))
        own = {control.key: control.value for control in self.controls}
        place = {"file": f"{file_stem(self.machine)}.toml", "folder": str(self.folder.resolve())}
        return render_page(
            "serve_machine",
            self.machine.name,
            {**data, "own": own},
            **parts,
            **place,
            full=False,
            controls=self.controls,
        )

    def check_phases(self, request: Mapping[str, Any]) -> PageAnswer:
        """Nothing, or mistakes: while a slider moves, the page itself turns the cams."""
        self.machine_of_request(request)
        return {}

    def machine_answer(self, request: Mapping[str, Any]) -> PageAnswer:
        """The machine when the sliders rest: its timing diagram, verdict and tables."""
        data, parts = machine_page_data_and_template_values(evaluate_machine(self.machine_of_request(request)))
        return {
            "data": data,
            "timing": parts["timing"],
            "lines": parts["lines"],
            "tables": [asdict(table) for table in parts["tables"]],
        }

    def save_machine(self, request: Mapping[str, Any]) -> PageAnswer:
        """Write the machine into the folder; ``overwrite`` allows to replace a file."""
        machine = self.machine_of_request(request)
        if self.folder.resolve() != (machine.folder or Path()).resolve():
            machine = machine.with_files_inside()
        return save_in_folder(self.folder, request, lambda path: write_text(path, machine.to_toml()))
