"""Limits on the cam as a part: judged, proved, swept and optimised, each against its quantity."""

import numpy as np
import pytest
from support import cams
from support.balls.curves import in_balls
from support.balls.proof import exact_turn
from support.balls.section import STROKE_PARTS, integrated_rows, section_rows
from support.cams import CONTACTS
from support.depth import covering_cases
from support.part_cams import BODY, GROOVED, HUB, cam_of, quantity_of, scene_of

from camopt import (
    BadInput,
    certify,
    evaluate,
    evaluate_designs,
    find_scene,
    load,
    optimise,
    shipped_scenes,
    sweep,
    synthesise,
)
from camopt.core.mistakes import Unmet
from camopt.core.quantities import AT_MOST, QUANTITIES
from camopt.core.quantities.limit_keys import LIMIT_KEYS
from camopt.model.effects import EvaluationBlock, section
from camopt.model.effects.peak import DOUBLES, CutterExcessOverRoller, DegreeScale, MotionDerivative
from camopt.scene.limits import Limits
from camopt.scene.problem.limits import PART_LIMITS, SINGLE_QUANTITY_KEYS
from camopt.scene.problem.problem import resolve, resolve_design, with_rounding_relative_error
from camopt.show.reporting.sections import limits_table

OPEN = [contact for contact in CONTACTS if contact not in GROOVED]
KEYS = (*PART_LIMITS, "cutter_radius")
CASES = [(contact, key) for contact in CONTACTS for key in KEYS if quantity_of(key, contact)[0]]


def test_a_short_key_with_a_quantity_makes_a_limit():
    """Its group in ``limit_keys`` decides that: a key of another group would be read, and nothing would hold it."""
    keys = {key.key for key in LIMIT_KEYS.values() if key.quantity}
    assert keys <= {*SINGLE_QUANTITY_KEYS}, "put the key into LOAD_KEYS, PART_KEYS or ERROR_KEYS"


def test_all_limits_on_the_part_are_tried():
    assert {key for _, key in CASES} == {*KEYS}
    assert {*KEYS} <= Limits.model_fields.keys()
    assert {key for contact, key in CASES if contact in GROOVED} == {*KEYS} - {"area", "unbalance", "cutter_radius"}


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("contact", "key"), covering_cases(CASES, lambda case: case))
def test_a_limit_is_held_up_to_its_quantity_and_no_further(contact, key):
    """Beside the bound evaluate and certify agree; the errors of its quadrature decide the mass of a groove."""
    name, side = quantity_of(key, contact)
    value = cam_of(contact)[name]
    for share, held in ((1e-10, True), (-1e-10, False), (0.2, True), (-0.2, False)):
        scene = scene_of(contact).replace(**{f"limits.{key}": value * (1.0 + side * share), "outputs": [name]})
        found = evaluate(scene)
        assert found["violated"] == ("" if held else key)
        assert certify(scene)[key] == ("held" if held else "broken")


CORNERED = ["uniform-knife-offset", "uniform-knife-radial"]


@pytest.mark.parametrize("name", CORNERED)
def test_balls_say_nothing_of_a_motion_with_corners(name):
    problem = with_rounding_relative_error(resolve_design(find_scene(name)))
    assert [*integrated_rows(problem, exact_turn(problem.programme), problem.design, problem.design, ())] == []


DISCS = [name for name in shipped_scenes() if find_scene(name).mechanism.body.bounded]


@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", sorted({*DISCS} - {*CORNERED}))
def test_balls_hold_what_quadrature_finds(name):
    """Two ways, of Gauss's rule in doubles and of Taylor series in balls: they meet in each other's errors."""
    problem = with_rounding_relative_error(resolve_design(find_scene(name)))
    rows = section_rows(problem, exact_turn(problem.programme), in_balls(problem.design), STROKE_PARTS[1])
    found = section.evaluate_columns(EvaluationBlock(problem.setup, problem.programme, problem.design), frozenset())
    for quantity, (value, error, scale) in found.items():
        low, width = rows.columns[quantity], rows.outward[quantity]
        assert np.all(low - error <= value)
        assert np.all(value <= low + width + error)
        assert np.all(error <= 1e-12 * scale)
        assert np.all(width >= 0.0)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", OPEN)
def test_balls_hold_the_sections_of_all_mechanisms(contact, rotation):
    scene = scene_of(contact, "poly345", rotation).replace(**{"cam.base_radius": 85})
    problem = with_rounding_relative_error(resolve_design(scene))
    found = section.evaluate_columns(EvaluationBlock(problem.setup, problem.programme, problem.design), frozenset())
    widths = []
    for parts in STROKE_PARTS[1:4]:
        rows = section_rows(problem, exact_turn(problem.programme), in_balls(problem.design), parts)
        for quantity, (value, error, _) in found.items():
            assert (
                rows.columns[quantity] - error <= value <= rows.columns[quantity] + rows.outward[quantity] + error
            )
        widths.append(float(rows.outward[section.AREA][0] / found[section.AREA].value[0]))
    assert widths[-1] < 1e-12
    assert widths[1] <= widths[0] * 2.0**-9 or widths[1] < 1e-14  # of order 11, but for rounding


def test_a_hollow_corner_stops_every_cutter():
    scene = scene_of("roller", "uniform").replace(**{"limits.area": 1e6, "limits.cutter_radius": 1.0})
    assert {key: certify(scene)[key] for key in ("area", "cutter_radius")} == {
        "area": "held",
        "cutter_radius": "broken",
    }
    assert "cutter_radius" in evaluate(scene)["violated"]


def test_any_cutter_no_larger_than_the_roller_will_do():
    roller = scene_of("roller").replace(**{"limits.cutter_radius": 14.0})
    assert certify(roller)["cutter_radius"] == "held"
    assert CutterExcessOverRoller(14.0)(resolve_design(roller).design)[0] == 0.0


# ------------------------------------------------------------------------------------------------- searches


SIZES = np.arange(24.0, 44.0, 1.0)


@pytest.mark.parametrize("key", KEYS)
def test_a_sweep_keeps_the_designs_that_hold_it(key):
    name, side = quantity_of(key, "roller")
    search = {"base_radius": SIZES.tolist(), "law": ["cycloidal"]}
    part = BODY if key == "hub_wall" else scene_of("roller").part
    base = scene_of("roller", "cycloidal").replace(search=search, outputs=[name], part=part)
    table = evaluate_designs(base, {"base_radius_mm": SIZES, "law": "cycloidal"})
    bound = float(table[name][np.isfinite(table[name])].median()) * (1 + 1e-3)
    held = table["feasible"] & (side * table[name] <= side * bound)
    assert held.any()
    limits = resolve(base.replace(**{f"limits.{key}": bound})).limits
    of_motion = next(limit.is_decided_by_motion_alone for limit in limits if limit.name == key)
    assert of_motion or not held.all()
    assert sweep(base.replace(**{f"limits.{key}": bound})).feasible == held.sum()
    inside = evaluate_designs(
        base.replace(**{f"limits.{key}": bound}), {"base_radius_mm": SIZES, "law": "cycloidal"}
    )
    assert (inside["feasible"] == held).all()
    sign = (inside[f"excess_{key}"] <= 0.0) == (side * table[name] <= side * bound)
    assert sign.all()


@pytest.mark.usefixtures("_boxes")
@pytest.mark.parametrize("key", KEYS)
def test_boxes_of_designs_lead_to_the_front_of_the_full_sweep(key):
    """Where a size decides, ranges of it do; where an integral does, designs are evaluated one by one."""
    name, side = quantity_of(key, "offset-roller")
    search = {"base_radius": SIZES.tolist(), "offset": [-5.0, 0.0, 5.0], "roller_radius": [8.0, 14.0]}
    scene = scene_of("offset-roller").replace(search={**search, "law": ["cycloidal"]}, outputs=[name])
    bound = cam_of("offset-roller", "cycloidal")[name] * (1 + side * 0.1)
    limited = scene.replace(part=BODY if key == "hub_wall" else scene.part, **{f"limits.{key}": bound})
    full, boxes = sweep(limited), sweep(limited, keep="front-only")
    assert full.feasible > 0
    assert boxes.pareto == full.pareto
    assert boxes.front == full.front


@pytest.mark.parametrize("contact", ["roller", "flat", "groove"])
def test_the_smallest_cam_with_a_wall(contact):
    """Bore, keyway and wall, and half the depth of a groove: a closed form."""
    part = {**BODY, **({"groove_depth": 10, "thickness": 70} if contact == "groove" else {})}
    wide = scene_of(contact).replace(part=part, outputs=None, **{"limits.hub_wall": 100.0})
    key = "mean_radius" if contact == "groove" else "base_radius"
    best = optimise(wide.replace(**{f"search.{key}": {"start": 20, "stop": 500}})).best
    reach = np.hypot(12.5 + 3.3, 4.0) + (5.0 if contact == "groove" else 0.0)
    assert best[f"{key}_mm"] == pytest.approx(100.0 + reach, rel=1e-12)
    assert (best["binding"], best["proved"]) == (["hub_wall"], True)
    hub = optimise(scene_of("roller").replace(**{"limits.hub_wall": 6.0, "outputs": None}))
    assert hub.best is None
    assert set(hub.obstacles.values()) == {"hub_wall"}


def test_the_smallest_cam_that_a_wheel_can_grind():
    """No smaller size than the optimum lets the wheel reach every flank."""
    base = find_scene("roller-1000rpm").replace(search={"law": ["poly345"]}, outputs=[])
    best = optimise(base.replace(**{"limits.pressure_angle": 40, "limits.cutter_radius": 250.0})).best
    assert best["proved"]
    assert "cutter_radius" in best["binding"]
    assert evaluate(best.scene)["cutter_radius_max_mm"] == pytest.approx(250.0, rel=1e-6)


@pytest.mark.slow
def test_a_change_of_lift_is_a_velocity():
    """By degree at 1000 rev/min, to evaluate, to optimise over angles and to synthesise."""
    base = find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    slow = 0.95 * evaluate(base)["velocity_max_m_s"]
    by_degree = slow * 1e3 / (1000 * np.pi / 30) * np.pi / 180
    one, two = (
        synthesise(base.replace(**limit))
        for limit in ({"limits.velocity": slow}, {"limits.lift_change": by_degree})
    )
    assert two.design["base_radius_mm"] == pytest.approx(one.design["base_radius_mm"], rel=1e-6)
    assert evaluate(two.scene.replace(outputs=["lift_change"]))["feasible"]
    constraints = [
        each
        for each in resolve(base.replace(**{"limits.lift_change": by_degree})).constraints
        if isinstance(each.curve, MotionDerivative)
    ]
    assert [constraint.upper_bound_of_each_side() for constraint in constraints] == [
        pytest.approx(slow * 1e3 / (1000 * np.pi / 30), rel=1e-15)
    ]
    assert DegreeScale(0).weighted_extreme_for_quantity(2.0, DOUBLES) == 2.0


@pytest.mark.parametrize("hub", [{}, HUB])
@pytest.mark.parametrize("key", ["area", "cam_mass", "cam_inertia"])
@pytest.mark.parametrize("contact", ["knife", "offset-roller", "flat", "spherical"])
def test_no_larger_cam_has_as_little(contact, key, hub):
    """Beyond the size that a limit tells its quantity is above the bound; of a disc it is the bound."""
    scene = scene_of(contact).replace(part={**BODY, **hub})
    name, bound = PART_LIMITS[key], 3.0 * cam_of(contact)[PART_LIMITS[key]]
    (limit,) = (each for each in resolve(scene.replace(**{f"limits.{key}": bound})).limits if each.name == key)
    beyond = scene.replace(**{"cam.base_radius": limit.most_size * (1 + 1e-9), "outputs": [name]})
    assert evaluate(beyond)[name] > bound
    still = beyond.replace(motion=cams.turn_of("cycloidal", 1e-6))
    assert evaluate(still)[name] == pytest.approx(bound, rel=1e-7)


@pytest.mark.slow
def test_that_a_wall_and_a_mass_contradict_each_other_is_proved():
    scene = scene_of("roller").replace(part=BODY, outputs=None, **{"limits.hub_wall": 60.0, "limits.cam_mass": 1.0})
    found = optimise(scene.replace(search={"law": ["cycloidal"]}), seconds=20)
    assert set(found.obstacles.values()) == {"hub_wall and cam_mass together"}
    assert not found.out_of_time


@pytest.mark.parametrize(
    "key", [key for key in PART_LIMITS if QUANTITIES[PART_LIMITS[key]].relation_to_limit == AT_MOST]
)
def test_no_cam_is_light_enough(key):
    """A limit that no cam of a range holds is named."""
    name, _ = quantity_of(key, "roller")
    scene = scene_of("roller").replace(search={"base_radius": {"start": 60, "stop": 70}}, outputs=None)
    found = optimise(scene.replace(**{f"limits.{key}": 1e-6 * cam_of("roller")[name]}), seconds=2)
    assert found.best is None
    assert key in next(iter(found.obstacles.values()))


@pytest.mark.parametrize(
    ("scene", "limit", "line"),
    [
        ("two-pauses", {"cam_mass": 1}, "limits.cam_mass = 1.0: needs part.thickness, part.density"),
        ("feeder-with-stop", {"area": 1e4}, "limits.area = 10000.0: this mechanism has no area_mm2"),
        ("feeder-with-stop", {"unbalance": 10}, "limits.unbalance = 10.0: this mechanism has no unbalance_g_mm"),
        ("knife-300rpm-radial", {"hub_wall": 10}, "limits.hub_wall = 10.0: needs part.bore"),
        (
            "bucket-valve",
            {"cutter_radius": 10},
            "limits.cutter_radius = 10: a flat face has no hollow flanks, so any",
        ),
        (
            "feeder-with-stop",
            {"cutter_radius": 12},
            "limits.cutter_radius = 12: the cutter of a groove is at most as large as its roller",
        ),
        ("two-pauses", {"area": -1}, "limits.area = -1: must be at least 1e-15"),
    ],
)
def test_a_limit_that_cannot_be_asked_is_told(scene, limit, line):
    with pytest.raises(BadInput) as error:
        evaluate(find_scene(scene).replace(limits=limit))
    (found,) = str(error.value).splitlines()
    assert found.partition(": ")[2].startswith(line)


def test_free_laws_cannot_thicken_the_wall_of_a_hub():
    part = {"bore": 25, "hub_diameter": 44, "hub_length": 32, "thickness": 16}
    own = find_scene("roller-1000rpm").replace(part=part, **{"limits.hub_wall": 9.6})
    with pytest.raises(Unmet, match="no cam of any size meets the limits"):
        synthesise(own)


@pytest.mark.slow
def test_the_base_circle_is_no_smaller_than_the_hub(tmp_path):
    """A hub of Ø130 asks a base circle of at least 65 mm, of searches, sweeps and pages alike."""
    own = find_scene("roller-1000rpm").replace(
        **{"part": {"thickness": 10, "hub_diameter": 130, "hub_length": 20}, "cam.base_radius": 70}
    )
    eased = own.replace(
        **{"limits": {"pressure_angle": 60}, "search.base_radius": {"start": 60, "stop": 70, "step": 1}}
    )
    best = optimise(eased).best
    assert (best["base_radius_mm"], best["binding"]) == (65.0, ["hub_diameter"])
    sweep(eased, tmp_path, keep="all")
    table = load(tmp_path / "designs.parquet")
    broken = {each["base_radius_mm"]: each["violated"] for each in table.to_dict("records")}
    assert {radius for radius, names in broken.items() if "hub_diameter" in names} == {60, 61, 62, 63, 64}
    found = limits_table(evaluate(own), resolve_design(own))
    rows = {row[0].text: [cell.text for cell in row[1:5]] for row in found.rows}
    assert rows["hub diameter"] == ["held", "≥ 130 mm", "140 mm", "10 mm"]


def test_the_smallest_cam_has_room_for_its_keyway():
    scene = find_scene("two-pauses").replace(
        **{"limits.pressure_angle": 70, "cam.base_radius": 30},
        part={"thickness": 15, "keyway_width": 12, "keyway_depth": 5},
    )
    best = optimise(scene).best
    assert best["binding"] == ["keyway"]
    assert evaluate(best.scene.replace(outputs=["wall"]))["hub_wall_min_mm"] == pytest.approx(0.0, abs=1e-6)
    assert certify(best.scene)["keyway"] == "held"
    smaller = sweep(scene.replace(**{"search.base_radius": [24.0, 26.0]}), keep="all")
    assert (smaller.designs, smaller.feasible) == (2, 1)
