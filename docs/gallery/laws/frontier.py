"""
The frontier of size and acceleration
=====================================

How much smaller can the cam be with more acceleration? Each point is a cam with its own motion laws. No motion
reaches the shaded region.
"""

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
found = camopt.frontier(scene, points=5, workers=1)

# %%
# The picture also shows known laws, each on the smallest cam that the limits allow.

camopt.plot(found)

# %%
# Every row has its scene: evaluate it, certify it or write it to a file.

for row in found.rows:
    print(f"{row['size']:7.2f} mm {row['acceleration']:9.1f} m/s²   bound {row['bound']:7.2f} mm")
camopt.certify(found.rows[0].scene)
