"""Animations: each part is at every frame where the mechanism has it, and the files are whole and the same."""

import re
import subprocess
import sys
from base64 import b64decode
from functools import cache
from itertools import pairwise, repeat
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from support.cams import cam_with
from support.pictures import faults_of
from test_figures import OTHERS, plain_scene

import camopt
from camopt import BadInput, Scene, animate, find_scene
from camopt.cli.main import main
from camopt.model.mechanisms import MECHANISMS
from camopt.scene.problem.problem import resolve_design
from camopt.show.drawing.animated_figure import DISC_SIZE, SHOWN_PANELS, draw_animated_figure
from camopt.show.drawing.animation import animated_svg
from camopt.show.drawing.frames import find_ffmpeg, write_mp4
from camopt.show.drawing.moving_bodies import FRAME_ANGLES, FRAMES, TURN_TIME
from camopt.show.drawing.picture import Picture
from camopt.show.drawing.style import new_figure

G = "{http://www.w3.org/2000/svg}"
BELOW = [{"segment": "move", "angle": angle, "to": to} for angle, to in ((90, -5), (90, 6), (180, 0))]
SCENES = {
    **{name: plain_scene(name) for name in OTHERS if not name.startswith("undercut")},
    "roller": plain_scene("cornered"),
    "face": plain_scene("undercut face").replace(**{"cam.base_radius": 60.0}),
    "face that starts above": plain_scene("undercut face").replace(motion=BELOW, **{"cam.base_radius": 60.0}),
    "swinging face that starts above": plain_scene("swinging face").replace(motion=BELOW),
}
"""Each mechanism, most contacts, both senses of rotation."""


@cache
def animated_scene(name):
    """What is drawn, where it goes, and the SVG file plain_scene of it."""
    picture = Picture(SCENES[name], resolve_design(SCENES[name]))
    with new_figure(None, DISC_SIZE) as figure:
        stage = draw_animated_figure(figure, picture)
        return picture, stage, ElementTree.fromstring(animated_svg(stage))


def turning(name):
    """What animates the groups of an animation, by their ids."""
    groups = {group.get("id", ""): group for group in animated_scene(name)[2].iter(f"{G}g")}
    moving = {name: group for name, group in groups.items() if name.startswith(("body-", "reading-"))}
    return {name: motion for name, group in moving.items() for motion in group.iter(f"{G}animateTransform")}


def test_every_mechanism_is_among_the_scenes():
    found = {(s.cam.form, s.follower.motion, s.follower.contact == "flat") for s in SCENES.values()}
    assert found == set(MECHANISMS)
    assert {s.cam.rotation for s in SCENES.values()} == {"cw", "ccw"}


def values_of(motion):
    return np.array([[float(part) for part in value.split()] for value in motion.get("values").split(";")])


def displacement_of(scene):
    """At the frames, mm or deg: by the formulas of the laws of a rise and a return; of moves as points have it."""
    if scene.motion[0].segment == "move":
        angular = scene.follower.motion == "oscillating"
        found = camopt.cam_points(scene, np.degrees(FRAME_ANGLES[:-1]))[
            "displacement_deg" if angular else "displacement_mm"
        ]
        return np.append(found, found[0])
    lift, angles = scene.motion[0].lift, np.degrees(FRAME_ANGLES)
    rise, fall = np.clip(angles / 120, 0, 1), np.clip((angles - 160) / 100, 0, 1)
    up, down = rise - np.sin(2 * np.pi * rise) / (2 * np.pi), 10 * fall**3 - 15 * fall**4 + 6 * fall**5
    return lift * (up - down)


@pytest.mark.slow
@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", SCENES)
def test_the_svg_moves_the_follower_by_the_displacement(name):
    """From the numbers of the file, which are points of the page or degrees."""
    scene, groups = SCENES[name], turning(name)
    grooved, angular = scene.cam.form == "cylindrical", scene.follower.motion == "oscillating"
    ccw = 1.0 if scene.cam.rotation == "ccw" else -1.0
    assert {motion.get("dur") for motion in groups.values()} == {f"{TURN_TIME:g}s"}
    cam, follower = (values_of(groups[body]) for body in ("body-0", "body-2" if grooved else "body-1"))
    if grooved:  # the surface goes once round
        points_per_mm = -cam[-1, 0] / (2 * np.pi * scene.cam.mean_radius)
        np.testing.assert_allclose(cam[:, 0] / cam[-1, 0], np.linspace(0.0, 1.0, FRAMES + 1), atol=1e-5)
    else:
        axes = animated_scene(name)[1].bodies[0].axes
        points_per_mm = axes.get_position().width * DISC_SIZE[0] * 72 / np.ptp(axes.get_xlim())
        np.testing.assert_allclose(cam[:, 0], -ccw * np.degrees(FRAME_ANGLES), atol=1e-3)
    displacement = displacement_of(scene)
    risen = displacement - displacement[0]
    if angular:
        np.testing.assert_allclose(follower[:, 0], risen * (ccw if grooved else 1.0), atol=1e-4)
    else:
        np.testing.assert_allclose(-follower[:, 1] / points_per_mm, risen, atol=1e-3)
        assert not follower[:, 0].any()


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", [name for name in SCENES if SCENES[name].cam.form == "disc"])
def test_the_contact_is_on_the_turned_profile_and_on_the_follower(name):
    picture, stage, _ = animated_scene(name)
    cam, follower, contact = stage.bodies[:3]
    problem = picture.problem
    travel = problem.setup.mechanism.trace_and_normal(problem.design, problem.programme, np.zeros(1))
    start = travel.trace - float(problem.design.roller_radius[0]) * travel.normal
    for dot in contact.axes.lines:  # a knife edge has none
        assert dot.get_xydata()[0] @ [1, 1j] == pytest.approx(start[0])
    touched = contact.positions(start)[0]
    profile = cam.positions(np.concatenate([curves.profile[0] for curves in picture.curves]))
    assert np.abs(profile - touched).min(axis=0).max() < 0.01 * float(problem.design.size[0])  # a sample is near
    if SCENES[name].follower.contact == "flat":
        blade = next(patch for patch in follower.axes.patches if patch.get_zorder() == 5.0).get_xy() @ [1, 1j]
        first, second = follower.positions(blade[:2])
        np.testing.assert_allclose(((touched - first) * (second - first).conj()).imag, 0.0, atol=1e-9)
    if SCENES[name].follower.contact == "knife":
        np.testing.assert_allclose(follower.positions(start)[0], touched, atol=1e-9)


@pytest.mark.slow
def test_a_groove_passes_under_its_roller():
    for name in ("groove", "swinging groove"):
        picture, stage, root = animated_scene(name)
        surface, _, follower = stage.bodies[:3]
        problem = picture.problem
        here = problem.setup.mechanism.trace_and_normal(
            problem.design, problem.programme, FRAME_ANGLES % (2 * np.pi)
        ).trace
        turned = np.where(FRAME_ANGLES[-1] == FRAME_ANGLES, 2 * np.pi * problem.design.size[0], 0.0)
        at = here + turned  # the turn after it
        centre = follower.positions(here[:1])[0]
        np.testing.assert_allclose(at + surface.path, centre, atol=1e-9)
        (group,) = [group for group in root.iter(f"{G}g") if group.get("id") == "body-0"]
        paths = [path for path in group.iter(f"{G}path") if "fill: none" in path.get("style", "")]
        lines = [re.findall(r"[ML] ([-.\d]+)", path.get("d")) for path in paths]
        turn = -values_of(turning(name)["body-0"])[-1, 0]
        assert max(np.ptp([float(x) for x in line]) for line in lines) > 2.99 * turn  # the pitch curve
        assert np.ptp([float(x) for line in lines for x in line]) > 2.99 * turn


CRANK = {"stage": "bell-crank", "crank": 90, "coupler": 180, "offset": -70, "angle": -110}
LEVER = {"stage": "rocker", "input_arm": 40, "input_angle": -10, "output_arm": 55, "output_angle": -25}
TRAINS = {
    "slide": find_scene("slide-by-bell-crank"),
    "valve": find_scene("valve-with-rocker"),
    "groove": Scene.from_dict({**cam_with("groove"), "train": [LEVER], "outputs": []}),
    "arm in a groove": Scene.from_dict({**cam_with("groove-arm"), "train": [CRANK], "outputs": []}),
}


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("scene", TRAINS.values(), ids=TRAINS)
def test_the_svg_moves_the_links_of_a_train_as_tool_and_follower_move(scene):
    """From the numbers of the file: the slide goes as far as the tool, and the crank turns with the arm."""
    with new_figure(None, DISC_SIZE) as figure:
        stage = draw_animated_figure(figure, Picture(scene, resolve_design(scene)))
        root = ElementTree.fromstring(animated_svg(stage))
    groups = {group.get("id"): group for group in root.iter(f"{G}g")}
    places = range(3, len(stage.bodies) - 2 * len(SHOWN_PANELS))  # between cam and follower, and the cursors
    moved = [[*groups[f"body-{place}"].iter(f"{G}animateTransform")] for place in places]
    axes = stage.bodies[places[0]].axes
    points_per_mm = axes.get_position().width * DISC_SIZE[0] * 72 / np.ptp(axes.get_xlim())
    points = camopt.cam_points(scene, np.degrees(FRAME_ANGLES[:-1]))
    tool = np.append(points["tool_displacement_mm"], points["tool_displacement_mm"][0])
    shifted = [values_of(motion) for each in moved for motion in each if motion.get("type") == "translate"]
    gone = [np.hypot(*values.T) / points_per_mm for values in shifted]
    assert any(np.allclose(each, np.abs(tool - tool[0]), atol=2e-3) for each in gone)
    if scene.follower.motion == "oscillating":
        turned = [values_of(motion)[:, 0] for each in moved for motion in each if motion.get("type") == "rotate"]
        angle = np.append(points["displacement_deg"], points["displacement_deg"][0])
        assert any(np.allclose(each, angle - angle[0], atol=1e-3) for each in turned)
    assert any(len(each) == 2 for each in moved) == (scene.follower.motion == "oscillating")  # a coupler does both


@pytest.mark.parametrize("name", ["swinging sphere", "swinging groove"])
def test_the_texts_of_an_animation_are_apart_on_the_page_and_read_the_values(name):
    _, stage, root = animated_scene(name)
    assert faults_of(stage.figure) == []
    angle, height, *_ = [reading.values for reading in stage.readings]
    assert angle[25] == "cam angle 90.0°"
    assert [float(text) for text in height] == pytest.approx(displacement_of(SCENES[name]), abs=0.00501)
    (column,) = [group for group in root.iter(f"{G}g") if group.get("id") == "reading-1"]
    assert [text.text for text in column.iter(f"{G}text")] == height[:FRAMES]
    jumps = values_of(turning(name)["reading-1"])[:, 1]
    places = [float(text.get("y")) for text in column.iter(f"{G}text")]
    np.testing.assert_allclose(places + jumps, places[0], atol=1e-2)  # each is seen in its frame


@pytest.mark.slow
def test_the_command_writes_a_gif_whose_first_frame_is_the_picture_without_motion(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["evaluate", "two-pauses", "--plot", "turning.GIF", "--quiet"]) == 0
    (file,) = tmp_path.iterdir()
    assert file.stat().st_size < 2 << 20
    with Image.open(file) as image:
        assert (image.n_frames, image.size, image.info["loop"]) == (FRAMES, (900, 540), 0)
        assert image.info["duration"] == round(1000 * TURN_TIME / FRAMES)
        shown = []
        for frame in (0, 1, 50, FRAMES - 1):
            image.seek(frame)
            shown.append(np.asarray(image.convert("RGB"), float))
    with new_figure(None, DISC_SIZE) as figure:
        draw_animated_figure(figure, Picture(find_scene("two-pauses"), resolve_design(find_scene("two-pauses"))))
        figure.set_dpi(100)
        figure.canvas.draw()
        still = np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(float)
    assert np.abs(shown[0] - still).mean() < 1.0
    assert all(np.abs(before - after).max() > 100 for before, after in pairwise(shown))


@pytest.mark.slow
def test_any_name_stays_text():
    name = "<script>alert('$\\frac$')</script> & " * 9
    svg = animate(SCENES["roller"].replace(name=name)).svg
    assert "<script" not in svg
    texts = [text.text for text in ElementTree.fromstring(svg).iter(f"{G}text")]
    assert any(name.startswith(text.removesuffix("…")) for text in texts if text and "alert" in text)


@pytest.fixture
def grey(monkeypatch):
    """Frames that need no drawing: the GIF shows what is drawn."""
    image = np.full((540, 900, 3), 128, dtype=np.uint8)
    monkeypatch.setattr("camopt.show.drawing.frames.render_frames", lambda stage: repeat(image, FRAMES))


@pytest.mark.slow
@pytest.mark.usefixtures("grey")
def test_a_video_by_ffmpeg(tmp_path):
    write_mp4(animated_scene("roller")[1], tmp_path / "turning.mp4")
    assert (tmp_path / "turning.mp4").read_bytes()[4:8] == b"ftyp"
    command = [find_ffmpeg(), "-i", tmp_path / "turning.mp4", "-f", "null", "-"]
    found = subprocess.run(command, capture_output=True, check=True)
    assert re.search(rb"frame= *100\b", found.stderr)
    assert b"900x540" in found.stderr
    assert b"Duration: 00:00:04.00" in found.stderr


def test_without_ffmpeg_a_video_is_refused_with_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("shutil.which", lambda program: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.chdir(tmp_path)
    assert main(["evaluate", "two-pauses", "--plot", "a.mp4", "--points", "p.csv"]) == 2
    told = capsys.readouterr().err.splitlines()
    assert told == ['camopt: .mp4: needs ffmpeg: install it, or pip install "camopt[video]"']
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("grey")
def test_an_ffmpeg_that_fails_leaves_no_file_and_says_why(tmp_path, monkeypatch):
    broken = tmp_path / "ffmpeg"
    broken.write_text("#!/bin/sh\necho no such encoder >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setattr("shutil.which", lambda program: str(broken))
    with pytest.raises(OSError, match="no such encoder"):
        animate(SCENES["roller"], tmp_path / "a.mp4")
    assert [path.name for path in tmp_path.iterdir()] == ["ffmpeg"]


@pytest.mark.slow
def test_the_command_writes_the_same_animated_svg_as_python_beside_a_picture(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["evaluate", "two-pauses", "--plot", "still.pdf", "--animate", "turning.SVG"]) == 0
    assert capsys.readouterr().err.splitlines()[-2:] == ["wrote still.pdf", "wrote turning.SVG"]
    assert {file.name for file in tmp_path.iterdir()} == {"still.pdf", "turning.SVG"}
    svg = (tmp_path / "turning.SVG").read_text(encoding="utf-8")
    assert "<script" not in svg
    assert len(svg) < 1 << 19
    found = animate(find_scene("two-pauses"))
    assert found.svg == svg
    page = found._repr_html_()  # of a notebook
    assert b64decode(re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', page)[0]).decode() == svg


def test_another_ending_and_a_folder_that_is_not_there_are_refused(tmp_path):
    with pytest.raises(BadInput, match=r"path.*\.svg, \.gif or \.mp4"):
        animate(SCENES["roller"], tmp_path / "a.png")
    with pytest.raises(FileNotFoundError, match=r"a\.svg"):
        animate(SCENES["roller"], tmp_path / "none" / "a.svg")
    assert not list(tmp_path.iterdir())
