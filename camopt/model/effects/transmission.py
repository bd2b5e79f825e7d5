"""Transmission angle: the least angle at which the couplers of a train drive, over the turn.

It is the acute angle between a coupler and the rocker or crank that it turns, or between a coupler and the line
square to the motion of the slide that it moves. At 90° the coupler drives best, at 0° not at all; usual practice is
at least 40°, or 45° at high speed.

The angle depends only on the position of the train. It is least at an end of the travel, or between the ends where
its cosine is stationary: with the crank of a four-bar linkage on the line of pivots; with the crank of a
slider-crank square to the slide's motion; or, driven by the slide, with the slide abreast of the pivot.

Source: Norton, Design of Machinery, ch. 3 and 4 (transmission angle).
"""

from functools import partial
from typing import Any

import numpy as np

from camopt.core.numerics import LEAST, Number
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.peak import DegreeScale, TrainMotion, TrainPeak
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.tool_drive import tool_travel_range

LEAST_ANGLE = "transmission_angle_min_deg"
ANGLE_ROUNDING = 1e-12  # of the angle: rounding of the positions of joints


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    assert case.setup.train is not None
    least = np.degrees(case.setup.train.least_transmission_angle_over_travel(*tool_travel_range(case.programme)))
    return {LEAST_ANGLE: EnclosedValue(least, -ANGLE_ROUNDING * least, least)}


def train_peaks(setup: Setup) -> dict[str, TrainPeak]:
    links = () if setup.train is None else setup.train.links
    curves = tuple(
        partial(_coupler_transmission_angle, link=k)
        for k, link in enumerate(links)
        if link.couplers_by_driving_side[0]
    )
    return {LEAST_ANGLE: TrainPeak(curves, LEAST, DegreeScale(1))}


def _coupler_transmission_angle(designs: Designs, motion: TrainMotion, link: int) -> Number:
    return motion.transmission_angle(link)


EFFECT = Effect(
    "transmission",
    lambda setup: (LEAST_ANGLE,) if setup.train is not None and setup.train.has_couplers else (),
    evaluate_columns,
    is_of_motion=lambda setup: True,
    train_peaks=train_peaks,
)
