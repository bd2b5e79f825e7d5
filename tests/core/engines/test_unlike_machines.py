"""Three unlike machines do parts of a sweep; a Dask cluster loses a worker, then its scheduler."""

import json
import os
import signal
import subprocess
import sys
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest

import camopt
from camopt.core.engines import cluster
from camopt.solve.front import store

pytestmark = pytest.mark.long
SCENE = camopt.find_scene("roller-1000rpm").replace(
    search={
        "base_radius": {"start": 30, "stop": 149, "step": 1},
        "offset": {"start": 0, "stop": 18, "step": 2},
        "law": ["harmonic", "cycloidal"],
    }
)
VECTORS = " ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", []))
MACHINES = (
    {"PYTHONHASHSEED": "1", "OPENBLAS_CORETYPE": "Prescott", "OPENBLAS_NUM_THREADS": "1"},
    {"PYTHONHASHSEED": "20", "OPENBLAS_CORETYPE": "Haswell", "NUMBA_CPU_NAME": "generic"},
    {"PYTHONHASHSEED": "300", "NUMBA_DISABLE_JIT": "1", "OMP_NUM_THREADS": "3", "TZ": "Asia/Kolkata"},
)


def files_of(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".parquet", ".toml")}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The files of one run."""
    out = tmp_path_factory.mktemp("whole")
    camopt.sweep(SCENE, out, keep="all", workers=1)
    return files_of(out)


def test_parts_of_three_machines_are_the_rows_of_one_run(tmp_path, whole):
    for number, settings in enumerate(MACHINES, 1):
        home = tmp_path / f"machine {number}"
        home.mkdir()
        (home / "mine.toml").write_text(SCENE.to_toml())
        options = ["--keep", "all", "--part", f"{number}/3", "--out", "parts", "--workers", str(number)]
        done = subprocess.run(
            [sys.executable, "-m", "camopt", "sweep", "mine.toml", *options],
            cwd=home,
            env={**os.environ, **settings, "HOME": str(home), "NUMBA_CACHE_DIR": str(home / "kernels")},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
    camopt.merge([tmp_path / f"machine {number}" / "parts" for number in (3, 1, 2)], tmp_path / "out")
    assert files_of(tmp_path / "out") == whole


def start_process(*arguments, cwd):
    command = [sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]]
    return subprocess.Popen(command, cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@contextmanager
def dask(folder):
    """The address of a scheduler, and its process before those of its two workers."""
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    local = ["--host", "127.0.0.1"]
    every = [
        start_process(
            "scheduler", *local, "--port", "0", "--no-dashboard", "--scheduler-file", str(file), cwd=folder
        )
    ]
    try:
        until = monotonic() + 60.0
        while not file.exists() or not file.read_text():
            assert monotonic() < until
            sleep(0.1)
        worker = [
            "worker",
            *local,
            "--scheduler-file",
            str(file),
            "--nthreads",
            "1",
            "--no-nanny",
            "--no-dashboard",
        ]
        every += [start_process(*worker, cwd=folder) for _ in range(2)]
        yield json.loads(file.read_text())["address"], every
    finally:
        for process in every:
            with suppress(ProcessLookupError):
                process.kill()
            process.wait()


def test_a_sweep_goes_on_after_a_worker_and_then_the_scheduler_are_killed(tmp_path, whole, monkeypatch):
    monkeypatch.setattr(store, "SAVE_SECONDS", 0.0)
    out, told = tmp_path / "out", []
    with dask(tmp_path) as (address, processes), cluster(address) as engine:
        victims = {0.2: processes[1], 0.6: processes[0]}

        def kill(done, total):
            for share in [share for share in victims if done >= share * total]:
                os.kill(victims.pop(share).pid, signal.SIGKILL)

        with pytest.raises(ConnectionError, match="the Dask scheduler was lost or restarted"):
            camopt.sweep(SCENE, out, keep="all", block=50, progress=kill, engine=engine)
    assert not victims
    assert not (out / "manifest.json").exists()
    with dask(tmp_path) as (address, _), cluster(address) as engine:
        camopt.sweep(SCENE, out, keep="all", block=50, tell=told.append, engine=engine)
    assert told[0].startswith("resuming an interrupted sweep: ")
    assert files_of(out) == whole


def test_the_command_says_that_its_scheduler_is_gone_and_goes_on_without_it(tmp_path, whole):
    (tmp_path / "mine.toml").write_text(SCENE.to_toml())
    command = [sys.executable, "-m", "camopt", "sweep", "mine.toml", "--keep", "all", "--out", "out"]
    with dask(Path(tmp_path)) as (address, processes):
        processes[0].kill()
        processes[0].wait()
        lost = subprocess.run(
            [*command, "--scheduler", address], cwd=tmp_path, capture_output=True, text=True, check=False
        )
    assert lost.returncode in (2, 3), lost.stderr
    assert address in lost.stderr
    assert "Traceback" not in lost.stderr
    assert not (tmp_path / "out" / "manifest.json").exists()
    assert subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode == 0
    assert files_of(tmp_path / "out") == whole
