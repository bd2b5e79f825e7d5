"""Measured lift: reading it, the gentlest motion within a band of the points, its proof, and the scene of it."""
