"""camopt finds the smallest cam that gives a motion within your limits, and computes new motion laws for it.

A question is a ``Scene`` (``find_scene``, ``Scene.from_toml``, ``Scene.from_dict``). ``evaluate`` computes one
design, ``optimise`` finds the smallest, ``sweep`` evaluates a grid, ``synthesise`` and ``frontier`` compute new
motion laws, ``fit`` finds the motion of a measured cam, ``certify`` proves limits, ``check`` finds damaged files,
``plot`` draws, ``construct`` shows how a cam is drawn by hand, ``animate`` shows it turning. ``QUANTITIES`` lists
what can be reported, ``LAWS`` the motion laws.

Names are imported when they are first used, so that ``import camopt`` takes no time.
"""

from importlib import import_module

from lazy_loader import attach_stub

from camopt.quantities.shown import HasHtml

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)


def _html(result: HasHtml) -> str:
    """What a notebook shows of a result."""
    return str(import_module("camopt.drawing.notebook").html_of(result))


HasHtml.html = _html
