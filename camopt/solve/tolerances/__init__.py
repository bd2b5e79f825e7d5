"""Tolerances: how far the motion of a real cam may be from the one that was asked for."""
