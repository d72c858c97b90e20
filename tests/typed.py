"""A command as typed, in a process of its own."""

import subprocess
import sys


def typed(*arguments, **settings):
    """Runs ``lockprobe`` to its end; settings are those of ``subprocess.run``."""
    command = [sys.executable, "-m", "lockprobe", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **settings)
