"""Load machine code that numba compiled as functions of this process, with llvmlite and without numba.

Importing numba takes half a second; llvmlite takes a tenth of that.
"""

import os
from ctypes import CFUNCTYPE, c_int, c_void_p, create_string_buffer
from functools import cache
from typing import Any, NamedTuple

from llvmlite import binding

from camopt.core.kernels.arguments import argument_c_types, flatten_to_machine_arguments


class ObjectCode(NamedTuple):
    """A kernel as numba compiled it: the name of its function and an object file.

    If it is not ``whole``, it calls functions of numba or reads memory of this process, and cannot be kept on disk.
    """

    name: str
    content: bytes
    whole: bool = True


class MachineCode:
    """A kernel for arguments of some kinds."""

    def __init__(self, kinds: tuple[Any, ...], code: ObjectCode) -> None:
        # each kernel has its own engine, because two kernels may have the same names inside
        machine = _llvm_target().create_target_machine(codemodel="jitdefault", jit=True)
        engine = binding.create_mcjit_compiler(binding.parse_assembly(""), machine)
        engine.add_object_file(binding.ObjectFileRef.from_data(code.content))
        engine.finalize_object()
        self._engine = engine
        self.address: int = self._engine.get_function_address(code.name)
        self._function = CFUNCTYPE(c_int, c_void_p, c_void_p, *argument_c_types(kinds))(self.address)

    def __call__(self, arguments: tuple[Any, ...]) -> None:
        if self._function(RESULT, ERROR, *flatten_to_machine_arguments(arguments)):
            raise RuntimeError("a kernel raised an error")


# memory for the result of a kernel, which is always None, and for its error, which never occurs
RESULT, ERROR = create_string_buffer(8), create_string_buffer(8)


@cache
def _llvm_target() -> Any:
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding.Target.from_default_triple()


@cache
def target_system_cpu_and_features() -> tuple[str, str, str]:
    """Target of the compilation: system, processor and features, the latter two as numba's variables set them."""
    name, features = (os.environ.get(f"NUMBA_CPU_{what}") for what in ("NAME", "FEATURES"))
    return (
        binding.get_process_triple(),
        binding.get_host_cpu_name() if name is None else name,
        binding.get_host_cpu_features().flatten() if features is None else features,
    )
