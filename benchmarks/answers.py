"""A process that asks the camopt beside its interpreter all cases, and keeps each answer.

    python answers.py CASES ANSWERS PATTERN

A case is a command with its files, or a call of a public name; an answer is the exit code or what was raised, what
was printed, and what was written. A case that ends the process has none: the next process says so, and goes on.
"""

import gc
import hashlib
import io
import json
import os
import pickle
import signal
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from fnmatch import fnmatchcase
from importlib.metadata import entry_points
from operator import attrgetter
from pathlib import Path
from shutil import rmtree
from time import process_time
from typing import Any

import camopt

LONGEST = 20.0  # seconds of the processor for one case, after which the process is ended
INTERRUPTED = (130, 143)
ENDED = f"ended the process, or took more than {LONGEST:g} s"


def write_case(folder: Path, group: str, files: dict[str, bytes], **case: Any) -> None:
    """A case as a file; equal ones are one."""
    text = json.dumps({**case, "files": {name: data.decode("latin-1") for name, data in files.items()}}, indent=1)
    (folder / f"{group} {hashlib.sha256(text.encode()).hexdigest()[:9]}.json").write_text(text, encoding="utf-8")


def scene_of(data: dict[str, Any]) -> camopt.Scene:
    """A scene among the arguments of a call: its class may have another home on either side."""
    return camopt.Scene.from_dict(data)


def call(case: dict[str, Any]) -> Any:
    """Run a command, or call a public name of camopt: the exit code, or what is raised."""
    if "argv" in case:
        sys.argv = ["camopt", *case["argv"]]
        (command,) = set(entry_points(group="console_scripts", name="camopt"))
        return command.load()()
    try:
        arguments, named = pickle.loads(case["arguments"].encode("latin-1"))
        attrgetter(case["call"])(camopt)(*arguments, **named)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return "returned"


def contents(file: Path) -> Any:
    """What a file holds: the columns of a table, or text; nothing of pictures, and of the sums of other files."""
    if file.suffix in (".csv", ".parquet"):
        import pandas as pd

        read = pd.read_parquet if file.suffix == ".parquet" else pd.read_csv
        return read(file).to_dict("list")
    data = file.read_bytes()
    return None if b"\0" in data or file.name == "manifest.json" else data.decode(errors="replace")


def answer(case: dict[str, Any], folder: Path) -> dict[str, Any]:
    """All that a case gives, in a folder of its own."""
    for name, text in case["files"].items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(text.encode("latin-1"))
    out, err, start = io.StringIO(), io.StringIO(), process_time()
    with chdir(folder), redirect_stdout(out), redirect_stderr(err):
        code = call(case)
    seconds = process_time() - start
    gc.unfreeze()  # a command leaves its memory to the end of the process
    names = {str(each.relative_to(folder)) for each in folder.rglob("*") if each.is_file()}
    files = {name: contents(folder / name) for name in sorted(names - {*case["files"]})}
    return {"code": code, "out": out.getvalue(), "err": err.getvalue(), "files": files, "seconds": seconds}


def main(cases: str, answers: str, only: str) -> None:
    os.environ["COLUMNS"] = "200"
    package = str(Path(camopt.__file__).parent)
    for file in sorted(file for file in Path(cases).iterdir() if fnmatchcase(file.stem, only)):
        kept, folder = Path(answers, file.name), Path(answers, file.stem)
        if kept.exists():
            continue
        found: dict[str, Any] = {"code": ENDED}
        if not folder.exists():
            folder.mkdir()
            signal.setitimer(signal.ITIMER_PROF, LONGEST)
            found = answer(json.loads(file.read_text(encoding="utf-8")), folder)
        if found["code"] in INTERRUPTED:
            sys.exit(found["code"])
        text = json.dumps(found, default=str)
        kept.write_text(text.replace(str(folder), ".").replace(package, "camopt"), encoding="utf-8")
        rmtree(folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
