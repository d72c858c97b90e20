"""A command as typed, in this process."""

import asyncio
import contextlib
import io
import subprocess

import pytest
from typer.testing import CliRunner

from lockprobe.cli import build, main


def in_process(*words, stdin=""):
    """Runs ``lockprobe`` here; a mistake is raised instead of printed."""
    said = [str(word) for word in words]
    done = CliRunner().invoke(build(said[:1]), said, input=stdin)
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


def typed_here(*words):
    """Runs ``lockprobe`` here as typed, without input: exit status, output and errors.

    People's server stops as soon as people could come.
    """

    @contextlib.contextmanager
    def at_once():
        (stopped := asyncio.Event()).set()
        yield stopped

    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2))
    arguments = ["lockprobe", *map(str, words)]
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        patch.setattr("lockprobe.people.web.app.stop_signals", at_once)
        patch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO()))
        patch.setattr("sys.argv", arguments)
        with pytest.raises(SystemExit) as ended:
            main()
    said = (one.buffer.getvalue().decode() for one in (out, err))
    return subprocess.CompletedProcess(arguments, ended.value.code or 0, *said)
