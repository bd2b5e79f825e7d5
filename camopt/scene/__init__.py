"""What a user asks: a scene in TOML or a dictionary, checked key by key, and the problem that it states.

In: a file, a name, a dictionary. Out: a ``Scene`` in the user's units; ``problem`` makes a ``Problem`` of it, in
inside units, with its limits, its variables and the designs that they span. A wrong key gives one clear message.

Read first: ``problem/problem.py``, which has all that solvers know of a scene.
"""
