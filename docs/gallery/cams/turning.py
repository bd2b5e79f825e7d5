"""
A cam that turns
================

``animate`` draws the cam turning under its follower, each frame from the motion itself: as an SVG that browsers
play without a script, as a GIF or an MP4 (``camopt.animate(scene, "rocker.gif")``).
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("rocker-valve")
camopt.animate(scene)

# %%
# The same from points: they are in the cam's own frame, which turns.

turn = np.radians([15, 45, 75, 95, 115, 145])
cam = camopt.cam_points(scene)
x, y = cam["profile_x_mm"], cam["profile_y_mm"]
figure, axes = plt.subplots(2, 3, figsize=(9, 5.5), sharex=True, sharey=True)
for ax, angle in zip(axes.flat, turn, strict=True):
    now = round(np.degrees(angle))
    rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    roller = rotation @ (cam["pitch_x_mm"][now], cam["pitch_y_mm"][now])
    ax.fill(*rotation @ (x, y), color="C0", alpha=0.8)
    ax.add_patch(plt.Circle(roller, scene.follower.roller_radius, color="C1"))
    ax.plot([scene.follower.centre_distance, roller[0]], [0, roller[1]], "o-", color="#22303c", lw=3)
    ax.plot(0, 0, "+", color="white", ms=10)
    ax.set(aspect="equal", title=f"{now}°: rocker at {cam['displacement_deg'][now]:.1f}°")
    ax.axis("off")
