"""Profiles from drawings: camopt's own DXF files come back, those of others too, and bad ones are told."""

import re

import ezdxf
import numpy as np
import pytest
from support.cams import CONTACTS, cam_with
from support.curves import largest_distance, true_points

from camopt import BadInput, Scene, cam_points, export, find_scene, shipped_scenes
from camopt.model.motion.profile import ElementSpec, place_profile_elements
from camopt.scene.drawn_profile import profile_elements_of_outline
from camopt.scene.dxf import read_dxf_profile
from camopt.scene.problem.problem import resolve_design
from camopt.solve.contour.curve import disc_curves

CORNERED = ("uniform-knife-offset", "uniform-knife-radial")  # their profiles have corners
SHIPPED = [name for name in shipped_scenes() if find_scene(name).mechanism.body.bounded and name not in CORNERED]
SMALL = [contact for contact in CONTACTS if cam_with(contact)["cam"]["form"] == "disc"]
TURNED = [(name, rotation) for name in [*SHIPPED, *SMALL] for rotation in ("ccw", "cw")]


def scene_of(name):
    return find_scene(name) if name in SHIPPED else Scene.from_dict(cam_with(name))


def from_drawing(scene, file):
    """The cam of a drawing with the follower of a scene."""
    follower = scene.to_dict()["follower"]
    cam = {"form": "disc", "rotation": scene.cam.rotation}
    return Scene.from_dict({"name": "back", "cam": cam, "follower": follower, "profile": str(file)})


def profile_points(scene):
    problem = resolve_design(scene)
    return true_points(problem, disc_curves(problem)["profile"].distance, 16_001)


def points_of(elements, rotation):
    """Dense points on arcs and lines that are tangent to 1e-9, by ``parts_of``, in the plane of the drawing."""
    mirror = np.conjugate if rotation == "ccw" else np.asarray
    given = [
        ElementSpec(each.get("radius"), mirror(complex(each["x"], each["y"])).item() if "x" in each else None)
        for each in elements
    ]
    found = []
    for part in place_profile_elements(given):
        share = np.linspace(0.0, 1.0, 200 + int(6000 * abs(part.normal_sweep_angle)))
        if part.radius is None:
            found.append(part.start.point + (part.end.point - part.start.point) * share)
        else:
            found.append(
                part.centre + part.radius * part.start.normal * np.exp(1j * part.normal_sweep_angle * share)
            )
    return mirror(np.concatenate(found))


@pytest.mark.one_in(13)
@pytest.mark.parametrize(("name", "rotation"), TURNED)
def test_a_profile_comes_back_from_its_drawing(tmp_path, name, rotation):
    scene = scene_of(name).replace(**{"cam.rotation": rotation})
    found = export(scene, tmp_path / "cam.dxf")
    elements = profile_elements_of_outline(read_dxf_profile(tmp_path / "cam.dxf"), rotation == "cw")
    there, here = profile_points(scene), points_of(elements, rotation)
    allowed = found.curves["profile"].deviation_mm + 2e-5
    assert max(largest_distance(here, there), largest_distance(there, here)) <= allowed
    if scene.profile:
        assert len(elements) == len(scene.profile)


def test_a_cam_from_its_drawing_moves_its_follower_so(tmp_path):
    scene = find_scene("flat-reciprocating")
    export(scene, tmp_path / "cam.dxf", chord=1e-3)
    back = from_drawing(scene, tmp_path / "cam.dxf")
    angles = np.arange(0.0, 360.0, 0.5)
    here, there = (cam_points(each, angles)["displacement_mm"] for each in (back, scene))
    assert np.abs(here - there).max() <= 1e-3
    assert Scene.from_dict(back.to_dict()) == back


def test_there_are_forty_profiles():
    assert len(TURNED) >= 40


THREE_ARC = find_scene("three-arc-valve")


def save_drawing(file, make, unit=4):
    document = ezdxf.new("R2010", units=unit)
    make(document.modelspace())
    document.saveas(file)


def loose(file, digits):
    """The profile of the three-arc cam as arcs in any order, either way, in some digits, beside other lines."""
    export(THREE_ARC.replace(part={"thickness": 5, "bore": 10}), file)
    (profile,) = ezdxf.readfile(file).modelspace().query('LWPOLYLINE[layer=="PROFILE"]')
    arcs = [(each.dxf.center, each.dxf.radius, each.dxf.start_angle, each.dxf.end_angle)
            for each in profile.virtual_entities()]  # fmt: skip

    def make(space):
        for centre, radius, start, end in arcs[::-1]:
            space.add_arc((round(centre.x, digits), round(centre.y, digits)), round(radius, digits), start, end)
        space.add_circle((0, 0), 5)
        space.add_line((-80, 0), (80, 0))
        space.add_text("cam")

    return make


@pytest.mark.parametrize(("digits", "near"), [(12, 1e-9), (6, 2e-6), (4, 2e-4)])
def test_loose_arcs_are_joined_and_made_tangent(tmp_path, digits, near):
    file = tmp_path / "loose.dxf"
    save_drawing(file, loose(tmp_path / "own.dxf", digits))
    elements = profile_elements_of_outline(read_dxf_profile(file), clockwise=False)
    assert len(elements) == 4
    there, here = profile_points(THREE_ARC), points_of(elements, "ccw")
    assert max(largest_distance(here, there), largest_distance(there, here)) <= near + 3e-5


def test_a_drawing_in_inches_is_as_large(tmp_path):
    save_drawing(tmp_path / "inch.dxf", lambda space: space.add_circle((0.25, 0), 1.0), unit=1)
    (only,) = from_drawing(find_scene("eccentric-rocker"), tmp_path / "inch.dxf").profile
    assert (only.radius, only.x, only.y) == pytest.approx((25.4, 6.35, 0.0))


BAD = {
    "corner": (lambda space: space.add_lwpolyline([(-9, -9), (9, -9), (9, 9)], close=True), "a corner of 135° at"),
    "open": (
        lambda space: space.add_arc((0, 0), 5, 0, 350),
        "it has no closed outline of arcs, lines or polylines",
    ),
    "spline": (lambda space: space.add_spline([(1, 0), (0, 1), (-1, 0)]), "polylines; it has SPLINE"),
    "concentric": (
        lambda space: space.add_circle((0, 0), 5),
        "a circle about the cam's axis does not move the follower",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_drawing_without_a_profile_is_told(tmp_path, name):
    make, message = BAD[name]
    save_drawing(tmp_path / "bad.dxf", make)
    with pytest.raises(BadInput, match=re.escape(message)) as error:
        from_drawing(THREE_ARC, tmp_path / "bad.dxf")
    assert len(error.value.mistakes) == 1


def nest_blocks(levels, insert, inside):
    """Blocks, each of which inserts the next by ``insert``; the last one has what ``inside`` draws."""

    def make(space):
        blocks = [space.doc.blocks.new(f"B{k}") for k in range(levels)]
        for k, block in enumerate(blocks[:-1]):
            insert(block, f"B{k + 1}")
        inside(blocks[-1])
        space.add_blockref("B0", (0, 0))

    return make


def draw_nothing(block):
    pass


def circle(block):
    block.add_circle((1, 0), 5)


def copies(count, step=1, **attributes):
    return lambda block, name: [block.add_blockref(name, (step * k, 0), attributes) for k in range(count)]


def arrays(rows):
    return lambda block, name: block.add_blockref(name, (0, 0)).grid((rows, rows), (1, 1))


def wave(space):
    angles = np.linspace(0.0, 2.0 * np.pi, 2003)
    radii = 30.0 + np.cos(angles)
    space.add_lwpolyline(np.column_stack([radii * np.cos(angles), radii * np.sin(angles)]))


FLAT_FOLLOWER = '[cam]\nform = "disc"\n[follower]\nmotion = "translating"\ncontact = "flat"\n'
MANY = "it has more than 100,000 entities and vertices, counting inserted blocks"
ENDLESS = {
    "circles": (nest_blocks(20, copies(8), circle), MANY),
    "empty": (nest_blocks(20, copies(8), draw_nothing), MANY),
    "oblique": (nest_blocks(20, copies(8, rotation=30, xscale=2), draw_nothing), MANY),
    "array": (nest_blocks(2, arrays(30_000), draw_nothing), MANY),
    "vertices": (nest_blocks(2, arrays(10), wave), MANY),
    "itself": (
        nest_blocks(3, copies(1), lambda block: block.add_blockref("B1", (0, 0))),
        'its block "B1" contains itself',
    ),
    "deep": (nest_blocks(1500, copies(1), circle), "its blocks are nested too deep"),
    "star": (
        nest_blocks(3, copies(60, step=0), lambda block: block.add_line((0, 0), (1, 0))),
        "3,600 of its arcs and lines end at the same point",
    ),
    "wave": (wave, "its profile has 2,002 arcs and lines; at most 1,000 are allowed"),
}


@pytest.mark.parametrize("name", ENDLESS)
def test_a_drawing_without_end_is_refused(tmp_path, command, name):
    """Drawings of some kilobytes that would take hours, or all memory: exit code 2, one line."""
    make, message = ENDLESS[name]
    save_drawing(tmp_path / "bad.dxf", make)
    (tmp_path / "own.toml").write_text(f'profile = "bad.dxf"\n{FLAT_FOLLOWER}')
    code, printed, told = command("evaluate", "own.toml")
    assert (code, printed, told.count("\n")) == (2, "", 1)
    assert f"profile = 'bad.dxf': must be a DXF file with the profile, or its [[profile]]: {message}" in told


def test_a_profile_in_nested_blocks_comes_back(tmp_path):
    """As it is drawn, and where the blocks about it hold 4,096 marks."""
    document = ezdxf.new("R2010", units=4)
    nest_blocks(5, copies(8), lambda block: block.add_point((60, 0)))(document.modelspace())
    profile = document.blocks.new("PROFILE")
    profile.add_circle((5, 0), 30)
    document.modelspace().add_blockref("PROFILE", (0, 0))
    document.saveas(tmp_path / "blocks.dxf")
    (only,) = from_drawing(find_scene("eccentric-rocker"), tmp_path / "blocks.dxf").profile
    assert (only.radius, only.x, only.y) == pytest.approx((30.0, 5.0, 0.0))


def test_no_drawing_and_none_that_is_there(tmp_path):
    (tmp_path / "text.dxf").write_text("no drawing")
    (tmp_path / "folder.dxf").mkdir()
    known = {"text.dxf": "not a DXF file", "none.dxf": "No such file", "folder.dxf": "it must be a regular file"}
    for name, message in known.items():
        with pytest.raises(BadInput, match=message):
            from_drawing(THREE_ARC, tmp_path / name)


def test_a_scene_file_names_its_drawing_beside_it(tmp_path):
    export(THREE_ARC, tmp_path / "cam.dxf")
    (tmp_path / "own.toml").write_text(f'profile = "cam.dxf"\n{FLAT_FOLLOWER}')
    assert len(Scene.from_toml(tmp_path / "own.toml").profile) == 4
