"""What three laws leave behind after a rise, over the time of the rise in natural periods."""

import matplotlib.pyplot as plt
import numpy as np

import camopt
from camopt.show.drawing.style import add_grid, series_line_style

ratio = np.linspace(0.2, 8, 600)
figure, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
for k, law in enumerate(("harmonic", "modified-sine", "cycloidal", "poly4567")):
    axes.semilogy(
        ratio, camopt.response_spectrum(law, ratio)["residual"], label=law, lw=1.2, **series_line_style(k)
    )
axes.set(xlabel="period ratio $t_1/T_n$", ylabel="residual amplitude, of the lift", ylim=(1e-5, 1.5), xlim=(0, 8))
add_grid(axes)
axes.legend(loc="upper right", ncols=2)
