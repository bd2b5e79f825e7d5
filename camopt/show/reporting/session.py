"""Requests of the pages with sliders, of a cam and of a machine, and their answers, without the network.

Between requests only the scene or machine of the start is kept: each request has the values of all controls.
Answers are plain mappings for JSON.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from math import isinf
from pathlib import Path
from typing import Any, Protocol

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.numerics.budget import Budget
from camopt.core.quantities import in_column_order
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.core.storage.files import write_text
from camopt.model.effects import available_quantities
from camopt.scene.machine import Machine
from camopt.scene.problem.limit import ASSEMBLY
from camopt.scene.problem.problem import Problem, resolve_design
from camopt.scene.scene import Scene
from camopt.scene.scene_file import write_scene
from camopt.show.drawing.linkage import draw_stage_of_refused_scene
from camopt.show.drawing.picture import Picture
from camopt.show.reporting.cam_data import cam_data
from camopt.show.reporting.cams import Chapter, ShownCam, cam_chapters, cam_sentences, cams_page, has_tolerances
from camopt.show.reporting.controls import FOLDED_GROUPS, Control, control_values, controls_of, scene_with_settings
from camopt.show.reporting.machine import machine_page_data_and_template_values
from camopt.show.reporting.page import figure_url, render_page
from camopt.show.reporting.search import BackgroundSearch
from camopt.show.reporting.sections import (
    UNPROVED,
    limits_table,
    quantities_table,
    verdict_line,
    verdicts_table,
)
from camopt.solve.machine.evaluation import evaluate_machine
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.result import Cell, Table
from camopt.solve.tolerances.batch import yield_of_cams
from camopt.solve.tolerances.tolerance import first_order_errors
from camopt.solve.tolerances.turn_errors import TurnErrors
from camopt.solve.verdicts.evaluation import Evaluation, evaluate_design
from camopt.solve.verdicts.limit_verdicts import evaluate_with_verdicts
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

PageAnswer = dict[str, Any]
Answer = Callable[[Mapping[str, Any]], PageAnswer]
QUICK_PROOF_WORK = 1e4  # most work to decide limits within rounding, while a control moves
MOVING_CAMS, RESTING_CAMS = 256, 4096
"""Cams drawn for the yield in a sentence, while a control moves and when it rests."""
PHASE_STEP = 0.5  # deg
SCENE_NAME = re.compile(r"[^\W_][\w .+-]{0,90}\.toml", re.ASCII)


class QuickPicture(Picture):
    """The picture while a control moves: fewer samples, and one evaluation for values and verdict."""

    per_degree = 1.0

    @cached_property
    def quantity_values(self) -> dict[str, Any]:
        """Quantities and verdict of the design."""
        available = set(available_quantities(self.problem.setup))
        # with two contacts: the limits that this contact has alone
        limits = tuple(limit for limit in self.problem.limits if available.issuperset(limit.required_quantities))
        problem = replace(self.problem, limits=limits)
        rows = evaluate_with_verdicts(
            problem, problem.design, self.quantities_to_evaluate, Budget(QUICK_PROOF_WORK)
        )
        return rows.records()[0]


class PageSession(Protocol):
    """What a server shows: a page, and answers to its requests."""

    @property
    def answers(self) -> Mapping[str, Answer]:
        """Answers to requests, by the last part of their address."""

    def page(self) -> str:
        """The HTML of the page as it opens."""

    def close(self) -> None:
        """Stop what works in the background."""


@dataclass(frozen=True)
class Session:
    """A scene with its controls, and the folder for saved scenes."""

    scene: Scene
    folder: Path
    search: BackgroundSearch = field(default_factory=BackgroundSearch)

    @property
    def answers(self) -> Mapping[str, Answer]:
        """Answers to requests, by the last part of their address."""
        return {
            "move": self.quick_cam_answer,
            "settle": self.proved_cam_answer,
            "smallest": self.smallest_cam_answer,
            "stop": self.stop_search,
            "report": self.report_page_answer,
            "save": self.save_scene,
        }

    def close(self) -> None:
        """Stop what works in the background."""
        self.search.stop()

    @cached_property
    def controls(self) -> list[Control]:
        return controls_of(self.scene)

    @cached_property
    def initial_values(self) -> dict[str, Any]:
        """Values of the controls at the start, in units of the scene."""
        return control_values(self.scene, [control.key for control in self.controls])

    def scene_of_request(self, request: Mapping[str, Any]) -> Scene:
        """The scene with the values of a request."""
        values = dict(request["values"])
        for control in (each for each in self.controls if each.key in values):
            shown, initial = values[control.key], self.initial_values[control.key]
            has_moved = shown != control.value_in_control_unit(initial)  # else exactly the initial value
            values[control.key] = control.value_in_scene_unit(shown) if has_moved else initial
        return scene_with_settings(self.scene, self.initial_values, values, request.get("moved", ""))

    def _shown_values(self, scene: Scene) -> dict[str, Any]:
        """The values that the controls show for a scene."""
        values = control_values(scene, list(self.initial_values))
        return {control.key: control.value_in_control_unit(values[control.key]) for control in self.controls}

    def page(self) -> str:
        """The HTML of the page as it opens."""
        scene, answer = self.scene, self.proved_cam_answer({"values": {}})
        groups: dict[str, list[Control]] = {}
        for control in self.controls:
            groups.setdefault(control.group, []).append(control)
        return render_page(
            "serve",
            scene.name,
            {"answer": answer, "label": scene.name, "own": self._shown_values(scene)},
            lines=answer["lines"],
            tables=[answer["limits"]],
            sections=answer["sections"],
            downloads=[],
            several=False,
            full=False,
            groups=groups,
            folded=FOLDED_GROUPS,
            file=f"{file_stem(scene)}.toml",
            folder=str(self.folder.resolve()),
        )

    def quick_cam_answer(self, request: Mapping[str, Any]) -> PageAnswer:
        """The cam while a control moves: verdicts in double precision, within milliseconds."""
        scene = self.scene_of_request(request)
        problem = resolve_design(scene)
        sketch = QuickPicture(scene, problem)
        verdicts = _quick_verdicts(sketch)
        evaluation = Evaluation(
            scene, {name: sketch.quantity_values[name] for name in in_column_order(sketch.quantity_values)}
        )
        limits = verdicts_table(evaluation, problem, verdicts, dict.fromkeys(verdicts, UNPROVED))
        line = verdict_line(limits, scene)
        if line.kind == "verdict held":
            line = Cell("Feasible in double precision. The proof follows when the controls rest.", line.kind)
        return self._cam_answer(sketch, line, MOVING_CAMS, limits, [])

    def proved_cam_answer(self, request: Mapping[str, Any]) -> PageAnswer:
        """The cam when the controls rest: every limit proved, all quantities, more samples."""
        scene = self.scene_of_request(request)
        problem = resolve_design(scene)
        evaluation, picture = evaluate_design(scene, problem), Picture(scene, problem)
        limits = limits_table(evaluation, problem)
        sections = [
            Chapter("Quantities", [quantities_table([evaluation], [problem], ["value"])]),
            *cam_chapters(ShownCam(scene.name, scene), problem, pictures=False),
        ]
        return self._cam_answer(picture, verdict_line(limits, scene), RESTING_CAMS, limits, sections)

    def _cam_answer(
        self, picture: Picture, verdict: Cell, random_cams: int, limits: Table, sections: list[Chapter]
    ) -> PageAnswer:
        texts = [*_tolerance_sentences(picture.scene, picture.problem, random_cams), *cam_sentences(picture)]
        return {
            "cam": cam_data(picture),
            "lines": [verdict, *map(Cell, texts)],
            "limits": asdict(limits),
            "sections": [asdict(section) for section in sections],
            "values": self._shown_values(picture.scene),
        }

    def smallest_cam_answer(self, request: Mapping[str, Any]) -> PageAnswer:
        """The control values of the smallest cam that meets the limits, or the reason why there is none."""
        answer = self.search.run(self.scene_of_request(request))
        if "why" in answer:
            return answer
        return {"told": answer["told"], "values": self._shown_values(Scene.from_dict(answer["scene"]))}

    def stop_search(self, request: Mapping[str, Any]) -> PageAnswer:
        """Stop the search for the smallest cam."""
        self.search.stop()
        return {}

    def report_page_answer(self, request: Mapping[str, Any]) -> PageAnswer:
        """The page of ``camopt report`` for the shown cam."""
        scene = self.scene_of_request(request)
        return {"name": f"{file_stem(scene)}.html", "text": cams_page([ShownCam(scene.name, scene)])}

    def save_scene(self, request: Mapping[str, Any]) -> PageAnswer:
        """Write the scene into the folder; ``overwrite`` allows to replace a file."""
        scene = self.scene_of_request(request)
        return save_in_folder(self.folder, request, lambda path: write_scene(path, scene))


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
        return render_page(
            "serve_machine",
            self.machine.name,
            {**data, "own": {control.key: control.value for control in self.controls}},
            **parts,
            file=f"{file_stem(self.machine)}.toml",
            folder=str(self.folder.resolve()),
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


def save_in_folder(folder: Path, request: Mapping[str, Any], write: Callable[[Path], None]) -> PageAnswer:
    """Write a TOML file under the name of a request; ``overwrite`` allows to replace a file."""
    name = request.get("name")
    if not (isinstance(name, str) and SCENE_NAME.fullmatch(name)):
        allowed = "a plain file name that ends in .toml: letters, digits, spaces, and . + - _"
        raise BadInput([Mistake("page", "name", name, allowed)])
    path = folder / name
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise BadInput([Mistake("page", "name", name, "another name: this one is not a plain file")])
    if path.exists() and request.get("overwrite") is not True:
        return {"exists": name}
    write(path)
    return {"saved": str(path)}


def file_stem(scene_or_machine: Scene | Machine) -> str:
    """Name of the files of a scene or machine, without ending."""
    return re.sub(r"[^\w-]+", "-", scene_or_machine.name, flags=re.ASCII).strip("-_")[:40] or "cam"


def _tolerance_sentences(scene: Scene, problem: Problem, cams: int) -> Iterator[str]:
    """Sentences on the largest motion errors, to first order, and on the yield of random cams, with its interval.

    None without tolerances; no errors if no tolerance moves the tool, no yield if tolerances touch no limit.
    """
    if not has_tolerances(scene, problem):
        return
    turn = TurnErrors(scene, problem)
    if turn.node_contributions:
        errors = ", ".join(
            f"{each.name} ∞"
            if isinf(worst := each.worst)
            else f"{each.name} {with_unit(worst, each.unit)} ({to_shown_unit(each.three_sigma, each.unit):.3g})"
            for each in first_order_errors(turn)
        )
        yield f"Largest error within the tolerances: {errors} (root sum square in brackets)."
    proportion = yield_of_cams(scene, problem, cams)
    if proportion is not None:
        share, low, high = (100.0 * value for value in proportion)
        yield f"Yield: {share:.4g} % of {cams:,} random cams meet the limits ({low:.4g} to {high:.4g} %)."


def _quick_verdicts(picture: QuickPicture) -> dict[str, str]:
    """The verdict on each limit. Deferred limits are undecided if another limit is broken."""
    limits, broken = picture.problem.limits, str(picture.quantity_values["violated"]).split(",")
    if ASSEMBLY in broken:
        return {ASSEMBLY: BROKEN}
    if picture.quantity_values["status"] == UNDECIDED:
        return {limit.name: UNDECIDED for limit in limits}
    others = UNDECIDED if any(broken) else HELD
    return {
        limit.name: BROKEN if limit.name in broken else others if limit.is_deferred else HELD for limit in limits
    }


def request_mistakes(request: Any) -> list[Mistake]:
    """Mistakes in the form of a request."""
    if not isinstance(request, dict):
        return [Mistake("page", "request", None, "an object")]
    kinds = {"values": dict, "moved": str, "name": str, "overwrite": bool}
    mistakes = [
        Mistake("page", key, None, "not a part of a request", bare=True) for key in request if key not in kinds
    ]
    mistakes += [
        Mistake("page", key, None, f"of the type {kind.__name__}")
        for key, kind in kinds.items()
        if key in request and not isinstance(request[key], kind)
    ]
    if not isinstance(request.get("values"), dict):
        mistakes.append(Mistake("page", "values", None, "an object"))
    elif not all(type(value) in (float, str) for value in request["values"].values()):
        mistakes.append(Mistake("page", "values", None, "numbers and names"))
    return mistakes


def answer_request(session: PageSession, request_name: str, request: Any) -> PageAnswer:
    """The answer to a request of a session; or its mistakes, each with the key of a control and a text.

    For a linkage that cannot be assembled, ``picture`` shows it as far as it goes.
    """
    try:
        if mistakes := request_mistakes(request):
            raise BadInput(mistakes)
        return session.answers[request_name](request)
    except BadInput as refused:
        linkage = draw_stage_of_refused_scene(refused)
        return {
            **({"picture": figure_url(linkage)} if linkage else {}),
            "mistakes": [
                {"key": each.key, "text": each.allowed if each.bare else f"must be {each.allowed}"}
                for each in refused.mistakes
            ],
        }
    except OSError as trouble:
        return {"mistakes": [{"key": "", "text": trouble.strerror or str(trouble)}]}
