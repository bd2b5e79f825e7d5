"""Whether HEAD gives other answers than another commit, or gives them more slowly.

    .ci/against REF [--quick] [--answers | --speed]

installs both, asks both the same cases (``cases.py``), and names each difference that ``differences.py`` does not
allow; then it measures both in turns (``track.py``), and names what takes more than 1.10 times the CPU time.
``--quick`` asks fewer cases, and measures what runs in one process. Uncommitted changes count as HEAD's.
"""

import argparse
import json
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import groupby
from pathlib import Path
from shutil import copytree, rmtree
from tempfile import TemporaryDirectory

from cases import write_cases
from differences import Difference, differences, read_accepted
from sides import ENVIRONMENTS, Side, commit_of, git, say, side_of
from tasks import QUICK, TASKS
from track import compared, countable, verdict

MOST_SHOWN = 60
PLACE = re.compile(r"\[\d+\]|#\d+")


def cases_of(head: str, quick: bool) -> Path:
    """The folder of all cases, which are kept: they are the same for the same tests and benchmarks."""
    trees = git("rev-parse", f"{head}:tests", f"{head}:benchmarks").decode().split()
    folder = ENVIRONMENTS / "-".join(("cases", *(tree[:9] for tree in trees), *["quick"][: int(quick)]))
    if not folder.is_dir():
        with TemporaryDirectory(dir=ENVIRONMENTS) as new:
            write_cases(Path(new), quick)
            copytree(new, folder)
    return folder


def answers_of(side: Side, cases: Path) -> Path:
    """The folder of a side's answers to all cases; it may have those of an earlier run."""
    folder = ENVIRONMENTS / f"answers-{side.name}-{cases.name}"
    folder.mkdir(exist_ok=True)
    while len([*folder.glob("*.json")]) < len([*cases.iterdir()]):  # a case may end its process
        if (code := side.start("answers.py", str(cases), str(folder)).wait()) > 0:
            raise SystemExit(f"{side.name} cannot be asked: answers.py ends with {code}")
    return folder


def differing(sides: list[Side], cases: Path) -> list[Difference]:
    """Where the answers of two sides differ; those of the first are kept for the next run."""
    say(f"{len([*cases.iterdir()])} cases")
    with ThreadPoolExecutor(len(sides)) as pool:
        folders = [*pool.map(lambda side: answers_of(side, cases), sides)]
    accepted, found = read_accepted(), []
    for file in sorted(cases.iterdir()):
        before, after = (json.loads((folder / file.name).read_text(encoding="utf-8")) for folder in folders)
        found += differences(file.stem, before, after, accepted)
    rmtree(folders[1])
    return found


def summary(found: list[Difference]) -> str:
    """The differences as Markdown, those of one place and kind of case in a line."""

    def kind(each: Difference) -> tuple[str, str]:
        return each.case.partition(" ")[0], PLACE.sub("", each.place)

    lines = ["| cases | place | times | share | for one | before | after |", "|---|---|---:|---:|---|---|---|"]
    for names, group in groupby(sorted(found, key=kind), kind):
        worst, *others = sorted(group, key=lambda each: -each.share)
        values = (f"`{worst.before!r:.200}`", f"`{worst.after!r:.200}`")
        cells = (*names, str(1 + len(others)), f"{worst.share:.1e}", worst.case, *values)
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines[: MOST_SHOWN + 2])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ref", metavar="REF")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--answers", action="store_true", help="compare the answers alone")
    parser.add_argument("--speed", action="store_true", help="compare the speed alone")
    asked = parser.parse_args()
    head = git("stash", "create").decode().strip() or commit_of("HEAD")
    sides = [side_of(commit_of(asked.ref)), side_of(head)]
    code = 0
    if not asked.speed:
        cases = cases_of(head, asked.quick)
        if found := differing(sides, cases):
            print(summary(found))
        print(f"\n{len(found)} differences of {len({each.case for each in found})} cases of {cases}")
        code = min(len(found), 1)
    if not asked.answers:
        tasks = list(QUICK if asked.quick else TASKS)
        code = max(code, verdict(compared(sides, tasks, [] if asked.quick else countable())))
    return code


if __name__ == "__main__":
    sys.exit(main())
