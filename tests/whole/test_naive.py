"""The reference of naive.py against worked examples, closed forms, quadrature and brute force."""

import json
import random
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from support import naive, oracle

DATA = Path(__file__).parents[1] / "data"
EXAMPLES = json.loads((DATA / "worked-examples.json").read_text())
REFERENCE = {entry["id"]: entry for entry in json.loads((DATA / "reference.json").read_text())}
LAW_TABLES = json.loads((DATA / "laws.json").read_text())

Scene = dict[str, Any]

# of naive.py and its data alone, minutes: in the ordinary run only if they are not what last passed (``oracle``)
settled = pytest.mark.long if oracle.tests_have_passed() else lambda test: test

# the scenes at whose random points the closed forms are checked: no corners, or they have no curvature
SMOOTH = sorted(name for name, e in REFERENCE.items() if "profile_radius_min_mm" in e["expected"])
DISCS = [name for name in SMOOTH if REFERENCE[name]["scene"]["cam"]["form"] == "disc"]


@pytest.fixture(autouse=True)
def fifty_digits():
    """Every check at the precision of the reference."""
    with mp.workdps(naive.DPS):
        yield


def approx_value(value: Any, expected: Any, rel: float) -> bool:
    """Equal to a relative tolerance (absolute below 1)."""
    return abs(mp.mpf(value) - mp.mpf(expected)) <= rel * max(abs(mp.mpf(expected)), mp.mpf(10) ** -30)


def example_scene(example: Scene) -> Scene:
    """A worked example in the shape of a scene."""
    given = example["scene"]
    motion, contact = given["follower"].split("-")
    cam = {"form": "disc"} | {k: given[k] for k in ("base_radius", "rotation", "rpm") if k in given}
    keys = ("roller_radius", "offset", "arm_length", "centre_distance")
    follower = {"motion": motion, "contact": contact} | {k: given[k] for k in keys if k in given}
    tables = [dict(zip(("segment", "angle", "law", "lift"), seg, strict=True)) for seg in given["segs"]]
    return {"cam": cam, "follower": follower, "motion": tables}


# ---------------------------------------------------------------------------------------- worked examples


@settled
@pytest.mark.parametrize("name", EXAMPLES)
def test_worked_example(name: str) -> None:
    got = naive.evaluate(example_scene(EXAMPLES[name]))
    for key, value in EXAMPLES[name]["expected"].items():
        if isinstance(value, bool):
            assert got[key] is value
        else:
            assert approx_value(got[key], value, 1e-13), key


# --------------------------------------------------------------------------------------------------- laws


def test_there_are_fifteen_examples_and_every_law_and_mechanism() -> None:
    assert len(EXAMPLES) == 15
    assert len(REFERENCE) >= 64
    assert set(LAW_TABLES) == set(naive.LAWS)


@pytest.mark.parametrize("law", naive.LAWS)
def test_law_runs_from_0_to_1_and_joins(law: str) -> None:
    pieces = naive.law_pieces(law)
    assert pieces[0][0] == 0
    assert pieces[-1][1] == 1
    assert abs(pieces[0][2](mp.zero)[0]) < 1e-45
    assert abs(pieces[-1][2](mp.one)[0] - 1) < 1e-45
    for (_, end, left), (start, _, right) in pairwise(pieces):
        assert end == start
        # inside a modified law the waves meet at their crests: even the jerk (0 there) is continuous
        for k in range(2 if law == "parabolic" else 3 if law.endswith("constant-velocity") else 4):
            assert abs(left(end)[k] - right(start)[k]) < 1e-45
    if law != "uniform" and not law.startswith("half"):
        assert abs(pieces[0][2](mp.zero)[1]) < 1e-45
        assert abs(pieces[-1][2](mp.one)[1]) < 1e-45


@settled
@pytest.mark.parametrize("law", naive.LAWS)
def test_law_derivatives_are_derivatives(law: str) -> None:
    for x0, x1, jet in naive.law_pieces(law):
        x = x0 + (x1 - x0) * mp.mpf("0.37")
        for k in range(3):
            with mp.workdps(2 * naive.DPS):
                slope = mp.diff(lambda t, jet=jet, k=k: jet(t)[k], x)
            assert abs(slope - jet(x)[k + 1]) < 1e-25
        assert abs(mp.quad(lambda t, jet=jet: jet(t)[1], [x0, x1]) - (jet(x1)[0] - jet(x0)[0])) < 1e-40


def test_a_polynomial_by_conditions_has_the_powers_in_print() -> None:
    """Kloomok and Muffley's eighth-power polynomial; its two decimal conditions are rounded to binary."""
    powers = {3: "6.09755", 5: "-20.78040", 6: "26.73155", 7: "-13.60965", 8: "2.56095"}
    for x in (mp.mpf("0.2"), mp.mpf("0.7"), mp.mpf(1)):
        expected = sum(mp.mpf(c) * x**n for n, c in powers.items())
        assert abs(naive.law_at("poly8", x)[0] - expected) < 1e-14


@pytest.mark.parametrize("law", ["harmonic", "cycloidal"])
def test_half_laws_are_the_halves_of_a_law(law: str) -> None:
    name = {"harmonic": "half-harmonic", "cycloidal": "half-cycloidal"}[law]
    for x in (mp.mpf(0), mp.mpf("0.21"), mp.mpf("0.83"), mp.mpf(1)):
        for half in (0, 1):
            found = naive.law_at(f"{name}-{half + 1}", x)
            whole = naive.law_at(law, (x + half) / 2)
            expected = [2 * whole[0] - half, *(value * 2 / mp.mpf(2) ** k for k, value in enumerate(whole) if k)]
            assert all(abs(a - b) < 1e-45 for a, b in zip(found, expected, strict=True))


@settled
@pytest.mark.parametrize("law", naive.SCCA)
def test_modified_law_is_its_definition(law: str) -> None:
    """The acceleration drawn by hand, integrated by quadrature, scaled to s(1) = 1."""

    def shape(x: Any) -> Any:
        x, sign = (x, 1) if x <= 0.5 else (1 - x, -1)
        if law == "cycloidal-constant-velocity":
            return sign * (mp.sin(4 * mp.pi * x) if x <= 0.25 else 0)
        if law == "modified-constant-velocity":
            ramp = mp.sin(8 * mp.pi * x) if x <= 0.0625 else mp.cos(8 * mp.pi / 3 * (x - 0.0625))
            return sign * (ramp if x <= 0.25 else 0)
        if x <= 0.125:
            return sign * mp.sin(4 * mp.pi * x)
        if law == "modified-sine":
            return sign * mp.sin(mp.pi / 2 + (x - 0.125) * 4 * mp.pi / 3)
        return sign * (1 if x <= 0.375 else mp.cos(4 * mp.pi * (x - 0.375)))

    knots = [mp.mpf(k) / 16 for k in (0, 1, 2, 4, 6, 8, 10, 12, 14, 15, 16)]
    # s(1) = integral of (1 - x) a(x)
    total = mp.quad(lambda x: (1 - x) * shape(x), knots)
    for x in (mp.mpf("0.06"), mp.mpf("0.3"), mp.mpf("0.44"), mp.mpf("0.6"), mp.mpf("0.7"), mp.mpf("0.93")):
        s, v, a, _ = naive.law_at(law, x)
        upto = [k for k in knots if k < x] + [x]
        assert abs(a - shape(x) / total) < 1e-40
        assert abs(v - mp.quad(shape, upto) / total) < 1e-40
        assert abs(s - mp.quad(lambda t, x=x: (x - t) * shape(t), upto) / total) < 1e-40


@settled
def test_law_peaks_have_their_closed_forms() -> None:
    pi, r3 = mp.pi, mp.sqrt(3)
    A, B = 8 * pi / (2 + pi), 4 * pi**2 / (4 + pi)
    whole = 1 + B / pi  # of half a stroke at the modified sine's largest velocity, B/pi, and the rest
    expected = {
        "uniform": (1, mp.inf, mp.inf),
        "parabolic": (2, 4, mp.inf),
        "harmonic": (pi / 2, pi**2 / 2, mp.inf),
        "cycloidal": (2, 2 * pi, 4 * pi**2),
        "poly345": (mp.mpf(15) / 8, 10 / r3, 60),
        "poly4567": (mp.mpf(35) / 16, 84 / (5 * mp.sqrt(5)), mp.mpf(105) / 2),
        "modified-trapezoid": (2, A, 4 * pi * A),
        "modified-sine": (B / pi, B, 4 * pi * B),  # of the quarter waves: B/(4 pi) + 3 B/(4 pi)
        "modified-constant-velocity": (2 * B / pi / whole, 4 * B / whole, 32 * pi * B / whole),
        "cycloidal-constant-velocity": (mp.mpf(4) / 3, 8 * pi / 3, 32 * pi**2 / 3),
        "half-cycloidal-1": (2, mp.inf, mp.inf),
        "half-cycloidal-2": (2, mp.inf, mp.inf),
        "half-harmonic-1": (pi / 2, mp.inf, mp.inf),
        "half-harmonic-2": (pi / 2, mp.inf, mp.inf),
    }
    for law, peaks in expected.items():
        for got, want in zip(naive.law_peaks(law), peaks, strict=True):
            assert got == want or abs(got - want) < 1e-40, law


@settled
@pytest.mark.parametrize("law", naive.LAWS)
def test_law_table_is_current(law: str) -> None:
    table = LAW_TABLES[law]
    assert 35 <= len(table["points"]) <= 60
    for point in table["points"]:
        jet = naive.law_at(law, mp.mpf(point["x"]))
        for key, value in zip("svaj", jet, strict=True):
            assert abs(value - mp.mpf(point[key])) <= 1e-24 * abs(value) + 1e-44
    for key, value in zip("vaj", naive.law_peaks(law), strict=True):
        assert value == mp.mpf(table["peaks"][key]) or approx_value(table["peaks"][key], value, 1e-24)


# ---------------------------------------------------------------------------------------------- geometry


def random_points(scene: Scene, n: int = 4) -> list[tuple[Any, naive.Jet, naive.Piece]]:
    """Random (theta, jet, piece) inside pieces of each kind, the same on every run."""
    chance = random.Random(scene["name"])
    pieces = naive.programme(scene["motion"], oscillating=scene["follower"]["motion"] == "oscillating")
    out = []
    for piece in chance.sample(pieces, min(n, len(pieces))):
        theta = piece.start + (piece.end - piece.start) * mp.mpf(chance.uniform(0.05, 0.95))
        out.append((theta, piece.jet(theta), piece))
    return out


def disc_translating(scene: Scene, jet: naive.Jet) -> tuple[Any, Any]:
    """tan beta and kappa of the mechanics sheet, trace-point disc cam, translating."""
    y, y1, y2, _ = jet
    e = -naive.spin(scene) * mp.mpf(scene["follower"].get("offset", 0))
    R_p = mp.mpf(scene["cam"]["base_radius"]) + naive.follower_radius(scene)
    s, w = mp.sqrt((R_p - e) * (R_p + e)) + y, y1 - e
    return w / s, (s**2 + w * (2 * y1 - e) - s * y2) / mp.sqrt(s**2 + w**2) ** 3


def disc_oscillating(scene: Scene, jet: naive.Jet) -> tuple[Any, Any]:
    """tan beta and kappa of the mechanics sheet, trace-point disc cam, oscillating."""
    y, y1, y2, _ = jet
    c, arm = mp.mpf(scene["follower"]["centre_distance"]), mp.mpf(scene["follower"]["arm_length"])
    R_p = mp.mpf(scene["cam"]["base_radius"]) + naive.follower_radius(scene)
    psi = mp.acos((c**2 + arm**2 - R_p**2) / (2 * c * arm)) + y
    q, C, S = 1 - naive.spin(scene) * y1, mp.cos(psi), mp.sin(psi)
    bend = arm**2 * q**3 + c**2 - c * arm * C * q * (1 + q) - c * arm * y2 * S
    return (arm * q - c * C) / (c * S), bend / mp.sqrt(arm**2 * q**2 + c**2 - 2 * c * arm * q * C) ** 3


def cylinder(scene: Scene, jet: naive.Jet) -> tuple[Any, Any]:
    """tan beta and kappa of a cylindrical cam; oscillating: of x = R_m theta -/+ l cos psi, y = l sin psi."""
    y, y1, y2, _ = jet
    R_m = mp.mpf(scene["cam"]["mean_radius"])
    if scene["follower"]["motion"] == "translating":
        return y1 / R_m, y2 / R_m**2 / mp.sqrt(1 + (y1 / R_m) ** 2) ** 3
    arm, upper = mp.mpf(scene["follower"]["arm_length"]), -naive.spin(scene)
    psi = y - naive.swing_middle(scene)
    C, S = mp.cos(psi), mp.sin(psi)
    dx, dy = R_m + upper * arm * S * y1, arm * C * y1
    ddx, ddy = upper * arm * (C * y1**2 + S * y2), arm * (C * y2 - S * y1**2)
    tangent = upper * S / C + arm * y1 / (R_m * C)
    return tangent, (dx * ddy - dy * ddx) / mp.sqrt(dx**2 + dy**2) ** 3


def flat(scene: Scene, jet: naive.Jet) -> tuple[Any, Any, Any]:
    """tan beta, rho and reach of the mechanics sheet, flat faces."""
    y, y1, y2, _ = jet
    follower, R_b = scene["follower"], mp.mpf(scene["cam"]["base_radius"])
    if follower["motion"] == "translating":
        e = -naive.spin(scene) * mp.mpf(follower.get("offset", 0))
        return mp.zero, R_b + y + y2, y1 - e
    c, f = mp.mpf(follower["centre_distance"]), mp.mpf(follower["face_offset"])
    psi, p = mp.asin((R_b - f) / c) + y, -naive.spin(scene) * y1
    C, S = mp.cos(psi), mp.sin(psi)
    t = c * C / (1 + p)
    return f / t, f + c * (S * (1 + 2 * p) / (1 + p) ** 2 + C * y2 / (1 + p) ** 3), t


@settled
@pytest.mark.parametrize("name", SMOOTH)
def test_closed_forms_at_random_points(name: str) -> None:
    scene = REFERENCE[name]["scene"]
    cylindrical = scene["cam"]["form"] == "cylindrical"
    oscillating = scene["follower"]["motion"] == "oscillating"
    state = naive.geometry(scene)
    for theta, jet, _ in random_points(scene):
        got = state(theta, jet)
        if scene["follower"]["contact"] == "flat":
            tangent, rho, reach = flat(scene, jet)
            assert abs(got["rho"] - rho) < 1e-45 * 1000
            assert abs(got["reach"] - reach) < 1e-45 * 1000
        else:
            closed = cylinder if cylindrical else disc_oscillating if oscillating else disc_translating
            tangent, kappa = closed(scene, jet)
            assert abs(got["kappa"] - kappa) < 1e-45
        assert abs(mp.tan(got["beta"]) - tangent) < 1e-45


@settled
@pytest.mark.parametrize("name", [n for n in SMOOTH if "flat" not in n])
def test_curve_derivatives_are_derivatives(name: str) -> None:
    scene = REFERENCE[name]["scene"]
    curve = naive.developed_curve if scene["cam"]["form"] == "cylindrical" else naive.pitch_curve
    for theta, jet, piece in random_points(scene, 2):
        p = curve(scene, mp, theta, jet)
        for k in (1, 2):
            with mp.workdps(2 * naive.DPS):
                slope = mp.diff(lambda t, piece=piece, k=k: curve(scene, mp, t, piece.jet(t))[k - 1], theta)
            assert abs(slope - p[k]) < 1e-25 * 1000


@settled
@pytest.mark.parametrize("name", [n for n in SMOOTH if "flat" in n])
def test_flat_envelope_touches_its_lines(name: str) -> None:
    """The contact's path is tangent to the face, and its radius of curvature is that of the path itself."""
    scene = REFERENCE[name]["scene"]
    sigma = naive.spin(scene)

    def contact(t: Any, piece: naive.Piece) -> Any:
        return naive.flat_face(scene, mp, t, piece.jet(t))["P"] * mp.expj(sigma * t)

    for theta, jet, piece in random_points(scene, 2):
        face = naive.flat_face(scene, mp, theta, jet)
        with mp.workdps(2 * naive.DPS):
            p1 = mp.diff(lambda t, piece=piece: contact(t, piece), theta)
            p2 = mp.diff(lambda t, piece=piece: contact(t, piece), theta, 2)
        ground = mp.expj(-sigma * theta)
        assert abs((p1 * ground * mp.conj(face["u"])).real) < 1e-20
        # a path run backwards (undercut) keeps its curvature's size and changes its sign
        assert abs(abs(1 / naive.curvature(p1, p2)) - abs(face["rho"])) < 1e-18 * abs(face["rho"])


def test_face_touches_a_circle_at_rest() -> None:
    """On the dwell a flat face lies on the base circle, whose radius is the radius of curvature."""
    for name in ("disc-translating-flat-cycloidal", "disc-oscillating-flat-cycloidal"):
        scene = REFERENCE[name]["scene"]
        y = mp.zero
        face = naive.flat_face(scene, mp, mp.one, (y, y, y, y))
        assert abs(abs(face["P"]) - scene["cam"]["base_radius"]) < 1e-45
        assert abs(face["rho"] - scene["cam"]["base_radius"]) < 1e-45


# ---------------------------------------------------------------------------------------------- extremes


def test_refine_finds_maxima_near_an_end_and_of_high_order() -> None:
    def g(x: Any) -> Any:
        return -((x - mp.mpf("1e-5")) ** 2)

    def quartic(x: Any) -> Any:
        return 1 - (x - mp.mpf("0.31")) ** 4

    nodes = [mp.mpf(k) / 100 for k in range(101)]
    for f, where in ((g, "1e-5"), (quartic, "0.31")):
        top, at = naive.piece_peak(f, nodes, [float(f(x)) for x in nodes])
        assert abs(top - f(mp.mpf(where))) < 1e-25
        assert abs(at - mp.mpf(where)) < 1e-12


@settled
@pytest.mark.parametrize("name", REFERENCE)
def test_reference_is_current(name: str) -> None:
    got = naive.evaluate(REFERENCE[name]["scene"])
    assert set(got) == set(REFERENCE[name]["expected"])
    for key, value in REFERENCE[name]["expected"].items():
        if isinstance(value, bool):
            assert got[key] is value
        elif value == "inf":
            assert got[key] == mp.inf
        else:
            assert abs(got[key] - mp.mpf(value)) <= 1e-24 * abs(mp.mpf(value)) + 1e-40, key


@settled
@pytest.mark.parametrize("name", REFERENCE)
def test_no_sample_beats_an_extreme(name: str) -> None:
    """Brute force in floats, at other places than the scan's: never above, and close below."""
    scene, expected = REFERENCE[name]["scene"], REFERENCE[name]["expected"]
    pieces = naive.programme(scene["motion"], naive.fp, scene["follower"]["motion"] == "oscillating")
    state = naive.geometry(scene, naive.fp)
    rows = []
    for p in pieces:
        for k in range(738):
            t = p.start + (p.end - p.start) * min(max((k - 0.37) / 736, 0.0), 1.0)
            jet = p.jet(t)
            rows.append((p.kind, state(t, jet) | naive.motion_state(t, jet)))
    beta = {kind: max(abs(r["beta"]) for k, r in rows if kind in (k, "")) for kind in ("rise", "return", "")}
    found = {f"pressure_angle_max_{kind}_deg".replace("__", "_"): np.degrees(value) for kind, value in beta.items()}
    if "pitch_curvature_max_per_mm" in expected:
        found["pitch_curvature_max_per_mm"] = max(r["kappa"] for _, r in rows)
        found["pitch_curvature_min_per_mm"] = min(r["kappa"] for _, r in rows)
    elif "face_reach_max_mm" in expected:
        found["face_reach_max_mm"] = max(r["reach"] for _, r in rows)
        found["face_reach_min_mm"] = min(r["reach"] for _, r in rows)
        found["profile_radius_min_mm"] = min(r["rho"] for _, r in rows)
    for order, key in enumerate(naive.DERIVATIVES, 1):
        unit, factor = naive.motion_unit(scene, order)
        for kind in ("rise", "return"):
            top = max(abs(r[key]) for k, r in rows if k == kind)
            found[f"{key}_max_{kind}_{unit}"] = top * float(factor)
    for key, sampled in found.items():
        if expected[key] != "inf":
            # where parts cancel, an extreme is small beside the opposite one
            size = max(abs(sampled), abs(found.get(key.replace("_min_", "_max_"), 0.0)))
            assert sampled == pytest.approx(float(expected[key]), rel=0, abs=1e-4 * size + 1e-9), key
            if "min" in key:
                assert sampled >= float(expected[key]) - 1e-11 * abs(sampled) - 1e-12, key
            else:
                assert sampled <= float(expected[key]) + 1e-11 * abs(sampled) + 1e-12, key


@settled
@pytest.mark.parametrize("name", [n for n in REFERENCE if "pressure_angle_max_at_deg" in REFERENCE[n]["expected"]])
def test_pitch_point_has_the_largest_pressure_angle(name: str) -> None:
    """At the reported cam angle, on one side of it at least, |beta| is the maximum over the turn."""
    scene, expected = REFERENCE[name]["scene"], REFERENCE[name]["expected"]
    state = naive.geometry(scene)
    theta = mp.mpf(expected["pressure_angle_max_at_deg"]) * mp.pi / 180
    here = [
        abs(state(theta, p.jet(theta))["beta"]) * 180 / mp.pi
        for p in naive.programme(scene["motion"], oscillating=scene["follower"]["motion"] == "oscillating")
        if p.start - 1e-20 <= theta <= p.end + 1e-20
    ]
    assert any(approx_value(value, expected["pressure_angle_max_deg"], 1e-22) for value in here)


# ------------------------------------------------------------------------------- whole profiles, in floats


def profile(scene: Scene, n: int = 900) -> np.ndarray:
    """Points of the profile of a disc cam, evenly in the cam angle, as complex numbers."""
    fp, sigma = naive.fp, naive.spin(scene)
    R_r = naive.follower_radius(scene, fp) if scene["follower"]["contact"] != "flat" else 0.0
    points = []
    pieces = naive.programme(scene["motion"], fp, scene["follower"]["motion"] == "oscillating")
    for k in range(n):
        theta = 2 * np.pi * (k + 0.5) / n
        piece = next(p for p in pieces if theta <= p.end)
        jet = piece.jet(theta)
        if scene["follower"]["contact"] == "flat":
            points.append(naive.flat_face(scene, fp, theta, jet)["P"] * fp.expj(sigma * theta))
        else:
            p, p1, _, _ = naive.pitch_curve(scene, fp, theta, jet)
            points.append(p - R_r * p1 * complex(0, -sigma) / abs(p1))
    return np.array(points)


def crosses_itself(points: np.ndarray) -> bool:
    """Whether any two sides of the closed polygon that are not neighbours cross."""
    a, b = points, np.roll(points, -1)

    def side(o: np.ndarray, d: np.ndarray, p: np.ndarray) -> np.ndarray:
        return ((d - o).conj()[:, None] * (p[None, :] - o[:, None])).imag > 0

    split = side(a, b, a) != side(a, b, b)
    both = split & split.T
    n = len(points)
    gap = np.abs(np.arange(n)[:, None] - np.arange(n)[None, :])
    return bool((both & (gap > 1) & (gap < n - 1)).any())


@settled
@pytest.mark.parametrize("name", DISCS)
def test_undercut_of_disc_cams_is_seen_on_the_profile(name: str) -> None:
    """The local test (sign of a radius) agrees with the profile drawn as a polygon: crossing or not."""
    entry = REFERENCE[name]
    assert crosses_itself(profile(entry["scene"])) is entry["expected"]["undercut"]


@settled
@pytest.mark.parametrize("name", [n for n in DISCS if not REFERENCE[n]["expected"]["undercut"]])
def test_profile_starts_on_the_base_circle(name: str) -> None:
    """base_radius is the least distance of the profile from the centre, unless the cam is undercut."""
    scene = REFERENCE[name]["scene"]
    least = float(np.abs(profile(scene)).min())
    # with no dwell at the bottom, a sample only comes near to it
    assert least == pytest.approx(scene["cam"]["base_radius"], rel=1e-6)
