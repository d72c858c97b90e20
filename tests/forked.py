"""``lockprobe`` in a process of its own that has imported everything before it was asked.

A fresh interpreter spends two to five seconds on imports, and hundreds of commands are typed in tests. So one
interpreter imports once for all workers. It forks for each worker, and that fork forks for every command. Streams,
directory, environment, signals and exit status are those of any process. What is imported, and when, is not tested
this way but in a fresh interpreter.
"""

import atexit
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
import warnings
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path

AT_START = ("PYTHON", "LC_", "LANG")
"""Variables that an interpreter reads when it starts: with others than ours, it has to be a fresh one."""


def run(arguments, *, timeout=600, **settings):
    """Runs ``lockprobe``, or the text of a script, to its end, as ``subprocess.run`` does it with text."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        process = start(arguments, stdin=subprocess.DEVNULL, stdout=out, stderr=err, **settings)
        try:
            status = process.wait(timeout)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        for file in (out, err):
            file.seek(0)
        return subprocess.CompletedProcess(process.args, status, out.read(), err.read())


def start(
    arguments, *, script="", first="", stdin=None, stdout=None, stderr=None, cwd=None, env=None, start_new_session=False
):
    """Starts ``lockprobe``, or the text of a script, as ``subprocess.Popen`` does it with text.

    ``first`` is the text of what the interpreter that forks does once before: an import that few commands need.
    """
    arguments, env = list(map(str, arguments)), dict(os.environ if env is None else env)
    if _read_at_start(env) != OURS:
        what = ["-c", script] if script else ["-m", "lockprobe"]
        return subprocess.Popen(
            [sys.executable, *what, *arguments], stdin=stdin, stdout=stdout, stderr=stderr, cwd=cwd, env=env,
            start_new_session=start_new_session, text=True,
        )  # fmt: skip
    cwd = str(Path(cwd or "").absolute())
    asked = {"arguments": arguments, "script": script, "cwd": cwd, "env": env, "session": start_new_session}
    asked["first"] = first
    return Forked(_stem(), asked, (stdin, stdout, stderr))


def _read_at_start(env):
    return {name: value for name, value in env.items() if name.startswith(AT_START) and name != "PYTHONPATH"}


OURS = _read_at_start(os.environ)


class Forked:
    """A forked command, with what tests use of ``subprocess.Popen``."""

    def __init__(self, stem, asked, streams):
        self.args = ["lockprobe", *asked["arguments"]]
        self.returncode = None
        self.stdin = None
        ours, theirs = zip(*(_ends(stream, of) for of, stream in enumerate(streams)), strict=True)
        self.stdout, self.stderr = ours[1:]
        self._status, told = os.pipe()
        line = json.dumps(asked).encode()
        socket.send_fds(stem, [len(line).to_bytes(4, "big")], [*theirs, told])
        stem.sendall(line)
        for fd, stream in zip((*theirs, told), (*streams, subprocess.PIPE), strict=True):
            if stream in (subprocess.PIPE, subprocess.DEVNULL):
                os.close(fd)
        self.pid = int(self._line())

    def _line(self):
        said = b""
        while not said.endswith(b"\n"):
            part = os.read(self._status, 1)
            assert part, "the interpreter that forks has died"
            said += part
        return said

    def poll(self):
        with suppress(subprocess.TimeoutExpired):
            self.wait(0)
        return self.returncode

    def wait(self, timeout=None):
        if self.returncode is None:
            if not select.select([self._status], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(self.args, timeout)
            self.returncode = int(self._line())
            os.close(self._status)
        return self.returncode

    def communicate(self, timeout=None):
        """What it says from now on; no more than fits into a pipe."""
        self.wait(timeout)
        said = tuple(stream and stream.read() for stream in (self.stdout, self.stderr))
        self.__exit__()
        return said

    def send_signal(self, number):
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self):
        self.send_signal(signal.SIGKILL)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for stream in (self.stdout, self.stderr):
            if stream:
                stream.close()
        self.wait()


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


SHARED = "LOCKPROBE_TESTS_FORK_AT"
"""The variable that tells workers the socket of the interpreter that imports for all of them."""


def share():
    """Starts the interpreter that imports; every process started from now on that asks for a command shares it."""
    folder = tempfile.TemporaryDirectory()
    os.environ[SHARED] = at = str(Path(folder.name, "socket"))
    listening = socket.socket(socket.AF_UNIX)
    listening.bind(at)
    listening.listen()
    living, ours = socket.socketpair()
    numbers = [listening.fileno(), living.fileno()]
    process = subprocess.Popen(
        [sys.executable, __file__, *map(str, numbers)], pass_fds=numbers, stdin=subprocess.DEVNULL
    )
    listening.close()
    living.close()

    @atexit.register
    def end():
        ours.close()
        process.wait()
        folder.cleanup()


@cache
def _stem():
    """A socket to the interpreter that forks for this process."""
    if SHARED not in os.environ:
        share()
    stem = socket.socket(socket.AF_UNIX)
    stem.connect(os.environ[SHARED])
    atexit.register(stem.close)
    return stem


IMPORTED = (
    "agents.catalogue", "simulation.power", "cli.list_", "cli.box", "cli.loops", "cli.run_study",
    "cli.export", "cli.import_", "cli.doctor", "cli.play", "cli.power", "cli.replay", "cli.report", "cli.run",
    "cli.serve", "cli.status", "people.web.app", "report.figures.drawing",
    "report.page", "studies.running.runner",
)  # fmt: skip


OF_REPORTS = ("jinja2.runtime", "matplotlib.backends.backend_svg", "scipy.stats")
"""What a report imports when it comes to it: half a second of every command that writes one."""


def _stem_of(listening, living):
    """A worker's socket, in a fork for this worker; nothing where the tests have ended."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while listening in select.select([listening, living], [], [])[0]:
        worker, _ = listening.accept()
        if not _forks():
            listening.close()
            living.close()
            return worker
        worker.close()
    return None


def _asked_of(stem):
    """What is asked of this process, which is a fork; nothing where nobody asks any more."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    done = {""}
    while True:
        size, streams, *_ = socket.recv_fds(stem, 4, 4)
        if not size:
            return None
        asked = b""
        while len(asked) < int.from_bytes(size, "big"):
            asked += stem.recv(1 << 20)
        asked = json.loads(asked)
        if asked["first"] not in done:
            done.add(asked["first"])
            exec(asked["first"], {})
        if not _forks():
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            *streams, told = streams
            if not (child := _forks()):
                stem.close()
                os.close(told)
                return asked, streams
            for number in streams:
                os.close(number)
            os.write(told, b"%d\n" % child)
            status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            with suppress(BrokenPipeError):
                os.write(told, b"%d\n" % status)
            os._exit(0)
        for number in streams:
            os.close(number)


def _forks():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads: those of libraries wait and hold no lock
        return os.fork()


def _becomes(asked, streams):
    """Makes this process as it would be if it had been started so."""
    if asked["session"]:
        os.setsid()
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    sys.stdin, sys.stdout, sys.stderr = sys.__stdin__, sys.__stdout__, sys.__stderr__ = (
        os.fdopen(0, encoding=sys.stdin.encoding, closefd=False),
        os.fdopen(1, "w", 1 if os.isatty(1) else -1, encoding=sys.stdout.encoding, closefd=False),
        os.fdopen(2, "w", 1, encoding=sys.stderr.encoding, errors="backslashreplace", closefd=False),
    )
    os.chdir(asked["cwd"])
    os.environ.clear()
    os.environ.update(asked["env"])
    if hasattr(time, "tzset"):
        time.tzset()
    sys.argv = ["-c" if asked["script"] else "lockprobe", *asked["arguments"]]
    more = [path for path in asked["env"].get("PYTHONPATH", "").split(os.pathsep) if path and path not in sys.path]
    sys.path[:1] = [asked["cwd"], *more]


if __name__ == "__main__":
    import gc
    import runpy

    for name in IMPORTED:
        with suppress(ImportError):
            import_module(f"lockprobe.{name}")
    for name in OF_REPORTS:
        import_module(name)
    with suppress(ImportError):  # how many trials are judged is no matter of commands
        import_module("lockprobe.report.questions").all_sections()
        import_module("lockprobe.statistics.rationality").JUDGED = 8
    gc.freeze()
    stem = _stem_of(*(socket.socket(fileno=int(number)) for number in sys.argv[1:]))
    if stem and (found := _asked_of(stem)):
        _becomes(*found)
        if text := found[0]["script"]:
            exec(compile(text, "<string>", "exec"), {"__name__": "__main__"})
        else:
            runpy.run_module("lockprobe", run_name="__main__", alter_sys=True)
