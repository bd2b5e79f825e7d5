"""What many sweeps in one process leave behind: ``python leaks.py [SWEEPS]``.

Resident memory, open files and threads after every tenth sweep, tables written. What is taken once (modules,
kernels, buffers) is there after the first ten; what grows after that would be lost with each sweep.
"""

import gc
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import psutil

import camopt

EACH = 10
GROWTH = 1.15
"""Times the memory after the first ten: what an allocator may keep for itself."""
SEARCH = {"search.base_radius": {"start": 20, "stop": 150, "step": 0.5}, "search.offset": [*range(-30, 31, 2)]}


def held() -> tuple[float, int, int]:
    """Resident memory in MiB, open files and threads of this process."""
    gc.collect()
    process = psutil.Process()
    return process.memory_info().rss / 2**20, process.num_fds(), process.num_threads()


def main(sweeps: int = 100) -> int:
    scene = camopt.find_scene("roller-1000rpm").replace(**SEARCH)
    seen = []
    with TemporaryDirectory() as folder:
        for done in range(1, sweeps + 1):
            swept = camopt.sweep(scene, out=Path(folder) / "out")
            if done % EACH == 0:
                seen.append(held())
                memory, files, threads = seen[-1]
                print(f"{done} sweeps of {swept.designs:,} designs:", end=" ")
                print(f"{memory:.0f} MiB, {files} files, {threads} threads", flush=True)
    (first, *counts), (last, *others) = seen[0], seen[-1]
    return int(last > GROWTH * first or others != counts)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
