"""The processor of this machine, on which the last digits of a local model's numbers depend."""

from __future__ import annotations

import platform
from contextlib import suppress
from functools import cache
from pathlib import Path

_LONGEST = 120


@cache
def cpu_model() -> str:
    """The model of the processor in the manufacturer's words, at most 120 characters; else its architecture."""
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text("utf-8", "replace").splitlines():
            name, _, value = line.partition(":")
            if name.strip() in ("model name", "Model", "cpu model") and value.strip():
                return value.strip()[:_LONGEST]
    return (platform.processor() or platform.machine())[:_LONGEST]
