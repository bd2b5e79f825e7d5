"""
One cam with all its diagrams
=============================

The exhaust valve of an oil engine: a roller follower that rises 37.5 mm in 60° of the cam. One call evaluates the
cam, another one draws it.
"""

import camopt

scene = camopt.find_scene("exhaust-valve")
cam = camopt.evaluate(scene)
cam

# %%
# Values are those of the continuous motion, with at most 1e-13 of relative error.

print(f"largest pressure angle {cam['pressure_angle_max_deg']:.9f}° at {cam['pressure_angle_max_at_deg']:.6f}°")

# %%
# The parabolic law has no finite jerk: arrows are its impulses.

print(cam.unbounded["jerk_max_rise_mm_per_rad3"])
camopt.plot(scene)
