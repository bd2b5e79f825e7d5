"""Whole commands as a user runs them, warm: interpreter, imports, compiled kernels from the disk cache, files."""

import json
import subprocess
import sys
import sysconfig
from pathlib import Path

from pytest_benchmark.fixture import BenchmarkFixture
from timing import measured, ratio, rival_seconds, seconds

from camopt import find_scene, sweep

CAMOPT = str(Path(sysconfig.get_path("scripts")) / "camopt")
NUMPY = [sys.executable, "-c", "import numpy"]
ROUNDS = 5


def output_of(command: list[str]) -> str:
    """What a command prints; an error if it fails."""
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout


def peak_mib(command: list[str]) -> float:
    """Peak memory of a command."""
    runner = Path(__file__).with_name("peak_memory.py")
    return round(float(output_of([sys.executable, str(runner), *command])), 1)


def against_numpy(benchmark: BenchmarkFixture, command: list[str]) -> None:
    """Record memory, and how many times longer the command takes than importing numpy."""
    benchmark.extra_info |= {
        "peak_mib": peak_mib(command),
        "import_numpy_peak_mib": peak_mib(NUMPY),
        "times_import_numpy": ratio(seconds(benchmark), rival_seconds(benchmark, lambda: output_of(NUMPY), ROUNDS)),
    }


def bench_sweep(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """The main job, with its tables written each time."""
    sweep(find_scene("roller-1000rpm"))  # kernels that are not on disk yet are compiled here
    command = [
        CAMOPT,
        "sweep",
        "--rpm",
        "1000",
        "--max-pressure",
        "30",
        "--out",
        str(tmp_path),
        "--json",
        "--again",
    ]
    found = json.loads(measured(benchmark, lambda: output_of(command), ROUNDS))
    counts = {name: found[name] for name in ("designs", "feasible", "pareto")}
    files = {path.name: path.stat().st_size for path in sorted(tmp_path.iterdir())}
    benchmark.extra_info |= {
        **counts,
        "designs_per_second": counts["designs"] / seconds(benchmark),
        "file_bytes": files,
    }
    against_numpy(benchmark, command)
    assert counts["designs"] > counts["feasible"] > counts["pareto"] > 0
    assert set(files) == {"designs.parquet", "pareto.parquet", "scene.toml", "manifest.json"}


def bench_help(benchmark: BenchmarkFixture) -> None:
    """``camopt --help``: what it costs to be asked nothing."""
    command = [CAMOPT, "--help"]
    text = measured(benchmark, lambda: output_of(command), ROUNDS)
    against_numpy(benchmark, command)
    assert "sweep" in text
