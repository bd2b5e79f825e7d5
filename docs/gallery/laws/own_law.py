"""
Motion laws of your own
=======================

A scene may have laws of its own: polynomials by their conditions at both ends, sine–constant–cosine shares, skewed
laws, splines, tables of points. Each has a name, and serves wherever a built-in law does.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

x = np.linspace(0, 1, 81)
lift = x - np.sin(2 * np.pi * x) / (2 * np.pi) + 0.02 * np.sin(2 * np.pi * x) ** 3  # any function, as points
scene = camopt.find_scene("roller-1000rpm").replace(
    laws={
        "slow-start": {"start": [0, 0, 0, 0], "end": [1, 0, 0]},
        "quick": {"scca": [0.2, 0.3, 0.3, 0.2]},
        "skewed": {"law": "modified-sine", "crossing": 0.4},
        "from-points": {"x": x.tolist(), "s": lift.tolist()},
    }
)

# %%
# Each law as the rise of the cam: the acceleration at 1000 rev/min.

figure, axes = plt.subplots(2, 2, figsize=(9, 5.5), sharex=True, sharey=True)
for k, (ax, law) in enumerate(zip(axes.flat, scene.laws, strict=True)):
    rise = scene.motion[0].model_dump(exclude_none=True) | {"law": law}
    others = [segment.model_dump(exclude_none=True) for segment in scene.motion[1:]]
    own = scene.replace(motion=[rise, *others])
    peak = camopt.evaluate(own)["acceleration_max_rise_m_s2"]
    angle = np.linspace(0, 120, 241)
    position = camopt.cam_points(own, angle)["displacement_mm"]
    per_second = np.gradient(np.gradient(position, angle), angle)[2:-2] * 6000**2 / 1000
    ax.fill_between(angle[2:-2], per_second, color=f"C{k}", alpha=0.25)
    ax.plot(angle[2:-2], per_second, color=f"C{k}")
    ax.set_title(f"{law}: largest acceleration {peak:.0f} m/s²")
figure.supxlabel("cam angle, deg", fontsize=9)
figure.supylabel("acceleration, m/s²", fontsize=9)

# %%
# The smallest cam of each law. Verdicts on a law of points are "sampled", because the motion between the points is
# unknown.

searched = scene.replace(**{"search.law": list(scene.laws), "search.roller_radius": [20]})
for design in camopt.optimise(searched).by_law.values():
    print(f"{design['law_rise']:12s} {design['base_radius_mm']:8.3f} mm   {design['status']}")
