"""Calls by address: one compiled search serves every curve.

numba compiles a function, with all functions that it calls, for the types of its arguments. A search that took a
curve as an argument would be compiled again for each kind of curve, which takes seconds. So the search takes the
address of the curve and of the few functions that evaluate it. Only these functions are compiled for each curve.

In plain Python, an address is the object itself. ``numba_types`` registers addresses with numba.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

from camopt.core.kernels.arguments import ADDRESS, NONE, Code
from camopt.core.kernels.marks import called_by_kernels


def address_of_values(values):
    """Address at which a kernel keeps ``values`` until it returns; ``[0]`` reads them."""
    return (values,)


def called_by_address(return_type: Any, *argument_types: Any) -> Callable[[Callable[..., Any]], Any]:
    """Mark a function that is called by address. The first argument is an address; the others have these types."""

    def mark(function: Callable[..., Any]) -> Any:
        part = called_by_kernels(function)
        part.code = Code(return_type, (ADDRESS, *argument_types))
        return part

    return mark


def function_address(function, values):
    """Address of a function that evaluates ``values``, compiled for their types."""
    return function


def call_by_address(code, arguments):
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
        """Address of the machine code, which is compiled now if it was not."""
        return int(self.kernel.machine_code(self.code.arguments).address)
