"""
Torque of the camshaft, and its flywheel
========================================

The torque of a cam goes up and down with the spring and the inertia of the follower. Its fluctuation about the
mean says how large a flywheel keeps the speed within 5 %.
"""

import matplotlib.pyplot as plt

import camopt

scene = camopt.find_scene("exhaust-valve").replace(
    **{
        "cam.rpm": 300,
        "follower.dynamics": {"mass": 1.5, "spring_rate": 15, "preload": 250, "friction": 0.1}
        | {"guide_length": 90, "overhang": 80, "fluctuation": 0.05},
        "outputs": ["torque"],
    }
)
found = camopt.evaluate(scene)
asked = ("torque_max_N_m", "torque_min_N_m", "torque_mean_N_m", "energy_fluctuation_J", "flywheel_inertia_kg_m2")
{name: round(found[name], 4) for name in asked}

# %%
# Where the torque is above its mean, the flywheel gives energy; where it is below, the flywheel takes it. The
# mean is what friction in the guide costs.

cam = camopt.cam_points(scene, step=0.25)
angle, torque, mean = cam["cam_angle_deg"], cam["torque_N_m"], found["torque_mean_N_m"]
figure, ax = plt.subplots()
ax.fill_between(angle, mean, torque, where=torque > mean, color="C1", alpha=0.35, label="the flywheel gives")
ax.fill_between(angle, mean, torque, where=torque < mean, color="C0", alpha=0.35, label="the flywheel takes")
ax.plot(angle, torque, color="k", lw=1.2)
ax.axhline(mean, color="C2", lw=1.2, label=f"mean {mean:.2f} N·m")
ax.set(xlabel="cam angle, deg", ylabel="torque, N·m", xlim=(0, 200))
ax.legend()
