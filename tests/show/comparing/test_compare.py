"""Two results side by side, against what the words mean: double loops, definitions, and what must mirror itself."""

import json
from collections import Counter
from itertools import islice, product
from math import inf, prod, sqrt

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import hostile
from support.depth import times

import camopt
from camopt import BadInput, Frontier, Scene, find_scene, sweep
from camopt.cli.main import main
from camopt.core.storage.tables import read_table, write_table
from camopt.show.comparing.compare import SHOWN_DESIGNS, compare
from camopt.show.comparing.fronts import compare_fronts
from camopt.show.comparing.scenes import scene_differences
from camopt.solve.front.pareto import REFERENCE_POINT, is_non_dominated
from camopt.solve.synthesis.files import write_frontier

SCENE = find_scene("roller-1000rpm")
TOLERANCE = SCENE.accuracy.relative_error
KEY = ["law_rise", "law_return", "base_radius_mm", "roller_radius_mm", "offset_mm"]
OBJECTIVES = ["base_radius_mm", "acceleration_max_m_s2", "pressure_angle_max_deg"]
SMALL = st.sampled_from([0.0, -0.0, 10.0, 20.0])
VALUE = st.sampled_from([1.0, 1.0 + 1e-15, 1.0 + 1.5e-9, 1.0 + 3e-9, 2.0, inf])
ROW = st.fixed_dictionaries(
    {
        "law_rise": st.sampled_from(["cycloidal", "poly345"]),
        "law_return": st.just("cycloidal"),
        "base_radius_mm": st.sampled_from([50.0, 60.0]),
        "roller_radius_mm": st.just(5.0),
        "prime_radius_mm": st.sampled_from([55.0, 65.0]),
        "offset_mm": SMALL,
        "acceleration_max_m_s2": VALUE,
        "pressure_angle_max_deg": VALUE,
        "feasible": st.booleans(),
        "violated": st.sampled_from(["", "pressure_angle"]),
        "relative_half_width": st.sampled_from([0.0, 1e-12]),
    }
)


def frame_of(rows, scene=SCENE):
    """A table as ``camopt.load`` gives it."""
    frame = pd.DataFrame(rows)
    frame.attrs = {"scene": scene.to_toml()}
    return frame


TABLES = st.lists(ROW, min_size=1, max_size=12).map(frame_of)


def keys_of(frame):
    """What makes each design; of those that are there several times, the time."""
    seen = Counter()
    for row in frame.to_dict("records"):
        key = tuple(row[name] for name in KEY)
        seen[key] += 1
        yield (*key, seen[key])


def differ(x, y, by=0.0):
    """Whether two values differ, or by more than the relative errors."""
    if isinstance(x, (str, bool)):
        return x != y
    return x != y and (inf in (abs(x), abs(y)) or abs(x - y) > by * (abs(x) + abs(y)))


@settings(max_examples=times(20, deep=400))
@given(TABLES, TABLES)
def test_designs_come_go_and_change_as_a_dictionary_of_them_says(a, b):
    table = compare(a, b).by_table["table"]
    places = [{key: place for place, key in enumerate(keys_of(each))} for each in (a, b)]
    mine, others = places
    assert table.went.tolist() == [place for key, place in mine.items() if key not in others]
    assert table.came.tolist() == [place for key, place in others.items() if key not in mine]
    pairs = [(place, others[key]) for key, place in mine.items() if key in others]
    names = [name for name in a if name not in KEY]
    quantities = {
        name: [(i, j) for i, j in pairs if differ(a[name].tolist()[i], b[name].tolist()[j])] for name in names
    }
    assert {name: change.designs for name, change in table.quantities.items()} == {
        name: len(which) for name, which in quantities.items() if which
    }
    changed = sorted({pair for which in quantities.values() for pair in which})
    assert sorted(map(tuple, table.changed.tolist())) == changed
    beyond = {
        name: {(i, j) for i, j in which if differ(a[name].tolist()[i], b[name].tolist()[j], TOLERANCE)}
        for name, which in quantities.items()
        if name != "relative_half_width"
    }
    assert table.beyond == len({pair for which in beyond.values() for pair in which})
    for name, change in table.quantities.items():
        assert change.beyond == len(beyond.get(name, ()))
        i, j = change.rows
        assert (i, j) in quantities[name]
        assert (change.a, change.b) == (a[name].tolist()[i], b[name].tolist()[j])


def swap_sides(document):
    """A document with A and B, went and came in each other's place."""
    if isinstance(document, list):
        return [swap_sides(each) for each in document]
    if not isinstance(document, dict):
        return document
    other = {"a": "b", "b": "a", "went": "came", "came": "went"}
    return {other.get(key, key): swap_sides(value) for key, value in document.items()}


def drop_names(document, *names):
    if isinstance(document, list):
        return [drop_names(each, *names) for each in document]
    if not isinstance(document, dict):
        return document
    return {key: drop_names(value, *names) for key, value in document.items() if key not in names}


@pytest.mark.slow
@settings(max_examples=times(20, deep=400))
@given(TABLES, TABLES)
def test_the_other_way_round_it_is_mirrored(a, b):
    one, other = (json.loads(json.dumps(compare(*pair).to_dict(), allow_nan=False)) for pair in ((a, b), (b, a)))
    words = ("told", "rows", "a_is", "quantities")
    assert drop_names(swap_sides(one), *words) == drop_names(other, *words)
    largest = [
        {name: change["largest"] for name, change in each["tables"]["table"]["quantities"].items()}
        for each in (one, other)
    ]
    assert largest[0] == largest[1]
    told = [each["tables"]["table"]["fronts"]["told"] for each in (one, other)]
    if not told[0].startswith("Each"):
        assert told[0].translate(str.maketrans("AB", "BA")) == told[1]


@pytest.mark.slow
@settings(max_examples=times(20, deep=400))
@given(TABLES, st.randoms(use_true_random=False))
def test_a_table_is_the_same_as_itself_in_any_order(frame, random):
    frame = frame.drop_duplicates(KEY)
    order = [*range(len(frame))]
    random.shuffle(order)
    shuffled = frame.iloc[order].reset_index(drop=True)
    shuffled.attrs = frame.attrs
    for other in (frame, shuffled):
        found = compare(frame, other)
        assert found.same
        assert found.by_table["table"].fronts.verdict_sentence in (
            "The fronts are the same.",
            "Neither has a front.",
        )


# --------------------------------------------------------------------------------------------------- the fronts

COST = st.sampled_from([0.0, 1.0, 2.0, 2.5, 4.0]) | st.floats(-100.0, 100.0)


@st.composite
def front_pairs(draw, cost=COST):
    """The costs of two fronts of the same objectives."""
    many = draw(st.integers(1, 4))
    rows = st.lists(st.lists(cost, min_size=many, max_size=many), min_size=1, max_size=8)
    fronts = [np.array(draw(rows), dtype=float) for _ in "ab"]
    return [front[is_non_dominated(front)] for front in fronts]


def covers(one, other):
    """Whether each point of another front is as bad as, or worse than, a point of one in all objectives."""
    return all(any(all(x <= y for x, y in zip(p, q, strict=True)) for p in one) for q in other)


def dominates(p, q):
    return all(x <= y for x, y in zip(p, q, strict=True)) and any(x < y for x, y in zip(p, q, strict=True))


def share_by_cells(points, reference):
    """The share of the box from 0 to a reference that points dominate, by the cells between all coordinates."""
    points = np.maximum(points, 0.0)
    edges = [sorted({0.0, reference, *(x for x in column if x < reference)}) for column in points.T]
    total = 0.0
    for cell in product(*(range(len(each) - 1) for each in edges)):
        low = [each[i] for each, i in zip(edges, cell, strict=True)]
        if any(all(p <= corner for p, corner in zip(point, low, strict=True)) for point in points):
            total += prod(each[i + 1] - each[i] for each, i in zip(edges, cell, strict=True))
    return total / reference ** len(edges)


@settings(max_examples=times(30, deep=600))
@given(front_pairs())
def test_two_fronts_against_the_definitions(pair):
    found = compare_fronts(*pair)
    both = np.concatenate(pair)
    low, width = both.min(axis=0), np.ptp(both, axis=0)
    scaled = [(front - low) / np.where(width > 0.0, width, 1.0) for front in pair]
    sides = (found.a, found.b)
    for side, mine, others, here, there in zip(sides, pair, pair[::-1], scaled, scaled[::-1], strict=True):
        assert side.points == len(mine)
        assert side.dominated == sum(any(dominates(q, p) for q in others.tolist()) for p in mine.tolist())
        assert side.shared == sum(p in others.tolist() for p in mine.tolist())
        assert side.hypervolume == pytest.approx(share_by_cells(here, REFERENCE_POINT), rel=1e-9, abs=1e-12)
        behind = [
            min(sqrt(sum(max(x - y, 0.0) ** 2 for x, y in zip(p, q, strict=True))) for p in here) for q in there
        ]
        assert side.behind_mean == pytest.approx(sum(behind) / len(there), rel=1e-9, abs=1e-12)
        most = max(min(max(x - y for x, y in zip(p, q, strict=True)) for p in here) for q in there)
        assert side.behind_most == pytest.approx(most, rel=1e-9, abs=1e-12)


@given(front_pairs() | front_pairs(st.sampled_from([0.0, 1.0, 2.0, inf, -inf])))
def test_the_words_on_two_fronts_are_those_of_coverage(pair):
    found = compare_fronts(*pair)
    a, b = (front.tolist() for front in pair)
    if covers(a, b) and covers(b, a):
        assert found.verdict_sentence == "The fronts are the same."
        assert found.has_same_points
    elif covers(a, b) or covers(b, a):
        name, better, worse = ("A", a, b) if covers(a, b) else ("B", b, a)
        where = all(any(dominates(p, q) for p in better) for q in worse)
        assert (
            found.verdict_sentence
            == f"{name}'s front is better {'everywhere' if where else 'in places, and equal elsewhere'}."
        )
    else:
        assert found.verdict_sentence.startswith("Each front is better in places")
    if not found.has_same_points:
        assert (found.a.uncovered_point_count > 0) == (not covers(b, a))
        assert (found.b.uncovered_point_count > 0) == (not covers(a, b))


@given(front_pairs())
def test_a_front_that_covers_another_dominates_as_much_and_is_nowhere_behind(pair):
    found = compare_fronts(*pair)
    for one, other, mine, others in ((found.a, found.b, *pair), (found.b, found.a, *pair[::-1])):
        if covers(mine, others):
            assert one.hypervolume >= other.hypervolume - 1e-12
            assert one.behind_mean == 0.0
            assert one.behind_most <= 0.0


def test_a_front_without_a_point_is_told():
    none, one = np.zeros((0, 2)), np.zeros((1, 2))
    assert compare_fronts(none, none).verdict_sentence == "Neither has a front."
    assert compare_fronts(one, none).verdict_sentence == "Only A has a front."
    assert compare_fronts(none, one).verdict_sentence == "Only B has a front."


def test_fronts_of_other_objectives_are_not_compared():
    rows = [{**dict.fromkeys(OBJECTIVES, 1.0), "law_rise": "cycloidal", "law_return": "cycloidal"}]
    other = SCENE.replace(**{"search.minimise": OBJECTIVES[:2], "search.maximise": OBJECTIVES[2:]})
    table = compare(frame_of(rows), frame_of(rows, other)).by_table["table"]
    assert table.fronts is None
    assert table.objectives[1] == {**dict.fromkeys(OBJECTIVES[:2], "minimise"), OBJECTIVES[2]: "maximise"}
    assert table.has_same_designs


# ------------------------------------------------------------------------------------------------- the settings

CHANGES = st.fixed_dictionaries(
    {},
    optional={
        "name": st.sampled_from(["one", "other"]),
        "cam.rpm": st.sampled_from([500.0, 1000.0]),
        "limits.pressure_angle": st.sampled_from([None, 30.0, 33.0]),
        "limits.acceleration": st.sampled_from([None, 2000.0]),
        "search.law": st.sampled_from([["cycloidal"], ["cycloidal", "poly345"]]),
        "search.base_radius": st.sampled_from([[50.0], {"start": 40.0, "stop": 60.0}]),
        "follower.dynamics": st.sampled_from([None, {"mass": 1.0, "spring_rate": 2.0}]),
        "accuracy.relative_error": st.sampled_from([1e-9, 1e-6]),
    },
)


def with_values(scene, values):
    """A scene with other values by dotted key, None for those that it has not; tables that are empty then go."""
    tables = scene.to_dict()
    for key in values:
        path, last = [tables], key.split(".")[-1]
        for name in key.split(".")[:-1]:
            path.append(path[-1].get(name, {}))
        path[-1].pop(last, None)
        for above, name in reversed([*zip(path, key.split(".")[:-1], strict=False)]):
            if above.get(name) == {}:
                del above[name]
    for key, value in values.items():
        *names, last = key.split(".")
        table = tables
        for name in names if value is not None else ():
            table = table.setdefault(name, {})
        table |= {} if value is None else {last: value}
    return Scene.from_dict(tables)


@given(CHANGES, CHANGES)
def test_settings_that_differ_make_one_scene_the_other(first, second):
    a, b = SCENE.replace(**first), SCENE.replace(**second)
    found = scene_differences(a, b)
    assert bool(found) == (a != b)
    assert {key: pair[::-1] for key, pair in scene_differences(b, a).items()} == found
    assert all(mine != other for mine, other in found.values())
    assert with_values(a, {key: other for key, (_, other) in found.items()}) == b


def test_segments_are_counted_from_one_and_defaults_are_told():
    motion = SCENE.to_dict()["motion"]
    motion[2] |= {"law": "cycloidal"}
    changed = SCENE.replace(motion=motion, **{"search.refine": True})
    assert scene_differences(SCENE, changed) == {
        "motion.3.law": ("parabolic", "cycloidal"),
        "search.refine": (False, True),
    }


# ----------------------------------------------------------------------------------------------------- two cams


def test_two_cams_are_told_by_the_quantities_that_differ(told):
    """Of a radial knife edge that starts at full speed tan β = y′/R there; what the motion is does not differ."""
    scene = find_scene("uniform-knife-radial")
    found = compare(scene, scene.replace(**{"cam.base_radius": 60}))
    slope = scene.motion[0].lift / np.radians(scene.motion[0].angle)
    a, b = (np.degrees(np.arctan(slope / radius)) for radius in (50.0, 60.0))
    rise = found.cams["scene"]["pressure_angle_max_rise_deg"]
    assert rise == pytest.approx((a, b, b - a), rel=1e-12)
    assert not [name for name in found.cams["scene"] if name.startswith(("velocity", "acceleration"))]
    back = compare(scene.replace(**{"cam.base_radius": 60}), scene).cams["scene"]
    assert {name: (v.b, v.a) for name, v in back.items()} == {n: (v.a, v.b) for n, v in found.cams["scene"].items()}
    faster = compare(scene, scene.replace(**{"cam.rpm": 60})).cams["scene"]
    assert faster["velocity_max_m_s"].a is None
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["cams"]["scene"]["base_radius_mm"] == {
        **dict(zip("ab", (50.0, 60.0), strict=True)),
        "difference": 10.0,
    }


def test_two_cams_are_told_in_inch(told, tmp_path):
    scene = find_scene("uniform-knife-radial")
    other = scene.replace(**{"cam.base_radius": 63.5})
    (tmp_path / "other.toml").write_text(other.to_toml(), encoding="utf-8")
    code, out, _ = told("compare", "uniform-knife-radial", tmp_path / "other.toml", "--units", "inch")
    lines = [line.split() for line in out.splitlines()]
    assert code == 0
    assert ["cam.base_radius", "1.9685", "2.5", "in"] in lines
    assert ["base_radius_in", "1.9685", "2.5", "+0.531496", "+27.0%"] in lines


def test_a_search_is_no_cam(folders):
    assert not compare(*folders).cams  # their scenes were searched
    scene = SCENE.replace(**{"cam.base_radius": None})
    assert not compare(scene, scene.replace(**{"cam.rpm": 500})).cams


# --------------------------------------------------------------------------------------------- files and commands

SEARCH = {"search.base_radius": [110, 120, 130], "search.offset": [20], "search.law": ["cycloidal", "poly345"]}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Two sweeps, of which the other has a larger cam and a higher limit."""
    parent = tmp_path_factory.mktemp("compared")
    one = SCENE.replace(**SEARCH)
    other = one.replace(**{"search.base_radius": [120, 130, 140], "limits.pressure_angle": 33})
    return [sweep(scene, parent / name).files[0].parent for name, scene in (("a", one), ("b", other))]


def test_folders_are_compared_by_the_names_in_them(folders):
    found = compare(*folders)
    assert [*found.by_table] == ["designs.parquet", "pareto.parquet"]
    assert found.by_table["designs.parquet"].fronts is None  # the other table has it
    (names,) = found.settings
    assert names == "designs.parquet, pareto.parquet, scene.toml"
    assert found.settings[names] == {
        "limits.pressure_angle": (30.0, 33.0),
        "search.base_radius": ([110.0, 120.0, 130.0], [120.0, 130.0, 140.0]),
    }
    assert found.versions == (camopt.__version__, camopt.__version__)
    assert not found.same
    for folder in folders:
        assert compare(folder, folder).same


def test_a_table_with_its_scene_and_what_load_makes_of_it_are_the_same(folders):
    path = folders[0] / "pareto.parquet"
    assert compare(path, camopt.load(path)).same
    assert compare(path, folders[0] / "scene.toml").same
    assert compare(str(path), Scene.from_toml(folders[0] / "scene.toml")).same
    assert not compare(path, folders[1] / "scene.toml").same


def test_a_searched_number_is_that_of_the_scene_where_it_is_no_column(tmp_path):
    scene = SCENE.replace(**SEARCH | {"search.base_radius": [130]})
    fast = scene.replace(**{"search.cam.rpm": [500, 1000]})
    one, other = sweep(scene, tmp_path / "one"), sweep(fast, tmp_path / "other")
    table = compare(one, other).by_table["designs.parquet"]
    assert table.columns_in_b == ("rpm",)
    assert (table.went.size, len(table.changed)) == (0, 0)
    rpm = camopt.load(other.files[0])["rpm"].to_numpy()
    assert rpm[table.came].tolist() == [500.0] * (table.designs[1] - table.designs[0])


@pytest.mark.long
def test_frontiers_are_the_same_where_their_motions_are(tmp_path):
    coarse = SCENE.replace(**{"synthesis.pieces": 12})
    found = camopt.frontier(coarse, points=2, workers=1)
    path = write_frontier(found, tmp_path)
    assert compare(found, path).same
    assert compare(camopt.load(path), path).same
    fewer = Frontier(found.scene, found.axes, found.rows, found.known[1:], found.least, found.local)
    table = compare(found, fewer).by_table["table"]
    assert (table.went.tolist(), table.came.size, len(table.changed)) == ([len(found.rows)], 0, 0)
    assert table.objectives[0] == dict.fromkeys(found.axes, "minimise")
    assert table.fronts.has_same_points


def test_a_column_that_another_command_added_is_told(folders, tmp_path):
    for name in ("designs.parquet", "pareto.parquet"):
        (tmp_path / name).write_bytes((folders[0] / name).read_bytes())
    assert main(["certify", str(tmp_path / "pareto.parquet"), "--quiet"]) == 0
    found = compare(folders[0], tmp_path)
    assert found.only_in_a == ("scene.toml",)
    table = found.by_table["pareto.parquet"]
    assert (table.columns_in_b, len(table.changed), table.has_same_designs) == (("proof",), 0, False)


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_designs_that_differ_are_written_with_where_they_come_from(folders, tmp_path, suffix):
    tables = [read_table(folder / "designs.parquet") for folder in folders]
    more = np.asarray(tables[0]["pressure_angle_max_deg"]) + 1.0
    place = tables[0].column_names.index("pressure_angle_max_deg")
    changed = tables[0].set_column(place, tables[0].schema.field(place), [more])
    write_table(changed, tmp_path / "other.parquet")
    for other, out in ((folders[1] / "designs.parquet", "moved"), (tmp_path / "other.parquet", "changed")):
        found = compare(folders[0] / "designs.parquet", other, out=tmp_path / f"{out}{suffix}").by_table["table"]
        rows = camopt.load if suffix == ".parquet" else pd.read_csv
        written = rows(tmp_path / f"{out}{suffix}")
        kinds = {change: written[written["change"] == change] for change in written["change"].unique()}
        assert {change: len(part) for change, part in kinds.items()} == {
            change: count
            for change, count in (
                *(("went", found.went.size), ("came", found.came.size)),
                *(("before", len(found.changed)), ("after", len(found.changed))),
            )
            if count
        }
        source = camopt.load(folders[0] / "designs.parquet")
        for change in {"went", "before"} & {*kinds}:
            expected = source.iloc[kinds[change]["row"]]["base_radius_mm"].tolist()
            assert kinds[change]["base_radius_mm"].tolist() == expected
    assert found.beyond == len(found.changed) == len(more)


def test_of_many_designs_a_few_are_shown_the_best_first():
    rows = [
        {
            **dict.fromkeys(OBJECTIVES, 1.0),
            "law_rise": "cycloidal",
            "base_radius_mm": float(size),
            "feasible": size > 3,
        }
        for size in range(9, 0, -1)
    ]
    table = compare(frame_of(rows), frame_of([{**rows[0], "offset_mm": 1.0}])).by_table["table"]
    assert [row["base_radius_mm"] for row in table.first["went"]] == [4.0, 5.0, 6.0, 7.0, 8.0][:SHOWN_DESIGNS]


@pytest.fixture
def told(capsys):
    """Run a command: exit code, and what it prints."""

    def run(*words):
        code = main([*map(str, words)])
        return code, *capsys.readouterr()

    return run


def test_the_command_ends_with_0_whether_or_not_they_differ(folders, told):
    code, out, _ = told("compare", *folders)
    assert code == 0
    assert "Settings that differ" in out
    assert "limits.pressure_angle" in out
    assert "only in A, " in out
    code, out, _ = told("compare", folders[0], folders[0])
    assert code == 0
    assert "A and B are the same" in out
    assert "differ" not in out


def test_the_document_is_what_the_library_gives(folders, told):
    code, out, _ = told("compare", *folders, "--json")
    assert code == 0
    assert json.loads(out) == json.loads(json.dumps(compare(*map(str, folders)).to_dict()))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["roller-1000rpm", "no-such-scene"], "no-such-scene"),
        (["FOLDER", "EMPTY"], "a folder with scenes or tables of designs that a command wrote"),
        (["FOLDER", "roller-1000rpm"], "a scene or table of the same name as in the other"),
        (["FOLDER", "FOLDER/pareto.parquet"], "a scene or table of the same name as in the other"),
        (["FOLDER", "SPECTRUM"], "not one of designs"),
        (["FOLDER", "DAMAGED"], "damaged"),
        (["FOLDER", "FOLDER", "--out", "rows.txt"], ".parquet or .csv"),
        (["FOLDER", "FOLDER", "--out", "FOLDER/pareto.parquet"], "another file: this one is compared"),
        (["FOLDER", "https://example.org/pareto.parquet"], "not an address"),
    ],
)
def test_what_cannot_be_compared_is_told_in_a_line(words, message, folders, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    table = read_table(folders[0] / "pareto.parquet")
    (tmp_path / "damaged.parquet").write_bytes(hostile.in_bytes(table)[:-9])
    write_table(table.drop_columns(["law_rise"]), tmp_path / "spectrum.parquet")
    names = {"FOLDER": folders[0], "EMPTY": "empty", "SPECTRUM": "spectrum.parquet", "DAMAGED": "damaged.parquet"}
    words = [str(names.get(word, word)).replace("FOLDER", str(folders[0])) for word in words]
    code, out, err = told("compare", *words)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_a_sweep_that_wrote_nothing_and_what_is_no_result_are_refused():
    for odd in (sweep(SCENE.replace(**SEARCH)), 3):
        with pytest.raises(BadInput, match="camopt: result"):
            compare(SCENE, odd)


def test_the_picture_has_the_points_of_both_fronts_and_of_each_alone(folders, tmp_path):
    found = compare(*folders)
    fronts = found.by_table["pareto.parquet"].fronts
    figure = camopt.plot(found, tmp_path / "fronts.svg")
    assert (tmp_path / "fronts.svg").stat().st_size
    for axes in figure.axes:
        drawn = {each.get_label(): len(each.get_offsets()) for each in axes.collections}
        expected = {
            "on both fronts": fronts.a.shared,
            "only on A's front": fronts.a.points - fronts.a.shared,
            "only on B's front": fronts.b.points - fronts.b.shared,
        }
        assert drawn == {label: count for label, count in expected.items() if count}
    assert figure.axes[0].get_xlabel() == "base radius, mm"
    with pytest.raises(BadInput, match="fronts of the same"):
        camopt.plot(compare(SCENE, SCENE))


@pytest.mark.slow
def test_a_hostile_table_is_compared_or_refused(folders, tmp_path):
    path, whole = tmp_path / "t.parquet", folders[1] / "designs.parquet"
    ends = Counter()
    tables = islice(hostile.tables(read_table(folders[0] / "designs.parquet")), 0, None, times(3, deep=1))
    for number, (_, made) in enumerate(tables):
        path.write_bytes(made())
        try:
            found = compare(path, (whole, path)[number % 2], out=tmp_path / "rows.csv")
            json.dumps(found.to_dict(), allow_nan=False)
            ends["compared"] += 1
        except (BadInput, OSError) as trouble:
            ends["refused"] += "\n" not in str(trouble)
    assert ends.total() == number + 1
    assert min(ends.values()) > times(6, deep=20)


def test_a_column_that_has_two_types_is_refused(folders):
    frame = camopt.load(folders[0] / "designs.parquet")
    for odd in (frame.assign(note=1), frame.assign(base_radius_mm="large")):
        with pytest.raises(BadInput, match="camopt: table"):
            compare(frame.assign(note="a"), odd)
