"""Free motion laws, found by convex optimisation.

``synthesise`` gives the laws of one scene; ``frontier`` trades one objective against others. Both build a
``SynthesisProblem`` from the scene (``problem_from_scene``) and then a convex programme (``convex_model``).
"""
