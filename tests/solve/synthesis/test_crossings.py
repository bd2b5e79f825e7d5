"""Little jerk where the force turns round, with its bound, against flights between flanks and a scan of places."""

from dataclasses import replace

import numpy as np
import pytest

from camopt import Scene, evaluate, prices, synthesise
from camopt.core.mistakes import BadInput, Unmet
from camopt.scene.problem.problem import resolve
from camopt.solve.synthesis.convex_model import build_convex_model
from camopt.solve.synthesis.crossing_jerk import largest_jerk_after_crossings
from camopt.solve.synthesis.crossings import with_best_crossings_and_bound
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import tighten_limits

GAP, RPM = 0.05, 300
OMEGA = RPM * np.pi / 30


def groove_scene(window=20.0, **changes):
    rise = {"segment": "rise", "angle": 90, "lift": 20, "law": "cycloidal"}
    motion = [rise, {"segment": "dwell", "angle": 90}, {**rise, "segment": "return", "angle": 110}]
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 60, "rpm": RPM},
            "follower": {
                "motion": "translating",
                "contact": "roller",
                "roller_radius": 8,
                "dynamics": {"mass": 2},
            },
            "drive": {"kind": "groove", "clearance": GAP},
            "motion": [*motion, {"segment": "dwell", "angle": 70}],
            "limits": {"pressure_angle": 35},
            "synthesis": {"minimise": "crossing_jerk", "crossing_window": window, "pieces": 24},
            "outputs": ["clearance", "pressure"],
        }
    )
    return scene.replace(**changes)


@pytest.mark.long
def test_free_laws_land_softly_and_no_motion_has_less_jerk_there():
    scene = groove_scene()
    found = synthesise(scene)
    before, after = evaluate(scene), evaluate(found.scene)
    assert after["crossing_count"] == before["crossing_count"] == 2
    assert after["crossing_speed_max_m_s"] < 0.5 * before["crossing_speed_max_m_s"]
    along = GAP / np.cos(np.radians(35))
    least = 6.0 * along / np.radians(20) ** 3 * OMEGA**3 / 1e3  # in the whole window, at a constant jerk
    assert least * (1 - 1e-4) < found.bound <= found.objective < least * 1.01
    most = (4.5 * found.objective * 1e3 * along**2) ** (1 / 3) / 1e3
    assert after["crossing_speed_max_m_s"] <= most * 1.01
    assert after["crossing_time_max_ms"] <= np.radians(20.1) / OMEGA * 1e3
    assert prices(found) == {"free-rise / free-return": []}


@pytest.mark.long
def test_the_place_is_that_of_a_scan_where_the_window_is_not_all():
    """Wide windows: the jerk is low all along them, and the best place is where the motion has room for it."""
    problem = build_synthesis_problem(groove_scene(30.0, **{"synthesis.pieces": 12}))
    placed, bound = with_best_crossings_and_bound(problem)

    def solve_with_place(x):
        asked = replace(problem, crossings=(problem.stroke_crossing(0, x, x),))
        return build_convex_model(tighten_limits(asked, 1e-7), SplineMotion).solve()

    rise, _ = placed.crossings
    scanned = [solve_with_place(x) for x in np.arange(0.3, 0.6, 0.025)]
    assert solve_with_place(rise.low) <= min(scanned) * 1.01
    assert 0.0 < bound <= max(min(scanned), solve_with_place(rise.low))


@pytest.mark.parametrize(("law", "jerk"), [("cycloidal", 4 * np.pi**2), ("poly345", 30.0)])
def test_the_jerk_of_known_laws_is_that_in_the_middle(law, jerk):
    scene = groove_scene(**{"motion.1.law": law, "motion.3.law": law})
    unit = 20 / (np.pi / 2) ** 3
    assert largest_jerk_after_crossings(resolve(scene).programme, 1e-3) == pytest.approx(jerk * unit, rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"drive.clearance": None}, "needs drive.clearance"),
        ({"follower.dynamics.spring_rate": 3}, "without spring, damping and load"),
        ({"synthesis.rest": 1}, "at least 2"),
        ({"synthesis.crossing_window": 0}, "crossing_window"),
    ],
)
def test_what_has_no_such_crossing_is_told(changes, message):
    with pytest.raises(BadInput, match=message):
        synthesise(groove_scene(**changes))


@pytest.mark.slow
def test_a_window_that_is_too_narrow_is_told():
    with pytest.raises(Unmet, match="within 1 deg"):
        synthesise(groove_scene(1.0, **{"drive.clearance": 0.5}))
