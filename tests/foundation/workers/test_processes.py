"""Processes as workers: a death costs one job, Ctrl-C ends all without a word, and nobody outlives who started them."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from lockprobe.foundation.errors import BadFile, Missing, UserMistake
from lockprobe.foundation.interrupts import interruptible
from lockprobe.foundation.workers import THIS_PROCESS, Lost, Processes, lose, tell


@pytest.fixture
def handler():
    """What handles Ctrl-C around a wait."""

    def handle(number, frame):
        raise AssertionError

    before = signal.signal(signal.SIGINT, handle)
    yield handle
    signal.signal(signal.SIGINT, before)


def test_within_it_a_signal_interrupts(handler):
    with pytest.raises(KeyboardInterrupt), interruptible():
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is handler


def test_another_thread_changes_nothing(handler):
    def seen():
        with interruptible():
            return signal.getsignal(signal.SIGINT)

    with ThreadPoolExecutor(1) as thread:
        assert thread.submit(seen).result() is handler


STARTING = """
import os, signal, time
from lockprobe.foundation.workers import Processes
if __name__ == "__main__":
    try:
        if not BEGUN:
            print("begun", flush=True)
        for _ in Processes(2).map(time.sleep, [0 if BEGUN else 30, 30, 30, 30]):
            print("begun", flush=True)
    except KeyboardInterrupt:
        print("stopped", flush=True)
"""


@pytest.mark.parametrize("begun", [True, False], ids=["at work", "while processes start"])
def test_ctrl_c_in_a_terminal_ends_all_processes_at_once_and_no_other_one_speaks(begun, tmp_path):
    """A terminal sends it to all of them, also to those that still import modules."""
    (tmp_path / "starting.py").write_text(f"BEGUN = {begun}{STARTING}")
    command = [sys.executable, str(tmp_path / "starting.py")]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as run:
        assert run.stdout.readline() == "begun\n"
        time.sleep(0 if begun else 0.2)
        os.killpg(run.pid, signal.SIGINT)
        said, complained = run.communicate(timeout=20)
    assert (said, complained) == ("stopped\n", "")


def test_ctrl_c_stays_held_back_from_the_first_process_that_starts():
    held = (
        "import multiprocessing, signal; from lockprobe.foundation.interrupts import held_back\n"
        "with held_back():\n"
        "    multiprocessing.get_context('spawn').Process(target=int).start()\n"
        "    print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))"
    )
    assert subprocess.run([sys.executable, "-c", held], capture_output=True, text=True).stdout == "True\n"


def test_results_come_in_the_order_of_the_jobs():
    assert list(THIS_PROCESS.map(abs, [-3, 1, -2])) == [3, 1, 2]
    assert list(Processes(2).map(abs, [-3, 1, -2])) == [3, 1, 2]


def test_a_dead_process_is_one_line():
    with pytest.raises(
        Missing, match="before its work was done .a worker process died, exit status 9.: is there memory"
    ):
        list(Processes(2).map(os._exit, [9]))


def deadly():
    """Jobs of which 7 kills its process, 8 gives itself up, and every one says its number."""

    def work(job):
        tell(job)
        if job == 7:
            os._exit(3)
        if job == 8:
            lose("it hangs in line 8")
        return -job

    return work


def test_a_job_that_kills_its_process_is_lost_alone_and_says_why_if_it_can():
    heard = []
    found = dict(Processes(2).each(deadly, range(30), heard.append))
    assert found.pop(7) == Lost("a worker process died, exit status 3")
    assert found.pop(8) == Lost("it hangs in line 8", explained=True)
    assert found == {job: -job for job in range(30) if job not in (7, 8)}
    assert set(heard) == set(range(30))


def mistaken():
    raise UserMistake("no such model")


def mistaken_job():
    def work(job):
        raise BadFile("here", "is full")

    return work


@pytest.mark.parametrize(("begin", "said"), [(mistaken, "no such model"), (mistaken_job, "here: is full")])
def test_a_users_mistake_is_raised_here(begin, said):
    with pytest.raises(UserMistake, match=said):
        list(Processes(1).each(begin, [1, 2]))


def dying():
    os._exit(4)


def test_processes_that_keep_dying_end_the_work():
    with pytest.raises(Missing, match=r"lost 3 times in a row.*exit status 4.*enough for 2\? try --workers 1"):
        list(Processes(2).each(dying, range(9)))


ORPHANS = """
import os, time
from lockprobe.foundation.workers import Processes
def begin():
    print(os.getpid(), flush=True)
    return time.sleep
if __name__ == "__main__":
    list(Processes(2).each(begin, [600, 600]))
"""


def test_processes_end_with_a_killed_one_that_started_them(tmp_path):
    (tmp_path / "orphans.py").write_text(ORPHANS)
    with subprocess.Popen([sys.executable, str(tmp_path / "orphans.py")], stderr=subprocess.PIPE, text=True) as run:
        pids = [int(run.stderr.readline()) for _ in range(2)]
        run.kill()
    end = time.monotonic() + 10
    while time.monotonic() < end and any(map(_runs, pids)):
        time.sleep(0.05)
    assert not any(map(_runs, pids))


def _runs(pid):
    try:
        return "zombie" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
