"""
Ten cams drawn with ruler and compasses
=======================================

The worked cams of textbooks, each with the construction that a lecture draws: the displacement diagram by the
construction of its law, and the profile by kinematic inversion. Every point is exact, so a drawing can be checked
against it. `Construct a cam by hand <../../how-to/construct-a-cam.html>`_ says how to read a sheet.
"""

import camopt

# %%
# Knife edge, uniform velocity: straight lines, and radii.

camopt.plot(camopt.find_scene("uniform-knife-radial"), construction=6)

# %%
# The same with an offset: tangents to the offset circle in place of radii.

camopt.plot(camopt.find_scene("uniform-knife-offset"), construction=6)

# %%
# Simple harmonic motion: a semicircle on the stroke.

camopt.plot(camopt.find_scene("harmonic-240rpm-radial"), construction=6)

# %%
# Uniform acceleration and retardation: a double parabola.

camopt.plot(camopt.find_scene("knife-900rpm-offset"), construction=6)

# %%
# A roller: the pitch curve begins at the prime circle, and the profile touches the rollers.

camopt.plot(camopt.find_scene("valve-rod-radial"), construction=6)

# %%
camopt.plot(camopt.find_scene("exhaust-valve"), construction=6)

# %%
# A roller with an offset.

roller = camopt.find_scene("roller-1000rpm").replace(**{"cam.base_radius": 50, "follower.offset": 20})
camopt.plot(roller, construction=6)

# %%
# Two laws in one turn.

camopt.plot(camopt.find_scene("two-pauses"), construction=6)

# %%
# A flat face: the profile touches the faces.

camopt.plot(camopt.find_scene("flat-reciprocating"), construction=6)

# %%
# An oscillating roller: arcs about the stations of the pivot.

camopt.plot(camopt.find_scene("oscillating-roller"), construction=6)
