"""What commands use of the library besides public names, each imported when it is first used.

Commands are imported for their help, so they import nothing heavy themselves.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub("camopt", __file__)
