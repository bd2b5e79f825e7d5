"""The version, in one place; pyproject.toml reads it from here."""

VERSION = "0.2.0"
__version__ = VERSION
SITE = ""
"""The address of the documentation, to which the schema of scenes has its links lead; none yet."""


def version_of_rows() -> str:
    """The version of camopt and of its kernels: with the same one, the same question has the same answer."""
    from camopt.core.kernels.version import (
        version_of_kernels,
    )  # hashlib is imported only here: OpenSSL takes long to load

    return f"{VERSION} {version_of_kernels()}"
