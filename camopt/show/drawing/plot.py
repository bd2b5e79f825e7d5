"""``plot``: the picture of a scene, a design, a result or a machine."""

import os
from collections.abc import Sequence
from importlib import import_module
from inspect import signature
from typing import Any, cast

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.quantities.display import Drawable
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.machine import find_machine, is_machine
from camopt.scene.scene import Scene
from camopt.show.drawing.construction.construct import construct
from camopt.show.drawing.style import Figure, Target, picture_style


def plot(
    what: Drawable | SceneSource | Sequence[Drawable], path: Target = None, *, ax: Any = None, **options: Any
) -> "Figure":
    """Draw a cam, a result or a machine; with a path, also save it as PNG, SVG or PDF.

    - A scene with all sizes, a design, or the result of ``evaluate``: the cam to scale at cam angle 0 (a groove is
      developed), and diagrams over one turn. These are displacement, velocity, acceleration, jerk, pressure angle,
      curvature, and the effects that the scene needs. The derivatives are by time if the scene has an rpm, else by
      cam angle. For a face square to the motion, the contact on the face replaces the pressure angle. Peaks have
      exact values; jumps are breaks, impulses are arrows. Lengths in mm, cam angles in deg.
    - A machine, or the result of ``evaluate_machine``: its timing diagram on one sheet, A3 or larger, or size B in
      inches. Each station has a row with the segments and the lift of its tool over a turn of the shaft. Below are
      the ranges of the clearances, and the torque of the shaft and of each station.
    - The result of ``construct``: the construction of the cam with ruler and compasses, on one A3 sheet. It has the
      displacement diagram by the construction of its law, the profile by kinematic inversion with numbered
      stations, the answers with their formulas, and the table by station.
    - The result of ``synthesise``: its cam beside that of the best known law within the same limits, if any.
    - The result of ``frontier``: its first axis vertical, the second horizontal, a third as colours. With two axes
      the region is shaded that no motion can reach, by the bounds (``Frontier.excluded``).
    - The result of ``fit``: points and motion, deviations in their band, acceleration by differences and of the
      motion. For a measured profile also the profile of the fitted cam, and the distances of the points from it.
    - The result of ``sweep``, or a DataFrame of its rows: the Pareto front, a panel for each pair of objectives
      that vary, coloured by law.
    - The result of ``compare``: both Pareto fronts, a panel for each pair of objectives that vary.
    - The result of ``response_spectrum``, or a list of them at one damping ratio: residual amplitude in the dwell,
      and largest acceleration of the mass.
    - The result of ``harmonics``: the amplitudes of displacement and acceleration by order.
    - The result of ``tolerance``: the errors of displacement, velocity and acceleration over the turn, and the
      contribution of each tolerance.
    - The result of ``sample_cams``: histograms of the largest errors and of the quantities of limits.

    The same input gives the same file. The file appears only when it is complete.

    Parameters
    ----------
    what : Scene, Machine, str, os.PathLike, DataFrame, or a result with a picture
        The subject of the picture; for spectra also a list.
    path : str or os.PathLike, optional
        A PNG, SVG or PDF file to write.
    ax : matplotlib.axes.Axes, optional
        Axes for the main diagram, in place of a new figure: the cam of a scene or a design, the front of a sweep, a
        frontier, the errors of displacement of ``tolerance``, the displacement of ``harmonics``.
    **options
        For a synthesis, ``known``: its known laws, if they were compared already. For a scene, ``construction``:
        draw its construction with this number of parts per stroke. For a construction, ``steps``: True for a page
        (PDF) or frame (GIF) per step.

    Returns
    -------
    matplotlib.figure.Figure
        The figure. Notebooks show it, and it can be changed.

    Raises
    ------
    BadInput
        If ``what`` has no picture, or no main diagram for ``ax``; or if the file does not end in .png, .svg or
        .pdf.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> figure = camopt.plot(camopt.find_scene("two-pauses"), "cam.svg")
    >>> figure = camopt.plot(camopt.find_scene("two-pauses"), "construction.pdf", construction=6)
    >>> figure = camopt.plot(camopt.find_machine("pick-and-place"), "timing.pdf")
    >>> spectra = [camopt.response_spectrum(law) for law in ("cycloidal", "poly345")]
    >>> figure = camopt.plot(spectra, "spectra.png")
    """
    if isinstance(what, (str, os.PathLike)):
        what = find_machine(what) if is_machine(os.fsdecode(what)) else scene_from(what)
    if isinstance(what, Scene) and options.get("construction") is not None:
        what = construct(what, options.pop("construction"))
    pictures = import_module(f"camopt.show.{_picture_module(what)}")
    allowed = ["construction"] if isinstance(what, Scene) else [*signature(pictures.draw).parameters][2:]
    if wrong := [name for name in options if name not in allowed]:
        hints = [suggest_names(name, allowed) if allowed else "it has none" for name in wrong]
        why = "is not an option of this picture; {}. The figure that plot returns can be changed"
        raise BadInput(
            Mistake("camopt", name, options[name], why.format(hint), bare=True)
            for name, hint in zip(wrong, hints, strict=True)
        )
    if ax is None:
        figure: Figure = pictures.draw(what, path, **options)
        return figure
    if path is not None or options or not hasattr(pictures, "draw_main_diagram"):
        why = "a scene, a design, or a result of sweep, frontier, tolerance or harmonics; and without a path"
        raise BadInput([Mistake("camopt", "ax", type(what).__name__, why)])
    if not hasattr(ax, "figure"):
        raise BadInput([Mistake("camopt", "ax", ax, "axes of matplotlib")])
    with picture_style():
        pictures.draw_main_diagram(ax, what)
    return cast("Figure", ax.figure)


def _picture_module(what: Any) -> str:
    """The module of ``camopt.show`` that draws ``what``."""
    if "scene" in getattr(what, "attrs", ()):  # a table of designs made by camopt
        return "pictures.front"
    items = [what] if isinstance(what, Drawable) else what if isinstance(what, (list, tuple)) else []
    kinds = {type(item) for item in items}
    kind = kinds.pop() if len(kinds) == 1 else None
    if kind is None or not issubclass(kind, Drawable) or not (kind is type(what) or kind.together):
        why = "a scene, a design, or a result that has a picture; or a list of results of response_spectrum"
        why += "; the design of an optimum is its attribute best" if hasattr(what, "best") else ""
        raise BadInput([Mistake("camopt", "what", type(what).__name__, why)])
    return kind.picture
