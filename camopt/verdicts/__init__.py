"""Proofs in ball arithmetic: whether a design holds its limits at every cam angle, whatever rounding does."""
