"""Figures are drawn under Lockprobe's settings alone, so that they are the same bytes on every machine.

Matplotlib reads a user's ``matplotlibrc`` and the variable ``MPLBACKEND`` when it is imported. Neither may change or
prevent a figure; both stay as they are for the user's own figures in the same process.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import Any

from lockprobe.foundation.errors import BadFile

INK, FAINT = "#222222", "#666666"

SMALL = 9.0
"""Size of all text, in points."""

_STYLE: dict[str, Any] = {
    "svg.hashsalt": "lockprobe",  # equal figures give equal bytes
    "pdf.fonttype": 42,  # TrueType, which publishers take; the usual Type 3 many do not
    "font.size": SMALL,
    "text.color": INK,
    "axes.titlesize": SMALL,
    "axes.titley": 1.0,  # else Matplotlib looks for ticks above the axes, of which there are none, four times a figure
    "axes.labelcolor": INK,
    "axes.edgecolor": "#888888",
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
}
"""What figures look like, beyond Matplotlib's defaults. Ticks, which Matplotlib makes late, are styled by ``sheet``."""

_BACKEND = "MPLBACKEND"


def _import_matplotlib() -> ModuleType:
    """Matplotlib, also where a notebook names a backend that is not installed here: figures need none.

    Raises:
        BadFile: If the user's ``matplotlibrc`` cannot be read.
    """
    backend = os.environ.pop(_BACKEND, None)
    try:
        import matplotlib as mpl
    except (OSError, UnicodeError) as error:
        raise BadFile("matplotlibrc", f"Matplotlib, which draws the figures, cannot read it ({error})") from error
    finally:
        if backend is not None:
            os.environ[_BACKEND] = backend
    if backend:
        with suppress(ValueError):
            mpl.rcParams["backend"] = backend  # as Matplotlib does itself
    return mpl


_MPL = _import_matplotlib()


@contextmanager
def own_settings() -> Iterator[None]:
    """A context, or a decorator of a function, in which Matplotlib has our settings instead of the user's."""
    with _MPL.rc_context():
        _MPL.rcdefaults()
        _MPL.rcParams.update(_STYLE)
        yield
