"""Two profiles that cannot be made: one undercut, one that crosses itself far from there."""

import matplotlib.pyplot as plt

import camopt
from camopt.show.drawing.style import INK, PITCH_COLOUR

turns = (
    ("undercut", 16, 30, [("rise", 60, 26), ("return", 60, 26), ("dwell", 240, 0)]),
    ("self-crossing", 3, 20, [("rise", 60, 90), ("dwell", 5, 0), ("return", 60, 90), ("dwell", 235, 0)]),
)
figure, row = plt.subplots(1, 2, figsize=(7, 3.6), layout="constrained")
for axes, (title, base, roller, segments) in zip(row, turns, strict=True):
    scene = camopt.Scene.from_dict({
        "cam": {"form": "disc", "base_radius": base},
        "follower": {"motion": "translating", "contact": "roller", "roller_radius": roller},
        "motion": [
            {"segment": kind, "angle": angle, **({"lift": lift, "law": "cycloidal"} if lift else {})}
            for kind, angle, lift in segments
        ],
    })  # fmt: skip
    points = camopt.cam_points(scene, step=0.1)
    axes.plot(
        points["pitch_x_mm"], points["pitch_y_mm"], color=PITCH_COLOUR, lw=0.9, ls=(0, (6, 2)), label="pitch curve"
    )
    axes.plot(points["profile_x_mm"], points["profile_y_mm"], color=INK, lw=1.2, label="profile")
    axes.plot(0, 0, "+", color=INK)
    axes.set_title(
        f"{title}: $\\kappa R_r$ = {camopt.evaluate(scene)['pitch_curvature_max_per_mm'] * roller:.2f} at most"
    )
    axes.set_aspect("equal")
    axes.set_axis_off()
row[0].legend(loc="lower left")
