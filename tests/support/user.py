"""A program of a user, for type checkers: it is read by mypy --strict, never run."""

from typing import assert_type

import pandas as pd

import camopt

scene = camopt.find_scene("two-pauses")
cam = camopt.evaluate(scene)
assert_type(cam["base_radius_mm"], float)
assert_type(cam["feasible"], bool)
assert_type(cam["violated"], str)
assert_type(cam.unbounded, dict[str, str])
cam["base_radius_mm"].upper()  # type: ignore[attr-defined]

optimum = camopt.optimise(scene)
if optimum.best is not None:
    assert_type(optimum.best["gap_mm"], float)
    assert_type(optimum.best["proved"], bool)
    assert_type(optimum.best["binding"], list[str])
    assert_type(optimum.best.scene.cam.base_radius, float | None)
optimum.best["gap_mm"]  # type: ignore[index]  # there may be no feasible cam

swept = camopt.sweep(scene, out="results")
assert_type(swept.best["cycloidal"]["held_by"], str)
designs = camopt.load("results/designs.parquet")
assert_type(designs, pd.DataFrame)
assert_type(camopt.scene_of(designs, 0), camopt.Scene)
assert_type(camopt.synthesise(scene).design["base_radius_mm"], float)
assert_type(camopt.frontier(scene).rows[0]["bound"], float | None)
assert_type(camopt.evaluate("two-pauses")["feasible"], bool)
camopt.sweep(scene, "results", "all")  # type: ignore[call-arg]  # keep is a keyword
