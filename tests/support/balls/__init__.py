"""The oracle of proofs: the same constraints in 200-bit ball arithmetic (python-flint), with its own laws."""
