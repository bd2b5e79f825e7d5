"""What people and platforms read of the project: one version, one list of dependencies, forms that are whole."""

import re
import tomllib

import pytest
import yaml
from support.pages import ROOT

import camopt
from camopt.storage.version import VERSION

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
    def parted(text):
        name, _, bounds = re.fullmatch(r"([\w-]+)(\s*)(.*)", text).groups()
        return CONDA.get(name, name), bounds

    wanted = {("python", PROJECT["requires-python"]), *map(parted, PROJECT["dependencies"])}
    assert {*map(parted, recipe()["requirements"]["run"])} == wanted


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
