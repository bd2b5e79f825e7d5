"""Other names of laws: each leads to one law, wherever a scene names one."""

import pytest

import camopt
from camopt.motion.aliases import ALIASES, NAMES, law_named


def test_each_name_is_of_one_law_and_of_none_that_is_built_in():
    assert {*ALIASES} <= {*camopt.LAWS}
    assert len(NAMES) == sum(map(len, ALIASES.values()))
    assert not {*NAMES} & {*camopt.LAWS}


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
        ("cycloidl", "cycloidl"),
    ],
)
def test_names_as_people_write_them(name, law):
    assert law_named(name) == law


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
