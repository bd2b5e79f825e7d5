"""From a scene to a problem in inside units (mm, s, rad): its setup, programme, design and limits."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from math import inf, nan
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics.same import Same
from camopt.core.quantities import EVERYTHING, GEOMETRY, QUANTITIES
from camopt.model.effects import Setup, offered, quantity_of
from camopt.model.effects.peak import unweighted
from camopt.model.mechanisms import SECOND_FIELDS, SIZE_FIELDS, Designs
from camopt.model.motion import LAWS
from camopt.model.motion.law import Law
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import GivenSegment
from camopt.model.trains.train import Train
from camopt.scene.load import constant_and_changing
from camopt.scene.own_laws import law_of
from camopt.scene.problem.asked_in_vain import not_offered, out_of_reach, unlike_halves
from camopt.scene.problem.choices import Choices, choices_of
from camopt.scene.problem.claims import Claim
from camopt.scene.problem.driving import through_train, unmoved
from camopt.scene.problem.limit import Limit, needs_of
from camopt.scene.problem.limits import limits_of
from camopt.scene.problem.rows import Objectives
from camopt.scene.problem.setup import load_and_unit, setup_of
from camopt.scene.problem.variables import Variable, is_of_train, variables_of
from camopt.scene.problem.zones import Off, looked_at, moved, nominal_of, robust_zones
from camopt.scene.profile import programme_of
from camopt.scene.scene import Scene
from camopt.scene.segments import given_segments
from camopt.scene.tolerances import Zone
from camopt.scene.train import train_load, trains_from

WITHOUT_SIZE = (
    "missing; only what finds sizes can do without it: optimise, serve, effects, a sweep whose [search] has it"
)
WITHOUT_NUMBER = "missing; only sweep and optimise can do without it, if [search] has it"
SINGLE_ERROR = 1e-13  # for single designs, whose digits people compare: it costs nothing there


@dataclass(frozen=True)
class Problem:
    """A resolved scene: setup, laws, programme and design in inside units, limits, and wanted quantities."""

    file: str
    """What messages call the scene."""
    setup: Setup
    laws: Mapping[str, Law]
    """Every law that the scene can name: the built-in ones and its own."""
    programme: Programme
    segments: tuple[GivenSegment, ...]
    """The turn as the scene gives it; none where it gives the profile of the cam."""
    profile: tuple[float, ...]
    """The radii of that profile's arcs, mm; below 0 where hollow, infinite for a line."""
    design: Designs
    """The scene's own design; a size that the scene leaves to its search is not a number (``resolve_design``)."""
    limits: tuple[Limit, ...]
    objectives: Objectives
    outputs: tuple[str, ...]
    """Quantities and effects to report besides, by name."""
    choices: Choices
    variables: tuple[Variable, ...]
    """What may differ between designs, whether searched or not; no angles."""
    missing: tuple[Variable, ...]
    """Those that the scene leaves to its search."""
    accuracy: float
    """The largest relative error of reported values that is asked; the setup's may be smaller."""
    values: "SceneValues"
    zones: Mapping[str, Zone] = field(default_factory=dict)
    """Between which ends numbers may be off of the cams that have to hold the limits as well, by field of designs;
    those of the train by key."""
    offs: tuple[Off, ...] = ()
    """By how much they are of those that are looked at: at the corners, and where a worse one is known."""

    def every(self, designs: Designs) -> Iterator[tuple["Problem", Designs]]:
        """Designs, and those that have to hold the limits with each of them, with what these have to hold.

        Of any kind of number. Limits on errors by tolerances are those of the first alone: they are of all cams
        within the tolerances already.
        """
        yield self, designs
        for own, off in self.others:
            yield own, moved(designs, off)

    @cached_property
    def others(self) -> "tuple[tuple[Problem, Off], ...]":
        """Those that have to hold the limits with designs: a problem with what these do not bring, and how far off.

        Designs do not bring the numbers of their train.
        """
        found = dict[frozenset[tuple[str, float]], Problem]()
        pairs = []
        for off in self.offs:
            shared, own = self.parted(off)
            place = frozenset(shared.items())
            if place not in found:
                found[place] = self.without_errors.with_numbers_off(shared)
            pairs.append((found[place], own))
        return tuple(pairs)

    def parted(self, off: Off) -> tuple[Off, Off]:
        """What of a cam that is off its designs do not bring, and what they do."""
        shared = {key: by for key, by in off.items() if key not in self.design.values}
        return shared, {key: by for key, by in off.items() if key not in shared}

    def with_numbers_off(self, off: Off) -> "Problem":
        """The problem with numbers that are off, as those of a train, and the same limits of those it gives."""
        if not off:
            return self
        most = {key: self.setup.given[key] for key in self.setup.free}
        moved = self.with_numbers({**most, **{key: self.nominal[key] + by for key, by in off.items()}})
        return self._with_same_limits(moved.bringing(self.setup.free))

    def _with_same_limits(self, changed: "Problem") -> "Problem":
        """Another problem with those limits that this one has."""
        given = {(limit.name, limit.bound): limit for limit in changed.limits}
        limits = tuple(given.get((limit.name, limit.bound), limit) for limit in self.limits)  # some may be left out
        return replace(changed, limits=limits)

    @cached_property
    def without_errors(self) -> "Problem":
        """The problem without limits on errors by tolerances."""
        return replace(self, limits=tuple(limit for limit in self.limits if not limit.of_errors))

    def to_error(self, relative_error: float) -> "Problem":
        """The problem with another relative error of its extremes."""
        return replace(self, setup=_to_error(Same(self.setup), relative_error))

    def with_programme(self, programme: Programme) -> "Problem":
        """The problem of another motion of the same follower, with the same limits."""
        problem = replace(self, programme=programme)
        vars(problem)["wanted"] = self.wanted  # the same for all motions
        return problem

    def with_numbers(self, numbers: Mapping[str, float | None]) -> "Problem":
        """The problem with other numbers of the scene, by key, to the same relative error; sizes stay."""
        if not numbers:
            return self
        values = self.values.replaced(numbers)
        moved = any(map(is_of_train, numbers))
        if moved and (why := values.unmoved):
            named = ", ".join(f"{key} = {value:.6g}" for key, value in numbers.items())
            return replace(self, setup=self.setup.with_numbers(numbers)).apart(f"{why} (with {named})")
        setup = replace(
            values.setup, relative_error=self.setup.relative_error, free=self.setup.free - numbers.keys()
        )
        changed = replace(self, values=values, setup=setup, limits=values.limits(setup))
        return changed.moving(self.given) if moved else changed

    def moving(self, asked: Programme) -> "Problem":
        """The problem of another motion that is asked; of no design, where the train cannot move so far."""
        try:
            return self.with_programme(self.driving(asked))
        except BadInput as error:
            return self.apart(error.mistakes[0].allowed)

    def apart(self, why: str) -> "Problem":
        """The problem where no design can be assembled, for a reason."""
        return replace(self, setup=replace(self.setup, mechanism=self.setup.mechanism.apart(why)))

    def freed(self, numbers: Mapping[str, float]) -> "Problem":
        """The problem of designs with numbers of their own, by key of the scene, at most as large as given here."""
        if not numbers:
            return self
        setup = self.with_numbers(numbers).setup
        setup = replace(setup, free=setup.free | numbers.keys())
        return replace(self, setup=setup, limits=self.values.limits(setup))

    def bringing(self, keys: Collection[str]) -> "Problem":
        """The problem of designs with numbers of their own that do not change what its own are, as of the train."""
        setup = replace(self.setup, free=self.setup.free.union(keys))
        return replace(self, setup=setup, limits=self.values.limits(setup))

    def alone(self, design: Designs) -> "tuple[Problem, Designs]":
        """The problem with the numbers of one design in it, and the design without them."""
        return self._with_same_limits(self.with_numbers(design.brought)), replace(design, numbers={})

    def settled(self, design: Designs) -> "tuple[Problem, Designs]":
        """As ``alone``, but the design still brings what tolerances of a robust cam move."""
        kept = {key: value for key, value in design.numbers.items() if key in self.zones}
        changed, bare = self.alone(design.without(kept))
        return changed, bare.with_values(kept)

    @cached_property
    def nominal(self) -> Off:
        """The numbers of the scene, by key: sizes, and all that it gives besides."""
        return nominal_of(self.variables, self.design, self.setup.given.values)

    def without(self, key: str) -> "Problem":
        """The problem without the bound of a key, and without all limits that it gives."""
        names = {limit.name for limit in self.limits if limit.key == key}
        changed = self.with_numbers({key: None})
        return replace(changed, limits=tuple(limit for limit in changed.limits if limit.name not in names))

    def with_laws(self, rise: str | None, fall: str | None) -> Programme:
        """The scene's programme with other laws, by name, on its rises and returns (None keeps them)."""
        return self.driving(self.asked_by(rise, fall))

    def asked_by(self, rise: str | None, fall: str | None) -> Programme:
        """The motion that is asked, of the tool or the follower itself, with other laws."""
        chosen = (None if name is None else self.laws[name] for name in (rise, fall))
        return self.given.with_laws(*chosen)

    @property
    def given(self) -> Programme:
        """The motion that the scene gives: of the tool, or of the follower."""
        return self.programme.given

    @property
    def given_turns(self) -> bool:
        """Whether that motion is an angle."""
        return self.setup.angular if self.programme.given_at_follower else self.setup.tool_turns

    def driving(self, asked: Programme) -> Programme:
        """The turn of the follower that moves as asked, or drives a tool so, under the scene's load.

        Raises
        ------
        BadInput
            If the tool goes beyond a dead point of the train.
        """
        return self.values.driving(asked, self.setup, self.segments)

    def trains(self, numbers: Mapping[str, Any]) -> Train:
        """The trains with other numbers, by key of the scene: arrays, or ranges with slopes."""
        return self.values.trains(numbers, angular=self.setup.angular)

    def train_off(self, errors: Mapping[str, Any]) -> Train:
        """The trains whose links are off, by key of the scene, in its units; other errors move no link."""
        own = {key: self.nominal[key] + by for key, by in errors.items() if is_of_train(key)}
        assert self.setup.train is not None
        return self.trains(own) if own else self.setup.train

    @property
    def contacts(self) -> "tuple[Problem, ...]":
        """That of each contact of the follower, as of an ordinary cam with the motion of its own."""
        first = replace(self, setup=replace(self.setup, mechanism=self.setup.mechanism._replace(further=())))
        found = [first]
        for each in self.setup.mechanism.further:
            own = replace(first, design=each.seen(self.design))
            found.append(
                replace(own, programme=self.programme.reversed)
                if each.mechanism.reverses
                else replace(own, setup=replace(first.setup, mechanism=each.mechanism))
            )
        return tuple(found)

    @property
    def half_width(self) -> float:
        """How far walls and profile are from the pitch curve: the roller's radius and half its clearance, mm."""
        return float(np.squeeze(self.setup.half_width(self.design)))

    @property
    def size_name(self) -> str:
        """The quantity of the size of the cam."""
        return self.setup.mechanism.body.size_quantity

    @cached_property
    def sizes(self) -> frozenset[str]:
        """The quantities of the sizes of a design."""
        return frozenset(n for n in offered(self.setup) if quantity_of(n, self.setup).effect == "sizes")

    @cached_property
    def without_last(self) -> "Problem":
        """The problem without the limits that are asked last."""
        return replace(self, limits=tuple(limit for limit in self.limits if not limit.last))

    @property
    def has_last(self) -> bool:
        """Whether there are limits that are asked last."""
        return any(limit.last for limit in self.limits)

    @property
    def claims(self) -> tuple[Claim, ...]:
        """The claims of all limits on curves."""
        return tuple(claim for limit in self.limits for claim in limit.claims)

    @cached_property
    def limits_of_pitch(self) -> tuple[Limit, ...]:
        """The limits that claims on pitch curves alone decide, whatever body rolls along them."""
        curves = self.setup.mechanism.of_pitch
        return tuple(
            limit
            for limit in self.limits
            if limit.claims and all(claim.curve in curves and claim.factor is unweighted for claim in limit.claims)
            if not limit.infinite_at(self.programme)
        )

    @cached_property
    def is_unproved(self) -> bool:
        """Whether a number decides a limit that has no enclosure, as that of a Python function."""
        return any(limit.is_unproved for limit in self.limits)

    @property
    def needed(self) -> frozenset[str]:
        """The quantities that limits and objectives call for."""
        return needs_of(self.limits).union(self.objectives)

    @property
    def named(self) -> frozenset[str]:
        """The quantities of the scene's named outputs, or else those of motion and geometry; and its own."""
        outputs = self.outputs or GEOMETRY
        about = {name: quantity_of(name, self.setup) for name in offered(self.setup)}
        named = [name for name, each in about.items() if each.effect in outputs or EVERYTHING in outputs]
        return frozenset(named) | (frozenset(outputs) & QUANTITIES.keys()) | self.setup.own.keys()

    @cached_property
    def wanted(self) -> frozenset[str]:
        """The wanted quantities: the scene's outputs, or else motion and geometry; and those that limits need."""
        return self.needed | self.named


@lru_cache(maxsize=4)  # the motions of a space have one setup
def _to_error(same: Same[Setup], relative_error: float) -> Setup:
    return replace(same.value, relative_error=relative_error)


@dataclass(frozen=True)
class SceneValues:
    """The values of a scene for setup and limits, which can be replaced; only this module reads them."""

    _scene: Scene

    def replaced(self, values: Mapping[str, float | None]) -> "SceneValues":
        """The same with other values by key of the scene, checked already; None removes one."""
        return SceneValues(self._scene.with_values(values))

    @property
    def setup(self) -> Setup:
        """The setup that they make."""
        return setup_of(self._scene)

    @property
    def unmoved(self) -> str:
        """Why the train cannot move the follower as asked; empty if it can."""
        return unmoved(self._scene)

    def driving(self, asked: Programme, setup: Setup, segments: Sequence[GivenSegment]) -> Programme:
        """The turn of the follower that moves as asked, or drives a tool so, under the scene's load."""
        _, load = constant_and_changing(*load_and_unit(self._scene))
        brought = train_load(self._scene.train, setup.train, load)
        return through_train(asked, segments, self._scene, setup.train, brought)

    def trains(self, numbers: Mapping[str, Any], *, angular: bool) -> Train:
        """The trains with other numbers, from a follower whose motion is an angle or not."""
        return trains_from(self._scene.train, numbers, angular=angular)

    def limits(self, setup: Setup) -> tuple[Limit, ...]:
        """The limits that they set to designs of a setup."""
        return limits_of(self._scene, setup)


def resolve(scene: Scene) -> Problem:
    """Turn a validated scene into inside units: mm, s, rad.

    Raises
    ------
    BadInput
        For a robust search of numbers whose tolerances are not the same for all of their values.
    """
    problem = _resolved(Same(scene))
    given = scene.tolerances.numbers if scene.search.robust else {}
    classes = [each for each in problem.variables if each.is_searched and each.key in given and given[each.key].iso]
    if classes:
        raise BadInput(
            [Mistake(scene.file, f"tolerances.{v.key}", given[v.key].iso, _of_class(v)) for v in classes]
        )
    return problem


def _of_class(searched: Variable) -> str:
    return f"± mm: with search.robust no class of a size that [search] varies; or leave out {searched.searched}"


@lru_cache(maxsize=4)  # a command asks several times of its scene
def _resolved(same: Same[Scene]) -> Problem:
    """As ``resolve``, of a design that a search leaves as it is."""
    scene = same.value
    variables = variables_of(scene)
    given = scene.numbers(each.key for each in variables)
    missing = [v for v in variables if given[v.key] is None and (v.is_size or v.is_searched)]
    missing = [v for v in missing if v.key not in SECOND_FIELDS]
    firsts = {f"second_{v.field}": given[v.key] for v in variables if v.is_size}
    given |= {v.key: firsts[v.field] for v in variables if v.key in SECOND_FIELDS and given[v.key] is None}
    setup = setup_of(scene.with_values({each.key: each.first for each in missing if not each.is_size}))
    sized = [v for v in variables if v.is_size and (v in missing or given[v.key] is not None)]
    sizes = {v.field: np.array([nan if v in missing else given[v.key]]) for v in sized}
    absent: dict[str, Any] = {name: np.zeros(1) for name in SIZE_FIELDS}
    design = Designs(**absent, sense=1.0 if scene.cam.rotation == "ccw" else -1.0).with_values(sizes)
    if mistakes := [*not_offered(scene, setup), *out_of_reach(scene, setup)]:
        raise BadInput(mistakes)
    laws = {**LAWS, **{name: law_of(name, law) for name, law in scene.laws.items()}}
    values, (_, load) = SceneValues(scene), constant_and_changing(*load_and_unit(scene))
    turn = given_segments(scene.motion, scene.cam.rpm)
    if scene.profile:
        motion = programme_of(scene, load)
    else:
        motion = Programme.from_segments(turn, angular=scene.given_turns, laws=laws, load=load)
    programme = values.driving(motion, setup, turn)
    if mistakes := unlike_halves(scene, programme):
        raise BadInput(mistakes)
    return Problem(
        file=scene.file,
        setup=setup,
        laws=laws,
        programme=programme,
        segments=tuple(turn),
        profile=tuple(inf if each.radius is None else each.radius for each in scene.profile),
        design=design,
        limits=limits_of(scene, setup),
        objectives=scene.search.objectives,
        outputs=scene.outputs,
        choices=choices_of(scene.search, variables, turn),
        variables=variables,
        missing=tuple(missing),
        accuracy=scene.accuracy.relative_error,
        values=values,
        zones=(zones := robust_zones(scene, variables, nominal_of(variables, design, setup.given.values))),
        offs=looked_at(zones),
    )


def resolve_design(scene: Scene) -> Problem:
    """As ``resolve``, for a scene that gives every size and number of its design.

    Raises
    ------
    BadInput
        For each size, or other number, that it leaves to a search.
    """
    problem = _resolved(Same(scene))
    if mistakes := missing(problem):
        raise BadInput(mistakes)
    return problem


def missing(problem: Problem, searched: Collection[str] = ()) -> list[Mistake]:
    """A mistake for each size or number that the scene does not give, but for those searched, by key."""
    return [
        Mistake(problem.file, each.key, None, WITHOUT_SIZE if each.is_size else WITHOUT_NUMBER, bare=True)
        for each in problem.missing
        if each.key not in searched
    ]


def claims_on(problem: Problem, made: Callable[[Designs, Programme], Any] | None) -> list[Claim]:
    """The claims of the limits on one of the mechanism's curves; none if it has no such curve."""
    return [claim for claim in problem.claims if claim.curve is made]


def strictest(claims: Iterable[Claim]) -> list[Claim]:
    """Some claims without those that a stricter one on the same curve and strokes implies."""
    found: dict[Any, Claim] = {}
    for claim in claims:
        same = claim.comparable
        if same not in found or claim.strictness > found[same].strictness:
            found[same] = claim
    return list(found.values())


def exactly(problem: Problem) -> Problem:
    """The problem at a relative error near rounding, for the few designs whose digits count."""
    return problem.to_error(min(problem.setup.relative_error, SINGLE_ERROR))
