"""Random spaces with planted ties, whose front is found in two ways.

``python -m support.ties FIRST COUNT [STEP]`` tries the spaces of COUNT seeds and prints the digest of each table:
processors and libraries that compute alike print the same.
"""

import sys
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from camopt import Scene, sweep
from camopt.core.mistakes import BadInput
from camopt.core.quantities import QUANTITIES
from camopt.core.storage.tables import read_table
from camopt.model.effects import available_quantities
from camopt.scene.problem.problem import resolve
from camopt.solve.front import front_search
from camopt.solve.front.box_bounds import can_bound_objective
from support.cams import CONTACTS, STEEL, UNGUIDED, cam_with
from support.ways import boxes_for_front_only

LAWS = ("cycloidal", "poly345", "modified-sine", "harmonic", "double-harmonic")
TRAIN = {"natural_frequency": 90.0, "damping_ratio": 0.05, "fluctuation": 0.02}
NUMBERS = {
    "cam.rpm": 420.0,
    "materials.face_width": 15.0,
    "follower.dynamics.natural_frequency": 90.0,
    "follower.dynamics.damping_ratio": 0.05,
    "follower.dynamics.preload": 260.0,
    "follower.dynamics.spring_rate": 9.0,
}


def space_with_ties(seed: int) -> Scene:
    """A random space of sizes, laws and numbers, of which two objectives at most know some."""
    rng = np.random.default_rng(seed)
    contact = str(rng.choice([*CONTACTS]))
    arm = CONTACTS[contact]["motion"] == "oscillating"
    scene = Scene.from_dict(cam_with(contact, "poly345", None if arm else UNGUIDED, materials=STEEL))
    scene = scene.replace(**{f"follower.dynamics.{key}": value for key, value in TRAIN.items()})
    offers = [name for name in available_quantities(resolve(scene).setup) if QUANTITIES[name].kind is float]
    offers = [name for name in offers if QUANTITIES[name].effect != "surface"]
    signs = {
        name: sign
        for name in offers
        for sign in (1.0, -1.0)
        if can_bound_objective(name, sign, resolve(scene).setup)
    }
    wanted = {str(name): signs[str(name)] for name in rng.permutation([*signs])[: rng.integers(1, 4)]}
    size = "mean_radius" if contact.startswith("groove") else "base_radius"
    largest = getattr(scene.cam, size)
    search = {f"search.{size}": (largest * (1.0 + 0.1 * np.sort(rng.random(rng.integers(2, 9))))).tolist()}
    for key in rng.permutation([*NUMBERS])[: rng.integers(1, 4)].tolist():
        value = scene.numbers([key])[key]
        search[f"search.{key}"] = [value, value * (1.0 + 0.5 * rng.random())]
    search["search.law"] = rng.permutation(LAWS)[: rng.integers(1, 4)].tolist()
    search["search.minimise"] = [name for name, sign in wanted.items() if sign > 0.0] or None
    search["search.maximise"] = [name for name, sign in wanted.items() if sign < 0.0] or None
    return scene.replace(**search, limits={"pressure_angle": 60} if rng.random() < 0.5 else {})


def fronts(seed: int, folder: Path) -> tuple[str, int, int]:
    """The digest of a space's table, the rows of its front, and how many of them tie; both ways give one front."""
    scene, rng = space_with_ties(seed), np.random.default_rng(seed + 1)
    with boxes_for_front_only(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(front_search, "FEW_DESIGNS", int(rng.integers(1, 9)))
        patch.setattr(front_search, "EVALUATED_AT_ONCE", int(rng.integers(2, 50)))
        for keep in ("all", "front-only"):
            sweep(scene, folder / keep, keep=keep, block=int(rng.choice([3, 17, 65536])) if keep == "all" else None)
    full, boxes = (read_table(folder / keep / "pareto.parquet") for keep in ("all", "front-only"))
    assert full.equals(boxes), f"seed {seed}: {full.num_rows} rows by the full sweep, {boxes.num_rows} by boxes"
    costs = full.select([*(scene.search.minimise or ()), *(scene.search.maximise or ())]).to_pandas()
    digest = sha256((folder / "all" / "designs.parquet").read_bytes()).hexdigest()[:16]
    return digest, full.num_rows, int(costs.duplicated(keep=False).sum())


def results_by_seed(first: int, count: int, step: int = 1) -> Iterator[str]:
    """A line for each seed: the digest of its table, the rows of its front, and its ties."""
    for seed in range(first, first + count * step, step):
        with TemporaryDirectory() as folder:
            try:
                digest, rows, ties = fronts(seed, Path(folder))
                yield f"{seed} {digest} {rows} {ties}"
            except (BadInput, AssertionError) as why:
                yield f"{seed} failed {why}"


if __name__ == "__main__":
    for line in results_by_seed(*map(int, sys.argv[1:])):
        print(line, flush=True)
