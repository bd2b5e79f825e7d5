"""Every picture: no text on another or off the page, text as text, one style; each is returned, saved or not."""

import re
import subprocess
import sys
from functools import cache
from importlib.resources import files

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from support.cams import cam_with
from support.depth import covering_cases
from support.faults import calls_of, with_fault
from support.pictures import crossed_texts, drawn_texts, faults_of
from test_figures import LIMITED, LOADED, OTHERS, TITLES, load_diagrams, loaded_scene, plain_scene

import camopt
from camopt import BadInput, Scene, find_scene, plot, shipped_scenes
from camopt.scene.problem.problem import resolve_design
from camopt.show.drawing.labels import Label, label_place_candidates, place_labels
from camopt.show.drawing.panels import motion_panels
from camopt.show.drawing.picture import Picture
from camopt.show.drawing.style import (
    COLOURS,
    DASHES,
    PALE_ALARM,
    SERIES,
    STILL_KINDS,
    new_figure,
    series_line_style,
)
from camopt.show.studies.accuracy import AccuracyCosts

RISE_AND_FALL = [
    {"segment": "rise", "angle": 60, "lift": 1e4, "law": "cycloidal"},
    {"segment": "return", "angle": 300, "lift": 1e4, "law": "poly345"},
]
SHORT = [
    {"segment": "rise", "angle": 12, "lift": 2, "law": "cycloidal"},
    {"segment": "dwell", "angle": 6},
    {"segment": "return", "angle": 10, "lift": 2, "law": "modified-trapezoid"},
    {"segment": "dwell", "angle": 332},
]
SCENES = {
    **{name: (lambda name=name: find_scene(name)) for name in shipped_scenes()},
    **{f"loaded {name}": (lambda name=name: loaded_scene(name)) for name in LOADED},
    **{f"made {name}": (lambda name=name: plain_scene(name)) for name in OTHERS},
    "impulses": lambda: plain_scene("cornered", "uniform"),
    "every limit": lambda: loaded_scene("roller", limits=LIMITED),
    **{f"only {effect}": (lambda effect=effect: loaded_scene("roller", outputs=[effect])) for effect in TITLES},
    "large": lambda: find_scene("roller-1000rpm").replace(motion=RISE_AND_FALL, **{"cam.base_radius": 2e4}),
    "short strokes": lambda: find_scene("roller-1000rpm").replace(motion=SHORT),
    "tiny profile": lambda: plain_scene("cornered").replace(
        **{"cam.base_radius": 0.5, "follower.roller_radius": 40.0}
    ),
    "fast": lambda: find_scene("roller-1000rpm").replace(**{"cam.rpm": 30000}),
}


def features(name):
    """What a picture shows that others may not: its mechanism, its number of diagrams, faults and extremes."""
    group, _, which = name.partition(" ")
    if group == "only":
        return [len(TITLES[which])]
    cam, follower, shipped = SCENES[name]().cam, SCENES[name]().follower, name in shipped_scenes()
    usual = shipped or (group in ("made", "loaded") and not which.startswith("undercut"))
    return [(shipped, cam.form, follower.motion, follower.contact), *([] if usual else [name])]


DRAWN = covering_cases(SCENES, features)


@pytest.fixture(scope="module")
def picture(tmp_path_factory):
    """Of a scene by its name, drawn once: the faults of its picture, and its SVG file."""
    folder = tmp_path_factory.mktemp("pictures")

    @cache
    def draw_picture(name):
        figure = plot(SCENES[name](), folder / "cam.svg")
        return faults_of(figure), (folder / "cam.svg").read_text(encoding="utf-8")

    return draw_picture


def assert_texts_apart(name, picture):
    faults, written = picture(name)
    assert faults == []
    assert "DejaVuSans-" not in written  # a glyph drawn as a path
    shown = re.findall(r"<text[^>]*>([^<]*)</text>", written)
    velocity = "Velocity of the tool, " if SCENES[name]().train else "Velocity, "
    assert len([text for text in shown if text.startswith(velocity)]) == 1


@pytest.mark.slow
@pytest.mark.one_in(14)
@pytest.mark.parametrize("name", DRAWN)
def test_the_texts_of_a_cam_are_apart_on_the_page_and_texts(name, picture):
    assert_texts_apart(name, picture)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["press-feed-by-pair", "valve-with-rocker"])
def test_the_texts_of_a_pair_and_of_a_train_are_apart(name, picture):
    """A pair has thin lines, of its second contact; behind a train the diagrams are of the tool."""
    assert_texts_apart(name, picture)


@pytest.mark.slow
def test_a_note_is_beside_the_title_of_its_diagram_however_long_both_are(tmp_path):
    """A tool that slides with moves, behind a follower that swings."""
    moves = [
        {"segment": "move", "angle": 75, "to": 30},
        {"segment": "constant-velocity", "angle": 70, "to": 73.5},
        {"segment": "move", "angle": 20, "to": 75},
        {"segment": "dwell", "angle": 60},
        {"segment": "return", "angle": 105, "law": "modified-sine", "to": 0},
        {"segment": "dwell", "angle": 30},
    ]
    figure = plot(find_scene("press-ram-by-four-bar").replace(motion=moves), tmp_path / "press.png")
    texts, _ = drawn_texts(figure)
    (note,) = (box for text, box in texts if text.get_text().startswith("squares: conditions of moves"))
    (title,) = (box for text, box in texts if text.get_text() == "Displacement of the tool, mm")
    assert title.x1 < note.x0


def test_the_band_of_an_undercut_needs_no_opacity(tmp_path):
    """Printers lose it. The page of a result draws the band below its curves, too."""
    name = next(name for name in OTHERS if name.startswith("undercut"))
    figure = plot(SCENES[f"made {name}"](), tmp_path / "cam.svg")
    bands = [
        part for axes in figure.axes for part in axes.collections if to_hex(part.get_facecolor()[0]) == PALE_ALARM
    ]
    assert bands
    assert all(part.get_alpha() in (None, 1.0) for part in bands)
    style = (files("camopt.show.reporting") / "assets" / "page.css").read_text(encoding="utf-8")
    (rule,) = re.findall(r"\.undercut \{([^}]*)\}", style)
    assert "opacity" not in rule


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", [name for name in shipped_scenes() if name in DRAWN])
def test_shipped_scene_draws(name, picture):
    _, written = picture(name)
    assert find_scene(name).name in written
    of_form = ("base circle", "ω") if find_scene(name).cam.form == "disc" else ("the surface moves",)
    for label in ("Displacement", "Velocity", "Acceleration", "Jerk", "cam angle, deg", *of_form):
        assert label in written


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", [name for name in OTHERS if f"made {name}" in DRAWN])
def test_other_mechanisms_draw(name, picture):
    _, written = picture(f"made {name}")
    assert (">undercut<" in written) == name.startswith("undercut")
    assert ("the surface moves" in written) == name.endswith("groove")


@pytest.mark.parametrize("effect", TITLES)
def test_the_diagrams_are_those_of_the_effects_that_ran(effect):
    assert {panel.title for panel in load_diagrams(SCENES[f"only {effect}"]())} == TITLES[effect]


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("effect", [effect for effect in TITLES if f"only {effect}" in DRAWN])
def test_a_picture_has_the_diagrams_of_the_effects_that_ran(effect, picture):
    _, written = picture(f"only {effect}")
    assert {title for titles in TITLES.values() for title in titles if title in written} == TITLES[effect]


def test_uniform_velocity_under_a_roller_shows_impulses_and_undercut(picture):
    _, written = picture("impulses")
    assert "arrows: impulses, where the velocity jumps" in written
    assert "undercut" in written


def test_picture_says_the_exact_values(picture):
    _, written = picture("roller-1000rpm")
    for label in ("pitch point 41.63°", "−29.8°", "6.667", "888.9", "ρ 35.66 mm", "broken limits: pressure angle"):
        assert label in written
    circles = ("prime circle, R 55", "pitch circle, R 78.81", "offset circle, R 20")
    for label in (*circles, "offset 20", "1000 rev/min"):
        assert label in written


@pytest.mark.slow
@pytest.mark.parametrize(("file", "start"), [("cam.PNG", b"\x89PNG"), ("cam.pdf", b"%PDF"), ("cam.SVG", b"<?xml")])
def test_a_file_is_what_its_name_says_and_the_figure_comes_back(file, start, tmp_path):
    figure = plot(find_scene("roller-1000rpm"), tmp_path / file)
    assert (tmp_path / file).read_bytes().startswith(start)
    assert [path.name for path in tmp_path.iterdir()] == [file]
    assert figure.axes


@pytest.mark.slow
def test_a_notebook_shows_a_figure_without_pyplot():
    code = (
        "import camopt, sys; f = camopt.plot(camopt.find_scene('two-pauses')); print(f._repr_png_()[1:4].decode())"
    )
    code += "; assert 'matplotlib.pyplot' not in sys.modules"
    shown = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert shown.stdout == "PNG\n"


SPECTRUM = camopt.response_spectrum("cycloidal", np.linspace(0.5, 4.0, 20), damping_ratio=0.02)


@cache
def spectra():
    return [camopt.response_spectrum(law, np.linspace(0.5, 4.0, 20), damping_ratio=0.02) for law in camopt.LAWS]


def test_spectra(tmp_path):
    assert faults_of(camopt.plot(spectra(), tmp_path / "spectrum.svg")) == []
    assert "DejaVuSans-" not in (tmp_path / "spectrum.svg").read_text(encoding="utf-8")


def accuracy_rows(shift=0.0):
    """Rows as ``camopt.show.studies.accuracy.measure`` gives them: some methods are equally good and slow."""
    rows = []
    for quantity in ("pressure angle", "smallest radius", "curvature"):
        errors = {
            "sampling": [(n, 3.0 * n, 1e2 / n**2) for n in (36, 72, 360, 720, 3600)],
            "sampling, polished": [(n, 3.5 * n, 4e1 / n**2 + shift) for n in (36, 360)],
            "enclosure": [(1e-4, 280.0, 9e-8), (1e-6, 281.0, 8.9e-8), (1e-9, 290.0, 3e-10), (1e-12, 380.0, 4e-13)],
            "50 digits": [(1e-25, 2e7, 1e-25)],
        }
        rows += [
            {"quantity": quantity, "method": m, "setting": n, "ns_per_design": t, "error_max": e}
            for m, each in errors.items()
            for n, t, e in each
        ]
    return AccuracyCosts(find_scene("roller-1000rpm"), rows)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("shift", [0.0, 0.05])
def test_what_accuracy_costs(shift, tmp_path):
    figure = camopt.plot(accuracy_rows(shift), tmp_path / "accuracy.svg")
    assert faults_of(figure) == []
    assert "DejaVuSans-" not in (tmp_path / "accuracy.svg").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_design_and_an_evaluation_have_the_picture_of_their_scene(tmp_path):
    scene = find_scene("two-pauses")
    plot(scene, tmp_path / "scene.svg")
    for name, what in {"design": camopt.optimise(scene).best, "evaluation": camopt.evaluate(scene)}.items():
        plot(what, tmp_path / f"{name}.svg")
        plot(what.scene, tmp_path / "alone.svg")
        assert (tmp_path / f"{name}.svg").read_bytes() == (tmp_path / "alone.svg").read_bytes()
    assert (tmp_path / "evaluation.svg").read_bytes() == (tmp_path / "scene.svg").read_bytes()


@pytest.mark.parametrize(
    "what", [3, ["two-pauses"], None, [], [find_scene("two-pauses"), 3], [SPECTRUM, find_scene("two-pauses")]]
)
def test_what_has_no_picture_is_told(what, tmp_path):
    with pytest.raises(BadInput, match=r"what = .*must be a scene, a design, or a result that has a picture"):
        plot(what, tmp_path / "a.svg")
    assert not list(tmp_path.iterdir())


def test_several_cams_are_no_picture(tmp_path):
    with pytest.raises(BadInput, match="or a list of results of response_spectrum"):
        plot([find_scene("two-pauses")] * 2, tmp_path / "a.svg")


@pytest.mark.parametrize("path", ["a.bmp", "a"])
def test_another_kind_of_file_is_refused(path, tmp_path):
    for draw in (
        lambda file: camopt.plot(spectra(), file),
        lambda file: plot(find_scene("two-pauses"), file),
    ):
        with pytest.raises(BadInput, match=r"\.png, \.svg or \.pdf"):
            draw(tmp_path / path)
    assert not list(tmp_path.iterdir())


def test_no_two_lines_of_a_series_look_alike():
    pens = [tuple(series_line_style(place).values()) for place in range(len(SERIES) * len(DASHES))]
    assert len(set(pens)) == len(pens) >= len(camopt.LAWS)


@pytest.mark.parametrize("several", [False, True], ids=["a line", "lines"])
def test_a_label_is_clear_of_all_the_width_of_a_line(several):
    ends = np.array([[0.0, 0.5], [1.0, 0.5]])
    with new_figure(None, (4.0, 3.0)) as figure:
        axes = figure.add_subplot()
        if several:
            axes.add_collection(LineCollection([ends, ends], linewidths=[16.0, 1.0]))
        else:
            axes.plot(*ends.T, linewidth=16.0)
        place_labels(figure, [Label(axes, "8", (0.5, 0.5), label_place_candidates([4.0, 12.0]), {})])
    texts, colours = drawn_texts(figure)
    assert [text.get_text() for text, _ in texts].count("8") == 1
    assert crossed_texts(texts, colours) == []


@pytest.mark.parametrize("several", [False, True], ids=["a line", "lines"])
def test_a_label_that_has_to_cross_a_line_crosses_the_thinnest(several):
    levels, widths = (0.3, 0.5, 0.7), (3.0, 3.0, 0.8)
    with new_figure(None, (4.0, 3.0)) as figure:
        axes = figure.add_subplot()
        axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
        if several:
            axes.add_collection(LineCollection([[(0.0, y), (1.0, y)] for y in levels], linewidths=widths))
        else:
            for y, width in zip(levels, widths, strict=True):
                axes.plot([0.0, 1.0], [y, y], linewidth=width)
        apart = 0.2 * axes.bbox.height * 72.0 / figure.dpi
        place_labels(figure, [Label(axes, "8", (0.5, 0.5), [(1.0, 0.0), (0.0, -apart), (0.0, apart - 4.0)], {})])
        (label,) = axes.texts
        assert label.get_position() == (0.0, apart - 4.0)


def test_a_label_is_not_behind_a_body_that_is_larger():
    with new_figure(None, (4.0, 3.0)) as figure:
        axes = figure.add_subplot()
        axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
        axes.fill([0.4, 0.4, 0.9, 0.9], [0.1, 0.9, 0.9, 0.1], zorder=5)
        place_labels(figure, [Label(axes, "8", (0.5, 0.5), [(20.0, 0.0), (-60.0, 0.0)], {})])
        (label,) = axes.texts
        assert label.get_position() == (-60.0, 0.0)


LMS = np.array([[17.8824, 43.5161, 4.11935], [3.45565, 27.1554, 3.86714], [0.0299566, 0.184309, 1.46709]])
BLIND = {  # Viénot, Brettel and Mollon (1999): what stands for the cone that is missing
    "protan": np.array([[0.0, 2.02344, -2.52581], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "deutan": np.array([[1.0, 0.0, 0.0], [0.494207, 0.0, 1.24827], [0.0, 0.0, 1.0]]),
}
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def colour_seen(colour, kind):
    """CIE L*a*b* of a colour as a kind of colour vision sees it."""
    rgb = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    linear = np.clip(np.linalg.solve(LMS, BLIND[kind] @ LMS @ linear), 0.0, 1.0)
    ratio = XYZ @ linear / XYZ.sum(axis=1)
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("kind", BLIND)
@pytest.mark.parametrize("colours", [SERIES[:6], (*COLOURS.values(),)], ids=["series", "strokes"])
def test_colours_are_apart_for_the_colour_blind(colours, kind):
    seen = [colour_seen(colour, kind) for colour in colours]
    apart = [np.linalg.norm(a - b) for k, a in enumerate(seen) for b in seen[:k]]
    assert min(apart) > 10.0  # ten times what is just seen


@pytest.mark.parametrize("contact", ["groove", "groove-arm"])
def test_the_thin_line_is_the_curvature_of_the_left_flank(contact):
    """That of the drawn flanks: by how much three points of each turn, per length."""
    scene = Scene.from_dict(cam_with(contact))
    picture = Picture(scene, resolve_design(scene))
    (panel,) = (each for each in motion_panels(picture) if each.title == "Curvature of the flanks")
    assert panel.note.startswith("thin: left flank")
    assert panel.other is not None
    names = [flank.name for flank in picture.problem.setup.mechanism.flanks]
    for name, lines in (("right", panel.values), ("left", panel.other)):
        for curves, line in zip(picture.curves, lines, strict=True):
            step = np.diff(curves.profile[names.index(name)])
            turned = np.angle(step[1:] / step[:-1]) / (0.5 * (np.abs(step[1:]) + np.abs(step[:-1])))
            middle = slice(len(line) // 5, -len(line) // 5)
            np.testing.assert_allclose(line[1:-1][middle], turned[middle], rtol=2e-2, atol=2e-4)


@pytest.mark.slow
@pytest.mark.one_in(5)
@pytest.mark.parametrize("kind", STILL_KINDS)
@pytest.mark.parametrize("fault", ["EIO", "ENOSPC"])
def test_a_disk_that_fails_is_told_as_such(kind, fault, tmp_path):
    """Whatever library draws: it may have its own trouble with a file that it cannot finish."""
    path = tmp_path / f"picture{kind}"

    def draw():
        with new_figure(path, (1.0, 1.0)) as figure:
            figure.add_artist(Line2D(*np.random.default_rng(0).random((2, 5000))))  # more than a buffer holds

    calls = calls_of(tmp_path, draw)
    assert "write" in calls
    path.unlink()
    for number, call in enumerate(calls):
        if call in ("open for writing", "write"):
            assert with_fault(tmp_path, draw, number, fault).code == 3
            assert [*tmp_path.iterdir()] == []
