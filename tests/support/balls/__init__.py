"""The oracle of proofs: the same constraints in 200-bit ball arithmetic (python-flint), with its own laws.

Formulas of camopt take balls as soon as any module of this folder is imported.
"""

from support.balls import point_contact, profile  # noqa: F401  these register what formulas do to balls
