"""
What tolerances do to the motion
================================

The profile, the roller and the offset of a real cam are never those of the drawing. ``tolerance`` tells how far the
motion may be from the one that was asked for, and what contributes most to it.
"""

import camopt

given = {"profile": 0.01, "waves": 12, "follower.roller_radius": "h6", "follower.offset": 0.02, "phase": 0.02}
laws = {"motion.1.law": "poly345", "motion.3.law": "poly345"}
scene = camopt.find_scene("roller-1000rpm").replace(
    name="Roller cam with tolerances", tolerances=given, limits={"position_error": 0.03}, **laws
)
errors = camopt.tolerance(scene)
camopt.plot(errors)

# %%
# What no cam within the tolerances exceeds, proved by exact contact, and the worst cam that was found:

worst = errors.worst_case
print(f"no cam is further off than {worst.bound:.6f} mm, one is {abs(worst.error):.6f} mm off")

# %%
# Many cams of a workshop, each with errors of its own: hardly any is near the worst case.

batch = camopt.sample_cams(scene, cams=2**14)
print(f"{batch.held.share:.2%} of {batch.cams:,} cams hold the limit of 0.03 mm, where the worst cam has 0.05 mm")
camopt.plot(batch)
