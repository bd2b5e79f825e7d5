"""
A measured cam
==============

Accelerations by differences of measured lifts are mostly noise. ``fit`` finds the gentlest motion that stays
within a band of the points, and proves that it does.
"""

import numpy as np

import camopt

rng = np.random.default_rng(1)
angle = np.arange(0.0, 360.0, 1.0)
x = np.clip((angle - 60) / 140, 0, 1)
bump = np.where(x < 0.5, 2 * x, 2 - 2 * x)
lift = 8 * (bump - np.sin(2 * np.pi * bump) / (2 * np.pi)) + rng.normal(0, 0.01, angle.size)
tappet = {
    "name": "Inlet cam, measured each degree",
    "cam": {"form": "disc", "base_radius": 20, "rpm": 1500},
    "follower": {"motion": "translating", "contact": "flat"},
}
found = camopt.fit(np.column_stack([angle, lift]), tappet)
found

# %%
# The points, and the acceleration: by differences, and of the motion found:

camopt.plot(found)

# %%
# The fit is a scene like any other.

fitted = camopt.evaluate(found.scene)
true = 2 * np.pi * 8 * (1500 * 6 / 70) ** 2 / 1000
print(f"largest acceleration {fitted['acceleration_max_m_s2']:.1f} m/s²; true {true:.1f} m/s²")
