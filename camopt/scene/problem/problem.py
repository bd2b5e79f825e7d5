"""``Problem``: a scene in inside units (mm, s, rad), with its setup, programme, design and limits.

``resolve`` makes a problem from a scene. Solvers, reports and pictures read the problem, not the scene.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, nan
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics.identity_cache import cached_by_identity
from camopt.core.quantities import EVERYTHING, GEOMETRY, QUANTITIES
from camopt.model.effects import (
    Setup,
    available_quantities,
    find_quantity,
    quantities_to_compute_by_effect,
    setup_effects,
)
from camopt.model.effects.peak import unit_weight
from camopt.model.mechanisms import SECOND_FIELDS, SIZE_FIELDS, Designs
from camopt.model.motion.law import Law
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import MotionSegment
from camopt.model.trains.train import Train
from camopt.scene.load import split_constant_and_changing_load
from camopt.scene.own_laws import laws_of_scene
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.limit import Limit, quantities_of_limits
from camopt.scene.problem.limits import limits_of_scene
from camopt.scene.problem.rows import Objectives
from camopt.scene.problem.search_space import SearchSpace, search_space_of
from camopt.scene.problem.setup import external_load_and_its_unit, setup_of
from camopt.scene.problem.tolerance_zones import (
    NumberErrors,
    collect_nominal_numbers,
    initial_robust_errors,
    tolerance_zones_of_robust_search,
    with_added_errors,
)
from camopt.scene.problem.train_motion import follower_motion_through_train, train_fault
from camopt.scene.problem.unavailable_quantities import (
    unavailable_limits,
    unavailable_outputs,
    yoke_motion_mistakes,
)
from camopt.scene.problem.variables import Variable, is_train_key, variables_of_scene
from camopt.scene.profile import profile_programme_if_known
from camopt.scene.scene import Scene
from camopt.scene.segments import motion_segments_of_rows
from camopt.scene.tolerances import ToleranceZone
from camopt.scene.train import build_trains

MISSING_SIZE = (
    "missing; only commands that find sizes work without it: optimise, serve, effects, and sweep if [search] has it"
)
MISSING_NUMBER = "missing; only sweep and optimise work without it, if [search] has it"
CURVE_WORK, PIECE_WORK, BOX_DESIGNS = 300.0, 0.01, 200
# work of a limit, and of each piece of its curve for a design; designs that take as much work as a box
SINGLE_DESIGN_ERROR = (
    1e-13  # relative error for single designs, whose digits people compare; it costs nothing there
)


@dataclass(frozen=True)
class Problem:
    """A scene in inside units: setup, laws, programme, design, limits, and the quantities to report."""

    file: str
    """The name of the scene in messages."""
    setup: Setup
    laws: Mapping[str, Law]
    """All laws that the scene can name: built-in ones and its own."""
    programme: Programme
    """The motion of the follower over a turn."""
    segments: tuple[MotionSegment, ...]
    """The segments in the scene; empty with a profile."""
    profile: tuple[float, ...]
    """The radii of the given profile's arcs [mm]: below 0 where hollow, infinite for a line."""
    design: Designs
    """The design of the scene; a size that the scene leaves to its search is NaN (``resolve_design``)."""
    limits: tuple[Limit, ...]
    objectives: Objectives
    outputs: tuple[str, ...]
    """Names of quantities and effects to report."""
    search_space: SearchSpace
    variables: tuple[Variable, ...]
    """The sizes and numbers that may differ between designs, searched or not; no angles."""
    missing_variables: tuple[Variable, ...]
    """The variables that the scene leaves to its search."""
    accuracy: float
    """Largest relative error of reported values; that of the setup may be smaller."""
    _scene: Scene
    """The scene behind the problem, to make setup and limits for other values; only this module reads it."""
    zones: Mapping[str, ToleranceZone] = field(default_factory=dict)
    """Tolerance zones of a robust search, by field of designs or key of the train: cams in them meet the limits."""
    robust_errors: tuple[NumberErrors, ...] = ()
    """Errors at which a robust search checks the limits: corners of the zones, and worse points found later."""

    def evaluation_work(self, design_count: int, box_count: int = 0) -> float:
        """Work of an evaluation of all limits for some designs or boxes (``core.numerics.budget``)."""
        return (1 + len(self.robust_errors)) * (
            len(self.limits)
            * (
                CURVE_WORK
                + PIECE_WORK * self.programme.table.half_width.size * (design_count + BOX_DESIGNS * box_count)
            )
            + design_count
            * sum(
                setup_effects(self.setup)[name].work
                for name in quantities_to_compute_by_effect(self.required_quantities, self.setup)
            )
        )

    def nominal_and_error_variants(self, designs: Designs) -> Iterator[tuple["Problem", Designs]]:
        """The nominal designs, then the designs with each of the robust errors, each with its problem.

        Designs may have any kind of number. Only the first problem has limits on motion errors, since these cover
        all cams within the tolerances already.
        """
        yield self, designs
        for problem, errors in self.error_variants:
            yield problem, with_added_errors(designs, errors)

    @cached_property
    def error_variants(self) -> "tuple[tuple[Problem, NumberErrors], ...]":
        """Each of the robust errors as a problem with the errors of its train, and the errors of designs."""
        problems = dict[frozenset[tuple[str, float]], Problem]()
        pairs = []
        for errors in self.robust_errors:
            shared, of_design = self.split_train_and_design_errors(errors)
            place = frozenset(shared.items())
            if place not in problems:
                problems[place] = self.without_motion_error_limits.with_number_errors(shared)
            pairs.append((problems[place], of_design))
        return tuple(pairs)

    def split_train_and_design_errors(self, errors: NumberErrors) -> tuple[NumberErrors, NumberErrors]:
        """Errors of numbers that designs do not have (those of the train), and errors of numbers of designs."""
        shared = {key: by for key, by in errors.items() if key not in self.design.values}
        return shared, {key: by for key, by in errors.items() if key not in shared}

    def with_number_errors(self, errors: NumberErrors) -> "Problem":
        """The problem with errors added to its numbers, such as those of a train, under the same limits."""
        if not errors:
            return self
        most = {key: self.setup.given[key] for key in self.setup.free}
        changed = self.with_numbers({**most, **{key: self.nominal_numbers[key] + by for key, by in errors.items()}})
        return self._with_only_own_limits(changed.with_keys_per_design(self.setup.free))

    def _with_only_own_limits(self, changed_problem: "Problem") -> "Problem":
        """The changed problem with only the limits that this problem has."""
        given = {(limit.name, limit.bound): limit for limit in changed_problem.limits}
        return replace(
            changed_problem, limits=tuple(given.get((limit.name, limit.bound), limit) for limit in self.limits)
        )

    @cached_property
    def without_motion_error_limits(self) -> "Problem":
        """The problem without limits on motion errors by tolerances."""
        return replace(self, limits=tuple(limit for limit in self.limits if not limit.is_on_motion_error))

    def with_relative_error(self, relative_error: float) -> "Problem":
        """The problem with another relative error of its extremes."""
        return replace(self, setup=_with_relative_error(self.setup, relative_error))

    def with_programme(self, programme: Programme) -> "Problem":
        """The problem of another motion of the same follower, with the same limits."""
        problem = replace(self, programme=programme)
        vars(problem)["evaluated_quantities"] = self.evaluated_quantities  # they do not depend on the motion
        return problem

    def with_numbers(self, numbers: Mapping[str, float | None]) -> "Problem":
        """The problem with other numbers of the scene, by key; sizes and relative error stay."""
        if not numbers:
            return self
        scene = self._scene.with_values(numbers)
        changes_train = any(map(is_train_key, numbers))
        if changes_train and (why := train_fault(scene)):
            named = ", ".join(f"{key} = {value:.6g}" for key, value in numbers.items())
            return replace(self, setup=self.setup.with_numbers(numbers)).with_no_assembly(f"{why} (with {named})")
        setup = replace(
            setup_of(scene), relative_error=self.setup.relative_error, free=self.setup.free - numbers.keys()
        )
        changed = replace(self, _scene=scene, setup=setup, limits=limits_of_scene(scene, setup))
        return changed.with_given_motion(self.given_motion) if changes_train else changed

    def with_given_motion(self, given_motion: Programme) -> "Problem":
        """The problem of another given motion; if the train cannot move so far, no design can be assembled."""
        try:
            return self.with_programme(self.follower_motion(given_motion))
        except BadInput as error:
            return self.with_no_assembly(error.mistakes[0].allowed)

    def with_no_assembly(self, why: str) -> "Problem":
        """The problem in which no design can be assembled, with the reason."""
        return replace(self, setup=replace(self.setup, mechanism=self.setup.mechanism.with_no_assembly(why)))

    def with_numbers_per_design(self, largest_values: Mapping[str, float]) -> "Problem":
        """The problem whose designs each have their own value of these numbers.

        ``largest_values`` gives the largest of each, by key.
        """
        if not largest_values:
            return self
        setup = self.with_numbers(largest_values).setup
        return replace(self, setup=setup).with_keys_per_design(largest_values)

    def with_keys_per_design(self, keys: Collection[str]) -> "Problem":
        """The problem whose designs have numbers of their own, by key; its own numbers stay."""
        setup = replace(self.setup, free=self.setup.free.union(keys))
        return replace(self, setup=setup, limits=self.limits_with_setup(setup))

    def limits_with_setup(self, setup: Setup) -> tuple[Limit, ...]:
        """The limits of the scene on designs of another setup."""
        return limits_of_scene(self._scene, setup)

    def absorb_design_numbers(self, design: Designs) -> "tuple[Problem, Designs]":
        """The problem with the numbers of one design as its own, and the design without them."""
        return self._with_only_own_limits(self.with_numbers(design.number_values)), replace(design, numbers={})

    def absorb_untoleranced_numbers(self, design: Designs) -> "tuple[Problem, Designs]":
        """As ``absorb_design_numbers``, but the design keeps numbers with a robust tolerance zone."""
        kept = {key: value for key, value in design.numbers.items() if key in self.zones}
        changed, bare = self.absorb_design_numbers(design.without_numbers(kept))
        return changed, bare.with_values(kept)

    @cached_property
    def nominal_numbers(self) -> Mapping[str, float]:
        """The nominal numbers of the scene, by key: sizes and other numbers."""
        return collect_nominal_numbers(self.variables, self.design, self.setup.given.values)

    def without_bound(self, key: str) -> "Problem":
        """The problem without the bound of a key, and without the limits that it sets."""
        names = {limit.name for limit in self.limits if limit.key == key}
        changed = self.with_numbers({key: None})
        return replace(changed, limits=tuple(limit for limit in changed.limits if limit.name not in names))

    def follower_motion_with_laws(self, rise_law: str | None, return_law: str | None) -> Programme:
        """The motion of the follower with other laws on rises and returns, by name; None keeps the law."""
        return self.follower_motion(self.given_motion_with_laws(rise_law, return_law))

    def given_motion_with_laws(self, rise_law: str | None, return_law: str | None) -> Programme:
        """The given motion, of tool or follower, with other laws on rises and returns, by name."""
        return self.given_motion.with_laws(
            *(None if name is None else self.laws[name] for name in (rise_law, return_law))
        )

    @property
    def given_motion(self) -> Programme:
        """The motion that the scene gives, of the tool or of the follower."""
        return self.programme.programme_given_by_scene

    @property
    def given_motion_is_angle(self) -> bool:
        """Whether the given motion is an angle."""
        return self.setup.angular if self.programme.given_at_follower else self.setup.tool_turns

    def follower_motion(self, given_motion: Programme) -> Programme:
        """The motion of the follower that gives the follower or the tool a motion, under the scene's load.

        Raises
        ------
        BadInput
            If the tool goes beyond a dead point of the train.
        """
        return follower_motion_through_train(given_motion, self.segments, self._scene, self.setup.train)

    def trains_with_numbers(self, numbers: Mapping[str, Any]) -> Train:
        """Trains with other numbers, by key of the scene: arrays, or ranges with slopes."""
        return build_trains(self._scene.train, numbers, angular=self.setup.angular)

    def train_with_errors(self, errors: Mapping[str, Any]) -> Train:
        """The train with errors of its numbers, by key and in units of the scene; other errors are ignored."""
        numbers = {key: self.nominal_numbers[key] + by for key, by in errors.items() if is_train_key(key)}
        assert self.setup.train is not None
        return self.trains_with_numbers(numbers) if numbers else self.setup.train

    @property
    def problem_of_each_contact(self) -> "tuple[Problem, ...]":
        """The problem of each contact of the follower, as an ordinary cam with its own motion."""
        first = replace(
            self, setup=replace(self.setup, mechanism=self.setup.mechanism._replace(further_contacts=()))
        )
        problems = [first]
        for contact in self.setup.mechanism.further_contacts:
            local = replace(first, design=contact.local_designs(self.design))
            problems.append(
                replace(local, programme=self.programme.reversed_programme)
                if contact.mechanism.reverses
                else replace(local, setup=replace(first.setup, mechanism=contact.mechanism))
            )
        return tuple(problems)

    @property
    def wall_distance_from_pitch_curve(self) -> float:
        """Distance of walls and profile from the pitch curve: radius of the roller plus half its clearance [mm]."""
        return float(np.squeeze(self.setup.pitch_to_flank_distance(self.design)))

    @property
    def size_quantity_name(self) -> str:
        """The name of the quantity for the cam's size."""
        return self.setup.mechanism.body.size_quantity

    @cached_property
    def size_quantity_names(self) -> frozenset[str]:
        """The names of the quantities for all sizes of a design."""
        return frozenset(
            n for n in available_quantities(self.setup) if find_quantity(n, self.setup).effect == "sizes"
        )

    @cached_property
    def without_deferred_limits(self) -> "Problem":
        """The problem without the limits that are checked last."""
        return replace(self, limits=tuple(limit for limit in self.limits if not limit.is_deferred))

    @property
    def has_deferred_limits(self) -> bool:
        """Whether some limits are checked last."""
        return any(limit.is_deferred for limit in self.limits)

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraints of all limits on curves."""
        return tuple(constraint for limit in self.limits for constraint in limit.constraints)

    @cached_property
    def pitch_curve_limits(self) -> tuple[Limit, ...]:
        """The limits that depend on pitch curves alone, not on the radius of roller or face."""
        curves = self.setup.mechanism.curves_shared_by_pitch_curve
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
        """Whether a limit depends on a number without an enclosure, such as that of a Python function."""
        return any(limit.lacks_enclosure for limit in self.limits)

    @property
    def required_quantities(self) -> frozenset[str]:
        """The quantities that limits and objectives need."""
        return quantities_of_limits(self.limits).union(self.objectives)

    @property
    def output_quantities(self) -> frozenset[str]:
        """The quantities of ``outputs`` (by default motion and geometry), and those that the scene defines."""
        outputs = self.outputs or GEOMETRY
        quantities = {name: find_quantity(name, self.setup) for name in available_quantities(self.setup)}
        named = [name for name, each in quantities.items() if each.effect in outputs or EVERYTHING in outputs]
        return frozenset(named) | (frozenset(outputs) & QUANTITIES.keys()) | self.setup.own_quantities.keys()

    @cached_property
    def evaluated_quantities(self) -> frozenset[str]:
        """All quantities to evaluate: outputs, and those that limits and objectives need."""
        return self.required_quantities | self.output_quantities


@cached_by_identity(maxsize=4)  # all motions of a space share one setup
def _with_relative_error(setup: Setup, relative_error: float) -> Setup:
    return replace(setup, relative_error=relative_error)


def resolve(scene: Scene) -> Problem:
    """Convert a checked scene to a problem in inside units: mm, s, rad.

    Raises
    ------
    BadInput
        For a robust search of a size with a class of ISO 286, whose zone depends on the size.
    """
    problem = _cached_problem(scene)
    given = scene.tolerances.numbers if scene.search.robust else {}
    classes = [each for each in problem.variables if each.is_searched and each.key in given and given[each.key].iso]
    if classes:
        raise BadInput(
            Mistake(
                scene.file,
                f"tolerances.{v.key}",
                given[v.key].iso,
                f"± mm with search.robust, since [search] varies this size; or leave {v.search_key} out",
            )
            for v in classes
        )
    return problem


@cached_by_identity(maxsize=4)  # a command resolves its scene several times
def _cached_problem(scene: Scene) -> Problem:
    """As ``resolve``, without the check of a robust search."""
    variables = variables_of_scene(scene)
    given = scene.numbers(each.key for each in variables)
    missing = [
        v for v in variables if given[v.key] is None and (v.is_size or v.is_searched) and v.key not in SECOND_FIELDS
    ]
    firsts = {f"second_{v.field}": given[v.key] for v in variables if v.is_size}
    given |= {v.key: firsts[v.field] for v in variables if v.key in SECOND_FIELDS and given[v.key] is None}
    setup = setup_of(scene.with_values({each.key: each.first_value for each in missing if not each.is_size}))
    sized = [v for v in variables if v.is_size and (v in missing or given[v.key] is not None)]
    sizes = {v.field: np.array([nan if v in missing else given[v.key]]) for v in sized}
    absent: dict[str, Any] = {name: np.zeros(1) for name in SIZE_FIELDS}
    design = Designs(**absent, sense=1.0 if scene.cam.rotation == "ccw" else -1.0).with_values(sizes)
    if mistakes := [*unavailable_outputs(scene, setup), *unavailable_limits(scene, setup)]:
        raise BadInput(mistakes)
    laws = laws_of_scene(scene)
    _, load = split_constant_and_changing_load(*external_load_and_its_unit(scene))
    turn = motion_segments_of_rows(scene.motion, scene.cam.rpm)
    motion = profile_programme_if_known(scene, load) if scene.profile else None
    if motion is None:
        motion = Programme.from_segments(turn, angular=scene.given_motion_is_angle, laws=laws, load=load)
    programme = follower_motion_through_train(motion, turn, scene, setup.train)
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
        limits=limits_of_scene(scene, setup),
        objectives=scene.search.objectives,
        outputs=scene.outputs,
        search_space=search_space_of(scene.search, variables, turn),
        variables=variables,
        missing_variables=tuple(missing),
        accuracy=scene.accuracy.relative_error,
        _scene=scene,
        zones=(
            zones := tolerance_zones_of_robust_search(
                scene, variables, collect_nominal_numbers(variables, design, setup.given.values)
            )
        ),
        robust_errors=initial_robust_errors(zones),
    )


def resolve_design(scene: Scene) -> Problem:
    """As ``resolve``, for a scene with every size and number of its design.

    Raises
    ------
    BadInput
        For each size or number that the scene leaves to its search.
    """
    problem = _cached_problem(scene)
    if mistakes := missing_variable_mistakes(problem):
        raise BadInput(mistakes)
    return problem


def missing_variable_mistakes(problem: Problem, searched_keys: Collection[str] = ()) -> list[Mistake]:
    """A mistake for each size or number that is missing in the scene and not among ``searched_keys``, by key."""
    return [
        Mistake(problem.file, each.key, None, MISSING_SIZE if each.is_size else MISSING_NUMBER, bare=True)
        for each in problem.missing_variables
        if each.key not in searched_keys
    ]


def constraints_on_curve(problem: Problem, curve: Callable[[Designs, Programme], Any] | None) -> list[Constraint]:
    """The constraints on one of the mechanism's curves; empty if the mechanism has no such curve."""
    return [constraint for constraint in problem.constraints if constraint.curve is curve]


def strictest_constraints(constraints: Iterable[Constraint]) -> list[Constraint]:
    """The strictest constraint on each curve and kind of stroke."""
    strictest: dict[Any, Constraint] = {}
    for constraint in constraints:
        key = constraint.comparison_key
        if key not in strictest or constraint.strictness > strictest[key].strictness:
            strictest[key] = constraint
    return list(strictest.values())


def with_rounding_relative_error(problem: Problem) -> Problem:
    """The problem with a relative error near rounding, for single designs whose digits people compare."""
    return problem.with_relative_error(min(problem.setup.relative_error, SINGLE_DESIGN_ERROR))
