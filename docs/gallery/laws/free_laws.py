"""
Free motion laws
================

New laws have the same peaks of acceleration and jerk as the 3-4-5 polynomial, and make this cam smaller than any
textbook law does. A second optimisation gives a bound for every possible motion.
"""

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 16})
found = camopt.synthesise(scene)
print(f"base radius {found.design['base_radius_mm']:.2f} mm; no motion has less than {found.bound:.2f} mm")

# %%
# The price of each limit, and the cost with the best laws for each of its values:

for price in camopt.prices(found)["free-rise / free-return"]:
    print(f"{price.key:30s} {price.price:8.3f} mm per {price.unit or 'unit'}")

# %%
# Before and after, at one scale:

camopt.plot(found)
