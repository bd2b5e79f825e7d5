"""Results in inch: each number that is shown, converted back by pint, is the number in mm."""

import json
import re

import ezdxf
import numpy as np
import pandas as pd
import pytest
from pint import UnitRegistry
from support.controls import CONTROLS
from support.curves import largest_distance, true_points
from support.pictures import faults_of

from camopt import (
    BadInput,
    Scene,
    cam_points,
    evaluate,
    export,
    find_scene,
    frontier,
    harmonics,
    plot,
    report,
    shown_in,
    sweep,
    synthesise,
    timing,
    tolerance,
)
from camopt.cli.main import main
from camopt.core.quantities import QUANTITIES, STAGE_NUMBER_KEYS
from camopt.core.quantities.unit_systems import (
    CUSTOMARY,
    UNIT_FACTOR,
    from_shown_unit,
    shown_system,
    to_shown_unit,
    unit_in_shown_system,
)
from camopt.scene.problem.problem import resolve_design
from camopt.show.drawing.figures import all_panels_in_shown_units
from camopt.show.drawing.picture import Picture
from camopt.show.exporting.cam_points import COLUMN_NOTES, FORM_COLUMNS
from camopt.show.exporting.program import CONTROL_DIALECTS
from camopt.show.sheet.marks import LARGE, Words
from camopt.show.sheet.sheet import sheet_of
from camopt.show.sheet.true_cam import TrueCam
from camopt.solve.contour.curve import disc_curves
from camopt.solve.synthesis.files import write_known_cam_and_summary
from camopt.solve.synthesis.known_law_cams import build_known_law_cams
from camopt.solve.tables.cells import column_suffix_of_unit, shown_column_name

PINT = UnitRegistry()
UNITS = sorted(
    {quantity.unit for quantity in QUANTITIES.values()}
    | {each.column_unit(angular=turns) for each in STAGE_NUMBER_KEYS.values() for turns in (False, True)}
    | {unit for unit, _ in (*COLUMN_NOTES.values(), *FORM_COLUMNS.values())}
    | {"mm/min", "mm³", "kg/m³"}
)
INTO_PINT = {
    "rev": "turn",
    "·": "*",
    "²": "**2",
    "³": "**3",
    "⁴": "**4",
    "µ": "micro",
    "Mpsi": "megapsi",
    "lbf": "force_pound",
}
AS_IN_MM = {"", "1", "deg", "rad", "s", "ms", "min", "Hz", "rev", "%"}
"""Units that are the same in both systems."""
LOADED = {
    "cam.rpm": 600,
    "follower.dynamics": {
        "mass": 0.5,
        "spring_rate": 30,
        "preload": 3000,
        "natural_frequency": 110,
        "damping_ratio": 0.05,
        "guide_length": 60,
        "overhang": 40,
        "friction": 0.1,
        "stem_diameter": 16,
        "fluctuation": 0.02,
    },
    "materials": {
        "cam": "steel",
        "follower": "steel",
        "face_width": 12,
        "wear_rate": 1e-9,
        "viscosity": 0.1,
        "pressure_viscosity": 20,
        "roughness": 0.4,
    },
    "part": {
        "thickness": 15,
        "bore": 20,
        "hub_diameter": 35,
        "hub_length": 30,
        "keyway_width": 6,
        "keyway_depth": 2.8,
    },
    "limits": {"pressure_angle": 40, "contact_stress": 900, "contact_force_min": 10, "acceleration": 3000},
    "outputs": ["all"],
}
GROOVE = {
    "cam": {"form": "cylindrical", "rpm": 100, "mean_radius": 80},
    "follower": {"motion": "translating", "contact": "roller", "roller_radius": 8},
    "motion": find_scene("roller-1000rpm").to_dict()["motion"],
    "outputs": ["all"],
}
SCENES = {
    "roller": find_scene("exhaust-valve").replace(**LOADED),
    "no speed": find_scene("exhaust-valve").replace(outputs=["all"]),
    "flat": find_scene("bucket-valve").replace(outputs=["all"]),
    "swung": find_scene("oscillating-roller").replace(outputs=["all"]),
    "moves": find_scene("belt-matching").replace(outputs=["all"]),
    "groove": Scene.from_dict(GROOVE),
    "train": find_scene("valve-with-rocker").replace(outputs=["all"]),
}


def in_pint(unit):
    """A unit as pint reads it."""
    for ours, theirs in INTO_PINT.items():
        unit = unit.replace(ours, theirs)
    return PINT.parse_units(unit)


def convert_by_pint(value, unit, other):
    """A number in a unit as pint has it in another."""
    return PINT.Quantity(value, in_pint(unit)).to(in_pint(other)).magnitude


@pytest.fixture
def inch():
    with shown_in("inch"):
        yield


@pytest.mark.parametrize("unit", UNITS)
def test_every_unit_of_a_quantity_has_its_counterpart(unit, inch):
    assert {name for name, _ in UNIT_FACTOR.findall(unit)} <= {*CUSTOMARY} | AS_IN_MM
    assert convert_by_pint(to_shown_unit(1.0, unit), unit_in_shown_system(unit), unit) == pytest.approx(
        1.0, rel=1e-12
    )
    assert from_shown_unit(to_shown_unit(np.array([3.0, -2.0]), unit), unit) == pytest.approx(
        [3.0, -2.0], rel=1e-15
    )
    with shown_in("mm"):
        assert (to_shown_unit(1.5, unit), unit_in_shown_system(unit)) == (1.5, unit)


@pytest.mark.parametrize("name", QUANTITIES)
def test_a_name_says_the_unit_in_which_its_number_is_shown(name, inch):
    unit = QUANTITIES[name].unit
    assert not unit or f"_{name}".endswith(column_suffix_of_unit(unit))
    if not unit or unit == unit_in_shown_system(unit):
        assert shown_column_name(name) == name
        return
    assert shown_column_name(name) == name.removesuffix(column_suffix_of_unit(unit)) + column_suffix_of_unit(
        unit_in_shown_system(unit)
    )


def test_units_are_those_of_the_process_and_come_back():
    with shown_in("inch"):
        assert shown_system() == "inch"
        with shown_in("mm"):
            assert shown_system() == "mm"
        assert shown_system() == "inch"
    assert shown_system() == "mm"
    with pytest.raises(BadInput, match="mm or inch"), shown_in("feet"):
        pass


def number_in(text):
    return float(text.replace("−", "-").replace("∞", "inf"))


@pytest.mark.parametrize("name", SCENES)
def test_the_table_of_a_design_has_the_same_numbers(name):
    found = evaluate(SCENES[name])
    plain = found.table()
    with shown_in("inch"):
        table = found.table()
    assert len(table.rows) == len(plain.rows) > 12
    for row, other in zip(table.rows, plain.rows, strict=True):
        quantity, unit = other[0].text, row[2].text
        known = found[quantity]
        assert unit == "" or not {each for each, _ in UNIT_FACTOR.findall(unit)} & {*CUSTOMARY}
        if not isinstance(known, float):
            assert row[1:] == other[1:]
            continue
        value = number_in(row[1].text)
        if np.isfinite(known) and value:
            assert convert_by_pint(value, unit or "1", QUANTITIES[quantity].unit or "1") == pytest.approx(
                known, rel=6e-6
            )
        limit = [each.text for each in (row[3], other[3]) if re.match("[≤≥±<>]", each.text)]
        if len(limit) == 2:
            ours, theirs = (number_in(text.split()[-1]) for text in limit)
            assert convert_by_pint(ours, unit or "1", QUANTITIES[quantity].unit or "1") == pytest.approx(
                theirs, rel=6e-6
            )


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", SCENES)
def test_diagrams_have_the_same_curves_peaks_and_limits(name):
    picture = Picture(SCENES[name], resolve_design(SCENES[name]))
    plain = all_panels_in_shown_units(picture)
    with shown_in("inch"):
        panels = all_panels_in_shown_units(picture)
    for panel, other in zip(panels, plain, strict=True):
        one = convert_by_pint(1.0, other.unit or "1", panel.unit or "1")
        numbers = {
            "values": (np.concatenate(panel.values), np.concatenate(other.values)),
            "peaks": ([each.value for each in panel.peaks], [each.value for each in other.peaks]),
            "limits": ([bound for _, bound in panel.limits], [bound for _, bound in other.limits]),
            "impulses": ([size for _, size in panel.impulses], [size for _, size in other.impulses]),
            "bands": (np.ravel(panel.bands), np.ravel(other.bands)),
            "span": (panel.span or (), other.span or ()),
            "marks": ([mark[2:] for mark in panel.marks], [mark[2:] for mark in other.marks]),
        }
        for mine, theirs in numbers.values():
            assert np.asarray(mine) == pytest.approx(one * np.asarray(theirs), rel=1e-12, nan_ok=True)
        for mine, theirs in ((panel.reference, other.reference), (panel.other, other.other)):
            assert (mine is None) == (theirs is None)
            if mine:
                assert np.concatenate(mine) == pytest.approx(one * np.concatenate(theirs), rel=1e-12, nan_ok=True)
        for peak in panel.peaks:
            if peak.text[-1:].isdigit():
                assert number_in(peak.text) == pytest.approx(peak.value, rel=1e-3, abs=1e-12)
        if panel.value_at:
            angles = np.linspace(0.1, 6.0, 5)
            assert panel.value_at(angles) == pytest.approx(one * other.value_at(angles), rel=1e-12, nan_ok=True)


METRIC = re.compile(r"(?<![\w.])(mm|MPa|GPa|N|N·m|m/s|m/s²|kg|µm|W|J)(?![\w.])")


@pytest.mark.slow
@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", SCENES)
def test_a_picture_has_no_text_in_another_unit_and_room_for_all(name, inch):
    figure = plot(SCENES[name])
    texts = [text.get_text() for text in figure.findobj(lambda each: hasattr(each, "get_text"))]
    assert [text for text in texts if METRIC.search(text)] == []
    assert any(re.search(r"\bin\b", text) for text in texts)
    assert faults_of(figure) == []


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", SCENES)
def test_a_page_has_no_text_in_another_unit(name, inch, tmp_path):
    text = report(SCENES[name], tmp_path / "cam.html").read_text(encoding="utf-8")
    told = re.sub(r"(?s)<style.*?</style>|<script.*?</script>|<pre.*?</pre>|<[^>]*>", "\n", text)
    symbols = {quantity.symbol for quantity in QUANTITIES.values()}
    assert [line for line in told.splitlines() if METRIC.search(line) and line not in symbols] == []
    data = re.search(r"(?s)<script[^>]*application/json[^>]*>(.*?)</script>", text)[1]
    units = {panel["unit"] for cam in json.loads(data)["cams"] for panel in cam["panels"]}
    assert [unit for unit in units if METRIC.search(unit)] == []


def run(capsys, *arguments):
    code = main([*map(str, arguments)])
    out, err = capsys.readouterr()
    return code, out, err


def test_the_option_and_the_variable_ask_for_inch_and_json_stays(capsys, monkeypatch):
    plain = run(capsys, "evaluate", "roller-1000rpm")[1]
    asked = run(capsys, "evaluate", "roller-1000rpm", "--units", "inch")[1]
    assert shown_system() == "mm"
    assert run(capsys, "evaluate", "roller-1000rpm")[1] == plain != asked
    document = run(capsys, "evaluate", "roller-1000rpm", "--json")[1]
    monkeypatch.setenv("CAMOPT_UNITS", "inch")
    assert run(capsys, "evaluate", "roller-1000rpm")[1] == asked
    assert run(capsys, "evaluate", "roller-1000rpm", "--json")[1] == document
    assert "Largest lift: 1.9685 in, reached" in asked
    monkeypatch.setenv("CAMOPT_UNITS", "feet")
    assert run(capsys, "evaluate", "roller-1000rpm")[0] == 2


def test_a_result_that_is_there_in_mm_is_told_in_inch_when_asked(capsys, tmp_path):
    search = ["--base-radius", "60:70:5", "--offset", "0:0:1", "--law", "cycloidal", "--out", tmp_path]
    _, plain, _ = run(capsys, "sweep", "roller-1000rpm", *search)
    _, asked, said = run(capsys, "sweep", "roller-1000rpm", *search, "--units", "inch")
    assert "up to date" in said
    assert "in " in asked != plain
    assert run(capsys, "sweep", "roller-1000rpm", *search)[1] == plain


def test_texts_of_the_smallest_cam_have_the_same_numbers(capsys):
    words = [
        "optimise",
        "roller-1000rpm",
        "--set",
        "search.law=['cycloidal']",
        "--set",
        "search.roller_radius=[10]",
    ]
    told = [run(capsys, *words, "--units", units)[1] for units in ("mm", "inch")]
    prices = [re.findall(r"(−?[\d.]+) (mm|in) per (deg|mm|in)", text) for text in told]
    sizes = [re.findall(r"(?<=[ ])([\d.]+) (mm|in)(?: )", text) for text in told]
    assert len(prices[0]) == len(prices[1]) >= 2
    assert len(sizes[0]) == len(sizes[1]) >= 1
    for (value, unit, per), (other, of, over) in zip(prices[1], prices[0], strict=True):
        assert convert_by_pint(number_in(value), f"{unit}/{per}", f"{of}/{over}") == pytest.approx(
            number_in(other), rel=2e-3
        )
    for (value, unit), (other, of) in zip(sizes[1], sizes[0], strict=True):
        assert convert_by_pint(number_in(value), unit, of) == pytest.approx(number_in(other), rel=1e-5)


def test_the_table_of_tolerances_has_the_same_lengths_and_angles():
    found = tolerance(find_scene("roller-1000rpm").replace(tolerances={"profile": 0.02}))
    plain = found.table()
    with shown_in("inch"):
        table = found.table()
    for row, other in zip(table.rows, plain.rows, strict=True):
        if "deg" in other[0].text:
            assert row == other
        else:
            assert convert_by_pint(number_in(row[1].text), "in", "mm") == pytest.approx(
                number_in(other[1].text), rel=1e-5
            )


def test_tables_of_timing_and_harmonics_have_the_same_numbers():
    scene = find_scene("roller-1000rpm")
    for result in (timing(scene, [10.0]), harmonics(scene, 4)):
        plain = result.table()
        with shown_in("inch"):
            table = result.table()
        for k, (head, other) in enumerate(zip(table.heads, plain.heads, strict=True)):
            units = [each.text.split("\n")[-1] for each in (head, other)]
            units = ["1", "1"] if units[0] == units[1] else units
            for row, same in zip(table.rows, plain.rows, strict=True):
                value = convert_by_pint(number_in(row[k].text), *units)
                assert value == pytest.approx(number_in(same[k].text), rel=1e-5, abs=1e-9)


@pytest.mark.slow
def test_points_in_a_csv_file_and_a_workbook_are_those_of_the_cam(tmp_path, inch):
    scene = SCENES["roller"]
    for suffix in (".csv", ".xlsx", ".parquet"):
        export(scene, tmp_path / f"points{suffix}", step=5.0)
    true = cam_points(scene, step=5.0)
    read = pd.read_csv(tmp_path / "points.csv")
    sheet = pd.read_excel(tmp_path / "points.xlsx", sheet_name="points", skiprows=[1], engine="openpyxl")
    assert list(sheet) == list(read)
    stored = pd.read_parquet(tmp_path / "points.parquet")
    assert list(stored) == list(true)
    for (name, values), column in zip(true.items(), read, strict=True):
        if name.endswith("_mm"):
            assert column == f"{name.removesuffix('_mm')}_in"
            one = 25.4 if not name.endswith("_per_mm") else 1 / 25.4
            assert one * read[column].to_numpy() == pytest.approx(values, rel=1e-12, abs=1e-12)
            assert one * sheet[column].to_numpy() == pytest.approx(values, rel=1e-12, abs=1e-12)
        assert not re.search("_(mm|N|MPa|N_m|m_s)$", column)
        assert stored[name].to_numpy() == pytest.approx(values)
    stress = read["contact_stress_ksi"].to_numpy()
    assert convert_by_pint(stress, "ksi", "MPa") == pytest.approx(true["contact_stress_MPa"], rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("curves", ["arcs", "spline"])
def test_a_drawing_in_inch_says_so_and_is_the_same_cam(tmp_path, curves):
    scene = SCENES["roller"]
    export(scene, tmp_path / "mm.dxf", curves=curves)
    with shown_in("inch"):
        export(scene, tmp_path / "inch.dxf", curves=curves)
    drawings = [ezdxf.readfile(tmp_path / f"{name}.dxf") for name in ("mm", "inch")]
    assert [drawing.units for drawing in drawings] == [ezdxf.units.MM, ezdxf.units.IN]
    for one, other in zip(*(drawing.modelspace() for drawing in drawings), strict=True):
        assert (one.dxftype(), one.dxf.layer) == (other.dxftype(), other.dxf.layer)
        if one.dxftype() == "LWPOLYLINE":
            mine, theirs = (np.array(each.get_points("xyb")) for each in (other, one))
            assert mine * [25.4, 25.4, 1.0] == pytest.approx(theirs, rel=1e-9, abs=1e-9)
        elif one.dxftype() == "SPLINE":
            assert 25.4 * np.array(other.control_points) == pytest.approx(np.array(one.control_points), abs=1e-9)
            assert list(other.knots) == list(one.knots)
        elif one.dxftype() == "CIRCLE":
            assert 25.4 * other.dxf.radius == pytest.approx(one.dxf.radius)
        else:
            assert 25.4 * np.array(other.dxf.end) == pytest.approx(np.array(one.dxf.end), abs=1e-9)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("control", CONTROL_DIALECTS)
def test_a_program_in_inch_cuts_the_profile(tmp_path, control, inch):
    """What the machine's interpreter makes of it, in mm, lies on the path of the cutter."""
    scene = find_scene("valve-rod-radial")
    given = {"cutter_radius": 5.0, "feed": 254.0, "depth": 12.7, "depth_step": 6.35}
    found = export(scene, tmp_path / "cam.nc", control=control, **given)
    text = (tmp_path / "cam.nc").read_text()
    inches, metric = {"siemens": ("G70", "G71"), "heidenhain": ("INCH", "MM")}.get(control, ("G20", "G21"))
    assert re.search(rf"\b{inches}\b", text)
    assert not re.search(rf"\b{metric}\b|\bmm\b", text)
    machine = CONTROLS[control](re.sub(rf"\b{inches}\b", metric, text), CONTROL_DIALECTS[control].decimals + 1)
    cut = machine.cuts[-1]
    assert [each.depth for each in machine.cuts] == pytest.approx([-0.25, -0.5])
    assert {*cut.feeds} == {10.0}
    closed = -25.4 * np.concatenate(cut.moves[2:-2]).conjugate()  # its hub is below: from behind
    problem = resolve_design(scene)
    true = true_points(problem, disc_curves(problem, 5.0)["cutter"].distance)
    off = max(largest_distance(closed, true), largest_distance(true, closed))
    assert off <= found.curves["cutter"].deviation_mm + 5e-5
    assert found.curves["cutter"].deviation_mm <= 5 * 25.4 * 10.0**-machine.decimals


def test_tables_for_grinders_and_drives_are_the_same(tmp_path):
    scene = find_scene("valve-rod-radial")
    for units in ("mm", "inch"):
        with shown_in(units):
            export(scene, tmp_path / f"{units}.p", cutter_radius=16.0)
            export(scene, tmp_path / f"{units}.txt", points=37)
    grinder, drive = ([np.loadtxt(tmp_path / f"{units}.{end}") for units in ("mm", "inch")] for end in ("p", "txt"))
    assert grinder[1] * [1.0, 25.4, 25.4] == pytest.approx(grinder[0], abs=2e-6)
    assert drive[1] * [1.0, 25.4, 25.4, 25.4] == pytest.approx(drive[0], rel=1e-8, abs=1e-9)
    assert "lift_in centre_in" in (tmp_path / "inch.p").read_text()
    assert "position_in velocity_in_per_deg" in (tmp_path / "inch.txt").read_text()


SHEETS = {
    "disc": find_scene("exhaust-valve").replace(
        part={
            **LOADED["part"],
            "roughness": 1.6,
            "profile_tolerance": 0.02,
            "keyway_fit": "P9",
            "edges": [-0.3, 0.3],
        }
    ),
    "flat": find_scene("bucket-valve"),
    "swung": find_scene("oscillating-roller"),
}


@pytest.mark.slow
@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", SHEETS)
@pytest.mark.parametrize("language", ["en", "de"])
def test_a_sheet_in_inch_has_the_same_dimensions(name, language):
    """Each size of the sheet in inch, to half of its last decimal, is one of the sheet in mm."""
    part = {**(SHEETS[name].to_dict().get("part") or {}), "language": language}
    scene = SHEETS[name].replace(part=part)
    problem = resolve_design(scene)
    plain = sizes_of(sheet_of(TrueCam(scene, problem)))
    with shown_in("inch"):
        drawn = sheet_of(TrueCam(scene, problem))
    found = sizes_of(drawn)
    assert len(found) >= 2
    for size in found:
        half = 0.5001 * 25.4 * 10.0 ** -len(size.partition(".")[2])
        assert any(abs(float(size) * 25.4 - float(known)) <= half + 5e-4 for known in plain), size
    texts = [mark.text for mark in drawn.marks if isinstance(mark, Words)]
    assert "DIMENSIONS ARE IN INCHES" in texts
    assert [text for text in texts if METRIC.search(text)] == []


def sizes_of(sheet):
    """The sizes without a fit, as they are written, with decimal points in any language."""
    large = [
        mark.text.replace(",", ".") for mark in sheet.marks if isinstance(mark, Words) and mark.height == LARGE
    ]
    return [text.lstrip("RØ") for text in large if re.fullmatch(r"[RØ]?(\d*\.\d+|\d+)", text) and text != "63"]


def test_options_take_lengths_and_feeds_with_a_unit(capsys, tmp_path):
    file, words = tmp_path / "cam.nc", ["export", "valve-rod-radial", tmp_path / "cam.nc"]
    assert run(capsys, *words, "--cutter-radius", "0.2 in", "--feed", "10 in/min")[0] == 0
    typed = file.read_text()
    assert run(capsys, *words, "--cutter-radius", "5.08", "--feed", "254")[0] == 0
    assert file.read_text() == typed
    for given in ("0.2 kg", "wide", "0.2 in/min"):
        code, _, said = run(capsys, *words, "--cutter-radius", given, "--feed", "254")
        assert code == 2
        assert "a number in mm, or a text with a unit of the same kind" in said


def test_a_synthesis_is_told_in_both_systems_for_pages_of_either(tmp_path):
    result = synthesise(find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12}))
    write_known_cam_and_summary(result, build_known_law_cams(result.asked), tmp_path)
    summary = json.loads((tmp_path / "synthesis.json").read_text())
    for key, unit in (("told", "mm"), ("told_in_inch", "in")):
        numbers = [number_in(text) for text in re.findall(rf"([\d.]+) {unit}\b", summary[key])]
        assert convert_by_pint(np.array(numbers), unit, "mm") == pytest.approx(
            [result.objective, result.bound], rel=1e-5
        )
    assert METRIC.search(summary["told_in_inch"]) is None


def test_a_page_of_results_has_the_columns_in_inch(inch, tmp_path):
    """A table of designs has words among its columns, which are in no unit."""
    search = {"base_radius": [90, 120], "law": ["cycloidal", "poly345"]}
    swept = sweep(find_scene("roller-1000rpm").replace(search=search), tmp_path / "out")
    text = report(swept.files[0].parent, tmp_path / "page.html").read_text(encoding="utf-8")
    told = re.sub(r"(?s)<style.*?</style>|<script.*?</script>|<pre.*?</pre>|<[^>]*>", "\n", text)
    assert [line for line in told.splitlines() if METRIC.search(line)] == []
    columns = json.loads(re.search(r"(?s)<script[^>]*application/json[^>]*>(.*?)</script>", text)[1])["columns"]
    scales = {column["name"]: column["scale"] for column in columns}
    assert (scales["base_radius_mm"], scales["law_rise"], scales["pressure_angle_max_deg"]) == (25.4, 1.0, 1.0)


@pytest.mark.slow
def test_a_frontier_is_drawn_in_inch(tmp_path):
    found = frontier(find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12}), points=2, workers=1)
    metric = plot(found)
    with shown_in("inch"):
        drawn = plot(found)
    assert METRIC.search(metric.axes[0].get_ylabel())
    texts = [text.get_text() for text in drawn.findobj(lambda each: hasattr(each, "get_text"))]
    assert [text for text in texts if METRIC.search(text)] == []
    ends = [np.sort(np.array(figure.axes[0].get_ylim())) for figure in (metric, drawn)]
    assert ends[1] == pytest.approx(ends[0] / 25.4, rel=1e-9)


def test_a_fit_is_told_and_drawn_in_inch(capsys, tmp_path):
    angles = np.arange(0.0, 360.0, 4.0)
    lifts = 5.0 * (1.0 - np.cos(np.radians(angles)))
    lifts[30] += 0.8  # which is left out
    rows = np.column_stack([angles, lifts + 1e-3 * np.sin(7.0 * angles)])
    np.savetxt(tmp_path / "lift.csv", rows, delimiter=",", header="angle_deg,lift_mm", comments="")
    files = [tmp_path / "lift.csv", "--scene", "bucket-valve", "--out", tmp_path / "fitted.toml"]
    found = {units: run(capsys, "fit", *files, "--units", units) for units in ("mm", "inch")}
    (mm,), (inch,) = ([line for line in err.splitlines() if "is left out" in line] for _, _, err in found.values())
    lengths = [
        np.array([number_in(each) for each in re.findall(r"([\d.e-]+) (?:mm|in)\b", line)]) for line in (mm, inch)
    ]
    assert lengths[0][0] == pytest.approx(lifts[30], rel=1e-3)
    assert 25.4 * lengths[1] == pytest.approx(lengths[0], rel=1e-5)
    assert METRIC.search(found["inch"][1] + found["inch"][2]) is None
