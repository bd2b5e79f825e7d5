"""The public names: each is there, is listed once, and whatever can be raised is among them."""

import inspect

import pytest

import camopt
from camopt import mistakes


@pytest.mark.parametrize("name", camopt.__all__)
def test_a_public_name_is_there_and_documented(name):
    value = getattr(camopt, name)
    assert inspect.getdoc(value)
    assert name in dir(camopt)


def test_every_exception_is_public():
    raised = {
        name
        for name, value in vars(mistakes).items()
        if inspect.isclass(value) and issubclass(value, Exception) and value.__module__ == mistakes.__name__
    }
    assert raised <= set(camopt.__all__)
