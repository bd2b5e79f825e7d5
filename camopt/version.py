"""The version, in one place; pyproject.toml reads it from here."""

VERSION = "0.2.0"
SITE = ""
"""The address of the documentation, to which the schema of scenes has its links lead; none yet."""
