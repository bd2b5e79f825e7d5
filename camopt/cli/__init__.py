"""The command line. Commands import what they need of the rest when they run, not for their help."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
