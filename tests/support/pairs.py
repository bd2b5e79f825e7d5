"""Pairs of contacts: random scenes, and where both contacts of a follower are as of one rigid body."""

from typing import Any

import numpy as np

from camopt.model.mechanisms.geometry import profile_points
from camopt.scene.problem.problem import Problem

LAWS = ("cycloidal", "poly345", "modified-sine", "modified-trapezoid", "harmonic", "poly4567")


def turn(rng: np.random.Generator, lift: float) -> list[dict[str, Any]]:
    """A rise, a dwell, a return and a dwell of random angles and laws."""
    rise, top, fall = 10.0 * rng.integers(8, 15), 10.0 * rng.integers(1, 6), 10.0 * rng.integers(8, 15)
    moving = [{"lift": lift, "law": str(rng.choice(LAWS))} for _ in range(2)]
    return [
        {"segment": "rise", "angle": rise, **moving[0]},
        {"segment": "dwell", "angle": top},
        {"segment": "return", "angle": fall, **moving[1]},
        {"segment": "dwell", "angle": 360.0 - rise - top - fall},
    ]


def halves(rng: np.random.Generator, lift: float) -> list[dict[str, Any]]:
    """A turn whose second half is the first with rises and returns exchanged."""
    angle, moving = 10.0 * rng.integers(9, 19), {"lift": lift, "law": str(rng.choice(LAWS))}
    rest = [{"segment": "dwell", "angle": 180.0 - angle}] if angle < 180.0 else []
    return [
        {"segment": "rise", "angle": angle, **moving},
        *rest,
        {"segment": "return", "angle": angle, **moving},
        *rest,
    ]


def pair(rng: np.random.Generator, motion: str) -> dict[str, Any]:
    """A conjugate pair with sizes of its own for the second disc."""
    swings = motion == "oscillating"
    own = {"arm_length": float(rng.uniform(65, 85))} if swings else {"offset": float(rng.uniform(-9, 9))}
    first = (
        {"arm_length": float(rng.uniform(70, 90)), "centre_distance": float(rng.uniform(90, 110))}
        if swings
        else {"offset": float(rng.uniform(-9, 9))}
    )
    return {
        "cam": {
            "form": "disc",
            "base_radius": float(rng.uniform(38, 55)),
            "rotation": str(rng.choice(["cw", "ccw"])),
            "rpm": 300,
        },
        "follower": {"motion": motion, "contact": "roller", "roller_radius": float(rng.uniform(6, 11)), **first},
        "drive": {
            "kind": "conjugate",
            "base_radius": float(rng.uniform(38, 55)),
            "roller_radius": float(rng.uniform(6, 11)),
            **own,
        },
        "motion": turn(rng, float(rng.uniform(8, 20))),
    }


def yoke(rng: np.random.Generator, kind: str) -> dict[str, Any]:
    """A yoke on one disc."""
    tip = {"contact": "flat"} if kind == "breadth" else {"contact": "roller", "roller_radius": 8.0}
    base, rotation = float(rng.uniform(45, 70)), str(rng.choice(["cw", "ccw"]))
    return {
        "cam": {"form": "disc", "base_radius": base, "rotation": rotation, "rpm": 300},
        "follower": {"motion": "translating", **tip},
        "drive": {"kind": kind},
        "motion": halves(rng, float(rng.uniform(5, 15))),
    }


def centres(problem: Problem, angles: Any) -> tuple[Any, Any]:
    """The centres of both rollers of one rigid follower in the ground frame."""
    first, second = problem.design, problem.setup.mechanism.further_contacts[0].local_designs(problem.design)
    (e1, rp1, l1), (e2, rp2, l2) = (
        (d.offset[0], d.size[0] + d.roller_radius[0], d.arm_length[0]) for d in (first, second)
    )
    lift, y = problem.programme.lift, problem.programme.motion_at(angles)[0]
    if not problem.setup.angular:
        s1, s2 = np.sqrt(rp1**2 - e1**2), np.sqrt(rp2**2 - e2**2)
        one = e1 + 1j * (s1 + y)
        return one, one + (e2 - e1) - 1j * (s1 + s2 + lift)
    c = first.centre_distance[0]
    starts = [np.arccos((c**2 + l**2 - r**2) / (2 * c * l)) for l, r in ((l1, rp1), (l2, rp2))]  # noqa: E741
    arm = np.exp(-1j * (starts[0] + y))
    return c - l1 * arm, c - l2 * arm * np.exp(1j * (sum(starts) + lift))


def profiles(problem: Problem, angles: Any) -> tuple[Any, Any]:
    """The profiles of both discs in the frame of the cam."""
    (contact,) = problem.setup.mechanism.further_contacts
    mirrored = profile_points(contact.mechanism, contact.local_designs(problem.design), problem.programme, angles)
    return profile_points(problem.setup.mechanism, problem.design, problem.programme, angles), mirrored.conj()


def nearest_points(problem: Problem, which: int, angles: Any) -> tuple[Any, Any]:
    """Of one disc the points that are nearest to its roller at cam angles, in the ground frame, and the distances.

    Over the whole profile, then closer and closer to the nearest point.
    """
    turned = np.exp(-1j * problem.design.sense * angles)[:, None]
    turned = turned.conj()  # of the cam against the ground
    centre = centres(problem, angles)[which][:, None]
    every = np.linspace(0.0, 2.0 * np.pi, 1441)[:-1]
    points = turned * profiles(problem, every)[which]
    at, step = every[np.abs(points - centre).argmin(axis=1)], every[1]
    for _ in range(5):
        near = np.mod(at[:, None] + step * np.linspace(-1.0, 1.0, 41), 2.0 * np.pi)
        points = turned * profiles(problem, near.ravel())[which].reshape(near.shape)
        best = np.abs(points - centre).argmin(axis=1)[:, None]
        at, step = np.take_along_axis(near, best, axis=1)[:, 0], step / 15.0
    found = np.take_along_axis(points, best, axis=1)[:, 0]
    return found, np.abs(found - centre[:, 0])
