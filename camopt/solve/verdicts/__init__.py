"""Verdicts: whether designs hold their limits at every cam angle, in double precision and in intervals.

Read ``limit_verdicts`` first; ``certify`` has the proofs in intervals, ``evaluation`` the result for one design.
"""
