"""Pictures of results: fronts, free laws, frontiers, tolerances, measured motions."""
