"""The forces in the joints of a train, by the statics of its bodies.

A link moves its output joint against a force or moment Q: the load of that joint and of all joints towards the
tool, by virtual work (``trains.carried_load``). The force in each joint of the link is Q times a share that depends
on the position:

    coupler b of a crank    Q·b/√(b² − S²), and S/√(b² − S²)·Q across the slide    (``trains.crank``)
    coupler of a four-bar   Q/(c·sin(δ − ψ)), δ the coupler's angle               (``trains.four_bar``)
    roller or pad of an arm, end of a lever, pinion and rack                       Q along the motion
    face of an incline      Q/sin(γ + α)

In a link that is driven at its output, the driving force there takes the place of Q.

Assumptions: couplers, rollers and levers have no mass. A turning part has its centre of mass on its pivot, a
sliding part on the line of its pin, so inertia acts along each motion only. Friction acts along the motion. Teeth
have no force that pushes wheels apart.

A pivot takes the forces of both links on its shaft. A scene does not give the angle between these links, so the
force on the pivot is the sum of both magnitudes: the largest that it can be. Two kinds of pivot are not computed:
that of an oscillating follower, which the cam loads too, and those of wheels, whose radii a ratio does not give.

Source: Norton, Design of Machinery, ch. 11 (dynamic force analysis).
"""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Literal, NamedTuple

from camopt.model.trains.link import Link


class WeightedForce(NamedTuple):
    """A force of a link, by the numbers of both, with a sign."""

    link: int
    force: int
    sign: float = 1.0


class JointForce(NamedTuple):
    """A force in a joint of a train: that of one link, or on a pivot the sum of the magnitudes of two."""

    stage: int
    name: str
    kind: Literal["joint", "pivot", "guide"]
    parts: tuple[WeightedForce, ...]

    @property
    def signed_sums(self) -> tuple[tuple[WeightedForce, ...], ...]:
        """Sums of the signed parts; the largest magnitude among them is that of this force.

        |a| + |b| is the larger of |a + b| and |a − b|.
        """
        first, *others = self.parts
        return tuple((first, *(each._replace(sign=s) for each in others)) for s in (1.0, -1.0)[: 1 + len(others)])


def list_joint_forces(links: Sequence[Link], stage_numbers: Sequence[int]) -> Iterator[JointForce]:
    """The forces of links and on the pivots between them, stage by stage; equal names of a stage get numbers."""
    in_links = [
        JointForce(stage_numbers[number], force.name, force.kind, (WeightedForce(number, k),))
        for number, link in enumerate(links)
        for k, force in enumerate(link.joint_forces)
    ]
    forces = sorted([*in_links, *_pivot_forces(links, stage_numbers)], key=lambda force: force.stage)
    for _, group in groupby(forces, key=lambda force: force.stage):
        stage_forces = list(group)
        for number, force in enumerate(stage_forces):
            alike = [k for k, other in enumerate(stage_forces) if other.name == force.name]
            yield force._replace(name=f"{force.name} {alike.index(number) + 1}") if len(alike) > 1 else force


def _pivot_forces(links: Sequence[Link], stage_numbers: Sequence[int]) -> Iterator[JointForce]:
    """The forces on pivots: each takes the forces of the links before and behind it, the last that before it."""
    for number, link in enumerate(links):
        loading = links[number : number + 2]
        if link.driver_and_driven_angular[1] and all(each.joint_forces for each in loading):
            parts = tuple(WeightedForce(number + k, 0) for k in range(len(loading)))
            yield JointForce(stage_numbers[number], "pivot", "pivot", parts)
