"""The plan of a sweep: a problem with objectives, its space of designs, and which designs to keep."""

import tomllib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from camopt.core.engines import Engine
from camopt.core.engines.threads import Threads
from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.quantities import Quantity, in_column_order, motion_peak_name
from camopt.core.quantities.function import FunctionCall
from camopt.core.storage.version import camopt_and_kernel_version
from camopt.model.effects import find_effect, find_quantity
from camopt.model.motion.installed_laws import installed_laws
from camopt.scene.arguments import check_count
from camopt.scene.mapping import leaf_values_by_key
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.rows import VERDICT_COLUMNS
from camopt.scene.problem.sample import sweep_space
from camopt.scene.problem.space import DesignSpace
from camopt.scene.scene import Scene
from camopt.solve.front.blocks import BLOCK_SIZE, SHARING_BLOCK_SIZE, BlockBatch, SpaceBlocks, merge_batches
from camopt.solve.front.curve_numbers import CurveNumbers, shared_pitch_curve_numbers
from camopt.solve.front.curve_verdicts import pitch_curves_decide_all_limits

FRONT_ONLY = "front-only"
SWEEP_PARTS = 100_000
SAMPLE_BLOCKS = 3  # blocks spread over the space that need all kernels
TABLED_KEEPS = ("feasible", "all")
KEEP_CHOICES = ("pareto", *TABLED_KEEPS, FRONT_ONLY)
"""The choices of designs for the table of designs; the last, an old name of the first, writes no such table."""
BOXES_OF_ONE, BOXES_OF_MORE = 90_000, 350_000  # pitch curves per motion from which boxes find the front sooner
DESIGN_COST = 1 / 12  # time of a design relative to that of its pitch curve


@dataclass(frozen=True)
class SweepKey:
    """The key of a sweep, or of a part of one, for other machines and later runs: equal keys give equal rows."""

    scene: str
    """TOML, with objectives."""
    keep: str
    block: int
    """The most designs of a block."""
    version: str
    """The version of camopt, its kernels and other packages that rows depend on."""
    part: int = 1
    parts: int = 1

    @classmethod
    def from_json(cls, values: Any) -> "SweepKey":
        """The key from JSON; a ValueError or a TypeError if the values are not those of a key."""
        kinds = {field.name: field.type for field in fields(cls)}
        if not isinstance(values, dict) or {name: type(value) for name, value in values.items()} != kinds:
            raise ValueError("not the key of a sweep")
        if not (1 <= values["part"] <= values["parts"] <= SWEEP_PARTS and values["block"] >= 1):
            raise ValueError("not a part of a sweep")
        tomllib.loads(values["scene"])
        return cls(**values)

    def differences_from(self, other: "SweepKey") -> list[str]:
        """The differences of another key from this one: keys of the scene, and names of other values."""
        ours, theirs = (dict(leaf_values_by_key(tomllib.loads(question.scene))) for question in (self, other))
        keys = [key for key in {**ours, **theirs} if ours.get(key) != theirs.get(key)]
        rest = ("keep", "block", "version", "part", "parts")
        return keys + [name for name in rest if getattr(self, name) != getattr(other, name)]

    def differences_except_block_size(self, other: "SweepKey") -> list[str]:
        """The differences without the size of blocks, which rows do not depend on."""
        return [name for name in self.differences_from(other) if name != "block"]

    @property
    def key_of_whole_sweep(self) -> "SweepKey":
        """The key of the whole sweep that this part belongs to."""
        return replace(self, part=1, parts=1)

    @property
    def sweep_manifest_entry(self) -> dict[str, Any]:
        """The key as in the manifest of a whole sweep: its rows do not depend on the size of blocks."""
        return asdict(self) | {"block": BLOCK_SIZE}


@dataclass(frozen=True)
class SweepPlan:
    """A sweep that is ready to run."""

    scene: Scene
    """The scene, with objectives."""
    problem: Problem
    space: DesignSpace
    keep: str
    most: int | None = None
    """The most designs of a block; None takes what suits the space."""

    @cached_property
    def shared_pitch_curves(self) -> CurveNumbers | None:
        """The numbers of the pitch curves that designs share; None if each design is evaluated by itself."""
        return None if self.keep == "all" or self.problem.robust_errors else shared_pitch_curve_numbers(self.space)

    @cached_property
    def own_pitch_curves_decide_limits(self) -> bool:
        """Whether designs share no pitch curves, but each one's own pitch curve decides all its limits."""
        if (
            self.shared_pitch_curves
            or self.keep in TABLED_KEEPS
            or self.problem.robust_errors
            or not self.space.axes
        ):
            return False
        return pitch_curves_decide_all_limits(self.problem, frozenset(self.searched_row_columns))

    @cached_property
    def block_size(self) -> int:
        """The most designs of a block."""
        return self.most or (
            SHARING_BLOCK_SIZE if self.shared_pitch_curves or self.own_pitch_curves_decide_limits else BLOCK_SIZE
        )

    @cached_property
    def table_columns(self) -> tuple[str, ...]:
        return sweep_columns(self.problem)

    def find_quantities(self, names: Iterable[str]) -> list[Quantity]:
        return [find_quantity(name, self.problem.setup) for name in names]

    @cached_property
    def searched_row_columns(self) -> tuple[str, ...]:
        """The columns of the searched rows: all columns only if these rows are tabled or refined."""
        full = self.keep in TABLED_KEEPS or self.scene.search.refine
        return self.table_columns if full else comparison_columns(self.problem)

    @property
    def searched_row_quantities(self) -> list[Quantity]:
        return self.find_quantities(self.searched_row_columns)

    @cached_property
    def searches_front_by_boxes(self) -> bool:
        """Whether boxes of designs find the front: only the front is wanted, and the objectives allow it."""
        if self.keep in TABLED_KEEPS or self.problem.search_space.samples or self.problem.robust_errors:
            return False
        if not boxes_are_faster(self):
            return False
        from camopt.solve.front.box_bounds import can_bound_all_objectives

        return all(map(can_bound_all_objectives, self.space.problems))

    @cached_property
    def blocks(self) -> SpaceBlocks:
        """The blocks of the space."""
        every, kept, own = self.keep == "all", self.keep in TABLED_KEEPS, self.own_pitch_curves_decide_limits
        return SpaceBlocks(
            self.space, self.searched_row_columns, self.shared_pitch_curves, every, kept, self.block_size, own
        )

    def sweep_key(self, part: int = 1, parts: int = 1) -> SweepKey:
        """The key of the sweep, or of one of several equal parts."""
        text = self.scene.to_toml()
        packages = (law.package for name, law in installed_laws().items() if f'"{name}"' in text)
        version = " ".join(
            [camopt_and_kernel_version(), *packages, *(each.digest for each in self.quantity_function_calls)]
        )
        return SweepKey(text, self.keep, self.block_size, version, part, parts)

    @property
    def quantity_function_calls(self) -> list[FunctionCall]:
        """The Python functions that are quantities of the scene."""
        return [each.function_call for each in self.problem.setup.own_quantities.values() if each.function_call]

    def __reduce__(self) -> tuple[Any, ...]:
        """Another process gets the key, and the calls, which pickle the user's functions along."""
        return plan_of_key, (self.sweep_key(), self.quantity_function_calls)

    def evaluate_blocks(self, block_numbers: Sequence[int]) -> BlockBatch:
        """The merged results of consecutive blocks."""
        return merge_batches(
            [self.blocks.evaluate_block(number) for number in block_numbers], self.problem.objectives
        )

    def evaluate_in_batches(self, block_numbers: range, engine: Engine) -> Iterator[BlockBatch]:
        """The results of blocks from an engine, in batches and in order."""
        if not isinstance(engine, Threads):
            for call in self.quantity_function_calls:
                call.check_importable()  # an engine's own message would be less clear
        sample = np.unique(np.linspace(0, len(self.blocks) - 1, SAMPLE_BLOCKS, dtype=int)).tolist()
        return engine.results_in_order(self.evaluate_blocks, block_numbers, sample)

    def part_blocks(self, part: int = 1, parts: int = 1) -> range:
        """The blocks of one of several equal parts: consecutive ones."""
        return range(len(self.blocks) * (part - 1) // parts, len(self.blocks) * part // parts)


def boxes_are_faster(plan: SweepPlan) -> bool:
    """Whether boxes of designs find the front sooner than blocks, from measurements of some hundred spaces.

    Blocks take time for each pitch curve and design. Boxes take time for each motion, and more of it if several
    objectives vary between its designs, so that its part of the front has many designs.
    """
    setup, effects = plan.problem.setup, [find_effect(name, plan.problem.setup) for name in plan.problem.objectives]
    varying = [effect for effect in effects if effect is None or setup.free or not effect.is_of_motion(setup)]
    least = BOXES_OF_MORE if len(varying) > 1 else BOXES_OF_ONE
    return plan.blocks.searched_curve_count + DESIGN_COST * len(plan.space) >= least * len(plan.space.problems)


def key_from_manifest(manifest_entry: Any) -> SweepKey | None:
    """The key in a manifest's question; None if there is none."""
    with suppress(ValueError, TypeError):
        return SweepKey.from_json(manifest_entry)
    return None


def sweep_plan(scene: Scene, keep: str, block: int | None = None) -> SweepPlan:
    """The plan of a sweep of a scene. Errors are those of ``sweep``."""
    check_count("block", block)
    if keep not in KEEP_CHOICES:
        raise BadInput(
            [Mistake("camopt", "keep", keep, f"a choice of designs; {suggest_names(str(keep), KEEP_CHOICES)}")]
        )
    resolved, mistakes = resolve(scene), list[Mistake]()
    if resolved.robust_errors and scene.search.refine:
        why = "cannot refine robust cams: omit it with search.robust; optimise finds the smallest robust cam"
        mistakes.append(Mistake(scene.file, "search.refine", True, why, bare=True))
    if resolved.robust_errors and keep == "all":
        why = "with search.robust must be feasible or pareto"
        mistakes.append(Mistake("camopt", "keep", keep, why, bare=True))
    if mistakes:
        raise BadInput(mistakes)
    problem = with_default_objectives(resolved)
    if problem is not resolved:
        scene = scene.with_values({"search.minimise": tuple(problem.objectives)})
    return SweepPlan(scene, problem, sweep_space(problem), keep, block)


def plan_of_key(key: SweepKey, function_calls: Sequence[FunctionCall] = ()) -> SweepPlan:
    """The plan of a key, on another machine or in a later run; ``function_calls`` bring their functions."""
    return sweep_plan(Scene.embedded(key.scene, "sweep"), key.keep, key.block)


def with_default_objectives(problem: Problem) -> Problem:
    """The problem with objectives: the scene's, or else size, peak acceleration and pressure angle.

    With a flat face the pressure angle hardly varies, and is no objective.
    """
    if problem.objectives:
        return problem
    setup = problem.setup
    acceleration = motion_peak_name("acceleration", "", angular=setup.tool_turns, timed=setup.omega is not None)
    names = [problem.size_quantity_name, acceleration]
    names += [] if setup.mechanism.flat_faced else ["pressure_angle_max_deg"]
    return replace(problem, objectives=dict.fromkeys(names, 1.0))


def comparison_columns(problem: Problem) -> tuple[str, ...]:
    """The columns that identify designs and compare them: sizes, objectives and the verdict."""
    return tuple(in_column_order(problem.size_quantity_names | problem.objectives.keys() | set(VERDICT_COLUMNS)))


def sweep_columns(problem: Problem) -> tuple[str, ...]:
    """The columns of a sweep: sizes, quantities of limits and objectives, named outputs, and the verdict."""
    setup = problem.setup
    numbers = {name for name in problem.required_quantities if find_quantity(name, setup).kind is float}
    outputs = problem.output_quantities if problem.outputs else frozenset()
    names = problem.size_quantity_names | numbers | outputs | setup.own_quantities.keys() | set(VERDICT_COLUMNS)
    return tuple(in_column_order(names))
