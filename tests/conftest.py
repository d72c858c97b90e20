"""Tests say the same whoever starts them: advice for a missing package is that for pip, also under ``uv run``."""

import os

os.environ.pop("UV_RUN_RECURSION_DEPTH", None)
