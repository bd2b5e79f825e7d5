"""Sweeps whose designs per second are measured: the default one and one for each mechanism; the same for a rival.

camopt is asked through its public functions, so that one commit's benchmarks measure another commit's package.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from rival_c import CELL_SAMPLES, SAMPLES, SIZES, TERMS, Rival, shared_curves
from rival_motion import Segment, motion_cells, motion_table
from rival_numpy import Array

from camopt import Scene, find_scene, sweep

DISC, DRUM = {"form": "disc", "rpm": 300}, {"form": "cylindrical", "rpm": 300}
ARM = {"motion": "oscillating", "contact": "roller", "roller_radius": 8}
FACE = {"contact": "flat"}
KEYS = dict(zip(SIZES, ("base_radius", *SIZES[1:]), strict=True))


@dataclass(frozen=True)
class Job:
    """A sweep: the rival's name of the mechanism, and the scene with its space."""

    mechanism: str
    scene: Scene

    @cached_property
    def raw(self) -> dict[str, Any]:
        return self.scene.to_dict()

    @cached_property
    def sizes(self) -> Array:
        """The designs of one law, (designs, 6); a size that the mechanism has not is 0."""
        given = self.raw["cam"] | self.raw["follower"] | self.raw["search"]
        key = {**KEYS, "size": "base_radius" if self.raw["cam"]["form"] == "disc" else "mean_radius"}
        return np.array(list(product(*(_values(given.get(key[name], 0.0)) for name in SIZES))))

    @property
    def designs(self) -> int:
        return len(self.sizes) * len(self.raw["search"]["law"])

    def motions(self, samples: int) -> list[Array]:
        """The tabulated motion with each law."""
        return [motion_table(law, self.turn, samples) for law in self.raw["search"]["law"]]

    @property
    def turn(self) -> list[Segment]:
        """The segments, in mm or rad."""
        unit = np.pi / 180 if self.raw["follower"]["motion"] == "oscillating" else 1.0
        signs = {"rise": unit, "return": -unit, "dwell": 0.0}
        return [(each["angle"], signs[each["segment"]] * each.get("lift", 0.0)) for each in self.raw["motion"]]

    @property
    def sense(self) -> float:
        """As ``rival.c`` takes it."""
        return 1.0 if self.raw["cam"].get("rotation", "ccw") == "ccw" else -1.0

    def swept(self, workers: int) -> Callable[[], Any]:
        """What sweeps the space with camopt, and writes no tables."""
        return lambda: sweep(self.scene, workers=workers)

    def sampled(self, rival: Rival, threads: int, samples: int = SAMPLES) -> Callable[[], list[Array]]:
        """What gives the extremes of the same designs by a rival, law by law; all that can be shared is made."""
        sizes = self.sizes.astype(rival.number)
        motions = [motion.astype(rival.number) for motion in self.motions(samples)]
        lift = float(max(motion[0].max() for motion in motions))
        return lambda: [rival.extremes(self.mechanism, sizes, self.sense, lift, each, threads) for each in motions]

    def polished(self, rival: Rival, threads: int) -> Callable[[], list[Array]]:
        """What gives them to 1e-9, curve by curve; curves and motions are made before."""
        curves = shared_curves(self.mechanism, self.sizes)
        motions = [motion_cells(law, self.turn, CELL_SAMPLES, TERMS) for law in self.raw["search"]["law"]]
        lift = float(max(motion[0].max() for motion, _ in motions))
        return lambda: [
            rival.polished_extremes(self.mechanism, curves, self.sense, lift, each, threads) for each in motions
        ]


def _values(choice: Any) -> Any:
    """The values of a number, a list, or a range with its ends."""
    if isinstance(choice, dict):
        count = round((choice["stop"] - choice["start"]) / choice["step"])
        return choice["start"] + choice["step"] * np.arange(count + 1)
    return np.atleast_1d(choice)


def _scene(cam: dict[str, Any], follower: dict[str, Any], lift: float, **search: Any) -> Scene:
    """A rise and a return of a cycloidal law, with the default scene's limits."""
    moving = {"lift": lift, "law": "cycloidal"}
    turn = [("rise", 120, moving), ("dwell", 50, {}), ("return", 110, moving), ("dwell", 80, {})]
    motion = [{"segment": kind, "angle": angle, **rest} for kind, angle, rest in turn]
    limits = {"curvature_radius": 1.0} | ({} if follower["contact"] == "flat" else {"pressure_angle": 30.0})
    raw = {"cam": cam, "follower": follower, "motion": motion, "limits": limits}
    size = "base_radius_mm" if cam["form"] == "disc" else "mean_radius_mm"
    return Scene.from_dict({**raw, "search": {"law": ["cycloidal"], "minimise": [size], **search}})


def _range(start: float, stop: float, steps: int) -> dict[str, float]:
    return {"start": start, "stop": stop, "step": (stop - start) / steps}


def jobs(steps: int) -> dict[str, Job]:
    """A sweep for each mechanism: two sizes are free, with so many steps each."""
    own, roller = _range(50.0, 90.0, steps), _range(5.0, 15.0, steps)
    default = find_scene("roller-1000rpm")
    offset = {"base_radius": own, "offset": _range(-20.0, 20.0, steps), "roller_radius": [10], "law": ["cycloidal"]}
    flat = {"motion": "translating", **FACE}
    face = {"motion": "oscillating", **FACE, "centre_distance": 120.0, "face_offset": 5.0}
    scenes = {
        "disc_translating": default.replace(search={**offset, "minimise": default.to_dict()["search"]["minimise"]}),
        "disc_translating_flat": _scene(DISC, flat, 20.0, base_radius=_range(20.0, 90.0, (steps + 1) ** 2 - 1)),
        "disc_oscillating": _scene(
            DISC,
            {**ARM, "arm_length": 100.0, "centre_distance": 120.0},
            20.0,
            base_radius=own,
            roller_radius=roller,
        ),
        "disc_oscillating_flat": _scene(DISC, face, 12.0, base_radius=own, face_offset=_range(2.0, 12.0, steps)),
        "cylindrical_translating": _scene(
            DRUM, {**ARM, "motion": "translating"}, 20.0, mean_radius=own, roller_radius=roller
        ),
        "cylindrical_oscillating": _scene(
            DRUM, {**ARM, "arm_length": 100.0}, 20.0, mean_radius=own, roller_radius=roller
        ),
    }
    return {name: Job(name, scene) for name, scene in scenes.items()}


def loaded_job(steps: int) -> Job:
    """A sweep with a limit on a load, which about half of the designs hold that hold the others."""
    job = jobs(steps)["disc_translating"]
    dynamics = {"mass": 0.5, "spring_rate": 20.0, "preload": 800.0}
    scene = job.scene.replace(**{"follower.dynamics": dynamics, "limits.side_thrust": 750.0})
    return Job(job.mechanism, scene)


def carried_job(steps: int) -> Job:
    """A sweep through a four-bar. The rival samples the same number of cams of a follower without a train."""
    train = [{"stage": "four-bar", "crank": 110, "coupler": 200, "rocker": 100, "ground": 220, "angle": 70}]
    return Job("disc_oscillating", jobs(steps)["disc_oscillating"].scene.replace(train=train))


def default_job() -> Job:
    """The default sweep."""
    return Job("disc_translating", find_scene("roller-1000rpm"))
