"""Whatever fails, and whenever a run is killed: the older result or the new one is there, whole, and nothing stays.

The faults are those of ``support.faults``, at each call on files.
"""

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from unittest.mock import patch

import pytest
from support.depth import is_deep
from support.faults import FAULTS, Disk, Tree, calls_of, ended, make, tree_of, watched

from camopt import find_scene, sweep, sweep_part
from camopt.files import write_text
from camopt.front.certified import certify_table
from camopt.manifest import settled_path
from camopt.publishing import published

SCENE = find_scene("roller-1000rpm")
SMALL = SCENE.replace(search={"base_radius": [60, 70], "offset": [0], "law": ["harmonic"]})
LARGER = SMALL.replace(**{"search.base_radius": [60, 62, 65, 70]})
TWO_LAWS = LARGER.replace(**{"search.law": ["harmonic", "cycloidal"]})
OLDER = SCENE.replace(search={"base_radius": [60, 65], "offset": [0], "law": ["harmonic"]})
TABLES = ("pareto.parquet", "pareto-grid.parquet", "designs.parquet", "scene.toml")
TEXTS = ("a.txt", "b.txt", "c.txt", "d.txt")


def in_blocks(folder: Path, tell: Callable[[str], None] | None = None) -> None:
    """A sweep whose journal takes each design as soon as it is evaluated."""
    with patch("camopt.front.journal.SECONDS", 0.0):
        sweep(LARGER, folder, workers=1, block=1, tell=tell)


def a_part(folder: Path, tell: Callable[[str], None] | None = None) -> None:
    with patch("camopt.front.journal.SECONDS", 0.0):
        sweep_part(TWO_LAWS, (1, 2), folder, workers=1, tell=tell)


def publish(folder: Path, text: str, names: tuple[str, ...]) -> None:
    with published(folder, "sweep", TEXTS) as unit:
        unit.journal.write_text("half of it")
        for name in names:
            write_text(unit.path(name), f"{text} {name}")


def others(folder: Path) -> None:
    """Results of another command, which stay."""
    with published(folder, "frontier", ("frontier.txt",)) as unit:
        write_text(unit.path("frontier.txt"), "frontier")


def older_sweep(folder: Path) -> None:
    sweep(OLDER, folder, workers=1)
    others(folder)
    shutil.copy(folder / "pareto.parquet", folder / "pareto-grid.parquet")  # as of an older camopt


def older_texts(folder: Path) -> None:
    publish(folder, "older", ("a.txt", "b.txt", "c.txt"))
    others(folder)


def new_texts(folder: Path) -> None:
    publish(folder, "new", ("b.txt", "c.txt", "d.txt"))


@dataclass(frozen=True)
class Case:
    """Some work on a folder, the files that it may write, and what is there before it."""

    work: Callable[[Path], object]
    names: tuple[str, ...]
    older: Callable[[Path], object] | None = None


CASES = {
    "texts": Case(new_texts, TEXTS),
    "texts over older ones": Case(new_texts, TEXTS, older_texts),
    "the same texts again": Case(new_texts, TEXTS, new_texts),
    "nothing over older texts": Case(partial(publish, text="new", names=()), TEXTS, older_texts),
    "a single file": Case(lambda folder: write_text(folder / "a.txt", "new"), TEXTS, older_texts),
    "sweep": Case(partial(sweep, SMALL, workers=1), TABLES),
    "sweep over an older one": Case(partial(sweep, SMALL, workers=1), TABLES, older_sweep),
    "a sweep with a journal": Case(in_blocks, TABLES, older_sweep),
    "a part of a sweep": Case(a_part, ("part-1-of-2/part-1-of-2.sweep",)),
    "certify": Case(
        lambda folder: certify_table(folder / "pareto.parquet"), TABLES, partial(sweep, SMALL, workers=1)
    ),
}
SLOW = {"sweep", "sweep over an older one", "a sweep with a journal", "a part of a sweep", "certify"}
WHOLE = {("texts over older ones", "killed"), ("texts over older ones", "EIO")}
SAMPLE = 5  # points of the other cases in each run


class Bench:
    """A folder in which a case is tried again and again."""

    def __init__(self, case: Case, root: Path) -> None:
        self.case, self.root, self.folder = case, root, root / "out"
        self.work = partial(case.work, self.folder)
        if case.older:
            case.older(self.folder)
        self.before = tree_of(root)
        self.calls = self.rerun()
        self.after = tree_of(root)
        self.older, self.newer = self.seen(self.before), self.seen(self.after)
        make(self.root, self.before)
        self.older_plain = self.plain()
        make(self.root, self.after)
        self.newer_plain = self.plain()
        assert (self.older == self.newer) == (case.older is case.work)

    def seen(self, tree: Tree | None = None) -> dict[str, bytes]:
        """What camopt reads of the files of a result, in a tree or in the folder as it is."""
        if tree is not None:
            make(self.root, tree)
        paths = {name: settled_path(self.folder / name) for name in (*self.case.names, "frontier.txt")}
        return {name: path.read_bytes() for name, path in paths.items() if path.exists()}

    def plain(self) -> dict[str, bytes]:
        """What other programs read."""
        paths = {name: self.folder / name for name in self.case.names}
        return {name: path.read_bytes() for name, path in paths.items() if path.exists()}

    def rerun(self) -> list[str]:
        """Do the work without a fault; its calls on files."""
        return calls_of(self.root, self.work)

    def check(self) -> None:
        """All of one result, and no two side by side."""
        assert self.seen() in (self.older, self.newer)
        plain = self.plain().items()
        assert plain <= self.older.items() or plain <= self.newer.items()


@pytest.fixture(scope="module")
def benches(tmp_path_factory):
    made: dict[str, Bench] = {}

    def bench(name: str) -> Bench:
        if name not in made:
            made[name] = Bench(CASES[name], tmp_path_factory.mktemp("faults"))
        return made[name]

    return bench


def points(name: str, fault: str, count: int) -> range:
    """The calls at which faults are tried: all, or some spread evenly."""
    return range(0, count, 1 if is_deep() or (name, fault) in WHOLE else max(count // SAMPLE, 1))


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("name", CASES)
def test_one_result_is_whole_after_a_fault_and_the_next_run_gives_the_same_bytes(benches, name, fault):
    bench = benches(name)
    for number in points(name, fault, len(bench.calls)):
        make(bench.root, bench.before)
        how, message = ended(bench.root, bench.work, number, fault)
        assert how == "killed" if fault == "killed" else how in ("done", "failed"), (number, message)
        assert how != "failed" or message.startswith(("OSError", "KeyboardInterrupt")), (number, message)
        assert ".camopt" not in message, number
        bench.check()
        assert how != "done" or bench.seen() == bench.newer
        assert not message or how == "failed" or ": published; tidying failed: " in message
        unnamed = ": published, but its files wait for their names" in message
        published = bench.plain() == bench.newer_plain != bench.older_plain
        assert not message.startswith("OSError") or unnamed or not published, (number, message)
        bench.rerun()
        assert tree_of(bench.root) == bench.after


@pytest.mark.parametrize(
    "name",
    [
        "a single file",
        "texts over older ones",
        *(
            pytest.param(name, marks=pytest.mark.long)
            for name in ("texts", "the same texts again", "nothing over older texts")
        ),
    ],
)
def test_one_result_is_whole_after_a_power_cut(benches, name):
    bench = benches(name)
    make(bench.root, bench.before)
    disk, cuts = Disk(bench.root), []

    def after(call, what):
        disk.after(call, what)
        cuts.extend(disk.after_power_cuts())

    with watched(bench.root, lambda *_: None, after):
        bench.work()
    assert all(bench.seen(tree) == bench.newer for tree in disk.after_power_cuts())
    for tree in {repr(tree): tree for tree in cuts}.values():
        make(bench.root, tree)
        bench.check()
        bench.rerun()
        assert tree_of(bench.root) == bench.after


@pytest.mark.parametrize(("name", "work"), [("a sweep with a journal", in_blocks), ("a part of a sweep", a_part)])
def test_a_sweep_that_was_killed_while_it_was_published_goes_on_where_it_was(benches, name, work):
    bench, told = benches(name), []
    staged = bench.calls.index("rename")
    published = bench.calls.index("replace", staged)
    for number in (staged, published, published + 1):
        make(bench.root, bench.before)
        ended(bench.root, bench.work, number, "killed")
        work(bench.folder, told.append)
        assert told.pop() == "going on where an interrupted sweep ended: 4 of 4 designs are done"
        assert tree_of(bench.root) == bench.after
