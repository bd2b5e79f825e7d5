"""From a scene to numbers: resolve it, run the effects that are called for, judge the limits."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from math import inf, isinf, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camopt.effects import Case, Subject, offered, plan
from camopt.effects.motion import KINDS
from camopt.limits import Limit, limits_of
from camopt.mechanisms import Designs, mechanism_for
from camopt.mistakes import BadInput, Mistake
from camopt.motion.programme import Programme
from camopt.motion.table import TURN
from camopt.numerics import FloatArray
from camopt.quantities import QUANTITIES
from camopt.rows import Columns, Rows
from camopt.scene import Scene

VERDICT = ("feasible", "violated")


@dataclass(frozen=True)
class Question:
    """A scene resolved: its subject, programme and design in inside units, its limits, what it calls for."""

    scene: Scene
    subject: Subject
    programme: Programme
    design: Designs
    limits: tuple[Limit, ...]

    @property
    def size_name(self) -> str:
        """The quantity that says how large the cam is."""
        return "mean_radius_mm" if self.subject.mechanism.grooved else "base_radius_mm"

    @property
    def sizes(self) -> frozenset[str]:
        """The quantities that a design is made of."""
        return frozenset(n for n in offered(self.subject) if QUANTITIES[n].effect == "sizes")

    @property
    def needed(self) -> frozenset[str]:
        """The quantities that limits and objectives call for."""
        objectives = (*self.scene.search.minimise, *self.scene.search.maximise)
        return frozenset([*objectives, *(need for limit in self.limits for need in limit.needs)])

    @property
    def wanted(self) -> frozenset[str]:
        """What the scene calls for: its named outputs, or else motion and geometry; and what limits need."""
        return self.needed | frozenset(self.scene.outputs or offered(self.subject))


def resolve(scene: Scene) -> Question:
    """Turn a validated scene into inside units: mm, s, rad."""
    if not isinstance(scene, Scene):
        raise BadInput([Mistake("camopt", "scene", scene, "a Scene, such as find_scene or Scene.from_toml give")])
    cam, follower = scene.cam, scene.follower
    subject = Subject(
        mechanism=mechanism_for(cam.form, follower.motion, follower.contact),
        angular=follower.motion == "oscillating",
        pointed=follower.contact == "knife",
        omega=None if cam.rpm is None else cam.rpm * 2 * pi / 60,
        shaft_radius=None if cam.shaft_diameter is None else cam.shaft_diameter / 2,
        tolerance=scene.accuracy.tolerance,
    )
    segments = [(s.segment, s.angle, s.lift, s.law) for s in scene.motion]
    design = Designs(
        size=_length(cam.base_radius if cam.form == "disc" else cam.mean_radius),
        roller_radius=_length(follower.roller_radius or follower.face_radius),
        offset=_length(follower.offset),
        arm_length=_length(follower.arm_length),
        centre_distance=_length(follower.centre_distance),
        face_offset=_length(follower.face_offset),
        sense=1.0 if cam.rotation == "ccw" else -1.0,
    )
    mistakes = _not_offered(scene, subject)
    if mistakes:
        raise BadInput(mistakes)
    programme = Programme.from_segments(segments, angular=subject.angular)
    return Question(scene, subject, programme, design, limits_of(scene, subject))


def _not_offered(scene: Scene, subject: Subject) -> list[Mistake]:
    """Quantities that a scene names and its mechanism has not; an objective has to be a number."""
    offers = (*offered(subject), *VERDICT)
    numbers = tuple(name for name in offers if QUANTITIES[name].kind is float)
    named = {
        "outputs": (scene.outputs, offers),
        "search.minimise": (scene.search.minimise, numbers),
        "search.maximise": (scene.search.maximise, numbers),
    }
    return [
        Mistake(scene.file, key, name, f"a quantity of this scene: {', '.join(allowed)}")
        for key, (names, allowed) in named.items()
        for name in names
        if name not in allowed
    ]


def _length(value: float | None) -> FloatArray:
    return np.array([value or 0.0])


def run_effects(case: Case, wanted: Iterable[str]) -> Rows:
    """The wanted quantities of a block of designs."""
    wanted = frozenset(wanted)
    columns: Columns = {}
    for effect in plan(wanted):
        columns |= _only(wanted, effect.run(case, wanted))
    return Rows(columns, len(case.designs))


def _only(wanted: frozenset[str], columns: Columns) -> Columns:
    return {name: value for name, value in columns.items() if name in wanted}


def judged(question: Question, programme: Programme, designs: Designs, wanted: frozenset[str]) -> Rows:
    """The wanted quantities of all designs, with ``feasible`` and ``violated``."""
    rows = run_effects(Case(question.subject, programme, designs), wanted | question.needed)
    excess = excesses(question.limits, rows.columns, designs)
    verdict = {"feasible": np.all(excess <= 0.0, axis=0), "violated": violations(question.limits, excess)}
    return Rows({**rows.columns, **verdict}, rows.count)


def screened(question: Question, programme: Programme, designs: Designs, wanted: frozenset[str]) -> Rows:
    """The wanted quantities of those designs that hold every limit, with ``feasible`` and ``violated``.

    Effects run cheapest first, and a design that fails a limit is dropped before the next effect runs.
    """
    wanted = wanted | question.needed
    rows = Rows({"feasible": True, "violated": ""}, len(designs))
    pending = list(question.limits)
    for effect in plan(wanted):
        found = effect.run(Case(question.subject, programme, designs), wanted)
        rows = Rows(rows.columns | _only(wanted, found), rows.count)
        ready = [limit for limit in pending if rows.columns.keys() >= set(limit.needs)]
        pending = [limit for limit in pending if limit not in ready]
        held = np.all(excesses(ready, rows.columns, designs) <= 0.0, axis=0)
        designs, rows = designs.take(held), rows.take(held)
    return rows


def excesses(limits: Iterable[Limit], columns: Columns, designs: Designs) -> FloatArray:
    """Relative excess over each limit, (limits, designs)."""
    rows = [limit.excess(columns, designs) + np.zeros(len(designs)) for limit in limits]
    return np.array(rows).reshape(len(rows), len(designs))


WORST = 1e6  # what counts as an infinite excess, so that designs can still be told apart by their other limits


def by_excess(excess: FloatArray) -> tuple[float, float]:
    """How badly a design (limits,) misses: its worst relative excess, and then the sum of all."""
    over = np.clip(excess, 0.0, WORST)
    return float(over.max(initial=0.0)), float(over.sum())


def least_excess(excess: FloatArray) -> int:
    """The design, of those in (limits, designs), that misses the least."""
    over = np.clip(excess, 0.0, WORST)
    return int(np.lexsort((over.sum(axis=0), over.max(axis=0)))[0])


def violations(limits: Iterable[Limit], excess: FloatArray) -> NDArray[np.str_]:
    """The names of the limits that each design exceeds, joined by commas."""
    names = [limit.name for limit in limits]
    kinds, which = np.unique(excess > 0.0, axis=1, return_inverse=True)
    texts = [",".join(n for n, bad in zip(names, kind, strict=True) if bad) for kind in kinds.T]
    return np.array(texts, dtype=str)[which.reshape(-1)]


@dataclass(frozen=True)
class Evaluation(Mapping[str, Any]):
    """The quantities of one design, a mapping from name to value.

    ``unbounded`` gives the reason for each infinite value.
    """

    scene: Scene
    quantities: dict[str, float | bool | str]
    unbounded: dict[str, str] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:
        return self.quantities[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)

    def to_json(self) -> dict[str, Any]:
        """Values with None for what is infinite, and the reasons under ``unbounded``."""
        finite = {n: None if isinstance(v, float) and isinf(v) else v for n, v in self.quantities.items()}
        return {**finite, **({"unbounded": self.unbounded} if self.unbounded else {})}


def evaluate(scene: Scene) -> Evaluation:
    """Every quantity that a scene calls for, of its one design.

    Extremes are those of the continuous motion, to the scene's tolerance (relative). A quantity that is
    infinite (the acceleration of a uniform-velocity law) is ``inf`` here, with its reason under ``unbounded``.
    """
    return evaluate_design(resolve(scene))


def evaluate_design(question: Question) -> Evaluation:
    """As ``evaluate``, for a scene already resolved."""
    (found,) = judged(question, question.programme, question.design, question.wanted).records()
    values = {name: found[name] for name in QUANTITIES if name in found}
    unbounded = {n: _reason(n, question.programme) for n, v in values.items() if v in (inf, -inf)}
    return Evaluation(question.scene, values, unbounded)


def _reason(name: str, programme: Programme) -> str:
    """Why a quantity is infinite."""
    kinds = next((kind for stroke, kind in KINDS.items() if stroke and f"_{stroke}_" in name), TURN)
    corners = ", ".join(f"{np.degrees(j.at):g}°" for j in programme.corners if j.kinds & kinds)
    jumps = ", ".join(f"{np.degrees(j.at):g}°" for j in programme.jumps if j.kinds & kinds)
    if name.startswith("jerk") and not corners:
        return f"the acceleration jumps at {jumps}"
    if name.startswith(("acceleration", "jerk")):
        return f"the velocity jumps at {corners}"
    if name == "cutter_radius_max_mm":
        return "no flank of the profile is concave"
    if name == "profile_radius_min_mm" and not corners:
        return "no part of the profile is convex"
    return f"the pitch curve has corners where the velocity jumps, at {corners}"
