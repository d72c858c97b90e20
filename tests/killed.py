"""Commands in processes that are killed at random moments, and what a scripted provider has seen of them."""

import os
import signal
import sqlite3
import subprocess
import time
from contextlib import closing, suppress

import forked
from provider_server import account

from lockprobe.studies.records.store import STORE

KILLS = int(os.environ.get("LOCKPROBE_KILLS", "3"))
"""How often a run is killed; ``LOCKPROBE_KILLS=100`` in the environment kills so often."""

MOMENTS = 0.3
"""Within so many seconds from its first call a run is killed: that is several replies on each connection."""

MODEL = "import lockprobe.agents.llm.model"
"""What takes long and is the same for every command that asks a model."""


def start(*asked):
    """Starts ``lockprobe`` in a process of its own, which says nothing."""
    return forked.start(asked, first=MODEL, stdout=subprocess.DEVNULL)


def settled(url):
    """The server's account once nothing is on its way."""
    while (seen := account(url))["on_their_way"]:
        time.sleep(0.02)
    return seen


def replies(directory):
    """How many replies are stored in a directory, by whatever is writing there now."""
    with suppress(sqlite3.Error), closing(sqlite3.connect(f"file:{directory / STORE}?mode=ro", uri=True)) as db:
        return db.execute("select count(answer ->> 'reply') from call").fetchone()[0]
    return 0


def ended(start, directory, luck, by=signal.SIGKILL):
    """The exit status of a run in a directory that gets a signal some moments after its first reply."""
    process = begun(start, directory)
    time.sleep(luck.uniform(0, MOMENTS))
    process.send_signal(by)
    return process.wait()


def begun(start, directory):
    """A run in a directory that has its first reply."""
    before, began = replies(directory), time.monotonic()
    process = start()
    while replies(directory) <= before and process.poll() is None and time.monotonic() - began < 60:
        time.sleep(0.005)
    return process
