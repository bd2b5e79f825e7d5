"""Ranges of the motion over stretches of a turn, from its tables: against balls, with laws of their own."""

import numpy as np
import pytest
from flint import arb
from support import own
from support.balls.ball import precisely
from support.balls.motion import exact_motion, motion_at

from camopt import find_scene, shipped_scenes
from camopt.model.motion.programme import Programme
from camopt.scene.problem.problem import resolve_design
from camopt.solve.contour.curve import enclose_motion_derivatives, smooth_spans

POINTS = 3
"""Of each stretch, its ends among them."""


@precisely()
def count_missed(seed, stretches):
    """Of stretches of a random turn, how many have a point whose motion does not lie in the range."""
    rng = np.random.default_rng(seed)
    laws, lift = rng.choice(sorted(own.EVERY), 2), 10.0 ** rng.uniform(-3.0, 3.0)
    angles = np.diff([0.0, *np.sort(rng.uniform(0.0, 360.0, 3)), 360.0]).tolist()
    kinds = [
        ("rise", lift, str(laws[0])),
        ("dwell", 0.0, None),
        ("return", lift, str(laws[1])),
        ("dwell", 0.0, None),
    ]
    segments = [(kind, angle, by, law) for angle, (kind, by, law) in zip(angles, kinds, strict=True)]
    programme = Programme.from_segments(segments, angular=False, laws=own.EVERY)
    exact, spans = exact_motion(programme), [*smooth_spans(programme)]
    which = rng.integers(0, len(spans), stretches)
    chosen = [spans[k] for k in which]
    start, end = (np.array([getattr(span, name) for span in chosen]) for name in ("start", "end"))
    middle = start + (end - start) * rng.uniform(0.0, 1.0, stretches)
    reach = (end - start) * 10.0 ** rng.uniform(-9.0, 0.0, stretches)
    lows, highs = np.maximum(middle - reach, start), np.minimum(middle + reach, end)
    rows, wrong = enclose_motion_derivatives(programme, chosen, lows, highs), 0
    pieces = [
        (stroke, piece, begin)
        for stroke, begin in _strokes_with_starts(exact)
        for piece in stroke.pieces or (None,)
    ]
    for k, span in enumerate(which):
        stroke, piece, begin = pieces[span]
        for angle in (lows[k], *rng.uniform(lows[k], highs[k], POINTS - 2), highs[k]):
            x = (arb(float(angle)) - begin) / stroke.angle
            found = motion_at(stroke, piece, x if piece is None else x.max(piece.start).min(piece.end))
            held = [
                not ball.arb < arb(float(row.low[k])) and not ball.arb > arb(float(row.high[k]))
                for ball, row in zip(found, rows, strict=True)
            ]
            wrong += not all(held)
    return wrong


def _strokes_with_starts(motion):
    """The strokes of a turn in balls, with the cam angles at which they start."""
    begin = arb(0)
    for stroke in motion.strokes:
        yield stroke, begin
        begin += stroke.angle


@pytest.mark.parametrize("seed", range(4))
def test_ranges_hold_the_motion_at_every_point_of_a_stretch(seed):
    assert count_missed(seed, 25) == 0


@pytest.mark.long
def test_ten_thousand_stretches_hold_their_motion():
    assert sum(count_missed(seed, 100) for seed in range(100, 200)) == 0


@pytest.mark.parametrize("name", shipped_scenes())
def test_an_angle_between_the_rounded_ends_of_two_parts_has_a_range(name):
    """Parts of a law begin and end at rounded cam angles, with doubles between them that are in neither."""
    programme = resolve_design(find_scene(name)).programme
    for span in smooth_spans(programme):
        centre, half = programme.table.centre, programme.table.half_width
        ends = np.concatenate([centre - half, centre + half])
        near = np.concatenate([ends, np.nextafter(ends, -np.inf), np.nextafter(ends, np.inf)])
        angles = near[(near >= span.start) & (near <= span.end)]
        rows = enclose_motion_derivatives(programme, [span] * angles.size, angles, angles)
        assert {row.low.shape for row in rows} == {angles.shape}
