"""How functions become machine code: marks for them, and what numba is told of them.

``compile`` has the marks, ``by_address`` the calls from one kernel to another. Only ``dispatchers`` and
``numba_types`` import numba, and ``compile`` imports them when the first kernel is compiled.
"""
