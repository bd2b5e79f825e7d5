"""The oracle of proofs: the same claims in ball arithmetic of 200 bits (python-flint), with laws of its own."""
