"""Limits on means of the motion: the area below the lift, linear in it, and root mean squares, which are cones.

    1/2π·∮y dθ ≥ m,    √(1/2π·∮(y⁽ᵏ⁾)² dθ) ≤ r

A mean that has to be large is convex where it is linear, one that has to be small in any case.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from camopt.effects.peak import Derivative
from camopt.problem.problem import Problem


@dataclass(frozen=True)
class MeanConstraint:
    """A bound, in mm or rad, on the mean of a derivative over the turn, or on its root mean square."""

    name: str
    order: int
    power: int
    bound: float
    side: float
    """−1 where it must be at least so much, else 1."""

    def closer(self, share: float) -> "MeanConstraint":
        """The limit held closer by a share of its bound, or wider."""
        return replace(self, bound=self.bound * (1.0 - self.side * share))


def means_of(problem: Problem) -> Iterator[MeanConstraint]:
    """The limits of a scene on means of the motion that are convex in it. What is not, the cam holds in the end."""
    for limit in problem.limits:
        claim = limit.mean
        if claim is None or not isinstance(curve := claim.mean.curves[0][0], Derivative):
            continue
        power, side = claim.mean.power, claim.side
        if power == 1 or side > 0.0:
            bound = claim.mean.of_powers(claim.allowed())
            yield MeanConstraint(limit.name, curve.order, power, float(bound), side)
