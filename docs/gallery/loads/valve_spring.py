"""
The spring that keeps the valve on its cam
==========================================

At high speed inertia lifts the follower off the cam. ``evaluate`` gives the speed at which contact is lost, and the
weakest spring that keeps it.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("bucket-valve").replace(
    **{
        "follower.dynamics.mass": 0.12,
        "follower.dynamics.spring_rate": 30,
        "follower.dynamics.preload": 250,
        "outputs": ["force"],
    }
)
jump = camopt.evaluate(scene)["jump_speed_rpm"]
print(f"contact is lost above {jump:.0f} rev/min")

# %%
# Force along the lift, at speeds up to one at which the valve floats:

figure, ax = plt.subplots()
colours = plt.colormaps["plasma"](np.linspace(0, 0.85, 5))
for rpm, colour in zip((1000, 2000, 3000, jump, 1.15 * jump), colours, strict=True):
    cam = camopt.cam_points(scene.replace(**{"cam.rpm": rpm}), step=0.5)
    ax.plot(cam["cam_angle_deg"], cam["contact_force_N"], color=colour, label=f"{rpm:.0f} rev/min")
ax.axhspan(ax.get_ylim()[0], 0, color="#b3261e", alpha=0.12, lw=0)
ax.text(150, -130, "the valve floats", color="#b3261e")
ax.set(xlabel="cam angle, deg", ylabel="force along the motion, N", xlim=(0, 185))
ax.legend()

# %%
# The speed that each spring allows:

rates = [20, 30, 40, 50]
found = camopt.evaluate_designs(scene, {"spring_rate_N_per_mm": rates})
found[["spring_rate_N_per_mm", "jump_speed_rpm", "contact_force_min_N"]].round(1)
