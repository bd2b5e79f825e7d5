"""A roller follower with an offset: the normal through the trace point passes through the pole."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Circle

import camopt
from camopt.scene.problem.problem import resolve_design
from camopt.show.drawing.style import BODY, FAINT, INK, MUTED, PITCH_COLOUR, SERIES

scene = camopt.Scene.from_dict({
    "cam": {"form": "disc", "base_radius": 25},
    "follower": {"motion": "translating", "contact": "roller", "roller_radius": 9, "offset": 8},
    "motion": [
        {"segment": "rise", "angle": 130, "lift": 25, "law": "cycloidal"},
        {"segment": "return", "angle": 230, "lift": 25, "law": "cycloidal"},
    ],
})  # fmt: skip
turned = np.radians(60.0)
y, y1, *_ = resolve_design(scene).programme.motion_at(np.array([turned]))[:, 0]
points = camopt.cam_points(scene)
ground = np.exp(1j * turned)  # the cam turns counter-clockwise
pitch, profile = ((points[f"{name}_x_mm"] + 1j * points[f"{name}_y_mm"]) * ground for name in ("pitch", "profile"))
trace, pole = 8 + 1j * (np.sqrt(34**2 - 8**2) + y), y1 + 0j
normal = (trace - pole) / abs(trace - pole)

figure, axes = plt.subplots(figsize=(7, 5), layout="constrained")
axes.fill(profile.real, profile.imag, color=BODY)
axes.plot(profile.real, profile.imag, color=INK, lw=1.3)
axes.plot(pitch.real, pitch.imag, color=PITCH_COLOUR, lw=1.0, ls=(0, (6, 2)))
axes.add_patch(Circle((trace.real, trace.imag), 9, fill=False, ec=INK, lw=1.3))
tip = trace + 22 * normal
axes.plot([pole.real, tip.real], [0, tip.imag], color=SERIES[1], lw=1.3)
axes.plot([8, 8], [0, trace.imag + 24], color=MUTED, lw=0.8, ls=(0, (8, 2, 1, 2)))
axes.plot([-45, 45], [0, 0], color=FAINT, lw=0.8)
for place in (0j, pole, trace, trace - 9 * normal):
    axes.plot(place.real, place.imag, "o", ms=5, mfc="white", mec=INK, zorder=5)
lean = np.linspace(np.pi / 2, np.angle(normal), 30)
axes.plot(*(trace + 17 * np.exp(1j * lean)).view(float).reshape(-1, 2).T, color=SERIES[1], lw=1.0)
middle = trace + 19.5 * np.exp(1j * lean.mean())
axes.text(middle.real, middle.imag, "β", color=SERIES[1], ha="center", fontsize=11)
for words, place, offset in (
    ("cam centre", 0j, (-10, -14)),
    ("pole $x_P = y'$", pole, (4, -14)),
    ("trace point $T$", trace, (-86, 12)),
    ("contact $T - R_r\\,n$", trace - 9 * normal, (14, -14)),
):
    axes.annotate(words, (place.real, place.imag), offset, textcoords="offset points")
axes.text(-46, 22, "pitch curve", color=PITCH_COLOUR)
axes.text(-14, -17, "profile", color=INK)
axes.text(9, trace.imag + 22, "axis of the follower", color=MUTED)
axes.set_aspect("equal")
axes.set_axis_off()
