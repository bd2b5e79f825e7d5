"""Free motion laws by convex optimisation."""
