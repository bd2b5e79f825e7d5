"""Clearance of a positive drive: flights of a roller between drawn walls, its spin by points, and its limits."""

from functools import cache
from math import pi

import numpy as np
import pandas as pd
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support.cams import cam_with, turn_of
from support.ribs import centres, rib

from camopt import BadInput, Scene, certify, evaluate, optimise, sweep
from camopt.core.numerics.curves import value_and_slope
from camopt.model.effects.clearance import flights_and_followers_by_setting, half_clearance_along_motion
from camopt.model.effects.effect import EvaluationBlock
from camopt.model.effects.flight import simulate_flights
from camopt.model.effects.loads import contact_load_curve
from camopt.model.mechanisms.geometry import cam_curves
from camopt.scene.problem.problem import resolve_design

FORMS = ("groove", "groove-arm", "offset-roller", "arm")
LAWS = ("cycloidal", "poly345", "modified-sine", "modified-trapezoid", "parabolic", "harmonic")
RIBS = {"rib-arm": "cylindrical", "rib-disc": "disc"}
CHECKED = 4
"""Cams of each form in short runs; 25 in long ones."""


def grooved_scene(form, seed, **drive):
    """A random cam with a groove, its loads and its clearance."""
    random, swings = np.random.default_rng([seed, FORMS.index(form)]), form.endswith("arm")
    law, sprung = LAWS[seed % len(LAWS)], seed % 2
    dynamics = {"mass": 0.8, "spring_rate": 2.0 * sprung, "damping": 0.02 * sprung, "load": random.uniform(-5, 5)}
    if swings:
        dynamics = {"inertia": 0.006, "spring_rate": 9.0 * sprung, "damping": 0.06 * sprung}
        dynamics["load"] = random.uniform(-0.5, 0.5)
    rise, fall = random.uniform(60, 130, 2)
    own = {"clearance": float(10 ** random.uniform(-2.5, -1.2)), "roller_inertia": 2e-6, "friction": 0.1, **drive}
    data = cam_with(form, law, dynamics, str(random.choice(["ccw", "cw"])), float(random.uniform(300, 700)))
    data |= {"drive": {"kind": "groove", **own}, "outputs": ["clearance"]}
    data["motion"] = turn_of(law, 10 if swings else 20, (rise, 30, fall, 330 - rise - fall))
    return Scene.from_dict(data)


@cache
def groove_problem(form, seed):
    """The problem of a groove, or of a rib between two swinging rollers on a cylinder or a disc."""
    return resolve_design(grooved_scene(form, seed) if form in FORMS else ribbed_scene(form, seed))


def ribbed_scene(form, seed):
    """A random rib between swinging rollers, its loads and its clearance."""
    random = np.random.default_rng(seed)
    data = {**rib(random, "oscillating", RIBS[form]), "outputs": ["clearance"]}
    data["follower"]["dynamics"] = {"inertia": 0.006, "load": random.uniform(-0.5, 0.5)}
    data["drive"]["clearance"] = float(10 ** random.uniform(-2.5, -1.2))
    return Scene.from_dict(data)


class Walls:
    """The walls of a groove by points at ±(R_r + j/2) from the pitch curve, and where a roller touches them."""

    def __init__(self, problem):
        setup = problem.setup
        self.problem, self.mechanism, self.design, self.turn = (
            problem,
            setup.mechanism,
            problem.design,
            problem.programme,
        )
        self.half, self.sense, self.angular = (
            setup.given.drive.clearance / 2,
            problem.design.sense,
            setup.angular,
        )
        self.developed = setup.mechanism.body.developed

    def centre(self, phi, side):
        """Where the roller's centre is in the cam's frame as it touches a wall beside the pitch curve at φ."""
        found = cam_curves(self.mechanism, self.design, self.turn, np.mod(phi, 2 * pi))
        around = 2 * pi * self.design.size[0] * np.floor(phi / (2 * pi)) if self.developed else 0.0
        return found.pitch + around + side * self.half * found.normal

    def beside(self, theta, phi, side):
        """How far that is from the way of the follower at a cam angle, and the displacement there."""
        z = self.centre(phi, side)
        l, lift = self.design.arm_length[0], self.turn.lift  # noqa: E741
        if self.developed:
            x, y = z.real - self.design.size[0] * theta, z.imag
            if not self.angular:
                return x, y
            swing = np.arcsin(y / l)
            return x + self.sense * l * (np.cos(swing) - np.cos(lift / 2)), swing + lift / 2
        z = z * np.exp(1j * self.sense * theta)
        start = self.mechanism.start(self.design)[0]
        if not self.angular:
            return z.real - self.design.offset[0], z.imag - start
        arm = self.design.centre_distance[0] - z
        return np.abs(arm) - l, -np.angle(arm) - start

    def from_follower(self, z, theta):
        """Points fixed in the cam's frame, or in its developed plane, as the follower sees them at a cam angle."""
        y = self.turn.motion_at(np.mod(theta, 2 * pi))[0]
        z = z - self.design.size[0] * theta if self.developed else z * np.exp(1j * self.sense * theta)
        if not self.angular:
            return z - 1j * y
        above = self.sense * self.design.arm_length[0] * np.cos(self.turn.lift / 2)
        pivot = above if self.developed else self.design.centre_distance[0]
        return (z - pivot) * np.exp((1j * self.sense if self.developed else 1j) * y)

    def touched(self, theta, side):
        """The displacement of a follower that touches a wall."""
        theta = np.asarray(theta, dtype=float)
        return self.beside(theta, self.place(theta, side), side)[1]

    def place(self, theta, side):
        """Where a follower at a cam angle touches a wall: the φ of that, by secants."""
        phi, other = theta, theta + 1e-4
        off, far = self.beside(theta, phi, side)[0], self.beside(theta, other, side)[0]
        for _ in range(5):
            step = np.where(far == off, 0.0, off * (other - phi) / np.where(far == off, 1.0, far - off))
            other, far, phi = phi, off, phi - step
            off = self.beside(theta, phi, side)[0]
        return phi


class Flanks(Walls):
    """The flanks of a rib at as much from the pitch curves of both rollers; that of the first is met going in."""

    def centre(self, phi, side):
        phi, place, step = np.atleast_1d(phi), int(side > 0), 1e-6
        low, here, high = (centres(self.problem, np.mod(phi, 2 * pi) + k * step)[place] for k in (-1.0, 0.0, 1.0))
        normal = 1j * (high - low) / np.abs(high - low) * (1.0 if self.developed else self.sense)
        around = 2 * pi * self.design.size[0] * np.floor(phi / (2 * pi)) if self.developed else 0.0
        return here + around + side * self.half * normal

    def beside(self, theta, phi, side):
        """Over a cylinder the middle of the arms counts, over a disc that of the first, the outer roller."""
        off, y = super().beside(theta, phi, side)
        half = np.arcsin(self.design.roller_spacing[0] / (2 * self.design.arm_length[0]))
        return off, y + half * (side if self.developed else 1 + side)


def flown(problem, walls, angle, side, jumps):
    """A flight from the wall that bears on one side: the speed of landing, mm/s (rad/s), and its time, s.

    Where the force jumps it begins as the follower touches the wall there; differences do not reach beyond that.
    """
    own, omega, step = problem.setup.dynamics, problem.setup.omega, 1e-4
    load = own.load + own.preload

    def force(theta):
        """What the wall gives, from its drawn points."""
        low, here, high = walls.touched(theta + step * np.array([-1.0, 0.0, 1.0]), -side)
        speed, bend = (high - low) / (2 * step), (high - 2 * here + low) / step**2
        return own.mass * omega**2 * bend + own.damping * omega * speed + own.stiffness * here + load

    near = 0.02

    def wall_or_force(theta):
        return float(walls.place(theta, -side)[0]) - angle if jumps else side * force(theta)

    left = brentq(wall_or_force, angle - near, angle + near, xtol=1e-12 if jumps else 1e-9)
    earlier, low, here = walls.touched(left + step * np.array([-2.0, -1.0, 0.0]), -side)
    start = [here, (3 * here - 4 * low + earlier) / (2 * step) * omega]

    def gap(time, state):
        return float(side * (state[0] - walls.touched([left + omega * time], side)[0]))

    def return_distance(time, state):
        """Above 0 before the follower is back at the wall that it left, but for rounding."""
        return float(side * (state[0] - walls.touched([left + omega * time], -side)[0])) + 1e-8

    gap.terminal, gap.direction = True, 1.0
    return_distance.terminal, return_distance.direction = True, -1.0
    found = solve_ivp(
        lambda time, state: [state[1], -(own.damping * state[1] + own.stiffness * state[0] + load) / own.mass],
        (0.0, pi / omega), start, events=(gap, return_distance), rtol=1e-10, atol=1e-13, max_step=0.02 / omega,
    )  # fmt: skip
    met = 0 if found.t_events[0].size else 1
    time, end = float(found.t_events[met][0]), left + omega * found.t_events[met][0]
    before, after = walls.touched(end + step * np.array([-1.0, 1.0]), side if met == 0 else -side)
    return abs(found.y_events[met][0, 1] - (after - before) / (2 * step) * omega), time


def check_flights(form, seed):
    """All crossings of a random cam, by a solver of differential equations with contacts by points."""
    problem = groove_problem(form, seed)
    case = EvaluationBlock(problem.setup, problem.programme, problem.design)
    walls = (Walls if form in FORMS else Flanks)(problem)
    flights, followers = flights_and_followers_by_setting(case)
    ends = simulate_flights(case.programme, followers, flights, half_clearance_along_motion(case))
    assert flights.angle.size >= 2
    checked = 0
    for k, (angle, side) in enumerate(zip(flights.angle, flights.side, strict=True)):
        jumps = flights.jump[k] != 0.0
        if np.any(np.abs(walls.turn.piece_starts - angle) < 0.02) and not jumps:
            continue  # it begins at the end of a dwell, where the force is 0 all along
        speed, time = flown(problem, walls, angle, side, jumps)
        checked += 1
        near = 2e-4 if not jumps else 1e-6 if form in FORMS else 2e-5  # flanks of ribs are drawn by differences
        assert ends.speed[k] * problem.setup.omega == pytest.approx(speed, rel=near)
        assert ends.length[k] / problem.setup.omega == pytest.approx(time, rel=near)
    assert checked


@pytest.mark.one_in(3)
@pytest.mark.parametrize("form", [*FORMS, *RIBS])
@pytest.mark.parametrize(
    "seed", [pytest.param(s, marks=[] if s < CHECKED else pytest.mark.long) for s in range(25)]
)
def test_a_follower_flies_as_it_does_between_drawn_walls(form, seed):
    check_flights(form, seed)


@pytest.mark.parametrize(("form", "seed"), [("rib-disc", 14), ("arm", 22)])
def test_a_flight_begins_where_a_jump_of_the_acceleration_reaches_the_flank(form, seed):
    """That at the rib lands where the next stroke has begun: from the jump itself it would be 2e-3 too fast."""
    check_flights(form, seed)


def test_a_jump_of_the_load_is_felt_at_once():
    """In a dwell of an arm whose pressure angle is not 0, where only a load jumps."""
    angles = dict(zip(("motion.1.angle", "motion.3.angle", "motion.4.angle"), (90.0, 100.0, 140.0), strict=True))
    rows = [[0, 9], [95, 9], [95, -9], [360, -9]]
    scene = grooved_scene("arm", 0).replace(**angles, **{"follower.dynamics.load": rows})
    problem = resolve_design(scene)
    case = EvaluationBlock(problem.setup, problem.programme, problem.design)
    flights, followers = flights_and_followers_by_setting(case)
    ends = simulate_flights(case.programme, followers, flights, half_clearance_along_motion(case))
    (k,) = np.flatnonzero(np.abs(flights.angle - np.radians(95.0)) < 1e-9)
    gap = problem.setup.given.drive.clearance / problem.design.arm_length[0]
    tangent = value_and_slope(
        problem.setup.mechanism.pressure(problem.design, problem.programme),
        0,
        problem.programme.state(np.radians([95.0])),
    )[0][0]
    acceleration = 9e3 / problem.setup.dynamics.mass / problem.setup.omega**2
    assert abs(tangent) > 0.1
    assert ends.length[k] == pytest.approx(np.sqrt(2 * gap * np.hypot(1, tangent) / acceleration), rel=1e-9)
    assert ends.angle[k] - flights.angle[k] == pytest.approx(ends.length[k], abs=1e-14)


@pytest.mark.parametrize(("law", "printed"), [("cycloidal", 41.4), ("parabolic", 56.6)])
def test_the_speed_of_landing_of_a_small_clearance_is_that_of_the_formula(law, printed):
    """300 rev/min, a rise of 20 mm in 90 deg, 0.05 mm; and in the limit of no clearance the flight itself."""
    data = cam_with("groove", law, {"mass": 1.0}, rpm=300, drive={"clearance": 0.05}, outputs=["clearance"])
    data["cam"]["mean_radius"] = 1e6  # no pressure angle
    data["motion"] = turn_of(law, 20, (90, 90, 90, 90))
    row = evaluate(Scene.from_dict(data))
    assert row["crossing_count"] == 2
    assert row["crossing_speed_leading_m_s"] * 1e3 == pytest.approx(printed, abs=0.05)
    off = []
    for clearance in (1e-3, 1e-6):
        row = evaluate(Scene.from_dict({**data, "drive": {"clearance": clearance}}))
        off.append(abs(row["crossing_speed_max_m_s"] / row["crossing_speed_leading_m_s"] - 1.0))
    assert off[1] < (1e-4 if law == "cycloidal" else 1e-9)
    assert off[1] <= 0.02 * off[0] + 1e-9  # as the clearance to the power ⅔


@pytest.mark.parametrize("form", ["groove", "offset-roller"])
def test_the_load_on_both_walls_has_the_digits_of_fifty(form):
    """N·(1/R_r ± κ) of walls at R_r + j/2 from the path of the roller, whose points are differentiated."""
    given = {"drive": {"kind": "groove", "clearance": 0.4}, "materials": {"cam": "steel", "follower": "steel"}}
    data = cam_with(form, "poly345", {"mass": 0.8}, rpm=500, **given)
    data["materials"]["face_width"] = 12
    problem = resolve_design(Scene.from_dict(data))
    setup, design, turn = problem.setup, problem.design, problem.programme
    first = turn.strokes[0]
    with mp.workdps(50):
        size, offset, radius = (mpf(float(x[0])) for x in (design.size, design.offset, design.roller_radius))
        start, sense = mp.sqrt((size + radius) ** 2 - offset**2), design.sense

        def lift(theta):
            x = theta / mpf(first.angle)
            return mpf(first.size) * (10 * x**3 - 15 * x**4 + 6 * x**5)

        def path(theta):
            if setup.mechanism.body.developed:
                return mp.mpc(size * theta, lift(theta))
            return mp.expj(-sense * theta) * mp.mpc(offset, start + lift(theta))

        def normal(theta):
            way = 1 if setup.mechanism.body.developed else sense
            along = mp.diff(path, theta)
            return way * mp.j * along / abs(along)

        for theta in map(mpf, ("0.3", "0.7", "1.1")):
            up = mp.j if setup.mechanism.body.developed else mp.j * mp.expj(-sense * theta)
            n = normal(theta)
            pushed = mpf("0.8e-3") * mpf(setup.omega) ** 2 * mp.diff(lift, theta, 2) / mp.re(mp.conj(n) * up)
            for flank in setup.mechanism.flanks:

                def wall(t, side=flank.side):
                    return path(t) + mpf(side) * (radius + mpf(0.4) / 2) * normal(t)

                along, bent = mp.diff(wall, theta), mp.diff(wall, theta, 2)
                hollow = mp.re(mp.conj(n) * bent) / abs(along) ** 2 * mpf(-flank.side)  # towards the roller
                exact = mpf(flank.pressing) * pushed * (1 / radius - hollow)
                made = contact_load_curve(setup, design, turn, flank)
                found = value_and_slope(made, 0, turn.state(np.array([float(theta)])))[0]
                assert float(found[0]) == pytest.approx(float(exact), rel=1e-11)


def test_a_wall_is_undercut_by_half_of_the_clearance():
    """Its least radius is smaller by half the clearance; below 0 it is undercut, and proved to be."""
    data = cam_with("groove", "poly345", {"mass": 0.8}, drive={"kind": "groove"}, outputs=["curvature"])
    tight = evaluate(Scene.from_dict(data))["profile_radius_min_mm"]
    data["follower"]["roller_radius"] += tight - 0.1  # on the same pitch curve
    for clearance, held in ((None, True), (0.2 - 1e-9, True), (0.2 + 1e-9, False)):
        scene = Scene.from_dict({**data, "drive": {"kind": "groove", "clearance": clearance}})
        row = evaluate(scene)
        assert row["profile_radius_min_mm"] == pytest.approx(0.1 - (clearance or 0.0) / 2.0, abs=1e-12)
        assert (row["undercut"], certify(scene)["undercut"]) == ((False, "held") if held else (True, "broken"))


def spin_rate(walls, theta, k, step=1e-5):
    """Spin of a roller that rolls on a wall, seen from its arm, by points of the wall [rad/rad]."""
    touched = cam_curves(walls.mechanism, walls.design, walls.turn, theta)
    before, after = (walls.from_follower(touched.profile[k], theta + side * step) for side in (-1.0, 1.0))
    arm = walls.from_follower(touched.profile[k] - touched.pitch, theta) - walls.from_follower(
        0.0 * touched.pitch, theta
    )
    return ((after - before) / (2 * step) / (1j * arm)).real


@pytest.mark.parametrize("form", FORMS)
def test_the_spin_of_a_roller_turns_round_and_slips_as_points_of_both_walls_say(form):
    problem, scene = groove_problem(form, 0), grooved_scene(form, 0, clearance=1e-9)
    walls, omega, radius = Walls(problem), problem.setup.omega, problem.design.roller_radius[0]
    row = evaluate(scene)
    flights, _ = flights_and_followers_by_setting(EvaluationBlock(problem.setup, problem.programme, problem.design))
    one, other = (omega * spin_rate(walls, flights.angle, k) for k in (0, 1))
    assert np.all(one * other < 0.0)
    change = np.abs(other - one).max()
    assert row["roller_spin_change_max_rpm"] == pytest.approx(change * 30 / pi, rel=1e-4)
    assert row["slip_speed_max_m_s"] == pytest.approx(change * radius / 1e3, rel=1e-4)
    if not walls.developed:
        surface = evaluate(scene.replace(outputs=["surface"]))
        most = max(np.abs(spin_rate(walls, np.linspace(0.01, 6.27, 2000), k)).max() for k in (0, 1))
        assert surface["roller_speed_max_rpm"] == pytest.approx(most * omega * 30 / pi, rel=1e-4)
    step, angles = 1e-3, np.linspace(0.01, 6.27, 700)
    inside = angles[np.abs(walls.turn.piece_starts[:, None] - angles).min(axis=0) > 2 * step]
    rates = [
        np.abs(spin_rate(walls, inside + step, k) - spin_rate(walls, inside - step, k)).max() / (2 * step)
        for k in (0, 1)
    ]
    found = row["roller_angular_acceleration_max_rad_s2"] / omega**2
    assert max(rates) == pytest.approx(found, rel=0.03)
    assert found >= max(rates) * (1 - 1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_a_roller_skids_until_friction_has_turned_it(form):
    """∫μ·N·R_r dt by a rule of quadrature over the drawn force, from the landing on."""
    problem = groove_problem(form, 0)
    setup, turn, design = problem.setup, problem.programme, problem.design
    case, omega, radius = EvaluationBlock(setup, turn, design), setup.omega, design.roller_radius[0]
    flights, followers = flights_and_followers_by_setting(case)
    ends = simulate_flights(turn, followers, flights, half_clearance_along_motion(case))
    own, lever, times = setup.dynamics, design.arm_length[0] if setup.angular else 1.0, []
    for k in range(flights.angle.size):

        def normal(theta, k=k):
            y, y1, y2, _ = turn.motion_at(np.mod(np.atleast_1d(theta), 2 * pi))
            load = own.mass * omega**2 * y2 + own.damping * omega * y1 + own.stiffness * y + own.load + own.preload
            tangent = value_and_slope(setup.mechanism.pressure(design, turn), 0, turn.state(ends.angle[k : k + 1]))[
                0
            ]
            return -flights.side[k] * load / lever * np.sqrt(1 + tangent**2)

        slip = (
            2
            * omega
            * value_and_slope(
                setup.mechanism.trace_speed_curve_maker(design, turn), 0, turn.state(ends.angle[k : k + 1])
            )[0][0]
        )
        needed = 2e-6 * 1e3 * slip / radius / (0.1 * radius)  # t·mm², N·s
        grid = ends.angle[k] + np.linspace(0.0, 2.5, 200_001)
        impulse = (
            np.concatenate([[0.0], np.cumsum(0.5 * np.diff(grid) * (normal(grid)[1:] + normal(grid)[:-1]))]) / omega
        )
        done = np.flatnonzero(impulse >= needed)
        pushed_off = np.flatnonzero(normal(grid) < -1e-9)
        stays = not pushed_off.size or (done.size and done[0] < pushed_off[0])
        times.append((grid[done[0]] - ends.angle[k]) / omega if done.size and stays else np.inf)
    assert evaluate(grooved_scene(form, 0))["skidding_time_max_ms"] == pytest.approx(max(times) * 1e3, rel=2e-4)


def test_limits_on_crossings_are_held_up_to_what_is_reached_and_no_further():
    scene = grooved_scene("arm", 0)
    row = evaluate(scene)
    keys = {
        "crossing_speed": "crossing_speed_max_m_s",
        "slip_speed": "slip_speed_max_m_s",
        "roller_angular_acceleration": "roller_angular_acceleration_max_rad_s2",
    }
    for key, name in keys.items():
        for share, said in ((1 + 1e-9, "held"), (1 - 1e-9, "broken")):
            limited = scene.replace(**{f"limits.{key}": row[name] * share})
            assert certify(limited)[key] == said
            assert evaluate(limited)["violated"] == ("" if said == "held" else key)


def test_a_smallest_cam_holds_the_speed_of_its_crossings():
    """By a dense scan: a smaller groove has larger pressure angles, and so a wider gap along the motion."""
    scene = grooved_scene("arm", 0).replace(**{"search.base_radius": {"start": 40, "stop": 120, "step": 1}})
    most = evaluate(scene.replace(**{"cam.base_radius": 80.0}))["slip_speed_max_m_s"]
    limited = scene.replace(**{"limits.slip_speed": most, "limits.pressure_angle": 60})
    best = optimise(limited).best
    sizes = np.linspace(40.0, 120.0, 161).tolist()
    held = next(s for s in sizes if evaluate(limited.replace(**{"cam.base_radius": s}))["feasible"])
    assert held - 0.5 <= best["base_radius_mm"] <= held + 1e-9


def test_a_sweep_over_clearances_has_what_each_scene_has(tmp_path):
    scene, rollers, clearances = grooved_scene("groove", 1), [5.0, 6.0], [0.01, 0.03]
    free = {"search.drive.clearance": clearances, "search.roller_radius": rollers}
    scene = scene.replace(**{"limits.curvature_radius": 1.0})
    sweep(scene.replace(**free), tmp_path, keep="all")
    found = pd.read_parquet(tmp_path / "designs.parquet")
    assert len(found) == 4
    names = ["crossing_speed_max_m_s", "crossing_time_max_ms", "slip_speed_max_m_s", "skidding_time_max_ms"]
    names.append("profile_radius_min_mm")
    for _, row in found.iterrows():
        own = {"drive.clearance": row["clearance_mm"], "follower.roller_radius": row["roller_radius_mm"]}
        alone = evaluate(scene.replace(**own))
        assert [row[name] for name in names] == pytest.approx([alone[name] for name in names], rel=1e-11)


def test_a_follower_that_is_pressed_on_one_wall_crosses_nowhere():
    row = evaluate(grooved_scene("groove", 0).replace(**{"follower.dynamics.preload": 1e4}))
    assert {
        row[n] for n in ("crossing_count", "crossing_speed_max_m_s", "crossing_at_deg", "slip_speed_max_m_s")
    } == {0.0}


def test_what_a_quantity_of_a_crossing_lacks_is_told():
    scene = grooved_scene("groove", 0)
    for key, name in (("clearance", "crossing_speed_max_m_s"), ("friction", "skidding_time_max_ms")):
        with pytest.raises(BadInput, match=f"{name}.*drive.{key}"):
            evaluate(scene.replace(**{f"drive.{key}": None, "limits": {name: 1.0}}))
    open_cam = {**cam_with("roller"), "drive": {"clearance": 0.02}}
    with pytest.raises(BadInput, match=r"drive.clearance = 0.02: a spring has none"):
        Scene.from_dict(open_cam)
    cornered = evaluate(scene.replace(**{"motion.1.law": "uniform", "motion.3.law": "uniform"}))
    assert cornered["crossing_speed_max_m_s"] == np.inf


def test_a_flight_back_to_the_same_wall_is_no_crossing():
    """A load that briefly changes sign: the roller lifts off twice, and lands on the same wall with its spin."""
    motion = [
        {"segment": "rise", "angle": 120, "lift": 24, "law": "modified-sine"},
        {"segment": "dwell", "angle": 60},
        {"segment": "return", "angle": 120, "lift": 24, "law": "modified-sine"},
        {"segment": "dwell", "angle": 60},
    ]
    follower = {"motion": "oscillating", "contact": "roller", "roller_radius": 15, "arm_length": 90}
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "rotation": "ccw", "rpm": 300, "base_radius": 48.13},
            "follower": {**follower, "centre_distance": 130, "dynamics": {"inertia": 0.05, "load": 26}},
            "drive": {"kind": "groove", "clearance": 0.05},
            "motion": motion,
            "outputs": ["clearance"],
        }
    )
    row = evaluate(scene)
    assert (row["crossing_count"], row["slip_speed_max_m_s"], row["roller_spin_change_max_rpm"]) == (0.0, 0.0, 0.0)
    assert 0.0 < row["crossing_speed_max_m_s"] < 1e-3  # of the landings
    assert evaluate(scene.replace(**{"follower.dynamics.load": 0}))["crossing_count"] == 2.0
    with pytest.raises(
        BadInput, match=r"drive.clearance = 40.0: must be at most a tenth of the roller's radius \(1.5\)"
    ):
        scene.replace(**{"drive.clearance": 40.0})
