"""A biarc with its control polygon, and how many elements of each kind a cam needs."""

import matplotlib.pyplot as plt
import numpy as np
from roller import SCENE

from camopt.scene.problem.problem import resolve_design
from camopt.show.drawing.style import INK, MUTED, SERIES, add_grid, series_line_style
from camopt.solve.contour.curve import disc_curves
from camopt.solve.contour.path_fitting import biarcs, fit_unproved_path

LABELS = {"polyline": "lines", "arcs": "arcs", "spline": "cubics"}
p0, t0, p1, t1 = 0j, np.exp(1.0j), 4 + 0.6j, np.exp(-0.3j)
pair = biarcs(*(np.array([each]) for each in (p0, t0, p1, t1)))
joint = pair.joint[0]
figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained", width_ratios=(1, 1))


def draw_arc(start, end, bulge, colour):
    turn = 2 * np.arctan(bulge)
    tangent = (end - start) / abs(end - start) * np.exp(-1j * turn)
    curvature = 2 * np.sin(turn) / abs(end - start)
    swept = np.linspace(0, 2 * turn, 100)
    points = start + tangent * (np.exp(1j * swept) - 1) / (1j * curvature)
    left.plot(points.real, points.imag, color=colour, lw=1.8)


for start, end, bulge, colour in zip((p0, joint), (joint, p1), pair.bulges, SERIES, strict=False):
    draw_arc(start, end, bulge[0], colour)
d = abs(joint - p0) ** 2 / (2 * ((joint - p0) * t0.conjugate()).real)
polygon = np.array([p0, p0 + d * t0, p1 - d * t1, p1])
left.plot(polygon.real, polygon.imag, color=MUTED, lw=0.9, ls=(0, (4, 3)))
for place, words, offset in (
    (p0, "$p_0$", (-4, -14)),
    (joint, "joint", (0, 8)),
    (p1, "$p_1$", (4, -12)),
    (p0 + d * t0, "$p_0 + d\\,t_0$", (-52, 4)),
    (p1 - d * t1, "$p_1 - d\\,t_1$", (-4, 8)),
):
    left.plot(place.real, place.imag, "o", mfc="white", mec=INK, ms=5)
    left.annotate(words, (place.real, place.imag), offset, textcoords="offset points")
left.set_aspect("equal")
left.set_axis_off()
left.margins(0.18)

profile = disc_curves(resolve_design(SCENE), None)["profile"]
chords = np.geomspace(1e-1, 1e-5, 7)
for place, kind in enumerate(("polyline", "arcs", "spline")):
    counts = [len(fit_unproved_path(profile, kind, chord)) for chord in chords]
    right.loglog(chords, counts, lw=1.3, marker="o", ms=3, label=LABELS[kind], **series_line_style(place))
right.set(xlabel="deviation, mm", ylabel="elements")
right.invert_xaxis()
right.legend()
add_grid(right)
