"""Derivatives of quantities by sizes and numbers, beside closed forms, slopes of ranges, and each other."""

import numpy as np
import pytest

import camopt
from camopt.core.numerics.curves import value_and_slope
from camopt.core.numerics.interval import Interval
from camopt.core.quantities import NUMBER_COLUMNS
from camopt.model.effects import EFFECTS, EvaluationBlock
from camopt.model.effects.peak import MultipleScale
from camopt.model.mechanisms import FIELDS
from camopt.scene.problem.problem import resolve_design, with_rounding_relative_error
from camopt.solve.smallest.enclosure import designs_of_sloped_intervals, state_enclosing_rounding

VALVE = camopt.find_scene("exhaust-valve").replace(
    **{
        "cam.rpm": 900,
        "follower.offset": 3,
        "follower.dynamics": {"mass": 0.8, "spring_rate": 59, "preload": 300, "damping": 0.02},
        "materials": {"cam": "steel", "follower": "steel", "face_width": 20},
        "outputs": ["all"],
    }
)
SCENES = {
    "roller": VALVE,
    "flat": camopt.find_scene("flat-reciprocating").replace(outputs=["all"]),
    "oscillating": camopt.find_scene("oscillating-roller").replace(outputs=["all"]),
}


@pytest.fixture(scope="module", params=SCENES)
def found(request):
    return camopt.sensitivities(SCENES[request.param])


def test_what_is_known_in_closed_form():
    found = camopt.sensitivities(VALVE)
    cam, width, rpm = found.quantities, 20.0, 900.0
    stress = found["contact_stress_max_MPa", "materials.face_width"].derivative
    assert stress == pytest.approx(-cam["contact_stress_max_MPa"] / (2 * width), rel=1e-8)  # p₀ ~ 1/√L
    jerk = found["jerk_rms_m_s3", "cam.rpm"] if np.isfinite(cam["jerk_rms_m_s3"]) else None
    assert jerk is None or jerk.derivative == pytest.approx(3 * cam["jerk_rms_m_s3"] / rpm, rel=1e-8)
    acceleration = found["acceleration_max_m_s2", "cam.rpm"].derivative
    assert acceleration == pytest.approx(2 * cam["acceleration_max_m_s2"] / rpm, rel=1e-8)
    assert found["prime_radius_mm", "follower.roller_radius"].derivative == pytest.approx(1.0, rel=1e-10)
    assert found["contact_force_min_N", "follower.dynamics.preload"].derivative == pytest.approx(1.0, rel=1e-9)
    assert found["acceleration_max_m_s2", "cam.base_radius"] == (0.0, 0.0, 0.0)


def test_a_place_that_jumps_to_another_peak_has_no_slope():
    """A symmetric cam at offset 0: the pressure angles of rise and return are the same, and the first is told."""
    cam = {"form": "disc", "rpm": 600, "base_radius": 40}
    follower = {"motion": "translating", "contact": "roller", "roller_radius": 10, "offset": 0}
    turn = ("rise", 100, 25.0), ("dwell", 40, None), ("return", 100, 25.0), ("dwell", 120, None)
    rows = [{"segment": kind, "angle": angle} | ({"lift": lift, "law": "cycloidal"} if lift else {})
            for kind, angle, lift in turn]  # fmt: skip
    scene = camopt.Scene.from_dict({"name": "even", "cam": cam, "follower": follower, "motion": rows})
    found = camopt.sensitivities(scene)
    place = found["pressure_angle_max_at_deg", "follower.offset"]
    assert place.derivative is None
    assert [each is None for each in place[1:]].count(True) == 1
    aside = camopt.sensitivities(scene.replace(**{"follower.offset": 3}))
    assert aside["pressure_angle_max_at_deg", "follower.offset"].derivative is not None


@pytest.mark.slow
def test_a_load_by_cam_angle_is_no_variable():
    found = camopt.sensitivities("clamp-by-wedge")
    keys = {key for _, key in found}
    assert "train.1.mass" in keys
    assert "train.1.load" not in keys


def test_numbers_of_a_train_are_variables():
    """A lever in closed form; lengths and angles of a bell crank against evaluations beside it."""
    lever = camopt.find_scene("roller-1000rpm").replace(train=[{"stage": "ratio", "ratio": 1.6}])
    found = camopt.sensitivities(lever)
    for name in ("acceleration_max_follower_m_s2", "velocity_max_follower_m_s"):
        slope = found[name, "train.1.ratio"].derivative
        assert slope == pytest.approx(-found.quantities[name] / 1.6, rel=1e-8)
    assert found["acceleration_max_m_s2", "train.1.ratio"].derivative == 0.0
    slide = camopt.find_scene("slide-by-bell-crank")
    found = camopt.sensitivities(slide)
    for key, own in slide.numbers([f"train.1.{each}" for each in ("crank", "coupler", "offset", "angle")]).items():
        low, high = (
            camopt.evaluate(slide.replace(**{key: own + by}))["pressure_angle_max_deg"] for by in (-1e-3, 1e-3)
        )
        slope = found["pressure_angle_max_deg", key].derivative
        assert slope == pytest.approx((high - low) / 2e-3, rel=1e-5)


def test_what_is_infinite_has_no_derivative():
    found = camopt.sensitivities(camopt.find_scene("uniform-knife-radial"))
    assert found.quantities["acceleration_max_mm_per_rad2"] == np.inf
    assert found["acceleration_max_mm_per_rad2", "cam.base_radius"] == (None, None, None)


def test_peaks_change_as_their_curves_do_at_their_cam_angles(found):
    """The envelope theorem, with slopes by the chain rule (``numerics.sloped_interval``)."""
    problem = with_rounding_relative_error(resolve_design(found.scene))
    keys = [*dict.fromkeys(key for _, key in found)]
    numbers = {key: problem.setup.given[key] for key in keys if key in NUMBER_COLUMNS}
    setup, design = problem.with_numbers_per_design(numbers).setup, problem.design
    design = design.with_values({key: np.array([float(value)]) for key, value in numbers.items()})
    free = [key if key in NUMBER_COLUMNS else FIELDS[key.partition(".")[2]] for key in keys]
    box = design.with_values({name: Interval(value, value) for name, value in design.values.items()})
    compared, case = 0, EvaluationBlock(setup, problem.programme, design)
    for effect in EFFECTS.values():
        for name, peak in effect.peaks(setup).items():
            if type(peak.scale) is not MultipleScale or name not in found.quantities or len(peak.curves) > 1:
                continue
            ((make, kinds),) = peak.curves
            if not hasattr(make(design, problem.programme), "_fields") or not np.isfinite(found.quantities[name]):
                continue
            extreme = case.extremes(make, [(kinds, peak.goal)], exact_angles=True)
            designs, _ = designs_of_sloped_intervals(box, design, free, 1)
            sides = []  # of a jump
            for angle in problem.programme.one_sided_angles(extreme.where, kinds).reshape(2, 1):
                state = state_enclosing_rounding(problem.programme.state(angle), problem.programme)
                sides.append(value_and_slope(make(designs, problem.programme), ..., state)[0])
            value = min(sides, key=lambda side: abs(abs(side.at.low[0]) - abs(extreme.value[0, 0])))
            sign = np.sign(found.quantities[name]) * np.sign(value.at.low[0])
            slopes = peak.scale.factor * sign * 0.5 * (value.slopes.low + value.slopes.high)[:, 0]
            for key, slope in zip(keys, slopes, strict=True):
                if (seen := found[name, key].derivative) is not None:
                    unit = abs(found.quantities[name]) / max(1.0, abs(float(problem.setup.given[key] or 1.0)))
                    assert seen == pytest.approx(slope, rel=1e-5, abs=1e-6 * unit), (name, key)
                    compared += 1
    assert compared > 5


def test_a_kink_has_a_slope_on_each_side_and_no_derivative():
    """A lobe that is its own mirror image has equal pressure angles on rise and return without an offset."""
    radial = VALVE.replace(**{"follower.offset": 0, "limits": None, "outputs": ["pressure"]})
    derivative, below, above = camopt.sensitivities(radial)["pressure_angle_max_deg", "follower.offset"]
    assert derivative is None
    assert below == pytest.approx(-above, rel=1e-6)
    assert above > 0.0


def test_an_unknown_pair_gets_its_neighbours():
    found = camopt.sensitivities(camopt.find_scene("roller-1000rpm"))
    assert len(found) == len([*found])
    with pytest.raises(
        camopt.UnknownName, match=r"'cam\.base_radus' is not a quantity or variable of this cam; did you"
    ):
        found["pressure_angle_max_deg", "cam.base_radus"]
