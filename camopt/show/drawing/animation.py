"""Animations: a cam, or the cams of a machine, turning under their followers; cursors of diagrams follow.

The SVG file has no script: it is the drawing at the first frame with SMIL elements that move it. Browsers play it;
programs without SMIL show the first frame.
"""

import os
from base64 import b64encode
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from io import StringIO
from typing import Any
from xml.etree import ElementTree

import numpy as np

from camopt.core.storage.files import atomically_written_file, checked_suffix
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.machine import Machine, find_machine, is_machine
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.show.drawing.animated_figure import DISC_SIZE, GROOVE_SIZE, draw_animated_figure
from camopt.show.drawing.frames import find_ffmpeg, write_gif, write_mp4
from camopt.show.drawing.moving_bodies import FRAMES, TURN_TIME, AnimatedFigure, MovingBody, Reading
from camopt.show.drawing.picture import Picture
from camopt.show.drawing.style import Target, new_figure

ANIMATION_KINDS = (".svg", ".gif", ".mp4")


@dataclass(frozen=True)
class Animation:
    """A cam, or the cams of a machine, turning; a notebook shows it.

    Attributes
    ----------
    name : str
        The name of the scene or machine.
    svg : str
        An animated SVG file: without scripts, one turn in 4 s.

    Examples
    --------
    >>> animation = camopt.animate(camopt.find_scene("two-pauses"))
    >>> "<animateTransform " in animation.svg, "<script" in animation.svg
    (True, False)
    """

    name: str
    svg: str = field(repr=False)

    def _repr_html_(self) -> str:
        image = b64encode(self.svg.encode()).decode()
        return f'<img src="data:image/svg+xml;base64,{image}" alt="a cam turning under its follower">'


def animate(scene: SceneSource | Machine, path: Target = None) -> Animation:
    """Animate a cam, or the cams of a machine, turning; with a path, also save it as SVG, GIF or MP4.

    The cam is to scale. Beside it are diagrams of displacement, acceleration and pressure angle, with cursors at
    the cam angle. For a cylindrical cam, the developed groove moves past the follower. The cams of a machine turn
    side by side at their phases and ratios, above its timing diagram. One turn takes 4 s and has 100 frames, each
    computed from the motion; an SVG is interpolated between them. The same scene gives the same SVG or GIF. The
    file appears only when it is complete.

    Parameters
    ----------
    scene : Scene, Machine, str or os.PathLike
        A scene with all sizes, or a machine of such scenes.
    path : str or os.PathLike, optional
        A file to write. An SVG has no scripts; browsers animate it, and other programs show the first frame. MP4
        needs ffmpeg, on the machine or by ``pip install "camopt[video]"``.

    Returns
    -------
    Animation
        The animation, which a notebook shows; ``svg`` is the text of the SVG file.

    Raises
    ------
    BadInput
        If the file's name does not end in .svg, .gif or .mp4, or if there is no ffmpeg for an MP4.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> animation = camopt.animate(camopt.find_scene("two-pauses"), "turning.svg")
    """
    if isinstance(scene, (str, os.PathLike)):
        scene = find_machine(scene) if is_machine(os.fsdecode(scene)) else scene_from(scene)
    if isinstance(scene, Machine):
        animated = import_module("camopt.show.machines.animated_machine").animated_machine_figure(scene)
    else:
        animated = animated_scene_figure(scene_from(scene))
    suffix = None if path is None else checked_suffix(path, "path", ANIMATION_KINDS)
    if suffix == ".mp4":
        find_ffmpeg()  # raises BadInput before the work if there is none
    with animated as stage:
        animation = Animation(scene.name, animated_svg(stage))
        if path is not None and suffix is not None:
            with atomically_written_file(path) as partial:
                if suffix == ".svg":
                    partial.write_text(animation.svg, encoding="utf-8", newline="\n")
                else:
                    (write_gif if suffix == ".gif" else write_mp4)(stage, partial)
    return animation


@contextmanager
def animated_scene_figure(scene: Scene) -> Iterator[AnimatedFigure]:
    """The figure of a cam under its follower, drawn at cam angle 0, with its moving parts."""
    picture = Picture(scene, resolve_design(scene))
    with new_figure(None, GROOVE_SIZE if picture.is_developed else DISC_SIZE) as figure:
        yield draw_animated_figure(figure, picture)


NAMESPACE = "http://www.w3.org/2000/svg"
POINTS_PER_INCH = 72.0  # the unit of the file is a point
PAGES_AROUND = 2.0  # page widths drawn on each side: their lines may move onto the page
TEXT_ABOVE, TEXT_BELOW, TEXT_LEFT = 9.0, 3.0, 120.0  # points of the window of a text, from its foot and end
READING_STEP = 24.0  # points from one text of a column to the next

Element = ElementTree.Element


def animated_svg(animated_figure: AnimatedFigure) -> str:
    """The text of the SVG file."""
    from matplotlib.transforms import Bbox

    figure, bodies, readings = animated_figure
    for place, body in enumerate(bodies):
        body.axes.set_gid(f"body-{place}")
    for place, reading in enumerate(readings):
        reading.text.set_gid(f"reading-{place}")
    width, height = figure.get_size_inches()
    # the page is wide, since matplotlib drops lines outside of it
    wide = Bbox.from_bounds(-PAGES_AROUND * width, 0.0, (1.0 + 2.0 * PAGES_AROUND) * width, height)
    file = StringIO()
    figure.savefig(file, format="svg", metadata={"Date": None}, bbox_inches=wide)
    ElementTree.register_namespace("", NAMESPACE)
    ElementTree.register_namespace("xlink", "http://www.w3.org/1999/xlink")
    root = ElementTree.fromstring(file.getvalue())
    width, height = width * POINTS_PER_INCH, height * POINTS_PER_INCH
    view = f"{PAGES_AROUND * width:g} 0 {width:g} {height:g}"
    root.attrib.update(viewBox=view, width=f"{width:g}pt", height=f"{height:g}pt")
    groups = {group.get("id"): group for group in root.iter(f"{{{NAMESPACE}}}g")}
    for place, body in enumerate(bodies):
        group = groups[f"body-{place}"]
        for kind, values in _svg_transforms(body, figure).items():
            if len(set(values)) > 1:
                inner = _wrap_content_in_group(group)
                if body.drawn_at is not None:
                    inner.set("transform", f"{kind}({values[0]})")  # for programs without SMIL
                _animate_transform(inner, kind, values, "linear")
        if body.windowed:
            _clip_group(group, _axes_box_in_file(body.axes, figure))
    for place, reading in enumerate(readings):
        _animate_reading(groups[f"reading-{place}"], reading)
    return ElementTree.tostring(root, encoding="unicode")


def _animate_reading(group: Element, reading: Reading) -> None:
    """Show one text after the other: a column of texts jumps past a window one line high."""
    (first,) = group.iter(f"{{{NAMESPACE}}}text")
    x, y = (float(first.get(key, "0")) for key in "xy")
    column = _wrap_content_in_group(group)
    first.attrib.pop("transform", None)
    for place, words in enumerate(reading.values[1:FRAMES], start=1):
        text = ElementTree.SubElement(column, f"{{{NAMESPACE}}}text", first.attrib)
        text.set("y", f"{y + place * READING_STEP:.6g}")
        text.text = words
    _animate_transform(
        column, "translate", [f"0 {-place * READING_STEP:.6g}" for place in range(FRAMES)], "discrete"
    )
    _clip_group(group, (x - TEXT_LEFT, y - TEXT_ABOVE, TEXT_LEFT, TEXT_ABOVE + TEXT_BELOW))


def _wrap_content_in_group(group: Element) -> Element:
    """Move the content of a group into a new inner group; return the inner group."""
    inner = ElementTree.Element(f"{{{NAMESPACE}}}g")
    inner.extend(group)
    group[:] = [inner]
    return inner


def _animate_transform(element: Element, kind: str, values: list[str], mode: str) -> None:
    """Animate the transform of an element over one turn, repeated for ever."""
    ElementTree.SubElement(
        element,
        f"{{{NAMESPACE}}}animateTransform",
        attributeName="transform",
        type=kind,
        values=";".join(values),
        calcMode=mode,
        dur=f"{TURN_TIME:g}s",
        repeatCount="indefinite",
    )


def _clip_group(group: Element, window: tuple[float, float, float, float]) -> None:
    """Show only the part of a group within a rectangle: left, top, width, height."""
    name = f"{group.get('id')}-window"
    clip = ElementTree.Element(f"{{{NAMESPACE}}}clipPath", id=name)
    sides = dict(zip(("x", "y", "width", "height"), (f"{side:.6g}" for side in window), strict=True))
    ElementTree.SubElement(clip, f"{{{NAMESPACE}}}rect", sides)
    group.insert(0, clip)
    group.set("clip-path", f"url(#{name})")


def _axes_box_in_file(axes: Any, figure: Any) -> tuple[float, float, float, float]:
    """The box of axes in the file: left, top, width, height [points]."""
    box, (width, height) = axes.get_position(), figure.get_size_inches() * POINTS_PER_INCH
    return (PAGES_AROUND + box.x0) * width, (1.0 - box.y1) * height, box.width * width, box.height * height


def _svg_transforms(body: MovingBody, figure: Any) -> dict[str, list[str]]:
    """SVG transforms of a body at all frames, in their order.

    Numbers have six digits: a thousandth of a point or of a degree.
    """
    left, top, width, height = _axes_box_in_file(body.axes, figure)
    (x0, x1), (y0, y1) = body.axes.get_xlim(), body.axes.get_ylim()
    points = np.array([body.origin, 0j, *(body.path - body.origin)])
    across, up = (points.real - x0) / (x1 - x0), (points.imag - y0) / (y1 - y0)
    (x, y), zero, *places = np.column_stack([left + across * width, top + (1.0 - up) * height])
    return {
        "rotate": [f"{-angle:.6g} {x:.6g} {y:.6g}" for angle in np.degrees(body.angles)],
        "translate": [f"{right:.6g} {down:.6g}" for right, down in np.array(places) - zero],
    }
