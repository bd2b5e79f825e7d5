"""Ribs of cylindrical cams: random scenes, and where both rollers of a follower are, as of one rigid body."""

from typing import Any

import numpy as np

from camopt.contour.curve import curves_of
from camopt.problem.problem import Problem
from support.pairs import turn


def rib(rng: np.random.Generator, motion: str) -> dict[str, Any]:
    """A cylindrical cam with a rib between two rollers."""
    swings = motion == "oscillating"
    own = {"arm_length": float(rng.uniform(90, 140))} if swings else {}
    return {
        "cam": {
            "form": "cylindrical",
            "mean_radius": float(rng.uniform(60, 90)),
            "rotation": str(rng.choice(["cw", "ccw"])),
            "rpm": 300,
        },
        "follower": {
            "motion": motion,
            "contact": "roller",
            "roller_radius": float(rng.uniform(6, 11)),
            "roller_spacing": float(rng.uniform(34, 50)),
            **own,
        },
        "drive": {"kind": "rib"},
        "motion": turn(rng, float(rng.uniform(10, 20))),
    }


def centres(problem: Problem, angles: Any) -> tuple[Any, Any]:
    """The centres of both rollers over the developed mantle, as points x + iy."""
    design, (y, *_), lift = problem.design, problem.programme.at(angles), problem.programme.lift
    d, x = design.roller_spacing[0], angles * design.size[0]
    if not problem.setup.angular:
        return x + 1j * (y + d / 2), x + 1j * (y - d / 2)
    l, sense = design.arm_length[0], design.sense  # noqa: E741
    pivot, half = x + sense * l * np.cos(lift / 2), np.arcsin(d / (2 * l))
    arms = (y - lift / 2 + half, y - lift / 2 - half)
    one, other = (pivot - sense * l * np.cos(a) + 1j * l * np.sin(a) for a in arms)
    return one, other


def flanks(problem: Problem, angles: Any) -> tuple[Any, Any]:
    """The flanks over the developed mantle, as the files of the cam have them, over more than one turn."""
    found, round_ = curves_of(problem), 2.0 * np.pi * problem.design.size[0]
    turns, within = np.divmod(angles, 2.0 * np.pi)
    one, other = (
        found[name].at(within, found[name].points) + turns * round_ for name in ("profile", "second_profile")
    )
    return one, other
