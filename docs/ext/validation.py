"""Directives of the page on validation: published cases computed anew, tests with a second answer, hard cases."""

import ast
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import camopt

TESTS = Path(__file__).parents[2] / "tests"
sys.path.insert(0, str(TESTS))

from support.hard_cases import HARD_CASES  # noqa: E402
from support.published import CASES, Answer, Case  # noqa: E402
from support.references import REFERENCE, WORKED, relative_error  # noqa: E402
from support.second_answers import SECOND_ANSWERS  # noqa: E402


class Published(SphinxDirective):
    """The cases of a topic, each with a table: the printed answer, that of camopt, and their difference."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        self.env.note_dependency(str(TESTS / "support" / "published.py"))
        cases = [case for case in CASES if case.topic == self.arguments[0]]
        if not cases:
            raise self.error(f"no published case of the topic {self.arguments[0]!r}")
        return self.parse_text_to_nodes("\n".join(map(described, cases)))


class References(SphinxDirective):
    """Cams whose quantities another program has computed to many digits, with the largest difference of each."""

    def run(self) -> list[nodes.Node]:
        worked = [(f"`{name}`", camopt.find_scene(name), entry["expected"]) for name, entry in WORKED.items()]
        rows = [differences([case]) for case in worked]
        others = [("", camopt.Scene.from_dict(entry["scene"]), entry["expected"]) for entry in REFERENCE.values()]
        _, *summary = differences(others)
        rows.append((f"{len(others)} cams of all mechanisms and laws", *summary))
        body = "\n".join(f"| {name} | {count} | {off:.1g} |" for name, count, off in rows)
        return self.parse_text_to_nodes(f"| cam | numbers | largest relative difference |\n|---|--:|--:|\n{body}\n")


class SecondAnswers(SphinxDirective):
    """The tests that compare camopt with something independent, by kind; their names are read as sentences."""

    def run(self) -> list[nodes.Node]:
        parts = []
        for kind, (words, tests) in SECOND_ANSWERS.items():
            rows = "\n".join(f"| {sentence(test)} | `{test}` |" for test in tests)
            parts.append(f"**{kind}.** {words}\n\n| what | test |\n|---|---|\n{rows}\n")
        return self.parse_text_to_nodes("\n".join(parts))


class HardCases(SphinxDirective):
    """The hard cases, each with its tests."""

    def run(self) -> list[nodes.Node]:
        rows = "".join(f"| {what} | {', '.join(map(sentence, tests))} |\n" for what, tests in HARD_CASES.items())
        return self.parse_text_to_nodes(f"| case | tests |\n|---|---|\n{rows}")


def differences(cases: list[tuple[str, camopt.Scene, dict[str, Any]]]) -> tuple[str, int, float]:
    """The name of the first cam, how many numbers are compared, and the largest relative difference of any."""
    off = []
    for _, scene, expected in cases:
        found = camopt.evaluate(scene)
        off += [relative_error(found, name, value) for name, value in expected.items()]
    return cases[0][0], len(off), max(off)


def described(case: Case) -> str:
    """A case in Markdown."""
    rows = "\n".join(row(answer, value) for answer, value in zip(case.answers, case.ours(), strict=True))
    note = f" *{case.note}*" if case.note else ""
    head = f"**{case.name}.** Source: {case.source}. {case.second_answer_text} Inputs: {case.inputs}.{note}"
    heads = f"| | {'in print' if case.read else 'as quoted'} | camopt | difference | allowed |"
    return f"{head}\n\n{heads}\n|---|--:|--:|--:|--:|\n{rows}\n"


def row(answer: Answer, value: float) -> str:
    off = abs(value - answer.value)
    if not off <= answer.allowed_error:
        raise ValueError(f"{answer.what}: {answer.printed} by its source, {value} by camopt")
    text = isinstance(answer.printed, str)
    printed = str(answer.printed) if text else f"{answer.printed:.8g}"
    digits = max(7, len(printed) + 1) if text else 8
    shown = f"{value:.{digits}g}" if abs(value) > 1e-12 else "0"
    unit = f", {answer.unit}" if answer.unit else ""
    difference = f"{off:.1g}" if off < 1.0 else f"{off:.3g}"
    return f"| {answer.what}{unit} | {printed} | {shown} | {difference} | {answer.allowed_error:.2g} |"


def sentence(test: str) -> str:
    """The name of a test as a sentence; an error if there is no such test."""
    file, name = test.split("::")
    tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
    if not any(isinstance(node, ast.FunctionDef) and node.name == name for node in tree.body):
        raise ValueError(f"there is no test {test}")
    words = name.removeprefix("test_").replace("_", " ")
    return words[0].upper() + words[1:]


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("published", Published)
    app.add_directive("references", References)
    app.add_directive("second-answers", SecondAnswers)
    app.add_directive("hard-cases", HardCases)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
