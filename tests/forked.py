"""``lockprobe`` in a process of its own that has imported everything before it was asked.

A fresh interpreter spends two to five seconds on imports, so Python's fork server imports once, and forks for every
command. Streams, directory, environment, signals and exit status are those of any process. What is imported, and when,
is not tested this way but in a fresh interpreter.
"""

import multiprocessing
import os
import runpy
import signal
import subprocess
import sys
import tempfile
from functools import cache
from multiprocessing import forkserver
from multiprocessing.reduction import DupFd
from pathlib import Path
from types import ModuleType

import pytest


def run(arguments, *, timeout=600, **settings):
    """Runs ``lockprobe``, or the text of a script, to its end, as ``subprocess.run`` does it with text."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        process = start(arguments, stdin=subprocess.DEVNULL, stdout=out, stderr=err, **settings)
        try:
            status = process.wait(timeout)
        finally:
            process.kill()
        for file in (out, err):
            file.seek(0)
        return subprocess.CompletedProcess(arguments, status, out.read(), err.read())


def start(arguments, *, script="", stdin=None, stdout=None, stderr=None, cwd=None, env=None, start_new_session=False):
    """Starts ``lockprobe``, or the text of a script, as ``subprocess.Popen`` does it with text."""
    argv = ["-c" if script else "lockprobe", *map(str, arguments)]
    environment = dict(os.environ if env is None else env)
    return Forked((argv, script, cwd or Path.cwd(), environment, start_new_session), (stdin, stdout, stderr))


@cache
def _server():
    """Where processes are forked; what it imports it finds where this process would."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["pytest", "forked", "preloaded"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
        forkserver.ensure_running()
    return context


class _Stream:
    """A file descriptor on its way to another process."""

    def __init__(self, number):
        self.number = number

    def __reduce__(self):
        return _received, (DupFd(self.number),)


def _received(sent):
    return sent.detach()


class Forked:
    """A forked command, with what tests use of ``subprocess.Popen``."""

    def __init__(self, asked, streams):
        ours, theirs = zip(*(_ends(stream, of) for of, stream in enumerate(streams)), strict=True)
        _, self.stdout, self.stderr = ours
        self._process = _server().Process(target=_becomes, args=(*asked, *map(_Stream, theirs)), daemon=True)
        self._process.start()
        for number, stream in zip(theirs, streams, strict=True):
            if stream in (subprocess.PIPE, subprocess.DEVNULL):
                os.close(number)

    def poll(self):
        return self._process.exitcode

    def wait(self, timeout=None):
        self._process.join(timeout)
        assert self.poll() is not None, f"it has not ended within {timeout} s"
        return self.poll()

    def communicate(self, timeout=None):
        """What it says from now on; no more than fits into a pipe."""
        self.wait(timeout)
        said = []
        for stream in (self.stdout, self.stderr):
            said.append(stream and stream.read())
            if stream:
                stream.close()
        return tuple(said)

    def send_signal(self, number):
        if self.poll() is None:
            os.kill(self._process.pid, number)

    def kill(self):
        self.send_signal(signal.SIGKILL)


def _ends(stream, of):
    """Our end of a stream, if there is one, and the file descriptor of the command."""
    if stream is subprocess.PIPE:
        assert of, "nothing is written to a command"
        ours, theirs = os.pipe()
        return os.fdopen(ours, encoding="utf-8"), theirs
    if stream is subprocess.DEVNULL:
        return None, os.open(os.devnull, os.O_RDWR)
    if stream is None:
        return None, of
    return None, stream if isinstance(stream, int) else stream.fileno()


def _becomes(argv, script, cwd, environment, session, *streams):
    """Makes this process as it would be if it had been started so, and runs."""
    multiprocessing.current_process().daemon = False  # it may start processes
    if session:
        os.setsid()
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    sys.stdin, sys.stdout, sys.stderr = sys.__stdin__, sys.__stdout__, sys.__stderr__ = (
        os.fdopen(0, encoding="utf-8", closefd=False),
        os.fdopen(1, "w", 1 if os.isatty(1) else -1, encoding="utf-8", closefd=False),
        os.fdopen(2, "w", 1, encoding="utf-8", errors="backslashreplace", closefd=False),
    )
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(environment)
    more = environment.get("PYTHONPATH", "").split(os.pathsep)
    sys.path[:] = [str(Path.cwd()), *filter(None, (*more, *sys.path))]
    sys.argv = argv
    if script:
        main = sys.modules["__main__"] = ModuleType("__main__")
        exec(compile(script, "<string>", "exec"), vars(main))
    else:
        runpy.run_module("lockprobe", run_name="__main__", alter_sys=True)
