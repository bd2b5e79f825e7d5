"""What one design costs, and what a batch of them gains, beside numpy: ``python benchmarks/batches.py``.

CPU time of a call of ``evaluate_designs`` once the scene is known, by the designs of a call; the rival finds three
extremes of the same cams to the same accuracy, camopt these three or all that the scene calls for.
"""

from collections.abc import Callable
from itertools import cycle
from time import process_time
from typing import Any

from random_cams import by_numpy, random_cams

from camopt import evaluate_designs, find_scene

COUNTS = (1, 10, 100, 1_000, 10_000)
CALLS, ROUNDS = 40, 5  # calls of other designs each; of rounds the least counts
LAW = "cycloidal"


def cpu_ms(call: Callable[[Any], Any], tables: list[Any]) -> float:
    """CPU time of a call [ms], the least of some rounds, after one that does not count."""
    times, each = [], cycle(tables)
    for _ in range(ROUNDS + 1):
        start = process_time()
        for _ in range(len(tables)):
            call(next(each))
        times.append((process_time() - start) / len(tables) * 1e3)
    return min(times[1:])


def rows() -> list[tuple[int, float, float, float]]:
    """Of each number of designs: CPU time of camopt for all quantities and for three of them, and of numpy [ms]."""
    found, whole = [], find_scene("roller-1000rpm")
    for count in COUNTS:
        calls = max(2, min(CALLS, 40_000 // count))
        scene, cams = random_cams(LAW, count * calls)
        tables = [cams[k * count : (k + 1) * count] for k in range(calls)]
        every = cpu_ms(lambda table: evaluate_designs(whole, table), tables)
        three = cpu_ms(lambda table, scene=scene: evaluate_designs(scene, table), tables)
        found.append((count, every, three, cpu_ms(lambda table: by_numpy(LAW, table), tables)))
    return found


def main() -> None:
    print("| designs in a call | all quantities, ms | a design, ms | three, ms | numpy, ms | three / numpy |")
    print("| ---: | ---: | ---: | ---: | ---: | ---: |")
    for count, every, three, rival in rows():
        each, ratio = every / count, three / rival
        print(f"| {count:,} | {every:.2f} | {each:.4f} | {three:.2f} | {rival:.2f} | {ratio:.2f} |")


if __name__ == "__main__":
    main()
