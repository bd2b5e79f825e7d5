"""The answers: verdicts, the smallest cam, fronts, free laws, tolerances, measured cams.

In: a ``Problem``. Out: results with tables (``tables``). Parts: ``verdicts`` (does a design hold its limits),
``smallest`` (the smallest design that does), ``front`` (sweeps and Pareto sets), ``synthesis`` (free laws by convex
optimisation), ``tolerances`` (real cams), ``contour`` (arcs and cubics along a cam), ``measured`` (measured
motions).

Read first: ``verdicts/limit_verdicts.py``, where designs meet their limits.
"""
