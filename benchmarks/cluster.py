"""Sweeps on a Dask cluster of this machine: ``python benchmarks/cluster.py [FINENESS [PROCESSES [WHAT …]]]``.

The files of one process are compared with those of a cluster that is left alone (``alone``), of one where a
worker is killed every few seconds and the command twice (``harassed``), and of clusters whose scheduler is killed
(``scheduler``). What a cluster costs is told in CPU seconds beside those of threads, because other work on the
machine changes these least, and in memory of all its processes; and what 1e12 designs would take on 1,000 workers
is reckoned from the seconds and bytes of a task (``reckoned``). Without WHAT, all of these are done.
"""

import json
import os
import pickle
import re
import resource
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import monotonic, process_time, sleep
from typing import Any, NamedTuple

import psutil

import camopt
from camopt.engines.dask_cluster import RATE, items_of_task
from camopt.front.plan import sweep_plan

KEEP = "pareto"
EACH = 6.0  # seconds between the deaths of workers
DRIVER = 20.0  # seconds after which the command is killed
DEATHS = 10  # of schedulers
PATIENCE = 60.0  # seconds for a command to see that its scheduler is dead
DESIGNS, WORKERS = 1e12, 1000
PIPES: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
ALL = ("alone", "harassed", "scheduler", "reckoned")


def scene(fineness: int) -> camopt.Scene:
    """About a million designs, and more by the square of the fineness."""
    size = {"start": 20, "stop": 150, "step": 0.5 / fineness}
    offset = {"start": -30, "stop": 30, "step": 1.0 / fineness}
    return camopt.find_scene("roller-1000rpm").replace(**{"search.base_radius": size, "search.offset": offset})


class Cost(NamedTuple):
    """What a command took: seconds, and the most MiB that all its processes had at a time."""

    wall: float
    cpu: float
    memory: float

    def __str__(self) -> str:
        return f"{self.wall:.1f} s, CPU {self.cpu:.1f} s, {self.memory:,.0f} MiB"


def swept(file: Path, out: Path, *options: str) -> Cost:
    """Run a command to its end."""
    before, start, memory = resource.getrusage(resource.RUSAGE_CHILDREN), monotonic(), 0.0
    run = subprocess.Popen(command(file, out, *options), **PIPES)
    while run.poll() is None:
        memory = max(memory, memory_of(run.pid))
        sleep(0.5)
    assert run.returncode == 0, run.communicate()[1].decode()
    wall, after = monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Cost(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, memory)


def memory_of(pid: int) -> float:
    """MiB that a process and its children have; what they share counts once."""
    total = 0
    with suppress(psutil.NoSuchProcess):
        for process in (psutil.Process(pid), *psutil.Process(pid).children(recursive=True)):
            with suppress(psutil.NoSuchProcess):
                total += process.memory_full_info().pss
    return total / 2**20


def command(file: Path, out: Path, *options: str) -> list[str]:
    """A sweep as users type it."""
    return [sys.executable, "-m", "camopt", "sweep", str(file), "--keep", KEEP, "--out", str(out), *options]


def harassed(file: Path, out: Path, *options: str) -> tuple[float, int, int, str]:
    """A sweep whose workers are killed all the time, and itself twice: seconds, workers, commands, last words."""
    workers = commands = 0
    start = monotonic()
    while True:
        run = subprocess.Popen(command(file, out, *options), **PIPES)
        begun, number = monotonic(), 0
        while run.poll() is None:
            if commands < 2 and monotonic() - begun > DRIVER and any(out.glob(".camopt/*.journal")):
                run.kill()
                commands += 1
                break
            if monotonic() - begun > EACH * (number + 1):
                number += 1
                workers += killed(run.pid, number)
            sleep(0.05)
        _, words = run.communicate()
        if run.returncode == 0:
            return monotonic() - start, workers, commands, words.decode()
        assert run.returncode == -signal.SIGKILL, words.decode()


def killed(driver: int, number: int) -> int:
    """Kill one of the workers of a command, in turns: how many died."""
    children = psutil.Process(driver).children()
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
    dask = [sys.executable, "-m", "dask"]
    at = ["--scheduler-file", str(address)]
    here = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    scheduler = subprocess.Popen([*dask, "scheduler", *at, *here], **quiet)
    alone = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "5"]
    try:
        while not (address.exists() and address.read_text().endswith("}")):
            sleep(0.05)
        workers = [subprocess.Popen([*dask, "worker", *at, *alone], cwd=folder, **quiet) for _ in range(processes)]
        yield scheduler, json.loads(address.read_text())["address"]
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


def bereaved(file: Path, out: Path, processes: int, moment: float, expected: dict[str, bytes]) -> str:
    """How a sweep ends whose scheduler dies at some moment; whether threads then go on to the same files."""
    with cluster_of(out.parent, processes) as (scheduler, address):
        run = subprocess.Popen(command(file, out, "--scheduler", address), **PIPES)
        with suppress(subprocess.TimeoutExpired):
            run.wait(moment)
        scheduler.kill()
        try:
            words = run.communicate(timeout=PATIENCE)[1].decode().replace(address, "ADDRESS")
        except subprocess.TimeoutExpired:
            run.kill()
            words = f"hangs for {PATIENCE:.0f} s: {run.communicate()[1].decode()}"
    swept(file, out, "--workers", "2")
    last = (words.splitlines() or [""])[-1]
    going_on = "" if run.returncode == 0 else f"; then {'the same' if files(out) == expected else 'OTHER'} files"
    return re.sub(r"[\d,]+ of [\d,]+ designs", "N designs", f"exit {run.returncode}: {last}{going_on}")


def files(folder: Path) -> dict[str, bytes]:
    """What a sweep wrote, but for the manifest, which has the number of the run."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".parquet", ".toml")}


def reckoned(fineness: int) -> None:
    """Print what a great sweep takes, from a few blocks of this one."""
    asked = sweep_plan(scene(fineness), KEEP)
    some = range(len(asked.blocks) // 3, len(asked.blocks) // 3 + 8)
    asked.evaluated(some)
    each = []
    for _ in range(8):  # with its own curves, as a worker that comes anew
        fresh, start = sweep_plan(scene(fineness), KEEP), process_time()
        size = len(pickle.dumps(fresh.evaluated(some)))
        each.append(((process_time() - start) / len(some), size / len(some)))
    seconds, size = map(median, zip(*each, strict=True))
    blocks = DESIGNS / asked.block
    count = items_of_task(10**12, WORKERS, seconds, size)
    tasks, wall = blocks / count, blocks * seconds / WORKERS
    print(f"a block: {1e3 * seconds:.1f} ms; a task of {len(some)} blocks gives {size * len(some):,.0f} B")
    print(f"{DESIGNS:.0e} designs are {blocks:.3g} blocks, {tasks:.3g} tasks of {count} blocks")
    print(f"on {WORKERS:,} workers {wall:,.0f} s, {tasks / wall:.0f} tasks/s (at most {RATE:.0f})")
    print(f"rows: at most {blocks * size / 1e9:.3g} GB in all, {blocks * size / wall / 1e6:.3g} MB/s")


def overhead() -> None:
    """Print how many tasks without work a scheduler and a reader of this machine take a second."""
    with camopt.cluster("local", 1) as engine:
        client = engine.client
        client.gather(client.map(abs, range(100), pure=False))
        start, used = monotonic(), process_time()
        client.gather(client.map(abs, range(3000), pure=False))
        wall, used = monotonic() - start, process_time() - used
        print(f"{3000 / wall:,.0f} tasks/s without work; {used / 3:.2f} ms CPU a task")


def main(fineness: int = 4, processes: int = 4, *what: str) -> None:
    """Run what is asked and print it."""
    what = what or ALL
    with TemporaryDirectory() as folder:
        file, out = Path(folder) / "fine.toml", Path(folder)
        file.write_text(scene(fineness).to_toml(), encoding="utf-8")
        cluster = ("--scheduler", "local", "--workers", str(processes))
        coarse = Path(folder) / "coarse.toml"
        coarse.write_text(scene(1).to_toml(), encoding="utf-8")
        swept(coarse, out / "first", "--workers", "2")  # compiles kernels
        threads = swept(file, out / "threads", "--workers", "2")
        expected = files(out / "threads")
        print(f"{len(sweep_plan(scene(fineness), KEEP).space):,} designs, {os.cpu_count()} cores")
        print(f"threads: {threads}", flush=True)
        if "alone" in what:
            alone = swept(file, out / "alone", *cluster)
            ratio, same = alone.cpu / threads.cpu, files(out / "alone") == expected
            print(f"cluster: {alone} (CPU {ratio:.2f} times); same: {same}", flush=True)
        if "harassed" in what:
            seconds, workers, commands, words = harassed(file, out / "harassed", *cluster)
            same = files(out / "harassed") == expected
            print(f"harassed: {seconds:.1f} s, {workers} workers and {commands} commands killed; same: {same}")
            print(words, flush=True)
        if "scheduler" in what:
            moments = [(4.0 + 2.0 * threads.wall) * number / DEATHS for number in range(DEATHS)]
            ends = Counter(bereaved(file, out / f"{m:.1f}", processes, m, expected) for m in moments)
            print(*(f"scheduler killed, {count} times: {end}" for end, count in ends.most_common()), sep="\n")
    if "reckoned" in what:
        overhead()
        reckoned(fineness)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]), *sys.argv[3:])
