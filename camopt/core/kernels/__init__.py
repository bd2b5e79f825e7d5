"""Kernels: functions that are compiled to machine code by numba, and kept on disk.

Read ``compile`` first: it decides when a kernel is compiled. ``marks`` has the decorators, ``address_calls`` the
calls from one kernel to another, ``kernel_cache`` the files. ``machine_code`` runs machine code from disk, with
``arguments``, without numba. Only ``dispatchers`` and ``numba_types`` import numba; ``compile`` imports them when a
kernel must be compiled.
"""
