"""Processes as workers: a death costs one job, Ctrl-C ends all without a word, and nobody outlives who started them.

Nothing here is measured in seconds: what is waited for is an end of a pipe, which comes or does not.
"""

import os
import signal
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.workers import Lost, Processes, lose, processes


@pytest.fixture(autouse=True)
def time_to_end(monkeypatch):
    """A process of a busy machine is given time to end by itself."""
    monkeypatch.setattr(processes, "_ENDS", 300.0)


INTERRUPTED = """
import os, signal, time
from lockprobe.foundation.workers import Processes

def interrupt_once(job=0):
    try:
        os.close(os.open("interrupted", os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return
    os.kill(os.getpid(), signal.SIGINT)  # first to itself, who could say something before it is ended
    os.killpg(0, signal.SIGINT)

def work(job):
    interrupt_once()
    time.sleep(600)

def begin():
    return work

if __name__ == "__mp_main__" and STARTING:
    interrupt_once()
if __name__ == "__main__":
    try:
        list(Processes(2).each(begin, [1, 2, 3, 4]))
    except KeyboardInterrupt:
        print("stopped", flush=True)
"""


@pytest.mark.parametrize("starting", [False, True], ids=["at work", "while the first process starts"])
def test_ctrl_c_in_a_terminal_ends_all_processes_at_once_and_no_other_one_speaks(starting, tmp_path):
    """A terminal sends it to all of them, also to those that still import modules."""
    (tmp_path / "main.py").write_text(f"STARTING = {starting}{INTERRUPTED}")
    run = subprocess.run(
        [sys.executable, "main.py"], cwd=tmp_path, capture_output=True, text=True, start_new_session=True
    )
    assert (run.stdout, run.stderr) == ("stopped\n", "")


ORPHANS = """
import os, sys, time
from lockprobe.foundation.workers import Processes
def begin():
    os.write(2, b"*")
    return time.sleep
if __name__ == "__main__":
    list(Processes(2).each(begin, [86400, 86400]))
"""


def test_processes_end_with_a_killed_one_that_started_them(tmp_path):
    (tmp_path / "main.py").write_text(ORPHANS)
    with subprocess.Popen([sys.executable, str(tmp_path / "main.py")], stderr=subprocess.PIPE) as run:
        assert run.stderr.read(2) == b"**"
        run.kill()
        assert run.stderr.read() == b""  # it ends when nobody has it open any more


def gives_up(job):
    lose("it hangs in line 8")


def within_a_message(job):
    """A kill that leaves half a message in the pipe."""
    pipe = processes._Here.pipe
    os.write(pipe.fileno(), struct.pack("!i", 1000) + b"half")
    os.kill(os.getpid(), signal.SIGKILL)


def leaves_a_child(job):
    """A child that outlives it keeps everything open that it had open."""
    if child := os.fork():
        Path(os.environ["CHILD"]).write_text(f"{child}")
        os._exit(5)
    while True:
        signal.pause()


FATES = {
    gives_up: Lost("it hangs in line 8", explained=True),
    within_a_message: Lost("a worker process died, exit status -9"),
    leaves_a_child: Lost("a worker process died, exit status 5"),
}


def fated():
    return lambda job: job(job) if callable(job) else -job


def test_a_job_that_ends_its_process_is_lost_alone_and_the_work_goes_on(tmp_path, monkeypatch):
    monkeypatch.setenv("CHILD", str(tmp_path / "child"))
    jobs = [gives_up, within_a_message, 1, leaves_a_child, *range(2, 17)]
    assert dict(Processes(1).each(fated, jobs)) == {job: FATES.get(job) or -job for job in jobs}
    os.kill(int((tmp_path / "child").read_text()), signal.SIGKILL)


def mistaken():
    raise UserMistake("no such model")


def test_a_users_mistake_is_raised_here():
    with pytest.raises(UserMistake, match="no such model"):
        list(Processes(1).each(mistaken, [1, 2]))
