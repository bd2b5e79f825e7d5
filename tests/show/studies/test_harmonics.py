"""Harmonics beside quadrature of the laws themselves, closed forms and identities."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import camopt
from camopt import LAWS, BadInput, harmonics
from camopt.scene.problem.problem import resolve
from camopt.show.studies.harmonics import ROUNDING

ORDERS = 30


def turn(rise, fall=None, **cam):
    return camopt.Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 40, **cam},
            "follower": {"motion": "translating", "contact": "knife"},
            "motion": [
                {"segment": "rise", "angle": 110, "lift": 20, "law": rise},
                {"segment": "dwell", "angle": 55},
                {"segment": "return", "angle": 130, "lift": 20, "law": fall or rise},
                {"segment": "dwell", "angle": 65},
            ],
        }
    )


def by_quadrature(scene, order, derivative):
    """(1/π)∫ f·e^{−ikθ} dθ by Gauss's rule between the points at which the law is not smooth."""
    programme, (nodes, weights) = resolve(scene).programme.tool, np.polynomial.legendre.leggauss(60)
    found = 0.0
    for stroke in programme.strokes:
        breaks = stroke.law.BREAKS if stroke.law else (0.0, 1.0)
        for low, high in pairwise(breaks):
            half = stroke.angle * (high - low) / 2
            angles = stroke.start + stroke.angle * (low + high) / 2 + half * nodes
            waves = programme.motion_at(angles)[derivative] * np.exp(-1j * order * angles)
            found += half * np.sum(weights * waves)
    return found / np.pi


@pytest.mark.one_in(5)
@pytest.mark.parametrize("law", sorted(LAWS))
def test_they_are_those_of_the_law_by_quadrature(law):
    scene = turn(law)
    found = harmonics(scene, ORDERS)
    assert found.mean == pytest.approx(by_quadrature(scene, 0, 0).real / 2, rel=1e-12)
    for order in found.order:
        wave = by_quadrature(scene, order, 0)
        same = found.displacement[order - 1] * np.exp(-1j * np.radians(found.phase_deg[order - 1]))
        assert abs(wave - same) < 1e-13 * 20


@pytest.mark.parametrize("law", sorted(LAWS))
def test_the_acceleration_has_each_times_the_square_of_its_order_impulses_included(law):
    """What a corner makes of the acceleration is an impulse: the uniform law has nothing else."""
    found = harmonics(turn(law, rpm=300), ORDERS)
    omega = 300 * 2 * np.pi / 60
    expected = found.displacement * (found.order * omega) ** 2 * 1e-3
    assert np.allclose(found.acceleration, expected, rtol=1e-9, atol=1e-10 * expected.max())
    assert (found.acceleration_unit, found.frequency_Hz[6]) == ("m/s²", pytest.approx(35.0))


def test_a_cosine_over_the_turn_has_one_harmonic():
    scene = turn("harmonic")
    whole = [{"segment": kind, "angle": 180, "lift": 20, "law": "harmonic"} for kind in ("rise", "return")]
    found = harmonics(scene.replace(motion=whole), 8)
    assert found.displacement.tolist() == pytest.approx([10.0, *[0.0] * 7], abs=1e-13)
    assert (found.displacement[1:] == 0.0).all()  # below ROUNDING
    assert found.phase_deg[0] == pytest.approx(180.0)
    assert found.mean == pytest.approx(10.0)
    assert ROUNDING < 1e-13


def test_the_mean_square_of_a_motion_is_that_of_its_harmonics():
    scene = turn("cycloidal", "poly345")
    found = harmonics(scene, 2000)
    angles = (np.arange(200_000) + 0.5) / 200_000 * 2 * np.pi
    whole = np.mean(resolve(scene).programme.tool.motion_at(angles)[0] ** 2)
    assert found.mean**2 + np.sum(found.displacement**2) / 2 == pytest.approx(whole, rel=1e-9)


def test_an_oscillating_follower_has_them_in_degrees():
    found = harmonics(camopt.find_scene("oscillating-roller"), 4)
    programme = resolve(found.scene).programme
    assert found.mean == pytest.approx(np.degrees(by_quadrature(found.scene, 0, 0).real / 2), rel=1e-12)
    assert programme.unit_in_mm_or_rad != 1.0
    assert found.acceleration_unit.startswith(("rad/s²", "deg/rad²"))


@pytest.mark.parametrize("orders", [0, -3, 10_001, 2.0, True])
def test_orders_that_are_none(orders):
    with pytest.raises(BadInput, match="a whole number from 1 to 10,000"):
        harmonics(turn("cycloidal"), orders)


def test_the_command(command):
    code, out, _ = command("harmonics", "bucket-valve", "--orders", "5", "--json", "--plot", "h.svg")
    told = json.loads(out)
    found = harmonics(camopt.find_scene("bucket-valve"), 5)
    assert (code, [each["order"] for each in told["harmonics"]]) == (0, [1, 2, 3, 4, 5])
    assert told["harmonics"] == json.loads(json.dumps(found.records()))
    assert Path("h.svg").stat().st_size > 1000
    code, _, err = command("harmonics", "--orders", "0")
    assert code == 2
    assert "--orders = 0: must be a whole number" in err
