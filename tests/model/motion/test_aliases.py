"""Other names of laws: each is accepted for its law wherever a scene names a law."""

from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

import camopt
from camopt.model.motion.aliases import ALIASES, SEGMENT_ALIASES, canonical_law_name, canonical_segment_kind


def test_each_name_is_of_one_law_and_of_none_that_is_built_in():
    assert {*ALIASES} <= {*camopt.LAWS}
    assert all(canonical_law_name(name) == law for law in camopt.LAWS for name in (law, *ALIASES.get(law, ())))
    assert all(
        canonical_segment_kind(name) == kind for kind, names in SEGMENT_ALIASES.items() for name in (kind, *names)
    )


@pytest.mark.parametrize(
    ("name", "law"),
    [
        ("Bestehorn-Sinoide", "cycloidal"),
        ("Polynom 5. Grades", "poly345"),
        ("modifizierte Sinoide", "modified-sine"),
        ("modifiziertes Beschleunigungstrapez", "modified-trapezoid"),
        ("Quadratische Parabel", "parabolic"),
        ("einfache Sinoide", "harmonic"),
        ("Modified Sine", "modified-sine"),
        ("modified_sine", "modified-sine"),
        ("Poly 345", "poly345"),
        ("cycloidl", "cycloidl"),
        # as lectures and textbooks write
        ("uniform", "uniform"),
        ("Uniform Velocity", "uniform"),
        ("constant velocity", "uniform"),
        ("SHM", "harmonic"),
        ("S.H.M.", "harmonic"),
        ("simple_harmonic_motion", "harmonic"),
        ("Simple Harmonic", "harmonic"),
        ("uniform acceleration", "parabolic"),
        ("uniform acceleration & retardation", "parabolic"),
        ("uniform acceleration and uniform retardation", "parabolic"),
        ("UNIFORM-ACCELERATION-AND-DECELERATION", "parabolic"),
        ("uniform and equal acceleration and retardation", "parabolic"),
        ("equal uniform acceleration and retardation", "parabolic"),
        ("constant acceleration", "parabolic"),
        ("parabola", "parabolic"),
        ("Parabolic motion", "parabolic"),
        ("cycloidal motion", "cycloidal"),
        ("Cycloid", "cycloidal"),
    ],
)
def test_names_as_people_write_them(name, law):
    assert canonical_law_name(name) == law


@given(st.sampled_from([*camopt.LAWS, *chain(*ALIASES.values())]), st.randoms(use_true_random=False))
def test_case_spaces_hyphens_and_underscores_make_no_difference(name, random):
    between = {"-": ["-", " ", "_", "  "], " ": [" ", "-", "_"]}
    written = "".join(random.choice(between.get(c, [c.lower(), c.upper()])) for c in name)
    assert canonical_law_name(written) == canonical_law_name(name) in camopt.LAWS


@pytest.mark.parametrize(
    ("name", "law"),
    [
        ("uniform aceleration", "parabolic"),
        ("unifrom velocity", "uniform"),
        ("simple harmonic moton", "harmonic"),
        ("cycloydal", "cycloidal"),
    ],
)
def test_a_misspelt_name_of_a_classroom_is_told_the_law_that_has_it(name, law):
    with pytest.raises(camopt.BadInput, match=f"did you mean {law}[?]"):
        camopt.find_scene("two-pauses").replace(**{"motion.1.law": name})


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("outstroke", "rise"),
        ("Out Stroke", "rise"),
        ("outward stroke", "rise"),
        ("ascent", "rise"),
        ("Return stroke", "return"),
        ("inward-stroke", "return"),
        ("descent", "return"),
        ("fall", "return"),
        ("Rest", "dwell"),
        ("DWELL PERIOD", "dwell"),
        ("Constant Velocity", "constant-velocity"),
        ("Move", "move"),
    ],
)
def test_segments_have_the_names_of_a_classroom_too(name, kind):
    plain = "two-pauses" if kind in ("rise", "dwell", "return") else "belt-matching"
    data = camopt.find_scene(plain).to_dict()
    want = camopt.Scene.from_dict(data)
    rows = [row for row in data["motion"] if row["segment"] == kind]
    assert rows
    for row in rows:
        row["segment"] = name
    assert camopt.Scene.from_dict(data) == want
    assert camopt.scene.tables.Segment(segment=name, angle=30).segment == kind


def test_a_turn_as_a_lecture_writes_it_gives_the_same_cam():
    """Results show the names that camopt uses."""
    scene = camopt.find_scene("two-pauses").to_dict()
    lecture = {"rise": ("outstroke", "SHM"), "return": ("fall", "uniform acceleration"), "dwell": ("rest", None)}
    plain = {"rise": ("rise", "harmonic"), "return": ("return", "parabolic"), "dwell": ("dwell", None)}
    turns = [
        [{**row, "segment": names[row["segment"]][0], "law": names[row["segment"]][1]} for row in scene["motion"]]
        for names in (lecture, plain)
    ]
    rows = [[{k: v for k, v in row.items() if v is not None} for row in turn] for turn in turns]
    one, other = (camopt.Scene.from_dict({**scene, "motion": turn}) for turn in rows)
    assert one == other
    assert one.to_toml() == other.to_toml()
    assert camopt.evaluate(one)["law_rise"] == "harmonic"


def test_a_scene_takes_them_wherever_it_names_a_law():
    scene = camopt.find_scene("two-pauses")
    changes = {"motion.1.law": "Bestehorn-Sinoide", "search.law": ["Polynom 5. Grades", "harmonic"]}
    changes |= {"synthesis.peak_jerk": "modifizierte Sinoide", "laws.mine": {"law": "Gerade", "crossing": 0.4}}
    changed = scene.replace(**{**changes, "laws.mine": {"law": "Bestehorn-Sinoide", "crossing": 0.4}})
    assert changed.motion[0].law == changed.laws["mine"].law == "cycloidal"
    assert changed.search.law == ("poly345", "harmonic")
    assert changed.synthesis.peak_jerk == "modified-sine"
    own = scene.replace(**{"laws.gerade": {"scca": [0.25, 0.5, 0.25]}, "motion.1.law": "gerade"})
    assert own.motion[0].law == "gerade"
