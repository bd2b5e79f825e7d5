"""Verdicts: whether designs hold their limits at every cam angle, in double precision and in intervals."""
