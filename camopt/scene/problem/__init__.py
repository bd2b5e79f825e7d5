"""The problem: a scene in inside units, its limits with their constraints, and the space of its designs."""
