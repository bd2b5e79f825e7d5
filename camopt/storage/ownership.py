"""Ownership of files: camopt's own may be replaced, the user's may not."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path

from camopt.mistakes import BadInput, Mistake
from camopt.storage.manifest import Fact, Manifest, RunResult, fact_of, manifest_to_renew
from camopt.storage.unit import DATA, TABLE_ENDING, Unit


def exact_names(names: Iterable[str]) -> set[str]:
    """Those names that are no patterns."""
    return {name for name in names if "*" not in name}


def check_own(unit: Unit, names: set[str]) -> None:
    """BadInput if a file to be replaced, or removed with the earlier result, is the user's or was edited."""
    manifest = manifest_to_renew(unit.folder)
    earlier = set() if unit.revises else {*earlier_files(unit, manifest)}
    why = "{}, and it would be replaced; choose another folder, or move the file"
    found = ((unit.folder / name, foreign(unit, manifest, name)) for name in sorted(names | earlier))
    mistakes = [Mistake("camopt", "out", str(path), why.format(what), bare=True) for path, what in found if what]
    if mistakes:
        raise BadInput(mistakes)


def earlier_files(unit: Unit, manifest: Manifest) -> Mapping[str, Fact]:
    """The files of the earlier result that the manifest names."""
    return manifest.results.get(unit.command, RunResult("", {})).files


def foreign(unit: Unit, manifest: Manifest, name: str) -> str:
    """The part of a file that is not camopt's, in words; empty if all is, or there is no file.

    Where no manifest names it, a table says of itself whether it is as it was written. Other files do not: they are
    taken for those of an older camopt, which wrote no manifest, until there is one of this command.
    """
    path, fact = unit.folder / name, manifest.files.get(name)
    if not path.is_file():
        return ""
    if fact:
        return "" if path.suffix in DATA or fact_of(path) == fact else "this was edited since camopt wrote it"
    own = _is_own(path) if path.suffix == TABLE_ENDING else unit.command not in manifest.results
    return "" if own else "camopt did not write this as it is"


def _is_own(path: Path) -> bool:
    """Whether a file is a table, and as camopt wrote it."""
    from camopt.storage.damage import TableFault, open_table

    with path.open("rb") as file, suppress(TableFault):
        open_table(file)
        return True
    return False
