"""The forces in the joints of a train, by the statics of its bodies.

What a joint and all beyond it carry asks the link before it for a force Q (a moment) against its motion, by virtual
work (``trains.carried_load``); Q times a share, which the position gives, is the force in each joint of that link:

    coupler b of a crank    Q·b/√(b² − S²), and S/√(b² − S²)·Q across the slide    (``trains.crank``)
    coupler of a four-bar   Q/(c·sin(δ − ψ)), δ the coupler's angle               (``trains.four_bar``)
    roller or pad of an arm, end of a lever, pinion and rack                       Q along the motion
    face of an incline      Q/sin(γ + α)

A link that is driven from its output has there what drives it in place of Q. Couplers, rollers and levers have no
mass; what turns has its centre of mass on its pivot, what slides has it on the line of its pin, so that inertia is
along each motion alone. Friction is that along the motion; teeth have no part that pushes wheels apart.

A pivot takes the forces of both links that meet on its shaft. How these are turned to each other a scene does not
say: the force on a pivot is the sum of both, as where they act one way, which is the largest that it can be. The
pivot of an oscillating follower, which the cam presses on too, and those of wheels, whose radii a ratio does not
have, are left out.

Source: Norton, Design of Machinery, ch. 11 (dynamic force analysis).
"""

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from typing import Literal, NamedTuple

from camopt.model.trains.link import Link


class WeightedForce(NamedTuple):
    """A force of a link, with a sign."""

    link: int
    force: int
    sign: float = 1.0


class JointForce(NamedTuple):
    """A force in a joint of a train: of one link, or on a pivot the sum of the magnitudes of two."""

    stage: int
    name: str
    kind: Literal["joint", "pivot", "guide"]
    parts: tuple[WeightedForce, ...]

    @property
    def sums(self) -> tuple[tuple[WeightedForce, ...], ...]:
        """What has its largest magnitude: of the magnitudes of two, their sum and their difference."""
        first, *others = self.parts
        return tuple((first, *(each._replace(sign=s) for each in others)) for s in (1.0, -1.0)[: 1 + len(others)])


def list_joint_forces(links: Sequence[Link], stages: Sequence[int]) -> Iterator[JointForce]:
    """The forces of links, and on the pivots between them, stage by stage."""
    every = sorted([*_link_forces(links, stages), *_pivot_forces(links, stages)], key=lambda each: each.stage)
    for _, group in groupby(every, key=lambda each: each.stage):
        of_stage = list(group)
        for number, each in enumerate(of_stage):
            alike = [k for k, other in enumerate(of_stage) if other.name == each.name]
            yield each._replace(name=f"{each.name} {alike.index(number) + 1}") if len(alike) > 1 else each


def _link_forces(links: Sequence[Link], stages: Sequence[int]) -> Iterator[JointForce]:
    for number, link in enumerate(links):
        for k, force in enumerate(link.forces):
            yield JointForce(stages[number], force.name, force.kind, (WeightedForce(number, k),))


def _pivot_forces(links: Sequence[Link], stages: Sequence[int]) -> Iterator[JointForce]:
    """What turns between two links takes what both pass on; the last, what moves it."""
    for number, (one, other) in enumerate(pairwise([*links, None])):
        assert one is not None
        if one.turns[1] and all(each.forces for each in (one, other) if each is not None):
            parts = [WeightedForce(number + k, 0) for k, each in enumerate((one, other)) if each is not None]
            yield JointForce(stages[number], "pivot", "pivot", tuple(parts))
