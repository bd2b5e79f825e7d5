"""What differs between the answers of two sides.

Texts, codes, keys and columns are equal, or they differ. Numbers are equal to 1e-13 of the largest of their curve:
of a column, of the points of a file, or of a quantity on rises, on returns and at both extremes. A proved bound may
change: it holds for what either side has found. An error bound may not become more than twice as large. A line of
``.ci/accepted.txt`` allows more.
"""

import json
import re
from collections.abc import Iterator
from fnmatch import fnmatchcase
from math import inf, isfinite
from pathlib import Path
from typing import Any, NamedTuple

from answers import ENDED, LONGEST

Answer = dict[str, Any]
ACCEPTED = Path(__file__).resolve().parents[1] / ".ci" / "accepted.txt"
ALLOWED = 1e-13
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?(?![\w.])|(?<=\b[A-Z])[-+]?\d+\.\d*")
POINTS = {".dxf": r"(?s)\nENTITIES\n(.*?)\n *0\nENDSEC", ".step": r"(?s)\nDATA;\n(.*)", ".nc": "(?s)(.*)"}
"""Where files have points."""
PROGRESS = re.compile(r"(camopt: (compiling kernels|[\d,]+ of [\d,]+ |[\d,]+ more searches )| *\d+%\|).*\n")
OVER = "s was over"  # the end of what is said of a search that its time has ended
HANDLES = re.compile(r"\n *(?:5|330)\n[0-9A-F]+(?=\n)|#\d+")
"""Names of things within drawings and solids, which nobody sees."""
ENDS = re.compile(r"_(max|min|rise|return|dwell)(?=_|$)")
BOUNDS = {"bound": ("error", "change", "objective", "size"), "any_motion": ("free_laws",)}
"""Proved bounds, and what was found beside them."""
ERROR_BOUNDS = ("relative_half_width", "gap", "gap_mm", "deviation_mm")


class Difference(NamedTuple):
    """A place where two answers differ, and by what share of the scale."""

    case: str
    place: str
    before: Any
    after: Any
    share: float = inf


class Accepted(NamedTuple):
    """A line of the list: by how much values may differ in some places of some cases."""

    case: str
    place: str
    allowed: float
    reason: str

    def allows(self, found: Difference) -> bool:
        fits = fnmatchcase(found.case, self.case) and fnmatchcase(found.place, self.place)
        return fits and found.share <= self.allowed


def read_accepted(file: Path = ACCEPTED) -> list[Accepted]:
    """The accepted differences; a line without a reason is a mistake."""
    lines = [line.split(maxsplit=3) for line in file.read_text(encoding="utf-8").splitlines()]
    return [Accepted(one, two, float(more), why) for one, two, more, why in lines if not one.startswith("#")]


def opened(answer: Answer) -> Answer:
    """An answer with documents and tables in place of their texts, and of drawings the points."""
    out, files = answer.get("out", ""), {}
    for name, text in answer.get("files", {}).items():
        suffix = Path(name).suffix
        if suffix in POINTS:
            found = re.search(POINTS[suffix], text)
            files[f"{name} points"] = HANDLES.sub("", found[1] if found else text)
        else:
            files[name] = json.loads(text) if suffix == ".json" and text else text
    out = json.loads(out) if out.startswith(("{", "[")) else out
    err = PROGRESS.sub("", answer.get("err", ""))
    return {**answer, "out": out, "err": err, "files": files, "seconds": None}


def leaves(value: Any, place: str = "", curve: str = "") -> Iterator[tuple[str, str, Any]]:
    """All values of an answer, numbers within texts as well: the place of each, its curve, and the value."""
    if isinstance(value, dict) and value:
        for key, each in value.items():
            yield from leaves(each, f"{place}.{key}", f"{curve}.{ENDS.sub('', key)}")
    elif isinstance(value, list) and value:
        for number, each in enumerate(value):
            yield from leaves(each, f"{place}[{number}]", curve)
    elif isinstance(value, str) and place != ".err":
        yield f"{place} text", "", NUMBER.sub("#", value)
        for number, each in enumerate(NUMBER.findall(value)):
            where = f"{place} #{number}"
            yield where, curve if curve.endswith(" points") else where, float(each)
    else:
        yield place, curve, value


def differences(case: str, before: Answer, after: Answer, accepted: list[Accepted]) -> list[Difference]:
    """Where two answers to a case differ by more than is allowed."""
    seconds = [each.get("seconds", LONGEST) for each in (before, after)]
    if (ENDED in (before["code"], after["code"]) and min(seconds) > LONGEST / 2) or OVER in f"{before}{after}":
        return []  # it takes about as long as it may
    values: tuple[Answer, Answer] = {}, {}
    curves: dict[str, str] = {}
    scales: dict[str, float] = {}
    for found, answer in zip(values, (before, after), strict=True):
        for place, curve, value in leaves(opened(answer)):
            found[place], curves[place] = value, curve
            if is_finite(value):
                scales[curve] = max(scales.get(curve, 0.0), abs(value))
    old, new = values
    found = []
    if list(old) != list(new):
        only = [[place for place in one if place not in other] for one, other in ((old, new), (new, old))]
        found.append(Difference(case, "keys" if any(only) else "order of keys", *only))
    for place in (place for place in old if place in new):
        share = share_of(place, old, new, scales.get(curves[place], 0.0))
        found += [Difference(case, place, old[place], new[place], share)] if share > ALLOWED else []
    return [each for each in found if not any(line.allows(each) for line in accepted)]


def share_of(place: str, old: Answer, new: Answer, scale: float) -> float:
    """By what share of the scale a value differs; infinite if it must not at all."""
    before, after = old[place], new[place]
    table, _, name = place.rpartition(".")
    for witness in (f"{table}.{each}" for each in BOUNDS.get(name, ())):
        if all(map(is_finite, (before, after, old.get(witness), new.get(witness)))):
            least, most = sorted((abs(old[witness]), abs(new[witness])))
            holds = min(before, after) >= most if before >= abs(old[witness]) else max(before, after) <= least
            return 0.0 if holds else inf
    if before == after or (before != before and after != after):
        return 0.0
    if not (is_finite(before) and is_finite(after)):
        return inf
    if name in ERROR_BOUNDS and after <= max(2.0 * before, ALLOWED):
        return 0.0
    return abs(before - after) / scale


def is_finite(value: Any) -> bool:
    """Whether a value is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and isfinite(value)
