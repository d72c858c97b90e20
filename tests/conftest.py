"""Tests say the same whoever starts them."""

import os
import signal

# Advice for a missing package is that for pip, also under ``uv run``.
os.environ.pop("UV_RUN_RECURSION_DEPTH", None)

# A job in the background ignores Ctrl-C, and so would the commands that tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
