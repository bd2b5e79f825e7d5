"""The record of speed: ``python benchmarks/track.py FOLDER`` measures HEAD, adds its file, and draws all files.

``--commit`` does so with another commit, ``--draw`` draws alone. ``--quick`` takes the first part of the list: what
runs in one process. The files are on the branch ``records``; ``.ci/against`` compares two commits.
"""

import argparse
import os
import platform
import sys
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from history_picture import drawn
from record import Record, least, records, with_counts, written
from rival_c import rival
from sides import commit_of, git, say, side_of
from speed import ROUNDS, countable
from tasks import CORES, QUICK, TASKS


def record_of(commit: str, tasks: list[str], to_count: list[str]) -> Record:
    """Measure a commit."""
    side = side_of(commit)
    side.warm(tasks)
    load = os.getloadavg()[0]
    times = least(side.timed(tasks) for _ in range(ROUNDS))
    counts = side.counted(to_count)
    second, subject = git("show", "-s", "--format=%ct%n%s", commit).decode().strip().split("\n", 1)
    made_with = {name: version(name) for name in ("numba", "llvmlite", "numpy")}
    return {
        "commit": commit,
        "date": datetime.fromtimestamp(int(second), UTC).isoformat(),
        "subject": subject,
        "machine": {"processor": processor(), "cores": CORES, "load": round(load, 2)},
        "versions": {"python": platform.python_version(), **made_with},
        "rival": rival("float").name,
        "tasks": with_counts(times, counts),
    }


def processor() -> str:
    """What the machine calls its processor."""
    about = Path("/proc/cpuinfo")
    lines = about.read_text(encoding="utf-8").splitlines() if about.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", type=Path)
    parser.add_argument("--commit", metavar="REV", default="HEAD")
    parser.add_argument("--draw", action="store_true")
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_args()
    if not asked.draw:
        record = record_of(commit_of(asked.commit), list(QUICK if asked.quick else TASKS), countable())
        say(f"written: {written(record, asked.folder)}")
    say(f"drawn: {drawn(records(asked.folder), asked.folder / 'history.png')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
