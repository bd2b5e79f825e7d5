"""What is computed: the peaks that a designer acts on, the smallest radius, and the designs to compute them of."""

from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.optimize import elementwise

from camopt.core.numerics import FloatArray
from camopt.core.numerics.extremes import Extremes, Precision, extremes
from camopt.model.effects.peak import Peak
from camopt.model.mechanisms import Designs
from camopt.scene.problem.limits import first_peak
from camopt.scene.problem.problem import SINGLE_DESIGN_ERROR, Problem
from camopt.scene.problem.sample import sweep_space
from camopt.show.studies.accuracy.digits import Digits, arithmetic, as_number, digit_numbers
from camopt.show.studies.accuracy.methods import Method, enclosure_method
from camopt.show.studies.accuracy.reference import EQUAL_DIGITS, extreme_near

DESIGN_COUNT = 4096
REFERENCE_COUNT = 24  # designs with a reference in 50 digits
SIZE_ROOM = 0.1  # relative, to both sides of a design's own size: where its smallest radius is looked for
FIRST_STEP = 2.0**-27  # relative, of the secant in 50 digits
QUANTITY_OF = {
    "pressure angle": "pressure_angle_max_deg",
    "curvature": "pitch_curvature_max_per_mm",
    "radius of curvature": "profile_radius_min_mm",
}
find_root: Any = elementwise.find_root  # its stubs know no arguments beside the root


@dataclass(frozen=True)
class PeakSubject:
    """A peak of some designs."""

    name: str
    problem: Problem
    peak: Peak
    designs: Designs
    cost_factor = 1

    @property
    def sign(self) -> float:
        """+1 for a quantity that a limit bounds from above, −1 from below."""
        return -1.0 if self.peak.is_least else 1.0

    @cached_property
    def _exact(self) -> FloatArray:
        """Each extreme, as exact as doubles have it."""
        return np.asarray(self._extremes(self.designs).value[0])

    def _extremes(self, designs: Designs) -> Extremes:
        """The extremes of designs in doubles."""
        curve, questions = self._curve_question(designs)
        return extremes(
            curve, len(designs), self.problem.programme.table, questions, Precision(SINGLE_DESIGN_ERROR, 1e-9)
        )

    def _curve_question(self, designs: Designs) -> tuple[Any, Any]:
        """The curve of designs, and the question about it."""
        ((make, kinds),) = self.peak.curves
        return make(designs, self.problem.programme), np.array([(kinds, self.peak.goal)])

    @property
    def truth(self) -> FloatArray:
        """The quantity of each design, as exact as doubles have it."""
        return np.asarray(self.peak.scale.quantity(self._exact, self.designs))

    def answer(self, method: Method, side: float = 0.0, designs: Designs | None = None) -> FloatArray:
        """What a method gives for each design; with ``side`` ±1 the far or the near end of what it proves."""
        designs = self.designs if designs is None else designs
        curve, questions = self._curve_question(designs)
        value, width = method.run(curve, len(designs), self.problem.programme, questions)
        return np.asarray(self.peak.scale.quantity(value[0] + side * self.sign * width[0], designs))

    def in_digits(self, design: Designs, size: Any = None) -> Any:
        """The extreme of a design, or of one of another size, in 50 digits."""
        exact = design.with_values({name: Digits(as_number(value)) for name, value in design.sizes.items()})
        if size is not None:
            design = replace(design, size=np.array([float(size)]))
            exact = exact.with_values({"size": Digits(size)})
        ((make, kinds),), (where,) = self.peak.curves, self._extremes(design).where[0]
        return extreme_near(make, kinds, self.peak.goal, exact, self.problem.programme, float(where))

    def reference(self, number: int) -> float:
        """The quantity of one design by 50 digits."""
        design = self.designs.take([number])
        return float(self.peak.scale.quantity(np.array([float(self.in_digits(design))]), design)[0])


@dataclass(frozen=True)
class RadiusSubject:
    """The smallest radius: the least size at which a peak holds its limit, the other sizes given.

    Each design asks with the peak that it has itself, so that its own size is the answer but for rounding. A
    bracketing root-finder (Chandrupatla's) asks the method at one size after another.
    """

    peak_subject: PeakSubject
    numbers: Any
    """Which of the designs of the peak."""
    name = "smallest radius"
    sign = 1.0
    cost_factor = 4

    @cached_property
    def designs(self) -> Designs:
        return self.peak_subject.designs.take(self.numbers)

    @property
    def truth(self) -> FloatArray:
        return self.designs.size

    def answer(self, method: Method, side: float = 0.0) -> FloatArray:
        """As of a peak; what a method finds is the far end."""
        return np.asarray(self.root(method, side or 1.0).bracket[int(side >= 0.0)])

    def root(self, method: Method, side: float = 0.0) -> Any:
        """Where the peak is at its limit by a method.

        Enclosures go to a quarter of the error asked, and so does the bracket, since errors of both add up in the
        size; samples know no error, and the bracket goes to 1e-9.
        """
        relative_error = 0.25 * method.setting if method.setting < 1.0 else 1e-9
        used = enclosure_method(relative_error) if method.setting < 1.0 else method
        limit = self.peak_subject.truth[self.numbers]

        def excess(size: FloatArray, index: FloatArray) -> FloatArray:
            places = index.astype(int)
            sized = replace(self.designs.take(places), size=size)
            return np.asarray(
                self.peak_subject.sign * (self.peak_subject.answer(used, side, sized) - limit[places])
            )

        ends = tuple(each.size for each in self.ends)
        return find_root(excess, ends, args=(np.arange(len(self.designs)),), tolerances={"xrtol": relative_error})

    @property
    def ends(self) -> list[Designs]:
        """The designs between which each is looked for."""
        return [
            replace(self.designs, size=self.designs.size * share) for share in (1.0 - SIZE_ROOM, 1.0 + SIZE_ROOM)
        ]

    def has_smallest_radius(self) -> Any:
        """Which designs have a smallest radius between their ends, both of which can be put together."""
        exists = partial(
            self.peak_subject.problem.setup.mechanism.can_assemble, programme=self.peak_subject.problem.programme
        )
        return self.root(enclosure_method(SINGLE_DESIGN_ERROR)).success & np.logical_and(*map(exists, self.ends))

    def reference(self, number: int) -> float:
        """By a secant in 50 digits, to half of them.

        Raises
        ------
        ArithmeticError
            If the secant does not settle.
        """
        place, design = self.numbers[number], self.designs.take([number])
        bound = self.peak_subject.peak.scale.extreme_at(float(self.peak_subject.truth[place]), digit_numbers())

        def limit_excess(size: Any) -> Any:
            return self.peak_subject.in_digits(design, size) - bound

        one = arithmetic().mpf(float(design.size[0]))
        other = one * (1 + arithmetic().mpf(FIRST_STEP))
        before, there = limit_excess(one), limit_excess(other)
        for _ in range(5):
            step = there * (other - one) / (there - before)
            one, before, other = other, there, other - step
            if abs(step) < EQUAL_DIGITS * other:
                return float(other)
            there = limit_excess(other)
        raise ArithmeticError(f"no smallest radius of {design} in 50 digits")


Subject = PeakSubject | RadiusSubject


def subjects_of(problem: Problem) -> list[Subject]:
    """Pressure angle, curvature of pitch curve or profile, and the smallest radius of the first that has one."""
    designs, mechanism = designs_of(problem), problem.setup.mechanism
    found: list[Subject] = []
    radius: RadiusSubject | None = None
    for name in ("pressure angle", "curvature" if mechanism.curvature else "radius of curvature"):
        peak = first_peak(QUANTITY_OF[name], problem.setup)
        assert peak is not None
        of = PeakSubject(name, problem, peak.as_magnitude() if mechanism.two_sided else peak, designs)
        if np.all(np.abs(of.truth) > 0.0):  # a flat face that translates has no pressure angle
            found.append(of)
            inside = (
                None if radius else np.flatnonzero(RadiusSubject(of, np.arange(len(designs))).has_smallest_radius())
            )
            if inside is not None and inside.size:
                radius = RadiusSubject(of, inside[: DESIGN_COUNT // 4])
                found.append(radius)
    return found


def designs_of(problem: Problem, seed: int = 0) -> Designs:
    """Designs of the scene's space at random; without a space, its own design with sizes varied a little."""
    rng, space = np.random.default_rng(seed), sweep_space(problem)
    count = 4 * DESIGN_COUNT  # some cannot be put together
    if space.designs_per_problem >= REFERENCE_COUNT:
        designs = space.designs(rng.integers(0, space.designs_per_problem, count))
    else:
        share = {name: rng.uniform(0.9, 1.3, count) for name in ("size", "roller_radius", "offset")}
        plain = problem.design.sizes.items()
        sizes = {name: value * share.get(name, np.ones(count)) for name, value in plain}
        designs = problem.design.with_values(sizes)
    return designs.take(problem.setup.mechanism.can_assemble(designs, problem.programme)).take(slice(DESIGN_COUNT))
