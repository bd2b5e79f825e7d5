"""Sweeps on a Dask cluster of this machine: ``python benchmarks/cluster.py [FINENESS [PROCESSES]]``.

The files of one process are held against those of a cluster that is left alone, of one where a worker is killed
every few seconds and the command twice, and of clusters whose scheduler is killed at ten moments.
"""

import json
import re
import resource
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, sleep
from typing import Any

import psutil

import camopt

EACH, DRIVER = 6.0, 20.0  # seconds between the deaths of workers, and until that of the command
DEATHS = 10  # of schedulers
PATIENCE = 60.0  # seconds for a command to see that its scheduler is dead
PIPES: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}


def scene(fineness: int) -> camopt.Scene:
    """About a million designs, and more by the square of the fineness."""
    size = {"start": 20, "stop": 150, "step": 0.5 / fineness}
    offset = {"start": -30, "stop": 30, "step": 1.0 / fineness}
    return camopt.find_scene("roller-1000rpm").replace(**{"search.base_radius": size, "search.offset": offset})


def start_sweep(file: Path, out: Path, *options: str) -> subprocess.Popen:
    """A sweep as users type it."""
    line = [sys.executable, "-m", "camopt", "sweep", str(file), "--keep", "pareto", "--out", str(out), *options]
    return subprocess.Popen(line, **PIPES)


def sweep_seconds(file: Path, out: Path, *options: str) -> tuple[float, float]:
    """Seconds of a sweep: of the clock, and of the processor."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), monotonic()
    run = start_sweep(file, out, *options)
    words = run.communicate()[1].decode()
    assert run.returncode == 0, words
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return monotonic() - start, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def sweep_with_deaths(file: Path, out: Path, *options: str) -> tuple[float, int, int]:
    """A sweep whose workers are killed all the time, and itself twice: seconds, workers, commands."""
    workers = commands = 0
    start = monotonic()
    while True:
        run, begun, number = start_sweep(file, out, *options), monotonic(), 0
        while run.poll() is None:
            if commands < 2 and monotonic() - begun > DRIVER:
                run.kill()
                commands += 1
                break
            if monotonic() - begun > EACH * (number + 1):
                number += 1
                workers += kill_worker(run.pid, number)
            sleep(0.05)
        words = run.communicate()[1].decode()
        if run.returncode == 0:
            return monotonic() - start, workers, commands
        assert run.returncode == -signal.SIGKILL, words


def kill_worker(command: int, number: int) -> int:
    """Kill one of the workers of a command, in turns: how many died."""
    children = psutil.Process(command).children()
    workers = [child for child in children if any("spawn_main" in word for word in child.cmdline())]
    if workers:
        workers[number % len(workers)].kill()
    return min(1, len(workers))


@contextmanager
def cluster_of(folder: Path, processes: int) -> Iterator[tuple[subprocess.Popen, str]]:
    """A scheduler and workers, processes of their own as on a cluster: the scheduler, and its address."""
    address = folder / "scheduler.json"
    address.unlink(missing_ok=True)
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    dask, at = [sys.executable, "-m", "dask"], ["--scheduler-file", str(address)]
    here = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    started = [subprocess.Popen([*dask, "scheduler", *at, *here], **quiet)]
    alone = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "5"]
    try:
        while not (address.exists() and address.read_text().endswith("}")):
            sleep(0.05)
        started += [subprocess.Popen([*dask, "worker", *at, *alone], cwd=folder, **quiet) for _ in range(processes)]
        yield started[0], json.loads(address.read_text())["address"]
    finally:
        for process in started:
            process.kill()
            process.wait()


def end_of_sweep(file: Path, out: Path, processes: int, moment: float, expected: dict[str, bytes]) -> str:
    """How a sweep ends whose scheduler dies at some moment; whether threads then go on to the same files."""
    with cluster_of(out.parent, processes) as (scheduler, address):
        run = start_sweep(file, out, "--scheduler", address)
        with suppress(subprocess.TimeoutExpired):
            run.wait(moment)
        scheduler.kill()
        try:
            words = run.communicate(timeout=PATIENCE)[1].decode().replace(address, "ADDRESS")
        except subprocess.TimeoutExpired:
            run.kill()
            words = f"hangs for {PATIENCE:.0f} s: {run.communicate()[1].decode()}"
    sweep_seconds(file, out, "--workers", "2")
    last = (words.splitlines() or [""])[-1]
    going_on = "" if run.returncode == 0 else f"; then {'the same' if files(out) == expected else 'OTHER'} files"
    return re.sub(r"[\d,]+ of [\d,]+ designs", "N designs", f"exit {run.returncode}: {last}{going_on}")


def files(folder: Path) -> dict[str, bytes]:
    """What a sweep wrote, but for the manifest, which has the number of the run."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".parquet", ".toml")}


def main(fineness: int = 4, processes: int = 4) -> None:
    """Print how the sweeps end."""
    with TemporaryDirectory() as name:
        folder, cluster = Path(name), ("--scheduler", "local", "--workers", str(processes))
        file = folder / "fine.toml"
        file.write_text(scene(fineness).to_toml(), encoding="utf-8")
        sweep_seconds(file, folder / "first", "--workers", "2")  # compiles kernels
        wall, cpu = sweep_seconds(file, folder / "threads", "--workers", "2")
        expected = files(folder / "threads")
        print(f"threads: {wall:.1f} s, CPU {cpu:.1f} s", flush=True)
        own_wall, own_cpu = sweep_seconds(file, folder / "alone", *cluster)
        same = files(folder / "alone") == expected
        print(
            f"cluster: {own_wall:.1f} s, CPU {own_cpu:.1f} s ({own_cpu / cpu:.2f} times); same: {same}", flush=True
        )
        seconds, workers, commands = sweep_with_deaths(file, folder / "deaths", *cluster)
        same = files(folder / "deaths") == expected
        print(f"killed: {workers} workers and {commands} commands, {seconds:.1f} s; same: {same}", flush=True)
        moments = [(4.0 + 2.0 * wall) * number / DEATHS for number in range(DEATHS)]
        ends = Counter(end_of_sweep(file, folder / f"{m:.1f}", processes, m, expected) for m in moments)
        print(*(f"scheduler killed, {count} times: {end}" for end, count in ends.most_common()), sep="\n")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
