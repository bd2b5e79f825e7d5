"""What people and platforms read of the project: one version, one list of dependencies, forms that are whole."""

import re
import sys
import tomllib
from importlib.metadata import distribution, packages_distributions, requires

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.version import Version
from support.pages import ROOT

import camopt
from camopt.core.storage.version import VERSION

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FORMS = [*(ROOT / ".github").rglob("*.yml"), *(ROOT / ".ci").rglob("*.yaml"), ROOT / "CITATION.cff"]
TEXTS = [*FORMS, *(ROOT / ".github").rglob("*.md"), *(ROOT / "docs" / "paper").iterdir(), ROOT / "pyproject.toml"]
CONDA = {"cvxpy": "cvxpy-base", "matplotlib": "matplotlib-base"}
"""Names that packages have there."""


def recipe():
    return yaml.safe_load((ROOT / ".ci" / "conda" / "recipe.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("file", FORMS, ids=lambda file: file.name)
def test_a_form_can_be_read(file):
    assert yaml.safe_load(file.read_text(encoding="utf-8"))


def test_the_version_is_one():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"]
    versions = re.findall(r"^## ([\d.]+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
    assert {cited, recipe()["context"]["version"], versions[0], camopt.__version__} == {VERSION}
    assert versions == sorted(versions, reverse=True)


def test_the_recipe_has_the_dependencies_of_the_project():
    def split_requirement(text):
        name, _, bounds = re.fullmatch(r"([\w-]+)(\s*)(.*)", text).groups()
        return CONDA.get(name, name), bounds

    wanted = {("python", PROJECT["requires-python"]), *map(split_requirement, PROJECT["dependencies"])}
    assert {*map(split_requirement, recipe()["requirements"]["run"])} == wanted


def test_the_versions_between_are_above_the_lowest():
    """Those of ``.ci/versions between``: allowed, and not what ``.ci/versions lowest`` runs already."""
    script = (ROOT / ".ci" / "versions").read_text(encoding="utf-8")
    between = {name: Version(version) for name, version in re.findall(r"([a-z]+)==([\d.]+)", script)}
    assert between.keys() >= {"pydantic", "numpy", "pandas", "pyarrow", "numba"}
    allowed = {wanted.name: wanted.specifier for wanted in map(Requirement, PROJECT["dependencies"])}
    for name, version in between.items():
        (floor,) = (Version(each.version) for each in allowed[name] if each.operator == ">=")
        assert version in allowed[name]
        assert version.release[:2] > floor.release[:2]


def test_the_docs_need_what_their_extra_installs():
    """Each package that a script of the site imports is of camopt, of its extra ``docs``, or of what these need."""
    listed = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["docs"]]
    names = {Requirement(each).name for each in listed}
    further = [each for name in names for each in requires(name) or () if "extra ==" not in each]
    installed = {name.lower() for name in [*names, *(Requirement(each).name for each in further), "camopt"]}
    scripts = [file for file in (ROOT / "docs").rglob("*.py") if "_build" not in file.parts]
    text = "\n".join(file.read_text(encoding="utf-8") for file in scripts)
    imported = set(re.findall(r"^(?:from|import) (\w+)", text, re.M)) - sys.stdlib_module_names
    distributions = packages_distributions()
    assert {"sphinx", "matplotlib"} <= imported
    for name in imported & distributions.keys():  # not those of the docs' and the tests' own folders
        assert installed & {each.lower() for each in distributions[name]}, name


def test_the_readme_of_a_package_index_has_absolute_links():
    """Each link and picture of the installed metadata begins with an address; install again to renew it."""
    readme = distribution("camopt").read_text("METADATA") or ""
    pictures, links = (re.findall(mark, readme) for mark in (r"!\[[^\]]*\]\(([^)]+)\)", r"\]\(([^)]+)\)"))
    assert len(links) > 5
    assert pictures
    assert not re.search(r"^\[[^\]]+\]:|<(?:a|img)\b", readme, re.M)  # other forms of links, which the build leaves
    address = re.escape(PROJECT["urls"]["Repository"])
    assert all(re.match(rf"{address}/raw/v[\d.]+/\S+$", each) for each in pictures)
    assert all(re.match(r"https://\S+$", each) for each in links)
    there = [each.removeprefix(f"{PROJECT['urls']['Repository']}/blob/v{VERSION}/") for each in links]
    assert all((ROOT / each).exists() for each in there if not each.startswith("https:"))


def test_what_the_paper_cites_is_in_its_list_and_nothing_else():
    folder = ROOT / "docs" / "paper"
    cited = set(re.findall(r"@([a-z]+\d{4})", (folder / "paper.md").read_text(encoding="utf-8")))
    assert cited == set(re.findall(r"^@\w+\{(\w+),", (folder / "paper.bib").read_text(encoding="utf-8"), re.M))


@pytest.mark.parametrize("file", TEXTS, ids=lambda file: file.name)
def test_no_registry_and_no_person_is_named(file):
    text = file.read_text(encoding="utf-8")
    assert not re.search(r"pypi\.org|pythonhosted|anaconda\.(org|com)|[\w.]+@[\w-]+\.\w{2,}", text)


def test_the_address_of_the_project_is_to_be_filled_in_at_one_place():
    places = [file for file in TEXTS if "example.org" in file.read_text(encoding="utf-8")]
    assert [file.name for file in places] == ["pyproject.toml"]
