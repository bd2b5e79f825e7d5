"""How functions become machine code: marks for them, and their registration with numba.

``compile`` has the marks, ``address_calls`` the calls from one kernel to another, ``kernel_cache`` the files.
Machine code that is on disk is run by ``machine_code`` with ``arguments``, without numba: only ``dispatchers`` and
``numba_types`` import it, and ``compile`` imports them when a kernel is to be compiled.
"""
