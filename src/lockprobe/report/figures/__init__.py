"""Figures are drawn under Lockprobe's settings alone, so that they are the same bytes on every machine.

Matplotlib reads a file of settings and the variable ``MPLBACKEND`` when it is imported, which is here. For us it reads
our own file: a user's can neither change nor prevent a figure, and need not be readable.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import chdir, contextmanager, suppress
from pathlib import Path

SMALL = 9.0
"""Size of all text, in points."""

DPI = 200
"""Pixels per inch of PNG files, and of what is measured."""

_STYLE = Path(__file__).with_name("lockprobe.mplstyle")

_USERS = {name: os.environ.pop(name, None) for name in ("MATPLOTLIBRC", "MPLBACKEND")}
os.environ["MATPLOTLIBRC"] = str(_STYLE)
try:
    with chdir(_STYLE.parent):  # a file of the working directory would count before that
        import matplotlib as mpl
finally:
    del os.environ["MATPLOTLIBRC"]
    os.environ.update({name: value for name, value in _USERS.items() if value is not None})
if _USERS["MPLBACKEND"]:
    with suppress(ValueError):  # what a user plots beside us is shown where they say, as in a notebook
        mpl.rcParams["backend"] = _USERS["MPLBACKEND"]


@contextmanager
def own_settings() -> Iterator[None]:
    """A context, or a decorator of a function, in which Matplotlib has our settings instead of the user's."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rc_file(_STYLE, use_default_template=False)
        yield
