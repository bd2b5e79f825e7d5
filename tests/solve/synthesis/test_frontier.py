"""The frontier of free laws: a front, above its bound, of cams that hold every limit."""

import tomllib
from functools import cache

import numpy as np
import pytest
from support.depth import times
from support.pictures import faults_of

from camopt import BadInput, Frontier, Scene, certify, evaluate, find_scene, frontier, load, plot, synthesise
from camopt.cli.main import main
from camopt.cli.terminal import print_sections
from camopt.core.mistakes import Unmet
from camopt.scene.synthesis import AXIS_TERMS
from camopt.show.pictures.frontier import AXIS_NAMES
from camopt.solve.smallest.boxes import Bisection
from camopt.solve.smallest.optimise import optimise
from camopt.solve.synthesis import frontier as searches
from camopt.solve.synthesis.axis_minimiser import AxisMinimiser
from camopt.solve.synthesis.cams import motion_holds_limits
from camopt.solve.synthesis.files import write_frontier
from camopt.solve.synthesis.frontier import _axis_ends_and_known_cams, _check_axes_and_add_outputs
from camopt.solve.synthesis.nonconvex_constraints import nonconvex_constraints_of
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.solver import CompiledProgramme
from camopt.solve.synthesis.term_units import term_unit

COARSE = {
    "synthesis.pieces": 20,
    "search.roller_radius": [5],
    "search.law": ["poly345", "modified-sine", "harmonic"],
}


@pytest.fixture(scope="session")
def scene():
    return find_scene("roller-1000rpm").replace(**COARSE)


@pytest.fixture(scope="module")
def found(scene):
    return frontier(scene, points=6, workers=1)


@pytest.mark.slow
def test_rows_are_a_front_above_its_bound(found):
    sizes, accelerations = (np.array([row[axis] for row in found.rows]) for axis in found.axes)
    assert len(found.rows) == 6
    assert np.all(np.diff(sizes) > 0.0)
    assert np.all(np.diff(accelerations) < 0.0)
    for row in found.rows:
        assert row["base_radius_mm"] == row["size"]
        assert row["acceleration_max_m_s2"] == pytest.approx(row["acceleration"], rel=1e-12)
        assert 0.9 * row["size"] < row["bound"] <= row["size"]


def test_known_laws_are_not_below_the_bound(found):
    """The bound falls with the acceleration, so that of the next larger acceleration holds too."""
    compared = 0
    for known in found.known:
        looser = [row["bound"] for row in found.rows if row["acceleration"] >= known["acceleration"]]
        if known["within"] and looser:
            compared += 1
            assert known["size"] >= max(looser)
    assert compared
    assert {row["law_rise"]: row["within"] for row in found.known} == {
        "poly345": True,
        "modified-sine": False,  # a jerk of 69.5 where 60 is allowed
        "harmonic": False,
        "parabolic": False,  # the scene's own
    }


def excludes(found, row):
    """Whether a point lies where the frontier says that no motion is."""
    first, second = found.axes
    return any(row[second] <= at and row[first] < bound for at, bound in found.excluded)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "changes", "axes"),
    [
        ("roller-1000rpm", COARSE | {"synthesis.pieces": 10}, ("size", "acceleration")),
        pytest.param(
            "roller-1000rpm",
            COARSE | {"synthesis.pieces": 10},
            ("size", "jerk_rms"),
            marks=pytest.mark.long,
        ),
        ("two-pauses", {"synthesis.pieces": 10, "limits.pressure_angle": 25}, ("size", "velocity")),
        ("exhaust-valve", {"synthesis.pieces": 10, "limits.pressure_angle": 45}, ("size", "acceleration")),
    ],
)
def test_no_certified_cam_lies_where_no_motion_is_said_to_be(name, changes, axes, monkeypatch):
    """Few points leave wide gaps between bounds; the cams of other points fall between them."""
    monkeypatch.setattr(
        "camopt.solve.synthesis.frontier._axis_ends_and_known_cams", cache(_axis_ends_and_known_cams)
    )
    scene = find_scene(name).replace(**{"search.law": ["poly345"], **changes})
    coarse, fine = (frontier(scene, axes, points=n, workers=1) for n in (3, 5))
    cams = [*coarse.rows, *fine.rows, *(row for row in (*coarse.known, *fine.known) if row["within"])]
    assert len(cams) >= 4
    assert not [row for row in cams if excludes(coarse, row) or excludes(fine, row)]


def test_the_excluded_region_is_what_the_bounds_prove_and_all_of_it(found):
    first, second = found.axes
    rng = np.random.default_rng(1)
    ranges = [
        (0.8 * min(row[a] for row in found.rows), 1.2 * max(row[a] for row in found.rows)) for a in found.axes
    ]
    points = [dict(zip(found.axes, pick, strict=True)) for pick in rng.uniform(*np.transpose(ranges), (2000, 2))]
    for point in points:
        rows = any(point[second] <= row[second] and point[first] < row["bound"] for row in found.rows)
        proved = rows or any(point[axis] < found.least[axis][1] for axis in found.axes)
        assert excludes(found, point) == proved
    assert 100 < sum(excludes(found, point) for point in points) < 1900


@pytest.mark.parametrize("law", ["poly345", "cycloidal", "poly4567", "modified-sine", "modified-trapezoid"])
@pytest.mark.parametrize("name", ["roller-1000rpm", "exhaust-valve", "two-pauses", "oscillating-roller"])
def test_a_law_is_within_its_own_peaks(name, law):
    """Whatever the angles and lifts, whose rounding is not that of the unit stroke."""
    peaks = {"synthesis.peak_acceleration": law, "synthesis.peak_velocity": law, "synthesis.peak_jerk": law}
    for lift in (37.5, 20.1, 12.7, 1 / 3):
        motion = [
            segment | ({"lift": lift} if "lift" in segment else {})
            for segment in find_scene(name).to_dict()["motion"]
        ]
        problem = build_synthesis_problem(find_scene(name).replace(motion=motion, **peaks))
        assert motion_holds_limits(problem, problem.scene_problem.follower_motion_with_laws(law, law))


def test_the_picture_of_a_frontier(found, tmp_path):
    figure = plot(found, tmp_path / "frontier.svg")
    assert faults_of(figure) == []
    written = (tmp_path / "frontier.svg").read_text(encoding="utf-8")
    assert "DejaVuSans-" not in written
    assert all(f">{row['law_rise']}<" in written for row in found.known)


def test_ends_are_those_of_single_objectives(scene, found):
    least = synthesise(scene.replace(**{"synthesis.peak_jerk": "poly345"})).objective
    assert found.rows[0]["size"] == pytest.approx(least, rel=2e-3)
    gentlest = synthesise(scene.replace(**{"synthesis.minimise": "acceleration", "cam.base_radius": 1000}))
    assert found.least["acceleration"][0] == pytest.approx(gentlest.objective, rel=3e-4)
    for free, bound in found.least.values():
        assert bound <= free


@pytest.mark.long
def test_lift_area_is_traded_for_acceleration_as_single_syntheses_trade_it(scene):
    """With the acceleration of a row as a limit, no law has more lift area than the row."""
    found = frontier(scene, ("lost_lift_area", "acceleration"), points=3, workers=1)
    assert found.local == ()
    for row in found.rows:
        limited = {"limits.acceleration": row["acceleration"], "synthesis.minimise": "lost_lift_area"}
        single = synthesise(scene.replace(**limited, **{"synthesis.peak_jerk": "poly345"}))
        assert row["bound"] <= row["lost_lift_area"] == pytest.approx(single.objective, rel=2e-3)


ENDS = {
    "convex": ("roller-1000rpm", {}),
    "curvature": ("exhaust-valve", {"limits.curvature_radius": 10}),
    "self-crossing": ("exhaust-valve", {}),
    "listed offsets": ("exhaust-valve", {"limits.pressure_angle": 35, "search.offset": [0, 30]}),
    "listed sizes": ("exhaust-valve", {"limits.pressure_angle": 35, "search.base_radius": [20, 40, 60]}),
    "flat": ("flat-reciprocating", {}),
    "swung": ("oscillating-roller", {"limits.pressure_angle": 45}),
}


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", ENDS)
def test_the_end_of_a_term_is_what_synthesise_finds(case):
    """Whatever decides; both hold the peaks of poly345, since neither minimises an acceleration."""
    name, changes = ENDS[case]
    scene = find_scene(name).replace(**{"synthesis.pieces": 12, **changes})
    end = AxisMinimiser(scene, ("size", "velocity"), "size", ()).minimise_at({}).row
    single = synthesise(scene)
    assert end["size"] == single.objective
    assert end["local"] == (not single.convex)
    assert Scene.from_dict(tomllib.loads(end["scene"])) == single.scene


def test_the_command_writes_the_table_and_the_picture(found, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("camopt.frontier", lambda *_, **__: found)
    assert main(["frontier", "roller-1000rpm", "--out", str(tmp_path / "out")]) == 0
    files = {".camopt", "frontier.parquet", "frontier.png", "manifest.json"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == files
    assert (tmp_path / "out" / "frontier.png").read_bytes().startswith(b"\x89PNG")
    assert len(load(tmp_path / "out" / "frontier.parquet")) == len(found.rows) + len(found.known)
    assert "frontier.png" in capsys.readouterr().err


def test_the_table_has_each_cam(found, tmp_path):
    table = write_frontier(found, tmp_path)
    frame = load(table)
    units = frame.attrs["units"]
    assert {name: units[name] for name in ("base_radius_mm", *found.axes, "bound")} == {
        "base_radius_mm": "mm", "size": "mm", "acceleration": "m/s²", "bound": "mm",
    }  # fmt: skip
    free = frame[frame["free"]]
    assert len(free) == len(found.rows)
    assert frame.loc[~frame["free"], ["bound", "scene"]].isna().all(axis=None)
    for number in (0, -1):
        row = free.iloc[number]
        path = tmp_path / "cam.toml"
        path.write_text(row["scene"])
        cam = Scene.from_toml(path)
        assert evaluate(cam)["base_radius_mm"] == row["base_radius_mm"]
        assert set(certify(cam).values()) == {"held"}
        assert optimise(cam).best["base_radius_mm"] == pytest.approx(row["base_radius_mm"], abs=1e-6)


@pytest.mark.slow
def test_the_printed_table_has_units_and_no_column_of_zeros(capsys):
    knife = find_scene("knife-900rpm-radial").replace(
        **{"synthesis.pieces": 8, "search": {"law": ["cycloidal"]}, "limits": {"pressure_angle": 30}}
    )
    found = frontier(knife, points=2, workers=1)
    print_sections(*found.sections())
    printed = capsys.readouterr().out
    head = [line for line in printed.splitlines()[:8] if "mm" in line]
    assert [word for word in head[0].split() if word != "law"] == ["mm", "m/s²", "mm", "mm"]
    assert "roller" not in printed
    assert "Least acceleration" in printed
    assert "m/s²;" in printed
    assert "on its smallest cam" in " ".join(printed.split())
    told = " ".join(printed.split())
    assert "have no default limit. So synthesise, which minimises size, also limits acceleration" in told


LIMITED = {
    ("acceleration", "size,velocity"): "synthesise, which minimises acceleration, does not limit acceleration.",
    ("jerk", "size,acceleration"): "synthesise, which minimises jerk, does not limit jerk.",
    ("size", "size,velocity"): "",
}


@pytest.mark.parametrize(("minimise", "axes"), LIMITED)
def test_limits_by_default_that_synthesise_has_not_are_said_too(scene, minimise, axes):
    asked, names = scene.replace(**{"synthesis.minimise": minimise}), tuple(axes.split(","))
    told = " ".join(map(str, Frontier(asked, names, [], [], {}).sections()))
    assert told.endswith(LIMITED[minimise, axes])
    assert ("So synthesise" in told) == bool(LIMITED[minimise, axes])


def test_the_picture_names_axes_as_the_table_does(found):
    axes = plot(found).axes[0]
    for axis, words in zip(found.axes, (axes.get_ylabel(), axes.get_xlabel()), strict=True):
        assert words.startswith(axis.replace("_", " "))
    assert AXIS_NAMES.keys() == {*AXIS_TERMS}
    assert all(words.startswith(axis.replace("_", " ")) for axis, words in AXIS_NAMES.items())


def test_units_of_terms_are_those_of_the_quantities(scene):
    slow = scene.replace(**{"cam.rpm": None})
    swung = find_scene("oscillating-roller")
    every = {term: (term_unit(term, scene), term_unit(term, slow), term_unit(term, swung)) for term in AXIS_TERMS}
    assert every["jerk"] == every["jerk_rms"] == ("m/s³", "mm/rad³", "deg/rad³")
    assert every["size"] == ("mm", "mm", "mm")
    assert every["lost_lift_area"] == ("mm·deg", "mm·deg", "deg·deg")
    assert every["residual_vibration"] == ("mm", "mm", "deg")
    assert term_unit("power_peak_W", swung) == "W"


@pytest.mark.long
def test_three_axes_and_quantities(scene):
    coarse = scene.replace(**{"synthesis.pieces": times(10, deep=20)})
    three = frontier(coarse, ("size", "acceleration", "jerk"), points=3, workers=1)
    values = np.array([[row[axis] for axis in three.axes] for row in three.rows])
    worse = (values[:, None] >= values[None]).all(axis=2) & (values[:, None] > values[None]).any(axis=2)
    assert len(three.rows) > 3
    assert not worse.any()
    assert three.excluded == []
    assert faults_of(plot(three)) == []


LOADED = {
    "synthesis.pieces": times(6, deep=8),
    "synthesis.peak_acceleration": 9,
    "synthesis.peak_jerk": 80,
    "search.roller_radius": [8],
    "search.law": ["poly345"],
    "follower.dynamics": {
        "mass": 0.5,
        "spring_rate": 30,
        "preload": 3000,
        "natural_frequency": 110,
        "damping_ratio": 0.05,
    },
    "materials": {"cam": "steel", "follower": "steel", "face_width": 12},
    "outputs": ["sizes", "motion", "torque", "hertz", "thrust", "vibration"],
}
SPRUNG = {
    "mass": 1.5,
    "gravity": 9.81,
    "guide_length": 90,
    "overhang": 80,
    "friction": 0.1,
    "stem_diameter": 16,
    "preload": 250,
    "spring_rate": 15,
}
BETTER = {  # the least share by which some point is below laws that are traded for acceleration
    "torque_peak_N_m": 0.15,
    "contact_stress_max_MPa": 0.02,
    "side_thrust_max_N": 0.02,
    "residual_vibration": 0.9,
}


@pytest.fixture(scope="session")
def loaded(scene):
    return scene.replace(**LOADED)


@pytest.fixture(scope="module")
def traded_for_acceleration(loaded):
    return frontier(loaded, points=6, workers=1).rows


@pytest.mark.long
@pytest.mark.parametrize(
    "axis",
    [
        "residual_vibration",
        pytest.param("torque_peak_N_m", marks=pytest.mark.long),
        pytest.param("contact_stress_max_MPa", marks=pytest.mark.long),
        pytest.param("side_thrust_max_N", marks=pytest.mark.long),
    ],
)
def test_a_quantity_is_no_higher_than_on_laws_traded_for_acceleration(loaded, traded_for_acceleration, axis):
    """At no larger a size; and lower somewhere."""
    found = frontier(loaded, ("size", axis), points=3, workers=1)
    assert found.local == (() if axis == "residual_vibration" else (axis,))
    name = "residual_vibration_max_mm" if axis == "residual_vibration" else axis
    shares = []
    for row in found.rows:
        cam = evaluate(Scene.from_dict(tomllib.loads(row["scene"])))
        assert cam["feasible"]
        assert row[axis] == cam[name] == row[name]
        assert row["size"] == cam["base_radius_mm"] >= row["bound"]
        smaller = [old[name] for old in traded_for_acceleration if old["size"] <= row["size"]]
        shares += [1.0 - row[axis] / min(smaller)] if smaller else []
    assert len(found.rows) >= 3
    assert min(shares) >= -1e-3
    assert max(shares) >= BETTER[axis]
    assert found.least[axis][0] <= found.rows[-1][axis] * (1 + 1e-9)


@pytest.mark.long
def test_steps_from_a_motion_within_its_bounds_stay_there_and_are_few(monkeypatch):
    """Least torque, then the least size with hardly more of it: a price too low would first lead far beyond it."""
    limits = {"pressure_angle": 35, "contact_stress": 450, "stem_bending_stress": 90}
    scene = find_scene("exhaust-valve").replace(
        **{"cam.rpm": 300, "follower.dynamics": SPRUNG, "limits": limits, "synthesis.pieces": 12},
        materials={"cam": "steel", "follower": "steel", "face_width": 10},
        outputs=["force"],
    )
    scene, axes = _check_axes_and_add_outputs(scene, ("size", "torque_peak_N_m"))  # calls for sizes and torque too
    gentle = AxisMinimiser(scene, axes, axes[1], ("size",)).minimise_at({"size": 248.0}, with_bound=False)
    least, solved = AxisMinimiser(scene, axes, "size", axes[1:]), []
    value = {axes[1]: gentle.row[axes[1]] * (1 + 3e-4)}
    constraints = nonconvex_constraints_of(least._problem_with_held_limits(value))
    solve = CompiledProgramme.solve
    monkeypatch.setattr(CompiledProgramme, "solve", lambda *given: solved.append(given) or solve(*given))
    reached = least.convex_steps.find_local_optimum(gentle.laws, constraints)
    assert least.convex_steps.largest_ratios_to_bounds(reached, constraints, ())[0] <= 1.0
    assert reached.height < gentle.laws.height
    assert len(solved) <= 8


@pytest.mark.slow
def test_a_solvers_error_in_the_jerk_loses_no_cam():
    """With the least margin the laws exceed the jerk a little; a wider one holds it."""
    least = AxisMinimiser(find_scene("bucket-valve"), ("size", "acceleration"), "acceleration", ("size",))
    assert least.minimise_at({"size": 13.0293}).row["acceleration"] < 4900.0


@pytest.mark.slow
def test_convex_steps_of_an_arm_keep_the_range_of_the_base_radius():
    """Below it, at an arm hardly longer than the centre distance, steps once ended at cams that do not exist."""
    least = AxisMinimiser(find_scene("face-groove-shutter"), ("size", "acceleration"), "size", ("acceleration",))
    cam = least.minimise_at({"acceleration": 2759.2}, with_bound=False)
    assert cam.row["size"] == pytest.approx(23.969, abs=1e-3)
    start = cam.laws._replace(height=0.55)
    constraints = nonconvex_constraints_of(least._problem_with_held_limits({"acceleration": 2759.2}))
    reached = least.convex_steps.find_local_optimum(start, constraints)
    assert reached.height * least.problem.size_unit >= least.problem.prime_range[0] * (1 - 1e-6)


@pytest.mark.slow
def test_a_cam_of_the_least_radius_in_the_range_is_found_without_a_search(monkeypatch):
    """Few arms allow it: a search among all of them took from one to many seconds."""
    gentle = AxisMinimiser(find_scene("face-groove-shutter"), ("size", "acceleration"), "acceleration", ("size",))
    monkeypatch.setattr(Bisection, "size_bound_by_bisection", lambda *given: pytest.fail("a search"))
    assert gentle.minimise_at({"size": 18.00018}).row["size"] == 18.0


def test_the_residual_vibration_of_the_programme_is_the_effects(loaded):
    """The value of the convex programme, at its own coefficients, is that of the cam's response."""
    finer = loaded.replace(**{"synthesis.pieces": 8})
    least = AxisMinimiser(finer, ("residual_vibration", "size"), "residual_vibration", ("size",))
    found = least.minimise_at({"size": 40.0})
    assert least.optimum > 1e-3
    assert found.row["residual_vibration_max_mm"] == pytest.approx(least.optimum, rel=1e-3)
    assert found.row["size"] <= 40.0 * (1 + 1e-9)


@pytest.mark.long
@pytest.mark.parametrize(
    "axes",
    [
        pytest.param(("torque_peak_N_m", "size"), marks=pytest.mark.long),
        pytest.param(("torque_peak_N_m", "side_thrust_max_N"), marks=pytest.mark.long),
        pytest.param(("size", "torque_peak_N_m", "residual_vibration"), marks=pytest.mark.long),
        ("contact_stress_max_MPa", "side_thrust_max_N"),
    ],
)
def test_any_axes_in_any_order(loaded, axes):
    found = frontier(loaded, axes, points=3, workers=1)
    values = np.array([[row[axis] for axis in axes] for row in found.rows])
    worse = (values[:, None] >= values[None]).all(axis=2) & (values[:, None] > values[None]).any(axis=2)
    assert len(found.rows) >= 3
    assert not worse.any()
    for axis, least in zip(axes, values.min(axis=0), strict=True):
        assert found.least[axis][0] <= least * (1 + 1e-3)
    assert all((row["bound"] is None) == (axes[0] in found.local) for row in found.rows)


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        (("size",), "two or three different axes"),
        (("size", "size"), "two or three different axes"),
        (("size", "velocity", "jerk", "acceleration"), "two or three different axes"),
        (("size", "acceleratoin"), "acceleration"),
        (("size", "profile_radius_min_mm"), "residual_vibration"),
        (("size", "film_ratio_min"), "residual_vibration"),
        (("size", "torque_peak_N_m"), "needs follower.dynamics.mass"),
        (("size", "contact_stress_max_MPa"), "needs follower.dynamics.mass, materials.cam"),
        (("size", "residual_vibration"), "needs follower.dynamics.natural_frequency"),
    ],
)
def test_axes_that_are_none(scene, axes, message):
    with pytest.raises(BadInput) as error:
        frontier(scene, axes)
    assert message in str(error.value)


def test_a_load_that_nothing_bounds_is_no_axis(scene):
    knife = find_scene("knife-300rpm-radial")
    with pytest.raises(BadInput, match="cannot be an axis for this follower"):
        frontier(knife, ("size", "contact_stress_max_MPa"))


@pytest.mark.slow
@pytest.mark.parametrize("outputs", [pytest.param(None, marks=pytest.mark.long), ["force"]])
def test_an_axis_is_called_for_where_the_scene_does_not(scene, outputs):
    """And so are the sizes, which are needed whatever the scene's outputs."""
    mass = {"follower.dynamics": {"mass": 0.5, "preload": 3000}, "outputs": outputs, "synthesis.pieces": 8}
    found = frontier(scene.replace(**mass), ("size", "power_peak_W"), points=2, workers=1)
    assert all(row["power_peak_W"] > 0.0 for row in [*found.rows, *found.known])


def test_freed_angles_are_for_optimise(scene):
    free = {"start": 80, "stop": 130}
    freed = scene.replace(**{"search.angle_rise": free, "search.angle_return": free})
    for ask in (synthesise, frontier):
        with pytest.raises(BadInput, match=r"search\.angle_rise"):
            ask(freed)


@pytest.mark.slow
def test_strokes_that_meet_have_finite_peak_factors():
    motion = [
        {"segment": "rise", "angle": 120, "lift": 20, "law": "poly345"},
        {"segment": "return", "angle": 120, "lift": 20, "law": "poly345"},
        {"segment": "dwell", "angle": 120},
    ]
    met = synthesise(find_scene("exhaust-valve").replace(motion=motion, **{"limits.pressure_angle": 30}))
    for peaks in met.peaks.values():
        assert peaks["peak_jerk"] <= 60.0


def test_a_frontier_of_nothing(scene):
    with pytest.raises(Unmet, match="no free law with this number of pieces meets all limits"):
        frontier(scene.replace(**{"limits.velocity": 2.0}), points=2, workers=1)


# ------------------------------------------------------------------------------------------------ how long it takes


@pytest.mark.parametrize(
    ("kinds", "workers", "clock", "told"),
    [
        ((2, 0, 1, 24), 1, [0.4, 0.4, 0.7], []),  # 0.7 + 24 · 0.3 s is no long time
        ((2, 0, 1, 24), 1, [4.0], [(25, "0:00:54")]),
        ((2, 0, 1, 24), 2, [4.0], [(25, "0:00:56")]),  # 4 + 13 · 4 s
        ((1, 1, 1, 9), 1, [1.0, 11.0], [(10, "0:01:51")]),
        ((1, 1, 1, 9), 1, [4.0, 44.0], [(11, "0:00:48"), (10, "0:07:24")]),  # the second kind takes far longer
    ],
)
def test_a_long_frontier_is_told_beforehand(monkeypatch, kinds, workers, clock, told):
    """What has passed, and each round of the searches to come as long as one of the last kind."""
    times, found = iter([0.0, 0.0, *clock]), []
    monkeypatch.setattr(searches, "monotonic", lambda: next(times))
    foreseen = searches.SearchTimeEstimate(kinds, workers, found.append)
    for _ in clock:
        foreseen.record_kind_and_announce_time()
    ends = "in all; fewer points take less"
    assert found == [f"{count} more searches for a motion, about {time} {ends}" for count, time in told]


@pytest.mark.slow
def test_it_is_told_before_the_first_point(monkeypatch):
    monkeypatch.setattr(searches, "LONG_SECONDS", 0.0)
    events = []
    coarse = find_scene("roller-1000rpm").replace(**COARSE | {"synthesis.pieces": 8})
    frontier(coarse, points=2, workers=1, progress=lambda done, _: events.append(done), tell=events.append)
    assert "3 more searches for a motion, about " in events[0]
    assert events[-2:] == [1, 2]
