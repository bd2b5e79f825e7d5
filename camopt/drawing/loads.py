"""Diagrams of the loads that a scene calls for: force along the motion, side thrust, contact stress."""

from collections.abc import Callable
from functools import partial
from math import isfinite
from typing import Any

import numpy as np

from camopt.drawing.panels import Panel, Peak, Values, extremes
from camopt.drawing.picture import Picture, number
from camopt.effects import hertz, thrust
from camopt.effects.loads import Variant, force_curve, sides
from camopt.quantities import QUANTITIES


def load_panels(picture: Picture) -> list[Panel]:
    """A diagram for each effect on loads that ran, and finite values to show."""
    found = [_force(picture), _thrust(picture), _stress(picture)]
    return [panel for panel in found if panel is not None]


def _ran(picture: Picture, *names: str) -> bool:
    """Whether quantities were computed, and are finite."""
    return all(isfinite(picture.values.get(name, np.inf)) for name in names)


def _force(picture: Picture) -> Panel | None:
    ends = ("contact_force_max_N", "contact_force_min_N")
    if not _ran(picture, *ends):
        return None
    question = picture.question
    values = picture.curve_values(force_curve(question.subject, question.design, question.programme))
    panel = Panel("Force along the motion", "N", values)
    panel.peaks = extremes(picture, values, tuple(picture.values[name] for name in ends))
    panel.note = "contact is lost below 0"
    bound = question.scene.limits.contact_force_min
    panel.limits = [] if bound is None else [(0, bound)]
    return panel


def _thrust(picture: Picture) -> Panel | None:
    subject = picture.question.subject
    if not _ran(picture, "side_thrust_max_N"):
        return None
    make = partial(thrust.thrust_curve, subject, arm=1.0, reach=0.0)
    variants: list[Variant] = [(partial(make, side=side), kinds) for side, kinds in sides(subject)]
    return _largest(picture, "Side thrust", "side_thrust_max_N", variants, lambda value: value)


def _stress(picture: Picture) -> Panel | None:
    if not _ran(picture, "contact_stress_max_MPa"):
        return None
    subject = picture.question.subject
    variants = [variant for *_, variant in hertz.variants(subject)]

    def stress(load: Any) -> Any:
        return hertz.stress_of(subject, np.maximum(load, 0.0))

    return _largest(picture, "Contact stress", "contact_stress_max_MPa", variants, stress)


def _largest(picture: Picture, title: str, name: str, variants: list[Variant], of: Callable[[Any], Any]) -> Panel:
    """The largest of a load's variants over each piece of the turn, its peak and its limit."""
    question = picture.question
    each = [(picture.curve_values(make(question.design, question.programme)), kinds) for make, kinds in variants]
    values: Values = []
    for k, kind in enumerate(picture.kinds):
        here = np.array([curves[k] for curves, kinds in each if kinds & kind])
        values.append(of(np.take_along_axis(here, np.abs(here).argmax(axis=0)[None], axis=0)[0]))
    every, angles = np.concatenate(values), np.concatenate(picture.pieces)
    at = int(np.abs(every).argmax())
    exact = float(np.copysign(picture.values[name], every[at]))
    panel = Panel(title, QUANTITIES[name].unit, values, [Peak(float(np.degrees(angles[at])), exact, number(exact))])
    bound = getattr(question.scene.limits, name.split("_max_")[0])
    panel.limits = [] if bound is None else [(0, bound)]
    return panel
