"""Commands in processes that are killed at random moments, and what a scripted provider has seen of them."""

import os
import signal
import subprocess
import time

import forked
from provider_server import account

KILLS = int(os.environ.get("LOCKPROBE_KILLS", "3"))
"""How often a run is killed; ``LOCKPROBE_KILLS=100`` in the environment kills so often."""

MOMENTS = 0.3
"""Within so many seconds from its first call a run is killed: that is several replies on each connection."""

MODEL = """
import lockprobe.agents.llm.model
from inspect_ai.model import get_model_info
get_model_info("fake/model")  # reads the table of all models
"""
"""What takes seconds and is the same for every command that asks a model."""


def start(*asked):
    """Starts ``lockprobe`` in a process of its own, which says nothing."""
    return forked.start(asked, first=MODEL, stdout=subprocess.DEVNULL)


def settled(url):
    """The server's account once nothing is on its way."""
    while (seen := account(url))["on_their_way"]:
        time.sleep(0.02)
    return seen


def size(path):
    return path.stat().st_size if path.exists() else 0


def ended(start, calls, luck, by=signal.SIGKILL):
    """The exit status of a run that gets a signal some moments after its first call; ``calls`` is the file of calls."""
    before, began = size(calls), time.monotonic()
    process = start()
    while size(calls) == before and time.monotonic() - began < 60:
        time.sleep(0.002)
    time.sleep(luck.uniform(0, MOMENTS))
    process.send_signal(by)
    return process.wait()
