"""Laws that a scene brings itself: splines and tables, right and wrong, through every command."""

import json
import re
import tomllib
from itertools import pairwise

import mpmath
import numpy as np
import pyarrow.parquet as pq
import pytest
from flint import arb
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline, make_interp_spline
from support import own
from support.balls.ball import precisely
from support.balls.laws import pieces_of
from support.depth import times
from test_scene import BASES, DELETED, mistakes, with_values

from camopt import Scene, certify, evaluate, find_scene, load, optimise, plot, sweep
from camopt.cli.main import main
from camopt.core.mistakes import BadInput
from camopt.model.motion import LAWS
from camopt.model.motion.law import is_symmetric
from camopt.model.motion.programme import law_displacement_range
from camopt.model.motion.spline import EndCondition, SplineLaw, fit_table_spline
from camopt.scene.law_forms import LEAST_GAP, overshoot_share_allowed_for_noise
from camopt.scene.own_laws import check_laws, make_own_law_from_values
from camopt.scene.problem.problem import resolve
from camopt.scene.unusual_values import unusual_value_notes
from camopt.solve.front.table_certificate import certify_table

BEZIER = {"degree": 5, "knots": [0] * 6 + [1] * 6, "coefficients": [0, 0, 0, 1, 1, 1]}
POINTS = np.linspace(0.0, 1.0, 41)
VERBS = ("displacement", "velocity", "acceleration", "jerk")


def sampled_table(law, count):
    x = np.linspace(0.0, 1.0, count)
    return {"x": x.tolist(), "s": LAWS[law].displacement(x).tolist()}


def with_law(name, law, **changes):
    """A shipped scene that moves by one law of its own, called ``own``."""
    scene = find_scene(name)
    motion = [{**s.model_dump(exclude_none=True), **({"law": "own"} if s.law else {})} for s in scene.motion]
    return scene.replace(laws={"own": law}, motion=motion, search=None, **changes)


def with_law_named(scene, law):
    motion = [{**s.model_dump(exclude_none=True), **({"law": law} if s.law else {})} for s in scene.motion]
    return scene.replace(motion=motion, laws=None)


# ------------------------------------------------------------------------------------ against other answers


@pytest.mark.parametrize("name", ["roller-1000rpm", "flat-reciprocating", "oscillating-roller"])
def test_a_bezier_spline_is_the_345_polynomial(name):
    scene = with_law(name, BEZIER)
    found, expected = evaluate(scene), evaluate(with_law_named(scene, "poly345"))
    assert found["status"] == "certified"
    for quantity, value in expected.items():
        if isinstance(value, float):
            assert found[quantity] == pytest.approx(value, rel=1e-12, abs=1e-12), quantity
        elif not quantity.startswith("law"):
            assert found[quantity] == value, quantity


def test_its_smallest_cam_is_that_of_the_polynomial():
    scene = with_law("roller-1000rpm", BEZIER).replace(search={"law": ["own", "poly345"], "offset": [0, 7]})
    found, expected = (optimise(scene).by_law[law] for law in ("own", "poly345"))
    assert found["base_radius_mm"] == pytest.approx(expected["base_radius_mm"], rel=1e-12)
    assert (found["binding"], found["proved"]) == (expected["binding"], True)


def test_a_table_nears_the_law_behind_it_as_a_quintic_spline_does():
    x = np.linspace(0.0, 1.0, 4001)
    errors = [
        [
            np.abs(getattr(fit_table_spline("t", *map(tuple, sampled_table("cycloidal", n + 1).values())), verb)(x)
                   - getattr(LAWS["cycloidal"], verb)(x)).max()
            for n in (16, 32, 64)
        ]
        for verb in VERBS
    ]  # fmt: skip
    orders = np.log2(np.array(errors)[:, :-1] / np.array(errors)[:, 1:])
    assert orders[0] == pytest.approx(6.0, abs=0.3)
    for lost, order in enumerate(orders):
        assert np.all(order > 5.5 - lost)


splines = st.integers(3, 12).flatmap(
    lambda degree: st.tuples(
        st.just(degree),
        st.lists(st.integers(1, 19), max_size=6).map(sorted).filter(lambda inner: len(set(inner)) == len(inner)),
        st.lists(st.floats(0.0, 1.0), min_size=degree + 6, max_size=degree + 6),
    )
)


def spline(made):
    degree, inner, between = made
    knots = [0.0] * (degree + 1) + [k / 20 for k in inner] + [1.0] * (degree + 1)
    coefficients = [0.0, *between[: degree + len(inner) - 1], 1.0]
    return {"degree": degree, "knots": knots, "coefficients": coefficients}


@settings(max_examples=times(30, deep=600))
@given(splines)
@mpmath.workdps(50)
@precisely()
def test_a_spline_is_that_of_scipy_and_of_fifty_digits(made):
    table = spline(made)
    law = SplineLaw("own", table["degree"], tuple(table["knots"]), tuple(table["coefficients"]))
    other = BSpline(np.array(law.knots), np.array(law.coefficients), law.degree)
    for piece in pieces_of(law):
        x = float(piece.start + (piece.end - piece.start) * 0.37)
        for order, exact in enumerate(own.law_at(law, mpmath.mpf(x))):
            ball = piece.derivative(order, arb(x))
            assert abs(mpmath.mpf(ball.mid().str(50, radius=False)) - exact) <= mpmath.mpf("1e-35")
            scale = np.abs(other.derivative(order)(POINTS)).max() + 1.0 if order else 1.0
            found = float(getattr(law, VERBS[order])(x))
            assert found == pytest.approx(float(exact), abs=1e-12 * scale)
            assert found == pytest.approx(
                float(other.derivative(order)(x) if order else other(x)), abs=1e-9 * scale
            )


@settings(max_examples=times(15, deep=1000))
@given(splines)
def test_any_spline_gives_a_cam_without_nan(made):
    found = evaluate(with_law("roller-1000rpm", spline(made)))
    assert not any(isinstance(value, float) and np.isnan(value) for value in found.values())
    assert found["status"] == "certified"


WIDE = st.one_of(st.just(0.0), st.floats(-20.0, 20.0), st.floats(-1e6, 1e6))
SHARE = st.one_of(st.just(0.0), st.floats(1e-3, 1.0))
made_of_few_numbers = st.one_of(
    st.tuples(st.lists(WIDE, max_size=5), st.lists(WIDE, max_size=5)).map(
        lambda ends: {"start": [0.0, *ends[0]], "end": [1.0, *ends[1]], "overshoot": True}
    ),
    st.tuples(SHARE, SHARE, SHARE, SHARE)
    .filter(lambda shares: sum(shares[:3]) > 0.0)
    .map(lambda shares: {"scca": [share / sum(shares) for share in shares]}),
    st.tuples(
        st.sampled_from([name for name, law in LAWS.items() if is_symmetric(law)]), st.floats(0.01, 0.99)
    ).map(lambda made: {"law": made[0], "crossing": made[1]}),
)


def mirrored_table(law):
    """The table of a law for its other end: the same if it is the same from there."""
    return law if is_symmetric(make_own_law_from_values("", law)) else {**law, "mirror": not law.get("mirror")}


@settings(max_examples=times(20, deep=1000))
@given(made_of_few_numbers, st.booleans())
def test_any_law_in_a_few_numbers_gives_a_cam_without_nan(law, mirror):
    scene = with_law("roller-1000rpm", mirrored_table(law) if mirror else law)
    found = evaluate(scene)
    assert not any(isinstance(value, float) and np.isnan(value) for value in found.values())
    assert found["status"] in ("certified", "undecided")
    assert {"held", "broken"} >= set(certify(scene).values()) or found["status"] == "undecided"


def dense(law):
    """Displacements at many points between each two knots, most of them next to the knots."""
    near = np.geomspace(1e-6, 0.5, 400)
    shares = np.concatenate([near, 1.0 - near])
    return law.displacement(np.concatenate([a + (b - a) * shares for a, b in pairwise(law.BREAKS)]))


@settings(max_examples=times(15, deep=1000))
@given(st.lists(st.tuples(st.floats(1e-3, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=30), st.booleans())
def test_any_table_is_a_law_through_its_points_or_a_mistake(steps, smooth):
    x = np.cumsum([0.0, *(step for step, _ in steps)])
    s = np.cumsum([0.0, *(step for _, step in steps)])
    x, s = x / x[-1], s / (s[-1] or 1.0)
    if smooth and s[-1]:  # between a law and what hypothesis thinks of: most of these stay between 0 and 1
        s = 0.9 * LAWS["poly345"].displacement(x) + 0.1 * x * s
    scene, told = None, ""
    try:
        scene = with_law("roller-1000rpm", {"x": x.tolist(), "s": s.tolist()})
    except BadInput as mistake:
        told = str(mistake)
    if "beyond its ends" in told:
        between = dense(fit_table_spline("own", tuple(x), tuple(s)))
        assert between.min() < 0.0 or between.max() > 1.0
    else:
        assert ("laws.own.s." in told) == (scene is None) == (s[-1] == 0.0)
    assume(scene)
    law = scene.laws["own"]
    made = fit_table_spline("own", law.x, law.s)
    assert made.displacement(law.x) == pytest.approx(np.array(law.s), abs=1e-12)
    by = max(
        LEAST_GAP, overshoot_share_allowed_for_noise({"x": law.x, "s": law.s})
    )  # noise shows in many points alone
    assert -by <= dense(made).min() <= dense(made).max() <= 1.0 + by
    assert [float(getattr(made, verb)(end)) for verb in VERBS[1:3] for end in (0.0, 1.0)] == [0.0] * 4
    found = evaluate(scene)
    assert found["status"] == "sampled"
    assert not any(isinstance(value, float) and np.isnan(value) for value in found.values())


def test_a_knot_as_often_as_the_degree_is_a_corner():
    law = {"degree": 3, "knots": [0] * 4 + [0.5] * 3 + [1] * 4, "coefficients": [0, 0, 0.1, 0.2, 0.9, 1, 1]}
    found = evaluate(with_law("roller-1000rpm", law))
    assert "the velocity jumps at 60°" in found.unbounded["acceleration_max_rise_m_s2"]
    smooth = {"degree": 3, "knots": [0] * 4 + [0.5] * 2 + [1] * 4, "coefficients": [0, 0, 0.1, 0.9, 1, 1]}
    found = evaluate(with_law("roller-1000rpm", smooth))
    assert "the acceleration jumps at 0°, 60°, 120°, by at most " in found.unbounded["jerk_max_rise_m_s3"]


SAME_LAWS = [
    ({"start": [0, 0, 0], "end": [1, 0, 0]}, "poly345"),
    ({"scca": [0.25, 0.5, 0.25]}, "modified-trapezoid"),
    ({"scca": [0.125, 0, 0.375, 0.5]}, "modified-constant-velocity"),
    ({"law": "cycloidal", "crossing": 0.5}, "cycloidal"),
    ({"scca": [0.5, 0, 0.5], "peaks": [3, 3]}, "cycloidal"),
    ({**BEZIER, "crossing": 0.5}, "poly345"),
    ({"law": "half-cycloidal-2", "mirror": True}, "half-cycloidal-1"),
]


@pytest.mark.parametrize(("law", "known"), SAME_LAWS)
def test_a_law_given_in_another_way_is_the_same(law, known):
    found, x = resolve(with_law("roller-1000rpm", law)).laws["own"], np.linspace(0.0, 1.0, 101)
    for verb in VERBS:
        expected = getattr(LAWS[known], verb)(x)
        np.testing.assert_allclose(getattr(found, verb)(x), expected, rtol=0, atol=5e-15 * np.abs(expected).max())


EXAMPLES = {
    "polynomial": {"start": [0, 0, 0], "end": [1, 0, -6]},
    "any order": {"start": [0, 0, 0, 0, 0, 0], "end": [1, 0, 0, 0, 0, 0]},
    "scca": {"scca": [0.1, 0.2, 0.3, 0.4]},
    "skewed": {"law": "modified-sine", "crossing": 0.4},
    "peaks": {"law": "parabolic", "peaks": [2, 1]},
    "skewed scca": {"scca": [0.3, 0, 0.7], "peaks": [2, 1], "mirror": True},
    "overshoot": {"start": [0, 0, 0], "end": [1, -0.5, 0], "overshoot": True},
}


@pytest.mark.parametrize("law", EXAMPLES.values(), ids=EXAMPLES)
def test_a_law_in_any_form_is_written_and_read_and_mirrored(law):
    laws = {"own": law, "back": mirrored_table(law)}
    motion = [
        {"segment": "rise", "angle": 120, "lift": 20, "law": "own"},
        {"segment": "return", "angle": 120, "lift": 20, "law": "back"},
        {"segment": "dwell", "angle": 120},
    ]
    scene = find_scene("roller-1000rpm").replace(laws=laws, motion=motion, search=None)
    assert Scene.from_dict(tomllib.loads(scene.to_toml())) == scene
    programme, angles = resolve(scene).programme, np.radians(np.linspace(0.5, 119.5, 60))
    there, back = programme.motion_at(angles), programme.motion_at(np.radians(240.0) - angles)
    for order in range(4):
        scale = np.abs(there[order]).max()
        np.testing.assert_allclose(back[order], (-1.0) ** order * there[order], rtol=0, atol=1e-12 * scale)


# ------------------------------------------------------------------------------------- through every command


LOPSIDED = {"degree": 5, "knots": [0] * 6 + [0.3] + [1] * 6, "coefficients": [0, 0, 0, 0.7, 1, 1, 1]}
UNEVEN = {"x": [0, 0.1, 0.4, 0.8, 1], "s": [0, 0.05, 0.6, 0.97, 1]}


@pytest.mark.parametrize("law", [LOPSIDED, UNEVEN], ids=["spline", "table"])
def test_a_mirrored_law_is_the_law_from_its_other_end(law):
    """1 − s(1 − x): on a return the motion is that of the rise, backwards."""
    moves = [("rise", 120, "own"), ("return", 120, "back"), ("dwell", 120, None)]
    motion = [
        {"segment": kind, "angle": angle, **({"lift": 40, "law": name} if name else {})}
        for kind, angle, name in moves
    ]
    laws = {"own": law, "back": law | {"mirror": True}}
    scene = find_scene("roller-1000rpm").replace(laws=laws, motion=motion, search=None)
    x = np.linspace(0.0, 1.0, 101)
    own, back = (resolve(scene).laws[name] for name in laws)
    assert np.abs(own.displacement(x) - (1.0 - own.displacement(1.0 - x))).max() > 0.1  # far from even
    for order, verb in enumerate(VERBS):
        expected = (order == 0) - (-1.0) ** order * getattr(own, verb)(1.0 - x)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(getattr(back, verb)(x), expected, rtol=0, atol=1e-9 * scale)
    angles = np.radians(np.linspace(0.5, 119.5, 60))
    there, back_again = (
        resolve(scene).programme.motion_at(angles),
        resolve(scene).programme.motion_at(np.radians(240.0) - angles),
    )
    for order in range(4):
        np.testing.assert_allclose(
            back_again[order], (-1.0) ** order * there[order], atol=1e-9 * abs(there[order]).max()
        )
    assert Scene.from_dict(tomllib.loads(scene.to_toml())) == scene


def test_mirror_is_true_or_false():
    with pytest.raises(BadInput, match=r"laws\.own\.mirror"):
        with_law("roller-1000rpm", LOPSIDED | {"mirror": "yes"})


@pytest.mark.slow
@pytest.mark.parametrize(("law", "status"), [(BEZIER, "certified"), (sampled_table("cycloidal", 21), "sampled")])
def test_a_sweep_writes_a_scene_that_stands_alone(law, status, tmp_path):
    sizes = {"base_radius": [60.0, 80.0, 120.0], "offset": [0.0, 8.0], "law": ["own", "harmonic"]}
    scene = with_law("roller-1000rpm", law).replace(search=sizes)
    result = sweep(scene, tmp_path, keep="all")
    table = load(tmp_path / "designs.parquet")
    assert dict(table.groupby("law_rise").status.first()) == {"harmonic": "certified", "own": status}
    assert result.feasible == table.feasible.sum() > 0
    written = Scene.from_toml(tmp_path / "scene.toml")
    assert written == Scene.from_dict(tomllib.loads(table.attrs["scene"])) == result.scene
    assert written.laws == scene.laws
    counts = certify_table(tmp_path / "designs.parquet")
    assert counts["undecided"] == 0
    proofs = pq.read_table(tmp_path / "designs.parquet").column("proof").to_pylist()
    assert [proof == "held" for proof in proofs] == table.feasible.tolist()


def test_rows_at_their_limit_are_sampled_too():
    """The verdict comes from intervals there, and at the limit itself there is none."""
    scene = with_law("roller-1000rpm", sampled_table("cycloidal", 9))
    angle = evaluate(scene)["pressure_angle_max_deg"]
    for share, status in ((3e-14, "sampled"), (0.0, "undecided"), (-3e-14, "sampled")):
        found = evaluate(held := scene.replace(limits={"pressure_angle": angle * (1.0 + share)}))
        assert found["status"] == status
        assert found["feasible"] is ({*certify(held).values()} == {"held"}) is (share > 0.0)


def test_a_file_is_read_into_the_scene(tmp_path, monkeypatch):
    law = sampled_table("cycloidal", 11)
    rows = "\n".join(f"{x!r},ignored,{s!r}" for x, s in zip(law["x"], law["s"], strict=True))
    (tmp_path / "lift.csv").write_text(f"\ufeffx,note, s\r\n{rows}\n\n", encoding="utf-8")
    scene = with_law("roller-1000rpm", BEZIER)
    text = scene.replace(laws={"own": law}).to_toml()
    (tmp_path / "whole.toml").write_text(text, encoding="utf-8")
    short = {**tomllib.loads(text), "laws": {"own": {"file": "lift.csv"}}}
    lines = json.dumps(short["laws"]["own"]["file"])
    (tmp_path / "cam.toml").write_text(
        f"{text.split('[laws.own]')[0]}\n[laws.own]\nfile = {lines}\n", encoding="utf-8"
    )
    read = Scene.from_toml(tmp_path / "cam.toml")
    assert read.laws == Scene.from_toml(tmp_path / "whole.toml").laws
    assert "lift.csv" not in read.to_toml()
    monkeypatch.chdir(tmp_path)
    assert Scene.from_dict(short).laws == read.laws
    assert short["laws"]["own"] == {"file": "lift.csv"}


@pytest.mark.slow
def test_commands_take_own_laws(tmp_path, capsys):
    file = tmp_path / "cam.toml"
    file.write_text(with_law("two-pauses", sampled_table("cycloidal", 21)).to_toml(), encoding="utf-8")
    assert main(["evaluate", str(file), "--json", "--plot", str(tmp_path / "cam.svg")]) == 0
    assert json.loads(capsys.readouterr().out)["law_rise"] == "own"
    assert ">own<" in (tmp_path / "cam.svg").read_text(encoding="utf-8")
    assert main(["certify", str(file), "--json"]) in (0, 1)
    sizes = ["--base-radius", "90", "--offset", "0", "--roller-radius", "8"]
    assert main(["sweep", str(file), *sizes, "--law", "own", "--law", "cubic", "--out", str(tmp_path / "out")]) in (
        0,
        1,
    )
    capsys.readouterr()
    assert main(["sweep", str(file), *sizes, "--law", "owm", "--out", str(tmp_path / "none")]) == 2
    assert "--law = 'owm': must be a motion law; did you mean own?" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()


@pytest.mark.slow
def test_a_picture_of_a_spline(tmp_path):
    plot(with_law("flat-reciprocating", BEZIER), tmp_path / "cam.png")
    assert (tmp_path / "cam.png").stat().st_size > 10_000


# --------------------------------------------------------------------------------------------------- mistakes

ONE_MISTAKE = [
    ({"laws": 5, "motion": BASES["flat"]["motion"]}, "laws = 5: must be a table"),
    ({"laws.m": 5}, "laws.m = 5: must be a table"),
    ({"laws.m": {}}, "laws.m: a law needs law, scca, start and end, degree, knots and coefficients (of a move: positions), x and s, or a f"),
    ({"laws.m": {"mirror": True}}, "laws.m: a law needs law, scca, start and end"),
    ({"laws.cycloidal": BEZIER}, "laws = 'cycloidal': is a built-in law; give yours another name"),
    ({"laws": {**own.TABLES, "a\nb": BEZIER}}, "laws = 'a\\nb': the name of a law must be one line of printable"),
    ({"laws": {**own.TABLES, "a+b": BEZIER}}, "laws = 'a+b': the name of a law must be"),
    ({"laws": {**own.TABLES, "a/b": BEZIER}}, "laws = 'a/b': the name of a law must be"),
    ({"laws": {**own.TABLES, "": BEZIER}}, "laws = '': the name of a law must be"),
    ({"laws.x": {**BEZIER, "degre": 5}}, "laws.x.degre = 5: not a known key; did you mean degree?"),
    ({"laws.range": {**BEZIER, "knot": 5}}, "laws.range.knot = 5: not a known key; did you mean knots?"),
    ({"motion.1.law": "own-splin"}, "motion.1.law = 'own-splin': must be a motion law; did you mean own-spline?"),
    ({"search.law": "own-tabel"}, "search.law.1 = 'own-tabel': must be a motion law; did you mean own-table?"),
    # splines
    ({"laws.own-spline.degree": 2}, "laws.own-spline.degree = 2: must be at least 3"),
    ({"laws.own-spline.degree": 13}, "laws.own-spline.degree = 13: must be at most 12"),
    ({"laws.own-spline.degree": 5.5}, "laws.own-spline.degree = 5.5: must be a whole number"),
    ({"laws.own-spline.degree": True}, "laws.own-spline.degree = True: must be a whole number"),
    ({"laws.own-spline.degree": DELETED}, "laws.own-spline.degree: missing; a B-spline has coefficients, degree, kn"),
    ({"laws.own-spline.knots": [0, 1]}, "laws.own-spline.knots: has 2 values; 9 coefficients of degree 5 need 15"),
    ({"laws.m": {**BEZIER, "knots": [0] * 5 + [0.5] + [1] * 6}}, "laws.m.knots = [0, 0, 0, 0, 0, 0.5, 1, 1, 1, 1, 1, 1]: must start with 6 zeros and end with 6 ones"),
    ({"laws.m": {**BEZIER, "coefficients": [0, 0, 0, 1, 1]}}, "laws.m.coefficients = [0, 0, 0, 1, 1]: needs at least 6"),
    ({"laws.m": {**BEZIER, "coefficients": [0.1, 0, 0, 1, 1, 1]}}, "laws.m.coefficients.1 = 0.1: must be 0: s(0)"),
    ({"laws.m": {**BEZIER, "coefficients": [0, 0, 0, 1, 1, 2]}}, "laws.m.coefficients.6 = 2: must be 1: s(0)"),
    ({"laws.m": {**BEZIER, "coefficients": [0, 0, 0, float("nan"), 1, 1]}}, "laws.m.coefficients.4 = nan: must be a finite"),
    ({"laws.m": {**BEZIER, "coefficients": [0, -0.1, 0, 1, 1, 1]}}, "laws.m: s goes beyond its ends by 0.025; it must stay"),
    ({"laws.m": {"degree": 3, "knots": [0] * 4 + [0.5] * 4 + [1] * 4, "coefficients": [0, 0, 0, 0, 1, 1, 1, 1]}}, "laws.m.knots = 0.5: occurs 4 times; more than 3 times makes"),
    ({"laws.m": {"degree": 3, "knots": [0] * 4 + [0.6, 0.5] + [1] * 4, "coefficients": [0, 0, 0, 1, 1, 1]}}, "laws.m.knots = [0, 0, 0, 0, 0.6, 0.5, 1, 1, 1, 1]: must be in order"),
    # tables
    ({"laws.own-table.s": DELETED}, "laws.own-table.s: missing; a table has x, s"),
    ({"laws.own-table.degree": 3}, "laws.own-table.degree = 3: a table has none: give one of law, scca, start"),
    ({"laws.m": {"x": [0], "s": [0]}}, "laws.m.x = [0]: needs at least two points, x = 0 and x = 1"),
    ({"laws.m": {"x": [], "s": [0]}}, "laws.m.x = []: must be a list of at least one value"),
    ({"laws.m": {"x": [0, 1], "s": [0, 0.5, 1]}}, "laws.m.s: has 3 values, and x has 2"),
    ({"laws.m": {"x": [0, 0.5, 0.5, 1], "s": [0, 0.4, 0.5, 1]}}, "laws.m.x.3 = 0.5: must be at least 1e-06 above the 0.5"),
    ({"laws.m": {"x": [0.2, 1], "s": [0, 1]}}, "laws.m.x.1 = 0.2: must be 0: a stroke runs from x = 0 to x = 1"),
    ({"laws.m": {"x": [0, 1], "s": [0, 0.9]}}, "laws.m.s.2 = 0.9: must be 1: a stroke runs from s = 0 to s = 1"),
    ({"laws.m": {"x": [0, "a", 1], "s": [0, 0.5, 1]}}, "laws.m.x.2 = 'a': must be a number"),
    ({"laws.m": {"x": [0, 0.1, 0.9, 1], "s": [0, 0, 1, 1]}}, "laws.m: s goes beyond its ends by 0.00075; it must"),
    ({"laws.m": {"x": [k / 2500 for k in range(2501)], "s": [k / 2500 for k in range(2501)]}}, "laws.m.s: has 2501 values; at most 2000 are allowed"),
    ({"laws.own-table.crossing": 0.4}, "laws.own-table.crossing = 0.4: a table has none: its points decide"),
    # polynomials
    ({"laws.m": {"start": [0, 0]}}, "laws.m.end: missing; a polynomial has start, end"),
    ({"laws.m": {"start": [], "end": [1]}}, "laws.m.start = []: must be a list of at least one value"),
    ({"laws.m": {"start": [0, "a"], "end": [1]}}, "laws.m.start.2 = 'a': must be a number"),
    ({"laws.m": {"start": [0.1, 0], "end": [1]}}, "laws.m.start.1 = 0.1: must be 0: a stroke runs from s = 0 to"),
    ({"laws.m": {"start": [0, 0], "end": [2]}}, "laws.m.end.1 = 2: must be 1: a stroke runs from s = 0 to s = 1"),
    ({"laws.m": {"start": [0] * 7, "end": [1] + [0] * 6}}, "laws.m.end: 14 conditions in all make a polynomial of degree 13; the highest degree is 12"),
    ({"laws.m": {"start": [0, -1], "end": [1]}}, "laws.m: s goes beyond its ends by 0.12; it must stay between 0 and 1 unless overshoot = true"),
    ({"laws.m": {"start": [0], "end": [1], "x": [0, 1]}}, "laws.m.start = [0]: a table has none: give one of law, scca"),
    # the SCCA family
    ({"laws.m": {"scca": [0.5, 0.5]}}, "laws.m.scca = [0.5, 0.5]: must be three shares of the stroke (sine ramps, constant acceleration, cosine), or four"),
    ({"laws.m": {"scca": [0.5, 0.5, 0.1]}}, "laws.m.scca = [0.5, 0.5, 0.1]: the shares add up to 1.1, not to 1"),
    ({"laws.m": {"scca": [0.5, -0.5, 1]}}, "laws.m.scca.2 = -0.5: must be 0, or a share of the stroke from 1e-06 to 1"),
    ({"laws.m": {"scca": [1e-9, 0.5, 0.5]}}, "laws.m.scca.1 = 1e-09: must be 0, or a share of the"),
    ({"laws.m": {"scca": [0, 0, 0, 1]}}, "laws.m.scca = [0, 0, 0, 1]: needs a share with acceleration; for constant velocity alone use the law uniform"),
    ({"laws.m": {"scca": 0.5}}, "laws.m.scca = 0.5: must be"),
    # built-in laws
    ({"laws.m": {"law": "cyclod", "crossing": 0.4}}, "laws.m.law = 'cyclod': must be a built-in motion law; did you mean cycloidal?"),
    ({"laws.m": {"law": "own-spline", "crossing": 0.4}}, "laws.m.law = 'own-spline': must be a built-in motion law"),
    ({"laws.m": {"law": 5, "crossing": 0.4}}, "laws.m.law = 5: must be the name of a motion law"),
    ({"laws.m": {"law": "cycloidal"}}, "laws.m.law = 'cycloidal': needs crossing, peaks or mirror; without them it is the built-in law"),
    ({"laws.m": {"law": "cycloidal", "mirror": True}}, "laws.m.mirror = True: cycloidal is the same from both ends"),
    ({"laws.m": {"scca": [0.25, 0.5, 0.25], "mirror": True}}, "laws.m.mirror = True: the law is the same from both ends; leave it out"),
    ({"laws.m": {"scca": [0.3, 0, 0.7], "peaks": [2, 2], "mirror": True}}, "laws.m.mirror = True: the law is the same from both ends"),
    ({"laws.m": {"start": [0, 0, 0], "end": [1, 0, 0], "mirror": True}}, "laws.m.mirror = True: the law is the same from both ends"),
    ({"laws.m": {**BEZIER, "mirror": True}}, "laws.m.mirror = True: the law is the same from both ends"),
    ({"laws.m": {"x": [0, 0.5, 1], "s": [0, 0.5, 1], "mirror": True}}, "laws.m.mirror = True: the law is the same from both ends"),
    ({"laws.m": {"law": "cycloidal", "scca": [0.5, 0, 0.5]}}, "laws.m.law = 'cycloidal': an SCCA law has none: give one of"),
    # crossings
    ({"laws.m": {"law": "cycloidal", "crossing": 1}}, "laws.m.crossing = 1: the acceleration would cross zero at 1; it must be from 0.01 to 0.99 of the stroke"),
    ({"laws.m": {"law": "cycloidal", "crossing": "a"}}, "laws.m.crossing = 'a': must be a number"),
    ({"laws.m": {"law": "cycloidal", "peaks": [1, 0]}}, "laws.m.peaks"),
    ({"laws.m": {"law": "cycloidal", "peaks": 5}}, "laws.m.peaks = 5: must be two numbers"),
    ({"laws.m": {"law": "cycloidal", "peaks": [1]}}, "laws.m.peaks = [1]: must be two numbers"),
    ({"laws.m": {"law": "cycloidal", "peaks": [1, 1e6]}}, "laws.m.peaks = [1, 1000000.0]: the acceleration would cross zero at 0.999999; it must be from 0.01"),
    ({"laws.m": {"law": "cycloidal", "peaks": [1, 2], "crossing": 0.4}}, "laws.m.peaks = [1, 2]: a law has either crossing or peaks"),
    ({"laws.m": {"law": "double-harmonic", "crossing": 0.4}}, "laws.m.crossing = 0.4: is for a symmetric law, s(1 − x) = 1 − s(x)"),
    ({"laws.m": {**BEZIER, "overshoot": 1}}, "laws.m.overshoot = 1: must be true or false"),
    # files
    ({"laws.m": {"file": 5}}, "laws.m.file = 5: must be a text"),
    ({"laws.m": {"file": "absent.csv"}}, "laws.m.file = 'absent.csv': must be a CSV file with columns x and s: No such"),
    ({"laws.m": {"file": "a\x00b"}}, "laws.m.file = 'a\\x00b': must be a CSV file with columns x and s: "),
    ({"laws.m": {"file": "lift.csv", "x": [0, 1]}}, "laws.m.file = 'lift.csv': give either a file, or x and s"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "line"), ONE_MISTAKE)
def test_a_mistake_in_a_law_is_told(changes, line):
    (found,) = mistakes(with_values(BASES["own laws"], changes))
    assert found.startswith(f"cam.toml: {line}")


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"", "its first line has no x and no s"),
        (b"x;s\n0;0\n1;1", "its columns are separated by semicolons, not by commas"),
        (b"x\ts\n0\t0\n1\t1", "its columns are separated by tabs, not by commas"),
        (b"PK\x03\x04\x14", "is an Excel workbook or another archive; save the table as CSV"),
        (b"\xd0\xcf\x11\xe0\xa1", "is an old Excel workbook; save the table as CSV"),
        ("x,s\n0,0\n1,1".encode("utf-16"), "is text in UTF-16; save it in UTF-8"),
        (b"x,s\n0,0\n0,5,0,5\n1,1", "line 3 has 4 values for 2 columns; write decimals with a point"),
        (b"x,s\n0,0\n\xe4,0\n1,1", "is not UTF-8 text: line 3 has the byte 0xe4"),
        (b"x,s\n" + b"0,0\n" * 2001, "has more than 2000 rows"),
        (b"x,y\n0,0\n1,1", "its first line has no s"),
        (b"x,s\n0,0\n1\n", "line 3 has no number for s"),
        (b"x,s\n0,0\n0.5,high\n1,1\n", "line 3 has no number for s"),
    ],
)
def test_a_file_that_is_no_table_is_told(tmp_path, monkeypatch, content, line):
    (tmp_path / "lift.csv").write_bytes(content)
    monkeypatch.chdir(tmp_path)
    (found,) = mistakes(with_values(BASES["own laws"], {"laws.m": {"file": "lift.csv"}}))
    assert found.startswith(f"cam.toml: laws.m.file = 'lift.csv': must be a CSV file with columns x and s: {line}")


def test_points_of_a_file_are_checked_as_those_of_the_scene(tmp_path, monkeypatch):
    (tmp_path / "lift.csv").write_text("x,s\n0,0\n0.5,nan\n1,1\n")
    monkeypatch.chdir(tmp_path)
    (found,) = mistakes(with_values(BASES["own laws"], {"laws.m": {"file": "lift.csv"}}))
    assert found == "cam.toml: laws.m.s.2 = nan: must be a finite number"


# -------------------------------------------------------------------------------------------------- overshoot

OVER = {"start": [0, 0, 0], "end": [1, 0, 0, -100], "overshoot": True}  # at rest at both ends, and above 1 between


def overshooting_scene(name, laws, rise="over", fall="cycloidal", lift=20, **changes):
    motion = [
        {"segment": "rise", "angle": 120, "lift": lift, "law": rise},
        {"segment": "return", "angle": 120, "lift": lift, "law": fall},
        {"segment": "dwell", "angle": 120},
    ]
    scene = find_scene(name) if isinstance(name, str) else name
    return scene.replace(laws=laws, motion=motion, search=None, **changes)


ANY_ENDS = st.lists(st.floats(-8.0, 8.0), max_size=3)


@settings(max_examples=times(30, deep=1000))
@given(ANY_ENDS, ANY_ENDS)
def test_how_far_a_law_overshoots_is_told(start, end):
    law = {"start": [0, *start], "end": [1, *end]}
    s = make_own_law_from_values("own", law).displacement(np.linspace(0.0, 1.0, 4001))
    by = max(-s.min(), s.max() - 1.0)
    faults = list(check_laws({"laws": {"own": law}}))
    assert not list(check_laws({"laws": {"own": {**law, "overshoot": True}}}))
    if by > 1e-6:
        ((_, _, told),) = faults
        assert float(told.split(" by ")[1].split(";")[0]) == pytest.approx(by, rel=0.06, abs=1e-4)
    elif faults:
        assert by > -1e-4


def test_the_highest_is_above_the_ends_of_the_rise():
    """√(e² + (s₀ + highest)²) − R_r is the outer radius, and base circle and start are where they were."""
    scene = overshooting_scene("roller-1000rpm", {"over": OVER}, limits=None, outputs=["outer_radius_mm"])
    lift = resolve(scene).programme.lift
    assert lift == pytest.approx(
        resolve(scene).programme.motion_at(np.linspace(0.0, 2.0, 200001))[0].max(), rel=1e-9
    )
    assert lift > 1.05 * 20
    offset, roller = scene.follower.offset, scene.follower.roller_radius
    height = np.sqrt((scene.cam.base_radius + roller) ** 2 - offset**2) + lift
    assert evaluate(scene)["outer_radius_mm"] == pytest.approx(np.hypot(offset, height) - roller, rel=1e-12)


@pytest.mark.parametrize("name", ["roller-1000rpm", "oscillating-roller", "groove"])
def test_a_motion_that_overshoots_is_certified(name):
    """At the limit, and as far to either side as rounding lets verdicts differ."""
    groove = {
        "cam": {"form": "cylindrical", "mean_radius": 60.0},
        "follower": {"motion": "oscillating", "contact": "roller", "roller_radius": 5.0, "arm_length": 90.0},
        "motion": find_scene("roller-1000rpm").to_dict()["motion"],
    }
    base = Scene.from_dict(groove) if name == "groove" else find_scene(name)
    scene = overshooting_scene(base, {"over": OVER}, lift=12, limits=None)
    found = evaluate(scene)
    assert found["status"] == "certified"
    angle = found["pressure_angle_max_deg"]
    for factor, verdict in ((1.0 - 1e-12, "broken"), (1.0 + 1e-12, "held")):
        limited = scene.replace(limits={"pressure_angle": angle * factor})
        assert certify(limited)["pressure_angle"] == verdict
        assert evaluate(limited)["feasible"] is (verdict == "held")


@pytest.mark.parametrize(("rise", "fall"), [("cycloidal", "over"), ("below", "cycloidal"), ("below", "over")])
def test_the_lowest_of_the_turn_is_on_the_base_circle(rise, fall):
    """Also where a law goes below the level at which the turn starts."""
    scene = overshooting_scene("roller-1000rpm", {"over": OVER, "below": {**OVER, "mirror": True}}, rise, fall)
    programme = resolve(scene).programme
    y = programme.motion_at(np.linspace(0.0, 2.0 * np.pi, 200001))[0]
    assert y.min() == pytest.approx(0.0, abs=1e-8)
    assert y.max() == pytest.approx(programme.lift, rel=1e-9)
    assert y[0] > 1.0
    found = evaluate(scene)
    assert found["status"] == "certified"
    assert found["feasible"] is ("broken" not in certify(scene).values())


def test_a_law_that_overshoots_counts_for_the_overhang():
    dynamics = {"mass": 0.5, "guide_length": 40.0, "overhang": 21.0}
    with pytest.raises(BadInput, match=r"overhang = 21.*: must be at least the lift \(21\.6"):
        overshooting_scene("roller-1000rpm", {"over": OVER}, **{"follower.dynamics": dynamics})


# ----------------------------------------------------------------------------------- tables that need not rest


REST = {"both": (True, True), "start": (True, False), "end": (False, True), "none": (False, False)}


@pytest.mark.parametrize("rest", REST)
@pytest.mark.parametrize("mirror", [False, True])
def test_a_table_rests_where_it_says(rest, mirror):
    """Half of a harmonic motion: it rests at its start, and has its velocity or its acceleration at its end."""
    x = np.linspace(0.0, 1.0, 31)
    law = make_own_law_from_values(
        "table", {"x": x.tolist(), "s": (1 - np.cos(np.pi * x / 2)).tolist(), "rest": rest, "mirror": mirror}
    )
    for place, resting in zip((0.0, 1.0), REST[rest][:: -1 if mirror else 1], strict=True):
        assert bool(law.velocity(place) == 0.0 and law.acceleration(place) == 0.0) is resting
    moving = 0.0 if mirror else 1.0
    if not REST[rest][1]:
        assert law.velocity(moving) == pytest.approx(np.pi / 2, abs=2e-3)  # natural ends are off by their own jerk


@pytest.mark.parametrize("turning", [EndCondition.REVERSAL, EndCondition.FREE])
def test_an_end_that_does_not_rest_has_the_least_jerk(turning):
    """No other end conditions have a smaller ∫ s‴² through the same points: the natural spline."""
    x, s = (0.0, 0.2, 0.45, 0.7, 1.0), (0.0, 0.05, 0.4, 0.8, 1.0)

    def square(spline):
        third = spline.derivative(3)
        nodes, weights = np.polynomial.legendre.leggauss(12)
        pieces = np.unique(spline.t)
        mids, halves = (pieces[1:] + pieces[:-1]) / 2, np.diff(pieces) / 2
        return float((third(mids[:, None] + halves[:, None] * nodes) ** 2 @ weights * halves).sum())

    natural = fit_table_spline("t", x, s, (EndCondition.REST, turning))
    law = BSpline(np.array(natural.knots), np.array(natural.coefficients), natural.degree)
    rest = [(1, 0.0), (2, 0.0)]
    for velocity in np.linspace(-2.0, 2.0, 9) if turning is EndCondition.FREE else [0.0]:
        for acceleration in np.linspace(-20.0, 20.0, 9):
            other = make_interp_spline(x, s, k=5, bc_type=(rest, [(1, velocity), (2, acceleration)]))
            assert square(other) >= square(law) * (1 - 1e-9)


@pytest.mark.parametrize("mirror", [False, True])
def test_a_table_turns_back_where_it_says(mirror):
    """Quarters of a sine: no velocity at the reversal, and the acceleration of the sine."""
    x = np.linspace(0.0, 1.0, 21)
    table = {
        "x": x.tolist(),
        "s": np.sin(np.pi * x / 2).tolist(),
        "rest": "none",
        "reversal": "end",
        "mirror": mirror,
    }
    law, end = make_own_law_from_values("table", table), 0.0 if mirror else 1.0
    assert float(law.velocity(end)) == 0.0
    assert float(law.acceleration(end)) == pytest.approx((1 if mirror else -1) * np.pi**2 / 4, rel=1e-6)
    assert float(law.velocity(1.0 - end)) == pytest.approx(np.pi / 2, rel=2e-3)


def test_the_jump_at_a_reversal_is_that_of_the_two_accelerations():
    """A rise straight into a return of another angle: velocity 0, and accelerations with the angles squared."""
    x = np.linspace(0.0, 1.0, 11)
    up = {"x": x.tolist(), "s": (x**3 * (7 - 9 * x + 3 * x**2)).tolist(), "reversal": "end"}
    scene = find_scene("roller-1000rpm").to_dict()
    scene["search"] = {key: value for key, value in scene["search"].items() if not key.startswith("law")}
    turn = ("rise", 60, 9.0, "up"), ("return", 80, 9.0, "down"), ("dwell", 220, None, None)
    keys = ("segment", "angle", "lift", "law")
    scene["motion"] = [{k: v for k, v in zip(keys, row, strict=True) if v is not None} for row in turn]
    laws = {"up": up, "down": {**up, "reversal": "end", "mirror": True}}
    scene = Scene.from_dict({**scene, "laws": laws})
    omega, law = scene.cam.rpm * np.pi / 30, make_own_law_from_values("up", up)
    before, after = (9e-3 * float(law.acceleration(1.0)) * (omega / np.radians(angle)) ** 2 for angle in (60, 80))
    jump = after - before
    assert [(each.order, round(np.degrees(each.at), 9)) for each in resolve(scene).programme.jumps] == [(2, 60.0)]
    told = evaluate(scene).unbounded["jerk_max_m_s3"]
    assert told == f"the acceleration jumps at 60°, by {jump:.6g} m/s²"
    same = scene.replace(**{"motion.1.angle": 80, "motion.3.angle": 200})
    assert evaluate(same)["jerk_max_m_s3"] < np.inf  # retraced in the same time, nothing jumps


def table_scene(s, **more):
    x = np.linspace(0.0, 1.0, len(s))
    scene = find_scene("roller-1000rpm").to_dict()
    scene["motion"] = [
        {**row, **({"law": "table"} if row["segment"] != "dwell" else {})} for row in scene["motion"]
    ]
    scene["search"] = {key: value for key, value in scene["search"].items() if not key.startswith("law")}
    return Scene.from_dict({**scene, "laws": {"table": {"x": x.tolist(), "s": list(s), **more}}})


def steep(count):
    x = np.linspace(0.0, 1.0, count)
    return x**3 * (10 - 15 * x + 6 * x**2)


def test_the_rounding_of_a_table_is_allowed_and_the_base_circle_is_where_it_is_lowest():
    beyond = []
    for decimals in (4, 5, 6):
        rounded = np.round(9.5 * steep(181), decimals) / 9.5
        least = float(
            law_displacement_range(
                make_own_law_from_values("t", {"x": np.linspace(0, 1, 181).tolist(), "s": rounded.tolist()})
            )[0]
        )
        beyond.append(least * 10**decimals)
        assert resolve(table_scene(rounded)).programme.lowest_and_highest_displacement[0] == pytest.approx(
            0.0, abs=1e-9
        )
    assert -1.0 < min(beyond) < 0.0  # of the last decimal
    with pytest.raises(BadInput, match="goes beyond its ends"):
        table_scene([*rounded[:9], -0.02, *rounded[10:]])


def test_noise_of_a_table_is_told():
    rng = np.random.default_rng(5)
    noisy = steep(181) + rng.normal(0.0, 1e-3, 181)
    noisy[0], noisy[-1] = 0.0, 1.0
    (told,) = [line for line in unusual_value_notes(table_scene(noisy, overshoot=True)) if "laws.table" in line]
    assert "of its acceleration is noise or rounding of its points" in told
    assert not [line for line in unusual_value_notes(table_scene(steep(181))) if "laws.table" in line]
    assert not [line for line in unusual_value_notes(table_scene(np.round(steep(61), 5))) if "laws.table" in line]
    in_microns = np.round(25.0 * steep(101), 3) / 25.0
    (told,) = [line for line in unusual_value_notes(table_scene(in_microns)) if "laws.table" in line]
    share = float(re.search(r"(\d+)% of its jerk", told)[1]) / 100
    third = np.diff(in_microns, 3) - np.diff(steep(101), 3)
    assert share == pytest.approx(np.std(third) / np.sqrt(np.mean(np.diff(in_microns, 3) ** 2)), abs=0.1)


def test_a_table_that_rests_where_a_rise_goes_over_into_a_return_is_told():
    scene = find_scene("roller-1000rpm").to_dict()
    scene["search"] = {key: value for key, value in scene["search"].items() if not key.startswith("law")}
    turn = ("rise", 60, 9.0, "up"), ("return", 60, 9.0, "down"), ("dwell", 240, None, None)
    keys = ("segment", "angle", "lift", "law")
    scene["motion"] = [{k: v for k, v in zip(keys, row, strict=True) if v is not None} for row in turn]

    def law_notes(**ends):
        up = {"x": [0.0, 0.3, 0.6, 1.0], "s": [0.0, 0.1, 0.6, 1.0], **ends}
        made = Scene.from_dict({**scene, "laws": {"up": up, "down": {**up, "mirror": True}}})
        return [line for line in unusual_value_notes(made) if line.startswith("laws.")]

    start, *_ = law_notes()
    assert start == (
        "laws.up: the follower rests between motion.1 and motion.2; "
        'set reversal = "end" to let it reverse with the acceleration of the points; '
        "set rest to keep the rest without this note"
    )
    assert len(law_notes()) == 2
    assert ['reversal = "both"' in line for line in law_notes(reversal="start")] == [True, True]
    assert not law_notes(reversal="end")
    assert not law_notes(rest="both")


def test_a_spline_of_another_program_may_overshoot_by_rounding():
    spline = make_interp_spline(x := np.linspace(0.0, 1.0, 21), steep(21), k=3, bc_type="clamped")
    coefficients = spline.c.copy()
    coefficients[1] = -1e-7
    law = {"degree": 3, "knots": spline.t.tolist(), "coefficients": coefficients.tolist()}
    least, _ = law_displacement_range(make_own_law_from_values("law", law))
    assert -1e-6 < least < 0.0 == x[0]
    assert not [*check_laws({"laws": {"law": law}})]
    law["coefficients"][1] = -1e-4
    assert "goes beyond its ends" in next(check_laws({"laws": {"law": law}}))[2]


def test_rest_is_for_tables():
    scene = find_scene("roller-1000rpm").to_dict()
    scene["laws"] = {"mine": {"scca": [0.2, 0.3, 0.5], "rest": "none"}}
    with pytest.raises(BadInput, match=r"laws.mine.rest = 'none': .* only a table of x and s has it"):
        Scene.from_dict(scene)
    few = {"x": [0, 1], "s": [0, 1], "rest": "none"}
    with pytest.raises(BadInput, match=r"laws.mine.x = .*needs at least three points"):
        Scene.from_dict({**scene, "laws": {"mine": few}})
    assert make_own_law_from_values("t", {**few, "reversal": "end"}).displacement(0.25) == pytest.approx(
        1 - 0.75**2
    )  # no jerk at all
    with pytest.raises(BadInput, match=r"laws.mine.reversal = 'both': rest = 'end' names the same end"):
        Scene.from_dict({**scene, "laws": {"mine": {**few, "rest": "end", "reversal": "both"}}})
