"""
What tolerances do to the motion
================================

The profile, the roller and the offset of a real cam are never exactly those of the drawing. ``tolerance`` gives the
largest error of the motion, and the share of each tolerance in it.
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
# The bound for all cams within the tolerances, proved by exact contact, and the worst cam found:

worst = errors.worst_case
print(f"no cam is further off than {worst.bound:.6f} mm, one is {abs(worst.error):.6f} mm off")

# %%
# A batch of cams, each with its own errors: hardly any is near the worst case.

batch = camopt.sample_cams(scene, cams=2**14)
print(f"{batch.held.share:.2%} of {batch.cams:,} cams hold the limit of 0.03 mm, where the worst cam has 0.05 mm")
camopt.plot(batch)
