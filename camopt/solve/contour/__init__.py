"""The cam's curves as paths of lines, arcs or cubics, each with a proved deviation.

``curve.py`` has the exact curves, ``path.py`` the paths, ``path_fitting.py`` fits them, ``deviation.py`` proves
them.
"""
