"""Sweeps on a Dask cluster of this machine: ``python benchmarks/cluster.py [FINENESS [PROCESSES]]``.

The files of one process are compared with those of a cluster that is left alone, and of one where a worker is
killed every few seconds and the command twice. What a cluster costs is told in CPU seconds beside those of threads,
because other work on the machine changes these least; and what 1e12 designs would take on 1,000 workers is reckoned
from the seconds and bytes of a task.
"""

import os
import pickle
import resource
import signal
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, process_time, sleep

import psutil

import camopt
from camopt.engines.dask_cluster import RATE, Pace
from camopt.front.asked import asked_of

KEEP = "pareto"
EACH = 6.0  # seconds between the deaths of workers
DRIVER = 20.0  # seconds after which the command is killed
DESIGNS, WORKERS = 1e12, 1000


def scene(fineness: int) -> camopt.Scene:
    """About a million designs, and more by the square of the fineness."""
    size = {"start": 20, "stop": 150, "step": 0.5 / fineness}
    offset = {"start": -30, "stop": 30, "step": 1.0 / fineness}
    return camopt.find_scene("roller-1000rpm").replace(**{"search.base_radius": size, "search.offset": offset})


def swept(file: Path, out: Path, *options: str) -> tuple[float, float]:
    """Wall and CPU seconds of a command, all its processes together."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), monotonic()
    subprocess.run(command(file, out, *options), check=True, capture_output=True)
    wall, after = monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def command(file: Path, out: Path, *options: str) -> list[str]:
    """A sweep as users type it."""
    return [sys.executable, "-m", "camopt", "sweep", str(file), "--keep", KEEP, "--out", str(out), *options]


def harassed(file: Path, out: Path, *options: str) -> tuple[float, int, int, str]:
    """A sweep whose workers are killed all the time, and itself twice: seconds, workers, commands, last words."""
    workers = commands = 0
    start = monotonic()
    while True:
        run = subprocess.Popen(command(file, out, *options), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
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


def files(folder: Path) -> dict[str, bytes]:
    """What a sweep wrote, but for the manifest, which has the number of the run."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".parquet", ".toml")}


def reckoned(fineness: int) -> None:
    """Print what a great sweep takes, from a few tasks of this one."""
    asked = asked_of(scene(fineness), KEEP)
    some, pace = range(len(asked.blocks) // 3, len(asked.blocks) // 3 + 8), Pace(0.0)
    asked.evaluated(some)
    for _ in range(8):  # each with its own curves, as a worker that comes anew
        fresh, start = asked_of(scene(fineness), KEEP), process_time()
        size = len(pickle.dumps(fresh.evaluated(some), protocol=pickle.HIGHEST_PROTOCOL))
        pace.learn(len(some), process_time() - start, size)
    blocks = DESIGNS / asked.block
    each = pace.items(10**12, WORKERS)
    tasks = blocks / each
    seconds = blocks * pace.seconds / WORKERS
    print(
        f"a block: {1e3 * pace.seconds:.1f} ms; a task of {len(some)} blocks gives {pace.bytes * len(some):,.0f} B"
    )
    print(f"{DESIGNS:.0e} designs are {blocks:.3g} blocks, {tasks:.3g} tasks of {each} blocks")
    print(f"on {WORKERS:,} workers {seconds:,.0f} s, {tasks / seconds:.0f} tasks/s (at most {RATE:.0f})")
    print(
        f"rows: at most {blocks * pace.bytes / 1e9:.3g} GB in all, {blocks * pace.bytes / seconds / 1e6:.3g} MB/s"
    )


def overhead() -> None:
    """Print how many tasks without work a scheduler and a reader of this machine take a second."""
    with camopt.cluster("local", 1) as engine:
        client = engine.client
        client.gather(client.map(abs, range(100), pure=False))
        start, used = monotonic(), process_time()
        client.gather(client.map(abs, range(3000), pure=False))
        wall, used = monotonic() - start, process_time() - used
        print(f"{3000 / wall:,.0f} tasks/s without work; {used / 3:.2f} ms CPU a task")


def main(fineness: int = 4, processes: int = 4) -> None:
    """Run all and print it."""
    with TemporaryDirectory() as folder:
        file, out = Path(folder) / "fine.toml", Path(folder)
        file.write_text(scene(fineness).to_toml(), encoding="utf-8")
        cluster = ("--scheduler", "local", "--workers", str(processes))
        swept(file, out / "first", "--workers", "2")
        threads = swept(file, out / "threads", "--workers", "2")
        alone = swept(file, out / "alone", *cluster)
        expected = files(out / "threads")
        print(f"{len(asked_of(scene(fineness), KEEP).space):,} designs, {os.cpu_count()} cores")
        print(f"threads: {threads[0]:.1f} s, CPU {threads[1]:.1f} s")
        same, ratio = files(out / "alone") == expected, alone[1] / threads[1]
        print(f"cluster: {alone[0]:.1f} s, CPU {alone[1]:.1f} s ({ratio:.2f} times); same: {same}")
        seconds, workers, commands, words = harassed(file, out / "harassed", *cluster)
        same = files(out / "harassed") == expected
        print(f"harassed: {seconds:.1f} s, {workers} workers and {commands} commands killed; same: {same}")
        print(words)
    overhead()
    reckoned(fineness)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
