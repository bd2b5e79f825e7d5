"""Claims: the requirement of a limit on a curve at every cam angle, for any kind of number.

Doubles (verdicts), intervals (proofs and boxes of designs), samples (convex steps) and drawings evaluate the same
claims, each in its own numbers. A solver asks a claim which curve it is about, never a limit for its name.
"""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import DOUBLES, BodyRadiusPlus, NumberKind, Peak, Scale, unweighted
from camopt.model.effects.train_peak import TrainPeak
from camopt.model.mechanisms import Designs
from camopt.model.motion.stroke import ALL_STROKES


class At(NamedTuple):
    """The extreme at which its quantity has a given value."""

    scale: Scale
    quantity: float

    def value(self, numbers: NumberKind) -> Any:
        return self.scale.extreme_at(self.quantity, numbers)


class Plain(NamedTuple):
    """A bound that is the same double for all designs and kinds of number."""

    number: float

    def value(self, numbers: NumberKind) -> Any:
        return numbers.of(self.number)


Bound = At | Plain


CLAIM_SIDES = {LARGEST: (1.0,), LEAST: (-1.0,), LARGEST_MAGNITUDE: (1.0, -1.0)}


class Claim(NamedTuple):
    """side · factor(design) · curve ≤ allowed at every cam angle of some strokes, for each side of the goal.

    That is: the largest value (LARGEST) or the largest magnitude (LARGEST_MAGNITUDE) of factor · curve is at most
    the bound, or its least value (LEAST) at least the bound. Units are the curve's. No factor is below 0, since
    searches look where the curve itself is largest or least.

    Example: a roller of radius R_r undercuts no profile with κ·R_r < 1 at every cam angle, where κ is the curvature
    of the pitch curve: the curve is κ, the goal LARGEST, the factor R_r, the bound 1.
    """

    curve: Callable[[Designs, Any], Any]
    """A curve of the mechanism or of a load, for a design and a motion; or of a train, for what that does."""
    kinds: int
    """Kinds of stroke, or ways in which the follower moves (``motion.table``)."""
    goal: int
    bound: Bound
    factor: Callable[[Designs], Any] = unweighted
    unit: Callable[[Designs], Any] = unweighted
    """The scale of a relative excess where the bound is 0."""

    @property
    def sides(self) -> tuple[float, ...]:
        return CLAIM_SIDES[self.goal]

    def allowed(self, numbers: NumberKind = DOUBLES) -> Any:
        """The upper bound of each side."""
        value = self.bound.value(numbers)
        return -value if self.goal == LEAST else value

    @property
    def comparable(self) -> tuple[Any, ...]:
        """Equal for claims of which the stricter one implies the others: on one curve, with one kind of factor."""
        of_body = isinstance(self.factor, BodyRadiusPlus)
        weighted = (BodyRadiusPlus, self.allowed()) if of_body else (self.factor, None)
        return self.curve, self.kinds, self.goal, *weighted

    @property
    def strictness(self) -> float:
        """Larger for the stricter of two comparable claims."""
        return self.factor.radius if isinstance(self.factor, BodyRadiusPlus) else -float(self.allowed())


def claims_of(peak: Peak, bound: float) -> tuple[Claim, ...]:
    """The claims of a bound on the curves that decide its quantity."""
    at, weight = At(peak.scale, bound), peak.scale.weight(bound)
    return tuple(Claim(make, kinds, peak.goal, at, weight, peak.unit or unweighted) for make, kinds in peak.curves)


def together(claims: Iterable[Claim]) -> list[Claim]:
    """Claims with equal bounds on one curve, over several kinds of stroke, as one over all of these."""
    found: dict[Any, Claim] = {}
    for claim in claims:
        same = (*claim._replace(kinds=0, bound=Plain(0.0)), claim.allowed())
        found[same] = claim._replace(kinds=claim.kinds | found[same].kinds) if same in found else claim
    return list(found.values())


def train_claims_of(peak: TrainPeak, bound: float) -> tuple[Claim, ...]:
    """The claims of a bound on the curves of a train that decide its quantity."""
    return tuple(Claim(curve, ALL_STROKES, peak.goal, At(peak.scale, bound)) for curve in peak.curves)


class MeanClaim(NamedTuple):
    """The requirement of a limit on the mean of a curve to a power over the turn: at most, or at least, a bound."""

    mean: Mean
    quantity: float
    """The bound on the quantity."""
    side: float
    """−1 where the mean must be at least so much, else 1."""

    @property
    def kinds(self) -> int:
        """The kinds of stroke that it is about: all."""
        return ALL_STROKES

    @property
    def sides(self) -> tuple[float, ...]:
        return (self.side,)

    def allowed(self, numbers: NumberKind = DOUBLES) -> Any:
        """The mean of the curve to the power that is just allowed, times the factor."""
        return self.mean.mean_of_powers_at(self.quantity, numbers)

    def factor(self, designs: Designs) -> Any:
        """The factor of that mean, which may depend on the design; not below 0."""
        factor = self.mean.scale.weight(self.quantity)(designs)
        return factor * factor if self.mean.power == 2 else factor


AnyClaim = Claim | MeanClaim


def mean_claim_of(mean: Mean, bound: float, side: float) -> MeanClaim:
    """The claim of a bound, from one side, on the mean that decides its quantity."""
    return MeanClaim(mean, bound, -side if mean.scale.falls else side)
