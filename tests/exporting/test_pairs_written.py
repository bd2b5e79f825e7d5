"""Files of pairs of discs read back: both discs in one frame, and what has one disc refuses."""

import ezdxf
import numpy as np
import pytest
from support.pairs import nearest, pair, profiles

from camopt import BadInput, Scene, cam_points, evaluate, export, find_scene
from camopt.contour.curve import discs_of
from camopt.effects import Case
from camopt.problem.problem import resolve_design
from camopt.verdicts.running import run_effects

RNG_SEED = 12


@pytest.fixture(params=["translating", "oscillating"])
def scene(request):
    return Scene.from_dict(pair(np.random.default_rng(RNG_SEED), request.param))


def test_both_discs_of_a_drawing_are_in_one_frame(scene, tmp_path):
    found = export(scene, tmp_path / "pair.dxf")
    assert {"profile", "second_profile"} <= found.curves.keys()
    problem, space = resolve_design(scene), ezdxf.readfile(tmp_path / "pair.dxf").modelspace()
    every = np.linspace(0.0, 2.0 * np.pi, 20001)
    for layer, drawn in zip(("PROFILE", "SECOND_PROFILE"), profiles(problem, every), strict=True):
        (line,) = space.query(f'LWPOLYLINE[layer=="{layer}"]')
        corners = np.array([complex(x, y) for x, y in line.get_points("xy")])
        assert np.abs(corners[:, None] - drawn).min(axis=1).max() < 0.02  # of points 0.02 mm from each other


def test_points_of_the_second_disc_are_a_roller_radius_from_its_pitch_curve(scene):
    """Along the normal out of the steel; and they are where the roller of the rigid follower is."""
    problem, points = resolve_design(scene), cam_points(scene, np.arange(0.0, 360.0, 7.0))
    radius = float(problem.setup.mechanism.further[0].seen(problem.design).roller_radius[0])

    def curve(name):
        return points[f"second_{name}_x"] + 1j * points[f"second_{name}_y"]

    pitch, profile = (points[f"second_{n}_x_mm"] + 1j * points[f"second_{n}_y_mm"] for n in ("pitch", "profile"))
    assert np.abs(profile + radius * curve("profile_normal") - pitch).max() < 1e-9
    touched, _ = nearest(problem, 1, np.radians(points["cam_angle_deg"]))
    turned = touched * np.exp(-1j * problem.design.sense * np.radians(points["cam_angle_deg"]))
    assert np.abs(turned - profile).max() < 1e-6
    assert (points["second_profile_curvature_per_mm"] > -1.0).all()


def test_each_disc_is_an_ordinary_cam_with_the_quantities_of_its_contact(scene):
    problem, names = resolve_design(scene), ("pressure_angle_max_deg", "profile_radius_min_mm", "outer_radius_mm")
    found = evaluate(scene.replace(outputs=["all"]))
    for place, disc in zip(("first", "second"), discs_of(problem), strict=True):
        alone = run_effects(Case(disc.problem.setup, disc.problem.programme, disc.problem.design), names)
        for name in names:
            assert alone.column(name)[0] == pytest.approx(found[f"{place}_{name}"], rel=1e-8)


def test_a_file_of_one_disc_refuses_a_pair(tmp_path):
    scene = find_scene("press-feed-by-pair")
    with pytest.raises(
        BadInput, match=r"a \.pdf file is of one disc, and a conjugate pair has two; both are in \.dxf"
    ):
        export(scene, tmp_path / "pair.pdf")
    export(find_scene("pump-of-constant-breadth"), tmp_path / "pump.pdf")
    assert (tmp_path / "pump.pdf").exists()
