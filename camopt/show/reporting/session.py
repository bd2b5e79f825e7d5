"""What the page asks and what it is answered, without a network: a function from a request to an answer.

Nothing is remembered between requests but the scene that the server was started with: each has the values of all
controls. Answers are plain mappings that JSON takes.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics.clock import clock_seconds
from camopt.core.quantities import in_column_order
from camopt.model.effects import available_quantities
from camopt.scene.problem.limit import ASSEMBLY
from camopt.scene.problem.problem import resolve_design
from camopt.scene.problem.rows import DesignRows
from camopt.scene.scene import Scene
from camopt.scene.scene_file import write_scene
from camopt.show.drawing.picture import Picture
from camopt.show.reporting.cam_data import cam_data
from camopt.show.reporting.cams import Chapter, ShownCam, cam_sentences, cams_page, chapters_of
from camopt.show.reporting.controls import FOLDED_GROUPS, Control, control_values, controls_of, scene_of_settings
from camopt.show.reporting.page import render_page
from camopt.show.reporting.search import BackgroundSearch
from camopt.show.reporting.sections import (
    UNPROVED,
    all_limits_held,
    limits_sheet,
    quantities_sheet,
    verdict_line,
    verdicts_sheet,
)
from camopt.show.reporting.tolerances import (
    MOVING_CAMS,
    RESTING_CAMS,
    error_sentence,
    has_tolerances,
    yield_sentence,
)
from camopt.solve.tables.result import Cell, Table
from camopt.solve.verdicts.evaluation import Evaluation, evaluate_design
from camopt.solve.verdicts.limit_verdicts import evaluate_rows
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

PageAnswer = dict[str, Any]
QUICK_PROOF_SECONDS = 0.01  # for what rounding hides, while a control moves
SCENE_NAME = re.compile(r"[^\W_][\w .+-]{0,90}\.toml", re.ASCII)


class QuickPicture(Picture):
    """The picture while a control moves: fewer samples, and one run of the effects for values and verdict."""

    per_degree = 1.0

    @cached_property
    def rows(self) -> DesignRows:
        """The quantities, and the verdict."""
        offers = set(available_quantities(self.problem.setup))
        # of one contact of two, the limits that it has by itself
        limits = tuple(limit for limit in self.problem.limits if offers.issuperset(limit.required_quantities))
        problem = replace(self.problem, limits=limits)
        return evaluate_rows(problem, problem.design, self.wanted_quantities, clock_seconds() + QUICK_PROOF_SECONDS)

    @cached_property
    def values(self) -> dict[str, Any]:
        return self.rows.records()[0]


@dataclass(frozen=True)
class Session:
    """A scene with its controls, and the folder that takes what is saved."""

    scene: Scene
    folder: Path
    search: BackgroundSearch = field(default_factory=BackgroundSearch)

    @cached_property
    def controls(self) -> list[Control]:
        return controls_of(self.scene)

    @cached_property
    def own_values(self) -> dict[str, Any]:
        """The values of the controls at the start."""
        return control_values(self.scene, [control.key for control in self.controls])

    def scene_of(self, asked: Mapping[str, Any]) -> Scene:
        """The scene that a request is about."""
        values = {key: self._scene_value(key, value) for key, value in asked["values"].items()}
        return scene_of_settings(self.scene, self.own_values, values, asked.get("moved", ""))

    def _scene_value(self, key: str, value: Any) -> Any:
        """A value of a control as the scene has it: its own one, to the last digit, where none was moved."""
        control = next((each for each in self.controls if each.key == key), None)
        if control is None:
            return value
        return self.own_values[key] if value == control.control_value(self.own_values[key]) else control.read(value)

    def _shown_values(self, scene: Scene) -> dict[str, Any]:
        """What the controls show of a scene."""
        values = control_values(scene, list(self.own_values))
        return {control.key: control.control_value(values[control.key]) for control in self.controls}

    def page(self) -> str:
        """The page as it opens."""
        scene, answer = self.scene, self.settle({"values": {}})
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
            groups=groups,
            folded=FOLDED_GROUPS,
            file=f"{file_stem(scene)}.toml",
            folder=str(self.folder.resolve()),
        )

    def move(self, asked: Mapping[str, Any]) -> PageAnswer:
        """The cam while a control moves: what double precision says of it, within milliseconds."""
        scene = self.scene_of(asked)
        problem = resolve_design(scene)
        sketch = QuickPicture(scene, problem)
        verdicts = _quick_verdicts(sketch)
        found = Evaluation(scene, {name: sketch.values[name] for name in in_column_order(sketch.values)})
        sheet = verdicts_sheet(found, problem, verdicts, dict.fromkeys(verdicts, UNPROVED))
        held = "Feasible in double precision. The proof follows where the controls rest."
        line = Cell(held, "verdict held") if all_limits_held(sheet) else verdict_line(sheet, scene)
        return self._cam_answer(sketch, [line, *_tolerance_lines(sketch, MOVING_CAMS)], sheet, [])

    def settle(self, asked: Mapping[str, Any]) -> PageAnswer:
        """The cam where the controls rest: every limit proved, all quantities, more samples."""
        scene = self.scene_of(asked)
        problem = resolve_design(scene)
        found, picture = evaluate_design(scene, problem), Picture(scene, problem)
        sheet = limits_sheet(found, problem)
        sections = [
            Chapter("Quantities", [quantities_sheet([found], [problem], ["value"])]),
            *chapters_of(ShownCam(scene.name, scene), problem, pictures=False),
        ]
        lines = [verdict_line(sheet, scene), *_tolerance_lines(picture, RESTING_CAMS)]
        return self._cam_answer(picture, lines, sheet, sections)

    def _cam_answer(self, picture: Picture, lines: list[Cell], sheet: Table, sections: list[Chapter]) -> PageAnswer:
        return {
            "cam": cam_data(picture),
            "lines": [*lines, *(Cell(text) for text in cam_sentences(picture))],
            "limits": asdict(sheet),
            "sections": [asdict(section) for section in sections],
            "values": self._shown_values(picture.scene),
        }

    def smallest(self, asked: Mapping[str, Any]) -> PageAnswer:
        """The values of the smallest cam that meets the limits, or ``why`` there is none."""
        found = self.search.run(self.scene_of(asked))
        if "why" in found:
            return found
        return {"told": found["told"], "values": self._shown_values(Scene.from_dict(found["scene"]))}

    def stop(self, asked: Mapping[str, Any]) -> PageAnswer:
        """Call off the search for the smallest cam."""
        self.search.stop()
        return {}

    def report(self, asked: Mapping[str, Any]) -> PageAnswer:
        """The page of ``camopt report`` of what is shown."""
        scene = self.scene_of(asked)
        return {"name": f"{file_stem(scene)}.html", "text": cams_page([ShownCam(scene.name, scene)])}

    def save(self, asked: Mapping[str, Any]) -> PageAnswer:
        """Write the scene into the folder; over a file that is there only if ``overwrite`` says so."""
        scene, name = self.scene_of(asked), asked.get("name")
        if not (isinstance(name, str) and SCENE_NAME.fullmatch(name)):
            allowed = "a plain file name that ends in .toml: letters, digits, spaces, and . + - _"
            raise BadInput([Mistake("page", "name", name, allowed)])
        path = self.folder / name
        if path.is_symlink() or (path.exists() and not path.is_file()):
            raise BadInput([Mistake("page", "name", name, "another name: this one is no plain file")])
        if path.exists() and asked.get("overwrite") is not True:
            return {"exists": name}
        write_scene(path, scene)
        return {"saved": str(path)}


def file_stem(scene: Scene) -> str:
    """What files of a scene are called."""
    return re.sub(r"[^\w-]+", "-", scene.name, flags=re.ASCII).strip("-_")[:40] or "cam"


def _tolerance_lines(picture: Picture, cams: int) -> list[Cell]:
    """How far the motion may be off, and the yield of some cams, of a scene with tolerances."""
    scene, problem = picture.scene, picture.problem
    if not has_tolerances(scene, problem):
        return []
    told = error_sentence(scene, problem), yield_sentence(scene, problem, cams)
    return [Cell(each) for each in told if each]


def _quick_verdicts(sketch: QuickPicture) -> dict[str, str]:
    """The verdict on each limit; those that are asked last are open where another one is broken."""
    limits, broken = sketch.problem.limits, str(sketch.values["violated"]).split(",")
    if ASSEMBLY in broken:
        return {ASSEMBLY: BROKEN}
    if sketch.values["status"] == UNDECIDED:
        return {limit.name: UNDECIDED for limit in limits}
    others = UNDECIDED if any(broken) else HELD
    return {
        limit.name: BROKEN if limit.name in broken else others if limit.is_deferred else HELD for limit in limits
    }


REQUESTS: dict[str, Callable[[Session, Mapping[str, Any]], PageAnswer]] = {
    "move": Session.move,
    "settle": Session.settle,
    "smallest": Session.smallest,
    "stop": Session.stop,
    "report": Session.report,
    "save": Session.save,
}
"""What can be asked, by the last part of the address."""


def request_mistakes(asked: Any) -> list[Mistake]:
    """What is wrong with the form of a request, before anything is looked at."""
    if not isinstance(asked, dict):
        return [Mistake("page", "request", None, "an object")]
    kinds = {"values": dict, "moved": str, "name": str, "overwrite": bool}
    found = [Mistake("page", key, None, "no part of a request", bare=True) for key in asked if key not in kinds]
    found += [
        Mistake("page", key, None, f"of the type {kind.__name__}")
        for key, kind in kinds.items()
        if key in asked and not isinstance(asked[key], kind)
    ]
    if not isinstance(asked.get("values"), dict):
        found.append(Mistake("page", "values", None, "an object"))
    elif not all(type(value) in (float, str) for value in asked["values"].values()):
        found.append(Mistake("page", "values", None, "numbers and names"))
    return found


def answer_request(session: Session, what: str, asked: Any) -> PageAnswer:
    """The answer to one of the requests ``REQUESTS``, which may be mistakes: the key of a control, and a text."""
    try:
        if mistakes := request_mistakes(asked):
            raise BadInput(mistakes)
        return REQUESTS[what](session, asked)
    except BadInput as refused:
        return {
            "mistakes": [
                {"key": each.key, "text": each.allowed if each.bare else f"must be {each.allowed}"}
                for each in refused.mistakes
            ]
        }
    except OSError as trouble:
        return {"mistakes": [{"key": "", "text": trouble.strerror or str(trouble)}]}
