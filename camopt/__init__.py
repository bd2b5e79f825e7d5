"""camopt finds the smallest cam that gives a motion within your limits, and computes new motion laws for it.

A ``Scene`` is a question: a cam, its follower and motion, limits, and in ``search`` what may vary. Every function
takes a scene, the name of a shipped one, or the path of a TOML file::

    scene = camopt.find_scene("roller-1000rpm").replace(**{"limits.pressure_angle": 30})
    cam = camopt.evaluate(scene)                   # every quantity of one design
    best = camopt.optimise(scene).best             # the smallest cam; best.scene is a scene again
    swept = camopt.sweep(scene)                    # every design of a grid, and the Pareto front
    front = swept.to_pandas()                      # rows for pandas; camopt.plot(swept) draws them
    rows = camopt.evaluate_designs(scene, front)   # quantities of the rows of any table
    one = camopt.scene_of(front, 0)                # a row as a scene, for every function

``synthesise`` and ``frontier`` compute new motion laws, ``fit`` finds the motion of a measured cam, ``certify``
proves limits, ``tolerance`` and ``sample_cams`` say what tolerances do, ``prices`` what a limit costs, ``check``
finds damaged files, ``compare`` sets two results side by side, ``export`` and ``report`` write files, ``plot``,
``construct`` and ``animate`` draw.

Each function returns a ``Result``: ``tables()``, ``to_pandas()``, ``to_dict()``, ``exit_code``. ``QUANTITIES``
lists what can be reported, limited and minimised, ``LAWS`` the motion laws; ``quantity`` makes one of your own.

Names are imported when they are first used, so that ``import camopt`` takes no time.
"""

from importlib import import_module

from lazy_loader import attach_stub

from camopt.core.quantities.display import HasHtml

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)


def _html(result: HasHtml) -> str:
    """What a notebook shows of a result."""
    return str(import_module("camopt.show.drawing.notebook").result_html(result))


HasHtml.html = _html
