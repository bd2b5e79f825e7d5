"""Python functions as quantities: how they are made known, found again by a name, and told from changed ones.

A scene has the name of a function, and this process knows the function. No file makes a process import anything: a
name is that of a function that ``quantity`` was given here, or of an entry point of an installed package.
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
_KNOWN_FUNCTIONS: dict[str, ArrayFunction] = {}
_FUNCTION_NUMBERS = count(1)
NOT_IMPORTABLE = "is no function that other processes can import: define it in a module of its own"


@dataclass(frozen=True)
class QuantityFunction:
    """A quantity that a Python function computes of columns of designs, for ``[quantities]`` of a scene.

    Parameters
    ----------
    name : str
        Name of the quantity.
    columns : tuple of str
        Quantities that the function takes, in this order.
    unit : str
        Unit of the value.
    sentence : str
        What the quantity is.
    function : callable
        From arrays, one a column, to an array.
    reference : str
        What scenes call the function: its module and name; of one that cannot be imported also a number.

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
        """What a scene has of it in ``[quantities]``."""
        columns = {"function": self.reference, "columns": [*self.columns]}
        return columns | {key: text for key in ("unit", "sentence") if (text := getattr(self, key))}


def quantity(
    function: ArrayFunction, columns: Sequence[str], *, name: str | None = None, unit: str = "", sentence: str = ""
) -> QuantityFunction:
    """A quantity that a Python function computes, for a scene to report, limit, minimise and maximise.

    The function takes an array of numbers for each column and returns an array as long, one number for each design.
    It is called with blocks of designs, from several threads at a time, and must treat each design by itself. A
    number that is not finite makes a design infeasible where a limit or an objective names the quantity. Verdicts
    that its numbers decide have the status ``sampled``, for these are no proof.

    Parameters
    ----------
    function : callable
        From arrays, one a column, to an array. Other processes take only functions that they can import.
    columns : sequence of str
        Quantities that the function takes, in this order; own ones of the scene above it too.
    name : str, optional
        Name of the quantity; that of the function if not given.
    unit : str, default ""
        Unit of the value, for headings and tables.
    sentence : str, default ""
        What the quantity is, for tables and reports.

    Returns
    -------
    QuantityFunction
        For ``scene.replace(quantities=[…])``.

    Raises
    ------
    BadInput
        If it is no function, or has no columns.

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
    if not columns or not all(isinstance(each, str) for each in columns):
        mistakes.append(Mistake("camopt", "columns", columns, "a list of names of quantities"))
    if mistakes:
        raise BadInput(mistakes)
    reference = reference_of(function)
    _KNOWN_FUNCTIONS[reference] = function
    called = getattr(function, "__name__", "") if name is None else name
    return QuantityFunction(called, tuple(columns), unit, sentence, function, reference)


def reference_of(function: ArrayFunction) -> str:
    """The module and name of a function; with a number of its own if no other process can import it by these."""
    module, name = getattr(function, "__module__", ""), getattr(function, "__qualname__", "")
    found: Any = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    importable = found is function and module != "__main__"
    return f"{module}:{name}" if importable else f"{module}:{name}#{next(_FUNCTION_NUMBERS)}"


@cache
def installed_quantities() -> Mapping[str, EntryPoint]:
    """The entry points that are quantities, none loaded; of two of a name the first on the path of imports."""
    return {each.name: each for each in reversed(tuple(entry_points(group=QUANTITY_GROUP)))}


@cache
def load_installed(name: str) -> QuantityFunction:
    """The quantity of an entry point.

    Raises
    ------
    ValueError
        If there is none, or what it has is no quantity; the message is the end of a sentence.
    """
    if name not in installed_quantities():
        raise ValueError(f"is no entry point of the group {QUANTITY_GROUP}: install the package that has it")
    entry = installed_quantities()[name]
    package = f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.module
    try:
        found = entry.load()
    except Exception as error:  # whatever a module does when it is imported
        raise ValueError(f"the entry point of {package} fails: {_first_line(error)}") from error
    if not isinstance(found, QuantityFunction):
        raise ValueError(
            f"the entry point of {package} has to be what camopt.quantity returns, not {type(found).__name__}"
        )
    return found


def _first_line(error: Exception) -> str:
    return shorten(f"{type(error).__name__}: {error}".splitlines()[0])


@dataclass(frozen=True)
class FunctionCall:
    """What a Python function makes of columns: it stands where an expression has its tree."""

    name: str
    """Of the quantity."""
    reference: str
    names: tuple[str, ...]

    def evaluate(self, columns: Mapping[str, Any], rules: Any = None) -> Any:
        """Its values.

        Raises
        ------
        BadInput
            If the function is not known here, fails, or returns anything but a number for each design.
        """
        given = [columns[name] for name in self.names]
        try:
            value = np.asarray(self.function(*(each.copy() for each in given)), dtype=float)
        except BadInput:
            raise
        except Exception as error:
            raise self._mistake(f"fails: {_first_line(error)}") from error
        if value.shape not in ((), given[0].shape):
            raise self._mistake(f"has to return an array of {given[0].size} numbers here, not one of {value.shape}")
        return value

    @property
    def function(self) -> ArrayFunction:
        """The function."""
        if self.reference in _KNOWN_FUNCTIONS:
            return _KNOWN_FUNCTIONS[self.reference]
        if not self.is_importable:
            raise self._mistake(NOT_IMPORTABLE)
        if ":" in self.reference:
            raise self._mistake("is not known here: give it to camopt.quantity in this process first")
        try:
            return load_installed(self.reference).function
        except ValueError as wrong:
            raise self._mistake(str(wrong)) from None

    def __reduce__(self) -> tuple[Any, ...]:
        """Another process gets the function too, if it can import it."""
        known = self.is_importable and self.reference in _KNOWN_FUNCTIONS
        shared = {self.reference: self.function} if known else {}
        return restore_call, (shared, self.name, self.reference, self.names)

    @property
    def is_importable(self) -> bool:
        """Whether other processes can import it."""
        return "#" not in self.reference

    @property
    def digest(self) -> str:
        """What changes if the function does; not with what it calls."""
        function = self.function
        kept = [getattr(function, "__defaults__", None), getattr(function, "__kwdefaults__", None)]
        kept += [cell.cell_contents for cell in getattr(function, "__closure__", None) or ()]
        facts = _code_facts(function.__code__) if hasattr(function, "__code__") else function
        try:
            data = pickle.dumps((facts, kept))
        except Exception:  # whatever cannot be pickled: it is this process's alone
            data = f"{id(function)} of {id(_KNOWN_FUNCTIONS)}".encode()
        return sha256(data).hexdigest()[:16]

    def check_importable(self) -> None:
        """BadInput unless another process can have the function: by an import, or as an entry point."""
        if not self.is_importable:
            raise self._mistake(NOT_IMPORTABLE)

    def _mistake(self, why: str) -> BadInput:
        return BadInput([Mistake("scene", f"quantities.{self.name}.function", self.reference, why, bare=True)])


def restore_call(functions: Mapping[str, ArrayFunction], *facts: Any) -> FunctionCall:
    """A call from another process, with its function made known here."""
    _KNOWN_FUNCTIONS.update(functions)
    return FunctionCall(*facts)


def _code_facts(code: CodeType) -> Any:
    """What a function does, without where it stands."""
    inner = [_code_facts(each) if isinstance(each, CodeType) else each for each in code.co_consts]
    return code.co_code, code.co_names, code.co_varnames, inner
