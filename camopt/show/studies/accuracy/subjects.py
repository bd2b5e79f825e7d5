"""Subjects of the comparison: peaks that a designer uses, the smallest radius, and the designs."""

from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.optimize import elementwise

from camopt.core.numerics import BoolArray, FloatArray, IndexArray, Number
from camopt.core.numerics.extremes import Extremes, Precision, extremes_of_curve
from camopt.model.effects.peak import NumberKind, Peak
from camopt.model.mechanisms import Designs
from camopt.scene.problem.limits import peak_at_first_contact
from camopt.scene.problem.problem import SINGLE_DESIGN_ERROR, Problem
from camopt.scene.problem.sample import sweep_space
from camopt.show.studies.accuracy.methods import Method, enclosure_method
from camopt.show.studies.accuracy.reference import (
    EQUAL_DIGITS,
    Digits,
    as_fifty_digit_number,
    fifty_digit_context,
    fifty_digit_extreme_near,
)

DESIGN_COUNT = 4096
REFERENCE_COUNT = 24  # designs with a reference of 50 digits
SIZE_ROOM = 0.1  # relative range around the size of a design, in which its smallest radius is searched
FIRST_STEP = 2.0**-40  # first relative step of the secant method
QUANTITY_OF = {
    "pressure angle": "pressure_angle_max_deg",
    "curvature": "pitch_curvature_max_per_mm",
    "radius of curvature": "profile_radius_min_mm",
}
find_root: Any = elementwise.find_root  # its type stubs lack arguments


@dataclass(frozen=True)
class PeakSubject:
    """A peak of designs."""

    name: str
    problem: Problem
    peak: Peak
    designs: Designs
    cost_factor = 1

    @property
    def sign(self) -> float:
        """+1 for a quantity that a limit bounds from above, −1 from below."""
        return -1.0 if self.peak.is_least else 1.0

    def _extremes(self, designs: Designs) -> Extremes:
        """Extremes of designs in doubles."""
        curve, questions = self._curve_and_extreme_kind(designs)
        return extremes_of_curve(
            curve, len(designs), self.problem.programme.table, questions, Precision(SINGLE_DESIGN_ERROR, 1e-9)
        )

    def _curve_and_extreme_kind(self, designs: Designs) -> tuple[Any, Any]:
        """The curve of designs, and the kind of extreme."""
        ((make, kinds),) = self.peak.curves
        return make(designs, self.problem.programme), np.array([(kinds, self.peak.goal)])

    @cached_property
    def truth(self) -> FloatArray:
        """The quantity of each design, to the precision of doubles."""
        return np.asarray(
            self.peak.scale.quantity_from_extreme(self._extremes(self.designs).value[0], self.designs)
        )

    def result_by_method(
        self, method: Method, enclosure_side: float = 0.0, designs: Designs | None = None
    ) -> FloatArray:
        """The result of a method for each design.

        ``enclosure_side`` ±1 gives the far or near end of its enclosure.
        """
        designs = self.designs if designs is None else designs
        curve, questions = self._curve_and_extreme_kind(designs)
        value, width = method.find_extremes(curve, len(designs), self.problem.programme, questions)
        return np.asarray(
            self.peak.scale.quantity_from_extreme(value[0] + enclosure_side * self.sign * width[0], designs)
        )

    def extreme_with_50_digits(self, design: Designs, size: Number = None) -> Number:
        """The extreme of a design with 50 digits; ``size`` replaces its size."""
        exact = design.with_values(
            {name: Digits(as_fifty_digit_number(value)) for name, value in design.sizes.items()}
        )
        if size is not None:
            design = replace(design, size=np.array([float(size)]))
            exact = exact.with_values({"size": Digits(size)})
        ((make, kinds),), (where,) = self.peak.curves, self._extremes(design).where[0]
        return fifty_digit_extreme_near(make, kinds, self.peak.goal, exact, self.problem.programme, float(where))

    def reference_with_50_digits(self, design_number: int) -> float:
        """The quantity of one design, computed with 50 digits."""
        design = self.designs.take([design_number])
        return float(
            self.peak.scale.quantity_from_extreme(np.array([float(self.extreme_with_50_digits(design))]), design)[0]
        )


@dataclass(frozen=True)
class RadiusSubject:
    """The smallest radius: the smallest size with which a peak meets its limit, with the other sizes fixed.

    The limit is the peak of the design itself, so that its own size is the answer, up to rounding. A bracketing
    root finder (Chandrupatla) calls the method at one size after another.
    """

    peak_subject: PeakSubject
    numbers: IndexArray
    """Numbers of the designs of the peak."""
    name = "smallest radius"
    sign = 1.0
    cost_factor = 4

    @cached_property
    def designs(self) -> Designs:
        return self.peak_subject.designs.take(self.numbers)

    @property
    def truth(self) -> FloatArray:
        return self.designs.size

    def result_by_method(self, method: Method, enclosure_side: float = 0.0) -> FloatArray:
        """The smallest radius of each design by a method: by default the far end of its bracket."""
        return np.asarray(
            self.find_size_at_limit(method, enclosure_side or 1.0).bracket[int(enclosure_side >= 0.0)]
        )

    def find_size_at_limit(self, method: Method, enclosure_side: float = 0.0) -> Any:
        """The size at which the peak reaches its limit, by a method.

        Enclosures and bracket have a quarter of the required error, since their errors add up in the size. Samples
        have no error bound; there the bracket has 1e-9.
        """
        relative_error = 0.25 * method.setting if method.setting < 1.0 else 1e-9
        used = enclosure_method(relative_error) if method.setting < 1.0 else method
        limit = self.peak_subject.truth[self.numbers]

        def excess(size: FloatArray, index: FloatArray) -> FloatArray:
            places = index.astype(int)
            sized = replace(self.designs.take(places), size=size)
            return np.asarray(
                self.peak_subject.sign
                * (self.peak_subject.result_by_method(used, enclosure_side, sized) - limit[places])
            )

        ends = tuple(each.size for each in self.designs_at_range_ends)
        return find_root(excess, ends, args=(np.arange(len(self.designs)),), tolerances={"xrtol": relative_error})

    @property
    def designs_at_range_ends(self) -> list[Designs]:
        """Designs at both ends of the search range."""
        return [
            replace(self.designs, size=self.designs.size * share) for share in (1.0 - SIZE_ROOM, 1.0 + SIZE_ROOM)
        ]

    def smallest_radius_mask(self) -> BoolArray:
        """Mask of designs with a smallest radius in the search range, whose ends can be assembled."""
        exists = partial(
            self.peak_subject.problem.setup.mechanism.can_assemble, programme=self.peak_subject.problem.programme
        )
        found = self.find_size_at_limit(enclosure_method(SINGLE_DESIGN_ERROR)).success
        return np.asarray(np.logical_and.reduce([found, *map(exists, self.designs_at_range_ends)]))

    def reference_with_50_digits(self, design_number: int) -> float:
        """The smallest radius by the secant method with 50 digits, to half of them.

        Raises
        ------
        ArithmeticError
            If the secant method does not converge.
        """
        place, design = self.numbers[design_number], self.designs.take([design_number])
        context = fifty_digit_context()
        kind = NumberKind(context.mpf, lambda: +context.pi, context.tan)
        bound = self.peak_subject.peak.scale.weighted_extreme_for_quantity(
            float(self.peak_subject.truth[place]), kind
        )

        def limit_excess(size: Number) -> Number:
            return self.peak_subject.extreme_with_50_digits(design, size) - bound

        one = context.mpf(float(design.size[0]))
        other = one * (1 + context.mpf(FIRST_STEP))
        before, there = limit_excess(one), limit_excess(other)
        for _ in range(5):
            step = there * (other - one) / (there - before)
            one, before, other = other, there, other - step
            if abs(step) < EQUAL_DIGITS * other:
                return float(other)
            there = limit_excess(other)
        raise ArithmeticError(f"the smallest radius of {design} was not found in 50 digits")


Subject = PeakSubject | RadiusSubject


def subjects_of(problem: Problem) -> list[Subject]:
    """Pressure angle, curvature of pitch curve or profile, and the smallest radius of the first one that has it."""
    designs, mechanism = random_designs(problem), problem.setup.mechanism
    found: list[Subject] = []
    radius: RadiusSubject | None = None
    for name in ("pressure angle", "curvature" if mechanism.curvature else "radius of curvature"):
        peak = peak_at_first_contact(QUANTITY_OF[name], problem.setup)
        assert peak is not None
        of = PeakSubject(
            name, problem, peak.as_magnitude() if mechanism.has_flanks_on_both_sides else peak, designs
        )
        if np.all(np.abs(of.truth) > 0.0):  # a flat face that translates has no pressure angle
            found.append(of)
            inside = (
                None
                if radius
                else np.flatnonzero(RadiusSubject(of, np.arange(len(designs))).smallest_radius_mask())
            )
            if inside is not None and inside.size:
                radius = RadiusSubject(of, inside[: DESIGN_COUNT // 4])
                found.append(radius)
    return found


def random_designs(problem: Problem) -> Designs:
    """Random designs of the search space of a scene; without one, its design with sizes varied a little."""
    rng, space = np.random.default_rng(0), sweep_space(problem)
    count = 4 * DESIGN_COUNT  # some cannot be assembled
    if space.designs_per_problem >= REFERENCE_COUNT:
        designs = space.designs(rng.integers(0, space.designs_per_problem, count))
    else:
        share = {name: rng.uniform(0.9, 1.3, count) for name in ("size", "roller_radius", "offset")}
        sizes = {name: value * share.get(name, np.ones(count)) for name, value in problem.design.sizes.items()}
        designs = problem.design.with_values(sizes)
    return designs.take(problem.setup.mechanism.can_assemble(designs, problem.programme)).take(slice(DESIGN_COUNT))
