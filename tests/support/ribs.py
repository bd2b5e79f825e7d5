"""Ribs of cylinders and discs: random scenes, and where both rollers of a follower are, as of one rigid body."""

from typing import Any, NamedTuple

import numpy as np

from camopt.scene.problem.problem import Problem
from camopt.solve.contour.curve import disc_curves
from support.pairs import turn


class Roller(NamedTuple):
    """Where a roller is in the frame of the cam's curves, at cam angles."""

    centre: Any
    way: Any
    """The direction in which the follower moves it, of length 1."""


def rib(rng: np.random.Generator, motion: str, form: str = "cylindrical") -> dict[str, Any]:
    """A cam with a rib between two rollers."""
    swings, disc = motion == "oscillating", form == "disc"
    own = {"arm_length": float(rng.uniform(90, 140))} if swings else {}
    size = "base_radius" if disc else "mean_radius"
    cam = {
        "form": form,
        size: float(rng.uniform(60, 90)),
        "rotation": str(rng.choice(["cw", "ccw"])),
        "rpm": 300,
    }
    follower = {
        "motion": motion,
        "contact": "roller",
        "roller_radius": float(rng.uniform(6, 11)),
        "roller_spacing": float(rng.uniform(34, 50)),
        **own,
    }
    if disc:
        follower |= (
            {"centre_distance": own["arm_length"] * float(rng.uniform(0.95, 1.05))}
            if swings
            else {"offset": float(rng.uniform(-12, 12))}
        )
    return {
        "cam": cam,
        "follower": follower,
        "drive": {"kind": "rib"},
        "motion": turn(rng, float(rng.uniform(10, 20))),
    }


def rollers(problem: Problem, angles: Any) -> tuple[Roller, Roller]:
    """Both rollers, over the developed mantle or over the disc, as points x + iy."""
    on = _on_mantle if problem.setup.mechanism.body.developed else _on_disc
    one, other = on(problem, angles)
    return one, other


def centres(problem: Problem, angles: Any) -> tuple[Any, Any]:
    """The centres of both rollers."""
    one, other = rollers(problem, angles)
    return one.centre, other.centre


def _on_mantle(problem: Problem, angles: Any) -> list[Roller]:
    design, (y, *_), lift = problem.design, problem.programme.motion_at(angles), problem.programme.lift
    d, x = design.roller_spacing[0], angles * design.size[0]
    if not problem.setup.angular:
        return [Roller(x + 1j * (y + side * d / 2), 1j * np.ones_like(x)) for side in (1.0, -1.0)]
    l, sense = design.arm_length[0], design.sense  # noqa: E741
    pivot, half = x + sense * l * np.cos(lift / 2), np.arcsin(d / (2 * l))
    arms = (l * (-sense * np.cos(a) + 1j * np.sin(a)) for a in (y - lift / 2 + half, y - lift / 2 - half))
    return [Roller(pivot + arm, -1j * sense * arm / l) for arm in arms]


def _on_disc(problem: Problem, angles: Any) -> list[Roller]:
    design, (y, *_) = problem.design, problem.programme.motion_at(angles)
    d, prime = design.roller_spacing[0], design.size[0] + design.roller_radius[0]
    turned = np.exp(-1j * design.sense * angles)
    if not problem.setup.angular:
        e = design.offset[0]
        high = np.sqrt(prime**2 - e**2) + y
        return [Roller(turned * (e + 1j * s), turned * 1j) for s in (high, high - d)]
    c, l = design.centre_distance[0], design.arm_length[0]  # noqa: E741
    psi = np.arccos((c**2 + l**2 - prime**2) / (2 * c * l)) + y
    arms = (l * np.exp(1j * (np.pi - a)) for a in (psi, psi - 2 * np.arcsin(d / (2 * l))))
    return [Roller(turned * (c + arm), turned * -1j * arm / l) for arm in arms]


def flanks(problem: Problem, angles: Any) -> tuple[Any, Any]:
    """The flanks, as the files of the cam have them, over more than one turn."""
    mantle = problem.setup.mechanism.body.developed
    found, round_ = disc_curves(problem), 2.0 * np.pi * problem.design.size[0] if mantle else 0.0
    turns, within = np.divmod(angles, 2.0 * np.pi)
    one, other = (
        found[name].evaluate_by_span(within, found[name].points) + turns * round_
        for name in ("profile", "second_profile")
    )
    return one, other
