"""The smallest cam with more than the size free, beside general optimisers: ``python benchmarks/optimisers.py``.

Offset, angles, roller, arm and centre distance, or a flat face's offset are free. Pressure angle, curvature or a
stress decides. A rival samples the turn, so that its cam may be too small: the table says by how many mm, and by
what share it breaks a limit between the samples.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from rival_numpy import LAWS, Array
from scipy import optimize

from camopt import Scene, find_scene
from camopt import optimise as smallest

ANGLES = 720  # samples of the turn
LAW, ROLLER = "cycloidal", 5.0
SIZES = (1.0, 200.0)
LIMITS = (30.0, 30.0)
SWING_LIMITS = (35.0, 40.0)
SWING = [
    {"segment": "rise", "angle": 120, "lift": 20, "law": LAW},
    {"segment": "dwell", "angle": 30},
    {"segment": "return", "angle": 100, "lift": 20, "law": LAW},
    {"segment": "dwell", "angle": 110},
]
LEAST_RADIUS = 10.0
FREE = {
    "offset": "offset_mm",
    "roller_radius": "roller_radius_mm",
    "face_offset": "face_offset_mm",
    "arm_length": "arm_length_mm",
    "centre_distance": "centre_distance_mm",
}
"""Columns of free sizes by their keys, in the order of the rivals."""


@dataclass(frozen=True)
class Problem:
    """Make x[0], the size, small within bounds; ``usage`` (x, samples) is how far limits are used, at most 1."""

    bounds: tuple[tuple[float, float], ...]
    usage: Callable[[Array, int], Array]

    def room(self, x: Array) -> Array:
        """At least 0 where the limits hold, at every sample."""
        return 1.0 - np.nan_to_num(self.usage(np.asarray(x), ANGLES), nan=1e3, posinf=1e3)

    def least_room(self, x: Array) -> float:
        return float(self.room(x).min())

    def excess(self, x: Array) -> float:
        """By how much, relatively, a cam breaks its limits on a dense turn."""
        return float(np.max(self.usage(np.asarray(x), 200_000))) - 1.0


Stroke = tuple[Array, Array, Array]


def strokes(rise: float, fall: float, lift: float, samples: int) -> tuple[Stroke, Stroke]:
    """y, y' and y'' of a rise and a return over angles in deg."""
    s, v, a = LAWS[LAW](np.linspace(0.0, 1.0, samples // 2))
    up, down = np.radians(rise), np.radians(fall)
    return (lift * s, lift / up * v, lift / up**2 * a), (lift * (1.0 - s), -lift / down * v, -lift / down**2 * a)


def translating(offset: bool, angles: bool) -> tuple[Scene, Problem]:
    """50 mm in 120°, back in 90°."""
    search: dict[str, Any] = {"law": [LAW]}
    bounds = [SIZES]
    if offset:
        search["offset"] = {"start": -40, "stop": 40}
        bounds.append((-40.0, 40.0))
    if angles:
        search |= {f"angle_{kind}": {"start": 60, "stop": 150} for kind in ("rise", "return")}
        bounds.append((60.0, 150.0))
    sizes = {"follower.offset": 0, "follower.roller_radius": ROLLER}
    limits = dict(zip(("pressure_angle", "pressure_angle_return"), LIMITS, strict=True))
    scene = find_scene("roller-1000rpm").replace(**sizes, limits=limits, search=search)

    def usage(x: Array, samples: int) -> Array:
        lead, rise = (x[1] if offset else 0.0), (x[-1] if angles else 120.0)
        height = np.sqrt(max((x[0] + ROLLER) ** 2 - lead**2, 0.0))
        turn = strokes(rise, 210.0 - rise, 50.0, samples)
        pairs = zip(turn, LIMITS, strict=True)
        parts = [np.abs((y1 - lead) / (height + y + 1e-12)) / np.tan(np.radians(lim)) for (y, y1, _), lim in pairs]
        return np.concatenate(parts)

    return scene, Problem(tuple(bounds), usage)


def oscillating(arm: bool, centre: bool) -> tuple[Scene, Problem]:
    """20° in 120°, back in 100°, ccw, a roller of 10 mm on an arm."""
    ranges = {"arm_length": (80.0, 140.0), "centre_distance": (100.0, 160.0)}
    fixed = {"arm_length": 120.0, "centre_distance": 130.0}
    free = [name for name, wanted in zip(ranges, (arm, centre), strict=True) if wanted]
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 40},
            "follower": {"motion": "oscillating", "contact": "roller", "roller_radius": 10, **fixed},
            "motion": SWING,
            "limits": dict(zip(("pressure_angle", "pressure_angle_return"), SWING_LIMITS, strict=True)),
            "search": {name: dict(zip(("start", "stop"), ranges[name], strict=True)) for name in free},
        }
    )

    def usage(x: Array, samples: int) -> Array:
        l, c = ({**fixed, **dict(zip(free, x[1:], strict=True))}[name] for name in ranges)  # noqa: E741
        cosine = (c**2 + l**2 - (x[0] + 10.0) ** 2) / (2 * c * l)
        turn = strokes(120.0, 100.0, np.radians(20.0), samples)
        if not -1.0 < cosine < 1.0 or np.arccos(cosine) + np.radians(20.0) >= np.pi:
            return np.full(2 * (samples // 2), 10.0 + abs(cosine))
        parts = []
        for (y, y1, _), limit in zip(turn, SWING_LIMITS, strict=True):
            psi = np.arccos(cosine) + y
            parts.append(np.abs((l * (1 + y1) - c * np.cos(psi)) / (c * np.sin(psi))) / np.tan(np.radians(limit)))
        return np.concatenate(parts)

    return scene, Problem((SIZES, *(ranges[name] for name in free)), usage)


def flat() -> tuple[Scene, Problem]:
    """The same swing of a flat face, its offset and the centre distance free: curvature decides."""
    ranges = {"face_offset": (-10.0, 15.0), "centre_distance": (100.0, 160.0)}
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 40},
            "follower": {"motion": "oscillating", "contact": "flat", "face_offset": 5, "centre_distance": 130},
            "motion": SWING,
            "limits": {"curvature_radius": LEAST_RADIUS},
            "search": {name: dict(zip(("start", "stop"), ends, strict=True)) for name, ends in ranges.items()},
        }
    )

    def usage(x: Array, samples: int) -> Array:
        radius, f, c = x
        sine = (radius - f) / c
        if not -1.0 < sine < 1.0 or np.arcsin(sine) + np.radians(20.0) >= np.pi / 2:
            return np.full(2 * (samples // 2), 10.0 + abs(sine))
        parts = []
        for y, y1, y2 in strokes(120.0, 100.0, np.radians(20.0), samples):
            psi, q = np.arcsin(sine) + y, 1 + y1
            curvature = f + c * (np.sin(psi) * (2 * q - 1) / q**2 + np.cos(psi) * y2 / q**3)
            parts.append(2.0 - curvature / LEAST_RADIUS)
        return np.concatenate(parts)

    return scene, Problem((SIZES, *ranges.values()), usage)


RPM, WIDTH, PRELOAD = 1000.0, 12.0, 900.0
STIFFNESS = 1.0 / (2.0 * (1.0 - 0.292**2) / 207e3)  # of two bodies of steel in contact [MPa]


def stress_usage(force: Array, curvature: Array, width: float, stress: float) -> Array:
    """Hertz's stress of a line contact as a share of a limit; an undercut cam (no positive sum) is far beyond."""
    pressed = np.maximum(force, 0.0) / (np.pi * width) * STIFFNESS
    return np.where(curvature > 0.0, np.sqrt(pressed * np.maximum(curvature, 0.0)) / stress, 10.0)


MATERIALS = {"cam": "steel", "follower": "steel", "face_width": WIDTH}
ANGLE_RANGES = {f"angle_{kind}": {"start": 80, "stop": 140} for kind in ("rise", "return")}


def loaded_turn(lift: float) -> list[dict[str, Any]]:
    """Up in 110° and back in 110°."""
    turn = (("rise", 110), ("dwell", 60), ("return", 110), ("dwell", 80))
    return [
        {"segment": kind, "angle": angle} | ({} if kind == "dwell" else {"lift": lift, "law": LAW})
        for kind, angle in turn
    ]


def roller_contact(roller: float, bend: Array) -> Array:
    """The sum of the curvatures of a roller and of the flank under it; −1 where the cam is undercut."""
    gap = 1.0 - roller * bend
    return np.where(gap > 0.0, 1.0 / (roller * np.where(gap > 0.0, gap, 1.0)), -1.0)


def loaded_roller(free: tuple[str, ...], **limit: float) -> tuple[Scene, Problem]:
    """20 mm up and back: 4 kg on a spring, a stress in a line contact of 12 mm or another load limited."""
    ranges = {"offset": (-10.0, 10.0), "roller_radius": (8.0, 16.0)}
    search: dict[str, Any] = {
        name: dict(zip(("start", "stop"), ranges[name], strict=True)) for name in free if name in ranges
    }
    bounds = [SIZES, *(ranges[name] for name in free if name in ranges)]
    if "angles" in free:
        search |= ANGLE_RANGES
        bounds.append((80.0, 140.0))
    dynamics = {"mass": 4, "spring_rate": 6, "preload": PRELOAD}
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "rotation": "cw", "rpm": RPM, "base_radius": 40},
            "follower": {"motion": "translating", "contact": "roller", "roller_radius": 12, "dynamics": dynamics},
            "materials": MATERIALS,
            "motion": loaded_turn(20),
            "limits": {"pressure_angle": LIMITS[0], **limit},
            "search": search,
        }
    )

    def usage(x: Array, samples: int) -> Array:
        sizes = dict(zip(("base", *free), x, strict=True))
        lead, roller, rise = sizes.get("offset", 0.0), sizes.get("roller_radius", 12.0), sizes.get("angles", 110.0)
        height, parts = np.sqrt(max((x[0] + roller) ** 2 - lead**2, 0.0)), []
        for y, y1, y2 in strokes(rise, 220.0 - rise, 20.0, samples):
            up, side = height + y + 1e-12, y1 - lead
            square = up**2 + side**2
            bend = (square + side * y1 - up * y2) / square**1.5
            force = 4e-3 * (RPM * np.pi / 30.0) ** 2 * y2 + 6.0 * y + PRELOAD
            normal = force * np.sqrt(square) / up
            loads = {
                "contact_stress": lambda bound: stress_usage(normal, roller_contact(roller, bend), WIDTH, bound),  # noqa: B023
                "normal_force": lambda bound: normal / bound,  # noqa: B023
                "side_thrust": lambda bound: np.abs(force * side / up) / bound,  # noqa: B023
            }
            parts += [np.abs(side / up) / np.tan(np.radians(LIMITS[0]))]
            parts += [loads[name](bound) for name, bound in limit.items()]
        return np.concatenate(parts)

    return scene, Problem(tuple(bounds), usage)


def loaded_flat(*, angles: bool, stress: float) -> tuple[Scene, Problem]:
    """20 mm up and back: 2 kg on a spring, under a flat face."""
    dynamics = {"mass": 2, "spring_rate": 6, "preload": PRELOAD}
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "rotation": "cw", "rpm": RPM, "base_radius": 40},
            "follower": {"motion": "translating", "contact": "flat", "dynamics": dynamics},
            "materials": MATERIALS,
            "motion": loaded_turn(20),
            "limits": {"contact_stress": stress},
            "search": {"law": [LAW], **(ANGLE_RANGES if angles else {})},
        }
    )

    def usage(x: Array, samples: int) -> Array:
        rise, parts = x[1] if angles else 110.0, []
        for y, _, y2 in strokes(rise, 220.0 - rise, 20.0, samples):
            radius = x[0] + y + y2
            force = 2e-3 * (RPM * np.pi / 30.0) ** 2 * y2 + 6.0 * y + PRELOAD
            touch = np.where(radius > 0.0, 1.0 / np.where(radius > 0.0, radius, 1.0), -1.0)
            parts.append(stress_usage(force, touch, WIDTH, stress))
        return np.concatenate(parts)

    return scene, Problem((SIZES, *[(80.0, 140.0)] * angles), usage)


def loaded_arm(stress: float) -> tuple[Scene, Problem]:
    """12° up and back: 0.02 kg·m² on a spring, a roller of 12 mm on an arm of free length."""
    lift, arm, centre = np.radians(12.0), (90.0, 130.0), 130.0
    dynamics = {"inertia": 0.02, "spring_rate": 40, "preload": 60}
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "rpm": RPM, "base_radius": 40},
            "follower": {
                "motion": "oscillating",
                "contact": "roller",
                "roller_radius": 12,
                "arm_length": 110,
                "centre_distance": centre,
                "dynamics": dynamics,
            },
            "materials": MATERIALS,
            "motion": loaded_turn(12),
            "limits": {"pressure_angle": SWING_LIMITS[0], "contact_stress": stress},
            "search": {"law": [LAW], "arm_length": dict(zip(("start", "stop"), arm, strict=True))},
        }
    )

    def usage(x: Array, samples: int) -> Array:
        size, length = x
        cosine = (centre**2 + length**2 - (size + 12.0) ** 2) / (2 * centre * length)
        if not -1.0 < cosine < 1.0 or np.arccos(cosine) + lift >= np.pi:
            return np.full(4 * (samples // 2), 10.0 + abs(cosine))
        parts = []
        for y, y1, y2 in strokes(110.0, 110.0, lift, samples):
            psi, turned = np.arccos(cosine) + y, 1.0 + y1
            s, w = centre * np.sin(psi), length * turned - centre * np.cos(psi)
            square, s1, w1 = s**2 + w**2, centre * np.cos(psi) * y1, length * y2 + s * y1
            bend = (turned * square - (w1 * s - w * s1)) / square**1.5
            moment = 0.02 * (RPM * np.pi / 30.0) ** 2 * y2 + 40.0 * y + 60.0
            normal = 1e3 * moment / length * np.sqrt(square) / s
            parts += [
                np.abs(w / s) / np.tan(np.radians(SWING_LIMITS[0])),
                stress_usage(normal, roller_contact(12.0, bend), WIDTH, stress),
            ]
        return np.concatenate(parts)

    return scene, Problem((SIZES, arm), usage)


PROBLEMS = {
    "offset": translating(offset=True, angles=False),
    "angles": translating(offset=False, angles=True),
    "offset and angles": translating(offset=True, angles=True),
    "arm": oscillating(arm=True, centre=False),
    "arm and centre": oscillating(arm=True, centre=True),
    "face and centre": flat(),
    "stress: roller": loaded_roller(("roller_radius",), contact_stress=740.0),
    "stress: offset": loaded_roller(("offset",), contact_stress=820.0),
    "stress: angles": loaded_roller(("angles",), contact_stress=820.0),
    "stress: offset, roller": loaded_roller(("offset", "roller_radius"), contact_stress=740.0),
    "stress: flat": loaded_flat(angles=False, stress=500.0),
    "stress: flat, angles": loaded_flat(angles=True, stress=500.0),
    "stress: arm": loaded_arm(585.0),
    "side thrust: offset": loaded_roller(("offset",), side_thrust=350.0),
    "normal force: offset, angles": loaded_roller(("offset", "angles"), normal_force=2420.0),
    "stress: offset, roller, angles": loaded_roller(("offset", "roller_radius", "angles"), contact_stress=760.0),
}


def by_slsqp(problem: Problem) -> Array:
    """Sequential quadratic programming with a constraint at every sample, from many starts."""
    rng, found = np.random.default_rng(1), []
    low, high = np.transpose(problem.bounds)
    for start in rng.uniform(low, high, (16, len(low))):
        result = optimize.minimize(
            lambda x: x[0],
            start,
            bounds=problem.bounds,
            constraints={"type": "ineq", "fun": problem.room},
            method="SLSQP",
            options={"ftol": 1e-10, "maxiter": 300},
        )
        if problem.least_room(result.x) >= -1e-6:
            found.append(result.x)
    return min(found, key=lambda x: float(x[0]), default=np.array(high))


def by_differential_evolution(problem: Problem) -> Array:
    held = optimize.NonlinearConstraint(problem.least_room, 0.0, np.inf)
    result = optimize.differential_evolution(
        lambda x: x[0], problem.bounds, constraints=held, rng=1, tol=1e-10, maxiter=300, polish=False
    )
    return np.asarray(result.x)


def by_shgo(problem: Problem) -> Array:
    constraint = {"type": "ineq", "fun": problem.least_room}
    result = optimize.shgo(
        lambda x: x[0],
        problem.bounds,
        constraints=constraint,
        n=256,
        iters=3,
        sampling_method="sobol",
    )
    return np.asarray(result.x) if result.x is not None else np.array([b for _, b in problem.bounds])


def by_nsga2(problem: Problem) -> Array:
    """pymoo's NSGA-II with the size as its one objective."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import ElementwiseProblem
    from pymoo.optimize import minimize

    low, high = map(np.array, zip(*problem.bounds, strict=True))

    class Sized(ElementwiseProblem):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(n_var=low.size, n_obj=1, n_ieq_constr=1, xl=low, xu=high)

        def _evaluate(self, x: Array, out: dict[str, float], *args: object, **kwargs: object) -> None:
            out["F"], out["G"] = x[0], -problem.least_room(x)

    result = minimize(Sized(), NSGA2(pop_size=60), ("n_gen", 200), seed=1)
    return np.array(high) if result.X is None else np.atleast_2d(result.X)[0]


Rival = Callable[[Problem], Array]


def quietly(rival: Rival, problem: Problem) -> Array:
    """A rival's answer without its warnings."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return rival(problem)


RIVALS: dict[str, Rival] = {
    "SLSQP × 16": by_slsqp,
    "evolution": by_differential_evolution,
    "SHGO": by_shgo,
    "NSGA-II": by_nsga2,
}


def by_camopt(scene: Scene) -> Array:
    """The smallest cam by camopt, as the rivals give it."""
    best = smallest(scene).best
    assert best is not None
    assert best["proved"]
    x = [best["base_radius_mm"]]
    for key, name in FREE.items():
        if key in scene.to_dict()["search"]:
            x.append(best[name] * (-1.0 if key == "offset" else 1.0))  # the cam turns clockwise
    return np.array(x + best.get("angles_deg", [])[:1])


def timed(run: Callable[[], Array], rounds: int) -> tuple[float, Array]:
    """The least seconds of some runs, and the answer."""
    times = []
    for _ in range(rounds):
        start = perf_counter()
        answer = run()
        times.append(perf_counter() - start)
    return min(times), answer


def main() -> None:
    """Print the table."""
    print(f"| free | camopt, mm | s | {' | '.join(f'{name}: radius, mm, excess, times' for name in RIVALS)} |")
    print("|---|---:|---:|" + "---|" * len(RIVALS))
    for name, (scene, problem) in PROBLEMS.items():
        own, best = timed(lambda: by_camopt(scene), 9)  # noqa: B023
        cells = [name, f"{best[0]:.6f}", f"{own:.4f}"]
        for rival in RIVALS.values():
            taken, answer = timed(lambda: quietly(rival, problem), 2)  # noqa: B023
            excess = problem.excess(answer)
            told = "held" if excess <= 0.0 else f"{excess:+.0e}"
            cells.append(f"{answer[0] - best[0]:+.0e}, {told}, {taken / own:.2g}")
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
