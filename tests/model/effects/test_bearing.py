"""Radii of bodies with which pitch curves meet a limit on contact stress, against the stress of each design."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.cams import FREE, GUIDED, STEEL, SWUNG, cam_with
from support.depth import times

from camopt import Scene, evaluate
from camopt.model.effects import bearing_radii
from camopt.model.effects.effect import EvaluationBlock
from camopt.model.effects.peak import RadiusRange
from camopt.scene.problem.limit import UNDERCUT
from camopt.scene.problem.problem import resolve
from camopt.solve.verdicts.effect_runs import columns_for_limits

GROOVE = {"kind": "groove", "clearance": 0.2}
CAMS = {
    "roller": {},
    "offset-roller": {"drive": GROOVE},
    "arm": {},
    "groove": {},
    "groove-arm": {"drive": GROOVE},
    "flat": {},
    "swinging-face": {},
}
"""Contacts whose pitch curves have ranges of bodies, each with what its scene has more."""
ALL, ONE = RadiusRange(4.0, 40.0), RadiusRange(12.0, 12.0)


def problem_of(contact, law, rotation, more=()):
    """The problem of a contact, with the contact stress of the scene as its limit."""
    dynamics = SWUNG if "arm" in contact or contact == "swinging-face" else FREE
    data = cam_with(contact, law, dynamics, rotation, materials=STEEL, **CAMS[contact], **dict(more))
    scene = Scene.from_dict(data | {"outputs": ["hertz"]})
    stress = evaluate(scene)["contact_stress_max_MPa"]
    return resolve(scene.replace(limits={"contact_stress": stress if np.isfinite(stress) else 500.0}))


def with_body(mechanism, designs, body):
    """Designs with the pitch curves of designs with a knife edge, and another body."""
    if mechanism.parallel == "face_offset":
        return replace(designs, face_offset=body, size=designs.size + body)
    if mechanism.pitch_ignores_parallel_size:
        return replace(designs, **{mechanism.parallel: body})
    return replace(designs, roller_radius=body, size=designs.size - body)


@pytest.mark.parametrize("contact", CAMS)
@given(
    seed=st.integers(0, 10**6),
    law=st.sampled_from(["cycloidal", "harmonic", "parabolic", "uniform"]),
    rotation=st.sampled_from(["cw", "ccw"]),
)
@settings(max_examples=times(3, deep=40))
def test_a_pitch_curve_has_one_range_of_bodies_that_bear_the_load(contact, law, rotation, seed):
    """Sound designs meet the limit within the range and nowhere else, next to its ends too; one body is certain."""
    rng, problem = np.random.default_rng(seed), problem_of(contact, law, rotation)
    (limit,) = (each for each in problem.limits if each.set_by_scene)
    (undercut,) = (each for each in problem.limits if each.name == UNDERCUT)
    limit = replace(limit, bound=limit.bound * rng.uniform(0.7, 1.3))
    mechanism, count = problem.setup.mechanism, 8
    curves = mechanism.standard_profile_reduction(problem.design.take(np.zeros(count, dtype=int)))
    curves = replace(curves, size=curves.size * rng.uniform(0.8, 1.5, count))
    case = EvaluationBlock(problem.setup, problem.programme, curves)
    told, of_one = (limit.sure_and_possible_body_radii(case, some) for some in (ALL, ONE))
    assert limit.deciding_pitch_curve_quantities == ()
    ends = np.array([np.broadcast_to(end, count) for each in told for end in each])
    ends = np.where((ends > ALL.least) & (ends < ALL.most), ends, 10.0)
    near = np.repeat(ends, 2, axis=0) * np.tile([[1.0 - 1e-9], [1.0 + 1e-9]], (4, 1))
    body = np.vstack([np.full(count, ONE.least), near, rng.uniform(*ALL, (6, count))])
    designs = with_body(mechanism, curves.take(np.tile(np.arange(count), len(body))), body.ravel())
    held, sound = (
        (each.excess(columns_for_limits(problem, [each], designs), designs) <= 0.0).reshape(body.shape)
        for each in (limit, undercut)
    )
    surely, perhaps = (each.contains(body) for each in told)
    assert not np.any(surely & sound & ~held)
    assert not np.any(held & ~perhaps)
    for each in of_one:
        assert np.array_equal(each.contains(body[0]) & sound[0], held[0])


@pytest.mark.parametrize("contact", ["spherical", "roller"])
def test_pitch_curves_do_not_tell_of_a_point_nor_of_a_rubbing_guide(contact):
    data = cam_with(contact, dynamics=FREE if contact == "spherical" else GUIDED, limits={"contact_stress": 500})
    problem = resolve(Scene.from_dict(data))
    (limit,) = (each for each in problem.limits if each.set_by_scene)
    assert limit.deciding_pitch_curve_quantities is None
    assert (
        limit.sure_and_possible_body_radii(EvaluationBlock(problem.setup, problem.programme, problem.design), ALL)
        is None
    )


TRACED = [contact for contact in CAMS if contact not in ("flat", "swinging-face")]
"""Contacts of rollers."""


def limit_and_curves(contact, law, factor):
    """The limit of a contact with another bound, and a block of pitch curves."""
    problem = problem_of(contact, law, "cw")
    (limit,) = (each for each in problem.limits if each.set_by_scene)
    curves = problem.setup.mechanism.standard_profile_reduction(problem.design.take(np.zeros(5, dtype=int)))
    curves = replace(curves, size=curves.size * np.linspace(0.9, 1.5, 5))
    case = EvaluationBlock(problem.setup, problem.programme, curves)
    return replace(limit, bound=limit.bound * factor), case


@pytest.mark.parametrize("law", ["cycloidal", "parabolic"])
@pytest.mark.parametrize("contact", TRACED)
def test_the_largest_force_and_curvature_bound_the_load_at_every_cam_angle(contact, law):
    _, case = limit_and_curves(contact, law, 1.0)
    for flank in case.setup.mechanism.flanks:
        shares = np.full(5, 0.01 * flank.pressing)
        above = bearing_radii._scaled_load_and_curvature_upper_bounds(case, flank, shares)
        for angle in np.linspace(0.0, 2.0 * np.pi, 500, endpoint=False):
            line = bearing_radii._scaled_load_and_curvature_at_state(
                case, flank, shares, slice(None), case.programme.state(np.full(5, angle))
            )
            assert all(np.all(one <= most + 1e-12) for one, most in zip(line, above, strict=True))
        assert np.all(above[0] <= 1e3)


@pytest.mark.parametrize("contact", TRACED)
def test_a_limit_far_from_the_stress_is_decided_without_a_search_of_the_load(contact, monkeypatch):
    monkeypatch.setattr(bearing_radii, "roller_load_utilisation", None)
    loose, case = limit_and_curves(contact, "cycloidal", 10.0)
    sure, _ = loose.sure_and_possible_body_radii(case, RadiusRange(9.0, 11.0))
    assert np.all(sure.contains(np.full(5, 9.0)) & sure.contains(np.full(5, 11.0)))
    if len(case.setup.mechanism.flanks) == 1:  # the other flank may still be searched
        tight, case = limit_and_curves(contact, "cycloidal", 0.1)
        _, possible = tight.sure_and_possible_body_radii(case, RadiusRange(9.0, 11.0))
        assert not np.any(possible.least <= possible.most)
