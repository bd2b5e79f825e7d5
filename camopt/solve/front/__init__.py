"""The sweep over a grid or sample of designs, its Pareto front, and the refinement of this front off the grid.

Start with ``sweep``, then ``plan`` (the space and the blocks), ``blocks`` (their results) and ``pareto``.
"""
