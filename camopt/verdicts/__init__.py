"""Verdicts: whether designs hold their limits at every cam angle, in double precision and proved in ball arithmetic."""
