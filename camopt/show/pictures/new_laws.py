"""The picture of a synthesis: the cams of the best known law and of free laws at one scale, and their motions."""

from typing import Any

import numpy as np

from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.effects.motion import motion_table_unit, motion_unit_factor
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.problem.problem import resolve
from camopt.show.drawing.cam import draw_disc
from camopt.show.drawing.diagrams import draw_condition_mark, short_number_factor_and_unit
from camopt.show.drawing.groove import draw_groove
from camopt.show.drawing.labels import place_labels
from camopt.show.drawing.panels import move_condition_marks
from camopt.show.drawing.picture import Picture, value_with_unit
from camopt.show.drawing.style import COLOURS, MUTED, PAGE_TITLE, TITLE_SIZE, Figure, Target, add_grid, new_figure
from camopt.solve.synthesis.known_law_cams import KnownLawCams, build_known_law_cams
from camopt.solve.synthesis.result_sentences import OWN_MOVES
from camopt.solve.synthesis.synthesis_result import Synthesis
from camopt.solve.tables.designs import joined_laws

KNOWN_COLOUR, NEW_COLOUR = MUTED, COLOURS[RISE]
CURVES = ("displacement", "velocity", "acceleration", "jerk")


def draw(result: Synthesis, path: Target = None, known: KnownLawCams | None = None) -> "Figure":
    """Draw the cam of free laws beside the cam of the best known law within the same limits, if any."""
    known = known or build_known_law_cams(result.asked)
    with new_figure(path, (15.5, 9.0)) as figure:
        drawn = {}
        if known.best is not None:
            own = "moves of the scene" if known.best == OWN_MOVES else "law of the scene"
            best = known.rows[known.best].scene
            drawn[own if known.best == known.own_law else "best known law"] = Picture(best, resolve(best))
        drawn["free laws"] = Picture(result.scene, resolve(result.scene))
        figure.text(0.03, 0.955, result.asked.name, fontsize=PAGE_TITLE, fontweight="bold")
        words = [] if known.best is not None else ["no known law meets all limits"]
        if known.own_law is None:
            words.append("nor does the law of the scene" if words else "no feasible cam with the law of the scene")
        elif known.own_law != known.best:
            row, body = known.rows[known.own_law], known.scene.mechanism.body
            size = f"{body.size_name} {value_with_unit(row[body.size_quantity])}"
            fault = "" if row["within"] else ", which breaks limits on the motion"
            words.append(f"law of the scene, {known.own_law}: {size}{fault}")
        figure.text(0.03, 0.93, "  ·  ".join(words), fontsize=TITLE_SIZE - 1.0, color=MUTED)
        _draw_cams(figure, drawn)
        _draw_motions(figure, list(drawn.values()))
    return figure


def _draw_cams(figure: Any, pictures: dict[str, Picture]) -> None:
    """Draw the cams at one scale: discs side by side, developed grooves one above the other."""
    body = next(iter(pictures.values())).problem.setup.mechanism.body
    beside = [(0.03, 0.06, 0.27, 0.80), (0.31, 0.06, 0.27, 0.80)]
    above = [(0.07, 0.52, 0.51, 0.34), (0.07, 0.08, 0.51, 0.34)]
    places = (above if body.developed else beside)[: len(pictures)]
    axes, labels = [figure.add_axes(place) for place in places], []
    for ax, picture in zip(axes, pictures.values(), strict=True):
        labels += (draw_groove if body.developed else draw_disc)(ax, picture)
        if body.developed:  # a developed surface is far wider than high
            low, high = ax.dataLim.intervaly
            ax.set_ylim(low - 0.15 * (high - low), high + 0.15 * (high - low))
    limits = np.array([[*ax.get_xlim(), *ax.get_ylim()] for ax in axes])
    lowest = int(limits[:, 2].argmin())
    for each, (ax, place, (word, picture)) in enumerate(zip(axes, places, pictures.items(), strict=True)):
        ax.set_position(place)
        ax.set(xlim=(limits[:, 0].min(), limits[:, 1].max()), ylim=(limits[:, 2].min(), limits[:, 3].max()))
        ax.set_aspect("equal", anchor="NW")
        size = f"{body.size_name} {value_with_unit(float(picture.problem.design.size[0]))}"
        title = ": ".join(filter(None, (word, "" if word == "free laws" else _law_names_of_picture(picture))))
        ax.set_title(
            f"{title}\n{size}",
            loc="left",
            fontsize=TITLE_SIZE,
            color=NEW_COLOUR if word == "free laws" else KNOWN_COLOUR,
        )
        if not body.developed and each != lowest:  # one scale bar for both
            ax.lines[-1].remove()
            ax.texts[-1].remove()
    place_labels(figure, labels)


def _law_names_of_picture(picture: Picture) -> str:
    """The laws of a picture, rises first."""
    programme = picture.problem.programme
    return joined_laws(programme.law_names(RISE), programme.law_names(RETURN))


def _draw_motions(figure: Any, pictures: list[Picture]) -> None:
    """Draw displacement to jerk of the tool over the turn: known laws grey, free laws in colour."""
    setup = pictures[-1].problem.setup
    pens = [{"color": KNOWN_COLOUR, "lw": 1.2}, {"color": NEW_COLOUR, "lw": 1.7}][-len(pictures) :]
    for order, name in enumerate(CURVES):
        ax = figure.add_axes((0.655, 0.71 - 0.215 * order, 0.325, 0.175))
        unit = motion_table_unit(setup, order)
        per, unit = to_shown_unit(motion_unit_factor(setup, order), unit), unit_in_shown_system(unit)
        factor, unit = short_number_factor_and_unit(
            [per * m[order] for picture in pictures for m in picture.tool_motion], unit
        )
        words = ["moves of the scene", "free moves"][-len(pictures) :]
        for picture, pen, word in zip(pictures, pens, words, strict=True):
            angles = np.concatenate([*(np.append(a, np.nan) for a in picture.angles_of_pieces)])
            values = np.concatenate([*(np.append(m[order] * per * factor, np.nan) for m in picture.tool_motion)])
            ax.plot(np.degrees(angles), values, label=_law_names_of_picture(picture) or word, **pen)
        for mark in move_condition_marks(pictures[-1], order, per):
            draw_condition_mark(ax, mark, factor)
        ax.set_title(f"{name.capitalize()}, {unit}", loc="left")
        ax.set(xlim=(0, 360), xticks=range(0, 361, 60))
        ax.tick_params(labelbottom=order == 3)
        add_grid(ax)
        if order == 0:
            ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2)
    ax.set_xlabel("cam angle, deg")
