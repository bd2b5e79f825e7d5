"""Searching the design space: the lazy space, the sweep with its Pareto set, and the exact smallest radius."""
