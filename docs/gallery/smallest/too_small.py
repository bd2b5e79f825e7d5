"""
Too small by a millionth of a millionth
=======================================

Sampling the turn finds a peak that is a little too low, and accepts a cam that breaks its limit. camopt encloses
the peak of the continuous motion, and ``certify`` decides in interval arithmetic.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

valve = camopt.find_scene("exhaust-valve")
strokes = [segment.model_dump(exclude_none=True) for segment in valve.motion]
scene = valve.replace(motion=[stroke | ({"law": "cycloidal"} if stroke["lift"] else {}) for stroke in strokes])
steepest = camopt.evaluate(scene)["pressure_angle_max_deg"]


def sampled(samples):
    """The largest pressure angle by its textbook formula at so many cam angles, deg."""
    x = (np.arange(samples) + 0.5) / samples
    law = camopt.LAWS["cycloidal"]
    lift, slope = 37.5 * law.displacement(x), 37.5 * law.velocity(x) / np.radians(60)
    return np.degrees(np.arctan(slope / (60 + lift))).max()


# %%
# How much of the peak sampling misses, against the number of samples in the rise:

counts = np.unique(np.geomspace(10, 100_000, 80).astype(int))
missed = [1 - sampled(count) / steepest for count in counts]
figure, ax = plt.subplots()
ax.loglog(counts, missed, ".-", color="C1", label="samples of the rise")
ax.axhline(1e-13, color="C0", lw=2, label="evaluate: proved, relative")
ax.axhline(1e-12, color="k", ls="--", lw=1, label="the cam below is too small by that much")
ax.set(xlabel="samples", ylabel="share of the pressure angle that is missed", ylim=(1e-14, 1))
ax.legend()

# %%
# Limits a relative 1e-12 above and below the true peak:

for share in (1e-12, -1e-12):
    limited = scene.replace(limits={"pressure_angle": steepest * (1 + share)})
    print(f"{share:+.0e}: {camopt.certify(limited)['pressure_angle']}")
