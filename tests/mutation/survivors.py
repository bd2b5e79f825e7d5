"""Count the mutants of six modules that their tests do not find: ``python tests/mutation/survivors.py [MODULE …]``.

It works in a clone of the last commit. ``survivors.toml`` names the modules, their tests and the number of
mutants. A mutant is chosen by the digest of the line that it changes, so that other changes of a module keep
the choice. Exit code 1 if more survive than the file allows.
"""

import os
import re
import resource
import subprocess
import sys
import tomllib
from difflib import unified_diff
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cosmic_ray.plugins
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code

HERE = Path(__file__).parent
ENOUGH = 300
"""Seconds of CPU time for the tests of one mutant; one that needs more is found, as it hardly ends."""


def mutants_of(source: str) -> list[tuple[str, str]]:
    """All mutants of a module in an order that depends on the changed lines alone: the diff and text of each."""
    config = tomllib.loads((HERE / "mutation.toml").read_text(encoding="utf-8"))["cosmic-ray"]
    excluded = re.compile("|".join(config["filters"]["operators-filter"]["exclude-operators"]))
    nodes: Any = [*ast_nodes(get_ast(source))]
    texts: dict[str, str] = {}
    for name in cosmic_ray.plugins.operator_names():
        operator_class = cosmic_ray.plugins.get_operator(name)
        if operator_class.arguments() or excluded.match(name):
            continue
        operator: Any = operator_class()
        for occurrence in range(sum(len([*operator.mutation_positions(node)]) for node in nodes)):
            text = mutate_code(source, operator, occurrence)
            diff = [*unified_diff(source.splitlines(), text.splitlines(), n=0, lineterm="")]
            texts.setdefault("\n".join(line for line in diff[2:] if not line.startswith("@@")), text)
    return sorted(texts.items(), key=lambda mutant: sha256(mutant[0].encode()).digest())


def run_tests(clone: Path, tests: list[str]) -> int:
    """Run tests in a clone, uncompiled, until one fails; the exit code."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    environment = os.environ | {"PYTHONPATH": str(clone), "NUMBA_DISABLE_JIT": "1"}
    return subprocess.run(
        [*command, *(f"tests/{test}.py" for test in tests)],
        cwd=clone,
        env=environment,
        capture_output=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (ENOUGH, ENOUGH + 5)),
        check=False,
    ).returncode


def survivors(clone: Path, module: str, mutants: int, tests: list[str]) -> list[str]:
    """The mutants that the tests do not find, as diffs."""
    path, left = clone / module, []
    source = path.read_text(encoding="utf-8")
    if run_tests(clone, tests):
        raise SystemExit(f"{module}: its tests fail without a mutant")
    for number, (diff, text) in enumerate(mutants_of(source)[:mutants], 1):
        path.write_text(text, encoding="utf-8")
        left += [] if run_tests(clone, tests) else [diff]
        print(f"{module}: {len(left)} of {number} so far", file=sys.stderr, flush=True)
    path.write_text(source, encoding="utf-8")
    return left


def main(*names: str) -> int:
    """Try the mutants of each module, print those that survive, and compare their number with the file."""
    modules = tomllib.loads((HERE / "survivors.toml").read_text(encoding="utf-8"))
    raised = 0
    with TemporaryDirectory() as folder:
        clone = Path(folder) / "clone"
        subprocess.run(["git", "clone", "--quiet", str(HERE.parents[1]), str(clone)], check=True)
        for module in names or modules:
            asked = modules[module]
            left = survivors(clone, module, asked["mutants"], asked["tests"])
            raised += len(left) > asked["survivors"]
            print(f"{module}: {len(left)} of {asked['mutants']} survive, {asked['survivors']} may", flush=True)
            print("".join(f"{diff}\n\n" for diff in left), flush=True)
    return min(raised, 1)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
