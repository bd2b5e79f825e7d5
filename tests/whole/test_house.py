"""The house: what imports what, and what no module may ask."""

import ast
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from mutation.killers import CORE, killers

import camopt
from camopt.effects import EFFECTS
from camopt.mechanisms.body import BODIES
from camopt.mechanisms.follower import MOTIONS
from camopt.quantities import QUANTITIES
from camopt.scene.limits import Limits
from camopt.scene.synthesis import OBJECTIVE_TERMS

PACKAGE = Path(camopt.__file__).parent
ROOMS = {
    "mistakes": "",
    "kernels": "mistakes",
    "quantities": "mistakes",
    "storage": "mistakes kernels",
    "engines": "mistakes kernels storage",
    "numerics": "kernels",
    "trains": "numerics",
    "motion": "mistakes numerics trains",
    "mechanisms": "kernels numerics motion",
    "effects": "kernels quantities numerics trains motion mechanisms",
    "scene": "mistakes quantities storage numerics trains motion mechanisms",
    "problem": "mistakes quantities numerics trains motion mechanisms effects scene",
    "tables": "mistakes quantities storage numerics motion scene problem",
    "verdicts": "mistakes quantities numerics trains motion mechanisms effects scene problem tables",
    "smallest": "mistakes quantities engines numerics motion mechanisms effects scene problem tables verdicts",
    "drawing": (
        "mistakes quantities storage numerics trains motion mechanisms effects scene problem tables verdicts"
    ),
    "tolerances": "mistakes quantities numerics motion mechanisms effects scene problem tables verdicts drawing",
    "front": (
        "mistakes quantities storage engines numerics motion mechanisms effects scene problem tables verdicts "
        "smallest"
    ),
    "synthesis": (
        "mistakes quantities storage engines numerics motion mechanisms effects scene problem tables verdicts "
        "smallest drawing"
    ),
    "contour": "mistakes numerics motion mechanisms scene problem verdicts",
    "measured": (
        "mistakes quantities storage numerics motion mechanisms effects scene problem tables verdicts tolerances "
        "drawing synthesis contour"
    ),
    "comparing": (
        "mistakes quantities storage numerics mechanisms scene problem tables verdicts drawing front synthesis"
    ),
    "sheet": (
        "mistakes quantities storage numerics motion mechanisms effects scene problem tables verdicts drawing "
        "contour"
    ),
    "exporting": (
        "mistakes quantities storage numerics trains motion mechanisms effects scene problem tables verdicts "
        "drawing contour sheet"
    ),
    "studies": (
        "mistakes quantities storage engines numerics motion mechanisms effects scene problem tables verdicts "
        "smallest drawing tolerances"
    ),
    "reporting": (
        "mistakes kernels quantities storage numerics motion mechanisms scene problem tables verdicts tolerances "
        "smallest drawing front synthesis exporting studies"
    ),
    "cli": (
        "mistakes kernels quantities storage engines numerics motion mechanisms scene problem tables verdicts "
        "smallest drawing tolerances front synthesis measured comparing exporting studies reporting"
    ),
}
"""Folders and modules of the package in the order of the data, each with the rooms that it may import, and does.

A new arrow is a decision: it stands here, or the code finds another way. None runs back.
"""
DOORS = {"__init__", "__main__"}
"""They open the package, and import from anywhere."""
HEAVY = {
    "pint",
    "python_calamine",
    "ezdxf",
    "matplotlib",
    "pandas",
    "scipy",
    "numpy.polynomial",
    "shapely",
    "pyarrow",
    "xlsxwriter",
    "PIL",
    "imageio_ffmpeg",
    "moocore",
    "rich",
    "jinja2",
    "markupsafe",
    "tomlkit",
    "tqdm",
}
"""Packages that take long to import: functions that need them may import them."""
LATE = {
    ("engines", "engines.dask_cluster"): "it imports Dask",
    ("numerics.quadrature", "flint.arb"): "it gives the nodes of integrals, which most sweeps have not",
    ("kernels.compile", "kernels.beside"): "it imports subprocess and pickle",
    ("kernels.compile", "kernels.dispatchers"): "it imports numba",
    ("kernels.compile", "kernels.kernel_cache"): "it imports llvmlite",
    ("kernels.compile", "kernels.machine_code"): "it imports llvmlite",
    ("__main__", "cli.main"): "an interrupt while it is imported is told as one",
    ("drawing.canvas", "drawing.empty_figure"): "it imports matplotlib",
    ("verdicts.judging", "verdicts.certify"): "balls are for what rounding leaves open",
    ("verdicts.judging", "verdicts.narrowing"): "balls are for what rounding leaves open",
    ("tables.designs", "tables.table"): "it imports pyarrow",
    ("tolerances.batch", "tables.table"): "it imports pyarrow",
    ("storage.ownership", "storage.damage"): "it imports pyarrow",
    ("exporting.cam_points", "storage.sealed"): "it imports pyarrow",
    ("scene.complaints", "scene.schema"): "it has the tables of a scene, and these complain by it",
    ("scene.scene", "scene.units"): "it reads the docstrings of keys, for which most scenes have no use",
    ("exporting.cam_points", "tables.workbook"): "it imports XlsxWriter",
    ("studies.spectrum", "storage.sealed"): "it imports pyarrow",
    ("studies.spectrum", "tables.table"): "it imports pyarrow",
    ("reporting.report", "tables.table"): "it imports pyarrow",
    ("storage.checking", "storage.damage"): "it imports pyarrow",
    ("storage.version", "kernels.version"): "it imports hashlib",
    ("tables.writing", "tables.table"): "it imports pyarrow",
    ("front.journal", "front.batch_bytes"): "it imports pyarrow",
    ("front.estimate", "front.batch_bytes"): "it imports pyarrow",
    ("front.compared", "front.refine"): "it imports the searches of optimise",
    ("front.plan", "front.box_bounds"): "boxes of designs are for a front alone",
    ("front.every_cam", "smallest.exchange"): "balls are for what rounding leaves open",
    ("front.sweep", "front.front_search"): "boxes of designs are for a front alone",
    ("front.sweep", "front.checkpoint"): "boxes of designs are for a front alone",
}
"""Imports of the package's own modules inside functions, and why. Commands import what they run."""


FILES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}
"""All modules, by their names without that of the package."""


@cache
def trees() -> dict[str, ast.Module]:
    """The syntax trees of all modules."""
    return {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in FILES.items()}


def imported(node: ast.AST) -> Iterator[str]:
    """What a statement imports: modules of the package without its name, others with theirs."""
    found: list[str] = []
    if isinstance(node, ast.ImportFrom) and node.module:
        found = [f"{node.module}.{alias.name}" for alias in node.names]
    elif isinstance(node, ast.Import):
        found = [alias.name for alias in node.names]
    for name in found:
        within = name.removeprefix("camopt.")
        yield next((each for each in (within, within.rpartition(".")[0]) if name != within and each in FILES), name)


def late(tree: ast.Module) -> set[ast.AST]:
    """Statements inside functions."""
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    return {inner for function in functions for inner in ast.walk(function)}


def for_types(tree: ast.Module) -> set[ast.AST]:
    """Statements for type checkers alone."""
    tests = (
        node for node in ast.walk(tree) if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
    )
    return {inner for test in tests for inner in ast.walk(test)}


@cache
def arrows() -> list[tuple[str, str, bool]]:
    """All imports: (module, what it imports, whether inside a function)."""
    found = []
    for name, tree in trees().items():
        inside, unread = late(tree), for_types(tree)
        statements = (node for node in ast.walk(tree) if node not in unread)
        found += [(name, target, node in inside) for node in statements for target in imported(node)]
    return found


def room(name: str) -> str:
    return name.partition(".")[0]


def test_all_modules_are_in_a_room():
    assert {room(name) for name in FILES} == {*ROOMS, *DOORS}


def test_each_room_imports_what_it_may_and_nothing_else():
    arrows_of = {name: set[str]() for name in ROOMS}
    for name, target, _ in arrows():
        if target in FILES and room(name) not in DOORS and room(target) != room(name):
            arrows_of[room(name)].add(room(target))
    assert arrows_of == {name: {*allowed.split()} for name, allowed in ROOMS.items()}


def test_no_arrow_runs_back():
    order = [*ROOMS]
    back = [
        (name, to)
        for name, allowed in ROOMS.items()
        for to in allowed.split()
        if order.index(to) > order.index(name)
    ]
    assert back == []


def test_no_circle_of_imports():
    graph: dict[str, set[str]] = {name: set() for name in FILES}
    for name, target, inside in arrows():
        if target in FILES and not inside and target != name:
            graph[name].add(target)
    assert len(list(TopologicalSorter(graph).static_order())) == len(FILES)  # CycleError names a circle


def test_imports_inside_functions_have_a_reason():
    unexplained, unused = set(), set(LATE)
    for name, target, inside in arrows():
        if inside and room(name) != "cli":
            unused.discard((name, target))
            heavy = any(target == each or target.startswith(f"{each}.") for each in HEAVY)
            if not heavy and (name, target) not in LATE:
                unexplained.add((name, target))
    assert (unexplained, unused) == (set(), set())


def test_numba_is_imported_where_machine_code_is_made_and_nowhere_else():
    found = {name for name, target, _ in arrows() if target.partition(".")[0] == "numba"}
    assert found == {"kernels.dispatchers", "kernels.numba_types"}


ALSO_NAMES_OF_TERMS = {*OBJECTIVE_TERMS, *QUANTITIES, *EFFECTS}
"""Names of limits that terms of an objective, quantities or effects have too."""


@pytest.mark.parametrize(
    "part",
    ["numerics", "motion", "mechanisms", "effects", "verdicts", "smallest", "front", "synthesis", "drawing"],
)
def test_no_search_no_proof_and_no_drawing_asks_for_a_limit_by_name(part):
    keys = {*Limits.model_fields, "shaft_diameter", "hub_diameter"} - ALSO_NAMES_OF_TERMS
    there = {name: tree for name, tree in trees().items() if name == part or name.startswith(f"{part}.")}
    assert there
    constants = ((name, node) for name, tree in there.items() for node in ast.walk(tree))
    declared = {("mechanisms.body", key) for body in BODIES.values() for key in (*body.cam, *body.part)}
    assert {(n, c.value) for n, c in constants if isinstance(c, ast.Constant) and c.value in keys} <= declared


def test_only_mechanisms_name_forms_of_cams_and_motions_of_followers():
    words = {*BODIES, *MOTIONS}
    constants = ((name, node) for name, tree in trees().items() for node in ast.walk(tree))
    named = {(n, c.value) for n, c in constants if isinstance(c, ast.Constant) and c.value in words}
    assert {name for name, _ in named} == {"mechanisms.body", "mechanisms.follower"}


def test_what_the_page_on_architecture_names_is_there():
    """Files by their paths, and constants by their names."""
    root = Path(camopt.__file__).parents[1]
    page = (root / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", page, flags=re.DOTALL))
    files = {each for each in named if re.fullmatch(r"[\w./-]+\.(py|md|json|sha256)", each) and "/" in each}
    constants = {each for each in named if re.fullmatch(r"[A-Z][A-Z_]{3,}", each)}
    assert len(files) > 20
    assert len(constants) > 5
    new = {"camopt/motion/poly11.py"}
    assert {f for f in files - new if not any((root / top / f).exists() for top in ("", "camopt"))} == set()
    text = "\n".join(
        path.read_text(encoding="utf-8") for top in ("camopt", "tests") for path in (root / top).rglob("*.py")
    )
    assert {each for each in constants if not re.search(rf"^{each}\b.*=", text, re.MULTILINE)} == set()


@pytest.mark.parametrize("name", sorted({*FILES} - DOORS))
def test_a_fault_in_a_module_is_sought_by_tests_that_know_it(name):
    found = killers(f"camopt.{name}".removesuffix(".__init__"))
    assert len(found) > len(CORE) or name.partition(".")[0] in {"cli", "drawing", "studies"}


def test_modules_whose_survivors_are_counted_are_there_with_their_tests():
    tests = PACKAGE.parent / "tests"
    counted = tomllib.loads((tests / "mutation" / "survivors.toml").read_text(encoding="utf-8"))
    assert len(counted) == 6
    for module, entry in counted.items():
        assert {*entry} == {"mutants", "survivors", "tests", "note"}, module
        assert 0 <= entry["survivors"] < entry["mutants"], module
        named = [PACKAGE.parent / module, *(tests / f"{test}.py" for test in entry["tests"])]
        assert [path for path in named if not path.is_file()] == [], module


MOST_LINES, MOST_ARGUMENTS = 60, 8


AS_COMMANDS = {
    ("front.sweep", "sweep"),
    ("front.parts", "sweep_part"),
    ("exporting.gcode", "write"),
    ("measured.fit", "fit"),
}
"""Functions that take what the options of their command ask, by the same names."""


def test_functions_are_short_and_take_few_arguments():
    """Docstrings do not count; the options of a command are its arguments."""
    long, many = set(), set()
    for name, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                given, body = node.args, node.body[1:] if ast.get_docstring(node) else node.body
                lines = (node.end_lineno or 0) - body[0].lineno + 1 if body else 0
                if lines > MOST_LINES:
                    long.add((name, node.name))
                asked = len([*given.posonlyargs, *given.args, *given.kwonlyargs])
                if asked > MOST_ARGUMENTS and not name.startswith("cli.commands."):
                    many.add((name, node.name))
    assert (long, many) == (set(), AS_COMMANDS)
