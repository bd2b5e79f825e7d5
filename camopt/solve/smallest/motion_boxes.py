"""The smallest cam over sizes and motions together, by branch and bound on many boxes of both at once.

The search drops a box in two cases only: a limit at some cam angle proves that the box holds no feasible cam, or a
feasible cam is known that is as small. When the search stops, the boxes that remain bound how much smaller a cam
may be.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from abc import abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics.sloped_interval import SlopedInterval
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.problem import Problem
from camopt.solve.smallest.boxes import Bisection, DesignBoxes
from camopt.solve.smallest.excesses import (
    Excesses,
    append_weighted_sum,
    choose_cut_side,
    concatenate_excesses,
    feasible_box_ends_and_empty_boxes,
    solve_linear_programme,
)
from camopt.solve.smallest.grid_search import size_scale
from camopt.solve.smallest.result import (
    SmallestCam,
    allowed_proof_gap,
    empty_known_crossings,
    first_feasible_design,
    is_provably_feasible,
)
from camopt.solve.smallest.smallest import solve_small_cam_unproved
from camopt.solve.verdicts.feasible_filter import feasible_designs
from camopt.solve.verdicts.sloped_designs import designs_of_sloped_intervals

MOTION_BATCH = 256  # boxes examined together, at most, so that the search can stop
IDLE_EXCESS = -0.5  # relative: a limit with no greater excess at any sampled point of boxes is skipped
STROKE_PLACES = 17  # evenly spaced places of each stroke at which every box is evaluated
SEARCHED_TRIALS = 2  # trials whose motion is searched: another local optimum may be better
LADDER_ROUNDS, LADDER_SIZES = 3, 16  # rounds of sizes that are tried, each round finer, and sizes in each


class BoxExcesses(NamedTuple):
    """Excesses over boxes; if one is above 0 over a box, no cam of it is feasible."""

    limits: Sequence[Excesses]
    others: Sequence[Excesses] = ()
    """Excesses over conditions that are no limits."""
    guides: Sequence[Excesses] = ()
    """Excesses that decide which side to cut, and prove nothing."""


class MotionSearch(Bisection):
    """Branch and bound over motions and the sizes of their cams, below the best cam so far."""

    most_boxes = 50_000
    bounds: SizeBounds
    best: SmallestCam
    """The smallest cam so far."""
    best_motion: Any
    """The numbers that define its motion: freed angles, or numbers of the train."""
    lift: float | None = None
    """Lift of the motions, if it differs from the problem's."""
    trial_count: int = 0

    @property
    @abstractmethod
    def motion_fields(self) -> Collection[str]:
        """The fields of boxes that define the motion."""

    @abstractmethod
    def search_ranges(self) -> SizeBounds:
        """The ranges of sizes, and of numbers that define the motion, that may hold a smaller cam."""

    @abstractmethod
    def problem_and_motion_of_design(self, design: Designs) -> tuple[Problem, Any]:
        """The problem with the motion of one design, and that motion's description."""

    @abstractmethod
    def add_worst_excess_places(self, design: Designs, problem: Problem) -> None:
        """Store the cam angles where a design in the middle of a box exceeds limits the most."""

    @abstractmethod
    def box_excesses(self, boxes: Designs, inside: Designs, template_interval: SlopedInterval) -> BoxExcesses:
        """The excesses over boxes, given as designs of sloped intervals like ``template_interval``."""

    def find_smallest_cam(self) -> SmallestCam:
        """The smallest cam, with the lower bound of its size."""
        ends = self.search_ranges()
        floor, most = ends["size"]  # most often floor exceeds most, and no smaller cam exists
        if most > floor:
            scale = size_scale(self.problem, self.bounds, self.lift)
            floor = self.size_bound_by_bisection(
                DesignBoxes.single_box(ends, scale, self.problem.search_space.variables)
            )
        return replace(self.best, floor=floor)

    def boxes_with_possible_motion(self, boxes: DesignBoxes) -> DesignBoxes:
        """The parts of boxes that contain motions at all."""
        return boxes

    def select_batch(self, boxes: DesignBoxes) -> tuple[DesignBoxes, DesignBoxes]:
        """The boxes with the smallest cams, and the rest."""
        order = np.argsort(boxes.low["size"], kind="stable")
        return boxes.take(order[:MOTION_BATCH]), boxes.take(order[MOTION_BATCH:])

    def contract_boxes_and_improve_incumbent(self, boxes: DesignBoxes) -> DesignBoxes:
        """The parts of boxes that may hold a smaller cam; cams of the first box are tried on the way."""
        boxes, cams = self.contract_by_limits(self.boxes_with_possible_motion(boxes))
        if len(cams):
            self.trial_count += 1
            self.try_cams(cams, with_grid_search=self.trial_count <= SEARCHED_TRIALS)
        return boxes

    def contract_by_limits(self, boxes: DesignBoxes) -> tuple[DesignBoxes, DesignBoxes]:
        """The boxes that may hold a smaller cam, without the parts that limits exclude, and cams to try.

        The cams differ in their sizes alone, from the least size in the first box under the linearised limits on.
        """
        if self.best.design is not None:
            boxes = self.drop_finished_and_lower_floor(
                boxes, boxes.low["size"] >= self.best.size - allowed_proof_gap(self.best.design)
            )
            boxes = boxes.cap_sizes(self.best.size)
        if not len(boxes):
            return boxes, boxes
        inside = boxes.middle_designs(self.problem.design)
        sloped, like = designs_of_sloped_intervals(
            boxes.as_interval_designs(self.problem.design), inside, list(boxes.free), 1
        )
        middle = np.array([inside.values[name] for name in boxes.free])
        low, high = (np.array([ends[name] for name in boxes.free]) for ends in (boxes.low, boxes.high))
        with np.errstate(all="ignore"):
            reach = like.span
            limits, others, guides = self.box_excesses(sloped, inside, like)
            if not limits:
                cut = boxes.with_ends_and_cut_side({}, {}, np.argmax(reach.high, axis=0))
                return cut, boxes.cams_at_point_of_first_box(middle[:, 0])
            over = concatenate_excesses([*limits, *others])
            multipliers, optimum = solve_linear_programme(over, reach, boxes.free.index("size"))
            cams = boxes.cams_at_point_of_first_box(middle[:, 0] + optimum)
            low, high, empty = feasible_box_ends_and_empty_boxes(
                append_weighted_sum(over, multipliers), low, high, middle
            )
            side = choose_cut_side(concatenate_excesses([*limits, *guides]), reach)
        new_low, new_high = (dict(zip(boxes.free, end, strict=True)) for end in (low, high))
        boxes = boxes.with_ends_and_cut_side(new_low, new_high, side).take(~empty)
        return self.drop_finished_and_lower_floor(boxes, boxes.too_narrow_to_cut), cams

    def try_cams(self, cams: DesignBoxes, *, with_grid_search: bool) -> None:
        """Try cams that differ in their sizes alone, and store where one exceeds limits the most."""
        design = cams.middle_designs(self.problem.design)
        problem, motion = self.problem_and_motion_of_design(design)
        self.add_worst_excess_places(design, problem)
        if problem.setup.mechanism.has_no_assembly:
            return
        design = design.without_numbers(self.motion_fields)
        if with_grid_search:
            low, high = self.bounds["size"]
            bounds = {**self.bounds, "size": (low, max(low, min(high, self.best.size)))}
            self.update_best(solve_small_cam_unproved(problem, bounds, self.best.design, self.budget), motion)
        rounding = allowed_proof_gap(design) / 4.0
        low, high = (float(ends["size"][0]) for ends in (cams.low, cams.high))
        high = min(high + rounding, self.best.size)
        for _ in range(LADDER_ROUNDS):
            sizes = np.linspace(low, high, LADDER_SIZES)
            ladder = replace(design.take(np.zeros(LADDER_SIZES, dtype=int)), size=sizes)
            cam = first_feasible_design(problem, ladder, empty_known_crossings(problem), self.budget)
            if cam is None:
                # intervals try the first design that doubles do not refute
                self.budget.spend(problem.evaluation_work(LADDER_SIZES))
                ladder = ladder.take(ladder.size < self.best.size - allowed_proof_gap(ladder))
                nominal_limits = problem.without_deferred_limits
                ladder = ladder.take(feasible_designs(nominal_limits, ladder, include_undecided=True))
                if len(ladder) and is_provably_feasible(problem, first := ladder.take([0]), self.budget):
                    self.update_best(SmallestCam(first, 0.0), motion)
                return
            self.update_best(SmallestCam(cam, 0.0), motion)
            low, high = float(cam.size[0]) - (sizes[1] - sizes[0]), float(cam.size[0])

    def update_best(self, answer: SmallestCam, motion: Any) -> None:
        """Keep a cam and its motion if it is smaller than the best."""
        if answer.size < self.best.size:
            self.best, self.best_motion = answer, motion
