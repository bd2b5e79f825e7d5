"""Measured cams: fit the gentlest motion within a band of points, and compare a profile with its drawing.

``fit`` turns measured points into a scene. ``inspect`` and ``inspect_pair`` find the errors of measured profiles.
"""
