"""Calls by address: one compiled search serves every curve.

numba compiles a function for the types of its arguments, and with it all that it calls. A search that took a curve
as an argument would be compiled anew for each kind of curve, seconds each time. So the search takes the address of
the curve, and of the few functions that evaluate it, and only those are compiled for each curve.

Called from Python, an address is the thing itself, and everything runs as it is written. What numba is told of it
is in ``numba_types``.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

from camopt.core.kernels.arguments import ADDRESS, NONE, Code
from camopt.core.kernels.marks import called_by_kernels


def address_of_values(values):
    """The address at which a kernel keeps values until it returns; they are read by ``[0]``."""
    return (values,)


def called_by_address(returns: Any, *arguments: Any) -> Callable[[Callable[..., Any]], Any]:
    """Mark a function that is called by address, with the types of all arguments but the first, an address."""

    def mark(function: Callable[..., Any]) -> Any:
        part = called_by_kernels(function)
        part.code = Code(returns, (ADDRESS, *arguments))
        return part

    return mark


def function_address(function, values):
    """The address of a function that ``evaluates``, compiled for the types of some values."""
    return function


def call(code, arguments):
    """Call the function at an address with a tuple of arguments."""
    return code(*arguments)


class AddressedKernel:
    """A kernel for arguments of given types, called by its address from another library."""

    def __init__(self, kernel: Any, arguments: tuple[Any, ...]) -> None:
        self.kernel, self.code = kernel, Code(NONE, arguments)

    def __call__(self, *arguments: Any) -> Any:
        return self.kernel.in_python(*arguments)

    @cached_property
    def address(self) -> int:
        """Of the machine code, which is compiled here if it is not yet."""
        return int(self.kernel.machine_code(self.code.arguments).address)
