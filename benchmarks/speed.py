"""What two commits cost: CPU seconds of the same tasks, measured in turns, and instructions.

Kernels are compiled before anything is measured, for each commit in a folder of its own, which is kept.
Instructions are counted where valgrind is.
"""

from collections.abc import Callable, Iterable, Sequence

import callgrind
from record import Change, Measures, cautious, changes, least, middle, table, with_counts
from sides import Side, say
from tasks import COUNTED

ROUNDS, MOST_ROUNDS = 5, 15
COUNTINGS = 2  # the first of a new environment may count what compiles
SLOWER, MORE = 0.10, 0.03  # allowed of one commit against another: time, instructions


def countable() -> list[str]:
    """The tasks whose instructions can be counted here."""
    absent = callgrind.missing()
    if absent:
        say(f"no instructions are counted, for lack of {absent}")
    return [] if absent else list(COUNTED)


def repeated(
    tasks: list[str],
    measure: Callable[[int, list[str]], None],
    suspects: Callable[[], list[str]],
) -> None:
    """Measure all tasks for a few rounds, and then those in doubt until there are none, or it is enough.

    The least of several times only falls: of equal commits it becomes equal, of a slower one it stays slower.
    """
    for turn in range(MOST_ROUNDS):
        names = tasks if turn < ROUNDS else suspects()
        if not names:
            return
        say(f"round {turn + 1}: {len(names)} tasks")
        measure(turn, names)


def compared(sides: Sequence[Side], tasks: list[str], to_count: list[str]) -> list[Change]:
    """Measure two commits in turns."""
    for side in sides:
        side.warm(tasks)
    rounds: list[list[Measures]] = [[], []]

    def measure(turn: int, names: list[str]) -> None:
        for k in (0, 1) if turn % 2 == 0 else (1, 0):
            rounds[k].append(sides[k].timed(names, "own"))

    def doubtful() -> list[str]:
        return named(each for each in seen(rounds) if each.doubtful)

    repeated(tasks, measure, doubtful)
    if lost := [task for task in least(rounds[0]) if task not in least(rounds[1])]:
        raise SystemExit(f"{sides[1].name} cannot do what {sides[0].name} can: {', '.join(lost)}")
    return seen(rounds, [least(side.counted(to_count) for _ in range(COUNTINGS)) for side in sides])


def seen(rounds: list[list[Measures]], counts: Sequence[Measures] = ({}, {})) -> list[Change]:
    """What has changed between two sides, by the least of their rounds and by the middle one.

    A quiet moment of a busy machine makes a least time, a few busy ones a median; only a slower commit makes both.
    """
    both = []
    for chosen in (least, middle):
        both.append(changes(*map(with_counts, map(chosen, rounds), counts), SLOWER, MORE))
    return cautious(*both)


def named(found: Iterable[Change]) -> list[str]:
    """The tasks of changes, each once."""
    return list(dict.fromkeys(each.task for each in found))


def failing(found: Iterable[Change]) -> list[str]:
    """The tasks that cost more than is allowed."""
    return named(each for each in found if each.failed)


def verdict(found: list[Change]) -> int:
    """Print a table of changes; the exit code."""
    print(table(found))
    failed = failing(found)
    print(f"\ncosts too much: {', '.join(failed)}" if failed else "\nnothing costs more than is allowed")
    return 1 if failed else 0
