"""From a scene to a problem in inside units (mm, s, rad): its setup, programme, design and limits."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from math import inf, nan
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics.identity_key import IdentityKey
from camopt.core.quantities import EVERYTHING, GEOMETRY, QUANTITIES
from camopt.model.effects import Setup, available_quantities, find_quantity
from camopt.model.effects.peak import unit_weight
from camopt.model.mechanisms import SECOND_FIELDS, SIZE_FIELDS, Designs
from camopt.model.motion import LAWS
from camopt.model.motion.law import Law
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import MotionSegment
from camopt.model.trains.train import Train
from camopt.scene.load import split_load
from camopt.scene.own_laws import own_law
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.limit import Limit, quantities_of_limits
from camopt.scene.problem.limits import limits_of
from camopt.scene.problem.rows import Objectives
from camopt.scene.problem.search_space import SearchSpace, search_space_of
from camopt.scene.problem.setup import load_and_unit, setup_of
from camopt.scene.problem.tolerance_zones import (
    NumberErrors,
    add_errors,
    collect_nominal_numbers,
    initial_robust_errors,
    robust_zones,
)
from camopt.scene.problem.train_motion import motion_through_train, train_fault
from camopt.scene.problem.unavailable_quantities import (
    unavailable_limits,
    unavailable_outputs,
    yoke_motion_mistakes,
)
from camopt.scene.problem.variables import Variable, is_train_key, variables_of
from camopt.scene.profile import profile_programme
from camopt.scene.scene import Scene
from camopt.scene.segments import given_segments
from camopt.scene.tolerances import ToleranceZone
from camopt.scene.train import build_trains, train_load

MISSING_SIZE = (
    "missing; only what finds sizes can do without it: optimise, serve, effects, a sweep whose [search] has it"
)
MISSING_NUMBER = "missing; only sweep and optimise can do without it, if [search] has it"
SINGLE_DESIGN_ERROR = 1e-13  # for single designs, whose digits people compare: it costs nothing there


@dataclass(frozen=True)
class Problem:
    """A resolved scene: setup, laws, programme and design in inside units, limits, and wanted quantities."""

    file: str
    """What messages call the scene."""
    setup: Setup
    laws: Mapping[str, Law]
    """Every law that the scene can name: the built-in ones and its own."""
    programme: Programme
    segments: tuple[MotionSegment, ...]
    """The turn as the scene gives it; none where it gives the profile of the cam."""
    profile: tuple[float, ...]
    """The radii of that profile's arcs, mm; below 0 where hollow, infinite for a line."""
    design: Designs
    """The scene's own design; a size that the scene leaves to its search is not a number (``resolve_design``)."""
    limits: tuple[Limit, ...]
    objectives: Objectives
    outputs: tuple[str, ...]
    """Quantities and effects to report besides, by name."""
    search_space: SearchSpace
    variables: tuple[Variable, ...]
    """What may differ between designs, whether searched or not; no angles."""
    missing_variables: tuple[Variable, ...]
    """Those that the scene leaves to its search."""
    accuracy: float
    """The largest relative error of reported values that is asked; the setup's may be smaller."""
    scene_values: "SceneValues"
    zones: Mapping[str, ToleranceZone] = field(default_factory=dict)
    """Between which ends numbers may be off of the cams that have to hold the limits as well, by field of designs;
    those of the train by key."""
    robust_errors: tuple[NumberErrors, ...] = ()
    """By how much they are of those that are looked at: at the corners, and where a worse one is known."""

    def all_variants(self, designs: Designs) -> Iterator[tuple["Problem", Designs]]:
        """Designs, and those that have to hold the limits with each of them, with what these have to hold.

        Of any kind of number. Limits on errors by tolerances are those of the first alone: they are of all cams
        within the tolerances already.
        """
        yield self, designs
        for own, off in self.error_variants:
            yield own, add_errors(designs, off)

    @cached_property
    def error_variants(self) -> "tuple[tuple[Problem, NumberErrors], ...]":
        """Those that have to hold the limits with designs: a problem with what these do not bring, and how far off.

        Designs do not bring the numbers of their train.
        """
        found = dict[frozenset[tuple[str, float]], Problem]()
        pairs = []
        for off in self.robust_errors:
            shared, own = self.split_errors(off)
            place = frozenset(shared.items())
            if place not in found:
                found[place] = self.without_error_limits.with_number_errors(shared)
            pairs.append((found[place], own))
        return tuple(pairs)

    def split_errors(self, off: NumberErrors) -> tuple[NumberErrors, NumberErrors]:
        """What of a cam that is off its designs do not bring, and what they do."""
        shared = {key: by for key, by in off.items() if key not in self.design.values}
        return shared, {key: by for key, by in off.items() if key not in shared}

    def with_number_errors(self, off: NumberErrors) -> "Problem":
        """The problem with numbers that are off, as those of a train, and the same limits of those it gives."""
        if not off:
            return self
        most = {key: self.setup.given[key] for key in self.setup.free}
        moved = self.with_numbers({**most, **{key: self.nominal_numbers[key] + by for key, by in off.items()}})
        return self._with_same_limits(moved.with_free_keys(self.setup.free))

    def _with_same_limits(self, changed: "Problem") -> "Problem":
        """Another problem with those limits that this one has."""
        given = {(limit.name, limit.bound): limit for limit in changed.limits}
        limits = tuple(given.get((limit.name, limit.bound), limit) for limit in self.limits)  # some may be left out
        return replace(changed, limits=limits)

    @cached_property
    def without_error_limits(self) -> "Problem":
        """The problem without limits on errors by tolerances."""
        return replace(self, limits=tuple(limit for limit in self.limits if not limit.is_on_motion_error))

    def with_relative_error(self, relative_error: float) -> "Problem":
        """The problem with another relative error of its extremes."""
        return replace(self, setup=_with_relative_error(IdentityKey(self.setup), relative_error))

    def with_programme(self, programme: Programme) -> "Problem":
        """The problem of another motion of the same follower, with the same limits."""
        problem = replace(self, programme=programme)
        vars(problem)["evaluated_quantities"] = self.evaluated_quantities  # the same for all motions
        return problem

    def with_numbers(self, numbers: Mapping[str, float | None]) -> "Problem":
        """The problem with other numbers of the scene, by key, to the same relative error; sizes stay."""
        if not numbers:
            return self
        values = self.scene_values.with_values(numbers)
        moved = any(map(is_train_key, numbers))
        if moved and (why := values.train_fault):
            named = ", ".join(f"{key} = {value:.6g}" for key, value in numbers.items())
            return replace(self, setup=self.setup.with_numbers(numbers)).with_no_assembly(f"{why} (with {named})")
        setup = replace(
            values.setup, relative_error=self.setup.relative_error, free=self.setup.free - numbers.keys()
        )
        changed = replace(self, scene_values=values, setup=setup, limits=values.limits(setup))
        return changed.with_given_motion(self.given_motion) if moved else changed

    def with_given_motion(self, asked: Programme) -> "Problem":
        """The problem of another motion that is asked; of no design, where the train cannot move so far."""
        try:
            return self.with_programme(self.follower_motion(asked))
        except BadInput as error:
            return self.with_no_assembly(error.mistakes[0].allowed)

    def with_no_assembly(self, why: str) -> "Problem":
        """The problem where no design can be assembled, for a reason."""
        return replace(self, setup=replace(self.setup, mechanism=self.setup.mechanism.with_no_assembly(why)))

    def with_free_numbers(self, numbers: Mapping[str, float]) -> "Problem":
        """The problem of designs with numbers of their own, by key of the scene, at most as large as given here."""
        if not numbers:
            return self
        setup = self.with_numbers(numbers).setup
        setup = replace(setup, free=setup.free | numbers.keys())
        return replace(self, setup=setup, limits=self.scene_values.limits(setup))

    def with_free_keys(self, keys: Collection[str]) -> "Problem":
        """The problem of designs with numbers of their own that do not change what its own are, as of the train."""
        setup = replace(self.setup, free=self.setup.free.union(keys))
        return replace(self, setup=setup, limits=self.scene_values.limits(setup))

    def absorb_design_numbers(self, design: Designs) -> "tuple[Problem, Designs]":
        """The problem with the numbers of one design in it, and the design without them."""
        return self._with_same_limits(self.with_numbers(design.number_values)), replace(design, numbers={})

    def absorb_fixed_numbers(self, design: Designs) -> "tuple[Problem, Designs]":
        """As ``absorb_design_numbers``, but the design still brings what tolerances of a robust cam move."""
        kept = {key: value for key, value in design.numbers.items() if key in self.zones}
        changed, bare = self.absorb_design_numbers(design.without_numbers(kept))
        return changed, bare.with_values(kept)

    @cached_property
    def nominal_numbers(self) -> Mapping[str, float]:
        """The numbers of the scene, by key: sizes, and all that it gives besides."""
        return collect_nominal_numbers(self.variables, self.design, self.setup.given.values)

    def without_bound(self, key: str) -> "Problem":
        """The problem without the bound of a key, and without all limits that it gives."""
        names = {limit.name for limit in self.limits if limit.key == key}
        changed = self.with_numbers({key: None})
        return replace(changed, limits=tuple(limit for limit in changed.limits if limit.name not in names))

    def follower_motion_with_laws(self, rise: str | None, fall: str | None) -> Programme:
        """The scene's programme with other laws, by name, on its rises and returns (None keeps them)."""
        return self.follower_motion(self.given_motion_with_laws(rise, fall))

    def given_motion_with_laws(self, rise: str | None, fall: str | None) -> Programme:
        """The motion that is asked, of the tool or the follower itself, with other laws."""
        chosen = (None if name is None else self.laws[name] for name in (rise, fall))
        return self.given_motion.with_laws(*chosen)

    @property
    def given_motion(self) -> Programme:
        """The motion that the scene gives: of the tool, or of the follower."""
        return self.programme.given_programme

    @property
    def given_turns(self) -> bool:
        """Whether that motion is an angle."""
        return self.setup.angular if self.programme.given_at_follower else self.setup.tool_turns

    def follower_motion(self, asked: Programme) -> Programme:
        """The turn of the follower that moves as asked, or drives a tool so, under the scene's load.

        Raises
        ------
        BadInput
            If the tool goes beyond a dead point of the train.
        """
        return self.scene_values.follower_motion(asked, self.setup, self.segments)

    def trains_with_numbers(self, numbers: Mapping[str, Any]) -> Train:
        """The trains with other numbers, by key of the scene: arrays, or ranges with slopes."""
        return self.scene_values.trains_with_numbers(numbers, angular=self.setup.angular)

    def train_with_errors(self, errors: Mapping[str, Any]) -> Train:
        """The trains whose links are off, by key of the scene, in its units; other errors move no link."""
        own = {key: self.nominal_numbers[key] + by for key, by in errors.items() if is_train_key(key)}
        assert self.setup.train is not None
        return self.trains_with_numbers(own) if own else self.setup.train

    @property
    def contact_problems(self) -> "tuple[Problem, ...]":
        """That of each contact of the follower, as of an ordinary cam with the motion of its own."""
        first = replace(
            self, setup=replace(self.setup, mechanism=self.setup.mechanism._replace(further_contacts=()))
        )
        found = [first]
        for each in self.setup.mechanism.further_contacts:
            own = replace(first, design=each.local_designs(self.design))
            found.append(
                replace(own, programme=self.programme.reversed_programme)
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
    def size_names(self) -> frozenset[str]:
        """The quantities of the sizes of a design."""
        return frozenset(
            n for n in available_quantities(self.setup) if find_quantity(n, self.setup).effect == "sizes"
        )

    @cached_property
    def without_deferred_limits(self) -> "Problem":
        """The problem without the limits that are asked last."""
        return replace(self, limits=tuple(limit for limit in self.limits if not limit.is_deferred))

    @property
    def has_deferred_limits(self) -> bool:
        """Whether there are limits that are asked last."""
        return any(limit.is_deferred for limit in self.limits)

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraints of all limits on curves."""
        return tuple(constraint for limit in self.limits for constraint in limit.constraints)

    @cached_property
    def pitch_curve_limits(self) -> tuple[Limit, ...]:
        """The limits that constraints on pitch curves alone decide, whatever body rolls along them."""
        curves = self.setup.mechanism.pitch_curves
        return tuple(
            limit
            for limit in self.limits
            if limit.constraints
            and all(
                constraint.curve in curves and constraint.factor is unit_weight for constraint in limit.constraints
            )
            if not limit.is_infinite_on_motion(self.programme)
        )

    @cached_property
    def has_unenclosed_limit(self) -> bool:
        """Whether a number decides a limit that has no enclosure, as that of a Python function."""
        return any(limit.lacks_enclosure for limit in self.limits)

    @property
    def required_quantities(self) -> frozenset[str]:
        """The quantities that limits and objectives call for."""
        return quantities_of_limits(self.limits).union(self.objectives)

    @property
    def output_quantities(self) -> frozenset[str]:
        """The quantities of the scene's named outputs, or else those of motion and geometry; and its own."""
        outputs = self.outputs or GEOMETRY
        about = {name: find_quantity(name, self.setup) for name in available_quantities(self.setup)}
        named = [name for name, each in about.items() if each.effect in outputs or EVERYTHING in outputs]
        return frozenset(named) | (frozenset(outputs) & QUANTITIES.keys()) | self.setup.own_quantities.keys()

    @cached_property
    def evaluated_quantities(self) -> frozenset[str]:
        """The wanted quantities: the scene's outputs, or else motion and geometry; and those that limits need."""
        return self.required_quantities | self.output_quantities


@lru_cache(maxsize=4)  # the motions of a space have one setup
def _with_relative_error(same: IdentityKey[Setup], relative_error: float) -> Setup:
    return replace(same.value, relative_error=relative_error)


@dataclass(frozen=True)
class SceneValues:
    """The values of a scene for setup and limits, which can be replaced; only this module reads them."""

    _scene: Scene

    def with_values(self, values: Mapping[str, float | None]) -> "SceneValues":
        """The same with other values by key of the scene, checked already; None removes one."""
        return SceneValues(self._scene.with_values(values))

    @property
    def setup(self) -> Setup:
        """The setup that they make."""
        return setup_of(self._scene)

    @property
    def train_fault(self) -> str:
        """Why the train cannot move the follower as asked; empty if it can."""
        return train_fault(self._scene)

    def follower_motion(self, asked: Programme, setup: Setup, segments: Sequence[MotionSegment]) -> Programme:
        """The turn of the follower that moves as asked, or drives a tool so, under the scene's load."""
        _, load = split_load(*load_and_unit(self._scene))
        brought = train_load(self._scene.train, setup.train, load)
        return motion_through_train(asked, segments, self._scene, setup.train, brought)

    def trains_with_numbers(self, numbers: Mapping[str, Any], *, angular: bool) -> Train:
        """The trains with other numbers, from a follower whose motion is an angle or not."""
        return build_trains(self._scene.train, numbers, angular=angular)

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
    problem = _cached_problem(IdentityKey(scene))
    given = scene.tolerances.numbers if scene.search.robust else {}
    classes = [each for each in problem.variables if each.is_searched and each.key in given and given[each.key].iso]
    if classes:
        raise BadInput(
            [Mistake(scene.file, f"tolerances.{v.key}", given[v.key].iso, _iso_class_advice(v)) for v in classes]
        )
    return problem


def _iso_class_advice(searched: Variable) -> str:
    return f"± mm: with search.robust no class of a size that [search] varies; or leave out {searched.search_key}"


@lru_cache(maxsize=4)  # a command asks several times of its scene
def _cached_problem(same: IdentityKey[Scene]) -> Problem:
    """As ``resolve``, of a design that a search leaves as it is."""
    scene = same.value
    variables = variables_of(scene)
    given = scene.numbers(each.key for each in variables)
    missing = [v for v in variables if given[v.key] is None and (v.is_size or v.is_searched)]
    missing = [v for v in missing if v.key not in SECOND_FIELDS]
    firsts = {f"second_{v.field}": given[v.key] for v in variables if v.is_size}
    given |= {v.key: firsts[v.field] for v in variables if v.key in SECOND_FIELDS and given[v.key] is None}
    setup = setup_of(scene.with_values({each.key: each.first_value for each in missing if not each.is_size}))
    sized = [v for v in variables if v.is_size and (v in missing or given[v.key] is not None)]
    sizes = {v.field: np.array([nan if v in missing else given[v.key]]) for v in sized}
    absent: dict[str, Any] = {name: np.zeros(1) for name in SIZE_FIELDS}
    design = Designs(**absent, sense=1.0 if scene.cam.rotation == "ccw" else -1.0).with_values(sizes)
    if mistakes := [*unavailable_outputs(scene, setup), *unavailable_limits(scene, setup)]:
        raise BadInput(mistakes)
    laws = {**LAWS, **{name: own_law(name, law) for name, law in scene.laws.items()}}
    values, (_, load) = SceneValues(scene), split_load(*load_and_unit(scene))
    turn = given_segments(scene.motion, scene.cam.rpm)
    if scene.profile:
        motion = profile_programme(scene, load)
    else:
        motion = Programme.from_segments(turn, angular=scene.given_turns, laws=laws, load=load)
    programme = values.follower_motion(motion, setup, turn)
    if mistakes := yoke_motion_mistakes(scene, programme):
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
        search_space=search_space_of(scene.search, variables, turn),
        variables=variables,
        missing_variables=tuple(missing),
        accuracy=scene.accuracy.relative_error,
        scene_values=values,
        zones=(
            zones := robust_zones(scene, variables, collect_nominal_numbers(variables, design, setup.given.values))
        ),
        robust_errors=initial_robust_errors(zones),
    )


def resolve_design(scene: Scene) -> Problem:
    """As ``resolve``, for a scene that gives every size and number of its design.

    Raises
    ------
    BadInput
        For each size, or other number, that it leaves to a search.
    """
    problem = _cached_problem(IdentityKey(scene))
    if mistakes := missing_variable_mistakes(problem):
        raise BadInput(mistakes)
    return problem


def missing_variable_mistakes(problem: Problem, searched: Collection[str] = ()) -> list[Mistake]:
    """A mistake for each size or number that the scene does not give, but for those searched, by key."""
    return [
        Mistake(problem.file, each.key, None, MISSING_SIZE if each.is_size else MISSING_NUMBER, bare=True)
        for each in problem.missing_variables
        if each.key not in searched
    ]


def constraints_on_curve(problem: Problem, made: Callable[[Designs, Programme], Any] | None) -> list[Constraint]:
    """The constraints of the limits on one of the mechanism's curves; none if it has no such curve."""
    return [constraint for constraint in problem.constraints if constraint.curve is made]


def strictest_constraints(constraints: Iterable[Constraint]) -> list[Constraint]:
    """Some constraints without those that a stricter one on the same curve and strokes implies."""
    found: dict[Any, Constraint] = {}
    for constraint in constraints:
        same = constraint.comparison_key
        if same not in found or constraint.strictness > found[same].strictness:
            found[same] = constraint
    return list(found.values())


def at_rounding_error(problem: Problem) -> Problem:
    """The problem at a relative error near rounding, for the few designs whose digits count."""
    return problem.with_relative_error(min(problem.setup.relative_error, SINGLE_DESIGN_ERROR))
