"""
The frontier of size and acceleration
=====================================

How much smaller may the cam be if it is allowed more acceleration? Each point is a cam with motion laws of its
own; the shaded region is closed to every motion.
"""

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
found = camopt.frontier(scene, points=5, workers=1)

# %%
# Known laws are beside it, each on the smallest cam that the limits allow.

camopt.plot(found)

# %%
# Every row has its scene, to be evaluated, proved or written to a file.

for row in found.rows:
    print(f"{row['size']:7.2f} mm {row['acceleration']:9.1f} m/s²   bound {row['bound']:7.2f} mm")
camopt.certify(found.rows[0].scene)
