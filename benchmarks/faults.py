"""Count what faults leave of results, by commands alone: ``python benchmarks/faults.py [MOST [CASE …]]``.

A fault meets a command at each of its calls on files: the command is killed, killed in mid-write or
interrupted, or the call fails. A blind restart is a kill after a random CPU time, three times in a row. A power
cut after a call loses any of the names and contents that are not synced. Then files are altered: those of a
killed command ("altered work") and those of a result, by a turned bit, a cut, a removal, or the file of an
older run ("foreign").

A try is good if three things hold. Plain pandas and ``camopt.load`` find rows of one result only, the older or
the new one, or fewer tables of it. ``camopt check`` does not call a damaged result whole. The same command then
ends with the same rows as without a fault. At most MOST tries of each fault, or somewhat more, are spread
evenly (0, the default: all). With 0.5, a case tries every second fault once, and the next case the others.

The tool knows commands and the rows of tables, but not how results are stored: it judges any store.
"""

import os
import sys
import tomllib
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module
from math import ceil
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from time import process_time
from traceback import extract_tb
from typing import Any, NamedTuple

import pandas as pd
import pyarrow as pa

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.faults import FAULTS, Disk, End, Tree, calls_of, make, run_forked, tree_of, watch_calls, with_fault

import camopt
from camopt.__main__ import main as camopt_main

RESTARTS = 60
FOUND, REFUSED, TROUBLE, INTERRUPTED, KILLED = 0, 2, 3, 130, range(-64, 0)
"""Exit codes."""
Read = dict[str, Any]
"""What is read of each file of a result, by its name."""
Alter = Callable[[bytes, bytes | None], bytes | None]
"""What a bad disk or a hand makes of a file; an older file of its name is known."""


class Case(NamedTuple):
    """A command, those of the older result and of what it reads, and those that bring its result to ``out``."""

    command: str
    older: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    later: tuple[str, ...] = ()


OLDER = ("sweep scenes/older.toml --keep all --out out", "optimise scenes/older.toml --out out")
PARTS = tuple(f"sweep scenes/new.toml --part {i}/2 --out parts" for i in (1, 2))
CASES = {
    "sweep": Case("sweep scenes/new.toml --out out"),
    "sweep over an older one": Case("sweep scenes/new.toml --out out", OLDER),
    "sweep --keep front-only": Case("sweep scenes/new.toml --keep front-only --out out", OLDER),
    "sweep --again": Case("sweep scenes/new.toml --again --out out", ("sweep scenes/new.toml --out out",)),
    "sweep --resume, of seconds": Case("sweep scenes/slow.toml --keep all --resume --out out"),
    "sweep --refine": Case("sweep scenes/one.toml --refine --out out", OLDER),
    "sweep --part": Case(
        "sweep scenes/new.toml --part 1/2 --out parts",
        ("sweep scenes/older.toml --part 1/2 --out parts",),
        PARTS[1:],
        ("merge parts --out out",),
    ),
    "merge": Case("merge parts --out out", OLDER, PARTS),
    "certify": Case("certify out/pareto.parquet", inputs=("sweep scenes/new.toml --out out",)),
    "optimise": Case("optimise scenes/one.toml --out out", OLDER),
    "report": Case("report out --out out/page.html", ("report roller-1000rpm --out out/page.html",), OLDER),
    "new": Case("new roller-1000rpm out/cam.toml", inputs=OLDER),
    **{
        f"export {ending}": Case(
            f"export scenes/new.toml out/cam{ending} --set part.thickness=12{options}",
            (f"export exhaust-valve out/cam{ending} --set part.thickness=12{options}",),
            OLDER,
        )
        for ending, options in {".dxf": "", ".step": "", ".csv": "", ".nc": " --cutter-radius 5 --feed 300"}.items()
    },
}


def scenes() -> dict[str, camopt.Scene]:
    """The scenes of the cases."""
    scene = camopt.find_scene("roller-1000rpm")
    axes = {"offset": [0], "roller_radius": [10, 12]}
    return {
        "older": scene.replace(search=axes | {"base_radius": [80, 95], "law": ["cycloidal", "poly345"]}),
        "new": scene.replace(search=axes | {"base_radius": [60, 62, 65, 70], "law": ["harmonic", "cycloidal"]}),
        "one": scene.replace(search=axes | {"base_radius": [62, 65, 70], "law": ["harmonic"]}),
        "slow": scene.replace(
            search=axes | {"base_radius": {"start": 40, "stop": 120, "step": 0.002}, "law": ["harmonic", "poly345"]}
        ),
    }


def run(command: str) -> int:
    """Run a command as it is typed; the exit code."""
    sys.argv = ["camopt", *command.split(), "--quiet"]
    return camopt_main()


def value_of(path: Path) -> Any:
    """What a file says: rows of a table as plain pandas reads it, keys of a scene, or else bytes."""
    if path.suffix == ".parquet":
        return pd.read_parquet(path).to_csv()
    return tomllib.loads(path.read_text(encoding="utf-8")) if path.suffix == ".toml" else path.read_bytes()


def tables_of(found: Read) -> Read:
    return {name: rows for name, rows in found.items() if name.endswith(".parquet")}


def is_of_one(found: Read, results: Sequence[Read]) -> bool:
    """Whether all that is read is of one result."""
    return any(found.items() <= result.items() for result in results)


def damaged(data: bytes, older: bytes | None, share: float = 0.5) -> bytes:
    """With a bit turned after a share of the bytes."""
    place = int(share * len(data))
    return data[:place] + bytes([data[place] ^ 4]) + data[place + 1 :]


def cut_short(data: bytes, older: bytes | None) -> bytes:
    return data[: len(data) // 2]


def missing(data: bytes, older: bytes | None) -> None:
    return None


def foreign(data: bytes, older: bytes | None) -> bytes:
    """That of another run, where there is one."""
    return older or data


ALTERED = (*(partial(damaged, share=share) for share in (0.03, 0.3, 0.5, 0.7, 0.97)), cut_short, missing)


class Bench:
    """A folder in which a case is tried again and again."""

    def __init__(self, case: Case, root: Path) -> None:
        self.case, self.root, self.out = case, root, root / "out"
        os.chdir(root)
        (root / "scenes").mkdir()
        for name, scene in scenes().items():
            (root / "scenes" / f"{name}.toml").write_text(scene.to_toml(), encoding="utf-8")
        empty = tree_of(root)
        self.do(*case.inputs, case.command, *case.later)
        alone = tables_of(self.plain())
        make(root, empty)
        self.do(*case.inputs, *case.older)
        self.before, self.older = tree_of(root), self.plain()
        modules = run_forked(lambda: [run(case.command), [*sys.modules]]).result[1]
        for module in modules:  # imported once, for all copies of this process
            with suppress(Exception):
                import_module(module)
        make(root, self.before)
        self.calls, self.seconds = run_forked(self._counted).result
        self.after = tree_of(root)
        self.do(*case.later)
        self.newer = self.plain()
        self.checked, self.newer_rows = self.check(), self.loaded()
        make(root, self.before)
        self.older_rows = self.loaded()
        assert self.newer
        assert alone == tables_of(self.newer) or not alone, "tables of an older result stay"
        assert (self.older == self.newer) == ("--again" in case.command)

    def _counted(self) -> tuple[int, float]:
        start = process_time()
        calls = calls_of(self.root, partial(run, self.case.command))
        return len(calls), process_time() - start

    def do(self, *commands: str) -> None:
        """Run commands that have to end well."""
        for command in commands:
            code, said, _ = run_forked(partial(run, command))
            assert code == FOUND, (command, code, said)

    def plain(self) -> Read:
        """What other programs read: no hidden files, and not what says which files are of a result."""
        files = [path for path in sorted(self.out.glob("[!.]*")) if path.is_file() and path.name != "manifest.json"]
        return {path.name: value_of(path) for path in files}

    def loaded(self) -> Read:
        """What camopt reads of tables, without those that it refuses."""
        rows = {}
        for name in sorted({*self.older, *self.newer} if hasattr(self, "newer") else self.older):
            if name.endswith(".parquet"):
                try:
                    rows[name] = camopt.load(self.out / name).to_csv()
                except (camopt.BadInput, OSError):
                    continue
        return rows

    def check(self) -> int:
        """The exit code of ``camopt check``."""
        folders = [name for name in ("out", "parts") if (self.root / name).exists()]
        return run_forked(partial(run, " ".join(["check", *folders]))).code if folders else REFUSED

    def judge(self, is_done: bool = False) -> None:
        """All of one result, no two side by side, and nothing is called whole that is not."""
        plain, rows, code = self.plain(), self.loaded(), self.check()
        assert is_of_one(plain, (self.older, self.newer)), "two results side by side"
        assert is_of_one(rows, (self.older_rows, self.newer_rows)), "rows of two results are read"
        assert code in (FOUND, REFUSED, TROUBLE), code
        whole = rows in (self.older_rows, self.newer_rows)
        assert code != FOUND or whole, "what is not whole is called so"
        assert not is_done or self.case.later or rows == self.newer_rows, "it is not done"

    def is_refused(self) -> bool:
        """Whether the command no longer runs: `new` does not write a file that exists."""
        return self.case.command.startswith("new ") and self.plain() == self.newer

    def finish(self) -> None:
        """The same command goes on to the same rows."""
        if not self.is_refused():
            self.do(self.case.command, *self.case.later)
        assert self.plain() == self.newer, "other values"
        assert self.loaded() == self.newer_rows, "other rows"
        assert self.check() == self.checked

    def faulty(self, number: int, fault: str) -> End:
        """Run the command with a fault."""
        end = with_fault(self.root, partial(run, self.case.command), number, fault)
        assert "Traceback" not in end.said, end.said
        assert end.code in (
            (FOUND, *KILLED) if fault in ("killed", "torn", "blind") else (FOUND, TROUBLE, INTERRUPTED)
        ), end
        self.judge(end.code == FOUND)
        return end

    def try_fault(self, number: int, fault: str) -> None:
        make(self.root, self.before)
        end = self.faulty(number, fault)
        published = end.code == TROUBLE and self.plain() == self.newer != self.older
        assert not published or "published" in end.said or self.case.later, end.said
        self.finish()

    def try_blind_restarts(self, seed: int) -> None:
        make(self.root, self.before)
        draw = Random(seed)
        for _ in range(3):
            if not self.is_refused():
                self.faulty(1 + int(draw.uniform(0, 1000 * self.seconds)), "blind")
        self.finish()

    def after_power_cuts(self) -> list[Tree]:
        """What a power cut at any moment of the command may leave, each once."""
        make(self.root, self.before)

        def cut() -> list[Tree]:
            disk, cuts = Disk(self.root), {}

            def after(call: str, what: Any) -> None:
                disk.after(call, what)
                cuts.update((repr(tree), tree) for tree in disk.after_power_cuts())

            with watch_calls(self.root, lambda *_: None, after):
                run(self.case.command)
            return [*cuts.values()]

        trees: list[Tree] = run_forked(cut).result
        return trees

    def try_power_cut(self, tree: Tree) -> None:
        make(self.root, tree)
        self.judge()
        self.finish()

    def left_when_killed(self, number: int) -> Tree:
        """What the command leaves if it is killed at one of its calls on files."""
        make(self.root, self.before)
        with_fault(self.root, partial(run, self.case.command), number, "killed")
        return tree_of(self.root)

    def altered(self, tree: Tree, alter: Alter) -> list[Tree]:
        """Trees in which one file that the command wrote is altered."""
        found = []
        for name, data in tree.items():
            older, is_told = self.before.get(name), alter is missing and name.endswith("manifest.json")
            if data and data != older and not is_told and (altered := alter(data, older)) != data:
                left = {each: content for each, content in tree.items() if each != name}
                found.append(left if altered is None else {**left, name: altered})
        return found

    def try_altered_result(self, tree: Tree) -> None:
        make(self.root, tree)
        assert self.check() != FOUND or self.checked != FOUND, "what is altered is called whole"
        assert is_of_one(self.loaded(), (self.newer_rows,)), "what is altered is read in silence"
        for command in (*self.case.later, self.case.command, *self.case.later):
            code, said, _ = run_forked(partial(run, command))
            assert code in (FOUND, REFUSED, TROUBLE), said
            assert said or code == FOUND
            assert code != FOUND or command not in (self.case.later or (command,)) or self.plain() == self.newer

    def try_altered_work(self, tree: Tree) -> None:
        make(self.root, tree)
        assert is_of_one(self.loaded(), (self.older_rows, self.newer_rows)), "rows of two results are read"
        self.finish()

    def tries(self) -> dict[str, Sequence[Callable[[], None]]]:
        """All tries by the name of their fault."""
        left = [self.left_when_killed(int(share * self.calls)) for share in (0.3, 0.6)]
        return {
            **{fault: [partial(self.try_fault, n, fault) for n in range(self.calls)] for fault in FAULTS},
            "blind restarts": [partial(self.try_blind_restarts, seed) for seed in range(RESTARTS)],
            "power cut": [partial(self.try_power_cut, tree) for tree in self.after_power_cuts()],
            "altered work": [
                partial(self.try_altered_work, tree)
                for killed in left
                for alter in ALTERED
                for tree in self.altered(killed, alter)
            ],
            "altered result": [
                partial(self.try_altered_result, tree)
                for alter in ALTERED
                for tree in self.altered(self.after, alter)
            ],
            "foreign result": [
                partial(self.try_altered_result, tree) for tree in self.altered(self.after, foreign)
            ],
        }


def spread(tries: Sequence[Callable[[], None]], most: int) -> Sequence[Callable[[], None]]:
    """So many of them at most, or somewhat more, spread evenly; 0: all."""
    step = max(len(tries) // most, 1) if most else 1
    return tries[step // 2 :: step]


def wrong_of(tries: Sequence[Callable[[], None]]) -> list[str]:
    """What goes wrong when all are tried."""
    wrong = []
    for attempt in tries:
        try:
            attempt()
        except Exception as fault:
            what = attempt.args if isinstance(attempt.args[0], int) else ""
            lines = [each.line for each in extract_tb(fault.__traceback__) if each.filename == __file__]
            wrong.append(f"{what} {type(fault).__name__} {fault} ({lines[-1]})".strip())
    return wrong


def main(most: float = 0, *names: str) -> int:
    """Try all; print how many were good, of how many, as a row for each case, and below what went wrong."""
    heads = [*FAULTS, "blind restarts", "power cut", "altered work", "altered result", "foreign result"]
    print("| case | ", " | ".join(heads), " |\n|---|", "---:|" * len(heads), sep="", flush=True)
    faults = 0
    for number, name in enumerate(names or CASES):
        with TemporaryDirectory() as folder:
            tries = {
                fault: spread(every, ceil(most)) if most in (0, ceil(most)) or (place + number) % 2 else ()
                for place, (fault, every) in enumerate(Bench(CASES[name], Path(folder)).tries().items())
            }
            wrong = {fault: wrong_of(some) for fault, some in tries.items()}
            os.chdir("/")
        cells = [f"{len(tries[fault]) - len(wrong[fault])} of {len(tries[fault])}" for fault in heads]
        print(f"| {name} |", " | ".join(cells), "|", flush=True)
        for fault in heads:
            for each in wrong[fault][:5]:
                print(f"{name}, {fault}: {each}", file=sys.stderr, flush=True)
            faults += len(wrong[fault])
    return min(faults, 1)


if __name__ == "__main__":
    pa.set_cpu_count(1)  # no thread of a library that a copy of this process would lack
    sys.exit(main(*map(float, sys.argv[1:2]), *sys.argv[2:]))
