"""One verb for every picture: what is drawn says which picture it has."""

import os
from collections.abc import Mapping, Sequence
from importlib import import_module
from inspect import signature
from typing import Any, cast

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.quantities.display import Drawable
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.scene import Scene
from camopt.show.drawing.construction.construct import construct
from camopt.show.drawing.style import Figure, Target, picture_style

TABLE_PICTURE = "pictures.front"


def plot(
    what: Drawable | SceneSource | Sequence[Drawable], path: Target = None, *, ax: Any = None, **options: Any
) -> "Figure":
    """Draw a cam or a result; to a PNG, SVG or PDF file as well, if a path is given.

    - A scene with sizes of its own, a design, or what ``evaluate`` gives: the cam to scale at cam angle 0 (a groove
      is developed), and over one turn in deg the diagrams of displacement, velocity, acceleration and jerk (by time
      if the scene has an rpm, by cam angle if not), pressure angle (contact on the face, for a face square to the
      motion), curvature, and of the effects that the scene calls for, and no others. Peaks carry their exact
      values; jumps are breaks, impulses arrows. Lengths in mm.
    - What ``construct`` gives: how the cam is constructed with ruler and compasses, on one A3 sheet: the
      displacement diagram by the construction of its law, the profile by kinematic inversion with numbered
      stations, the answers with their formulas, and the table by station.
    - What ``synthesise`` gives: its cam beside that of the best known law within the same limits, if there is one.
    - What ``frontier`` gives: its first axis up, the second to the right, a third as colours. Of two axes a
      staircase is shaded, the region that no motion can reach by the bounds (``Frontier.excluded``).
    - What ``fit`` gives: points and motion, deviations in their band, acceleration by differences and of the
      motion; of a measured profile also the profile of the cam found, and how far the points are from it.
    - What ``sweep`` gives, or a DataFrame of its rows: its Pareto front, a panel for each pair of objectives that
      vary, coloured by law.
    - What ``compare`` gives: the Pareto fronts of both, a panel for each pair of objectives that vary.
    - What ``response_spectrum`` gives, for one law or a list at one damping ratio: residual amplitude in the dwell,
      and largest acceleration of the mass.
    - What ``harmonics`` gives: the amplitudes of displacement and acceleration by order.
    - What ``tolerance`` gives: the errors of displacement, velocity and acceleration over the turn, and what each
      tolerance contributes.
    - What ``sample_cams`` gives: how many cams have which largest errors and which quantities of limits.

    The same input gives the same file, and the file appears only when whole.

    Parameters
    ----------
    what : Scene, str, os.PathLike, DataFrame, or a result with a picture
        What is drawn; of spectra also a list.
    path : str or os.PathLike, optional
        A PNG, SVG or PDF file to write as well.
    ax : matplotlib.axes.Axes, optional
        Axes to draw the main diagram in, in place of a figure: the cam of a scene or a design, the front of a
        sweep, a frontier, the errors of displacement of ``tolerance``, the displacement of ``harmonics``.
    **options
        Of a synthesis ``known``: its known laws, if they were compared already. Of a scene ``construction``: draw
        its construction with so many parts a stroke. Of a construction ``steps``: True for a page of a PDF, or a
        frame of a GIF, a step.

    Returns
    -------
    matplotlib.figure.Figure
        Which a notebook shows, and which can be changed.

    Raises
    ------
    BadInput
        If it has no picture, no main diagram for ``ax``, or the file's name does not end in .png, .svg or .pdf.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> figure = camopt.plot(camopt.find_scene("two-pauses"), "cam.svg")
    >>> figure = camopt.plot(camopt.find_scene("two-pauses"), "construction.pdf", construction=6)
    >>> spectra = [camopt.response_spectrum(law) for law in ("cycloidal", "poly345")]
    >>> figure = camopt.plot(spectra, "spectra.png")
    """
    if isinstance(what, (str, os.PathLike)):
        what = scene_from(what)
    if isinstance(what, Scene) and options.get("construction") is not None:
        what = construct(what, options.pop("construction"))
    pictures = import_module(f"camopt.show.{_picture_module(what)}")
    known = ["construction"] if isinstance(what, Scene) else [*signature(pictures.draw).parameters][2:]
    _check_options(options, known)
    if ax is None:
        figure: Figure = pictures.draw(what, path, **options)
        return figure
    if path is not None or options or not hasattr(pictures, "draw_in"):
        why = "axes for a scene, a design, or what sweep, frontier, tolerance or harmonics gives, without a path"
        raise BadInput([Mistake("camopt", "ax", type(what).__name__, why)])
    if not hasattr(ax, "figure"):
        raise BadInput([Mistake("camopt", "ax", ax, "axes of matplotlib")])
    with picture_style():
        pictures.draw_in(ax, what)
    return cast("Figure", ax.figure)


def _picture_module(what: Any) -> str:
    """The module of the package that draws something."""
    if "scene" in getattr(what, "attrs", ()):  # a table of designs that camopt made
        return TABLE_PICTURE
    every = [what] if isinstance(what, Drawable) else what if isinstance(what, (list, tuple)) else []
    kinds = {type(each) for each in every}
    kind = kinds.pop() if len(kinds) == 1 else None
    if kind is None or not issubclass(kind, Drawable) or not (kind is type(what) or kind.together):
        why = "a scene, a design, or a result that has a picture; several together if response_spectrum gave them"
        why += "; an optimum has a design as its best" if hasattr(what, "best") else ""
        raise BadInput([Mistake("camopt", "what", type(what).__name__, why)])
    return kind.picture


def _check_options(options: Mapping[str, Any], known: Sequence[str]) -> None:
    """BadInput for options that a picture has not."""
    wrong = [name for name in options if name not in known]
    if wrong:
        has = [suggest_names(name, known) if known else "it has none" for name in wrong]
        why = "is no option of this picture; {}. The figure that plot returns can be changed"
        found = zip(wrong, has, strict=True)
        raise BadInput(
            Mistake("camopt", name, options[name], why.format(words), bare=True) for name, words in found
        )
