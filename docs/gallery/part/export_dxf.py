"""
A DXF file of tangent arcs
==========================

``export`` writes the cam for a machine. It uses the fewest tangent arcs that stay within the chord tolerance of the
true curve, and proves their deviation. Another library reads the file back.
"""

import ezdxf
import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("valve-rod-radial")
for chord in (0.1, 0.01, 0.001):
    profile = camopt.export(scene, "cam.dxf", chord=chord).curves["profile"]
    print(f"chord {chord:5g} mm: {profile.elements:3d} arcs, within {profile.deviation_mm:.7f} mm (proved)")

# %%
# The arcs of the profile for a chord of 0.1 mm, each in a colour of its own:

camopt.export(scene, "coarse.dxf", chord=0.1)
drawing = ezdxf.readfile("coarse.dxf").modelspace()
figure, ax = plt.subplots(figsize=(7, 5.5))
(outline,) = drawing.query("LWPOLYLINE[layer=='PROFILE']")
colours = plt.colormaps["tab20"]
for k, piece in enumerate(outline.virtual_entities()):
    path = np.array([(p.x, p.y) for p in piece.flattening(1e-3)]) if piece.dxftype() == "ARC" else None
    ends = np.array([piece.dxf.start, piece.dxf.end])[:, :2] if path is None else path
    ax.plot(*ends.T, color=colours(k % 20), lw=5, solid_capstyle="butt")
ax.add_patch(plt.Circle((0, 0), scene.cam.shaft_diameter / 2, fill=False, color="k"))
ax.plot(0, 0, "k+", ms=12)
ax.set_aspect("equal")
ax.axis("off")
