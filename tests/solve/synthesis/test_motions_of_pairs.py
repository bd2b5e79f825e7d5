"""Free laws of followers with two contacts: limits at both, and the halves of a turn in a yoke."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.depth import times

from camopt import Scene, evaluate, find_scene, optimise, synthesise
from camopt.core.mistakes import BadInput
from camopt.core.numerics.curves import value_and_slope
from camopt.core.numerics.state import State
from camopt.model.mechanisms.pairs import largest_half_turn_misfit
from camopt.scene.problem.problem import resolve
from camopt.solve.synthesis.linear_constraints import linear_constraints_of

RISE = {"segment": "rise", "angle": 120, "lift": 20, "law": "cycloidal"}
TURN = [
    RISE,
    {"segment": "dwell", "angle": 60},
    {**RISE, "segment": "return", "angle": 110},
    {"segment": "dwell", "angle": 70},
]
OWN = {"base_radius": 48, "roller_radius": 9, "offset": 2}


def pair_scene(rotation="ccw", **drive):
    return Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 40, "rotation": rotation},
            "follower": {"motion": "translating", "contact": "roller", "roller_radius": 8},
            "drive": {"kind": "conjugate", **drive},
            "motion": TURN,
            "limits": {"pressure_angle": 30},
            "search": {"offset": {"start": -15, "stop": 15}},
            "synthesis": {"pieces": 10},
        }
    )


def rib_scene(rotation):
    return pair_scene(rotation).replace(**{"drive.kind": "rib", "follower.roller_spacing": 20.0})


@settings(max_examples=times(10, deep=400))
@given(
    st.sampled_from(
        [made for way in ("cw", "ccw") for made in (pair_scene(way), pair_scene(way, **OWN), rib_scene(way))]
    ),
    st.floats(0, 20),
    st.floats(-30, 30),
    st.floats(20, 60),
    st.floats(-15, 15),
)
def test_linear_limits_of_both_contacts_are_those_of_their_pressure_angles(scene, y, y1, size, offset):
    problem = resolve(scene)
    design = problem.design.with_values({"size": np.array([size]), "offset": np.array([offset])})
    (contact,) = problem.setup.mechanism.further_contacts
    state = State(y, y1, 0.0, 0.0)
    first = value_and_slope(problem.setup.mechanism.pressure(design, problem.programme), 0, state)[0]
    second = value_and_slope(
        contact.mechanism.pressure(contact.local_designs(design), problem.programme), 0, state
    )[0]
    lead, height = float(design.signed_offset[0]), float(problem.setup.mechanism.start(design)[0])
    values = [
        f.displacement * y + f.velocity * y1 + f.lead * lead + f.height * height + f.constant
        for f in linear_constraints_of(problem)
    ]
    room = np.tan(np.radians(30)) - max(abs(first), abs(second))
    assert len(values) == 4
    if abs(room) > 1e-9:
        assert (min(values) > 0.0) == (room > 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("drive", [{}, OWN])
def test_free_laws_of_a_pair_hold_limits_at_both_discs(drive):
    scene = pair_scene(**drive)
    found, known = synthesise(scene), optimise(scene)
    assert found.convex
    assert found.bound <= found.objective < known.best["base_radius_mm"]
    told = evaluate(found.scene.replace(outputs=["pair"]))
    angles = [told[f"{place}_pressure_angle_max_deg"] for place in ("first", "second")]
    assert max(angles) == pytest.approx(30, abs=1e-6)
    assert "drive" in found.scene.to_dict()


@pytest.mark.slow
def test_free_laws_of_a_yoke_are_the_same_in_both_halves_of_the_turn():
    pump = find_scene("pump-of-constant-breadth").replace(
        **{"synthesis": {"pieces": 10, "minimise": "jerk"}, "limits.contact_stress": 900}
    )
    found = synthesise(pump)
    assert largest_half_turn_misfit(resolve(found.scene).programme).off < 1e-12
    assert found.bound <= found.objective
    moves = [{"segment": "move", "angle": 100, "to": 12, "through": [{"angle": 50, "position": 7}]}]
    moves += [{"segment": "dwell", "angle": 30}, {"segment": "move", "angle": 50, "to": 9}]
    limits = {"curvature_radius": 15, "acceleration": 10}
    yoke = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 40, "rpm": 100},
            "follower": {"motion": "translating", "contact": "flat"},
            "drive": {"kind": "breadth"},
            "motion": moves,
            "limits": limits,
            "synthesis": {"pieces": 10},
        }
    )
    assert [(each.segment, each.to) for each in yoke.motion[3:]] == [("move", 9.0), ("dwell", None), ("move", 12.0)]
    assert yoke.motion[3].through[0].position == 14.0
    assert largest_half_turn_misfit(resolve(synthesise(yoke).scene).programme).off < 1e-12


def test_a_yoke_can_be_given_half_a_turn():
    pump = find_scene("pump-of-constant-breadth")
    halved = pump.replace(motion=pump.to_dict()["motion"][:2])
    assert halved == pump
    with pytest.raises(BadInput, match=r"the angles add up to 180 deg, not to 360"):
        pump.replace(motion=pump.to_dict()["motion"][:2], drive=None)
