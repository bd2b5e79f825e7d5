"""The problem: a scene in inside units, its limits and what they claim, and the space of its designs."""
