"""The command line.

In: the arguments of a command. Out: a printed result, files and an exit code. Commands import what they use when
they run, so their help is fast.

Read first: ``main.py``, which lists the commands.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
