"""The version of camopt; pyproject.toml reads it from here."""

VERSION = "0.2.0"
__version__ = VERSION
SITE = ""
"""Address of the documentation, for links in the schema of scenes; empty while there is no site."""


def camopt_and_kernel_version() -> str:
    """Version of camopt and of its kernels. Equal versions give equal results for the same scene."""
    # imported only here: hashlib loads OpenSSL, which takes long
    from camopt.core.kernels.version import version_of_kernels

    return f"{VERSION} {version_of_kernels()}"
