"""Batches of cams: yields, percentiles and shares of the variance, where they are known in closed form."""

import json
from math import erf, sqrt

import numpy as np
import pytest
from scipy import stats

import camopt
from camopt.core.mistakes import BadInput
from camopt.scene.problem.problem import resolve_design
from camopt.solve.tolerances.batch import share_with_confidence
from camopt.solve.tolerances.error_samples import exceed_tolerances, real_error_parts_in_mm_and_deg, sample_errors
from camopt.solve.tolerances.errors import error_ranges_at_one_contact
from tests.solve.tolerances.test_margins import scene_of

FACE = camopt.find_scene("bucket-valve")


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("given", "below"),
    [
        ({"cpk": 1.0}, lambda off: erf(off / (0.5 / 3.0) / sqrt(2.0))),
        ({"cpk": 1.5}, lambda off: erf(off / (0.5 / 4.5) / sqrt(2.0))),
        ({"distribution": "uniform"}, lambda off: off / 0.5),
        ({"distribution": "triangular"}, lambda off: 1.0 - (1.0 - off / 0.5) ** 2),
    ],
)
def test_the_yield_and_the_percentiles_of_a_linear_limit_are_those_of_its_closed_form(given, below):
    """The reach of a flat face is that of the nominal cam and |e|, by an offset e."""
    tolerance = {"plus": 0.5, "minus": 0.5, **given}
    nominal = camopt.evaluate(FACE)["face_reach_max_mm"]
    scene = FACE.replace(tolerances={"follower.offset": tolerance}, **{"limits.face_reach": nominal + 0.2})
    batch = camopt.sample_cams(scene, cams=2**15)
    assert batch.held.share == pytest.approx(below(0.2), abs=2e-4)
    assert batch.held.low < below(0.2) < batch.held.high
    spread = batch.spreads[0]
    for place, share in ((spread.median, 0.5), (spread.high, 0.99865)):
        assert below(place - nominal) == pytest.approx(share, abs=2e-4)


@pytest.mark.slow
def test_the_worst_cam_of_a_batch_is_not_beyond_the_proved_worst_one_unless_its_sizes_are():
    """A normal distribution has parts beyond its zone, others have none."""
    for kind in ("uniform", "triangular"):
        given = {key: {"plus": 0.4, "minus": 0.3, "distribution": kind} for key in ("offset", "roller_radius")}
        scene = scene_of("offset-roller").replace(tolerances={"follower": given})
        worst = {each.limit: each for each in camopt.tolerance(scene).margins}
        for spread in camopt.sample_cams(scene, cams=2**12).spreads:
            margin = worst[spread.limit]
            side = -1.0 if margin.relation in ("≥", ">") else 1.0
            assert side * (spread.worst - margin.worst) <= margin.gap
            assert spread.worst == pytest.approx(margin.worst, rel=0.02)


@pytest.mark.slow
def test_shares_of_the_variance_are_those_of_first_order():
    """c²σ²/Σ with slopes c by differences of single cams, of small tolerances."""
    scene = scene_of("arm").replace(
        tolerances={"follower": {"arm_length": 0.03, "centre_distance": 0.02, "roller_radius": 0.05}}
    )
    spread = camopt.sample_cams(scene, cams=2**12).spreads[0]
    slopes = {}
    for key, zone in (("arm_length", 0.03), ("centre_distance", 0.02), ("roller_radius", 0.05)):
        middle, step = scene.to_dict()["follower"][key], 1e-4
        ends = [
            camopt.evaluate(scene.replace(**{f"follower.{key}": middle + by}))[spread.quantity]
            for by in (-step, step)
        ]
        slopes[f"follower.{key}"] = (ends[1] - ends[0]) / (2.0 * step) * zone
    total = sum(each**2 for each in slopes.values())
    for key, slope in slopes.items():
        assert spread.variances[key] == pytest.approx(slope**2 / total, abs=0.01)


def test_drawn_sizes_have_the_distribution_that_is_asked():
    given = {
        "offset": {"plus": 0.3, "minus": 0.1, "distribution": "triangular"},
        "roller_radius": {"plus": 0.0, "minus": 0.2, "cpk": 1.33},
    }
    more = {
        "profile": 0.03,
        "waves": 5,
        "bore_eccentricity": 0.012,
        "phase": {"plus": 0.2, "distribution": "uniform"},
    }
    scene = scene_of("offset-roller").replace(tolerances={"follower": given, **more})
    problem = resolve_design(scene)
    errors = real_error_parts_in_mm_and_deg(sample_errors(scene, problem, 2**14, 3))
    known = {
        "follower.offset": stats.triang(0.5, loc=-0.1, scale=0.4),
        "follower.roller_radius": stats.norm(-0.1, 0.1 / 3.99),
        **{f"profile.{part}": stats.norm(0.0, 0.01) for part in ("cosine", "sine")},
        **{f"bore_eccentricity.{part}": stats.norm(0.0, 0.004) for part in ("x", "y")},
        "phase": stats.uniform(0.0, 0.2),
    }
    assert errors.keys() == known.keys()
    for key, values in errors.items():
        assert stats.kstest(values, known[key].cdf).statistic < 1e-3
    again = real_error_parts_in_mm_and_deg(sample_errors(scene, problem, 2**14, 3))
    assert all(np.array_equal(errors[key], again[key]) for key in errors)


@pytest.mark.slow
@pytest.mark.parametrize(("own", "within"), [({}, erf(3 / sqrt(2))), ({"cpk": 0.5}, erf(1.5 / sqrt(2)))])
def test_so_many_cams_are_outside_of_their_tolerances_as_normal_distributions_have(own, within):
    """An axis is outside of a circle of 3σ in exp(−9/2) of the cams, a number outside of 3σ·cpk."""
    scene, offset = FACE.replace(tolerances={"bore_eccentricity": 0.01}), {"plus": 0.5, "minus": 0.5}
    scene = scene.replace(**{"tolerances.follower.offset": {**offset, **own}})
    problem = resolve_design(scene)
    share = exceed_tolerances(
        sample_errors(scene, problem, 2**15, 0), error_ranges_at_one_contact(scene, problem)
    ).mean()
    assert share == pytest.approx(1.0 - within * (1.0 - np.exp(-4.5)), abs=1e-3)
    even = FACE.replace(tolerances={"follower.offset": {**offset, "distribution": "uniform"}})
    assert camopt.sample_cams(even, cams=500).outside == 0


def test_the_interval_of_a_share_is_that_of_a_binomial_test():
    for count, cams in ((0, 50), (3, 50), (50, 50), (999, 1000)):
        known = stats.binomtest(count, cams).proportion_ci(0.95, method="exact")
        assert share_with_confidence(count, cams) == pytest.approx(
            (count / cams, known.low, known.high), rel=1e-9, abs=1e-15
        )


@pytest.mark.slow
def test_the_command_draws_cams(command, tmp_path):
    file = tmp_path / "cam.toml"
    file.write_text(scene_of("offset-roller").to_toml())
    assert "cams drawn by the tolerances" in command("tolerance", file, "--cams", "500")[1]
    found = json.loads(command("tolerance", file, "--cams", "500", "--seed", "2", "--json")[1])["batch"]
    batch = camopt.sample_cams(scene_of("offset-roller"), cams=500, seed=2)
    assert (found["cams"], found["seed"], found["outside"]) == (500, 2, batch.outside)
    assert found["held"]["share"] == batch.held.share
    assert [each["worst"] for each in found["errors"]] == [each.worst for each in batch.errors]
    assert command("tolerance", file, "--seed", "2")[0] == 2


@pytest.mark.slow
def test_what_each_cam_has_is_a_table_and_a_picture(command, tmp_path):
    file, out = tmp_path / "cam.toml", tmp_path / "made"
    scene = scene_of("offset-roller").replace(**{"tolerances.phase": 0.05})
    file.write_text(scene.to_toml())
    assert command("tolerance", file, "--cams", "500", "--out", out)[0] == 0
    table, batch = camopt.load(out / "cams.parquet"), camopt.sample_cams(scene, cams=500)
    picture = (out / "cams.svg").read_text()
    assert all(text in picture for text in ("<?xml", f"500 random cams, {batch.outside} of them"))
    assert set(table.columns) == set(batch.samples)
    for name, column in batch.samples.items():
        assert np.array_equal(table[name], column.values)
        assert table.attrs["units"][name] == column.unit
    assert table["position_error_max_mm"].max() == batch.errors[0].worst
    worst = table.loc[table["position_error_max_mm"].idxmax()]
    assert worst["phase_off_deg"] == batch.errors[0].parts["phase"]
    held = (table["pressure_angle_max_rise_deg"] <= batch.bounds["pressure_angle_max_rise_deg"]).mean()
    assert held == next(each.held.share for each in batch.spreads if each.limit == "pressure_angle")


@pytest.mark.slow
def test_a_limit_beyond_the_axis_of_a_histogram_is_on_its_side(tmp_path):
    scene = scene_of("offset-roller").replace(**{"limits.pressure_angle": 5.0, "limits.curvature_radius": 0.5})
    batch = camopt.sample_cams(scene.replace(**{"limits.pressure_angle_return": 89.0}), cams=64)
    picture = camopt.plot(batch, tmp_path / "cams.svg")
    said = {axes.get_title(loc="left"): [text.get_text() for text in axes.texts] for axes in picture.axes}
    assert said["Pressure angle max rise, deg"] == ["← limit 5"]
    assert said["Pressure angle max return, deg"] == ["limit 89 →"]
    assert "99.73 % are above" in picture.axes[6].get_legend_handles_labels()[1]


def test_invalid_batches_are_refused():
    with pytest.raises(BadInput, match="tolerances: has no tolerance: add one, such as profile"):
        camopt.sample_cams(FACE)
    with pytest.raises(BadInput, match="a whole number from 1 to"):
        camopt.sample_cams(scene_of("flat"), cams=0)
