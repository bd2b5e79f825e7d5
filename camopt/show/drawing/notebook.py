"""HTML of results for notebooks: their tables, with a small picture of the cam.

The picture is the profile to scale, as SVG, made without matplotlib.
"""

from collections.abc import Iterable
from dataclasses import replace
from html import escape
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput
from camopt.core.numerics import ComplexArray
from camopt.core.quantities.display import HasHtml
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.show.drawing.picture import Picture, value_with_unit
from camopt.show.drawing.second_contact import second_disc_outline
from camopt.show.drawing.style import COLOURS, FILL, INK, MUTED, SECOND_COLOUR
from camopt.solve.tables.html import html_section, html_table
from camopt.solve.tables.result import Result, Table

CAM_PIXELS, MARGIN_PIXELS, TEXT_PIXELS = 180.0, 4.0, 16.0  # longer side of the cam, margin, line of text below
NEAR_PIXELS = 2.0  # pixels; closer points are left out


def result_html(result: HasHtml) -> str:
    """HTML of a result: its tables and sentences, and its cam on the right if it has one."""
    text = _sections_html(result) if isinstance(result, Result) else _scene_html(result)
    try:
        cam = cam_profile_svg(result.shown_cam) if result.shown_cam else ""
    except BadInput:  # sizes that no scene allows: show the table without a cam
        cam = ""
    return f'<div style="display: flex; flex-wrap: wrap; gap: 2em">{text}{cam}</div>' if cam else text


def _sections_html(result: Result) -> str:
    """HTML of the tables and sentences of a result under its name."""
    text, *rest = repr(result), *filter(None, result.sections())
    name = text[1:-1] if text.startswith("<") else type(result).__name__
    if rest and isinstance(rest[0], Table):
        first, *rest = rest
        head = html_table(replace(first, title=name))
    else:
        head = f"<b>{escape(name)}</b>"
    return f"<div>{head}{''.join(map(html_section, rest))}</div>"


def _scene_html(scene: Any) -> str:
    """HTML of a scene: its description, and its TOML to unfold."""
    unfolded = f"<details><summary>TOML</summary><pre>{escape(scene.to_toml())}</pre></details>"
    return f"<div><b>{escape(repr(scene))}</b>{unfolded}</div>"


def cam_profile_svg(scene: Scene) -> str:
    """SVG of the profile of a disc cam with its base circle, or of a developed groove; "" if there is no cam."""
    picture = Picture(scene, resolve_design(scene))
    if not picture.can_assemble:
        return ""
    body = picture.problem.setup.mechanism.body
    first, *others = [[curves.profile for curves in each.curves] for each in picture.first_disc_contacts]
    sides = [np.concatenate(rows) for rows in zip(first, *others, strict=True)]
    size = float(picture.problem.design.size[0])
    circle = np.zeros(0, dtype=complex) if body.developed else size * np.exp(2j * np.pi * np.linspace(0.0, 1.0, 61))
    second = second_disc_outline(picture)
    every = np.concatenate([circle, second, *(side for piece in sides for side in piece)])
    if not np.isfinite(every).all():
        return ""
    corner = complex(every.real.min(), every.imag.max())
    extent = np.array([np.ptp(every.real), np.ptp(every.imag)])
    scale = CAM_PIXELS / extent.max()

    def svg_path_in_picture(points: Any, **style: object) -> str:
        return _svg_path((points - corner).conj() * scale, **style)

    drawn = []
    if not body.developed:
        drawn = [
            svg_path_in_picture(np.concatenate([s[0] for s in sides]), fill=FILL),
            svg_path_in_picture(circle, stroke=MUTED),
        ]
    for kind, piece in zip(picture.stroke_kind_of_each_piece, sides, strict=True):
        drawn += [svg_path_in_picture(side, stroke=COLOURS[kind], stroke_width=2) for side in piece]
    drawn += [svg_path_in_picture(second, stroke=SECOND_COLOUR, stroke_width=1.5)] if second.size else []
    cross = 0.06 * size * np.array([-1, 1], dtype=complex)
    drawn += (
        []
        if body.developed
        else [svg_path_in_picture(cross, stroke=INK), svg_path_in_picture(1j * cross, stroke=INK)]
    )
    return _svg_picture_with_caption(drawn, scale * extent, f"{body.size_name} {value_with_unit(size)}", scene.name)


def _svg_path(points: ComplexArray, **style: object) -> str:
    """An SVG path through points [pixels], y downwards; points near to their predecessor are left out."""
    kept = [points[0]]
    for point in points[1:-1]:
        if abs(point - kept[-1]) > NEAR_PIXELS:
            kept.append(point)
    places = "L".join(f"{p.real:.1f},{p.imag:.1f}" for p in (*kept, points[-1]))
    pens = " ".join(f'{name.replace("_", "-")}="{value}"' for name, value in {"fill": "none", **style}.items())
    return f'<path d="M{places}" {pens}/>'


def _svg_picture_with_caption(elements: Iterable[str], extent: Iterable[float], caption: str, title: str) -> str:
    """An SVG picture of elements, with a line of text below."""
    width, height = (side + 2.0 * MARGIN_PIXELS for side in extent)
    box = f"{-MARGIN_PIXELS} {-MARGIN_PIXELS} {width:.1f} {height + TEXT_PIXELS:.1f}"
    foot = height + 0.7 * TEXT_PIXELS - MARGIN_PIXELS
    text = f'<text y="{foot:.1f}" font-size="11" fill="{INK}">{escape(caption)}</text>'
    size = f'width="{max(width, CAM_PIXELS):.0f}" height="{height + TEXT_PIXELS:.0f}" font-family="sans-serif"'
    opening = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" {size}><title>{escape(title)}</title>'
    return opening + "".join(elements) + text + "</svg>"
