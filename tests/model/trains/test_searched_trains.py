"""Numbers of a train that a search varies: against scenes of their own, and against dense scans."""

from itertools import product

import pytest

from camopt import (
    BadInput,
    evaluate,
    evaluate_designs,
    find_scene,
    load,
    optimise,
    prices,
    scene_of,
    sweep,
    synthesise,
)
from camopt.core.quantities import QUANTITIES, STAGE_NUMBER_KEYS, in_column_order
from camopt.scene.choices import searchable_number_types
from camopt.scene.problem.problem import resolve
from camopt.scene.train import TrainStage

SLIDE, VALVE = find_scene("slide-by-bell-crank"), find_scene("valve-with-rocker")
CARRYING = {
    "follower.dynamics.mass": 0.08,
    **{f"train.1.{key}": each for key, each in {"mass": 0.1, "spring_rate": 30.0, "preload": 250.0}.items()},
    "outputs": ["force"],
}
QUESTIONS = {
    "lengths": SLIDE.replace(
        search={
            "base_radius": {"start": 45, "stop": 85, "step": 20},
            "law": ["modified-sine", "poly345"],
            "train.1.coupler": [220, 230.5],
            "train": {"1": {"crank": {"start": 120, "stop": 170, "step": 25}}},
            "minimise": ["base_radius_mm", "acceleration_max_follower_rad_s2", "train_1_crank_mm"],
        }
    ),
    "a sample": SLIDE.replace(
        search={
            "base_radius": {"start": 45, "stop": 85},
            "train": {"1": {"angle": {"start": -115, "stop": -100}, "offset": [-150, -140]}},
            "samples": 9,
        }
    ),
    "what it carries": VALVE.replace(
        **CARRYING,
        search={
            "base_radius": [20, 30],
            "train": {"1": {"mass": [0.05, 0.2], "preload": [200, 300], "input_arm": 24, "friction_force": 7}},
            "follower": {"dynamics": {"mass": [0.08, 0.1]}},
            "minimise": ["base_radius_mm", "contact_force_max_N"],
        },
    ),
}


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("question", QUESTIONS)
def test_rows_of_a_sweep_are_scenes_of_their_own(question, tmp_path):
    swept = sweep(QUESTIONS[question], tmp_path, keep="all")
    rows, front = load(tmp_path / "designs.parquet"), load(tmp_path / "pareto.parquet")
    assert len(rows) == swept.designs - swept.impossible > 8
    for table, tolerance in ((rows, 1e-9), (front, 0.0)):
        for row in table.index:
            alone = evaluate(scene_of(table, row))
            for name in set(table.columns) - {"relative_half_width"}:
                value = table.loc[row, name]
                if isinstance(value, float) and name in alone:
                    assert value == pytest.approx(alone[name], rel=tolerance, abs=tolerance), name
                else:
                    assert value == alone.get(name, value)


def test_the_scenes_own_train_gives_the_same_rows_bit_for_bit(tmp_path):
    plain = {"base_radius": {"start": 45, "stop": 85, "step": 5}, "law": ["modified-sine", "poly345"]}
    sweep(SLIDE.replace(search=plain), tmp_path / "plain", keep="all")
    sweep(SLIDE.replace(search={**plain, "train.1.coupler": [220]}), tmp_path / "searched", keep="all")
    one, other = (load(tmp_path / name / "designs.parquet") for name in ("plain", "searched"))
    assert other.pop("train_1_coupler_mm").eq(220).all()
    assert one.equals(other)


@pytest.mark.slow
@pytest.mark.usefixtures("_boxes")
@pytest.mark.parametrize("angle", [[], ["transmission_angle_min_deg"]], ids=["costs", "and a transmission angle"])
def test_boxes_give_the_front_of_the_sweep(angle, tmp_path):
    """Row for row: each linkage of the grid has boxes of its own, which those of all others dominate."""
    scene = QUESTIONS["lengths"].replace(**{"search.base_radius.step": 0.5, "search.maximise": angle})
    fronts = []
    for keep in ("feasible", "front-only"):
        found = sweep(scene, out=tmp_path / keep, keep=keep)
        assert found.pareto > 2
        fronts.append(load(tmp_path / keep / "pareto.parquet"))
    assert fronts[0].equals(fronts[1])


def test_trains_that_cannot_move_so_are_impossible_designs_with_a_reason():
    scene = SLIDE.replace(search={"base_radius": [60, 70], "train.1.coupler": [5, 220]})
    swept = sweep(scene)
    assert (swept.designs, swept.impossible) == (4, 2)
    with pytest.raises(BadInput) as refused:
        scene.replace(**{"train.1.coupler": 5})
    assert swept.obstacle.startswith("1 of 2 motions through a train, such as train.1: ")
    assert str(refused.value).split("train.1: ")[1] in swept.obstacle
    assert "train.1.coupler = 5" in swept.obstacle
    table = evaluate_designs(scene, {"base_radius_mm": [60, 60], "train_1_coupler_mm": [5, 220]})
    assert table["violated"].tolist() == ["assembly", ""]
    assert table["train_1_coupler_mm"].tolist() == [5, 220]
    none = sweep(scene.replace(search={"train.1.coupler": [5]}))
    assert none.impossible == none.designs == 1
    assert none.nearest_miss is None
    assert "train.1.coupler = 5" in none.obstacle


def test_a_dead_point_within_the_motion_is_told_with_its_angle():
    scene = SLIDE.replace(search={"train": {"1": {"angle": {"start": -110, "stop": -60, "step": 50}}}})
    swept = sweep(scene)
    assert swept.impossible == 1
    assert "(cam angle " in swept.obstacle
    found = optimise(scene.replace(**{"search.train.1.angle": [-60]}))
    assert found.best is None
    assert "(cam angle " in found.obstacles["modified-sine"]


@pytest.mark.slow
def test_optimise_takes_the_best_of_listed_trains():
    search = {"train.1.coupler": [5, 210, 230], "train.1.crank": [140, 160]}
    found = optimise(SLIDE.replace(search=search))
    alone = [
        optimise(SLIDE.replace(search=None, **{"train.1.coupler": coupler, "train.1.crank": crank})).best
        for coupler, crank in product([210, 230], [140, 160])
    ]
    best = min(alone, key=lambda each: each["base_radius_mm"])
    assert found.best["proved"]
    assert found.best["base_radius_mm"] == pytest.approx(best["base_radius_mm"], rel=1e-9)
    assert found.best.scene.train == best.scene.train
    (price,) = prices(found)["modified-sine"]
    (price_alone,) = prices(optimise(best.scene.replace(search=None)))["modified-sine"]
    assert price.price == pytest.approx(price_alone.price, rel=1e-6)


@pytest.mark.slow
def test_trains_that_no_proof_covers_are_told(monkeypatch):
    monkeypatch.setattr("camopt.solve.smallest.optimise.OPTIMISE_WORK", 2e6)
    ranges = {"crank": (130.0, 190.0), "offset": (-160.0, -120.0), "coupler": (200.0, 240.0)}
    search = {"train": {"1": {key: {"start": low, "stop": high} for key, (low, high) in ranges.items()}}}
    found = optimise(SLIDE.replace(search=search))
    assert found.out_of_time
    assert not found.best["proved"]
    assert found.best["gap_mm"] > 0.0
    assert any("no proof covers the others" in warning for warning in found.warnings)
    assert evaluate(found.best.scene)["feasible"]


@pytest.mark.slow
def test_the_best_train_may_be_at_the_end_of_its_range():
    free = SLIDE.replace(search={"train": {"1": {"crank": {"start": 130, "stop": 190}}}})
    found, alone = optimise(free), optimise(SLIDE.replace(search=None, **{"train.1.crank": 190}))
    assert found.best["train_1_crank_mm"] == 190.0
    assert found.best["base_radius_mm"] == pytest.approx(alone.best["base_radius_mm"], rel=1e-9)
    hurried = optimise(free, seconds=0.1)
    assert hurried.out_of_time
    assert hurried.best is None or hurried.best["base_radius_mm"] >= found.best["base_radius_mm"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"search.train": {"2": {"crank": [3]}}}, "search.train.2: the train of the scene has 1 stage"),
        ({"search.train": {"one": {"crank": [3]}}}, "search.train.one = {'crank': [3]}: not the number of a row"),
        ({"search.train": {"1": {"rocker": [3]}}}, "search.train.1.rocker = [3]: a bell crank has no rocker"),
        ({"search.train": {"1": {"crossed": True}}}, "search.train.1.crossed = True: not a number of this table"),
        ({"search.train": {"1": {"crank": [0]}}}, "search.train.1.crank.1 = 0.0: must be at least"),
        ({"search.train": 3}, "search.train = 3: must be a table"),
        ({"search.train": {"1": 3}}, "search.train.1 = 3: must be a table"),
        (
            {"train.1.load": [[0, 1], [180, 2]], "search.train": {"1": {"load": [3]}}},
            "train.1.load changes over the turn; a single number cannot replace it",
        ),
    ],
)
def test_what_is_no_number_of_a_stage_is_refused(changes, message):
    with pytest.raises(BadInput) as refused:
        SLIDE.replace(**changes)
    assert message in str(refused.value)


def test_what_does_not_search_trains_says_so():
    scene = SLIDE.replace(**{"search.train.1.crank": {"start": 150, "stop": 160}, "search.roller_radius": None})
    with pytest.raises(BadInput, match=r"search.train.1.crank.step: must be above 0 for a sweep"):
        sweep(scene)
    with pytest.raises(BadInput, match=r"train"):
        synthesise(scene)
    freed = {"rise": {"start": 100, "stop": 120}, "dwell": {"start": 50, "stop": 90}}
    both = scene.replace(**{f"search.angle_{kind}": ends for kind, ends in freed.items()})
    with pytest.raises(BadInput, match=r"cannot have a range while angles of the motion are free"):
        optimise(both)


def test_keys_may_be_quoted_and_have_units():
    search = {"train.1.coupler": ["21 cm", 220], "cam.rpm": [100], "train": {"1": {"crank": ["1.5 dm"]}}}
    quoted = SLIDE.replace(search=search)
    numbers = {"cam.rpm": (100.0,), "train.1.coupler": (210.0, 220.0), "train.1.crank": (150.0,)}
    assert quoted.search.numbers == numbers
    assert quoted == type(quoted).from_dict(quoted.to_dict())
    assert [each.quantity for each in resolve(quoted).search_space.trains] == [
        "train_1_coupler_mm",
        "train_1_crank_mm",
    ]
    with pytest.raises(BadInput, match=r"search.train.1.crank = \[150\]: is given twice"):
        SLIDE.replace(search=search | {"train.1.crank": [150]})


def test_every_number_of_a_stage_may_be_searched():
    assert {key for key, hint in searchable_number_types(TrainStage).items() if hint} == {*STAGE_NUMBER_KEYS}


def test_numbers_of_stages_are_quantities_behind_the_other_sizes():
    names = ["rpm", "train_1_ratio", "train_2_spring_rate_N_m_per_rad", "acceleration_max_m_s2", "feasible"]
    assert in_column_order({*names}) == names
    assert QUANTITIES["train_2_spring_rate_N_m_per_rad"].unit == "N·m/rad"
    for name in ("train_0_crank_mm", "train_1_crank", "train_1_crank_deg", "train_1_law_mm", "train_1_ratio_mm"):
        assert name not in QUANTITIES
