"""Programs of benchmarks/ as modules, for tests of what they measure."""

from importlib import import_module
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


def benchmark(name):
    """The module of a program; it finds the modules beside it, as when it runs."""
    with pytest.MonkeyPatch.context() as patched:
        patched.syspath_prepend(BENCHMARKS)
        return import_module(name)
