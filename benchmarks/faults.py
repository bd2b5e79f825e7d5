"""What faults of files leave of results: ``python benchmarks/faults.py [MOST [CASE …]]``.

For each case of ``tests/storage/test_faults.py``: the work is killed, interrupted, or has a failing call, at
each of its calls on files; and the power is cut after each of them, with any of the names and contents lost that
were not synced. It is good if the older result or the new one is there, whole, and the next run gives the bytes of
a run without faults. At most MOST of each, or somewhat more, are tried, spread evenly (0, as by default: all).
"""

import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from traceback import extract_tb

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "tests" / "storage")]
from support.faults import FAULTS  # noqa: E402
from test_faults import CASES, Bench, spread  # noqa: E402


def wrong_of(tries: Sequence[Callable[[], object]]) -> list[str]:
    """What goes wrong when all are tried."""
    wrong = []
    for attempt in tries:
        try:
            attempt()
        except Exception as fault:
            wrong.append(f"{type(fault).__name__} {fault} ({extract_tb(fault.__traceback__)[-1].line})")
    return wrong


def main(most: int = 0, *names: str) -> int:
    """Try all, and print a line for each case and fault."""
    faults = 0
    for name in names or CASES:
        with TemporaryDirectory() as folder:
            bench = Bench(CASES[name], Path(folder))
            cuts = bench.after_power_cuts()
            tries = {
                fault: [partial(bench.try_fault, number, fault) for number in range(len(bench.calls))]
                for fault in FAULTS
            } | {"power cut": [partial(bench.try_power_cut, tree) for tree in cuts]}
            for fault, every in tries.items():
                some = spread(every, most)
                wrong = wrong_of(some)
                faults += len(wrong)
                good = len(some) - len(wrong)
                print(f"{name}: {fault}: {len(some)} tried, {good} good", *wrong[:5], sep="\n  ", flush=True)
    return min(faults, 1)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:2]), *sys.argv[2:]))
