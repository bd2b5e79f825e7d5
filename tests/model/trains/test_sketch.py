"""Sketches of trains: joints of rigid parts stay together, and the last part moves as the tool does."""

import numpy as np
import pytest
from support.trains import random_train

from camopt.model.trains.link import formula_value_at_end
from camopt.model.trains.sketch import Port
from camopt.model.trains.train import Train, assemble_train

SIZE = 40.0
LEVERS = [("ratio", {"ratio": each}) for each in (-2.0, -0.5, 0.5, 1.0, 3.0)]


def positions(train: Train, count: int = 9) -> np.ndarray:
    """Positions of the follower over most of the tool's travel."""
    low, high = (float(np.clip(end.at, -2.0, 2.0)) for end in train.tool_travel_ends)
    tool = np.linspace(0.9 * low, 0.9 * high, count)
    return np.array([formula_value_at_end(train.follower_displacement, float(each)) for each in tool])


def paths(sketch):
    """The paths of all joints (both ends of bars, origins of other parts), and the pivots."""
    found = [member.at for member in sketch.members]
    found += [m.at + m.points[1] * np.exp(1j * m.turned) for m in sketch.members if m.shape == "bar"]
    return found + [np.full(found[0].size, each.at) for each in sketch.supports]


@pytest.mark.parametrize("seed", range(60))
def test_joints_of_a_train_stay_together(seed):
    train = random_train(np.random.default_rng(seed))[1]
    follower = positions(train)
    sketch = train.sketch(follower, port_of(train), SIZE)
    every = paths(sketch)
    for member in sketch.members:
        if member.shape == "bar" and (False, False) not in [link.driver_and_driven_angular for link in train.links]:
            for end in (member.at, member.at + member.points[1] * np.exp(1j * member.turned)):
                near = sorted(float(np.abs(end - other).max()) for other in every)
                assert near[1] < 1e-9 * SIZE * (1.0 + np.abs(end).max()), "no other part has this joint"


@pytest.mark.parametrize("seed", range(60))
def test_parts_move_as_follower_and_tool_do(seed):
    train = random_train(np.random.default_rng(seed))[1]
    check_ends(train, positions(train))


@pytest.mark.parametrize("stage", LEVERS)
def test_a_lever_moves_its_ends_by_its_ratio(stage):
    check_ends(assemble_train([stage], angular=False), np.linspace(-2.0, 5.0, 8))


def check_ends(train: Train, follower: np.ndarray) -> None:
    """Check that a part of a sketch moves as the tool does, and is turned or mirrored with its input port."""
    tool = np.array([formula_value_at_end(train.tool_displacement, float(each)) for each in follower])
    port = port_of(train)
    for shown in (port, Port(3.0 + 4.0j, np.exp(2.1j), -port.sense)):
        sketch = train.sketch(follower, shown, SIZE)
        moved, asked = tool - tool[0], sketch.output_port
        if train.angular:
            assert any(np.allclose(m.turned, asked.sense * moved, atol=1e-9) for m in sketch.members)
        else:
            assert any(np.allclose(m.at - m.at[0], asked.way * moved, atol=1e-9) for m in sketch.members)
            assert abs(asked.way) == pytest.approx(1.0)
        assert sketch.input_port == shown


def port_of(train: Train) -> Port:
    return Port(0.0, 1.0, -1.0) if train.links[0].driver_and_driven_angular[0] else Port(0.0, 1j)
