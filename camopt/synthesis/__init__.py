"""Free motion laws by convex optimisation. The only part of camopt that imports cvxpy."""
