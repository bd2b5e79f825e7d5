"""What pages cost: their size, the time to write them, until they answer, and the pictures a second of the cam.

    python benchmarks/pages.py

The pages are opened in headless Chromium, without a graphics card; times are the least of three.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.browser import open_page, running_browser

import camopt
from camopt.core.storage.files import write_text
from camopt.show.reporting.results import results_page, thinned_result_rows

SCENES = ("two-pauses", "rocker-valve", "bucket-valve", "feeder-with-stop")
ROWS = (1_000, 100_000)
RUNS = 3
FRAMES = """() => new Promise((done) => {
  const start = performance.now();
  let count = 0;
  camopt.player.play();
  const rate = () => (1000 * count) / (performance.now() - start);
  const step = () => (++count < 120 ? requestAnimationFrame(step) : done(rate()));
  requestAnimationFrame(step);
})"""
"""Pictures a second while the cam is played."""
BRUSH = """() => new Promise((done) => {
  const start = performance.now(), column = camopt.rows.numeric[1];
  camopt.rows.filter(column.name, [column.low, (column.low + column.high) / 2]);
  requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now() - start)));
})"""
"""Milliseconds from a filter until everything is drawn again."""


def swept(folder: Path) -> "tuple[pd.DataFrame, pd.DataFrame]":
    """The designs of the main job, and its front."""
    camopt.sweep(camopt.find_scene("roller-1000rpm").replace(**{"limits.pressure_angle": 30}), out=folder)
    return camopt.load(folder / "designs.parquet"), camopt.load(folder / "pareto.parquet")


def least(work) -> float:
    """The least time of a few runs, s."""
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    """Print a table of pages."""
    print("| page | kB | s to write | s until it answers | ms to filter | pictures a second |")
    print("|---|---:|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as name, running_browser() as browser:
        folder = Path(name)
        window = browser.new_page(viewport={"width": 1280, "height": 900})
        for scene in SCENES:
            path = folder / f"{scene}.html"
            written = least(lambda path=path, scene=scene: camopt.report(scene, path))
            tell(window, scene, path, written)
        designs, front = swept(folder / "swept")
        for rows in ROWS:
            path = folder / f"{rows}.html"
            places = np.linspace(0, len(designs) - 1, rows).astype(int)
            part = designs.iloc[places].reset_index(drop=True)
            part.attrs = designs.attrs
            written = least(
                lambda path=path, part=part: write_text(
                    path, results_page([thinned_result_rows("swept", part, front)])
                )
            )
            tell(window, f"{rows:,} designs", path, written)


def tell(window, name: str, path: Path, written: float) -> None:
    """Print the row of one page."""
    answers = least(lambda: open_page(window, path))
    brush = f"{min(window.evaluate(BRUSH) for _ in range(RUNS)):.0f}" if window.evaluate("!!camopt.rows") else ""
    frames = window.evaluate(FRAMES)
    print(f"| {name} | {path.stat().st_size / 1e3:.0f} | {written:.2f} | {answers:.2f} | {brush} | {frames:.0f} |")


if __name__ == "__main__":
    main()
