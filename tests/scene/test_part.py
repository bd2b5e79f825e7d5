"""The cam as a part: what [part] takes, what it leaves to other tables, and its mistakes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.cams import cam_with

from camopt import BadInput, Scene, cam_points, find_scene, shipped_scenes
from camopt.scene.fits import KEYWAYS
from camopt.scene.materials import MATERIALS
from camopt.scene.part import Part
from camopt.scene.unusual_values import unusual_value_notes

PLATE = {"thickness": 16, "hub_diameter": 44, "hub_length": 32, "keyway_width": 8, "keyway_depth": 3.3}
CYLINDER = {"thickness": 100, "bore": 60, "keyway_width": 18, "keyway_depth": 4.4, "groove_depth": 16}
HUBLESS = {"part.hub_diameter": None, "part.hub_length": None}
SHAFTLESS = {"cam.shaft_diameter": None}
BASES = {
    "disc": find_scene("valve-rod-radial").replace(part=PLATE),  # base radius 25, shaft 25
    "cylinder": find_scene("feeder-with-stop").replace(
        part=CYLINDER
    ),  # mean radius 100, highest at 65.2433, roller 9
    "pair": find_scene("press-feed-by-pair").replace(
        part={"thickness": 16, "hub_diameter": 80, "hub_length": 50}, **{"materials.face_width": 16}
    ),  # base radius 62, shaft 50
}
BLANK = BASES["disc"].replace(**SHAFTLESS, part=None)
ONE_MISTAKE = [
    ("disc", {"part": 5}, "part = 5: must be a table"),
    ("disc", {"part.thicknes": 5}, "part.thicknes = 5: not a known key; did you mean thickness?"),
    ("disc", {"part.thickness": "16"}, "part.thickness = '16': must be a number"),
    ("disc", {"part.thickness": -1}, "part.thickness = -1: must be at least 1e-09"),
    ("disc", {"part.keyway_angle": 400}, "part.keyway_angle = 400: must be at most 360"),
    ("disc", {"part.density": 0}, "part.density = 0: must be at least 1e-15"),
    ("disc", {"part.material": 1.4310}, "part.material = 1.431: must be a text, in quotes"),
    ("disc", {"part.number": True}, "part.number = True: must be a text"),
    ("disc", {"part.designer": 5}, "part.designer = 5: must be a text"),
    ("disc", {"part.name": "a\nb"}, r"part.name = 'a\nb': must be a text of one line"),
    ("disc", {"part.groove_depth": 5}, "part.groove_depth = 5: a disc cam has none"),
    ("cylinder", {"part.hub_length": 50}, "part.hub_length = 50: a cylindrical cam has none"),
    ("disc", {"part.keyway_depth": None}, "part.keyway_depth: missing; the keyway of part.keyway_width needs it"),
    ("disc", {"part.keyway_width": None}, "part.keyway_width: missing; the keyway of part.keyway_depth needs it"),
    ("disc", {"cam.shaft_diameter": None}, "part.bore: missing; a keyway needs it, or cam.shaft_diameter"),
    ("disc", {"part.keyway_width": 25}, "part.keyway_width = 25.0: must be below the diameter of the bore (25)"),
    ("disc", {"part.hub_diameter": None}, "part.hub_diameter: missing; part.hub_length describes a hub,"),
    ("disc", {"part.hub_length": None}, "part.hub_length: missing; part.hub_diameter describes a hub, which"),
    ("disc", {"part.thickness": None}, "part.thickness: missing; part.hub_diameter describes a hub, which"),
    ("disc", {"part.hub_length": 15}, "part.hub_length = 15.0: must be at least the thickness (16), which it inc"),
    ("disc", {"part.hub_diameter": 32}, "part.hub_diameter = 32.0: must be above 32.5969: the bore and its keyway"),
    ("disc", {"part.hub_diameter": 50.1}, "part.hub_diameter = 50.1: must be at most twice the base radius (50)"),
    ("disc", {"part.bore": 20}, "part.bore = 20.0: must equal cam.shaft_diameter (25); or leave one of"),
    ("disc", {"part.bore": "30 H7"}, "part.bore = 30.0: must equal cam.shaft_diameter (25); or leave one of"),
    ("disc", {"part.bore": 50, **SHAFTLESS, **HUBLESS}, "part.bore = 50.0: must leave a wall"),
    ("disc", {"part.bore": 50, **SHAFTLESS, "part.hub_diameter": 60}, "part.bore = 50.0: must leave a wall"),
    (
        "disc",
        {"part.keyway_depth": 12.5, **HUBLESS},
        "part.keyway_depth = 12.5: must leave a wall to the base circle (radius 25)",
    ),
    ("disc", {"part.disc_gap": 5}, "part.disc_gap = 5: only a conjugate pair has a gap; this cam has one"),
    ("pair", {"part.hub_length": 35.9}, "part.hub_length = 35.9: must be at least two thicknesses and the gap"),
    ("pair", {"part.disc_gap": 19}, "part.hub_length = 50.0: must be at least two thicknesses and the gap (51)"),
    ("pair", {"drive.base_radius": 39}, "part.hub_diameter = 80.0: must be at most twice the base radius (78)"),
    ("cylinder", {"part.bore": 184}, "part.bore = 184.0: must leave a wall to the bottom of the groove (radi"),
    ("cylinder", {"part.groove_depth": 130}, "part.keyway_depth = 4.4: must leave a wall to the bottom of the gro"),
    ("cylinder", {"part.groove_depth": 200}, "part.groove_depth = 200.0: must be below twice the mean radius (200"),
    ("cylinder", {"part.thickness": 83}, "part.thickness = 83.0: must be above 83.2433, the length of the groove"),
]  # fmt: skip


KEYS = {
    2: (2, 1.2), 3: (3, 1.8), 4: (4, 2.5), 5: (5, 3.0), 6: (6, 3.5), 8: (7, 4.0), 10: (8, 5.0), 12: (8, 5.0),
    14: (9, 5.5), 16: (10, 6.0), 18: (11, 7.0), 20: (12, 7.5), 22: (14, 9.0), 25: (14, 9.0), 28: (16, 10.0),
    32: (18, 11.0), 36: (20, 12.0), 40: (22, 13.0), 45: (25, 15.0), 50: (28, 17.0), 56: (32, 20.0), 63: (32, 20.0),
    70: (36, 22.0), 80: (40, 25.0), 90: (45, 28.0), 100: (50, 31.0),
}  # fmt: skip
"""By the width of a parallel key: its height, and the depth of its keyway in the shaft (t₁), mm; DIN 6885-1."""


def test_a_standard_keyway_leaves_some_tenths_above_its_key():
    assert [width for width, _ in KEYWAYS.values()] == [*KEYS]
    for width, depth in KEYWAYS.values():
        height, in_shaft = KEYS[width]
        assert round(in_shaft + depth - height, 9) in (0.2, 0.3, 0.4)
        assert 3.0 <= max(bore for bore, (each, _) in KEYWAYS.items() if each == width) / width <= 5.0


@pytest.mark.parametrize(
    ("bore", "keyway"), [(20, (6, 2.8)), (22, (6, 2.8)), (22.1, (8, 3.3)), ("30 H7", (8, 3.3))]
)
def test_short_forms_of_the_hole(bore, keyway):
    scene = BLANK.replace(part={"thickness": 16, "bore": bore, "keyway": "DIN 6885"})
    part = scene.part
    assert (part.keyway_width, part.keyway_depth, part.keyway_fit) == (*keyway, "JS9")
    assert (part.bore, part.bore_fit) == ((30.0, "H7") if isinstance(bore, str) else (bore, None))
    assert Scene.from_dict(scene.to_dict()) == scene
    assert scene.replace(**{"part.bore": 25}).part.keyway_width == keyway[0]


@pytest.mark.parametrize(
    ("bore", "size", "fit", "width"),
    [
        ("38.1 mm", 38.1, None, 12),
        ("1.5 in", 38.1, None, 12),
        ("1.5 in H7", 38.1, "H7", 12),
        ("40 mm H7", 40.0, "H7", 12),
        ("4cmH8", 40.0, "H8", 12),
    ],
)
def test_a_bore_has_a_unit_a_fit_and_a_standard_keyway(bore, size, fit, width):
    part = BLANK.replace(part={"thickness": 16, "bore": bore, "keyway": "DIN 6885"}).part
    assert (part.bore, part.bore_fit, part.keyway_width) == (size, fit, width)


SHORT_MISTAKES = [
    (
        {"bore": "1.5 kg H7", "keyway": "DIN 6885"},
        "part.bore = '1.5 kg': must be a number in mm, or a text with a unit",
    ),
    ({"bore": "30 h"}, "part.bore = '30 h': must be a number"),
    ({"bore": 20, "bore_fit": "h"}, "part.bore_fit = 'h': must be a fit of ISO 286, such as H7"),
    ({"bore": 20, "keyway": "DIN 6886"}, "part.keyway = 'DIN 6886': must be one of 'DIN 6885'"),
    (
        {"bore": 20, "keyway": "DIN 6885", "keyway_width": 5},
        "part.keyway_width = 5: part.keyway = 'DIN",
    ),
    ({"bore": 5, "keyway": "DIN 6885"}, "part.keyway = 'DIN 6885': needs a bore above 6 mm, at most 500 mm"),
    ({"edges": [0.1]}, "part.edges = [0.1]: must be two numbers"),
    ({"language": "fr"}, "part.language = 'fr': must be "),
]


@pytest.mark.parametrize(("part", "line"), SHORT_MISTAKES)
def test_a_short_form_that_is_none_is_told(part, line):
    with pytest.raises(BadInput) as error:
        BLANK.replace(part=part)
    (found,) = str(error.value).splitlines()
    assert line in found


@pytest.mark.parametrize(("base", "changes", "line"), ONE_MISTAKE)
def test_a_part_that_cannot_be_is_told_in_one_line(base, changes, line):
    with pytest.raises(BadInput) as error:
        BASES[base].replace(**changes)
    (found,) = str(error.value).splitlines()
    assert found.partition(": ")[2].startswith(line)


@pytest.mark.parametrize(("base", "changes", "_"), ONE_MISTAKE[9:])
def test_what_a_check_is_about_is_allowed_up_to_there(base, changes, _):
    """The sizes that are too large or too small by a share of the gap: halfway back they are a part."""
    sizes = {key: value for key, value in changes.items() if isinstance(value, (int, float))}
    own = {f"part.{key}": value for key, value in (PLATE if base == "disc" else CYLINDER).items()}
    halfway = {key: (value + own[key]) / 2 for key, value in sizes.items() if key in own}
    wide = halfway.get("part.hub_diameter", 0.0) > 50.0  # the base circle
    if "part.keyway_width" not in sizes and not wide:  # a key as wide as half the bore is deep too
        assert BASES[base].replace(**halfway).part


@given(
    st.sampled_from(sorted(BASES)),
    st.dictionaries(
        st.sampled_from([*Part.model_fields, "hub"]),
        st.floats() | st.floats(0, 200) | st.text(max_size=5) | st.none() | st.just([]) | st.booleans(),
        max_size=8,
    ),
)
def test_whatever_is_given_makes_a_part_or_one_mistake_a_key(base, table):
    data = BASES[base].to_dict() | {"part": table}
    keys, scene = [], None
    try:
        scene = Scene.from_dict(data)
    except BadInput as error:
        keys = [mistake.key for mistake in error.mistakes]
    assert len(keys) == len({*keys})
    if scene:
        assert Scene.from_dict(scene.to_dict()) == scene
        assert scene.whole_part.bore_reach < (25.0 if base == "disc" else 100.0)


@pytest.mark.parametrize("contact", ["groove", "groove-arm"])
def test_a_wall_beside_a_groove_that_is_thin_is_told(contact):
    """Thinner than half of the groove's depth; how far the groove runs is by the points of the roller's centre."""
    scene = Scene.from_dict(cam_with(contact, "poly345"))
    heights = cam_points(scene)["pitch_y_mm"]
    run = heights.max() - heights.min() + 2 * scene.follower.roller_radius
    scene = scene.replace(**{"materials.face_width": 12})
    short, long = (scene.replace(part={"groove_depth": 12, "thickness": run + 2 * wall}) for wall in (5.97, 6.03))
    (told,) = unusual_value_notes(short)
    assert unusual_value_notes(long) == []
    assert told.startswith("part.thickness: a wall of 5.97 mm is left beside the groove")
    assert "0.5 times the groove's depth (12 mm)" in told


def test_a_part_says_what_other_tables_say():
    bare = find_scene("two-pauses").replace(
        **{"materials.cam": "bronze", "part.keyway_width": 8, "part.keyway_depth": 3}
    )
    part = bare.whole_part
    assert (part.bore, part.density, part.material, part.name) == (40.0, 8150.0, "bronze", bare.name)
    assert part.keyway_angle == 90.0
    assert part.bore_reach == pytest.approx((23.0**2 + 4.0**2) ** 0.5, rel=1e-15)
    own = {"bore": 40, "density": 8800, "material": "CuSn12", "name": "Cam", "keyway_angle": 0}
    said = bare.replace(**{f"part.{key}": value for key, value in own.items()}).whole_part
    assert {key: getattr(said, key) for key in own} == own
    knife = find_scene("knife-300rpm-radial").whole_part
    assert (knife.bore, knife.density, knife.keyway_angle, knife.bore_reach) == (None, None, None, 0.0)


@pytest.mark.parametrize("key", ["material", "number", "revision"])
def test_a_whole_number_is_a_text_where_people_number_things(key):
    """A steel, a drawing and a revision have numbers. A number with a point is no text: 1.4310 loses its end."""
    scene = BASES["disc"].replace(**{f"part.{key}": 4140})
    assert getattr(scene.part, key) == "4140"
    assert scene.to_dict()["part"][key] == "4140"


def test_a_part_is_read_and_written():
    for base in BASES.values():
        assert Scene.from_dict(base.to_dict()) == base
        assert unusual_value_notes(base) == []
    told = BASES["disc"].replace(**{"part.density": 7.8})
    assert [line.partition(" = ")[0] for line in unusual_value_notes(told)] == ["part.density"]
    for name in ("press-feed-by-pair", "barrel-traverse", "bottle-filler-by-rib"):
        scene = find_scene(name)
        key = scene.mechanism.body.flank_height or "thickness"
        (wide,) = unusual_value_notes(scene.replace(**{"materials.face_width": 4 * getattr(scene.part, key)}))
        assert f"wider than part.{key} (" in wide
        assert wide.endswith(" carries, the contact stress is 2 times the computed one")
    feed = find_scene("press-feed-by-pair")
    for table, words in ("follower", "the roller covers"), ("drive", "the roller of the second disc covers"):
        (told,) = unusual_value_notes(feed.replace(**{"drive.roller_radius": 16, f"{table}.roller_radius": 112}))
        assert told.startswith(f"{table}.roller_radius = 112 mm: {words} the pivot of its arm")
    assert [name for name in shipped_scenes() if "thickness" in find_scene(name).to_dict().get("part", {})]


@pytest.mark.parametrize(
    ("name", "unit_weight"),
    [("steel", 76.5), ("stainless-steel", 76.0), ("grey-cast-iron", 70.6), ("bronze", 80.1)],
)
def test_densities_are_those_of_the_unit_weights_of_shigley(name, unit_weight):
    """Table A-5 of Shigley has kN/m³ (carbon steel, stainless, grey cast iron, phosphor bronze)."""
    assert MATERIALS[name].density == pytest.approx(unit_weight * 1e3 / 9.81, abs=25.0)


def test_plates_of_a_pair_are_a_gap_apart_the_first_in_front():
    part = BASES["pair"].whole_part
    assert (part.plate_extents, part.width, part.has_protruding_hub) == (((20.0, 36.0), (0.0, 16.0)), 36.0, True)
    wide = BASES["pair"].replace(**{"part.disc_gap": 7.5, "part.hub_length": 39.5}).whole_part
    assert (wide.plate_extents, wide.has_protruding_hub) == (((23.5, 39.5), (0.0, 16.0)), False)
    assert (BASES["disc"].whole_part.plate_extents, Part().plate_extents) == (((0.0, 16.0),), ())


@pytest.mark.parametrize("key", ["cam.base_radius", "drive.base_radius"])
def test_a_disc_of_a_pair_without_a_wall_about_the_shaft_is_told(key):
    pair = find_scene("press-feed-by-pair").replace(part=None, **{"follower.centre_distance": 130})
    told = "the wall between bore and base circle is 0 mm"
    for base, expected in ((25.0, True), (26.0, False)):
        found = unusual_value_notes(pair.replace(**{"drive.base_radius": 62, key: base}))
        assert any(each.startswith(told) for each in found) == expected
