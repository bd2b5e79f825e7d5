"""How many scenes that went wrong at random end how: ``python fuzz.py [--misfits] [CASES] [PROCESSES] [FIRST]``.

Each case is a shipped scene, changed, and a command. A fault is a traceback, a hang (more than a minute of the
processor), a NaN in what is printed or written, or a message that is no line, or longer than one reads.
With ``--misfits`` the changes are lists, tables and endless numbers where words and numbers belong, in all tables.
``fuzz.py [--misfits] --case NUMBER`` shows one.
"""

import os
import sys
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.fuzzed import case, misfit_case, outcome

SECONDS = 60.0
TOGETHER = 250


def tried(made: Callable[[int], tuple[str, bytes]], numbers: range) -> tuple[Counter, list[str]]:
    """How some cases end: by command and exit code; and what is wrong."""
    counts, wrong = Counter(), []
    for number in numbers:
        found = outcome(*made(number), SECONDS)
        counts[found.command.partition(" ")[0], found.code] += 1
        if found.faults:
            wrong.append(f"{number} {found.command}: {', '.join(found.faults)}: {found.err.strip()[-200:]}")
    return counts, wrong


def main(made: Callable[[int], tuple[str, bytes]], cases: int = 100_000, processes: int = 1, first: int = 0) -> int:
    counts, faults, done = Counter(), 0, 0
    blocks = [range(start, min(start + TOGETHER, first + cases)) for start in range(first, first + cases, TOGETHER)]
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn"), initializer=partial(os.nice, 19)) as pool:
        for block, (some, wrong) in zip(blocks, pool.map(partial(tried, made), blocks), strict=True):
            counts, faults, done = counts + some, faults + len(wrong), done + len(block)
            print(*wrong, f"{done} cases, {faults} faults", sep="\n", flush=True)
    for (command, code), count in sorted(counts.items()):
        print(f"{command:10} exit code {code:3}  {count:7}")
    return min(faults, 1)


if __name__ == "__main__":
    _, *arguments = sys.argv
    made = misfit_case if "--misfits" in arguments else case
    arguments = [each for each in arguments if each != "--misfits"]
    if arguments[:1] == ["--case"]:
        command, text = made(int(arguments[1]))
        print(f"camopt {command}\n{text.decode(errors='replace')}")
    else:
        sys.exit(main(made, *map(int, arguments)))
