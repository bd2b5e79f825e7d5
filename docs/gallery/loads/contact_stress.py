"""
Contact stress and oil film
===========================

A larger roller has less contact stress and a thicker film, until the cam becomes sharp under it. Film and
roughness give the film ratio: below 1 the surfaces touch, above 3 they hardly do.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("exhaust-valve").replace(
    **{
        "cam.rpm": 300,
        "follower.dynamics": {"mass": 1.5, "spring_rate": 15, "preload": 250},
        "materials": {"cam": "steel", "follower": "steel", "face_width": 10}
        | {"viscosity": 0.05, "pressure_viscosity": 18, "roughness": 0.2},
        "outputs": ["hertz", "surface"],
    }
)

# %%
# Stress along the turn for three rollers, and the peaks of many rollers at once, proved for the continuous turn:

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), width_ratios=(3, 2))
for radius in (8, 14, 20):
    cam = camopt.cam_points(scene.replace(**{"follower.roller_radius": radius}), step=0.5)
    left.plot(cam["cam_angle_deg"], cam["contact_stress_MPa"], label=f"roller radius {radius} mm")
left.set(xlabel="cam angle, deg", ylabel="contact stress, MPa", xlim=(0, 200))
left.legend(loc="upper right")

radii = np.linspace(4, 40, 37)
found = camopt.evaluate_designs(scene, {"roller_radius_mm": radii})
right.plot(radii, found["contact_stress_max_MPa"], color="C0")
right.set(xlabel="roller radius, mm", ylabel="largest contact stress, MPa")
right.yaxis.label.set_color("C0")
film = right.twinx()
film.plot(radii, found["film_ratio_min"], color="C1")
film.set_ylabel("least film ratio", color="C1")
film.grid(visible=False)

# %%
# The roller that stays under 420 MPa with the smallest cam:

limited = scene.replace(limits={"contact_stress": 420, "pressure_angle": 45}, search={"roller_radius": [8, 14, 20]})
best = camopt.optimise(limited).best
print(best["roller_radius_mm"], best["base_radius_mm"], best["binding"])
