"""Calls by address, with which one compiled search serves every curve.

numba compiles a function for the types of its arguments, and with it all that it calls. A search that took a curve
as an argument would be compiled anew for each kind of curve, seconds each time. So the search takes the address of
the curve, and of the few functions that evaluate it, and only those are compiled for each curve.

Called from Python, an address is the thing itself, and everything runs as it is written.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

from numba import types
from numba.core import cgutils
from numba.core.typing.typeof import typeof_impl
from numba.extending import NativeValue, lower_builtin, models, register_model, type_callable, unbox

from camopt.numerics.compile import called_by_kernels


class CodeType(types.Type):
    """The numba type of a function's address: what it returns, and the types of its arguments."""

    def __init__(self, returns: Any, arguments: tuple[Any, ...]) -> None:
        self.returns, self.arguments = returns, arguments
        super().__init__(name=f"Code({returns}, {arguments})")


register_model(CodeType)(models.OpaqueModel)


def address_of(values):
    """Where a kernel keeps some values until it returns; what is there is read by ``[0]``."""
    return (values,)


@type_callable(address_of)
def _type_address_of(context):
    return lambda values: types.voidptr


@lower_builtin(address_of, types.Any)
def _lower_address_of(context, builder, signature, arguments):
    return builder.bitcast(cgutils.alloca_once_value(builder, arguments[0]), cgutils.voidptr_t)


def evaluates(returns: Any, *arguments: Any) -> Callable[[Callable[..., Any]], Any]:
    """Mark a function that is called by address, with the types of all arguments but the first, an address."""

    def mark(function: Callable[..., Any]) -> Any:
        part = called_by_kernels(function)
        vars(part)["code"] = CodeType(returns, (types.voidptr, *arguments))
        return part

    return mark


def code_of(function, values):
    """The address of a function that ``evaluates``, compiled for the types of some values."""
    return function


@type_callable(code_of)
def _type_code_of(context):
    def typer(function, values):
        code = function.dispatcher.code
        function.get_call_type(context, (types.CPointer(values), *code.arguments[1:]), {})
        return code

    return typer


@lower_builtin(code_of, types.Dispatcher, types.Any)
def _lower_code_of(context, builder, signature, arguments):
    function, values = signature.args
    compiled = function.dispatcher.overloads[types.CPointer(values), *signature.return_type.arguments[1:]]
    context.active_code_library.add_linking_library(compiled.library)
    return builder.bitcast(context.declare_function(builder.module, compiled.fndesc), cgutils.voidptr_t)


def call(code, arguments):
    """Call what is at an address, with a tuple of arguments."""
    return code(*arguments)


@type_callable(call)
def _type_call(context):
    def typer(code, arguments):
        fits = len(arguments) == len(code.arguments) and all(
            context.can_convert(given, asked) is not None
            for given, asked in zip(arguments, code.arguments, strict=True)
        )
        return code.returns if fits else None

    return typer


@lower_builtin(call, CodeType, types.BaseTuple)
def _lower_call(context, builder, signature, arguments):
    code, given = signature.args
    values = [
        context.cast(builder, value, kind, asked)
        for value, kind, asked in zip(
            cgutils.unpack_tuple(builder, arguments[1]), given, code.arguments, strict=True
        )
    ]
    shape = context.call_conv.get_function_type(code.returns, code.arguments)
    function = builder.bitcast(arguments[0], shape.as_pointer())
    # kernels raise nothing; to look for errors would keep numba from dropping pairs of reference counts
    _, result = context.call_conv.call_function(builder, function, code.returns, code.arguments, values)
    return result


class Reached:
    """A kernel for arguments of given types, which a kernel of another library calls by its address."""

    def __init__(self, kernel: Any, arguments: tuple[Any, ...]) -> None:
        self.kernel, self.code = kernel, CodeType(types.none, arguments)

    def __call__(self, *arguments: Any) -> Any:
        return getattr(self.kernel, "py_func", self.kernel)(*arguments)

    @cached_property
    def address(self) -> int:
        """Of the machine code, which is compiled here if it is not yet."""
        compiled = self.kernel.get_compile_result(types.none(*self.code.arguments))
        address: int = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
        return address


@typeof_impl.register(Reached)
def _type_reached(reached, context):
    return reached.code


@unbox(CodeType)
def _unbox_code(kind, reached, context):
    address = context.pyapi.object_getattr_string(reached, "address")
    code = cgutils.alloca_once_value(context.builder, cgutils.get_null_value(cgutils.voidptr_t))
    with context.builder.if_then(cgutils.is_not_null(context.builder, address)):  # compiling may be interrupted
        context.builder.store(context.pyapi.long_as_voidptr(address), code)
        context.pyapi.decref(address)
    return NativeValue(context.builder.load(code), is_error=cgutils.is_null(context.builder, address))
