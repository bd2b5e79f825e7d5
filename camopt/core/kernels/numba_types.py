"""Registration of the package's types with numba: value types, function addresses, functions chosen by type.

Only ``dispatchers`` imports this module, when the first kernel is compiled.
"""

from collections.abc import Callable
from functools import cache, wraps
from inspect import Parameter, Signature
from types import NoneType
from typing import Any

from numba import types
from numba.core import cgutils
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.typing.typeof import typeof_impl
from numba.extending import (
    lower_builtin,
    make_attribute_wrapper,
    models,
    overload,
    register_model,
    type_callable,
)

from camopt.core.kernels.address_calls import address_of_values, call_by_address, function_address
from camopt.core.kernels.arguments import Code, Record
from camopt.core.kernels.marks import CHOICES, VALUE_TYPES, KernelPart


class PartLibrary(JITCodeLibrary):
    """Code of functions that only kernels call. It becomes machine code inside the kernels."""

    def _optimize_final_module(self) -> None:
        """Do nothing: the code is optimised inside each kernel."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, which numba reads as no pointer."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Any:
        """Receiver of a function's environment, by which machine code reaches the interpreter."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: without machine code there is no place for the environment."""


class KernelLibrary(JITCodeLibrary):
    """Code of a kernel. LLVM inlines it from the innermost calls outwards and simplifies each function between.

    Numba would first inline all calls at once, for reference counts, which kernels do not have. The function is
    then so long that LLVM takes ten times as long.
    """

    def _optimize_final_module(self) -> None:
        self.enable_object_caching()
        passes, builder = self._codegen._module_pass_manager()
        passes.run(self._final_module, builder)


def compiler_for_library_class(library_class: type[JITCodeLibrary]) -> Any:
    """Numba's compiler, which puts a function into a library of a class."""
    return lambda typing, target, _, *others: Compiler(
        typing, target, library_class(target.codegen(), "part"), *others
    )


# without wrappers for calls from Python, which never occur, compilation is faster
KERNEL_OPTIONS: Any = {
    "pipeline_class": compiler_for_library_class(KernelLibrary),
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
LINKED_OPTIONS: Any = {**KERNEL_OPTIONS, "pipeline_class": compiler_for_library_class(PartLibrary)}
INLINE_OPTIONS: Any = {"forceinline": True, **LINKED_OPTIONS}


@typeof_impl.register(KernelPart)
def _dispatcher_type_of_part(part, context):
    return types.Dispatcher(part.dispatcher)


# ------------------------------------------------------------------------ descriptions


@cache
def numba_type(kind: Any) -> Any:
    """Numba's type for an ``ArgumentKind``, a ``Record`` or a ``Code``."""
    if isinstance(kind, Record):
        return types.BaseTuple.from_types(tuple(map(numba_type, kind.fields)), kind.owner)
    if isinstance(kind, Code):
        return CodeType(kind)
    number = getattr(types, kind.name)
    return types.Array(number, kind.dimensions, kind.layout) if kind.dimensions else number


def python_class_of_numba_type(numba_kind: Any) -> type:
    """Python's class for a type of numba: a value type, a NamedTuple, tuple, NoneType, or else float."""
    if isinstance(numba_kind, ValueType):
        return numba_kind.owner
    if isinstance(numba_kind, types.NoneType):
        return NoneType
    owner: type = getattr(numba_kind, "instance_class", tuple if isinstance(numba_kind, types.BaseTuple) else float)
    return owner


# ------------------------------------------------------------------------ value types


class ValueType(types.Type):
    """Numba's type of a class of named numbers."""

    def __init__(self, owner: type) -> None:
        self.owner = owner
        super().__init__(name=owner.__name__)


def _register_value_type(owner: type, fields: tuple[str, ...]) -> None:
    """Let kernels make objects of a class and read their fields, each in a register."""
    members = [(name, types.float64) for name in fields]
    type_class = type(f"{owner.__name__}Type", (ValueType,), {})
    kind = type_class(owner)
    register_model(type_class)(lambda manager, kind: models.StructModel(manager, kind, members))
    for name in fields:
        make_attribute_wrapper(type_class, name, name)
    parameters = [Parameter(name, Parameter.POSITIONAL_ONLY) for name in fields]

    def typer(*numbers):
        return kind

    vars(typer)["__signature__"] = Signature(parameters)
    type_callable(owner)(lambda context: typer)

    @lower_builtin(owner, *[types.float64] * len(fields))
    def build_struct(context, builder, signature, values):
        struct = cgutils.create_struct_proxy(kind)(context, builder)
        for name, value in zip(fields, values, strict=True):
            setattr(struct, name, value)
        return struct._getvalue()


# ------------------------------------------------------------------------ functions chosen by type


def _register_choice(function: Callable[..., Any], choose: Callable[..., Any]) -> None:
    """Let kernels call the function that ``choose`` returns for the argument classes, in place of ``function``."""
    overload(function, jit_options=INLINE_OPTIONS)(
        wraps(choose)(lambda *kinds: choose(*map(python_class_of_numba_type, kinds)))
    )


def register_marks() -> None:
    """Register all marks since the last call with numba."""
    while VALUE_TYPES:
        _register_value_type(*VALUE_TYPES.pop(0))
    while CHOICES:
        _register_choice(*CHOICES.pop(0))


# ------------------------------------------------------------------------ addresses of functions


class CodeType(types.Type):
    """Numba's type of a function's address."""

    def __init__(self, code: Code) -> None:
        self.returns, self.arguments = numba_type(code.returns), tuple(map(numba_type, code.arguments))
        super().__init__(name=f"Code({self.returns}, {self.arguments})")


register_model(CodeType)(models.OpaqueModel)


@type_callable(address_of_values)
def _typing_of_value_address(context):
    return lambda values: types.voidptr


@lower_builtin(address_of_values, types.Any)
def _lower_value_address(context, builder, signature, arguments):
    return builder.bitcast(cgutils.alloca_once_value(builder, arguments[0]), cgutils.voidptr_t)


@type_callable(function_address)
def _typing_of_function_address(context):
    def typer(function, values):
        code = numba_type(function.dispatcher.part.code)
        function.get_call_type(context, (types.CPointer(values), *code.arguments[1:]), {})
        return code

    return typer


@lower_builtin(function_address, types.Dispatcher, types.Any)
def _lower_function_address(context, builder, signature, arguments):
    function, values = signature.args
    compiled = function.dispatcher.overloads[types.CPointer(values), *signature.return_type.arguments[1:]]
    context.active_code_library.add_linking_library(compiled.library)
    return builder.bitcast(context.declare_function(builder.module, compiled.fndesc), cgutils.voidptr_t)


@type_callable(call_by_address)
def _typing_of_call_by_address(context):
    def typer(code, arguments):
        return (
            code.returns
            if len(arguments) == len(code.arguments)
            and all(
                context.can_convert(argument, parameter) is not None
                for argument, parameter in zip(arguments, code.arguments, strict=True)
            )
            else None
        )

    return typer


@lower_builtin(call_by_address, CodeType, types.BaseTuple)
def _lower_call_by_address(context, builder, signature, arguments):
    code, kinds = signature.args
    values = [
        context.cast(builder, value, kind, parameter)
        for value, kind, parameter in zip(
            cgutils.unpack_tuple(builder, arguments[1]), kinds, code.arguments, strict=True
        )
    ]
    shape = context.call_conv.get_function_type(code.returns, code.arguments)
    function = builder.bitcast(arguments[0], shape.as_pointer())
    # kernels raise nothing, and checks for errors would keep numba from removing reference counts
    _, result = context.call_conv.call_function(builder, function, code.returns, code.arguments, values)
    return result
