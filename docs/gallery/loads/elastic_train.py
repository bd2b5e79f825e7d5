"""
Vibration of an elastic follower train
======================================

Between cam and valve there is an elastic train. Its mass lags and overshoots, and keeps vibrating in the dwell.
Some speeds are much worse than others.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(
    **{
        "cam.rpm": 450,
        "follower.dynamics": {"mass": 1.5, "natural_frequency": 80, "damping_ratio": 0.02},
        "limits": {},
        "outputs": ["vibration"],
    }
)

# %%
# Residual vibration in the dwells, against the speed; and how far the mass is off its cam at 450 rev/min, with
# the parabolic law.

speeds = np.linspace(200, 700, 31)
figure, (above, below) = plt.subplots(2, figsize=(8, 6), height_ratios=(3, 2))
for law in ("parabolic", "cycloidal"):
    found = camopt.evaluate_designs(scene, {"rpm": speeds, "law": law})
    above.semilogy(speeds, found["residual_vibration_max_mm"], ".-", label=law)
above.set(xlabel="speed, rev/min", ylabel="residual vibration, mm", xlim=(200, 700))
above.legend(loc="lower right")

cam = camopt.cam_points(scene, step=0.25)
below.fill_between(cam["cam_angle_deg"], cam["overshoot_mm"], color="C0", alpha=0.3)
below.plot(cam["cam_angle_deg"], cam["overshoot_mm"], lw=1)
below.set(xlabel="cam angle, deg", ylabel="deviation, mm", xlim=(0, 360))
