"""Parts of a sweep, each evaluated on a machine of its own (``sweep_part``), and their union (``merge``)."""

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from camopt.core.engines import Engine
from camopt.core.engines.progress import Progress, with_progress_bar
from camopt.core.engines.threads import Threads
from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.manifest import (
    DamagedManifest,
    Manifest,
    file_matches_entry,
    read_manifest,
    read_manifest_or_empty,
)
from camopt.core.storage.publishing import publication, published_answer_to_same_question
from camopt.scene.arguments import SceneSource, allow_positional_options, check_count, scene_from
from camopt.scene.problem.scene_notes import notes_on_search
from camopt.scene.scene import Scene
from camopt.solve.front.blocks import BlockBatch, gather_batches
from camopt.solve.front.estimate import announce_estimate
from camopt.solve.front.plan import SWEEP_PARTS, SweepKey, SweepPlan, key_from_manifest, plan_of_key, sweep_plan
from camopt.solve.front.result import Sweep, undecided_and_recheck_counts
from camopt.solve.front.store import (
    BATCH_FILES,
    QUESTION_FILE,
    BrokenBatch,
    MessageSink,
    Store,
    interrupted_key,
    read_batch,
    save_batches_on_early_end,
    sorted_batch_files,
)
from camopt.solve.front.sweep import (
    SWEEP_COMMAND,
    published_sweep,
    run_and_publish_sweep,
    up_to_date_message,
)
from camopt.solve.tables.result import Result
from camopt.solve.verdicts.limit_verdicts import Effort

PART_COMMAND = "part"
PART_FOLDER = re.compile(r"part-\d{1,9}-of-\d{1,9}")
PART_COUNTS = ("designs", "impossible", "feasible")
BLOCKS_OF_A_PART = 8  # least number of blocks in a part: part sizes differ by one block
MOST_NAMED_PARTS = 20  # parts that a message names


@dataclass(frozen=True)
class SweepPart(Result):
    """The result of one part of a sweep.

    Attributes
    ----------
    scene : Scene
        The scene that was swept.
    part, parts : int
        The number of the part, from 1, and the number of all parts.
    designs : int
        Number of designs in the part.
    impossible : int
        Number of designs that cannot be assembled.
    feasible : int
        Number of feasible designs.
    effort : Effort
        Numbers of designs that were evaluated again.
    folder : pathlib.Path
        The folder that ``merge`` reads: a manifest, and files with the finished batches.
    already_done : bool
        Whether the result was in the folder already.

    Examples
    --------
    >>> search = {"base_radius": [60, 90, 120], "law": ["cycloidal"]}
    >>> scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    >>> part = camopt.sweep_part(scene, (1, 1), out="parts")
    >>> part.designs, part.feasible
    (3, 1)
    """

    scene: Scene
    part: int
    parts: int
    designs: int
    impossible: int
    feasible: int
    effort: Effort
    folder: Path = field(repr=False)
    already_done: bool = False

    @property
    def shown_cam(self) -> None:
        """None: a part shows no cam."""
        return None

    def sections(self) -> Iterator[str]:
        """Counts of the part."""
        part = f"part {self.part} of {self.parts}"
        yield f"{self.scene.name}, {part}: {self.designs:,} designs, {self.feasible:,} feasible"

    @property
    def notes(self) -> tuple[str, ...]:
        """Odd or unused keys of the scene, and objectives that are equal for all designs."""
        return notes_on_search(self.scene)

    def values_for_json(self) -> dict[str, Any]:
        """Counts, and the folder of the part."""
        return {
            "scene": self.scene.name,
            "part": self.part,
            "parts": self.parts,
            "designs": self.designs,
            "impossible": self.impossible,
            "feasible": self.feasible,
            **undecided_and_recheck_counts(self.effort),
            "files": [self.folder],
        }

    @property
    def file(self) -> Path:
        """The old name of ``folder``."""
        return self.folder

    def __repr__(self) -> str:
        return f"<Part {self.part} of {self.parts} of a sweep of {self.scene.name}: {self.designs:,} designs>"


@allow_positional_options
@with_progress_bar("designs")
def sweep_part(  # noqa: PLR0913
    scene: SceneSource,
    part: tuple[int, int],
    *,
    out: str | os.PathLike[str],
    keep: str = "feasible",
    workers: int | None = None,
    progress: Progress | None = None,
    engine: Engine | None = None,
    tell: MessageSink | None = None,
    again: bool = False,
) -> SweepPart:
    """Evaluate one of several equal parts of a sweep; ``merge`` joins them.

    Parts are independent: each may run on a machine of its own, at any time.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        As for ``sweep``.
    part : tuple of two int
        The number of the part, from 1, and the number of all parts: (3, 100).
    out : str or os.PathLike
        Folder of the parts; this part gets a folder inside it, such as ``part-3-of-100``.
    keep : str, default "feasible"
        As for ``sweep``, but parts never decide boxes of designs together.
    workers : int, optional
        Number of threads; None takes one per core.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (designs done, designs of the whole sweep).
    engine : Engine, optional
        As for ``sweep``.
    tell : callable, optional
        As for ``sweep``.
    again : bool, default False
        As for ``sweep``.

    Returns
    -------
    SweepPart
        Counts, and the folder.

    Raises
    ------
    BadInput
        As ``sweep``; also for a part that does not exist.
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
    scene = scene_from(scene)
    check_count("workers", workers)
    plan, threads = (
        _plan_with_blocks_in_every_part(sweep_plan(scene, keep), part),
        Threads(workers or os.cpu_count() or 1),
    )
    folder, question = Path(out) / part_folder_name(*part), plan.sweep_key(*part)
    if not again and (answer := published_answer_to_same_question(folder, PART_COMMAND, asdict(question))):
        with suppress(LookupError, TypeError):  # a manifest may be damaged
            counts = {name: answer[name] for name in PART_COUNTS} | {"effort": Effort(*answer["effort"])}
            if tell:
                tell(up_to_date_message(folder))
            return SweepPart(plan.scene, *part, **counts, folder=folder, already_done=True)
    with publication(
        folder,
        PART_COMMAND,
        (BATCH_FILES,),
        question=asdict(question),
        kept_patterns=(BATCH_FILES, QUESTION_FILE),
    ) as unit:
        store = Store(unit.staging, plan, question, tell)
        with save_batches_on_early_end(store):
            announce_estimate(store, threads, engine or threads, tell)
            batches = store.load_or_evaluate_batches(engine or threads)
            counted = gather_batches(plan.space, batches, plan.block_size, lambda rows: None, progress)
        store.write_pending_batches()
        if store.trouble:
            raise store.trouble
        existing, feasible = counted.existing or 0, counted.feasible or 0
        impossible = counted.evaluated - existing
        result = SweepPart(plan.scene, *part, counted.evaluated, impossible, feasible, counted.effort, folder)
        unit.answer = {name: getattr(result, name) for name in PART_COUNTS} | {"effort": [*counted.effort]}
    return result


def part_folder_name(part: int, part_count: int) -> str:
    return f"part-{part}-of-{part_count}"


def _plan_with_blocks_in_every_part(plan: SweepPlan, part: tuple[int, int]) -> SweepPlan:
    """The plan with blocks small enough for all parts to have some; BadInput if there is no such part.

    Rows do not depend on the size of blocks.
    """
    if not isinstance(part, (tuple, list)) or [*map(type, part)] != [int, int]:
        why = "two numbers, such as (3, 100): the part, and the number of parts"
        raise BadInput([Mistake("camopt", "part", part, why)])
    number, parts = part
    if not 1 <= parts <= SWEEP_PARTS:
        raise BadInput([Mistake("camopt", "part", part, f"one of at most {SWEEP_PARTS:,} parts")])
    if not 1 <= number <= parts:
        raise BadInput([Mistake("camopt", "part", part, f"the number of a part, from 1 to {parts:,}")])
    return replace(plan, most=min(plan.block_size, max(len(plan.space) // (BLOCKS_OF_A_PART * parts), 1)))


@allow_positional_options
@with_progress_bar("designs")
def merge(
    parts: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str] | None = None,
    *,
    progress: Progress | None = None,
    tell: MessageSink | None = None,
    again: bool = False,
) -> Sweep:
    """Join the parts of a sweep: the same result, and tables row for row, as from one run.

    Parameters
    ----------
    parts : str, os.PathLike or a sequence of these
        Folders of parts, or folders that contain them; together they must be all parts of one sweep.
    out : str or os.PathLike, optional
        Folder for the tables, as for ``sweep``; None writes nothing.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (designs done, designs in all).
    tell : callable, optional
        Called with a sentence if the result is in ``out`` already.
    again : bool, default False
        As for ``sweep``.

    Returns
    -------
    Sweep
        As from one run.

    Raises
    ------
    BadInput
        If a part is missing, damaged or duplicated, or belongs to another sweep or version of camopt.
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
    questions, files, mistakes = _read_parts(_part_folders(places))
    plan = _plan_of_complete_parts(questions, mistakes)
    if out is not None:
        interrupted = interrupted_key(Path(out), SWEEP_COMMAND)
        if interrupted and interrupted.differences_except_block_size(plan.sweep_key()):
            why = "another folder: an interrupted sweep is kept in this one, and would be lost"
            raise BadInput([Mistake("camopt", "out", str(Path(out)), why)])
        if not again and (done := published_sweep(plan, out, tell)):
            return done
    in_order = sorted(questions, key=lambda folder: questions[folder].part)

    def read_batches_in_order() -> Iterator[BlockBatch]:
        for folder in in_order:
            for _, path in sorted_batch_files(folder / name for name in files[folder]):
                try:
                    yield read_batch(path, plan)
                except BrokenBatch as why:
                    raise BadInput([_incomplete_part_mistake(path, f"this is {why}")]) from None

    return run_and_publish_sweep(
        plan,
        out,
        lambda store, write: gather_batches(plan.space, read_batches_in_order(), plan.block_size, write, progress),
        Threads(os.cpu_count() or 1),
        progress,
    )


def _part_folders(places: Iterable[str | os.PathLike[str]]) -> list[Path]:
    """The folders of parts among some folders and inside them, recognised by their manifest or name."""
    part_folders: dict[Path, None] = {}
    for place in map(Path, places):
        place.stat()  # an OSError if there is none
        folders = [place, *sorted(path for path in place.iterdir() if path.is_dir())] if place.is_dir() else []
        parts = [
            folder
            for folder in folders
            if PART_FOLDER.fullmatch(folder.name) or PART_COMMAND in read_manifest_or_empty(folder).results
        ]
        if not parts:
            raise BadInput([Mistake("camopt", "part", str(place), "a folder with parts of a sweep; this has none")])
        part_folders |= dict.fromkeys(parts)
    return [*part_folders]


def _read_parts(
    folders: Iterable[Path],
) -> tuple[dict[Path, SweepKey], dict[Path, Iterable[str]], list[Mistake]]:
    """The keys and the files of parts, by folder, and mistakes for folders that are not whole parts."""
    questions: dict[Path, SweepKey] = {}
    files: dict[Path, Iterable[str]] = {}
    mistakes: list[Mistake] = []
    plans: dict[SweepKey, SweepPlan | str] = {}
    for folder in folders:
        try:
            result = (read_manifest(folder) or Manifest()).results.get(PART_COMMAND)
        except DamagedManifest:
            mistakes.append(
                _incomplete_part_mistake(folder, "its manifest is damaged, or of another version of camopt")
            )
            continue
        if result is None:
            mistakes.append(_incomplete_part_mistake(folder, "it has no manifest, because its sweep has not ended"))
            continue
        question = key_from_manifest(result.question)
        if question is None:
            mistakes.append(_incomplete_part_mistake(folder, "its manifest does not name its scene and options"))
            continue
        if question.key_of_whole_sweep not in plans:
            plans[question.key_of_whole_sweep] = _plan_or_fault(question.key_of_whole_sweep)
        plan = plans[question.key_of_whole_sweep]
        if isinstance(plan, str):
            mistakes.append(_incomplete_part_mistake(folder, plan))
            continue
        questions[folder], files[folder] = question, result.files
        for name, entry in result.files.items():
            if not (folder / name).exists():
                mistakes.append(_incomplete_part_mistake(folder / name, "this is missing"))
            elif not file_matches_entry(folder / name, entry):
                mistakes.append(
                    _incomplete_part_mistake(folder / name, "this is damaged, changed, or from another run")
                )
        if not _files_cover_all_blocks_once(result.files, plan.part_blocks(question.part, question.parts)):
            mistakes.append(_incomplete_part_mistake(folder, "its files do not cover all of its designs"))
    return questions, files, mistakes


def _files_cover_all_blocks_once(names: Iterable[str], block_numbers: range) -> bool:
    """Whether files of batches cover all blocks, each once."""
    ranges = [blocks for blocks, _ in sorted_batch_files(map(Path, names))]
    starts, ends = [blocks.start for blocks in ranges], [blocks.stop for blocks in ranges]
    return [*starts, block_numbers.stop] == [block_numbers.start, *ends]


def _plan_or_fault(key: SweepKey) -> SweepPlan | str:
    """The plan of a key, or the fault of the key in words."""
    try:
        return plan_of_key(key)
    except BadInput as error:
        first = error.mistakes[0]
        return f"its scene has mistakes, such as {first.key}: {first.allowed}"


def _incomplete_part_mistake(path: Path, why: str) -> Mistake:
    return Mistake("camopt", "part", str(path), f"a complete part of a sweep; {why}")


def _plan_of_complete_parts(keys_by_folder: dict[Path, SweepKey], mistakes: list[Mistake]) -> SweepPlan:
    """The plan of the whole sweep; BadInput with all mistakes if the parts are not all parts of one sweep."""
    if not keys_by_folder:
        raise BadInput(mistakes or [Mistake("camopt", "part", None, "missing", bare=True)])
    first = next(iter(keys_by_folder))
    whole, parts = keys_by_folder[first].key_of_whole_sweep, keys_by_folder[first].parts
    named = {int(number) for mistake in mistakes for number in re.findall(r"part-(\d+)-of-", str(mistake.value))}
    by_part: dict[int, list[Path]] = {}
    for path, question in keys_by_folder.items():
        if question.key_of_whole_sweep != whole or question.parts != parts:
            other = ", ".join(name for name in question.differences_from(keys_by_folder[first]) if name != "part")
            why = f"a part of the same sweep as {first}; it differs in {other}"
            mistakes.append(Mistake("camopt", "part", str(path), why))
        else:
            by_part.setdefault(question.part, []).append(path)
    for part, paths in by_part.items():
        if len(paths) > 1:
            why = f"given more than once: {', '.join(map(str, paths))}"
            mistakes.append(Mistake("camopt", "part", part, why, bare=True))
    if missing := [part for part in range(1, parts + 1) if part not in by_part and part not in named]:
        listed = ", ".join(map(str, missing[:MOST_NAMED_PARTS])) + (" …" if len(missing) > MOST_NAMED_PARTS else "")
        why = f"not complete: of {parts} parts, these are missing: {listed}"
        mistakes.append(Mistake("camopt", "parts", None, why, bare=True))
    plan = plan_of_key(whole)
    if plan.sweep_key().version != whole.version:
        why = f"of this version of camopt and its kernels ({plan.sweep_key().version}), not {whole.version}"
        mistakes.append(Mistake("camopt", "parts", None, why))
    if mistakes:
        raise BadInput(mistakes)
    return plan
