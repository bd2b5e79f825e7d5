"""Outlines: distances by shapely, and chords that cover them."""

import numpy as np
import pytest
from support.machines import random_outline, shapely_distances

from camopt.scene.machine import Body, Station
from camopt.solve.machine.outlines import MovingOutline, offsets_from_segments, outline_distances


def random_table(rng, centre):
    """A fixed body, or a station whose tool slides or turns."""
    shape = {
        "name": "a",
        "outline": random_outline(rng, centre, 9),
        "outline_radius": float(rng.choice([0.0, 1.5])),
    }
    ways = [
        None,
        {"direction": float(rng.uniform(-180.0, 180.0))},
        {"pivot": list(rng.uniform(-50.0, 50.0, 2)), "sense": str(rng.choice(["ccw", "cw"]))},
    ]
    way = ways[rng.integers(3)]
    return Body(**shape) if way is None else Station(scene="two-pauses", **shape, **way)


@pytest.mark.parametrize("seed", range(3))
def test_distances_agree_with_shapely(seed):
    rng, zeros = np.random.default_rng(seed), 0
    for _ in range(60):
        tables = [random_table(rng, 0.0), random_table(rng, rng.uniform(0.0, 30.0))]
        lifts = rng.uniform(0.0, 30.0, (2, 50))
        found = outline_distances(*(MovingOutline.from_table(each) for each in tables), *lifts)
        true = shapely_distances(*tables, *lifts)
        assert np.abs(found - true).max() < 1e-12 * 100.0
        zeros += np.count_nonzero(true == 0.0)
    assert 300 < zeros < 8000


@pytest.mark.parametrize("seed", range(3))
def test_chords_cover_the_outline_and_halves_cover_less(seed):
    rng = np.random.default_rng(seed)
    outline = MovingOutline.from_table(
        Station(name="a", scene="x", direction=0, outline=random_outline(rng, 0.0, 40))
    )
    tree = outline.chord_tree
    corners = tree.start[(tree.children[:, 0] == np.arange(len(tree.cover)))]
    assert sorted(corners.tolist(), key=abs) == sorted(outline.points.tolist(), key=abs)
    for chord, children in enumerate(tree.children):
        if children[0] != chord:
            assert tree.start[children[0]] == tree.start[chord]
            assert tree.end[children[0]] == tree.start[children[1]]
            assert tree.end[children[1]] == tree.end[chord]
            ends = np.array([tree.start[children[1]]])
            reach = np.abs(offsets_from_segments(ends, tree.start[chord], tree.end[chord]))[0]
            assert reach <= tree.cover[chord] + 1e-12
        else:
            assert tree.cover[chord] == 0.0


def test_a_tool_turns_about_its_pivot_and_slides_along_its_direction():
    turning = MovingOutline.from_table(Station(name="a", scene="x", outline=[[10, 0]], pivot=[4, 0], sense="cw"))
    assert turning.moved_points(turning.points, 90.0) == pytest.approx([4.0 - 6.0j])
    assert turning.velocities_by_lift(np.array([4.0 - 6.0j])) * np.degrees(1.0) == pytest.approx([-6.0])
    sliding = MovingOutline.from_table(Station(name="a", scene="x", outline=[[10, 0]], direction=120))
    assert sliding.moved_points(sliding.points, 2.0) == pytest.approx([9.0 + np.sqrt(3.0) * 1j])
