"""Numbers with units: converted as tables of units say, checked for their kind, told if they are none."""

import subprocess
import sys
from math import pi

import pytest

import camopt
from camopt.core.quantities import NUMBER_KEYS, QUANTITIES, quantity_name_by_number_key
from camopt.scene.table_places import is_key_of_angular_motion

pytest.importorskip("pint")
LB, IN, LBF = 0.45359237, 25.4, 4.4482216152605  # kg, mm, N: NIST SP 811, appendix B
GIVEN = [
    ("cam.base_radius", "2 in", 2 * IN),
    ("cam.base_radius", "1 1/2 in", 1.5 * IN),
    ("follower.offset", "-5/32 in", -5 * IN / 32),
    ("follower.offset", "-1 1/4 in", -1.25 * IN),
    ("cam.rpm", "10 rev/s", 600.0),
    ("cam.rpm", "240 1/min", 240.0),
    ("cam.rpm", "240 min^-1", 240.0),
    ("cam.rpm", "100 rad/s", 100 * 30 / pi),
    ("motion.1.angle", "120 deg", 120.0),
    ("motion.1.angle", "0.33333333333333333 turn", 120.0),
    ("follower.offset", "-0.5 cm", -5.0),
    ("follower.dynamics.mass", "3 lb", 3 * LB),
    ("follower.dynamics.spring_rate", "20 lbf/in", 20 * LBF / IN),
    ("follower.dynamics.spring_rate", "250 N/m", 0.25),
    ("follower.dynamics.load", "50 lbf", 50 * LBF),
    ("follower.dynamics.natural_frequency", "0.2 kHz", 200.0),
    ("limits.contact_stress", "1.2 GPa", 1200.0),
    ("limits.torque_rms_N_m", "10 lbf·in", 10 * LBF * IN / 1000),
    ("materials.viscosity", "80 cP", 0.08),
    ("part.density", "7.85 g/cm³", 7850.0),
    ("tolerances.profile", "0.001 in", IN / 1000),  # not the table of the same name
]


@pytest.mark.parametrize(("key", "text", "number"), GIVEN)
def test_a_number_with_a_unit_is_that_number(key, text, number):
    scene = camopt.find_scene("roller-1000rpm").replace(**{key: text})
    plain = camopt.find_scene("roller-1000rpm").replace(**{key: number})
    found, value = scene.to_dict(), plain.to_dict()
    for name in key.split("."):
        found, value = (each[int(name) - 1] if isinstance(each, list) else each[name] for each in (found, value))
    assert found == pytest.approx(value, rel=1e-14)


def test_ranges_lists_and_laws_take_them():
    scene = camopt.find_scene("roller-1000rpm").replace(
        **{
            "search.base_radius": {"start": "1 in", "stop": "10 cm", "step": "1/32 in"},
            "search.offset": ["0 mm", "1/8 in".replace("1/8", "0.125")],
            "search.follower": {"dynamics": {"mass": ["1 lb", 2]}},
            "search.cam": {"rpm": {"start": "5 rev/s", "stop": 900}},
        }
    )
    assert (scene.search.base_radius.start, scene.search.base_radius.stop) == (IN, 100.0)
    assert scene.search.base_radius.step == IN / 32
    assert scene.search.offset == (0.0, 3.175)
    assert scene.search.follower["dynamics"]["mass"] == (LB, 2.0)
    assert scene.search.cam["rpm"].start == 300.0


def test_an_oscillating_follower_has_moments():
    lever = camopt.find_scene("oscillating-roller")
    assert lever.replace(**{"motion.1.lift": "0.5 rad", "motion.2.lift": "0.5 rad"}).motion[
        0
    ].lift == pytest.approx(90 / pi, rel=1e-14)
    assert lever.replace(**{"follower.dynamics.spring_rate": "10 N·m/rad"}).follower.dynamics.spring_rate == 10.0
    with pytest.raises(camopt.BadInput, match="a number in N·m/rad"):
        lever.replace(**{"follower.dynamics.spring_rate": "10 N/mm"})


@pytest.mark.parametrize(
    ("key", "text", "line"),
    [
        (
            "cam.base_radius",
            "3 kg",
            "must be a number in mm, or a text with a unit of the same kind, such as '1 mm'",
        ),
        ("cam.base_radius", "3 inn", "'inn' is not defined"),
        ("cam.rpm", "10 Hz", "a number in rev/min"),
        ("follower.dynamics.natural_frequency", "600 rpm", "a number in Hz"),
        ("follower.dynamics.friction", "2 mm", "a number without a unit"),
        ("motion.1.angle", "3 mm", "a number in deg"),
        ("cam.base_radius", "-3 mm", "must be at least 1e-09"),
        ("cam.base_radius", "fast", "must be a number"),
    ],
)
def test_what_is_none_is_told_once(key, text, line):
    with pytest.raises(camopt.BadInput, match=line) as told:
        camopt.find_scene("roller-1000rpm").replace(**{key: text})
    assert [mistake.key for mistake in told.value.mistakes][:1] == [key]
    assert len(told.value.mistakes) == 1


@pytest.mark.parametrize("key", NUMBER_KEYS)
def test_a_unit_that_is_read_is_that_of_the_column(key):
    """Of a follower that swings and drives a slide by a train, and the other way round."""
    for angular in (False, True):
        turns = {"angular": angular, "tool_turns": not angular}
        read = NUMBER_KEYS[key].unit_of(angular=is_key_of_angular_motion(key, **turns, straight_spring=False))
        assert read.replace("no unit", "") == QUANTITIES[quantity_name_by_number_key(**turns)[key]].unit


WITHOUT_SOURCES = """
import inspect

def fail(*_):
    raise OSError("could not get source code")

inspect.getsource = inspect.findsource = inspect.getsourcelines = fail
import camopt
from camopt.scene.keys import find_keys

lifts = {"motion.1.lift": "0.5 rad", "motion.2.lift": "0.5 rad"}
scene = camopt.find_scene("oscillating-roller").replace(**{"cam.base_radius": "2 in"}, **lifts)
print(scene.cam.base_radius, round(scene.motion[0].lift, 4), find_keys("cam.rpm")[0].unit)
"""


@pytest.mark.slow
def test_units_do_not_come_from_the_source():
    """A package that is installed as compiled modules alone has none."""
    found = subprocess.run([sys.executable, "-c", WITHOUT_SOURCES], capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["50.8", "28.6479", "rev/min"]
