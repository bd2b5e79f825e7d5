"""The cam for other programs, machines and people: files of drawings, solids, points and tables."""

from camopt.storage.home import settle_home

settle_home()
