"""Whether HEAD gives other answers than another commit, or gives them more slowly.

    .ci/against REF [--quick] [--answers | --speed]

installs both, asks both the same cases (``cases.py``), and names each difference that ``differences.py`` does not
allow; then it measures both in turns (``speed.py``), and names what takes more than 1.10 times the CPU time, or 3 %
more instructions where valgrind is.
``--quick`` asks fewer cases, and measures what runs in one process. Uncommitted changes count as HEAD's.
"""

import argparse
import json
import re
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatchcase
from functools import partial
from hashlib import sha256
from itertools import groupby
from pathlib import Path
from shutil import copytree
from tempfile import TemporaryDirectory
from typing import Any

from cases import write_cases
from differences import Difference, differences, read_accepted
from sides import ENVIRONMENTS, Side, commit_of, git, say, side_of
from speed import compared, countable, verdict
from tasks import QUICK, TASKS

MOST_SHOWN = 60
PLACE = re.compile(r"\[\d+\]|#\d+")


def cases_of(head: str, quick: bool) -> Path:
    """The folder of all cases, which are kept: they are the same for the same tests and makers of cases."""
    makers = ("tests", *(f"benchmarks/{name}.py" for name in ("cases", "recording", "answers")))
    key = sha256(git("rev-parse", *(f"{head}:{path}" for path in makers))).hexdigest()[:9]
    folder = ENVIRONMENTS / f"cases-{key}{'-quick' if quick else ''}"
    if not folder.is_dir():
        with TemporaryDirectory(dir=ENVIRONMENTS) as new:
            write_cases(Path(new), quick)
            copytree(new, folder)
    return folder


def answers_of(side: Side, cases: Path, only: str) -> dict[str, Any]:
    """The answers of a side to the cases of a pattern, by their names; some may be there from an earlier run."""
    folder = ENVIRONMENTS / f"answers-{side.name}-{cases.name}"
    folder.mkdir(exist_ok=True)
    names = [file.stem for file in sorted(cases.iterdir()) if fnmatchcase(file.stem, only)]
    say(f"{side.name}: {len(names)} cases")
    while not all((folder / f"{name}.json").exists() for name in names):  # a case may end the process
        if (code := side.start("answers.py", str(cases), str(folder), only).wait()) > 0:
            raise SystemExit(f"{side.name} cannot be asked: answers.py ends with {code}")
    return {name: json.loads((folder / f"{name}.json").read_text(encoding="utf-8")) for name in names}


def summary(found: list[Difference]) -> str:
    """The differences as Markdown, those of one place and kind of case in a line."""

    def kind(each: Difference) -> tuple[str, str]:
        return each.case.partition(" ")[0], PLACE.sub("", each.place)

    lines = ["| cases | place | times | share | for one | before | after |", "|---|---|---:|---:|---|---|---|"]
    for names, group in groupby(sorted(found, key=kind), kind):
        first, *others = sorted(group, key=lambda each: -each.share)
        values = [repr(value) for value in (first.before, first.after)]
        start = next((k for k, (one, other) in enumerate(zip(*values, strict=False)) if one != other), 0)
        values = [f"`{value[max(0, start - 60) :][:150]}`" for value in values]
        cells = (*names, str(1 + len(others)), f"{first.share:.1e}", first.case, *values)
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines[: MOST_SHOWN + 2])


def differing(sides: Sequence[Side], cases: Path, only: str) -> int:
    """Print where the answers of two sides differ; the exit code."""
    with ThreadPoolExecutor() as pool:
        before, after = pool.map(partial(answers_of, cases=cases, only=only), sides)
    accepted = read_accepted()
    found = [each for name in before for each in differences(name, before[name], after[name], accepted)]
    print(summary(found) if found else f"no answer differs in {len(before)} cases", flush=True)
    return min(len(found), 1)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ref", metavar="REF")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--answers", action="store_true", help="compare the answers alone")
    parser.add_argument("--speed", action="store_true", help="compare the speed alone")
    parser.add_argument("--only", metavar="PATTERN", default="*", help="cases with such a name alone: 'random *'")
    asked = parser.parse_args()
    head = git("stash", "create").decode().strip() or commit_of("HEAD")
    sides, code = [side_of(commit_of(asked.ref)), side_of(head)], 0
    if not asked.speed:
        code = differing(sides, cases_of(head, asked.quick), asked.only)
    if not asked.answers:
        tasks = list(QUICK if asked.quick else TASKS)
        code = max(code, verdict(compared(sides, tasks, countable())))
    return code


if __name__ == "__main__":
    sys.exit(main())
