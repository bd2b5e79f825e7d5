"""Mechanisms: what each says of its body, its flanks and its follower, against what its curves do."""

from importlib import import_module
from pkgutil import iter_modules
from typing import get_args

import numpy as np
import pytest
from support.cams import CONTACTS, cam_with

import camopt.model.mechanisms
from camopt.core.mistakes import BadInput
from camopt.core.numerics.curves import value_and_slope
from camopt.model.mechanisms import DRIVEN, FIELDS, MECHANISMS, SIZE_FIELDS, mechanism_for, mechanisms_for
from camopt.model.mechanisms.elements import BODIES, DRIVES, MOTIONS, TIPS, CamForm, DriveName, MotionName, TipName
from camopt.model.mechanisms.geometry import cam_curves
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.scene.tables import Cam, Dynamics, Follower

TRACED = [contact for contact in CONTACTS if contact not in ("flat", "swinging-face")]


def problem_of(contact, **more):
    return resolve_design(Scene.from_dict(cam_with(contact, **more)))


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", TRACED)
def test_a_flank_is_as_curved_as_its_side_and_its_bulge_say(contact, rotation):
    """Drawn points turn by their angle per length; the formula κ/(1 − κ·R) has the sign that ``bulge`` gives it."""
    problem = problem_of(contact, rotation=rotation)
    mechanism, design, turn = problem.setup.mechanism, problem.design, problem.programme
    step, radius = 1e-5, float(design.roller_radius[0])
    for degrees in (23.0, 61.0, 88.0, 171.0, 204.0, 233.0):
        angles = np.radians(degrees) + step * np.array([-1.0, 0.0, 1.0])
        kappa = float(value_and_slope(mechanism.curvature(design, turn), 0, turn.state(angles[1:2]))[0][0])
        drawn = cam_curves(mechanism, design, turn, angles)
        for flank, points in zip(mechanism.flanks, drawn.profile, strict=True):
            one, other = np.diff(points)
            bent = np.angle(other / one) / (0.5 * (abs(one) + abs(other)))
            outwards = ((points[1] - drawn.pitch[1]) * np.conj(drawn.normal[1])).real
            assert outwards == pytest.approx(flank.side * radius, abs=1e-9)
            # seen from the follower, left of the way where the normal is to the left of it
            leftwards = np.sign((np.conj(points[2] - points[0]) * -flank.side * drawn.normal[1]).imag)
            convex = -leftwards * bent
            bent_so = flank.bulge * kappa
            assert convex == pytest.approx(bent_so / (1.0 - bent_so * radius), rel=2e-4, abs=2e-6)


@pytest.mark.parametrize("mechanism", MECHANISMS.values(), ids=lambda mechanism: mechanism.name)
def test_a_flank_below_the_trace_point_pushes_and_one_beyond_it_pulls(mechanism):
    assert [flank.pressing for flank in mechanism.flanks] == [-flank.side for flank in mechanism.flanks]
    assert mechanism.can_pull_follower == any(flank.side > 0.0 for flank in mechanism.flanks)


@pytest.mark.parametrize("mechanism", MECHANISMS.values(), ids=lambda mechanism: mechanism.name)
def test_the_keys_of_a_mechanism_are_those_of_scenes(mechanism):
    assert {*mechanism.sizes} < {*SIZE_FIELDS}
    for tip in mechanism.tips:
        for key in mechanism.keys(tip):
            table, name = key.split(".")
            assert name in {"cam": Cam, "follower": Follower}[table].model_fields
            assert FIELDS[name] in ("size", *mechanism.sizes)
        assert mechanism_for(mechanism.body.form, mechanism.motion.name, tip.name) is mechanism
    assert {*mechanism.motion.own_dynamics_keys} < {*Dynamics.model_fields}


@pytest.mark.parametrize("drive", DRIVES)
def test_a_drive_is_on_some_cam_and_refused_where_there_is_none(drive):
    """A kind is written back, and gives the mechanism that has it; where none has it, other kinds are told."""
    refused = 0
    for contact in CONTACTS:
        given = cam_with(contact, drive={"kind": drive}, dynamics={})
        given["follower"].pop("offset", None)  # which a yoke has not
        given["follower"] |= {"roller_spacing": 40} if drive == "rib" else {}
        usual = Scene.from_dict(cam_with(contact)).mechanism
        form, motion, touching = given["cam"]["form"], given["follower"]["motion"], given["follower"]["contact"]
        known = {each.drive.name: each for each in mechanisms_for(form, motion, touching)}
        assert mechanism_for(form, motion, touching) is known[usual.drive.name] is usual
        if drive in known:
            scene = Scene.from_dict(given)
            assert scene.mechanism is known[drive]
            assert scene.to_dict()["drive"] == {"kind": drive}
        else:
            refused += 1
            with pytest.raises(BadInput, match=f"drive.kind = '{drive}': must be '{usual.drive.name}'"):
                Scene.from_dict(given)
    assert 0 < refused < len(CONTACTS)


@pytest.mark.parametrize("mechanism", [*MECHANISMS.values(), *DRIVEN], ids=lambda each: each.name)
def test_random_sizes_fit_or_are_told(mechanism):
    """Of one decimal, as people write them, and of triangles that are flat within rounding."""
    rng, fitting = np.random.default_rng(57), 0
    for number in range(600):
        sizes = {name: float(rng.uniform(1.0, 200.0)) for name in ("size", *mechanism.sizes)}
        sizes = {name: round(each, 1) if number % 2 else each for name, each in sizes.items()}
        if number % 3 == 0 and {"arm_length", "centre_distance"} <= sizes.keys():
            flat = abs(sizes["centre_distance"] - sizes["arm_length"]) * (1.0 + 2e-16 * rng.integers(-3, 4))
            sizes["size"] = flat - (sizes["roller_radius"] if mechanism.body.form == "disc" else 0.0)
        lift = float(rng.uniform(1.0, 30.0))
        found = mechanism.misfit({**dict.fromkeys(SIZE_FIELDS, 0.0), **sizes, "lift": lift})
        fitting += found is None
        assert found is None or found[2]
    assert fitting


def test_each_mechanism_has_a_place_of_its_own():
    modules = [
        import_module(f"camopt.model.mechanisms.{each.name}")
        for each in iter_modules(camopt.model.mechanisms.__path__)
    ]
    assert len(MECHANISMS) == sum(hasattr(module, "MECHANISM") for module in modules)


def test_the_words_of_scenes_are_those_of_the_registries():
    words = {CamForm: BODIES, MotionName: MOTIONS, TipName: TIPS, DriveName: DRIVES}
    for names, registry in words.items():
        assert (
            get_args(names)
            == tuple(registry)
            == tuple(each.form if names is CamForm else each.name for each in registry.values())
        )
    assert {(form, motion) for form, motion, _ in MECHANISMS} == {(b, m) for b in BODIES for m in MOTIONS}
