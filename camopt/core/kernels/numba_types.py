"""Registration of the package's types with numba: value types, function addresses, functions chosen by type.

Imported by ``dispatchers`` alone, when the first kernel is compiled.
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

from camopt.core.kernels.address_calls import address_of_values, call, function_address
from camopt.core.kernels.arguments import Code, Record
from camopt.core.kernels.marks import CHOICES, VALUE_TYPES, KernelPart


class PartLibrary(JITCodeLibrary):
    """The code of functions called only by kernels: it becomes machine code inside them, not on its own."""

    def _optimize_final_module(self) -> None:
        """Nothing: it is optimised in each kernel, with all that calls it."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """None, which numba writes as 0."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Any:
        """What numba gives a function's environment to, with which machine code reaches the interpreter."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Nothing: without machine code there is no place to put it."""


class PartCompiler(Compiler):
    """Compiles a function into a ``PartLibrary``."""

    def __init__(self, typing: Any, target: Any, library: Any, *others: Any) -> None:
        own = PartLibrary(target.codegen(), "part")
        super().__init__(typing, target, own, *others)


UNWRAPPED_OPTIONS: Any = {
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}  # never called from Python: compiles faster
LINKED_OPTIONS: Any = {"pipeline_class": PartCompiler, **UNWRAPPED_OPTIONS}
INLINE_OPTIONS: Any = {"forceinline": True, **LINKED_OPTIONS}


@typeof_impl.register(KernelPart)
def _type_part(part, context):
    return types.Dispatcher(part.dispatcher)


# ------------------------------------------------------------------------ descriptions


@cache
def numba_type(kind: Any) -> Any:
    """The numba type that a ``ArgumentKind``, a ``Record`` or a ``Code`` describes."""
    if isinstance(kind, Record):
        return types.BaseTuple.from_types(tuple(map(numba_type, kind.fields)), kind.owner)
    if isinstance(kind, Code):
        return CodeType(kind)
    number = getattr(types, kind.name)
    return types.Array(number, kind.dimensions, kind.layout) if kind.dimensions else number


def python_class_of(kind: Any) -> type:
    """The class for a numba type: a value type, a NamedTuple, tuple, NoneType, or float for all others."""
    if isinstance(kind, ValueType):
        return kind.owner
    if isinstance(kind, types.NoneType):
        return NoneType
    owner: type = getattr(kind, "instance_class", tuple if isinstance(kind, types.BaseTuple) else float)
    return owner


# ------------------------------------------------------------------------ value types


class ValueType(types.Type):
    """The numba type of a class of numbers."""

    def __init__(self, owner: type) -> None:
        self.owner = owner
        super().__init__(name=owner.__name__)


def _register_value_type(owner: type, fields: tuple[str, ...]) -> None:
    """Let kernels make values of a class and read their fields, each in a register."""
    members = [(name, types.float64) for name in fields]
    own = type(f"{owner.__name__}Type", (ValueType,), {})
    kind = own(owner)
    register_model(own)(lambda manager, kind: models.StructModel(manager, kind, members))
    for name in fields:
        make_attribute_wrapper(own, name, name)
    parameters = [Parameter(name, Parameter.POSITIONAL_ONLY) for name in fields]

    def typer(*numbers):
        return kind

    vars(typer)["__signature__"] = Signature(parameters)
    type_callable(owner)(lambda context: typer)

    @lower_builtin(owner, *[types.float64] * len(fields))
    def _make(context, builder, signature, values):
        made = cgutils.create_struct_proxy(kind)(context, builder)
        for name, value in zip(fields, values, strict=True):
            setattr(made, name, value)
        return made._getvalue()


# ------------------------------------------------------------------------ functions chosen by type


def _register_choice(function: Callable[..., Any], choose: Callable[..., Any]) -> None:
    """Let kernels call, in place of a function, the one that is chosen by the classes of its arguments."""

    @wraps(choose)
    def choose_by_class(*kinds):
        return choose(*map(python_class_of, kinds))

    overload(function, jit_options=INLINE_OPTIONS)(choose_by_class)


def register_marks() -> None:
    """Register with numba everything marked since the last call."""
    while VALUE_TYPES:
        _register_value_type(*VALUE_TYPES.pop(0))
    while CHOICES:
        _register_choice(*CHOICES.pop(0))


# ------------------------------------------------------------------------ addresses of functions


class CodeType(types.Type):
    """The numba type of a function's address."""

    def __init__(self, code: Code) -> None:
        self.returns, self.arguments = numba_type(code.returns), tuple(map(numba_type, code.arguments))
        super().__init__(name=f"Code({self.returns}, {self.arguments})")


register_model(CodeType)(models.OpaqueModel)


@type_callable(address_of_values)
def _type_address_of(context):
    return lambda values: types.voidptr


@lower_builtin(address_of_values, types.Any)
def _lower_address_of(context, builder, signature, arguments):
    return builder.bitcast(cgutils.alloca_once_value(builder, arguments[0]), cgutils.voidptr_t)


@type_callable(function_address)
def _type_code_of(context):
    def typer(function, values):
        code = numba_type(function.dispatcher.part.code)
        function.get_call_type(context, (types.CPointer(values), *code.arguments[1:]), {})
        return code

    return typer


@lower_builtin(function_address, types.Dispatcher, types.Any)
def _lower_code_of(context, builder, signature, arguments):
    function, values = signature.args
    compiled = function.dispatcher.overloads[types.CPointer(values), *signature.return_type.arguments[1:]]
    context.active_code_library.add_linking_library(compiled.library)
    return builder.bitcast(context.declare_function(builder.module, compiled.fndesc), cgutils.voidptr_t)


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
