"""Arguments of the public functions: scenes by name or path, counts, options by keyword."""

import os
import warnings
from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from logging import INFO, getLogger
from typing import Any, ParamSpec, TypeVar

from camopt.core.mistakes import BadInput, Mistake
from camopt.scene.scene import Scene, find_scene

SceneSource = Scene | str | os.PathLike[str]
"""A scene, the name of a shipped one, or the path of a TOML file."""
LOG = getLogger("camopt")

OptionParameters = ParamSpec("OptionParameters")
FunctionResult = TypeVar("FunctionResult")


def scene_from(scene_or_name: SceneSource) -> Scene:
    """The scene itself, or by name or path; errors are those of ``find_scene``."""
    if isinstance(scene_or_name, Scene):
        return scene_or_name
    if isinstance(scene_or_name, (str, os.PathLike)):
        return find_scene(scene_or_name)
    hint = "; Scene.from_dict makes a scene from a mapping" if isinstance(scene_or_name, dict) else ""
    hint = "; use its attribute scene" if isinstance(getattr(scene_or_name, "scene", None), Scene) else hint
    allowed = f"a Scene, the name of a shipped scene, or a TOML file{hint}"
    raise BadInput([Mistake("camopt", "scene", scene_or_name, allowed)])


def check_count(name: str, value: Any, least: int = 1) -> None:
    """Raise BadInput unless a count is a whole number of at least ``least``, or None for camopt's choice."""
    if value is not None and (not isinstance(value, int) or isinstance(value, bool) or value < least):
        raise BadInput([Mistake("camopt", name, value, f"a whole number of at least {least}")])


def allow_positional_options(
    function: Callable[OptionParameters, FunctionResult],
) -> Callable[OptionParameters, FunctionResult]:
    """Let a function accept its keyword-only options by position for one more version, with a warning.

    Without a ``tell``, messages of the function go to the logger "camopt".
    """
    parameters = signature(function).parameters.values()
    most = sum(each.kind is Parameter.POSITIONAL_OR_KEYWORD for each in parameters)
    names = [each.name for each in parameters if each.kind is Parameter.KEYWORD_ONLY]

    @wraps(function)
    def call(*args: OptionParameters.args, **kwargs: OptionParameters.kwargs) -> FunctionResult:
        options: dict[str, Any] = dict(kwargs)
        extra = dict(zip(names, args[most:], strict=False))
        if extra and len(args) <= most + len(names) and not extra.keys() & options.keys():
            what = f"{function.__name__} takes {', '.join(extra)} by keyword; the next version requires it"
            warnings.warn(what, DeprecationWarning, stacklevel=2)
            args, options = args[:most], options | extra  # type: ignore[assignment]
        if "tell" in names and options.get("tell") is None and LOG.isEnabledFor(INFO):
            options["tell"] = LOG.info
        return function(*args, **options)

    return call
