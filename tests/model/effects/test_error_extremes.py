"""Largest errors without a curve, against corners of tolerances by exact contact, tables and smallest cams."""

from itertools import product

import numpy as np
import pytest
from support.real_cams import cams_of
from support.ribs import rib

import camopt
from camopt.model.effects.motion import motion_error_quantity_names, motion_unit_factor
from camopt.model.motion.stroke import DWELL
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.solve.tolerances.errors import error_ranges_by_key_at_all_contacts
from camopt.solve.tolerances.tolerance import first_order_errors
from camopt.solve.tolerances.turn_errors import TurnErrors

LINKS = {"train.1.coupler": 0.05, "train.1.crank": {"plus": 0.04, "minus": 0.0}, "follower.arm_length": 0.03}
PAIR = {"drive.roller_radius": "h6", "follower.arm_length": 0.02, "phase": 0.02, "disc_phase": 0.02}
SCENES = {
    "links": ("slide-by-bell-crank", {}, {**LINKS, "phase": 0.02}),
    "ratio": ("slide-by-bell-crank", {}, {"follower.roller_radius": 0.02, "phase": {"plus": 0.03, "minus": 0.01}}),
    "pair": ("press-feed-by-pair", {"part": {}}, PAIR),
    "yoke": ("pump-of-constant-breadth", {"part": {}}, {"phase": 0.1, "cam.base_radius": 0.02}),
    "rib": (
        "bottle-filler-by-rib",
        {"part": {}, "cam.rpm": 100},
        {"follower.roller_radius": 0.02, "follower.roller_spacing": 0.05, "phase": 0.05},
    ),
}
RIB = {"follower.roller_radius": 0.02, "follower.roller_spacing": 0.05, "phase": 0.05}
SCENES |= {f"rib of a disc, {motion}": (motion, {}, RIB) for motion in ("translating", "oscillating")}
DENSE = np.linspace(0.0, 2.0 * np.pi, 3001)[:-1]


def scene_of(kind, **more):
    name, changes, given = SCENES[kind]
    own = kind.startswith("rib of") and rib(np.random.default_rng(3), name, "disc")
    scene = Scene.from_dict(own) if own else camopt.find_scene(name)
    return scene.replace(limits={}, **changes).replace(tolerances={**given, **more})


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", SCENES)
def test_the_largest_errors_are_those_of_the_worst_corner_by_exact_contact(kind):
    """Errors of position, velocity and acceleration, up to terms of second order."""
    scene = scene_of(kind)
    problem = resolve_design(scene)
    found = camopt.evaluate(scene.replace(outputs=["motion_errors"]))
    ends, worst = error_ranges_by_key_at_all_contacts(scene, problem), np.zeros(3)
    cams = cams_of(problem, 0)
    for corner in product(*ends.values()):
        off = {key: np.full(DENSE.size, end) for key, end in zip(ends, corner, strict=True)}
        errors = [
            motion_unit_factor(problem.setup, order) * np.abs(cams.motion_errors(off, DENSE, order)).max()
            for order in range(3)
        ]
        worst = np.maximum(worst, errors)
    told = np.array([found[name] for name in motion_error_quantity_names(problem.setup)[:3]])
    finite = np.isfinite(told)  # the law of one jumps
    assert finite[:2].all()
    np.testing.assert_allclose(worst[finite], told[finite], rtol=8e-3)


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", SCENES)
def test_they_are_those_of_the_tables_with_profiles_and_bores_too(kind):
    scene = scene_of(kind, profile=0.01, waves=9, bore_eccentricity=0.02)
    turn = TurnErrors(scene, resolve_design(scene))
    found = camopt.evaluate(scene.replace(outputs=["motion_errors"]))
    names = motion_error_quantity_names(turn.problem.setup)
    np.testing.assert_allclose(
        [found[n] for n in names[:3]], [e.worst for e in first_order_errors(turn)], rtol=1e-9
    )
    changes = [0.0]
    for stroke in turn.problem.programme.tool.strokes:
        if stroke.kind == DWELL:
            dwell = np.linspace(stroke.start, np.nextafter(stroke.start + stroke.angle, 0.0), 33)
            changes.append(
                motion_unit_factor(turn.problem.setup, 0)
                * sum(each.change() for each in turn.contributions_at(dwell))
            )
    assert max(changes) == pytest.approx(found[names[3]], rel=1e-9)


def test_a_jump_of_the_motion_makes_them_infinite_as_in_the_tables():
    motion = [{"segment": each, "angle": 180, "lift": 10, "law": "parabolic"} for each in ("rise", "return")]
    scene = scene_of("pair").replace(motion=motion)
    _, velocity, acceleration = first_order_errors(TurnErrors(scene, resolve_design(scene)))
    found = camopt.evaluate(scene.replace(outputs=["motion_errors"]))
    assert found["velocity_error_max_rad_s"] == pytest.approx(velocity.worst, rel=1e-9)
    assert found["acceleration_error_max_rad_s2"] == acceleration.worst == np.inf


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("kind", "limits"),
    [("links", {"position_error": 0.0695}), ("pair", {"velocity_error": 0.0497, "dwell_error": 0.02})],
)
def test_limits_on_them_hold_in_searches_and_proofs(kind, limits, tmp_path):
    """The smallest cam just meets the limit; each design of a sweep has the errors of its own scene."""
    search = {"base_radius": {"start": 40, "stop": 90, "step": 10}}
    scene = scene_of(kind, profile=0.01, waves=9).replace(limits=limits, search=search)
    best = camopt.optimise(scene).best
    second = {"drive.base_radius": 62} if kind == "pair" else {}  # as the first one of the scene
    (name,) = [each for each in limits if each != "dwell_error"]
    column = next(key for key in best if key.startswith(f"{name}_max"))
    assert best[column] == pytest.approx(limits[name], rel=1e-6)
    for share, verdict in ((1.0 + 1e-6, "held"), (1.0 - 1e-4, "broken")):
        fixed = scene.replace(search={}, **second, **{"cam.base_radius": best["base_radius_mm"] * share})
        assert camopt.certify(fixed)[name] == verdict
    camopt.sweep(scene, tmp_path)
    designs = camopt.load(tmp_path / "designs.parquet")
    for row in (0, len(designs) - 1):
        size = float(designs["base_radius_mm"][row])
        alone = camopt.evaluate(scene.replace(search={}, **second, **{"cam.base_radius": size}))
        assert alone[column] == pytest.approx(float(designs[column][row]), rel=1e-12)
