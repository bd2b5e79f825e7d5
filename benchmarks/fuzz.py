"""How many scenes that went wrong at random end how: ``python fuzz.py [CASES] [PROCESSES] [FIRST]``.

Each case is a shipped scene, changed, and a command. A fault is a traceback, a hang (more than a minute of the
processor), a NaN in what is printed or written, or a message that is no line, or longer than one reads.
``fuzz.py --case NUMBER`` shows one.
"""

import os
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.fuzzed import case, outcome

SECONDS = 60.0
TOGETHER = 250


def tried(numbers: range) -> tuple[Counter, list[str]]:
    """How some cases end: by command and exit code; and what is wrong."""
    counts, wrong = Counter(), []
    for number in numbers:
        found = outcome(*case(number), SECONDS)
        counts[found.command.partition(" ")[0], found.code] += 1
        if found.faults:
            wrong.append(f"{number} {found.command}: {', '.join(found.faults)}: {found.err.strip()[-200:]}")
    return counts, wrong


def main(cases: int = 100_000, processes: int = 1, first: int = 0) -> int:
    counts, faults, done = Counter(), 0, 0
    blocks = [range(start, min(start + TOGETHER, first + cases)) for start in range(first, first + cases, TOGETHER)]
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn"), initializer=partial(os.nice, 19)) as pool:
        for block, (some, wrong) in zip(blocks, pool.map(tried, blocks), strict=True):
            counts, faults, done = counts + some, faults + len(wrong), done + len(block)
            print(*wrong, f"{done} cases, {faults} faults", sep="\n", flush=True)
    for (command, code), count in sorted(counts.items()):
        print(f"{command:10} exit code {code:3}  {count:7}")
    return min(faults, 1)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--case"]:
        command, text = case(int(sys.argv[2]))
        print(f"camopt {command}\n{text.decode(errors='replace')}")
    else:
        sys.exit(main(*map(int, sys.argv[1:])))
