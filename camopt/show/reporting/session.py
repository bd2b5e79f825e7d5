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
from camopt.core.numerics.clock import now
from camopt.core.quantities import in_order
from camopt.model.effects import offered
from camopt.scene.problem.limit import ASSEMBLY
from camopt.scene.problem.problem import resolve_design
from camopt.scene.problem.rows import Rows
from camopt.scene.scene import Scene
from camopt.scene.written import write_scene
from camopt.show.drawing.picture import Picture
from camopt.show.reporting.cam import cam_of
from camopt.show.reporting.cams import Chapter, ShownCam, cams_page, chapters_of, words_of
from camopt.show.reporting.controls import FOLDED, Control, controls_of, scene_of_settings, values_of
from camopt.show.reporting.page import rendered
from camopt.show.reporting.search import Background
from camopt.show.reporting.sections import (
    UNPROVED,
    is_held,
    limits_sheet,
    quantities_sheet,
    verdict_line,
    verdicts_sheet,
)
from camopt.show.reporting.tolerances import AT_REST, MOVING, has_tolerances, in_a_sentence, yield_in_a_sentence
from camopt.solve.tables.result import Cell, Table
from camopt.solve.verdicts.evaluation import Evaluation, evaluate_design
from camopt.solve.verdicts.judging import evaluate_rows
from camopt.solve.verdicts.words import BROKEN, HELD, UNDECIDED

Answer = dict[str, Any]
PROOF_SECONDS = 0.01  # for what rounding hides, while a control moves
SCENE_NAME = re.compile(r"[^\W_][\w .+-]{0,90}\.toml", re.ASCII)


class Sketch(Picture):
    """The picture while a control moves: fewer samples, and one run of the effects for values and verdict."""

    per_degree = 1.0

    @cached_property
    def rows(self) -> Rows:
        """The quantities, and the verdict."""
        offers = set(offered(self.problem.setup))
        # of one contact of two, the limits that it has by itself
        limits = tuple(limit for limit in self.problem.limits if offers.issuperset(limit.needs))
        problem = replace(self.problem, limits=limits)
        return evaluate_rows(problem, problem.design, self.wanted, now() + PROOF_SECONDS)

    @cached_property
    def values(self) -> dict[str, Any]:
        return self.rows.records()[0]


@dataclass(frozen=True)
class Session:
    """A scene with its controls, and the folder that takes what is saved."""

    scene: Scene
    folder: Path
    search: Background = field(default_factory=Background)

    @cached_property
    def controls(self) -> list[Control]:
        return controls_of(self.scene)

    @cached_property
    def own(self) -> dict[str, Any]:
        """The values of the controls at the start."""
        return values_of(self.scene, [control.key for control in self.controls])

    def scene_of(self, asked: Mapping[str, Any]) -> Scene:
        """The scene that a request is about."""
        values = {key: self._read(key, value) for key, value in asked["values"].items()}
        return scene_of_settings(self.scene, self.own, values, asked.get("moved", ""))

    def _read(self, key: str, value: Any) -> Any:
        """A value of a control as the scene has it: its own one, to the last digit, where none was moved."""
        control = next((each for each in self.controls if each.key == key), None)
        if control is None:
            return value
        return self.own[key] if value == control.shown(self.own[key]) else control.read(value)

    def _shown_values(self, scene: Scene) -> dict[str, Any]:
        """What the controls show of a scene."""
        values = values_of(scene, list(self.own))
        return {control.key: control.shown(values[control.key]) for control in self.controls}

    def page(self) -> str:
        """The page as it opens."""
        scene, answer = self.scene, self.settle({"values": {}})
        groups: dict[str, list[Control]] = {}
        for control in self.controls:
            groups.setdefault(control.group, []).append(control)
        return rendered(
            "serve",
            scene.name,
            {"answer": answer, "label": scene.name, "own": self._shown_values(scene)},
            lines=answer["lines"],
            tables=[answer["limits"]],
            sections=answer["sections"],
            downloads=[],
            several=False,
            groups=groups,
            folded=FOLDED,
            file=f"{stem_of(scene)}.toml",
            folder=str(self.folder.resolve()),
        )

    def move(self, asked: Mapping[str, Any]) -> Answer:
        """The cam while a control moves: what double precision says of it, within milliseconds."""
        scene = self.scene_of(asked)
        problem = resolve_design(scene)
        sketch = Sketch(scene, problem)
        verdicts = _quick_verdicts(sketch)
        found = Evaluation(scene, {name: sketch.values[name] for name in in_order(sketch.values)})
        sheet = verdicts_sheet(found, problem, verdicts, dict.fromkeys(verdicts, UNPROVED))
        held = "Feasible in double precision. The proof follows where the controls rest."
        line = Cell(held, "verdict held") if is_held(sheet) else verdict_line(sheet, scene)
        return self._shown(sketch, [line, *_tolerance_lines(sketch, MOVING)], sheet, [])

    def settle(self, asked: Mapping[str, Any]) -> Answer:
        """The cam where the controls rest: every limit proved, all quantities, more samples."""
        scene = self.scene_of(asked)
        problem = resolve_design(scene)
        found, picture = evaluate_design(scene, problem), Picture(scene, problem)
        sheet = limits_sheet(found, problem)
        sections = [
            Chapter("Quantities", [quantities_sheet([found], [problem], ["value"])]),
            *chapters_of(ShownCam(scene.name, scene), problem, pictures=False),
        ]
        lines = [verdict_line(sheet, scene), *_tolerance_lines(picture, AT_REST)]
        return self._shown(picture, lines, sheet, sections)

    def _shown(self, picture: Picture, lines: list[Cell], sheet: Table, sections: list[Chapter]) -> Answer:
        return {
            "cam": cam_of(picture),
            "lines": [*lines, *(Cell(text) for text in words_of(picture))],
            "limits": asdict(sheet),
            "sections": [asdict(section) for section in sections],
            "values": self._shown_values(picture.scene),
        }

    def smallest(self, asked: Mapping[str, Any]) -> Answer:
        """The values of the smallest cam that meets the limits, or ``why`` there is none."""
        found = self.search.run(self.scene_of(asked))
        if "why" in found:
            return found
        return {"told": found["told"], "values": self._shown_values(Scene.from_dict(found["scene"]))}

    def stop(self, asked: Mapping[str, Any]) -> Answer:
        """Call off the search for the smallest cam."""
        self.search.stop()
        return {}

    def report(self, asked: Mapping[str, Any]) -> Answer:
        """The page of ``camopt report`` of what is shown."""
        scene = self.scene_of(asked)
        return {"name": f"{stem_of(scene)}.html", "text": cams_page([ShownCam(scene.name, scene)])}

    def save(self, asked: Mapping[str, Any]) -> Answer:
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


def stem_of(scene: Scene) -> str:
    """What files of a scene are called."""
    return re.sub(r"[^\w-]+", "-", scene.name, flags=re.ASCII).strip("-_")[:40] or "cam"


def _tolerance_lines(picture: Picture, cams: int) -> list[Cell]:
    """How far the motion may be off, and the yield of some cams, of a scene with tolerances."""
    scene, problem = picture.scene, picture.problem
    if not has_tolerances(scene, problem):
        return []
    told = in_a_sentence(scene, problem), yield_in_a_sentence(scene, problem, cams)
    return [Cell(each) for each in told if each]


def _quick_verdicts(sketch: Sketch) -> dict[str, str]:
    """The verdict on each limit; those that are asked last are open where another one is broken."""
    limits, broken = sketch.problem.limits, str(sketch.values["violated"]).split(",")
    if ASSEMBLY in broken:
        return {ASSEMBLY: BROKEN}
    if sketch.values["status"] == UNDECIDED:
        return {limit.name: UNDECIDED for limit in limits}
    others = UNDECIDED if any(broken) else HELD
    return {limit.name: BROKEN if limit.name in broken else others if limit.last else HELD for limit in limits}


ASKED: dict[str, Callable[[Session, Mapping[str, Any]], Answer]] = {
    "move": Session.move,
    "settle": Session.settle,
    "smallest": Session.smallest,
    "stop": Session.stop,
    "report": Session.report,
    "save": Session.save,
}
"""What can be asked, by the last part of the address."""


def mistakes_in(asked: Any) -> list[Mistake]:
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


def answer_to(session: Session, what: str, asked: Any) -> Answer:
    """The answer to one of the requests ``ASKED``, which may be mistakes: the key of a control, and a text."""
    try:
        if mistakes := mistakes_in(asked):
            raise BadInput(mistakes)
        return ASKED[what](session, asked)
    except BadInput as refused:
        return {
            "mistakes": [
                {"key": each.key, "text": each.allowed if each.bare else f"must be {each.allowed}"}
                for each in refused.mistakes
            ]
        }
    except OSError as trouble:
        return {"mistakes": [{"key": "", "text": trouble.strerror or str(trouble)}]}
