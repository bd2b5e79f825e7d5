"""HTML of results for notebooks: their tables, with a small picture of the cam.

The picture is the profile to scale, as SVG, made without matplotlib.
"""

from dataclasses import replace
from functools import partial
from html import escape
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput
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
    """HTML of a result: its tables and sentences under its name, and its cam on the right if it has one.

    A scene has its description, and its TOML to unfold.
    """
    if isinstance(result, Result):
        words, *rest = repr(result), *filter(None, result.sections())
        name = words[1:-1] if words.startswith("<") else type(result).__name__
        if rest and isinstance(rest[0], Table):
            first, *rest = rest
            head = html_table(replace(first, title=name))
        else:
            head = f"<b>{escape(name)}</b>"
        text = f"<div>{head}{''.join(map(html_section, rest))}</div>"
    else:
        scene: Any = result
        unfolded = f"<details><summary>TOML</summary><pre>{escape(scene.to_toml())}</pre></details>"
        text = f"<div><b>{escape(repr(scene))}</b>{unfolded}</div>"
    try:
        cam = cam_profile_svg(result.shown_cam) if result.shown_cam else ""
    except BadInput:  # sizes that no scene allows: show the table without a cam
        cam = ""
    return f'<div style="display: flex; flex-wrap: wrap; gap: 2em">{text}{cam}</div>' if cam else text


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

    svg_path = partial(_svg_path, corner, scale)
    drawn = []
    if not body.developed:
        drawn = [
            svg_path(np.concatenate([s[0] for s in sides]), fill=FILL),
            svg_path(circle, stroke=MUTED),
        ]
    for kind, piece in zip(picture.stroke_kind_of_each_piece, sides, strict=True):
        drawn += [svg_path(side, stroke=COLOURS[kind], stroke_width=2) for side in piece]
    drawn += [svg_path(second, stroke=SECOND_COLOUR, stroke_width=1.5)] if second.size else []
    cross = 0.06 * size * np.array([-1, 1], dtype=complex)
    drawn += [] if body.developed else [svg_path(cross, stroke=INK), svg_path(1j * cross, stroke=INK)]
    width, height = scale * extent + 2.0 * MARGIN_PIXELS
    box = f"{-MARGIN_PIXELS} {-MARGIN_PIXELS} {width:.1f} {height + TEXT_PIXELS:.1f}"
    foot, caption = height + 0.7 * TEXT_PIXELS - MARGIN_PIXELS, escape(f"{body.size_name} {value_with_unit(size)}")
    text = f'<text y="{foot:.1f}" font-size="11" fill="{INK}">{caption}</text>'
    outer = f'width="{max(width, CAM_PIXELS):.0f}" height="{height + TEXT_PIXELS:.0f}" font-family="sans-serif"'
    opening = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" {outer}><title>{escape(scene.name)}</title>'
    return opening + "".join(drawn) + text + "</svg>"


def _svg_path(corner: complex, scale: float, points: Any, **style: object) -> str:
    """An SVG path through points, given in mm; points near to their predecessor are left out.

    The corner is the upper left one of the picture [mm], the scale in pixels per mm.
    """
    points = (points - corner).conj() * scale
    kept = [points[0]]
    for point in points[1:-1]:
        if abs(point - kept[-1]) > NEAR_PIXELS:
            kept.append(point)
    places = "L".join(f"{p.real:.1f},{p.imag:.1f}" for p in (*kept, points[-1]))
    pens = " ".join(f'{name.replace("_", "-")}="{value}"' for name, value in {"fill": "none", **style}.items())
    return f'<path d="M{places}" {pens}/>'
