"""A train: stages in a chain, from the follower to the tool."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from math import inf, prod
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series, Taylor, series_quotient
from camopt.model.trains import TRAIN_STAGES
from camopt.model.trains.carried_load import CarriedLoad, FollowerLoad, TrainJoint, sum_follower_load
from camopt.model.trains.constant_ratio import ConstantRatio
from camopt.model.trains.joint_forces import JointForce, WeightedForce, list_joint_forces
from camopt.model.trains.link import (
    AssemblyFault,
    Keys,
    Link,
    position_at,
    reversed_link,
    unit_series,
    value_at_end,
)
from camopt.model.trains.sketch import LinkSketch, Port

NO_MOTION = 1e-9  # rad (mm): a start position no further from a dead point is at it


class StageFault(AssemblyFault):
    """The fault of a stage, by its number from 1."""

    def __init__(self, number: int, why: str) -> None:
        super().__init__(why)
        self.number = number


class TravelEnd(NamedTuple):
    """Where the tool's motion ends, mm (rad), why, and the number of the stage."""

    at: float
    why: str = ""
    stage: int = 0


@dataclass(frozen=True)
class Train:
    """What is between follower and tool; displacements of both are from the start position, mm or rad."""

    links: tuple[Link, ...]
    """From the follower to the tool."""
    stages: tuple[int, ...]
    """The number of the stage of each link, from 1."""
    carried: tuple[CarriedLoad, ...] = ()

    @property
    def has_mass(self) -> bool:
        """Whether it carries any mass."""
        return any(each.mass for each in self.carried)

    @property
    def angular(self) -> bool:
        """Whether the tool's motion is an angle."""
        return self.links[-1].turns[1]

    @cached_property
    def reversed_train(self) -> "Train":
        """The train from the tool to the follower, as where the tool drives; it carries nothing."""
        return Train(tuple(map(reversed_link, self.links[::-1])), self.stages[::-1])

    @property
    def constant_ratio(self) -> float | None:
        """Its velocity ratio, if that is the same everywhere."""
        factors = [link.factor for link in self.links if isinstance(link, ConstantRatio)]
        return float(prod(factors)) if len(factors) == len(self.links) else None

    def tool(self, follower: Series) -> Series:
        """The displacement of the tool."""
        for link in self.links:
            follower = link.forward(follower)
        return follower

    def follower(self, tool: Series) -> Series:
        """The displacement of the follower."""
        for link in reversed(self.links):
            tool = link.backward(tool)
        return tool

    def follower_at(self, tool: FloatArray) -> FloatArray:
        """The displacement of the follower, of numbers alone."""
        return np.asarray(self.follower(Taylor([tool])).terms[0])

    def joints(self, follower: Series) -> list[TrainJoint]:
        """The joints, from the follower to the tool."""
        found = [TrainJoint(follower, unit_series(follower))]
        for link in self.links:
            moved, ratio = found[-1]
            found.append(TrainJoint(link.forward(moved), ratio * link.ratio(moved)))
        return found

    @property
    def has_couplers(self) -> bool:
        """Whether any of its links has a coupler."""
        return any(link.couplers[0] for link in self.links)

    def least_transmission(self, low: Any, high: Any) -> Any:
        """The least transmission angle of its couplers over a travel of the tool, rad."""
        found = []
        for link in reversed(self.links):
            one, other = (position_at(link.backward, each) for each in (low, high))
            low, high = np.minimum(one, other), np.maximum(one, other)
            if (coupler := link.couplers[0]) is not None:
                found.append(coupler.least_angle(low, high))
        return reduce(np.minimum, found)

    def sketch(self, follower: FloatArray, port: Port, size: float) -> LinkSketch:
        """Its links in some positions of the follower, from where that drives the first (``trains.sketch``)."""
        moved, first, found = follower, port, list[LinkSketch]()
        for link in self.links:
            asked = np.asarray(link.forward(Taylor([moved])).terms[0])
            found.append(link.sketch(moved, asked, size).attach_to(port))
            moved, port = asked, found[-1].output_port
        members = [member for each in found for member in each.members]
        return LinkSketch(members, [still for each in found for still in each.supports], first, port)

    @cached_property
    def senses(self) -> tuple[Any, ...]:
        """For each joint 1 if it moves out with the follower, −1 if against it."""
        return tuple(np.sign(joint.ratio.terms[0]) for joint in self.joints(Taylor([0.0, 1.0])))

    def load_at_follower(self, follower: Series, ways: Sequence[Any], loads: Mapping[int, Series]) -> FollowerLoad:
        """What it brings to the follower (``trains.carried_load``)."""
        return sum_follower_load(self.joints(follower), self.carried, ways, loads)

    @cached_property
    def forces(self) -> tuple[JointForce, ...]:
        """The forces in its joints, from the follower to the tool (``trains.joints``)."""
        return tuple(list_joint_forces(self.links, self.stages))

    def force_in(
        self, parts: Sequence[WeightedForce], follower: Series, ways: Sequence[Any], loads: Mapping[int, Series]
    ) -> FollowerLoad:
        """A sum of forces of its links, in the form of what it brings to the follower."""
        joints = self.joints(follower)
        still, inertia = (each * 0.0 for each in sum_follower_load(joints, (), ways, {}))
        for part in parts:
            share = self.links[part.link].forces[part.force].share(joints[part.link].moved) * part.sign
            # what a joint, and all beyond it, takes from the link that moves it
            joint = part.link + 1
            carried = tuple(each for each in self.carried if each.joint >= joint)
            beyond = sum_follower_load(joints, carried, ways, {k: load for k, load in loads.items() if k >= joint})
            asked = FollowerLoad(*(series_quotient(each, joints[joint].ratio) for each in beyond))
            still, inertia = still + asked.still * share, inertia + asked.carried * share
        return FollowerLoad(still, inertia)

    @cached_property
    def tool_reach(self) -> tuple[TravelEnd, TravelEnd]:
        """The ends of the tool's motion: at the first dead point below the start position, and above."""
        low, high = TravelEnd(-inf), TravelEnd(inf)
        for number, link in zip(self.stages, self.links, strict=True):
            below, above = (TravelEnd(*each, number) for each in link.ends)
            low, high = max(low, below), min(high, above)
            low, high = sorted(each._replace(at=value_at_end(link.forward, each.at)) for each in (low, high))
        return low, high


def assemble_train(stages: Sequence[tuple[str, Keys]], *, angular: bool) -> Train:
    """A train from the names and keys of its stages, from the follower to the tool, mm and deg.

    ``angular`` says whether the follower's motion is an angle.

    Raises
    ------
    StageFault
        If a stage lacks a key, has one too many, cannot be put together, or starts at a dead point.
    """
    train = assemble_trains(stages, angular=angular)
    for number, link in zip(train.stages, train.links, strict=True):
        for end in link.ends:
            if abs(end.at) <= NO_MOTION:
                raise StageFault(number, f"it starts at a dead point: {end.why}")
    return train


def assemble_trains(stages: Sequence[tuple[str, Keys]], *, angular: bool) -> Train:
    """Trains whose numbers are arrays or ranges; those that cannot be put together are among them."""
    links, numbers = list[Link](), list[int]()
    for number, (name, keys) in enumerate(stages, start=1):
        try:
            found = TRAIN_STAGES[name].make_links(keys, angular)
        except AssemblyFault as unfit:
            raise StageFault(number, str(unfit)) from None
        links += found
        numbers += [number] * len(found)
        angular = TRAIN_STAGES[name].turns(keys, angular)
    return Train(tuple(links), tuple(numbers))
