"""What is made from the code and kept beside it is fresh: the parts of pages, and the schema of scenes."""

from functools import cache
from importlib.util import module_from_spec, spec_from_file_location

from support.pages import ROOT

SPEC = spec_from_file_location("make", ROOT / "docs" / "make.py")
make = module_from_spec(SPEC)
SPEC.loader.exec_module(make)
made = cache(make.made)


def test_it_is_as_the_code_makes_it():
    stale = [file.name for file, text in made().items() if file.read_text(encoding="utf-8") != text]
    assert stale == [], "run: python docs/make.py"


def test_every_key_quantity_and_law_is_in_the_reference():
    pages = {file.stem: text for file, text in made().items()}
    assert "````{key} follower.dynamics.spring_rate" in pages["scene"]
    assert "````{key} limits.pressure_angle" in pages["limits"]
    assert "````{quantity} pressure_angle_max_deg" in pages["quantities"]
    assert "````{law} modified-sine" in pages["laws"]
