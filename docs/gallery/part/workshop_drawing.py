"""
A workshop drawing
==================

A PDF is one sheet at a standard scale: views, dimensions, the angles of the motion, a table of the profile, and
material, tolerance and roughness from ``[part]``.
"""

import matplotlib.pyplot as plt
import numpy as np
import pymupdf

import camopt

scene = camopt.find_scene("belt-matching").replace(
    part={
        "thickness": 18,
        "hub_diameter": 55,
        "hub_length": 36,
        "keyway_width": 8,
        "keyway_depth": 3.3,
        "density": 7800,
        "material": "16MnCr5, case-hardened",
        "hardness": "60 + 4 HRC",
        "profile_tolerance": 0.02,
        "roughness": 0.8,
        "name": "Pusher cam",
        "number": "BM-60-01",
    }
)
camopt.export(scene, "cam.pdf").about

# %%
# The sheet, as a picture:

pixels = pymupdf.open("cam.pdf")[0].get_pixmap(dpi=110)
image = np.frombuffer(pixels.samples, np.uint8).reshape(pixels.height, pixels.width, 3)
figure, ax = plt.subplots(figsize=(11.7, 11.7 * pixels.height / pixels.width))
ax.imshow(image)
ax.axis("off")
