"""Files of a published result get their names, and leftovers of dead runs are removed."""

import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from errno import EXDEV
from functools import partial
from pathlib import Path

from camopt.storage.files import forgotten, synced, target_of, whole_file
from camopt.storage.folder import LOCK_FILE
from camopt.storage.manifest import Manifest, manifest_to_renew
from camopt.storage.unit import JOURNAL


def tried(calls: Iterable[Callable[[], None]]) -> Iterator[OSError]:
    """Make all calls, even if some fail; returns their errors."""
    for call in calls:
        try:
            call()
        except OSError as trouble:
            yield trouble


def place_results(folder: Path, work: Path, alone: bool) -> None:
    """Give the files of published results their names, and remove leftovers of dead runs; journals stay."""
    manifest = manifest_to_renew(folder)
    commands = {result.run: command for command, result in manifest.results.items()}
    for left in sorted(work.iterdir()):
        if left.name == LOCK_FILE or left.suffix == JOURNAL:
            continue
        if left.name in commands:
            _place(folder, left, manifest, commands[left.name])
        elif alone or forgotten(left):
            remove(left)


def _place(folder: Path, staging: Path, manifest: Manifest, command: str) -> None:
    """Give files their names, after those of the earlier result are gone: no two results are ever side by side.

    A disk that fails to sync fails at the end: the names matter more.
    """
    result, others = manifest.results[command], manifest.others(command)
    waiting = [name for name in result.files if (staging / name).exists()]
    old = [folder / name for name in result.replaces if name not in others]
    for path in (*old, *(target_of(folder / name) for name in waiting)):
        if not path.is_dir():
            path.unlink(missing_ok=True)
    troubles = [*tried([partial(synced, folder)])]
    for name in waiting:
        _rename(staging / name, folder / name)
    troubles += tried([partial(synced, folder)])
    remove(staging)
    if troubles:
        raise troubles[0]


def _rename(staged: Path, path: Path) -> None:
    """Give a file its name; on another disk, where a link may lead, as a copy."""
    try:
        os.replace(staged, target_of(path))
    except OSError as trouble:
        if trouble.errno != EXDEV:
            raise
        with whole_file(path) as partial:
            shutil.copyfile(staged, partial)
        staged.unlink()


def remove(path: Path) -> None:
    """Remove a file or a folder with all its content, if it exists."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
