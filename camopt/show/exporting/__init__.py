"""Files of a cam for machines, other programs and people: drawings, solids, programs, points and tables.

Points have all columns of the cam: displacement, curves and loads at each cam angle.
"""

from camopt.core.storage.home import ensure_home_folder

ensure_home_folder()
