"""The cam for other programs, machines and people: files of drawings, solids, points and tables.

Its points have all columns of the cam: displacement, curves and loads at each cam angle."""

from camopt.core.storage.home import settle_home

settle_home()
