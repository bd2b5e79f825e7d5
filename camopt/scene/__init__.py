"""Scenes: the user's input in TOML or a dictionary, checked key by key, and the problem made from it.

In: a file, a name, a dictionary. Out: a ``Scene`` in the user's units. ``problem`` makes a ``Problem`` from it in
inside units, with limits, variables and the space of designs. Each wrong key gives one clear message.

Read first: ``problem/problem.py``, which has all that solvers read from a scene.
"""
