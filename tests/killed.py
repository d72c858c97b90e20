"""Commands in processes that are killed at random moments, and what a scripted provider has seen of them."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

from provider_server import account

KILLS = int(os.environ.get("LOCKPROBE_KILLS", "4"))
"""How often a run is killed; ``LOCKPROBE_KILLS=100`` in the environment kills so often."""

# Imports what takes seconds to import once, and makes a process of its own for every command.
FORKS = """
import json, os, sys
import lockprobe.agents.llm.model, lockprobe.cli.run, lockprobe.cli.branch
from lockprobe.cli import main
for line in sys.stdin:
    if not (child := os.fork()):
        sys.argv = json.loads(line)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        main()
    print(child, flush=True)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


def settled(url):
    """The server's account once nothing is on its way."""
    while (seen := account(url))["on_their_way"]:
        time.sleep(0.02)
    return seen


@contextmanager
def commands():
    """Starts ``lockprobe`` in a process of its own, and returns its number and a function that waits for its end."""
    command = [sys.executable, "-c", FORKS]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as forks:

        def start(asked):
            print(json.dumps(["lockprobe", *map(str, asked)]), file=forks.stdin, flush=True)
            return int(forks.stdout.readline()), lambda: int(forks.stdout.readline())

        yield start
        forks.stdin.close()


def size(path):
    return path.stat().st_size if path.exists() else 0


def ended(start, calls, luck, by=signal.SIGKILL):
    """The exit status of a run that gets a signal some moments after its first call; ``calls`` is the file of calls."""
    before, began = size(calls), time.monotonic()
    process, status = start()
    while size(calls) == before and time.monotonic() - began < 60:
        time.sleep(0.002)
    time.sleep(luck.uniform(0, 0.6))
    os.kill(process, by)  # still there, if only as what its parent has to ask after
    return status()
