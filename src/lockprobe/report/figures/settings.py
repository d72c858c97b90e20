"""Figures are drawn under Lockprobe's settings alone, so that they are the same bytes on every machine.

Matplotlib reads a user's ``matplotlibrc`` and the variable ``MPLBACKEND`` when it is imported. Neither may change or
prevent a figure; both stay as they are for the user's own figures in the same process.
"""

from __future__ import annotations

import io
import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec, module_from_spec
from pathlib import Path
from types import ModuleType

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import read_input

INK, FAINT = "#222222", "#666666"

SMALL = 9.0
"""Size of all text, in points."""

DPI = 200
"""Pixels per inch of PNG files, and of what is measured."""

_STYLE = Path(__file__).with_name("lockprobe.mplstyle")

_NAME, _BACKEND = "matplotlib", "MPLBACKEND"

_LARGEST = 1 << 20
"""Bytes of a file of settings; Matplotlib's own has 45 000."""


def _readable(name: str, encoding: str) -> io.StringIO:
    """A file of settings that Matplotlib opens when it is imported; empty for a pipe and for what is no text."""
    try:
        return io.StringIO(read_input(Path(name), _LARGEST).decode(encoding))
    except (BadFile, UnicodeError):
        return io.StringIO()


def _import_matplotlib() -> ModuleType:
    """Matplotlib, with the user's settings as far as they can be read, and also where a backend is not installed here.

    Its warnings of the user's settings are left out: figures have ours.
    """
    if _NAME in sys.modules:
        return sys.modules[_NAME]
    spec = find_spec(_NAME)
    if spec is None or spec.loader is None:
        raise ModuleNotFoundError(_NAME)
    made, log, backend = module_from_spec(spec), logging.getLogger(_NAME), os.environ.pop(_BACKEND, None)
    level, sys.modules[_NAME] = log.level, made
    vars(made)["open"] = _readable  # in place of the function that waits for a pipe
    log.setLevel(logging.CRITICAL)
    try:
        spec.loader.exec_module(made)
    finally:
        if backend is not None:
            os.environ[_BACKEND] = backend
        log.setLevel(level)
        del sys.modules[_NAME], vars(made)["open"]
    sys.modules[_NAME] = made
    if backend:
        with suppress(ValueError):
            made.rcParams["backend"] = backend  # as Matplotlib does itself
    return made


_MPL = _import_matplotlib()


@contextmanager
def own_settings() -> Iterator[None]:
    """A context, or a decorator of a function, in which Matplotlib has our settings instead of the user's."""
    with _MPL.rc_context():
        _MPL.rcdefaults()
        _MPL.rc_file(_STYLE, use_default_template=False)
        yield
