"""Names say what a function does or returns: participles, adverbs and prepositions alone do not."""

import ast
import re
import tomllib
from collections import defaultdict
from pathlib import Path

import pytest
from support.sources import PACKAGE, parsed_modules

TESTS = Path(__file__).parents[1]
WORDS = tomllib.loads((TESTS / "data" / "words.toml").read_text(encoding="utf-8"))
CLOSED, IRREGULAR, NOUNS = (frozenset(WORDS[name].split()) for name in ("closed", "irregular", "nouns"))


def functions_of(folder):
    """All functions and methods of a folder but special ones: (path, line, name)."""
    for path, tree in parsed_modules(folder).items():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not node.name.startswith("__"):
                yield path.relative_to(folder), node.lineno, node.name


def is_mute(name):
    """Whether a name has no noun and no verb but participles."""
    words = [word for word in name.strip("_").lower().split("_") if word]
    if words[:1] in (["is"], ["has"], ["can"], ["are"]):
        words = [word for word in words[1:] if not re.fullmatch(r"\w+(ed|ing)", word)] or ["closed"]
        return len(words) > 0 and all(word in CLOSED for word in words)
    participles = {word for word in words if re.fullmatch(r"\w+(ed|ing)", word) or word in IRREGULAR} - NOUNS
    return bool(words) and all(word in CLOSED | participles for word in words)


def test_names_that_say_something_are_told_from_those_that_do_not():
    mute = ["told", "_beside", "moved_by", "made_of", "at", "drawn", "is_it", "with_some", "said_twice"]
    plain = [
        "largest_error",
        "sample_cams",
        "with_rpm",
        "is_flat",
        "is_closed",
        "shifted_law",
        "spring",
        "run",
        "spacing",
    ]
    assert [name for name in mute if not is_mute(name)] == []
    assert [name for name in plain if is_mute(name)] == []


@pytest.mark.parametrize(("folder", "share"), [(PACKAGE, 0.01), (TESTS, 0.03)], ids=["package", "tests"])
def test_few_functions_are_named_by_participles_adverbs_and_prepositions_alone(folder, share):
    found = list(functions_of(folder))
    mute = [f"{path}:{line}: {name}" for path, line, name in found if is_mute(name)]
    assert len(mute) <= share * len(found), "\n".join(mute)


MOST_SHARED_NAMES = 60
"""Names at the top of more than one module: those of registries (laws, effects, mechanisms) and a few others."""


def test_few_names_have_homes_in_two_modules():
    homes = defaultdict(set)
    for path, tree in parsed_modules(PACKAGE).items():
        for node in tree.body:
            targets = node.targets if isinstance(node, ast.Assign) else []
            names = [node.name] if isinstance(node, ast.FunctionDef | ast.ClassDef) else []
            names += [target.id for target in targets if isinstance(target, ast.Name)]
            for name in names:
                homes[name].add(path)
    shared = sorted(name for name, found in homes.items() if len(found) > 1 and not name.startswith("__"))
    assert len(shared) <= MOST_SHARED_NAMES, shared
