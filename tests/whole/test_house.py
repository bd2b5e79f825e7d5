"""The house: what no module may ask. Rules on imports and lengths are those of import-linter and ruff."""

import ast
import re
import tomllib
from functools import cache
from pathlib import Path

import pytest
from mutation.killers import CORE, killers
from support.sources import PACKAGE, parsed_modules

import camopt
from camopt.core.quantities import QUANTITIES
from camopt.model.effects import EFFECTS
from camopt.model.mechanisms.elements import BODIES, MOTIONS
from camopt.scene.limits import Limits
from camopt.scene.synthesis import OBJECTIVE_TERMS

DOORS = {"__init__", "__main__"}
"""They open the package, and import from anywhere."""
MOST_IMPORTS_INSIDE, MOST_OF_OURS = 68, 16
"""Imports inside functions, and those of modules of the package among them: lower them where there are fewer."""


MOST_STATEMENTS = {"core": 5_575, "model": 8_755, "scene": 6_325, "solve": 20_130, "show": 11_875, "cli": 1_070}
"""Budgets of statements of the six folders; that of commands has the package's own files. To raise one is a commit
that says why."""


def module_name(path: Path) -> str:
    """The name of a module without that of the package."""
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__")


FILES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}
"""All modules, by their names without that of the package."""


@cache
def trees() -> dict[str, ast.Module]:
    """The syntax trees of all modules."""
    return {module_name(path): tree for path, tree in parsed_modules(PACKAGE).items()}


def test_few_imports_are_inside_functions():
    """A budget, which ruff (PLC0415) has not."""
    functions = [node for tree in trees().values() for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    imports = {
        node for each in functions for node in ast.walk(each) if isinstance(node, ast.Import | ast.ImportFrom)
    }
    ours = {node for node in imports if ast.unparse(node).split()[1].startswith("camopt")}
    assert len(imports) <= MOST_IMPORTS_INSIDE
    assert len(ours) <= MOST_OF_OURS


@pytest.mark.parametrize("folder", MOST_STATEMENTS)
def test_statements_stay_within_their_budget(folder):
    parts = {folder, "", "__main__", "library"} if folder == "cli" else {folder}
    nodes = [node for name, tree in trees().items() if name.split(".")[0] in parts for node in ast.walk(tree)]
    count = sum(isinstance(node, ast.stmt) for node in nodes)
    assert 0 < count <= MOST_STATEMENTS[folder], f"raise MOST_STATEMENTS[{folder!r}] in a commit that says why"


def test_the_package_has_six_folders_and_each_says_what_it_is():
    assert {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()} == {*MOST_STATEMENTS}
    for folder in MOST_STATEMENTS:
        text = ast.get_docstring(trees()[folder]) or ""
        assert [word for word in ("In:", "Out:", "Read first:") if word not in text] == [], folder
        (first,) = re.findall(r"Read first: ``([\w/.]+)``", text)
        assert (PACKAGE / folder / first).is_file(), folder


ALSO_NAMES_OF_TERMS = {*OBJECTIVE_TERMS, *QUANTITIES, *EFFECTS}
"""Names of limits that terms of an objective, quantities or effects have too."""


@pytest.mark.parametrize(
    "part",
    [
        *("core.numerics", "model.motion", "model.mechanisms", "model.effects", "solve.verdicts", "solve.smallest"),
        *("solve.front", "solve.synthesis", "show.drawing"),
    ],
)
def test_no_search_no_proof_and_no_drawing_asks_for_a_limit_by_name(part):
    keys = {*Limits.model_fields, "shaft_diameter", "hub_diameter"} - ALSO_NAMES_OF_TERMS
    there = {name: tree for name, tree in trees().items() if name == part or name.startswith(f"{part}.")}
    assert there
    constants = ((name, node) for name, tree in there.items() for node in ast.walk(tree))
    declared = {("model.mechanisms.elements", key) for body in BODIES.values() for key in (*body.cam, *body.part)}
    assert {(n, c.value) for n, c in constants if isinstance(c, ast.Constant) and c.value in keys} <= declared


def test_only_mechanisms_name_forms_of_cams_and_motions_of_followers():
    words = {*BODIES, *MOTIONS}
    constants = ((name, node) for name, tree in trees().items() for node in ast.walk(tree))
    named = {(n, c.value) for n, c in constants if isinstance(c, ast.Constant) and c.value in words}
    assert {name for name, _ in named} == {"model.mechanisms.elements"}


def test_what_the_page_on_architecture_names_is_there():
    """Files by their paths, and constants by their names."""
    root = Path(camopt.__file__).parents[1]
    page = (root / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", page, flags=re.DOTALL))
    files = {each for each in named if re.fullmatch(r"[\w./-]+\.(py|md|json|sha256)", each) and "/" in each}
    constants = {each for each in named if re.fullmatch(r"[A-Z][A-Z_]{3,}", each)}
    assert len(files) > 20
    assert len(constants) > 5
    new = {"camopt/model/motion/poly11.py"}
    assert {f for f in files - new if not any((root / top / f).exists() for top in ("", "camopt"))} == set()
    text = "\n".join(
        path.read_text(encoding="utf-8") for top in ("camopt", "tests") for path in (root / top).rglob("*.py")
    )
    assert {each for each in constants if not re.search(rf"^{each}\b.*=", text, re.MULTILINE)} == set()


@pytest.mark.parametrize("name", sorted({*FILES} - DOORS))
def test_a_fault_in_a_module_is_sought_by_tests_that_know_it(name):
    found = killers(f"camopt.{name}".removesuffix(".__init__"))
    assert len(found) > len(CORE) or name.startswith(("cli", "show.drawing", "show.studies", "show.pictures"))


def test_modules_whose_survivors_are_counted_are_there_with_their_tests():
    tests = PACKAGE.parent / "tests"
    counted = tomllib.loads((tests / "mutation" / "survivors.toml").read_text(encoding="utf-8"))
    assert len(counted) == 6
    for module, entry in counted.items():
        assert {*entry} == {"mutants", "survivors", "tests", "note"}, module
        assert 0 <= entry["survivors"] < entry["mutants"], module
        named = [PACKAGE.parent / module, *(tests / f"{test}.py" for test in entry["tests"])]
        assert [path for path in named if not path.is_file()] == [], module
