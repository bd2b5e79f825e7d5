"""
An inlet valve cam made of moves
================================

Ramps take up the lash at a small constant velocity. Flanks and nose follow. The motion consists of *moves*: they
join with continuous velocity and acceleration, and have the least mean-square jerk between the given positions.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("bucket-valve")
cam = camopt.cam_points(scene, step=0.25)
angle, lift = cam["cam_angle_deg"], cam["displacement_mm"]

# %%
# The valve opens where the lift passes the lash, on the ramp. Squares are the ends of the moves.

ends = np.cumsum([segment.angle for segment in scene.motion])
speed = np.gradient(lift, np.radians(angle))
figure, (above, below) = plt.subplots(2, sharex=True, figsize=(8, 5), height_ratios=(3, 2))
above.fill_between(angle, lift, color="C0", alpha=0.2)
above.plot(angle, lift)
above.plot(ends, np.interp(ends, angle, lift), "s", color="C0", ms=4)
above.axhspan(0.1, 0.2, color="C1", alpha=0.5, label="lash, 0.1 to 0.2 mm")
above.set(ylabel="lift, mm", xlim=(0, 190))
above.legend()
below.plot(angle, speed, color="C1")
below.fill_between(angle, speed, color="C1", alpha=0.2)
below.set(xlabel="cam angle, deg", ylabel="velocity, mm/rad")

# %%
# The speeds at which the valve opens and closes, the least radius of the nose, and how far the contact runs on
# the face:

asked = ["opening_speed_max_m_s", "closing_speed_max_m_s", "profile_radius_min_mm", "face_reach_max_mm"]
found = camopt.evaluate(scene.replace(outputs=asked))
for name in asked:
    print(f"{name:24s} {found[name]:8.4f}")
