"""Numbers next to a cusp, which doubles do not have: what is told of their error, against 60 digits."""

from functools import cache

import mpmath
import numpy as np
import pytest
from mpmath import fp, mp
from support import naive
from support.cams import FREE, cam_with

from camopt import Scene, evaluate
from camopt.scene.problem.problem import resolve_design
from camopt.scene.problem.rows import DesignRows
from camopt.solve.verdicts import certified_ranges

CUSPED = {"flat": 33.17488339964133, "offset-roller": 1.6679948460734322}
"""Base radii, mm, whose profiles have a radius of 1e-12 and 1e-9 mm somewhere."""
LARGE = 100.0
DIGITS, PLACES = 60, 50
USUAL_ERROR = 1e-9
NAMES = ["profile_radius_min_mm", "contact_stress_max_MPa"]


def load_over_radius(scene, ctx):
    """N/R at a cam angle, N/mm, where 1/R is the sum of both bodies' curvatures, and the radius of the profile."""
    speed, state = scene["cam"]["rpm"] * ctx.pi / 30, naive.geometry(scene, ctx)
    radius = scene["follower"].get("roller_radius")

    def at(angle, jet):
        y, y1, y2, _ = jet
        force = (
            FREE["mass"] * (speed**2 * y2 / 1000 + ctx.mpf(FREE["gravity"])) + ctx.mpf(FREE["damping"]) * speed * y1
        )
        force += FREE["spring_rate"] * y + FREE["preload"] + FREE["load"]
        seen = state(angle, jet)
        if radius is None:
            return force / seen["rho"], seen["rho"]
        bulge = seen["kappa"] * radius
        return force / ctx.cos(seen["beta"]) / (radius * (1 - bulge)), (1 - bulge) / seen["kappa"]

    return at


def worst(scene):
    """The largest N/R and the radius there: by golden sections about the best of a scan."""
    rough, pieces = load_over_radius(scene, fp), naive.programme(scene["motion"], fp)
    places = [
        (k, low + (high - low) * n / PLACES) for k, (low, high, *_) in enumerate(pieces) for n in range(PLACES + 1)
    ]
    k, near = max(places, key=lambda place: rough(place[1], pieces[place[0]][-1](place[1]))[0])
    with mp.workdps(DIGITS):
        low, high, *_, jet = naive.programme(scene["motion"], mp)[k]
        step, exact = (high - low) / PLACES, load_over_radius(scene, mp)
        _, there = naive.golden(lambda x: exact(x, jet(x))[0], max(low, near - step), min(high, near + step))
        return exact(there, jet(there))


def of_size(scene, base_radius):
    return {**scene, "cam": {**scene["cam"], "base_radius": base_radius}}


@cache
def evaluate_near_cusp(contact):
    """Quantities of a cam with a cusp, and one of the scene's own."""
    scene = cam_with(contact, outputs=NAMES, quantities={"mine": "contact_stress_max_MPa / 7"})
    return evaluate(Scene.from_dict(of_size(scene, CUSPED[contact])))


@pytest.mark.slow
@pytest.mark.parametrize("contact", CUSPED)
def test_stress_and_radius_next_to_a_cusp_are_as_near_to_those_of_60_digits_as_is_told(contact):
    """The stress grows with √(N/R): from that of a large cam, of which doubles have all digits."""
    scene = cam_with(contact, outputs=NAMES)
    near, large = (of_size(scene, size) for size in (CUSPED[contact], LARGE))
    (load, radius), (known, _) = map(worst, (near, large))
    found, other = evaluate_near_cusp(contact), evaluate(Scene.from_dict(large))
    stress = other["contact_stress_max_MPa"] * float(mpmath.sqrt(load / known))
    told = found["relative_half_width"]
    assert USUAL_ERROR < told < 1.0
    assert found["profile_radius_min_mm"] == pytest.approx(float(radius), rel=told)
    assert found["contact_stress_max_MPa"] == pytest.approx(stress, rel=told)


@pytest.mark.parametrize("contact", CUSPED)
def test_an_own_quantity_is_no_more_exact_than_what_it_reads(contact):
    found = evaluate_near_cusp(contact)
    assert found["mine"] == pytest.approx(found["contact_stress_max_MPa"] / 7, rel=1e-12)
    assert USUAL_ERROR < found["relative_half_width"] < 1.0


@pytest.mark.parametrize(("name", "worst"), [("contact_stress_max_MPa", max), ("profile_radius_min_mm", min)])
def test_a_range_of_two_contacts_has_the_worst_of_each_bound(name, worst, monkeypatch):
    """Of ranges that lie within each other, neither alone encloses the worst of both contacts."""
    problem = resolve_design(Scene.from_dict(cam_with("roller")))
    rows = DesignRows({name: np.array([3.0])}, 1, {name: np.array([1.0])})
    ranges = iter([(1.0, 5.0), (2.0, 3.0)])
    peak = certified_ranges.peaks_of_quantity(name, problem.setup)[0]
    monkeypatch.setattr(certified_ranges, "peaks_of_quantity", lambda *_: (peak, peak))
    monkeypatch.setattr(certified_ranges, "_certified_range", lambda *_: next(ranges))
    proved = certified_ranges._certified_ranges_by_quantity(problem, problem.design, rows, 1e-9)
    assert proved[name] == (worst(1.0, 2.0), worst(5.0, 3.0))
