"""The glossary of ``docs/nomenclature.md``: its nouns are the classes of the package."""

import ast
import re
from functools import cache

from support.pages import ROOT
from support.sources import PACKAGE, parsed_modules

PAGE = (ROOT / "docs" / "nomenclature.md").read_text(encoding="utf-8")
(SECTION,) = re.findall(r"^## Words of the code\n(.*?)^## ", PAGE, re.DOTALL | re.MULTILINE)
ROWS = re.findall(r"^\| (?!noun|---)(\S[^|]*?) \| ([^|]+?) \|$", SECTION, re.MULTILINE)
IN_CODE = [noun.strip("`") for noun, _ in ROWS if noun.startswith("`")]
TERMS = [noun for noun, _ in ROWS if not noun.startswith("`")]


@cache
def defined_names():
    """Names of the classes and functions of the package."""
    defined = (ast.ClassDef, ast.FunctionDef)
    trees = parsed_modules(PACKAGE).values()
    return {node.name for tree in trees for node in ast.walk(tree) if isinstance(node, defined)}


def test_the_glossary_has_at_most_60_nouns_and_each_once():
    nouns = IN_CODE + TERMS
    assert len(nouns) == len(set(nouns)) == len(re.findall(r"^\| ", SECTION, re.MULTILINE)) - 2
    assert 40 <= len(nouns) <= 60


def test_nouns_in_code_font_are_defined_in_the_package():
    assert sorted(set(IN_CODE) - defined_names()) == []


def test_plain_terms_are_not_names_of_the_package():
    assert sorted(set(TERMS) & defined_names()) == []


def test_each_noun_has_one_sentence_or_two():
    assert [noun for noun, meaning in ROWS if not 2 < len(meaning.split()) <= 30 or not meaning.endswith(".")] == []
