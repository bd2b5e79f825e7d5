"""Parts of a sweep, evaluated on as many machines as there are, and put together again."""

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from camopt.engines import Engine
from camopt.engines.progress import Progress, with_progress_bar
from camopt.engines.threads import Threads
from camopt.front.blocks import Batch
from camopt.front.estimate import foresee
from camopt.front.journal import (
    Broken,
    Tell,
    all_batches,
    interrupted,
    journal_at,
    question_of,
    recalled,
    what_is_kept,
    whole_batches,
)
from camopt.front.plan import SWEEP_PARTS, SweepKey, SweepPlan, plan_of_key, sweep_plan
from camopt.front.result import Sweep
from camopt.front.streaming import Seen, gathered
from camopt.front.sweep import Beside, Keeps, Write, result_of, swept_already
from camopt.mistakes import BadInput, Mistake
from camopt.quantities.shown import HasHtml
from camopt.scene.scene import Scene
from camopt.storage.files import regular_file
from camopt.storage.manifest import settled_paths
from camopt.storage.publishing import published
from camopt.storage.records import damage_of
from camopt.storage.unit import PART_ENDING, name_of_part
from camopt.verdicts.judging import Effort

PART_COMMAND = "part"
PART_NAME = re.compile(rf"part-(\d{{1,9}})-of-(\d{{1,9}}){re.escape(PART_ENDING)}")
PART_COUNTS = ("designs", "impossible", "feasible")
BLOCKS_OF_A_PART = 8  # at least: parts are of equal size, but for one block
MOST_NAMED = 20  # parts that a message names


@dataclass(frozen=True)
class SweepPart(HasHtml):
    """The result of one part of a sweep.

    Attributes
    ----------
    scene : Scene
        What was asked.
    part, parts : int
        Which part it is, from 1, and of how many.
    designs : int
        Designs of the part.
    impossible : int
        Designs that cannot be assembled.
    feasible : int
        Feasible designs.
    effort : Effort
        Designs that were looked at again.
    file : pathlib.Path
        What ``merge`` reads.
    already_done : bool
        Whether it was there already.

    Examples
    --------
    >>> search = {"base_radius": [60, 90, 120], "law": ["cycloidal"]}
    >>> scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    >>> found = camopt.sweep_part(scene, (1, 1), out="parts")
    >>> found.designs, found.feasible
    (3, 1)
    """

    scene: Scene
    part: int
    parts: int
    designs: int
    impossible: int
    feasible: int
    effort: Effort
    file: Path = field(repr=False)
    already_done: bool = False

    def __repr__(self) -> str:
        return f"<Part {self.part} of {self.parts} of a sweep of {self.scene.name}: {self.designs:,} designs>"


@with_progress_bar("designs")
def sweep_part(  # noqa: PLR0913
    scene: Scene,
    part: tuple[int, int],
    out: str | os.PathLike[str],
    keep: str = "feasible",
    workers: int | None = None,
    progress: Progress | None = None,
    engine: Engine | None = None,
    tell: Tell | None = None,
    again: bool = False,
    beside: Beside | None = None,
) -> SweepPart:
    """Evaluate one of several equal parts of a sweep; ``merge`` puts them together.

    Parts need nothing of each other: each may run on a machine of its own, at any time.

    Parameters
    ----------
    scene : Scene
        As for ``sweep``.
    part : tuple of two int
        Which part, from 1, and of how many: (3, 100).
    out : str or os.PathLike
        Folder of the parts; this one gets a folder inside it, such as ``part-3-of-100``.
    keep : str, default "feasible"
        As for ``sweep``. Boxes of designs that are decided together have no parts.
    workers : int, optional
        Threads; None takes one a core.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (designs done, designs of the whole sweep).
    engine : Engine, optional
        As for ``sweep``.
    tell : callable, optional
        As for ``sweep``.
    again : bool, default False
        As for ``sweep``.
    beside : callable, optional
        As for ``sweep``.

    Returns
    -------
    SweepPart
        Counts, and the file.

    Raises
    ------
    BadInput
        As ``sweep``; for a part that does not exist.
    OSError
        If a file cannot be written, or another run writes to the same part.

    Examples
    --------
    >>> search = {"base_radius": [60, 90, 120], "law": ["cycloidal"]}
    >>> scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    >>> parts = [camopt.sweep_part(scene, (number, 2), out="parts") for number in (1, 2)]
    >>> camopt.merge(["parts"]).designs
    3
    """
    plan, own = _part_of(sweep_plan(scene, keep), part), Threads(workers or os.cpu_count() or 1)
    folder, name = Path(out) / name_of_part(*part), f"{name_of_part(*part)}{PART_ENDING}"
    question, journal = plan.question(*part), None

    def found(answer: Any) -> SweepPart:
        effort = Effort(*answer["effort"])
        counts = {name: answer[name] for name in PART_COUNTS}
        return SweepPart(plan.scene, *part, **counts, effort=effort, file=folder / name, already_done=True)

    if not again and (done := recalled(folder, PART_COMMAND, question, found, tell)):
        return done
    with ExitStack() as stack:
        stack.enter_context(what_is_kept(lambda: journal.kept if journal else ""))
        unit = stack.enter_context(published(folder, PART_COMMAND, (name,), question=question.plain))
        journal = stack.enter_context(journal_at(unit.journal, plan, *part, tell))
        foresee(journal, own, engine or own, tell)
        batches = all_batches(journal, engine or own, tell)
        seen = gathered(plan.space, batches, plan.block, lambda rows: None, progress)
        journal.finish(unit.path(name))
        existing, feasible = seen.existing or 0, seen.feasible or 0
        impossible = seen.evaluated - existing
        result = SweepPart(plan.scene, *part, seen.evaluated, impossible, feasible, seen.effort, folder / name)
        unit.answer = {name: getattr(result, name) for name in PART_COUNTS} | {"effort": [*seen.effort]}
        unit.answer |= beside(result) if beside else {}
    return result


def _part_of(plan: SweepPlan, part: tuple[int, int]) -> SweepPlan:
    """The sweep in blocks of which each part has some; BadInput if there is no such part.

    Rows do not depend on the size of blocks.
    """
    mistakes = []
    if not isinstance(part, (tuple, list)) or [*map(type, part)] != [int, int]:
        why = "two numbers, such as (3, 100): which part, and of how many"
        raise BadInput([Mistake("camopt", "part", part, why)])
    number, parts = part
    if not 1 <= parts <= SWEEP_PARTS:
        mistakes.append(Mistake("camopt", "part", part, f"one of at most {SWEEP_PARTS:,} parts"))
    elif not 1 <= number <= parts:
        mistakes.append(Mistake("camopt", "part", part, f"the number of a part, from 1 to {parts:,}"))
    if mistakes:
        raise BadInput(mistakes)
    return replace(plan, most=min(plan.block, max(len(plan.space) // (BLOCKS_OF_A_PART * parts), 1)))


@with_progress_bar("designs")
def merge(
    parts: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    tell: Tell | None = None,
    again: bool = False,
) -> Sweep:
    """Put the parts of a sweep together: the same result, and files byte for byte, as of one run.

    Parameters
    ----------
    parts : str, os.PathLike or a sequence of these
        Folders with parts in them, or in folders inside them; or the files of parts. All parts of one sweep.
    out : str or os.PathLike, optional
        Folder for the tables, as for ``sweep``; None writes nothing.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (designs done, designs in all).
    tell : callable, optional
        Called with a sentence if it is done already.
    again : bool, default False
        As for ``sweep``.

    Returns
    -------
    Sweep
        As of one run.

    Raises
    ------
    BadInput
        If a part is missing, damaged, there twice, or of another sweep or version of camopt.
    OSError
        If a file cannot be read or written.

    Examples
    --------
    >>> search = {"base_radius": [60, 90, 120], "law": ["cycloidal"]}
    >>> scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    >>> parts = [camopt.sweep_part(scene, (number, 2), out="parts") for number in (1, 2)]
    >>> merged = camopt.merge(["parts"], out="results")
    >>> [file.name for file in merged.files]
    ['designs.parquet', 'pareto.parquet', 'scene.toml']
    """
    places = [parts] if isinstance(parts, (str, os.PathLike)) else [*parts]
    questions, damaged = _questions(_files(places))
    plan = _checked(questions, damaged)
    if out is not None:
        _check_folder(Path(out), plan)
    if out is not None and not again and (done := swept_already(plan, out, tell)):
        return done
    in_order = sorted(questions, key=lambda path: questions[path].part)

    def batches() -> Iterator[Batch]:
        for path in in_order:
            question = questions[path]
            try:
                yield from whole_batches(path, question, plan)
            except Broken as why:
                raise BadInput([_no_part(path, str(why))]) from None

    def searched(kept: Keeps | None, write: Write) -> Seen:
        return gathered(plan.space, batches(), plan.block, write, progress)

    return result_of(plan, out, searched, Threads(os.cpu_count() or 1), progress)


def _check_folder(folder: Path, plan: SweepPlan) -> None:
    """BadInput if an interrupted sweep of another question is kept in a folder: it would go."""
    found = interrupted(folder, "sweep")
    if found and found.asks_other_than(plan.question()):
        why = "another folder: an interrupted sweep is kept in this one, which would go"
        raise BadInput([Mistake("camopt", "out", str(folder), why)])


def _files(places: Iterable[str | os.PathLike[str]]) -> list[Path]:
    """The files of parts in some folders, in folders inside them, or named."""
    found: dict[Path, None] = {}
    for place in map(Path, places):
        place.stat()  # an OSError if there is none
        if not place.is_dir():
            found[place] = None
            continue
        folders = [place, *sorted(each for each in place.iterdir() if each.is_dir())]
        files = [file for folder in folders for file in settled_paths(folder, f"*{PART_ENDING}")]
        if not files:
            raise BadInput([Mistake("camopt", "part", str(place), "a folder with parts of a sweep; this has none")])
        found |= dict.fromkeys(files)
    return [*found]


def _questions(files: Iterable[Path]) -> tuple[dict[Path, SweepKey], list[Mistake]]:
    """The keys of files, and messages for files that are no parts, or damaged."""
    questions: dict[Path, SweepKey] = {}
    mistakes: list[Mistake] = []
    scenes: dict[SweepKey, str] = {}
    for path in files:
        with regular_file(path) as file:
            damage = damage_of(file)
        question = question_of(path)
        if question is None:
            mistakes.append(_no_part(path, "this is none, or damaged at its beginning"))
            continue
        if question.whole not in scenes:
            scenes[question.whole] = _oddity(question.whole)
        if odd := scenes[question.whole] or _other_than_named(path, question):
            mistakes.append(_no_part(path, odd))
            continue
        questions[path] = question
        if damage:
            mistakes.append(_no_part(path, f"this is {damage}"))
    return questions, mistakes


def _oddity(question: SweepKey) -> str:
    """The fault of the key of a part; empty if there is none."""
    try:
        plan_of_key(question)
    except BadInput as refused:
        first = refused.mistakes[0]
        return f"its scene has mistakes, such as {first.key}: {first.allowed}"
    return ""


def _other_than_named(path: Path, question: SweepKey) -> str:
    """The part that a file really is, if its name says otherwise; empty if they agree."""
    named = _named(path)
    if named in (None, (question.part, question.parts)):
        return ""
    return f"it says of itself that it is part {question.part} of {question.parts}"


def _named(path: Path) -> tuple[int, int] | None:
    """The number of a part and of all parts, by the name of a file."""
    found = PART_NAME.fullmatch(path.name)
    return (int(found[1]), int(found[2])) if found else None


def _no_part(path: Path, why: str) -> Mistake:
    return Mistake("camopt", "part", str(path), f"a whole part of a sweep; {why}")


def _checked(questions: dict[Path, SweepKey], mistakes: list[Mistake]) -> SweepPlan:
    """The sweep of parts; BadInput with all mistakes if they are not all the parts of one sweep."""
    if not questions:
        raise BadInput(mistakes or [Mistake("camopt", "part", None, "missing", bare=True)])
    first = next(iter(questions))
    whole, parts = questions[first].whole, questions[first].parts
    refused = {named[0] for each in mistakes if (named := _named(Path(str(each.value))))}
    by_part: dict[int, list[Path]] = {}
    for path, question in questions.items():
        if question.whole != whole or question.parts != parts:
            other = ", ".join(name for name in question.other_than(questions[first]) if name != "part")
            why = f"a part of the same sweep as {first}; it differs in {other}"
            mistakes.append(Mistake("camopt", "part", str(path), why))
        else:
            by_part.setdefault(question.part, []).append(path)
    for part, paths in by_part.items():
        if len(paths) > 1:
            why = f"there more than once: {', '.join(map(str, paths))}"
            mistakes.append(Mistake("camopt", "part", part, why, bare=True))
    if missing := [part for part in range(1, parts + 1) if part not in by_part and part not in refused]:
        listed = ", ".join(map(str, missing[:MOST_NAMED])) + (" …" if len(missing) > MOST_NAMED else "")
        why = f"not complete: of {parts} parts there is no part {listed}"
        mistakes.append(Mistake("camopt", "parts", None, why, bare=True))
    plan = plan_of_key(whole)
    if plan.question().version != whole.version:
        why = f"of this version of camopt and its kernels ({plan.question().version}), not {whole.version}"
        mistakes.append(Mistake("camopt", "parts", None, why))
    if mistakes:
        raise BadInput(mistakes)
    return plan
