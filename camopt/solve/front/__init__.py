"""Fronts: the sweep over a grid of designs, its Pareto set, and each row of it moved off the grid."""
