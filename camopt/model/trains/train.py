"""A train: stages in a chain, from the follower to the tool."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from math import inf, prod
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.taylor import Series, Taylor, series_quotient
from camopt.model.trains import TRAIN_STAGES
from camopt.model.trains.carried_load import CarriedLoad, FollowerLoad, TrainJoint, sum_follower_load
from camopt.model.trains.constant_ratio import ConstantRatio
from camopt.model.trains.joint_forces import JointForce, WeightedForce, list_joint_forces
from camopt.model.trains.link import (
    AssemblyFault,
    Keys,
    Link,
    ReversedLink,
    constant_one_series,
    formula_value_at,
    formula_value_at_end,
)
from camopt.model.trains.sketch import LinkSketch, Port

NO_MOTION = 1e-9  # rad (mm): a start position this near to a dead point counts as at it


class StageFault(AssemblyFault):
    """An assembly fault with the number of its stage, from 1."""

    def __init__(self, number: int, why: str) -> None:
        super().__init__(why)
        self.number = number


class TravelEnd(NamedTuple):
    """An end of the tool's travel [mm or rad], its reason, and the number of the stage that sets it."""

    at: float
    why: str = ""
    stage: int = 0


@dataclass(frozen=True)
class Train:
    """The linkage between follower and tool; displacements of both count from the start position [mm or rad]."""

    links: tuple[Link, ...]
    """From the follower to the tool."""
    stages: tuple[int, ...]
    """The stage number of each link, from 1."""
    carried: tuple[CarriedLoad, ...] = ()

    @property
    def has_mass(self) -> bool:
        return any(load.mass for load in self.carried)

    @property
    def angular(self) -> bool:
        """Whether the tool's motion is an angle."""
        return self.links[-1].driver_and_driven_angular[1]

    @cached_property
    def reversed_train(self) -> "Train":
        """The train from the tool to the follower, as if the tool drove it; without loads."""
        links = (each.link if isinstance(each, ReversedLink) else ReversedLink(each) for each in self.links[::-1])
        return Train(tuple(links), self.stages[::-1])

    @property
    def constant_ratio(self) -> float | None:
        """Its velocity ratio if that is constant, else None."""
        factors = [link.factor for link in self.links if isinstance(link, ConstantRatio)]
        return float(prod(factors)) if len(factors) == len(self.links) else None

    def tool_displacement(self, follower: Series) -> Series:
        """Displacement of the tool, from that of the follower."""
        for link in self.links:
            follower = link.driven_displacement(follower)
        return follower

    def follower_displacement(self, tool: Series) -> Series:
        """Displacement of the follower, from that of the tool."""
        for link in reversed(self.links):
            tool = link.driver_displacement(tool)
        return tool

    def follower_displacement_at(self, tool: FloatArray) -> FloatArray:
        """Displacement of the follower, as numbers without derivatives."""
        return np.asarray(self.follower_displacement(Taylor([tool])).terms[0])

    def joint_motions(self, follower: Series) -> list[TrainJoint]:
        """The joints, from the follower to the tool."""
        joints = [TrainJoint(follower, constant_one_series(follower))]
        for link in self.links:
            displacement, ratio = joints[-1]
            joints.append(
                TrainJoint(link.driven_displacement(displacement), ratio * link.velocity_ratio(displacement))
            )
        return joints

    @property
    def has_couplers(self) -> bool:
        return any(link.couplers_by_driving_side[0] for link in self.links)

    def least_transmission_angle_over_travel(self, lowest_tool_position: Any, highest_tool_position: Any) -> Number:
        """Least transmission angle of its couplers over a travel of the tool [rad]."""
        angles = []
        for link in reversed(self.links):
            one, other = (
                formula_value_at(link.driver_displacement, lowest_tool_position),
                formula_value_at(link.driver_displacement, highest_tool_position),
            )
            lowest_tool_position, highest_tool_position = np.minimum(one, other), np.maximum(one, other)
            if (coupler := link.couplers_by_driving_side[0]) is not None:
                angles.append(coupler.least_transmission_angle(lowest_tool_position, highest_tool_position))
        return reduce(np.minimum, angles)

    def sketch(self, follower: FloatArray, port: Port, size: float) -> LinkSketch:
        """Its links in some positions of the follower; ``port`` is where the follower drives the first link."""
        driver, first, sketches = follower, port, list[LinkSketch]()
        for link in self.links:
            driven = np.asarray(link.driven_displacement(Taylor([driver])).terms[0])
            sketches.append(link.sketch(driver, driven, size).attached_to_port(port))
            driver, port = driven, sketches[-1].output_port
        members = [member for sketch in sketches for member in sketch.members]
        return LinkSketch(members, [support for sketch in sketches for support in sketch.supports], first, port)

    @cached_property
    def joint_motion_signs(self) -> tuple[Any, ...]:
        """For each joint 1 if it moves with the follower, −1 if against it."""
        return tuple(np.sign(joint.ratio.terms[0]) for joint in self.joint_motions(Taylor([0.0, 1.0])))

    @cached_property
    def joint_forces(self) -> tuple[JointForce, ...]:
        """The forces in its joints, from the follower to the tool (``trains.joint_forces``)."""
        return tuple(list_joint_forces(self.links, self.stages))

    def sum_joint_forces(
        self,
        parts: Sequence[WeightedForce],
        follower: Series,
        velocity_signs: Sequence[Any],
        loads: Mapping[int, Series],
    ) -> FollowerLoad:
        """A sum of joint forces, split into its static part and its inertia as a load on the follower is."""
        joints = self.joint_motions(follower)
        total = FollowerLoad(*(series * 0.0 for series in sum_follower_load(joints, (), velocity_signs, {})))
        for part in parts:
            share = self.links[part.link].joint_forces[part.force].share(joints[part.link].displacement) * part.sign
            # the load of the link's output joint and of all joints towards the tool
            joint = part.link + 1
            carried = tuple(load for load in self.carried if load.joint >= joint)
            beyond = sum_follower_load(
                joints, carried, velocity_signs, {k: load for k, load in loads.items() if k >= joint}
            )
            static, inertia = (series_quotient(series, joints[joint].ratio) * share for series in beyond)
            total = FollowerLoad(total.still + static, total.carried + inertia)
        return total

    @cached_property
    def tool_travel_ends(self) -> tuple[TravelEnd, TravelEnd]:
        """The ends of the tool's travel: the first dead points below and above the start position."""
        low, high = TravelEnd(-inf), TravelEnd(inf)
        for number, link in zip(self.stages, self.links, strict=True):
            below, above = (TravelEnd(*each, number) for each in link.dead_points)
            low, high = max(low, below), min(high, above)
            low, high = sorted(
                each._replace(at=formula_value_at_end(link.driven_displacement, each.at)) for each in (low, high)
            )
        return low, high


def assemble_train(stages: Sequence[tuple[str, Keys]], *, angular: bool) -> Train:
    """A train from the names and keys of its stages [mm and deg], from the follower to the tool.

    ``angular`` says whether the follower's motion is an angle.

    Raises
    ------
    StageFault
        If a stage has a missing or unknown key, cannot be assembled, or starts at a dead point.
    """
    train = assemble_train_with_arrays(stages, angular=angular)
    for number, link in zip(train.stages, train.links, strict=True):
        for end in link.dead_points:
            if abs(end.at) <= NO_MOTION:
                raise StageFault(number, f"it starts at a dead point: {end.why}")
    return train


def assemble_train_with_arrays(stages: Sequence[tuple[str, Keys]], *, angular: bool) -> Train:
    """Trains from arrays or ranges of numbers; those that cannot be assembled are among them."""
    links, numbers = list[Link](), list[int]()
    for number, (name, keys) in enumerate(stages, start=1):
        try:
            stage_links = TRAIN_STAGES[name].make_links(keys, angular)
        except AssemblyFault as fault:
            raise StageFault(number, str(fault)) from None
        links += stage_links
        numbers += [number] * len(stage_links)
        angular = TRAIN_STAGES[name].turns(keys, angular)
    return Train(tuple(links), tuple(numbers))
