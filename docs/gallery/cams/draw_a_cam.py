"""
A cam and its diagrams
======================
"""

import camopt

camopt.plot(camopt.find_scene("two-pauses"))
