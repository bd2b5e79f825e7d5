"""Margins of limits over all cams within tolerances, against scans of corners and insides, and witnesses."""

import json

import numpy as np
import pytest
from support.cams import STEEL, cam_with

import camopt
from camopt.core.numerics import LARGEST
from camopt.core.numerics.curves import Linear
from camopt.model.effects import EvaluationBlock
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.constraints import ConstantBound, Constraint
from camopt.scene.problem.problem import resolve_design, with_rounding_relative_error
from camopt.scene.scene import Scene
from camopt.solve.verdicts.constraint_boxes import constraint_verdict_over_box
from camopt.solve.verdicts.effect_runs import run_effects

LIMITS = {"pressure_angle": 40, "curvature_radius": 2, "contact_stress": 3000, "contact_force_min": 1, "torque": 60}
WIDE = {
    "offset-roller": {"roller_radius": 0.4, "offset": {"plus": 1.5, "minus": 0.5}},
    "spherical": {"face_radius": 0.5, "offset": 0.3},
    "arm": {"arm_length": 0.7, "centre_distance": 0.5, "roller_radius": {"plus": 0.0, "minus": 0.3}},
    "flat": {"offset": 0.4},
    "groove-arm": {"arm_length": 0.6},
}
BOUNDED = {"flat": {"face_reach": 40, **LIMITS}, "groove-arm": {"pressure_angle": 60, "torque": 60}}


def scene_of(contact):
    found = cam_with(contact, "poly345")
    limits = {key: each for key, each in BOUNDED.get(contact, LIMITS).items() if contact != "flat" or key[0] != "p"}
    tolerances = {"follower": WIDE[contact]}
    return Scene.from_dict(
        {"name": contact, **found, "materials": STEEL, "limits": limits, "tolerances": tolerances, "outputs": []}
    )


@pytest.mark.one_in(5)
@pytest.mark.parametrize("contact", WIDE)
def test_no_cam_within_the_tolerances_is_worse_than_the_worst_cam(contact):
    """Of 300 cams inside, on the sides and at the corners; and the scene of the worst cam has the worst value."""
    scene, rng = scene_of(contact), np.random.default_rng(4)
    found, problem = camopt.tolerance(scene), with_rounding_relative_error(resolve_design(scene))
    keys = list(found.margins[0].sizes)
    fields = [key.partition(".")[2].replace("face_radius", "roller_radius") for key in keys]
    shares = rng.uniform(size=(300, len(keys)))
    shares[100:200] = np.round(shares[100:200])
    shares[200:, 0] = np.round(shares[200:, 0])
    values = {}
    for place, (key, field) in enumerate(zip(keys, fields, strict=True)):
        given = WIDE[contact][key.partition(".")[2]]
        plus, minus = (given["plus"], given["minus"]) if isinstance(given, dict) else (given, given)
        values[field] = problem.design.sizes[field][0] - minus + shares[:, place] * (plus + minus)
    designs = problem.design.take(np.zeros(300, dtype=int)).with_values(values)
    for limit, margin in zip(problem.limits, found.margins, strict=True):
        if not margin.quantity:
            continue
        columns = run_effects(
            EvaluationBlock(problem.setup, problem.programme, designs), limit.required_quantities
        ).columns
        seen = np.array([np.broadcast_to(columns[name], 300) for name in limit.shown_quantities])
        seen = np.abs(seen).max(axis=0) if len(seen) > 1 else seen[0]
        side = -1.0 if margin.relation in ("≥", ">") else 1.0
        assert margin.gap is not None, margin
        assert margin.gap <= 2e-6 * max(1.0, abs(margin.worst)), margin
        assert (side * (seen - margin.worst)).max() <= margin.gap, margin
        assert margin.verdict == ("held" if side * (margin.worst - margin.bound) <= 0.0 else "broken"), margin
        alone = resolve_design(found.worst_cam(margin.limit))
        there = run_effects(
            EvaluationBlock(with_rounding_relative_error(alone).setup, alone.programme, alone.design),
            limit.required_quantities,
        ).columns
        worst = max(abs(float(np.ravel(there[name])[0])) for name in limit.shown_quantities)
        assert worst == pytest.approx(abs(margin.worst), rel=1e-11)


def test_a_cam_inside_the_box_that_is_worse_than_all_corners_is_found():
    """A curve that is highest at an offset which is no corner, and not the middle."""
    problem = with_rounding_relative_error(resolve_design(scene_of("offset-roller")))

    def hill(designs, programme):
        off = np.square(designs.offset - 11.3) + np.square(designs.roller_radius - 14.1)
        none = 0.0 * off
        return Linear(1.0 + none, none, none, -off)

    lift, ends = problem.programme.lift, {"offset": (10.5, 12.5), "roller_radius": (13.6, 14.4)}
    constraint = Constraint(hill, ALL_STROKES, LARGEST, ConstantBound(lift - 1e-6))
    found = constraint_verdict_over_box(problem, constraint, problem.design, ends)
    assert found.verdict == "broken"
    assert abs(found.witness.offset[0] - 11.3) < 2e-3
    assert abs(found.witness.roller_radius[0] - 14.1) < 2e-3
    constraint = constraint._replace(bound=ConstantBound(lift + 1e-9))
    assert constraint_verdict_over_box(problem, constraint, problem.design, ends).verdict == "held"


@pytest.mark.slow
def test_the_verdict_changes_where_the_worst_cam_meets_the_bound():
    scene = scene_of("arm")
    worst = {each.limit: each.worst for each in camopt.tolerance(scene).margins}["pressure_angle"]
    for share, verdict in ((1.0 + 1e-9, "held"), (1.0 - 1e-9, "broken")):
        margins = camopt.tolerance(scene.replace(**{"limits.pressure_angle": worst * share})).margins
        assert {each.limit: each.verdict for each in margins}["pressure_angle"] == verdict


def test_a_profile_that_the_pressure_angle_shows_to_be_clear_of_itself_is_for_all_cams():
    margins = camopt.tolerance(scene_of("offset-roller")).margins
    assert {each.limit: each.verdict for each in margins}["self_crossing"] == "held"


def test_limits_that_no_size_moves_have_the_value_of_the_nominal_cam():
    scene = scene_of("offset-roller").replace(**{"limits.acceleration": 100})
    margin = next(each for each in camopt.tolerance(scene).margins if each.limit == "acceleration")
    assert margin.worst == margin.nominal
    assert (margin.gap, margin.verdict) == (0.0, "held")


def test_there_are_no_margins_without_tolerances_of_sizes():
    scene = scene_of("offset-roller").replace(tolerances={"profile": 0.01})
    found = camopt.tolerance(scene)
    assert found.margins == ()
    assert found.margins_table() is None
    with pytest.raises(camopt.UnknownName, match="not a limit with a margin"):
        found.worst_cam("pressure_angle")


@pytest.mark.slow
def test_the_command_shows_the_margins_and_writes_them(command, tmp_path):
    scene = scene_of("offset-roller")
    file = tmp_path / "cam.toml"
    file.write_text(scene.to_toml())
    text = command("tolerance", file)[1]
    assert "limits within the tolerances" in text
    assert "offset 12.5 mm" in text
    margins = json.loads(command("tolerance", file, "--json")[1])["margins"]
    found = {each.limit: each for each in camopt.tolerance(scene).margins}
    assert {each["limit"]: each["worst"] for each in margins} == {n: each.worst for n, each in found.items()}
    code, _, err = command("tolerance", file, "--out", tmp_path / "cams")
    worst = tmp_path / "cams" / "worst-pressure_angle.toml"
    assert (code, f"wrote {worst}" in err) == (0, True)
    assert camopt.Scene.from_toml(worst).follower.offset == found["pressure_angle"].sizes["follower.offset"]
