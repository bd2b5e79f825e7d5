"""Free laws on disk: the scene that has them, and a table of each."""

import csv
import os
from pathlib import Path

import numpy as np

from camopt.files import whole_file
from camopt.synthesis.synthesise import Synthesised
from camopt.table import write_text

SCENE, LAWS = "synthesised.toml", "laws.csv"
POINTS = 361


def write(result: Synthesised, folder: str | os.PathLike[str]) -> list[Path]:
    """Write the scene with the free laws (TOML) and their tables (CSV): unit displacement to jerk; the files."""
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    write_text(out / SCENE, result.scene.to_toml())
    x = np.linspace(0.0, 1.0, POINTS)
    with whole_file(out / LAWS) as partial, partial.open("w", newline="", encoding="utf-8") as text:
        rows = csv.writer(text)
        rows.writerow(("law", "x", "s", "velocity", "acceleration", "jerk"))
        for name, law in result.laws.items():
            columns = (x, law.displacement(x), law.velocity(x), law.acceleration(x), law.jerk(x))
            rows.writerows((name, *map(repr, map(float, row))) for row in zip(*columns, strict=True))
    return [out / SCENE, out / LAWS]
