"""Constructions with ruler and compasses: read back from the SVG alone, and held against the curves of the cam."""

import json
from itertools import combinations
from math import cos, hypot, pi, radians, sin
from random import Random
from xml.etree import ElementTree

import numpy as np
import pytest
from support.depth import is_deep
from support.pictures import drawn_texts
from support.references import WORKED

from camopt import BadInput, Scene, construct, evaluate, find_scene, plot
from camopt.model.mechanisms.geometry import cam_curves
from camopt.show.drawing.construction.answers import stroke_peaks_with_text
from camopt.show.drawing.construction.displacement import CONSTRUCTION_BY_LAW, DiagramScale, construct_laws

SHEET = 1e-6  # of the width of the sheet: what may be lost on the way to the file
SVG = "{http://www.w3.org/2000/svg}"


def construction_of(scene, parts=6):
    inversion = construct(scene, parts).inversion
    return inversion.picture, inversion


# ------------------------------------------------------------------ from the file alone


def lines_of(file):
    """The width of the sheet, and the points of every named line or mark of an SVG file, y upwards."""
    root = ElementTree.parse(file).getroot()
    found = {}
    for group in (each for each in root.iter(f"{SVG}g") if each.get("id")):
        path, mark = group.find(f"{SVG}path"), next(group.iter(f"{SVG}use"), None)
        if path is not None:
            numbers = [float(word) for word in path.get("d").split() if word[0] in "-.0123456789"]
            found.setdefault(group.get("id"), np.array(numbers[::2]) - 1j * np.array(numbers[1::2]))
        elif mark is not None:
            found.setdefault(group.get("id"), np.array([float(mark.get("x")) - 1j * float(mark.get("y"))]))
    return float(root.get("viewBox").split()[2]), found


def lines_named(lines, name):
    """The lines that stations have, by the station's number."""
    return {key.removeprefix(f"{name}-"): points for key, points in lines.items() if key.startswith(f"{name}-")}


def centre_and_radius(points):
    centre = np.mean(points[:-1])
    return centre, float(np.mean(np.abs(points - centre)))


def distance_to(points, place):
    """The least distance of a place from a polyline."""
    start, along = points[:-1], np.diff(points)
    start, along = start[along != 0], along[along != 0]
    share = np.clip(((place - start) * along.conj()).real / np.abs(along) ** 2, 0, 1)
    return float(np.abs(start + share * along - place).min())


@pytest.mark.slow
@pytest.mark.one_in(18)
@pytest.mark.parametrize("name", WORKED)
def test_the_file_alone_shows_the_construction_of_a_worked_cam(name, tmp_path):  # noqa: PLR0915
    """Tangents touch the offset circle, stations lie on them at the ordinates of the diagram, rollers touch."""
    scene, given = find_scene(name), WORKED[name]["scene"]
    plot(scene, tmp_path / "cam.svg", construction=6)
    width, lines = lines_of(tmp_path / "cam.svg")
    near = SHEET * width
    centre, base = centre_and_radius(lines["base-circle"])
    scale = base / float(given["base_radius"])  # points of the file for a mm of the cam
    radius, offset = (scale * float(given.get(key, 0)) for key in ("roller_radius", "offset"))
    prime = centre_and_radius(lines["prime-circle"])[1] if radius else base
    assert prime == pytest.approx(base + radius, abs=near)
    starts, stations, guides = (
        lines_named(lines, "start"),
        lines_named(lines, "station"),
        lines_named(lines, "guide"),
    )
    ordinates, set_off = lines_named(lines, "ordinate"), lines_named(lines, "set-off")
    assert set(starts) == set(stations) == set(guides) == set(ordinates) == set(set_off)
    height = lines["axis-AY"][-1].imag - lines["axis-AY"][0].imag
    for number, (station,) in stations.items():
        guide, (start,) = guides[number], starts[number]
        foot, top = ordinates[number]
        assert abs(abs(start - centre) - prime) < near
        if "arm_length" in given:
            (pivot,) = lines[f"pivot-{number}"]
            assert abs(pivot - centre) == pytest.approx(scale * given["centre_distance"], abs=near)
            assert np.abs(np.abs(guide - pivot) - scale * given["arm_length"]).max() < near
            swung = abs(np.angle((station - pivot) / (start - pivot)))
            assert swung == pytest.approx((top - foot).imag / height * radians(given["segs"][0][3]), abs=2e-6)
        else:
            along = np.diff(guide)[0] / abs(np.diff(guide)[0])
            assert abs(((centre - start) * along.conj()).imag) == pytest.approx(offset, abs=near)
            assert abs(((station - start) * along.conj()).imag) < near
            lift = scale * float(given["segs"][0][3])
            assert abs(station - start) == pytest.approx((top - foot).imag / height * lift, abs=near)
        if radius:
            assert distance_to(lines["profile"], station) == pytest.approx(radius, abs=near)
        elif given["follower"].endswith("flat"):
            first, last = lines[f"face-{number}"]
            normal = 1j * (last - first) / abs(last - first)
            heights = ((lines["profile"] - first) * np.conj(normal)).real * np.sign(
                ((first - centre) * np.conj(normal)).real
            )
            assert heights.max() == pytest.approx(0.0, abs=near)
        else:
            assert distance_to(lines["profile"], station) < near
    if offset:
        assert centre_and_radius(lines["offset-circle"])[1] == pytest.approx(offset, abs=near)
    turned = {number: np.angle((point[0] - centre) / (starts["0"][0] - centre)) for number, point in starts.items()}
    per_turn = lines["axis-AX"][-1].real - lines["axis-AX"][0].real
    sense = 1.0 if given.get("rotation") == "cw" else -1.0
    for number, angle in turned.items():
        cam_angle = 2 * pi * (ordinates[number][0].real - lines["axis-AX"][0].real) / per_turn
        assert abs(np.exp(1j * angle) - np.exp(1j * sense * cam_angle)) < 1e-5


# ------------------------------------------------------------------ random cams of every kind


def random_turn(random, most):
    law = [random.choice([*CONSTRUCTION_BY_LAW, "modified-sine", "poly345"]) for _ in range(2)]
    angles = [random.uniform(60, 120), random.uniform(0, 50), random.uniform(60, 120)]
    lift, names = random.uniform(0.2, 1.0) * most, ("rise", "dwell", "return", "dwell")
    segments = [
        {"segment": "rise", "angle": angles[0], "lift": lift, "law": law[0]},
        {"segment": "dwell", "angle": angles[1]},
        {"segment": "return", "angle": angles[2], "lift": lift, "law": law[1]},
        {"segment": "dwell", "angle": 360 - sum(angles)},
    ]
    assert [each["segment"] for each in segments] == list(names)
    return segments


def random_scene(kind, seed):
    """A cam with sizes and a motion that are not round."""
    random = Random(f"{kind} {seed}")
    form, motion, contact = kind.split("-")
    swinging = motion == "oscillating"
    base = random.uniform(30, 80)
    follower = {"motion": motion, "contact": contact}
    if contact in ("roller", "spherical"):
        follower["roller_radius" if contact == "roller" else "face_radius"] = random.uniform(4, 15)
    if form == "cylindrical":
        follower |= {"arm_length": random.uniform(60, 120)} if swinging else {}
    elif swinging and contact == "flat":
        follower |= {"centre_distance": base + random.uniform(40, 90), "face_offset": random.uniform(-10, 10)}
    elif swinging:
        centre = base + random.uniform(60, 110)
        follower |= {"centre_distance": centre, "arm_length": random.uniform(0.75, 0.98) * centre}
    elif contact != "flat":
        follower["offset"] = random.choice([0.0, random.uniform(-0.5, 0.5) * base])
    size = {"mean_radius": base} if form == "cylindrical" else {"base_radius": base}
    cam = {"form": form, "rotation": random.choice(["cw", "ccw"]), **size}
    return {"cam": cam, "follower": follower, "motion": random_turn(random, 18 if swinging else 25)}


KINDS = [
    *(f"disc-translating-{contact}" for contact in ("knife", "roller", "spherical", "flat")),
    *(f"disc-oscillating-{contact}" for contact in ("knife", "roller", "spherical", "flat")),
    *(f"cylindrical-{motion}-roller" for motion in ("translating", "oscillating")),
]


@pytest.mark.slow
@pytest.mark.one_in(9)
@pytest.mark.parametrize("kind", KINDS)
def test_stations_are_points_of_the_cam(kind):
    """Constructed points lie on the pitch curve, rollers and faces touch the profile, tangents a circle."""
    random, drawn_cams = Random(kind), 0
    for seed in range(100 if is_deep() else 25):
        try:
            scene = Scene(**random_scene(kind, seed))
            picture, inversion = construction_of(scene, random.choice(range(4, 26, 2)))
        except BadInput:
            continue
        drawn_cams += 1
        problem, plan = picture.problem, inversion.plan
        angles = np.array([each.angle for each in plan.stations])
        curves = cam_curves(problem.setup.mechanism, problem.design, problem.programme, angles)
        points = inversion.follower_point_in_cam_frame(
            angles, np.array([each.displacement for each in plan.stations])
        )
        size = inversion.drawing_reach
        shapes = {shape.name: shape.points for step in inversion.steps() for shape in step.shapes}
        for each, point, pitch in zip(plan.stations, points, curves.pitch, strict=True):
            guide = shapes[f"guide-{each.number}"]
            assert shapes[f"station-{each.number}"][0] == pytest.approx(point, abs=1e-12 * size)
            if kind.endswith("flat"):
                first, last = shapes[f"face-{each.number}"]
                along = (last - first) / abs(last - first)
                assert abs(((pitch - first) * along.conjugate()).imag) < 1e-9 * size
                assert -1e-9 < ((pitch - first) * along.conjugate()).real / abs(last - first) < 1 + 1e-9
                continue
            assert abs(point - pitch) < 1e-9 * size
            if inversion.angular:
                pivot = inversion.points_in_cam_frame(inversion.pivot, each.angle)
                arm = scene.follower.arm_length
                assert np.abs(np.abs(guide - pivot) - arm).max() < 1e-12 * size
            elif not inversion.is_developed:
                along = (guide[1] - guide[0]) / abs(guide[1] - guide[0])
                assert abs(abs((guide[0] * along.conjugate()).imag) - abs(inversion.offset)) < 1e-12 * size
                assert abs((guide[0] * along.conjugate()).real) < 1e-12 * size
        if inversion.roller_radius and not scene_has_corner(picture):
            for profile in curves.profile:
                assert np.abs(np.abs(profile - points) - inversion.roller_radius).max() < 1e-9 * size
    assert drawn_cams > 10


def scene_has_corner(picture):
    return bool(picture.problem.programme.corners)


@pytest.mark.parametrize("parts", [4, 6, 8, 12, 24])
@pytest.mark.parametrize("law", CONSTRUCTION_BY_LAW)
def test_each_construction_gives_the_ordinates_of_its_law(law, parts):
    """Against the equations of the lectures, on rises and returns between any levels."""
    equations = {
        "uniform": lambda x: x,
        "harmonic": lambda x: (1 - cos(pi * x)) / 2,
        "parabolic": lambda x: 2 * x * x if x <= 0.5 else 1 - 2 * (1 - x) ** 2,
        "cycloidal": lambda x: x - sin(2 * pi * x) / (2 * pi),
    }
    half = [{"segment": "rise", "angle": 70.3, "lift": 11.7, "law": law}, {"segment": "dwell", "angle": 9.1}]
    turn = [
        *half,
        *half,
        {"segment": "return", "angle": 122.2, "lift": 23.4, "law": law},
        {"segment": "dwell", "angle": 79.0},
    ]
    scene = find_scene("knife-300rpm-radial").replace(motion=turn)
    _, inversion = construction_of(scene, parts)
    scale = DiagramScale(30.0, 1.7)
    levels = [(0.0, 11.7), (11.7, 11.7), (23.4, -23.4)]
    found = construct_laws(inversion.plan, scale)
    for (start, change), division, each in zip(levels, inversion.plan.divisions, found, strict=True):
        expected = [start + change * equations[law](k / parts) for k in range(parts + 1)]
        assert each.points.imag == pytest.approx(1.7 * np.array(expected), abs=1e-12 * 40)
        angles = [station.angle for station in division.stations]
        assert each.points.real == pytest.approx(30.0 * np.array(angles), rel=1e-14)


# ------------------------------------------------------------------ letters, answers, files


CROWDED = ["valve-rod-offset", "oscillating-roller", "flat-reciprocating", "barrel-traverse"]


@pytest.mark.slow
@pytest.mark.one_in(9)
@pytest.mark.parametrize("parts", [6, 8, 12])
@pytest.mark.parametrize(
    "name", ["valve-rod-offset", "oscillating-roller", "flat-reciprocating", "barrel-traverse"]
)
def test_letters_do_not_overlap(name, parts):
    """On the whole sheet no text lies on another, and none leaves it."""
    figure = plot(find_scene(name), construction=parts)
    texts = [(artist.get_text(), box) for artist, box in drawn_texts(figure)[0]]
    meeting = [(a, b) for (a, one), (b, other) in combinations(texts, 2) if one.padded(-0.6).overlaps(other)]
    assert meeting == []
    page = figure.bbox
    assert [t for t, b in texts if b.x0 < page.x0 or b.x1 > page.x1 or b.y0 < page.y0 or b.y1 > page.y1] == []


@pytest.mark.parametrize("name", WORKED)
def test_answers_are_the_peaks_of_evaluate(name):
    scene = find_scene(name)
    _, inversion = construction_of(scene)
    found, values = stroke_peaks_with_text(inversion), evaluate(scene)
    timed, angular = scene.cam.rpm is not None, scene.follower.motion == "oscillating"
    units = (
        ("m_s", "m_s2") if timed else ("deg_per_rad", "deg_per_rad2") if angular else ("mm_per_rad", "mm_per_rad2")
    )
    names = [
        f"{quantity}_max_{kind}_{unit}"
        for kind in ("rise", "return")
        for quantity, unit in zip(("velocity", "acceleration"), units, strict=True)
    ]
    assert [value for value, _ in found] == pytest.approx([values[key] for key in names], rel=1e-12)


def test_letters_and_numbers_are_those_of_the_lectures():
    """A to G on the outstroke, H to P on the return; 1, 2, 3 … and 0′, 1′, 2′ …; S and T where the dwell is."""
    _, inversion = construction_of(find_scene("valve-rod-offset"))
    plan = inversion.plan
    assert [each.letter for each in plan.stations] == [*"ABCDEFGHJKLMNP"]
    assert [each.number for each in plan.stations] == [*"0123456", *(f"{k}′" for k in range(7))]
    assert [letter for letter, _ in plan.lettered_segment_ends] == ["A", "S", "T", "P", "X"]
    _, inversion = construction_of(find_scene("oscillating-roller"))
    assert [each.letter for each in inversion.plan.stations] == [*"ABCDEFGHJKLMN"]  # no dwell between the strokes
    assert len({each.letter for each in construction_of(find_scene("two-pauses"), 24)[1].plan.stations}) == 50


@pytest.mark.parametrize(
    "name", ["tangent-cam", "feeder-with-stop", "rocker-valve", "indexing-overlap", "two-pauses"]
)
def test_a_letter_is_one_place(name):
    """Of the turn: a station and an end of a stroke have the same letter only where they are the same."""
    plan = construction_of(find_scene(name))[1].plan
    places = [*((each.letter, each.angle) for each in plan.stations), *plan.lettered_segment_ends]
    angles = {letter: {round(angle, 9) for name, angle in places if name == letter} for letter, _ in places}
    assert [letter for letter, every in angles.items() if len(every) > 1] == []


@pytest.mark.parametrize("parts", [7, 2, 26, 0, -6, True, 6.5, "six"])
def test_other_numbers_of_parts_are_refused(parts):
    with pytest.raises(BadInput, match="must be an even number from 4 to 24"):
        plot(find_scene("two-pauses"), construction=parts)


def test_what_has_no_construction_says_why(tmp_path):
    with pytest.raises(BadInput, match="a follower with one contact"):
        plot(find_scene("press-feed-by-pair"), construction=6)
    with pytest.raises(BadInput, match=r"\.pdf or \.gif"):
        plot(find_scene("two-pauses"), tmp_path / "a.png", construction=6, steps=True)
    assert not [*tmp_path.iterdir()]


@pytest.mark.slow
def test_steps_are_pages_or_frames(command, tmp_path):
    """A page of a PDF, or a frame of a GIF, for each step that the sheet lists."""
    from PIL import Image
    from pymupdf import Document

    scene = find_scene("uniform-knife-offset")
    _, inversion = construction_of(scene)
    code, _, errors = command("plot", "uniform-knife-offset", "steps.pdf", "--construction", "--steps", "--quiet")
    assert (code, errors) == (0, "")
    with Document(tmp_path / "steps.pdf") as book:
        pages = [page.get_text() for page in book]
    assert len(pages) == 5 + len(inversion.steps())
    assert "tangents to the offset circle" in " ".join(pages[-3].split())
    plot(scene, tmp_path / "steps.gif", construction=4, steps=True)
    with Image.open(tmp_path / "steps.gif") as frames:
        assert frames.n_frames == len(pages)


@pytest.mark.slow
def test_the_command_prints_the_table_by_station(command):
    code, output, errors = command("plot", "two-pauses", "cam.svg", "--construction", "8")
    assert code == 0
    assert errors.strip() == "wrote cam.svg"
    assert output.count("\n") > 18
    code, output, _ = command("plot", "two-pauses", "cam.png", "--construction", "--json")
    stations = json.loads(output)["stations"]
    assert code == 0
    assert len(stations) == 14
    third = stations[3]
    assert third["cam_angle_deg"] == pytest.approx(60)
    assert third["displacement"] == pytest.approx(20)
    assert third["point"][0] == pytest.approx(hypot(12.5, (37.5**2 - 12.5**2) ** 0.5 + 20))
    assert command("plot", "two-pauses", "cam.svg", "--steps")[0] == 2
