"""The cheapest grades, against all sets of grades and against the convex programme without grades."""

import json
from itertools import product

import cvxpy as cp
import numpy as np
import pytest

import camopt
from camopt.core.mistakes import BadInput
from camopt.scene.iso286 import limit_deviations
from camopt.scene.problem.problem import resolve_design
from camopt.solve.tolerances import allocation
from camopt.solve.tolerances.response import ToolResponse
from tests.solve.tolerances.test_tolerance import scene_of

GIVEN = {"follower.roller_radius": "h6", "follower.offset": {"plus": 0.03, "minus": 0.01}, "phase": 0.02}
ARM = {"follower.arm_length": "js7", "follower.centre_distance": "js7", "profile": 0.02}
FOUR = {6: 3.0, 7: 1.5, 8: 1.0, 9: 0.7}


@pytest.mark.long
@pytest.mark.parametrize(("contact", "given", "within"), [("offset-roller", GIVEN, 0.09), ("arm", ARM, 0.045)])
def test_no_set_of_grades_that_keeps_the_distance_is_cheaper(contact, given, within):
    """By the proved worst case of each set."""
    scene = scene_of(contact, given=given)
    found = camopt.allocate(scene, within, costs=FOUR)
    held = {}
    for grades in product(FOUR, repeat=len(found.tolerances)):
        changes = {}
        for each, grade in zip(found.tolerances, grades, strict=True):
            of_base = limit_deviations(f"js{grade}", 140.0).upper
            named = f"{each.named.rstrip('0123456789')}{grade}"
            changes[f"tolerances.{each.key}"] = of_base if each.key == "profile" else named
        bound = camopt.tolerance(scene.replace(**changes)).worst_case.bound
        if bound <= within:
            held[sum(FOUR[grade] for grade in grades)] = grades
    assert held
    assert found.cost == found.least_cost == min(held)
    assert found.worst_case.bound <= within
    again = camopt.tolerance(found.scene).worst_case
    assert again.bound == pytest.approx(found.worst_case.bound, rel=2e-5)


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "given", "within", "only"),
    [
        ("pump-of-constant-breadth", {"profile": 0.02, "bore_eccentricity": 0.005}, 0.04, ()),
        ("face-groove-shutter", {"profile": 0.02, "follower.arm_length": "js7"}, 0.04, ()),
        (
            "bottle-filler-by-rib",
            {"profile": 0.01, "follower.roller_radius": "h5", "phase": 0.01},
            0.06,
            ("profile",),
        ),
    ],
)
def test_the_grades_of_followers_held_from_both_sides_are_the_cheapest_too(name, given, within, only):
    """Of those with which each cam has a preload, where one is meant to; the rib would be within with IT7."""
    scene, grades = camopt.find_scene(name).replace(part={}, limits={}, tolerances=given), (5, 6, 7)
    found, held = camopt.allocate(scene, within, costs=dict(zip(grades, (4, 3, 2), strict=True)), only=only), {}
    asked = [each.key for each in found.tolerances]
    body = scene.cam.base_radius or scene.cam.mean_radius
    for tried in product(grades, repeat=len(asked)):
        named = {
            key: limit_deviations(f"js{grade}", 2 * body).upper if key == "profile" else f"h{grade}"
            for key, grade in zip(asked, tried, strict=True)
        }
        of = camopt.tolerance(scene.replace(**{f"tolerances.{key}": each for key, each in named.items()}))
        kept = all(each.least > 0.0 for each in of.plays if each.what == "preload")
        if kept and of.worst_case.bound <= within:
            held.setdefault(sum(9 - each for each in tried), []).append(tried)
    assert found.cost == found.least_cost == min(held)
    assert tuple(each.grade for each in found.tolerances) in held[min(held)]
    assert set(asked) == set(only) or not only
    assert found.worst_case.bound <= within
    if name.startswith("bottle"):
        loose = camopt.tolerance(scene.replace(**{"tolerances.profile": limit_deviations("js7", 2 * body).upper}))
        assert loose.worst_case.bound <= within
        assert next(each for each in loose.plays if each.what == "interference").least < 0.0


def test_grades_cost_no_less_than_the_best_widths_of_reciprocal_cost():
    """Σ B/T under the linear worst case at some cam angles, a convex programme; with one of them alone by
    Lagrange's rule, T² ~ B/c, which gives (Σ √(Bc))²/X."""
    scene = scene_of("offset-roller", given={"follower.offset": "js7", "profile": 0.02})
    problem, within = resolve_design(scene), 0.05
    widths = {
        "follower.offset": {grade: limit_deviations(f"js{grade}", 11.0).upper for grade in range(5, 13)},
        "profile": {grade: limit_deviations(f"js{grade}", 140.0).upper for grade in range(5, 13)},
    }
    price = {"follower.offset": 0.01, "profile": 0.03}
    costs = {key: {grade: price[key] / t for grade, t in each.items()} for key, each in widths.items()}
    found = camopt.allocate(scene, within, costs=costs)
    answers = ToolResponse(problem, np.linspace(0.01, 6.27, 400))
    c = np.abs([answers.number_response("follower.offset")[0], answers.profile_response[0]])
    t, b = cp.Variable(2, pos=True), np.array([*price.values()])
    best = cp.Problem(cp.Minimize(cp.sum(cp.multiply(b, cp.inv_pos(t)))), [c.T @ t <= within]).solve()
    one = c[:, c.sum(axis=0).argmax()]
    alone = np.sum(np.sqrt(b * one)) ** 2 / within
    assert alone <= best * (1 + 1e-6)
    assert best <= found.cost * (1 + 1e-6)
    assert found.cost < 1.6 * best


def test_unreachable_limits_and_invalid_costs_are_refused(tmp_path):
    scene = scene_of("offset-roller", given=GIVEN)
    for within, costs, said in (
        (0.001, None, "no permitted grades keep ±0.001 mm: even with the finest ones a cam has an error of"),
        (-1.0, None, "a distance above 0"),
        (0.1, {6: 1.0, 7: 2.0}, "must be at least the cost of the coarser grade 7"),
        (0.1, {6.5: 1.0}, "a grade, 1 to 18"),
        (0.1, {"follower.offset": {7: 1.0}}, "costs.follower.roller_radius"),
        (0.1, tmp_path / "none.csv", "must be a CSV file"),
    ):
        with pytest.raises(BadInput, match=said):
            camopt.allocate(scene, within, costs=costs)
    with pytest.raises(BadInput, match=r"only = 'follower.ofset': is not a tolerance with a grade; did you mean"):
        camopt.allocate(scene, 0.1, only=["follower.ofset"])
    with pytest.raises(BadInput, match="has no tolerance with a grade"):
        camopt.allocate(scene_of(given={"phase": 0.1}), 0.1)


@pytest.mark.slow
def test_the_command_allocates_by_a_file_of_costs(command, tmp_path):
    file, costs = tmp_path / "cut.toml", tmp_path / "costs.csv"
    file.write_text(scene_of("offset-roller", given=GIVEN).to_toml())
    costs.write_text("grade,cost,follower.offset\n6,3,9\nIT7,1.5,8\n8,1,7\n9,0.7,1\n")
    code, out, err = command("tolerance", file, "--allocate", "0.09", "--costs", costs, "--out", tmp_path / "out")
    assert (code, "the cheapest grades within ±0.09 mm" in out, "allocated.toml" in err) == (0, True, True)
    assert "--allocate = '0': must be a tool error" in command("tolerance", file, "--allocate", "0")[2]
    found = json.loads(command("tolerance", file, "--allocate", "90 µm", "--costs", costs, "--json")[1])[
        "allocation"
    ]
    assert {each["key"]: each["named"] for each in found["tolerances"]}["follower.offset"] == "js9"
    assert found["worst_case"]["bound"] <= 0.09
    allocated = camopt.Scene.from_toml(tmp_path / "out" / "allocated.toml")
    assert allocated.tolerances.numbers["follower.offset"].iso == "js9"
    assert command("tolerance", file, "--costs", costs)[0] == 2


def test_proofs_count_for_the_budget_of_the_search(monkeypatch):
    """Else sets of grades without a proof would take all the work of a proof each."""
    proofs, searches = [], []
    make, search = allocation.Budget, allocation.search_budget
    monkeypatch.setattr(allocation, "Budget", lambda *each: proofs.append(make(*each)) or proofs[-1])
    monkeypatch.setattr(allocation, "search_budget", lambda *each: searches.append(search(*each)) or searches[-1])
    camopt.allocate(scene_of("offset-roller", given=GIVEN), 0.09, costs=FOUR)
    assert proofs
    assert searches[0].meter.work >= sum(each.meter.work for each in proofs) > 0.0
