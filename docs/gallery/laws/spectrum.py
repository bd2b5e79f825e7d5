"""
How a motion law rings
======================

A follower train is elastic. After a rise it vibrates in the dwell. The amplitude depends on the law and on the
ratio of rise time to natural period.
"""

import matplotlib.pyplot as plt

import camopt

laws = ("parabolic", "harmonic", "cycloidal", "modified-sine", "poly4567")
spectra = {law: camopt.response_spectrum(law) for law in laws}

# %%
# Residual amplitude in the dwell, as a share of the lift. After a long rise a smoother law leaves less vibration:
# between eight and ten periods the cycloidal law leaves a tenth of that of the parabola, 4-5-6-7 a twentieth.

figure, ax = plt.subplots()
for law, found in spectra.items():
    ax.semilogy(found["period_ratio"], found["residual"], label=law)
ax.set(xlabel="rise time / natural period", ylabel="residual amplitude / lift", xlim=(0, 10), ylim=(1e-5, 2))
ax.legend(ncols=3, loc="upper right")

# %%
# A table for the designer: the largest acceleration of the mass, and the residual vibration in the dwell, at 4.5
# periods.

for law in laws:
    found = camopt.response_spectrum(law, [4.5])
    print(f"{law:15s} acceleration {found['acceleration'][0]:6.2f}   residual {found['residual'][0]:.5f}")
