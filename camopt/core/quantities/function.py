"""Python functions as quantities: registration, look-up by name, and a digest that changes with the code.

A scene has only the name of a function. The function was given to ``quantity`` in this process, or it is an entry
point of an installed package. So a scene file cannot make a process import code.
"""

import pickle
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from importlib.metadata import EntryPoint, entry_points
from itertools import count
from types import CodeType
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake, shorten

QUANTITY_GROUP = "camopt.quantities"
ArrayFunction = Callable[..., Any]
_REGISTERED_FUNCTIONS: dict[str, ArrayFunction] = {}
_FUNCTION_NUMBERS = count(1)
NOT_IMPORTABLE = "is a function that other processes cannot import: define it in a module of its own"


@dataclass(frozen=True)
class QuantityFunction:
    """A quantity that a Python function computes from columns of designs, for ``[quantities]`` of a scene.

    Parameters
    ----------
    name : str
        Name of the quantity.
    columns : tuple of str
        Quantities that the function takes, in this order.
    unit : str
        Unit of the value.
    sentence : str
        Description of the quantity.
    function : callable
        Takes one array a column and returns an array.
    reference : str
        Name of the function in scenes: its module and name, with a number if it cannot be imported.

    Examples
    --------
    >>> def price(mass, torque):
    ...     return 4.2 * mass + 11.0 * torque**0.8
    >>> camopt.quantity(price, ["cam_mass_kg", "torque_rms_N_m"], unit="EUR").name
    'price'
    """

    name: str
    columns: tuple[str, ...]
    unit: str
    sentence: str
    function: ArrayFunction = field(repr=False)
    reference: str

    @property
    def table(self) -> dict[str, Any]:
        """Table of the quantity in a scene's ``[quantities]``."""
        columns = {"function": self.reference, "columns": [*self.columns]}
        return columns | {key: text for key in ("unit", "sentence") if (text := getattr(self, key))}


def quantity(
    function: ArrayFunction, columns: Sequence[str], *, name: str | None = None, unit: str = "", sentence: str = ""
) -> QuantityFunction:
    """Make a quantity from a Python function, which a scene can report, limit, minimise or maximise.

    The function takes an array of numbers for each column and returns an array of the same length, with one number
    for each design. It is called with blocks of designs from several threads, and must treat each design by itself.
    If a limit or an objective names the quantity, a design whose number is not finite is infeasible. Verdicts that
    depend on the quantity have the status ``sampled``, because camopt cannot prove its numbers.

    Parameters
    ----------
    function : callable
        Takes one array a column and returns an array. Other processes take only functions that they can import.
    columns : sequence of str
        Quantities that the function takes, in this order. They may be quantities that the scene defines above it.
    name : str, optional
        Name of the quantity; that of the function if not given.
    unit : str, default ""
        Unit of the value, for headings and tables.
    sentence : str, default ""
        Description of the quantity, for tables and reports.

    Returns
    -------
    QuantityFunction
        For ``scene.replace(quantities=[…])``.

    Raises
    ------
    BadInput
        If ``function`` is not callable, or ``columns`` is empty.

    Examples
    --------
    >>> def footprint(radius):
    ...     return 4.0 * radius**2
    >>> area = camopt.quantity(footprint, ["outer_radius_mm"], name="footprint_mm2", unit="mm²")
    >>> scene = camopt.find_scene("knife-300rpm-offset").replace(quantities=[area])
    >>> cam = camopt.evaluate(scene)
    >>> cam["footprint_mm2"] == 4.0 * cam["outer_radius_mm"] ** 2
    True
    """
    mistakes = []
    if not callable(function):
        mistakes.append(Mistake("camopt", "function", function, "a function of arrays"))
    columns = [columns] if isinstance(columns, str) else [*columns]
    if not columns or not all(isinstance(column, str) for column in columns):
        mistakes.append(Mistake("camopt", "columns", columns, "a list of names of quantities"))
    if mistakes:
        raise BadInput(mistakes)
    reference = module_and_name_of_function(function)
    _REGISTERED_FUNCTIONS[reference] = function
    name = getattr(function, "__name__", "") if name is None else name
    return QuantityFunction(name, tuple(columns), unit, sentence, function, reference)


def module_and_name_of_function(function: ArrayFunction) -> str:
    """Module and name of a function, with a number if no other process can import it by them."""
    module, name = getattr(function, "__module__", ""), getattr(function, "__qualname__", "")
    importable_object: Any = sys.modules.get(module)
    for part in name.split("."):
        importable_object = getattr(importable_object, part, None)
    importable = importable_object is function and module != "__main__"
    return f"{module}:{name}" if importable else f"{module}:{name}#{next(_FUNCTION_NUMBERS)}"


@cache
def installed_quantities() -> Mapping[str, EntryPoint]:
    """Entry points of quantities by name, not loaded. Of two with one name, the first on the import path counts."""
    return {entry.name: entry for entry in reversed(tuple(entry_points(group=QUANTITY_GROUP)))}


@cache
def load_installed_quantity(name: str) -> QuantityFunction:
    """Load the quantity of an entry point.

    Raises
    ------
    ValueError
        If there is no such entry point, or it is no quantity. The message is the end of a sentence.
    """
    if name not in installed_quantities():
        raise ValueError(f"is not an entry point of the group {QUANTITY_GROUP}: install the package that has it")
    entry = installed_quantities()[name]
    package = f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.module
    try:
        loaded = entry.load()
    except Exception as error:  # importing a module may raise anything
        raise ValueError(f"the entry point of {package} fails: {_first_line(error)}") from error
    if not isinstance(loaded, QuantityFunction):
        raise ValueError(
            f"the entry point of {package} must be a result of camopt.quantity, not {type(loaded).__name__}"
        )
    return loaded


def _first_line(error: Exception) -> str:
    return shorten(f"{type(error).__name__}: {error}".splitlines()[0])


@dataclass(frozen=True)
class FunctionCall:
    """The call of a Python function with columns. It takes the place of an expression's tree."""

    name: str
    """Name of the quantity."""
    reference: str
    names: tuple[str, ...]

    def evaluate(self, columns: Mapping[str, Any], rules: Any = None) -> Any:
        """Values of the quantity, one for each design.

        Raises
        ------
        BadInput
            If the function is not registered here, fails, or does not return one number for each design.
        """
        arguments = [columns[name] for name in self.names]
        try:
            value = np.asarray(self.function(*(argument.copy() for argument in arguments)), dtype=float)
        except BadInput:
            raise
        except Exception as error:
            raise self._bad_function_error(f"fails: {_first_line(error)}") from error
        if value.shape not in ((), arguments[0].shape):
            raise self._bad_function_error(
                f"must return an array of {arguments[0].size} numbers, not one of shape {value.shape}"
            )
        return value

    @property
    def function(self) -> ArrayFunction:
        """The registered function, or that of the entry point.

        Raises
        ------
        BadInput
            If neither exists.
        """
        if self.reference in _REGISTERED_FUNCTIONS:
            return _REGISTERED_FUNCTIONS[self.reference]
        self.check_importable()
        if ":" in self.reference:
            raise self._bad_function_error("is not registered: give it to camopt.quantity in this process first")
        try:
            return load_installed_quantity(self.reference).function
        except ValueError as wrong:
            raise self._bad_function_error(str(wrong)) from None

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the function too if another process can import it."""
        registered = self.is_importable and self.reference in _REGISTERED_FUNCTIONS
        shared = {self.reference: self.function} if registered else {}
        return restore_call, (shared, self.name, self.reference, self.names)

    @property
    def is_importable(self) -> bool:
        """Whether other processes can import the function."""
        return "#" not in self.reference

    @property
    def digest(self) -> str:
        """Digest of the function's code, defaults and closure, but not of the functions that it calls."""
        function = self.function
        values = [getattr(function, "__defaults__", None), getattr(function, "__kwdefaults__", None)]
        values += [cell.cell_contents for cell in getattr(function, "__closure__", None) or ()]
        facts = _code_content_for_digest(function.__code__) if hasattr(function, "__code__") else function
        try:
            data = pickle.dumps((facts, values))
        except Exception:  # values that cannot be pickled belong to this process alone
            data = f"{id(function)} of {id(_REGISTERED_FUNCTIONS)}".encode()
        return sha256(data).hexdigest()[:16]

    def check_importable(self) -> None:
        """Raise BadInput unless another process can import the function or load its entry point."""
        if not self.is_importable:
            raise self._bad_function_error(NOT_IMPORTABLE)

    def _bad_function_error(self, why: str) -> BadInput:
        return BadInput([Mistake("scene", f"quantities.{self.name}.function", self.reference, why, bare=True)])


def restore_call(functions: Mapping[str, ArrayFunction], *call_fields: Any) -> FunctionCall:
    """Restore a call from another process and register its function here."""
    _REGISTERED_FUNCTIONS.update(functions)
    return FunctionCall(*call_fields)


def _code_content_for_digest(code: CodeType) -> Any:
    """Instructions, names and constants of a function, without file and lines."""
    inner = [_code_content_for_digest(value) if isinstance(value, CodeType) else value for value in code.co_consts]
    return code.co_code, code.co_names, code.co_varnames, inner
