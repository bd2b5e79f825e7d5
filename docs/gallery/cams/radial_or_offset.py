"""
Radial or offset?
=================

An offset makes the pressure angle of the rise smaller and that of the return larger, or the other way round. The
best offset depends on both limits. ``optimise`` finds it together with the size.
"""

import matplotlib.pyplot as plt

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(
    **{"search.law": ["modified-sine"], "search.roller_radius": [12], "limits.pressure_angle_return": 45}
)
found = {
    "radial": camopt.optimise(scene.replace(**{"search.offset": [0]})).best,
    "offset": camopt.optimise(scene.replace(**{"search.offset": {"start": -40, "stop": 40}})).best,
}

# %%
# Both cams meet 30° on the rise and 45° on the return; circles are the rollers at their lowest.

figure, ax = plt.subplots(figsize=(9, 5))
for (word, design), colour in zip(found.items(), ("C7", "C0"), strict=True):
    cam = camopt.cam_points(design.scene)
    label = f"{word}\nbase radius {design['base_radius_mm']:.1f} mm\noffset {design['offset_mm']:.1f} mm\n"
    ax.fill(cam["profile_x_mm"], cam["profile_y_mm"], color=colour, alpha=0.25)
    ax.plot(cam["profile_x_mm"], cam["profile_y_mm"], color=colour, label=label)
    roller = (cam["pitch_x_mm"][0], cam["pitch_y_mm"][0])
    ax.add_patch(plt.Circle(roller, design["roller_radius_mm"], fill=False, color=colour))
    ax.axvline(design["offset_mm"], color=colour, ls=":", lw=1)
ax.plot(0, 0, "k+", ms=12)
ax.set(aspect="equal", xlabel="mm", ylabel="mm")
ax.legend(loc="center left", bbox_to_anchor=(1, 0.5))
