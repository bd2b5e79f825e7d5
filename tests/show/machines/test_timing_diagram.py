"""Timing diagrams: segments, angles and curves are where phase and ratio put them, and no text hides another."""

import numpy as np
import pytest
from support.drawn_machines import LONG, SCENES, random_machine
from support.pictures import drawn_texts, faults_of

import camopt
from camopt.scene.machine import Machine
from camopt.show.machines.timing_sheet import draw
from camopt.show.machines.timing_spans import (
    TimingData,
    clearance_span,
    curve_angles_deg_and_values,
    linear_form_text,
)
from camopt.solve.machine.stations import resolve_stations

CLEARANCES = [
    *({"between": ["station 1"], "along": [1], "angles": [a, a + width]} for a, width in ((-40, 90), (10, 360))),
    {"name": f"{LONG} keeps away", "between": ["station 0", "station 2"], "along": [-1, 2.5], "angles": [100, 120]},
]


def stations_of(machine):
    """The stations of a machine as tables, with their scenes inside."""
    return [
        {**station.model_dump(exclude_none=True), "scene": machine.scenes[station.name].to_dict()}
        for station in machine.station
    ]


def names_at(spans, angle):
    """The names of the spans that hold an angle [deg]."""
    return {span.name for span in spans for start, end in span.ranges_within_turn if start < angle < end}


@pytest.mark.parametrize("seed", range(2))
def test_segments_are_those_of_the_scene_at_the_cam_angle(seed):
    """At random angles of the shaft, from the segments of the scene and the angle of the cam."""
    machine, rng = random_machine(len(SCENES), seed), np.random.default_rng(seed)
    data = TimingData.from_machine(machine)
    for station, spans in zip(machine.station, data.spans, strict=True):
        if not (segments := machine.scenes[station.name].motion):  # a given profile
            continue
        ends = np.cumsum([segment.angle for segment in segments])
        for angle in rng.uniform(0.0, 360.0, 100):
            cam_angle = (angle - station.phase) * station.ratio % 360.0
            if np.abs(cam_angle - np.array([0.0, *ends])).min() > 1e-6:
                segment = segments[int(np.searchsorted(ends, cam_angle))].segment
                name = "move" if segment == "constant-velocity" else segment
                assert names_at(spans, angle) == {name}, (station.name, angle)
        assert sum(end - start for span in spans for start, end in span.ranges_within_turn) == pytest.approx(360.0)


def test_ends_of_segments_shifted_repeated_and_split():
    station = {"name": "a", "scene": "two-pauses", "phase": -30.0, "ratio": 2}
    (spans,) = TimingData.from_machine(Machine(station=[station])).spans
    ends = [0.0, 120.0, 165.0, 315.0]
    starts = sorted((end / 2 + 180.0 * turn - 30.0) % 360.0 for end in ends for turn in range(2))
    assert [span.start for span in spans] == pytest.approx(starts)
    crossing = [span for span in spans if len(span.ranges_within_turn) == 2]
    assert [span.ranges_within_turn for span in crossing] == [[(330.0, 360.0), (0.0, 30.0)]]
    assert crossing[0].name == "rise"


def test_dwells_that_follow_each_other_are_one():
    (spans,) = TimingData.from_machine(Machine(station=[{"name": "a", "scene": "indexing-overlap"}])).spans
    assert [span.name for span in spans] == ["move", "dwell"]


def test_points_of_a_curve_are_on_it():
    machine = camopt.find_machine("pick-and-place")
    for station in resolve_stations(machine):
        angles, values = curve_angles_deg_and_values(station.lift)
        assert (angles[0], angles[-1]) == pytest.approx((0.0, 360.0))
        programme = station.problem.programme.tool
        cam = np.radians(angles - station.station.phase) * station.station.ratio % (2 * np.pi)
        assert values == pytest.approx(programme.motion_at(cam, 0)[0] / programme.unit_in_mm_or_rad, abs=1e-9)


def test_clearances_in_words():
    machine = random_machine(3, clear=CLEARANCES)
    spans = [span for _, span in TimingData.from_machine(machine).clearances]
    assert [span.ranges_within_turn for span in spans] == [
        [(320.0, 360.0), (0.0, 50.0)],
        [(0.0, 360.0)],
        [(100.0, 120.0)],
    ]
    assert spans[0].words == "station 1 ≥ 0 deg"  # its tool turns
    assert spans[2].words == "−station 0 + 2.5·station 2 ≥ 0 mm"
    assert linear_form_text([-2.0, -1.0], ["a", "b"]) == "−2·a − b"
    unit = camopt.find_machine("pick-and-place")
    assert clearance_span(unit.clear[2], "mm").words == "distance lift – feed ≥ 2 mm"


def test_an_evaluation_shows_the_least_of_each_clearance():
    machine = camopt.find_machine("pick-and-place")
    clear = [each.model_dump() for each in machine.clear[:2]]
    clear[1] |= {"at_least": 1e3}
    result = camopt.evaluate_machine(Machine(station=stations_of(machine), clear=clear))
    (_, held), (_, broken) = TimingData.from_machine(result).clearances
    assert (held.name, broken.name) == ("clearance held", "clearance broken")
    for span, least in zip((held, broken), result.clearances, strict=True):
        assert f"least {least.upper:.4g} mm at {least.angle:.5g}°" in span.words
    texts = {text.get_text() for text, _ in drawn_texts(draw(result))[0]}
    assert {"clearance held", "clearance broken"} <= texts


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize(("count", "system"), [(1, "mm"), (5, "inch"), (12, "mm"), (12, "inch"), (20, "mm")])
def test_no_text_hides_another_and_all_are_printed(count, system):
    machine = random_machine(count, count, clear=CLEARANCES if count > 2 else [])
    with camopt.shown_in(system):
        figure = draw(machine)
        assert faults_of(figure) == []
        texts = [text.get_text() for text, _ in drawn_texts(figure)[0]]
    words = " ".join(texts)
    assert [station.name for station in machine.station if station.name not in words] == []
    assert [f"{angle}°" for angle in range(0, 361, 30) if texts.count(f"{angle}°") < 2] == []
    assert "have no room" not in words
    assert {clearance.title for clearance in machine.clear if clearance.title not in words} == set()
    width, height = figure.get_size_inches() * 25.4
    paper = {"mm": (420.0, 297.0), "inch": (431.8, 279.4)}[system]
    assert ((width, height) == pytest.approx(paper)) == (count <= 12)


def test_texts_are_at_the_angles_of_changes():
    """The number of an angle is above its place on the scale."""
    machine = random_machine(1, 7)
    texts, _ = drawn_texts(draw(machine))
    places = {text.get_text(): (box.x0 + box.x1) / 2 for text, box in texts}
    start, end = places["0°"], places["360°"]
    for angle in TimingData.from_machine(machine).spans[0]:
        label = f"{angle.start:.2f}".rstrip("0").rstrip(".")
        assert places[label] == pytest.approx(start + (end - start) * angle.start / 360.0, abs=1.5)


def test_torque_of_the_shaft_is_the_sum():
    data = TimingData.from_machine(camopt.find_machine("pick-and-place"))
    angles = np.linspace(0.0, 2 * np.pi, 7, endpoint=False)
    total = sum(torque.curve.value(angles) for torque in data.torques)
    assert data.total_torque.curve.value(angles) == pytest.approx(total)
    with camopt.shown_in("inch"):
        words = TimingData.from_machine(data.machine).total_torque.peak_words
    peak = camopt.evaluate_machine(data.machine).shaft
    assert words == f"{peak.peak / 0.1129848290276167:.4g} lbf·in at {np.degrees(peak.peak_angle):.2f}°"


@pytest.mark.slow
def test_the_same_machine_gives_the_same_file(tmp_path):
    paths = [tmp_path / f"{name}.svg" for name in "ab"]
    for path in paths:
        camopt.plot("pick-and-place", path)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert ">Pick-and-place unit<" in paths[0].read_text(encoding="utf-8")
    camopt.plot(camopt.find_machine("pick-and-place"), tmp_path / "timing.pdf")
    assert (tmp_path / "timing.pdf").read_bytes().startswith(b"%PDF")


def test_a_machine_without_speed_has_no_times():
    machine = Machine(station=[{"name": "a", "scene": "two-pauses"}])
    assert machine.shaft_rpm is None
    texts = {text.get_text() for text, _ in drawn_texts(draw(machine))[0]}
    assert not any(text.startswith("time [") for text in texts)
