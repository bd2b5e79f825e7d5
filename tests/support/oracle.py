"""Whether the tests of the oracle (``naive``) have passed for what it is now, by a digest beside its data.

    python -m pytest -m "" tests/whole/test_naive.py && python tests/support/oracle.py

After a change of naive.py or of its data they run with all others, until they have passed and the digest is
renewed.
"""

from hashlib import sha256
from pathlib import Path

SUPPORT = Path(__file__).parent
TESTS = SUPPORT.parent
DIGEST = TESTS / "data" / "oracle.sha256"


def digest() -> str:
    """The digest of the oracle and of all its data."""
    files = [SUPPORT / "naive.py", TESTS / "whole" / "test_naive.py", *sorted((TESTS / "data").glob("*.json"))]
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def tests_have_passed() -> bool:
    """Whether the tests have passed since the last change."""
    return DIGEST.exists() and DIGEST.read_text(encoding="utf-8").strip() == digest()


if __name__ == "__main__":
    DIGEST.write_text(digest() + "\n", encoding="utf-8")
