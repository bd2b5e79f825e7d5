"""Benchmarks are the functions ``bench_*`` of the files ``bench_*.py``; they run only when asked for."""

import compiled  # noqa: F401
import pytest


def pytest_configure(config: pytest.Config) -> None:
    """Collect this folder's files, whatever the names of the tests elsewhere."""
    config.addinivalue_line("python_files", "bench_*.py")
    config.addinivalue_line("python_functions", "bench_*")
