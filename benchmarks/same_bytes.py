"""Whether results depend on anything but the question: ``python benchmarks/same_bytes.py [PYTHON …]``.

Commands are run as they are, and then under other hash seeds, locales, time zones, widths of the terminal, numbers
of threads, and by other interpreters (paths of python, each with camopt's packages); sweeps with other numbers of
workers, sizes of blocks and engines. What they write and print is compared byte for byte. ``same_bytes.py --do
FOLDER`` runs the commands once. It needs ``localedef``.
"""

import locale
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import camopt
from camopt.cli.main import main as typed
from camopt.engines.processes import processes
from camopt.exporting.endings import ENDINGS

PLAIN = {"PYTHONHASHSEED": "0", "LC_ALL": "C.UTF-8", "TZ": "UTC", "COLUMNS": "120"}
OTHERS: dict[str, dict[str, str]] = {
    "hash seed 1": {"PYTHONHASHSEED": "1"},
    "hash seed 4": {"PYTHONHASHSEED": "4"},
    "hash seed 4294967295": {"PYTHONHASHSEED": "4294967295"},
    "German": {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"},
    "Turkish": {"LC_ALL": "tr_TR.UTF-8", "LANG": "tr_TR.UTF-8"},
    "ASCII alone": {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    "another day": {"TZ": "Pacific/Kiritimati"},
    "a narrow terminal": {"COLUMNS": "40"},
    "one thread": {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"},
    "without assertions": {"PYTHONOPTIMIZE": "1"},
}
SMALL = camopt.find_scene("roller-1000rpm").replace(
    part={"thickness": 12},
    search={
        "base_radius": {"start": 30, "stop": 90, "step": 1},
        "offset": {"start": 0, "stop": 18, "step": 2},
        "law": ["harmonic", "cycloidal", "modified-sine"],
    },
)
NEEDS = {".nc": ("--cutter-radius", "5", "--feed", "300"), ".p": ("--cutter-radius", "5")}
COMMANDS: dict[str, tuple[str, ...]] = {
    "evaluate": ("evaluate", "exhaust-valve", "--outputs", "all", "--json"),
    "picture": ("evaluate", "exhaust-valve", "--plot", "cam.svg", "--points", "points.csv"),
    "certify": ("certify", "oscillating-roller", "--json"),
    "optimise": ("optimise", "small.toml", "--json", "--out", "optimum"),
    "sweep": ("sweep", "small.toml", "--keep", "all", "--out", "sweep"),
    "refined": ("sweep", "small.toml", "--refine", "--thin", "0.01", "--out", "refined"),
    "samples": ("sweep", "small.toml", "--samples", "500", "--out", "samples"),
    "front": ("sweep", "small.toml", "--keep", "front-only", "--out", "front"),
    "synthesise": ("synthesise", "two-pauses", "--out", "motion"),
    "fit": ("fit", "points.csv", "--columns", "1,2", "--base-radius", "40", "--json", "--out", "fitted.toml"),
    "report": ("report", "sweep", "--out", "sweep.html"),
    "page": ("report", "two-pauses", "--out", "page.html"),
    **{
        f"export {ending}": ("export", "small.toml", f"cam{ending}", *NEEDS.get(ending, ()))
        for ending in ENDINGS
        if ending != ".toml"  # that of the scene that is read
    },
}
KEPT = ("all", "feasible", "pareto", "front-only")


def do(folder: Path) -> None:
    """Run all commands in a folder; what they print is in files, too."""
    locale.setlocale(locale.LC_ALL, "")  # as programs do that have camopt as a library
    os.chdir(folder)
    Path("small.toml").write_text(SMALL.to_toml(), encoding="utf-8")
    for name, words in COMMANDS.items():
        with open(f"{name}.printed", "w", encoding="utf-8") as printed, redirect_stdout(printed):
            code = typed([*words, *(() if "--json" in words else ("--quiet",))])
        Path(f"{name}.code").write_text(f"{code}\n", encoding="utf-8")


def tree(folder: Path) -> dict[str, bytes]:
    """All files in a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def done(python: str, folder: Path, **environment: str) -> dict[str, bytes]:
    """What the commands give by an interpreter and in an environment."""
    folder.mkdir()
    subprocess.run(
        [python, __file__, "--do", str(folder)],
        env={**os.environ, **PLAIN, **environment},
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return tree(folder)


def told(what: str, one: dict[str, bytes], other: dict[str, bytes]) -> int:
    """Print how many files are the same, and which are not: 1 if any."""
    different = [name for name in sorted({*one, *other}) if one.get(name) != other.get(name)]
    print(f"{what}: {len(one)} files, {len(one) - len(different)} the same", *different, sep="\n  ", flush=True)
    return min(len(different), 1)


def swept(folder: Path, keep: str, **options: Any) -> dict[str, bytes]:
    """The files of a sweep."""
    camopt.sweep(SMALL, folder, keep, **options)
    return tree(folder)


def engines(folder: Path) -> int:
    """Sweep in all ways; how many are other than by one thread."""
    other = 0
    with camopt.cluster("local", 2) as cluster, processes(2) as some:
        ways: dict[str, dict[str, Any]] = {
            **{f"{workers} threads": {"workers": workers} for workers in (2, 3, 7)},
            **{f"blocks of {block}": {"workers": 2, "block": block} for block in (1, 7, 100, 100_000)},
            "processes": {"engine": some, "block": 100},
            "Dask": {"engine": cluster, "block": 100},
        }
        for keep in KEPT:
            one = swept(folder / keep, keep, workers=1)
            for name, options in ways.items():
                other += told(f"{keep}, {name}", one, swept(folder / f"{keep} {name}", keep, **options))
    return other


@contextmanager
def locales() -> Iterator[dict[str, str]]:
    """Where the locales are found, which few machines have."""
    with TemporaryDirectory() as folder:
        for name in ("de_DE", "tr_TR", "C"):
            made = Path(folder) / f"{name}.UTF-8"
            subprocess.run(["localedef", "-i", name, "-f", "UTF-8", str(made)], check=True, capture_output=True)
        yield {"LOCPATH": folder}


def main(*pythons: str) -> int:
    """Compare all, and print a line for each."""
    with TemporaryDirectory() as name, locales() as here:
        folder = Path(name)
        one = done(sys.executable, folder / "one", **here)
        other = told("again", one, done(sys.executable, folder / "again", **here))
        for what, environment in OTHERS.items():
            other += told(what, one, done(sys.executable, folder / what, **here, **environment))
        for number, python in enumerate(pythons):
            version = subprocess.check_output([python, "--version"], text=True).strip()
            other += told(version, one, done(python, folder / f"python {number}", **here))
        return min(other + engines(folder), 1)


if __name__ == "__main__":
    sys.exit(do(Path(sys.argv[2])) if sys.argv[1:2] == ["--do"] else main(*sys.argv[1:]))
