"""Fronts decided by boxes of designs against those of the full sweep, row for row and bit for bit."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import cache
from threading import Barrier, BrokenBarrierError
from time import sleep
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from support.cams import CONTACTS, GUIDED, WORN, cam_with
from support.depth import times

from camopt import Scene, evaluate, find_scene, load, sweep
from camopt.core.engines.threads import Threads
from camopt.core.numerics import dominance
from camopt.core.numerics.dominance import Dominators, PointTree
from camopt.core.quantities import QUANTITIES
from camopt.model.effects import EvaluationBlock, available_quantities
from camopt.scene.problem.limits import LOAD_LIMITS
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.rows import concatenate_rows
from camopt.scene.problem.space import grid_space
from camopt.solve.front import curve_numbers as numbering
from camopt.solve.front import curve_verdicts, front_search, plan
from camopt.solve.front.blocks import SpaceBlocks, gather_batches
from camopt.solve.front.box_bounds import BoxBounds, can_bound_all_objectives, can_bound_objective
from camopt.solve.front.curve_numbers import shared_pitch_curve_numbers
from camopt.solve.front.curve_verdicts import CurveVerdicts, pitch_curves_decide_all_limits
from camopt.solve.front.front_search import FrontSearch
from camopt.solve.front.grid_boxes import Grid
from camopt.solve.front.pareto import LARGEST_COST, non_dominated, row_costs
from camopt.solve.front.plan import comparison_columns, sweep_columns, with_default_objectives
from camopt.solve.verdicts import feasible_filter
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.limit_verdicts import evaluate_with_verdicts_and_effort

SPREAD = {"base_radius": 0.5, "mean_radius": 0.5, "roller_radius": 0.4, "face_radius": 0.4, "arm_length": 0.2}
SWINGING_FACE = "swinging-face"
AROUND = {"offset": 12.0, "face_offset": 8.0}
LAWS = ("cycloidal", "poly345", "harmonic", "parabolic", "uniform", "modified-sine")


def axis(rng, middle, half, count):
    """Values around one, in any order."""
    values = np.round(middle + half * np.linspace(-1.0, 1.0, count), 3)
    return [float(v) for v in dict.fromkeys(rng.permutation(values).tolist())]


def axes_of(scene, rng, most):
    """A few values of each size that the mechanism has."""
    given_sizes = {**scene.cam.model_dump(), **scene.follower.model_dump()}
    keys = [key for key in (*SPREAD, "centre_distance") if given_sizes.get(key)]
    found = {}
    for key in keys:
        share = SPREAD.get(key, 0.2)
        found[key] = axis(rng, given_sizes[key], share * given_sizes[key], int(rng.integers(1, most)))
    if scene.follower.motion == "translating" and scene.cam.form == "disc":
        found["offset"] = axis(rng, 0.0, AROUND["offset"], int(rng.integers(1, most)))
    if given_sizes.get("face_offset"):
        found["face_offset"] = axis(rng, 0.0, AROUND["face_offset"], int(rng.integers(1, most)))
    return found


@cache
def cam_of(contact):
    """All quantities of a contact's own cam."""
    return evaluate(mechanism(contact)[0])


@cache
def mechanism(contact):
    """A scene of a contact that has every quantity, and its objectives that boxes bound, each with its sign."""
    dynamics = None if CONTACTS[contact]["motion"] == "oscillating" else GUIDED
    scene = Scene.from_dict(cam_with(contact, "poly345", dynamics, materials=WORN))
    setup = resolve(scene).setup
    names = [name for name in available_quantities(setup) if QUANTITIES[name].kind is float]
    return scene, [(name, sign) for name in names for sign in (1.0, -1.0) if can_bound_objective(name, sign, setup)]


def sample_objectives(objectives, rng, count):
    return [objectives[k] for k in rng.permutation(len(objectives))[:count]]


def search_of(axes, rng, objectives):
    """A table ``[search]``; no quantity is both minimised and maximised."""
    chosen = dict(reversed(objectives))
    least, most = ([name for name in chosen if chosen[name] == way] for way in (1.0, -1.0))
    laws = rng.permutation(LAWS)[: rng.integers(1, 4)].tolist()
    asked = {"minimise": least, "maximise": most}
    return {**axes, "law": laws, **{side: names for side, names in asked.items() if names}}


def question(contact, seed, most=6):
    """A random space of a mechanism: sizes, laws, objectives of both kinds, limits near what its cam has."""
    rng = np.random.default_rng(seed)
    scene, objectives = mechanism(contact)
    chosen = sample_objectives(objectives, rng, rng.integers(1, 4))
    search = search_of(axes_of(scene, rng, most), rng, chosen)
    tolerance = {"accuracy.relative_error": float(rng.choice([1e-9, 1e-4]))}
    return scene.replace(search=search, limits=limits_of(cam_of(contact), rng), outputs=None, **tolerance)


def limits_of(cam, rng):
    """Some limits, on what a cam has and a little more or less."""
    limits = {}
    for key, quantity in LOAD_LIMITS.items():
        if quantity in cam and np.isfinite(cam[quantity]) and cam[quantity] > 0.0 and rng.random() < 0.15:
            limits[key] = float(cam[quantity] * (1.0 + QUANTITIES[quantity].limit_sign * rng.uniform(-0.2, 0.5)))
    if "jamming_margin" in limits:
        limits["jamming_margin"] = min(limits["jamming_margin"], 0.99)
    if rng.random() < 0.5:
        limits["pressure_angle"] = min(80.0, rng.uniform(0.8, 1.5) * cam["pressure_angle_max_deg"]) or 45.0
    if rng.random() < 0.5:
        limits["curvature_radius"] = rng.uniform(0.2, 1.0) * max(cam["profile_radius_min_mm"], 0.1)
    return limits


def sweep_blocks(space, names, size, write, kept=True):
    """What is seen of a space that is swept block by block."""
    numbers = shared_pitch_curve_numbers(space)
    own = not (kept or numbers) and pitch_curves_decide_all_limits(space.problem, frozenset(names))
    blocks = SpaceBlocks(space, names, numbers, keep_rows=kept, block_size=size, decide_by_own_curves=own)
    batches = Threads(2).results_in_order(lambda numbers: blocks.evaluate_block(*numbers), range(len(blocks)))
    return gather_batches(space, batches, size, write, lambda done, total: None)


def both_fronts(scene, few, together=50):
    """The front by a full sweep and that by boxes, and what the search knows of its work."""
    problem = with_default_objectives(resolve(scene))
    assert can_bound_all_objectives(problem)
    space, names = grid_space(problem), sweep_columns(problem)
    full = sweep_blocks(space, names, 32768, lambda rows: None)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(front_search, "FEW_DESIGNS", few)
        patch.setattr(front_search, "BOUNDED_AT_ONCE", together)
        found = FrontSearch(space, names, 1, None).find_front()
    return full, found, len(space)


def shares_curves(contact):
    """Whether designs share curves: of a roller or a spherical face, or of a flat face of a disc."""
    return CONTACTS[contact]["contact"] in ("roller", "spherical") or contact in ("flat", SWINGING_FACE)


def plain_limits(contact):
    """Limits of which curves that designs share tell everything: those of a swinging face differ in their angle."""
    return {"curvature_radius": 1.0} | ({"pressure_angle": 30.0} if contact != SWINGING_FACE else {})


def same_rows(full, found):
    assert found.count == full.count
    assert set(found.columns) == set(full.columns)
    for name in full.columns:
        mine, theirs = found.column(name), full.column(name)
        assert np.array_equal(mine, theirs), (name, mine[mine != theirs][:3], theirs[mine != theirs][:3])


def with_repeated_sums(scene):
    """The scene with sizes that repeat their sums."""
    first = 74.0 if scene.follower.contact == "flat" else 24.0
    sizes = {
        key: [first, first + 0.5, first + 1.0, first + 6.0]
        for key in scene.search.model_fields_set & {"base_radius", "mean_radius"}
    }
    rollers = {
        key: [5.0, 5.5, 6.0]
        for key in scene.search.model_fields_set & {"roller_radius", "face_radius", "face_offset"}
    }
    return scene.replace(**{f"search.{key}": values for key, values in (sizes | rollers).items()})


def feasible_one_by_one(space, names):
    """How many designs can be assembled, and the feasible ones, each judged by the plain path."""
    found = []
    for problem, first, last in space.design_ranges_by_problem():
        designs = space.designs(np.arange(first, last))
        designs = designs.take(problem.setup.mechanism.can_assemble(designs, problem.programme))
        found.append(evaluate_with_verdicts_and_effort(problem, designs, frozenset(names))[0].select_columns(names))
    rows = concatenate_rows(found)
    return rows.count, rows.take(rows.column("feasible").astype(bool))


@pytest.mark.slow
@pytest.mark.one_in(5)
@pytest.mark.parametrize("contact", CONTACTS)
@given(seed=st.integers(0, 10**6), block=st.sampled_from([7, 50, 65536]), plain=st.booleans())
@settings(max_examples=times(4, deep=40))
def test_a_sweep_finds_what_the_plain_path_finds_of_each_design(contact, seed, block, plain):
    """With a table of designs and without: every count, row and digit, in the order of the space.

    Without, rows have fewer columns, and pitch curves tell of limits without the quantities that these bound.
    """
    scene = with_repeated_sums(question(contact, seed))
    if plain and shares_curves(contact):
        scene = scene.replace(limits=plain_limits(contact))
    problem = with_default_objectives(resolve(scene))
    space, names = grid_space(problem), sweep_columns(problem)
    existing, expected = feasible_one_by_one(space, names)
    front = non_dominated(expected, problem.objectives)
    for worth, kept in ((1.0, True), (1.0, False), (np.inf, False)):
        rows = []
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(numbering, "CURVES_AT_ONCE", 16)
            patch.setattr(numbering, "LEAST_SHARING", worth)
            patch.setattr(feasible_filter, "MANY_DESIGNS", 0)
            found = sweep_blocks(space, names if kept else comparison_columns(problem), block, rows.append, kept)
        assert (found.existing, found.feasible) == (existing, expected.count)
        if kept:
            same_rows(front, found.front)
            same_rows(expected, concatenate_rows(rows))
        else:  # the half-width is that of the columns which are there
            alike = set(comparison_columns(problem)) - {"relative_half_width"}
            same_rows(front.select_columns(alike), found.front.select_columns(alike))


@pytest.mark.slow
@pytest.mark.one_in(6)
@pytest.mark.parametrize("contact", [name for name in CONTACTS if shares_curves(name)])
@given(seed=st.integers(0, 10**6), block=st.sampled_from([7, 50, 32768]))
@settings(max_examples=times(4, deep=40))
def test_curves_that_designs_share_change_no_bit(contact, seed, block):
    """The full sweep with each pitch curve searched once, four together, and without; sizes repeat their sums."""
    scene = with_repeated_sums(question(contact, seed))
    if contact == SWINGING_FACE:  # else they share none
        scene = scene.replace(limits={"curvature_radius": 1.0 + seed % 30})
    problem = with_default_objectives(resolve(scene))
    space, names, tables = grid_space(problem), sweep_columns(problem), []
    for at_once, worth in ((4, 1.0), (4096, np.inf)):
        rows = []
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(numbering, "CURVES_AT_ONCE", at_once)
            patch.setattr(numbering, "LEAST_SHARING", worth)
            shared = shared_pitch_curve_numbers(space) is not None
            found = sweep_blocks(space, names, block, rows.append)
        tables.append((shared, found.existing, found.effort, found.reached, concatenate_rows(rows)))
    (shared, *counts, rows), (alone, *others, expected) = tables
    assert (shared, alone) == (True, False)
    assert counts == others
    same_rows(expected, rows)


def test_no_curve_is_lost_where_threads_begin_a_motion_together(monkeypatch):
    """Each made columns for the motion, and what the other had written in its own was gone."""
    scene = find_scene("roller-1000rpm")
    search = {"base_radius": [144.0, 145.0, 146.0, 160.0], "roller_radius": [14.0, 15.0, 16.0, 17.0]}
    problem = with_default_objectives(resolve(scene.replace(search=search)))
    monkeypatch.setattr(numbering, "CURVES_AT_ONCE", 3)
    monkeypatch.setattr(numbering, "LEAST_SHARING", 1.0)
    space, names = grid_space(problem), sweep_columns(problem)
    curves = CurveVerdicts(space, problem, shared_pitch_curve_numbers(space), frozenset(names))
    together = Barrier(2)

    def late(count):
        """Both threads are here before either goes on, and one writes before the other does."""
        with suppress(BrokenBarrierError):
            sleep(0.05 * together.wait(10.0))
        return np.zeros(count)

    alone = CurveVerdicts(space, problem, shared_pitch_curve_numbers(space), frozenset(names))

    def feasible(curves, first):
        """The rows of four designs, from one on."""
        _, _, surely, _, perhaps = curves.block_verdicts(first, first + 4, keep_dominated=True)
        assert not len(perhaps)
        return curves.evaluate_held_designs(surely, frozenset(names))

    expected = [feasible(alone, first) for first in (0, 12)]
    assert all(rows.count for rows in expected)
    with pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(2) as pool:
        patch.setattr(curve_verdicts, "np", SimpleNamespace(**{**vars(np), "zeros": late}))
        list(pool.map(lambda first: feasible(curves, first), (0, 12)))
    for first, rows in zip((0, 12), expected, strict=True):
        same_rows(rows, feasible(curves, first))


@pytest.mark.slow
@pytest.mark.one_in(12)
@pytest.mark.parametrize("contact", CONTACTS)
@given(seed=st.integers(0, 10**6), few=st.sampled_from([1, 2, 9]))
@settings(max_examples=times(3, deep=40))
def test_boxes_give_the_front_of_the_full_sweep(contact, seed, few):
    full, found, designs = both_fronts(question(contact, seed), few)
    same_rows(full.front, found.front)
    assert found.decided + found.evaluated >= designs


@pytest.mark.one_in(4)
@pytest.mark.parametrize("contact", CONTACTS)
@given(seed=st.integers(0, 10**6))
@example(seed=7386)  # a force that is the same for all designs: over an arm whose length does not vary
@settings(max_examples=times(3, deep=40))
def test_no_design_of_a_box_costs_less_than_its_bound(contact, seed):
    """Some objectives that boxes bound, of every design of random boxes, as the kernels find them."""
    rng = np.random.default_rng(seed)
    scene, objectives = mechanism(contact)
    search = search_of(axes_of(scene, rng, 4), rng, sample_objectives(objectives, rng, 8))
    problem = resolve(scene.replace(search=search, limits={}, outputs=None))
    space = grid_space(problem)
    grid, problem = Grid(space), space.problems[0]
    assume(grid.varied_fields)
    boxes = grid.whole_box_of_each_motion(len(problem.objectives)).take(slice(0, 1))
    while rng.random() < 0.8 and np.any(boxes.design_counts > 1):
        boxes = boxes.take(boxes.design_counts > 1)
        boxes = boxes.halve_boxes(np.argmax((boxes.high - boxes.low) * rng.random(boxes.low.shape), axis=1))
    looked = BoxBounds(problem, grid.varied_fields).bound_costs(grid.boxes_as_interval_designs(boxes))
    designs, home = (
        space.designs(grid.design_numbers_in_boxes(boxes)),
        np.repeat(np.arange(len(boxes)), boxes.design_counts),
    )
    exists = problem.setup.mechanism.can_assemble(designs, problem.programme)
    rows = run_effects(
        EvaluationBlock(problem.setup, problem.programme, designs.take(exists)), problem.required_quantities
    )
    costs = row_costs(rows, problem.objectives)
    assert np.all(looked.costs[home[exists]] <= costs)


@pytest.mark.slow
def test_the_default_scene():
    """A million designs, of which few are evaluated."""
    full, found, designs = both_fronts(find_scene("roller-1000rpm"), 64, 2048)
    same_rows(full.front, found.front)
    assert full.front.count == 426
    assert found.evaluated < 0.1 * designs
    assert found.decided > 0.9 * designs


@pytest.mark.slow
@pytest.mark.usefixtures("_boxes")
def test_boxes_do_not_depend_on_threads(tmp_path):
    scene = find_scene("roller-1000rpm").replace(**{"search.offset": {"start": -30, "stop": 30, "step": 5}})
    results = [sweep(scene, tmp_path / str(workers), keep="front-only", workers=workers) for workers in (1, 3)]
    tables = [(tmp_path / str(workers) / "pareto.parquet").read_bytes() for workers in (1, 3)]
    assert tables[0] == tables[1]
    assert results[0].evaluated == results[1].evaluated


@pytest.fixture(scope="module")
def ties():
    """A scene with ties, and with objectives that are infinite for some laws."""
    search = {"base_radius": list(range(40, 100, 3)), "offset": [-10, 0, 10], "roller_radius": [5, 20, 8]}
    search |= {"law": ["uniform", "parabolic", "poly345"], "minimise": ["jerk_max_m_s3"], "maximise": ["offset_mm"]}
    return find_scene("roller-1000rpm").replace(search=search, limits={"pressure_angle": 50})


def test_ties_and_infinities(ties):
    full, found, _ = both_fronts(ties, 4)
    same_rows(full.front, found.front)
    assert full.front.count > 20
    endless = ties.replace(**{"search.law": ["uniform", "parabolic"]})
    full, found, _ = both_fronts(endless, 4)
    same_rows(full.front, found.front)
    assert np.isinf(full.front.column("jerk_max_m_s3")).all()


@pytest.mark.usefixtures("_boxes")
def test_what_a_sweep_of_the_front_alone_tells(ties, tmp_path):
    usual, alone = (
        sweep(ties, tmp_path / "usual", keep="pareto"),
        sweep(ties, tmp_path / "alone", keep="front-only"),
    )
    assert (alone.feasible, alone.impossible) == (None, None)
    assert alone.front == usual.front
    assert alone.designs == usual.designs == usual.evaluated
    assert [file.name for file in alone.files] == ["pareto.parquet", "scene.toml"]
    tables = [load(tmp_path / name / "pareto.parquet") for name in ("usual", "alone")]
    assert tables[0].equals(tables[1])
    counted = {"designs": alone.designs, "evaluated": alone.evaluated, "decided_by_boxes": alone.decided_by_boxes}
    assert tables[1].attrs["sweep"] == counted
    assert {law: dict(row) for law, row in alone.best.items()}.items() <= {
        law: dict(row) for law, row in usual.best.items()
    }.items()


def test_the_front_of_a_large_space_is_found_by_boxes(ties, tmp_path, monkeypatch):
    """With the same tables: that of the designs which are kept has those on the front."""
    usual = sweep(ties, tmp_path / "usual", keep="pareto")
    tied = grid_space(resolve(ties))
    cost = (
        SpaceBlocks(tied, (), shared_pitch_curve_numbers(tied)).searched_curve_count + plan.DESIGN_COST * len(tied)
    ) / len(tied.problems)
    monkeypatch.setattr(plan, "BOXES_OF_ONE", cost)  # the jerk is that of the motion
    boxes, same = (sweep(ties, tmp_path / name, keep=name) for name in ("pareto", "front-only"))
    assert replace(same, files=boxes.files) == boxes
    assert (usual.decided_by_boxes, boxes.feasible, boxes.front) == (0, None, usual.front)
    assert boxes.decided_by_boxes + boxes.evaluated >= boxes.designs == usual.designs
    assert [file.name for file in boxes.files] == [file.name for file in usual.files]
    for file in ("pareto.parquet", "designs.parquet"):
        assert load(tmp_path / "pareto" / file).equals(load(tmp_path / "usual" / file))
    assert sweep(ties).feasible == usual.feasible  # who asks for no table has them counted
    assert sweep(ties, tmp_path / "more").feasible == usual.feasible
    monkeypatch.setattr(plan, "BOXES_OF_ONE", cost + 1)
    assert sweep(ties, keep="front-only").evaluated == usual.evaluated


@pytest.mark.usefixtures("_boxes")
@pytest.mark.parametrize("name", ["pressure_angle_max_deg", "pressure_angle_max_at_deg", "relative_half_width"])
def test_an_objective_that_boxes_do_not_bound_is_swept_as_usual(ties, name):
    scene = ties.replace(**{"search.minimise": ["base_radius_mm"], "search.maximise": [name]})
    assert not can_bound_all_objectives(resolve(scene))
    usual, alone = sweep(scene, keep="pareto"), sweep(scene, keep="front-only")
    assert alone.decided_by_boxes == 0
    assert (alone.feasible, alone.front) == (usual.feasible, usual.front)


@pytest.mark.slow
@pytest.mark.usefixtures("_boxes")
def test_where_nothing_is_feasible():
    scene = find_scene("roller-1000rpm").replace(**{"limits.pressure_angle": 2, "limits.pressure_angle_return": 2})
    found = sweep(scene, keep="front-only")
    assert (found.pareto, found.front, found.feasible) == (0, None, None)
    assert found.nearest_miss["violated"] == "pressure_angle,pressure_angle_return"
    assert found.decided_by_boxes + found.evaluated >= found.designs
    assert found.evaluated < 0.01 * found.designs


@pytest.mark.usefixtures("_boxes")
def test_an_interrupt_leaves_no_files(ties, tmp_path):
    def stop(done, total):
        raise KeyboardInterrupt("by hand")

    with pytest.raises(KeyboardInterrupt, match="by hand"):
        sweep(ties, tmp_path / "new", keep="front-only", progress=stop)
    assert list(tmp_path.iterdir()) == []


@given(st.integers(0, 10**6))
def test_dominators_are_those_of_the_definition(seed):
    rng = np.random.default_rng(seed)
    many = rng.integers(1, 5)
    known, asked = (rng.choice([0.0, 1.0, 2.0, 3.5, LARGEST_COST], (rng.integers(0, 150), many)) for _ in range(2))
    expected = [any(np.all(p <= c) and np.any(p < c) for p in known) for c in asked]
    assert Dominators(known).mask_dominated_points(asked).tolist() == expected


@given(st.integers(0, 10**6))
def test_points_that_come_in_parts_dominate_as_all_of_them_do(seed):
    rng = np.random.default_rng(seed)
    values, many = [0.0, 1.0, 2.0, 3.5, LARGEST_COST], rng.integers(1, 5)
    known, seen = PointTree(many), np.empty((0, many))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dominance, "COMPARED_AT_ONCE", 4)
        for _ in range(rng.integers(1, 8)):
            part, asked = (rng.choice(values, (rng.integers(0, 30), many)) for _ in range(2))
            told, seen = known.add_and_find_dominated(part), np.concatenate([seen, part])
            expected = Dominators(seen).mask_dominated_points(asked)
            assert not np.any(told & ~Dominators(seen).mask_dominated_points(part))
            dominators = known.dominators(lambda: seen[~Dominators(seen).mask_dominated_points(seen)])  # noqa: B023
            assert np.array_equal(dominators.mask_dominated_points(asked), expected)
