"""Whatever fails, and whenever a run is killed: the older result or the new one is there, whole, and nothing stays.

The faults are those of ``support.faults``, at each call on files.
"""

import shutil
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Any, TypeVar
from unittest.mock import patch
from warnings import warn

import pytest
from support.depth import is_deep
from support.faults import FAULTS, Disk, Tree, calls_of, ended, make, tree_of, watched

from camopt import export, find_scene, merge, sweep, sweep_part
from camopt.cli import exits
from camopt.cli.main import main
from camopt.exporting.endings import ENDINGS
from camopt.front.certified import certify_table
from camopt.storage.files import Untidy, write_text
from camopt.storage.manifest import settled_path
from camopt.storage.publishing import published

Try = TypeVar("Try")
SCENE = find_scene("roller-1000rpm")
SMALL = SCENE.replace(search={"base_radius": [60, 70], "offset": [0], "law": ["harmonic"]})
LARGER = SMALL.replace(**{"search.base_radius": [60, 62, 65, 70]})
TWO_LAWS = LARGER.replace(**{"search.law": ["harmonic", "cycloidal"]})
OLDER = SCENE.replace(search={"base_radius": [60, 65], "offset": [0], "law": ["harmonic"]})
TABLES = ("pareto.parquet", "pareto-grid.parquet", "designs.parquet", "scene.toml")
TEXTS = ("a.txt", "b.txt", "c.txt", "d.txt")
OPTIMA = tuple(f"optimum-{law}.toml" for law in ("harmonic", "cycloidal", "poly345"))
MILLED = {"cutter_radius": 5.0, "feed": 300.0}
MACHINE = {".nc": MILLED, ".mpf": MILLED, ".h": MILLED, ".p": {"cutter_radius": 5.0}}
"""What the files of some machines need."""
INTERRUPTED = 130


def in_blocks(folder: Path, tell: Callable[[str], None] | None = None) -> None:
    """A sweep whose journal takes each design as soon as it is evaluated."""
    with patch("camopt.front.journal.RECORD_SECONDS", 0.0):
        sweep(LARGER, folder, workers=1, block=1, tell=tell)


def a_part(folder: Path, tell: Callable[[str], None] | None = None) -> None:
    with patch("camopt.front.journal.RECORD_SECONDS", 0.0):
        sweep_part(TWO_LAWS, (1, 2), folder, workers=1, tell=tell)


def a_command(*words: str) -> None:
    """A command as it is typed; what it says of a fault is raised."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()) as told:
        code = main([*words, "--quiet"])
    said = told.getvalue().strip()  # an interrupt ends the line of its ^C first
    assert said.count("\n") == 0
    if code == exits.FILE_TROUBLE:
        raise OSError(said)
    if code == INTERRUPTED:
        raise KeyboardInterrupt(said)
    assert code == 0
    if said:
        warn(said, Untidy, stacklevel=2)


def optimised(folder: Path, laws: str = "new") -> None:
    a_command("optimise", str(folder.parent / f"{laws}.toml"), "--out", str(folder))


def older_optimum(folder: Path) -> None:
    for name, laws in (("older", ["cycloidal", "poly345"]), ("new", ["harmonic", "cycloidal"])):
        scene = SCENE.replace(search={"law": laws})  # of one size, which is found at once
        (folder.parent / f"{name}.toml").write_text(scene.to_toml(), encoding="utf-8")
    optimised(folder, "older")


def exported(folder: Path, ending: str, scene: str = "roller-1000rpm") -> None:
    folder.mkdir(exist_ok=True)
    cam = find_scene(scene).replace(part={"thickness": 12})
    export(cam, folder / f"cam{ending}", **MACHINE.get(ending, {}))


def started(folder: Path) -> None:
    """A scene to start from, where there is none: ``new`` writes over no file."""
    if not (folder / "cam.toml").exists():
        a_command("new", "feeder", str(folder / "cam.toml"))


def two_parts(folder: Path) -> None:
    """Parts beside a folder with an older sweep."""
    older_sweep(folder)
    for part in (1, 2):
        sweep_part(TWO_LAWS, (part, 2), folder.parent / "parts", workers=1)


def merged(folder: Path) -> None:
    merge(folder.parent / "parts", folder)


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
    "a part over one of another sweep": Case(
        a_part, ("part-1-of-2/part-1-of-2.sweep",), lambda folder: sweep_part(OLDER, (1, 2), folder, workers=1)
    ),
    "merge": Case(merged, TABLES, two_parts),
    "optimise": Case(optimised, OPTIMA, older_optimum),
    "new": Case(started, ("cam.toml",), Path.mkdir),
    **{
        f"export {ending}": Case(
            partial(exported, ending=ending),
            (f"cam{ending}",),
            partial(exported, ending=ending, scene="exhaust-valve"),
        )
        for ending in ENDINGS
    },
    "certify": Case(
        lambda folder: certify_table(folder / "pareto.parquet"), TABLES, partial(sweep, SMALL, workers=1)
    ),
}
CHEAP = {name for name in CASES if not name.startswith("export") or name in ("export .txt", "export .toml")}
WHOLE = {("texts over older ones", fault) for fault in ("killed", "EIO", "power cut")}
SAMPLE = 5  # points of the other cases in each run, at least


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
        self.rerun()
        self.again = tree_of(root)  # the same, but for the names of the older files, which are gone
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

    def check_next_run(self) -> None:
        """It gives the same bytes, and leaves nothing else."""
        self.rerun()
        assert tree_of(self.root) in (self.after, self.again)

    def try_fault(self, number: int, fault: str) -> str:
        """Do the work with a fault at one of its calls on files, and then without one: how it ended at first."""
        make(self.root, self.before)
        how, message = ended(self.root, self.work, number, fault)
        assert how == "killed" if fault == "killed" else how in ("done", "failed"), (number, message)
        assert how != "failed" or message.startswith(("OSError", "KeyboardInterrupt")), (number, message)
        assert ".camopt" not in message, number
        self.check()
        assert how != "done" or self.seen() == self.newer
        assert not message or how == "failed" or ": published; tidying failed: " in message
        unnamed = ": published, but its files wait for their names" in message
        published = self.plain() == self.newer_plain != self.older_plain
        assert not message.startswith("OSError") or unnamed or not published, (number, message)
        self.check_next_run()
        return how

    def after_power_cuts(self) -> list[Tree]:
        """What a power cut at any moment of the work may leave, each once."""
        make(self.root, self.before)
        disk, cuts = Disk(self.root), []

        def after(call, what):
            disk.after(call, what)
            cuts.extend(disk.after_power_cuts())

        with watched(self.root, lambda *_: None, after):
            self.work()
        assert all(self.seen(tree) == self.newer for tree in disk.after_power_cuts())
        return list({repr(tree): tree for tree in cuts}.values())

    def try_power_cut(self, tree: Tree) -> None:
        """Go on from what a power cut left."""
        make(self.root, tree)
        self.check()
        self.check_next_run()


@pytest.fixture(scope="module")
def benches(tmp_path_factory):
    made: dict[str, Bench] = {}

    def bench(name: str) -> Bench:
        if name not in made:
            made[name] = Bench(CASES[name], tmp_path_factory.mktemp("faults"))
        return made[name]

    return bench


def spread(tries: Sequence[Try], most: int) -> Sequence[Try]:
    """So many of them at most, spread evenly; 0: all."""
    return tries[:: max(len(tries) // most, 1)] if most else tries


def sample(name: str, fault: str) -> int:
    """How many points of a case are tried in each run; 0: all."""
    return 0 if is_deep() or (name, fault) in WHOLE else SAMPLE


def everyday(name: str) -> Any:
    """The name of a case for each run, or for ``.ci/deep``."""
    return name if name in CHEAP else pytest.param(name, marks=pytest.mark.long)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("name", [*map(everyday, CASES)])
def test_one_result_is_whole_after_a_fault_and_the_next_run_gives_the_same_bytes(benches, name, fault):
    bench = benches(name)
    for number in spread(range(len(bench.calls)), sample(name, fault)):
        bench.try_fault(number, fault)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", [*map(everyday, CASES)])
def test_one_result_is_whole_after_a_power_cut(benches, name):
    bench = benches(name)
    for tree in spread(bench.after_power_cuts(), sample(name, "power cut")):
        bench.try_power_cut(tree)


@pytest.mark.parametrize(("name", "work"), [("a sweep with a journal", in_blocks), ("a part of a sweep", a_part)])
def test_a_sweep_that_was_killed_while_it_was_published_goes_on_where_it_was(benches, name, work):
    bench, told = benches(name), []
    staged = bench.calls.index("rename")
    published = bench.calls.index("replace", staged)
    for number in (staged, published, published + 1):
        make(bench.root, bench.before)
        ended(bench.root, bench.work, number, "killed")
        work(bench.folder, told.append)
        done, goes_on = "already done: ", "going on where an interrupted sweep ended: 4 of 4 designs are done"
        assert told.pop().startswith(done if number > published else goes_on)
        assert tree_of(bench.root) == bench.after
