"""What is made from the code and kept beside it is fresh: the parts of pages, and the schema of scenes."""

from importlib.util import module_from_spec, spec_from_file_location

import pytest
from support.pages import ROOT

SPEC = spec_from_file_location("make", ROOT / "docs" / "make.py")
make = module_from_spec(SPEC)
SPEC.loader.exec_module(make)
MADE = make.made()


@pytest.mark.parametrize("file", MADE, ids=lambda file: file.name)
def test_it_is_as_the_code_makes_it(file):
    assert file.read_text(encoding="utf-8") == MADE[file], "run: python docs/make.py"


def test_every_key_quantity_and_law_is_in_the_reference():
    pages = {file.stem: text for file, text in MADE.items()}
    assert "````{key} follower.dynamics.spring_rate" in pages["scene"]
    assert "````{key} limits.pressure_angle" in pages["limits"]
    assert "````{quantity} pressure_angle_max_deg" in pages["quantities"]
    assert "````{law} modified-sine" in pages["laws"]
