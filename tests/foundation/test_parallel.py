"""Work on several processes; Ctrl-C interrupts a wait of the main thread, and ends processes that help without a word."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from lockprobe.foundation.errors import Missing
from lockprobe.foundation.interrupts import interruptible
from lockprobe.foundation.workers import THIS_PROCESS, Processes


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


def test_results_come_in_the_order_of_the_jobs():
    assert list(THIS_PROCESS.map(abs, [-3, 1, -2])) == [3, 1, 2]
    assert list(Processes(2).map(abs, [-3, 1, -2])) == [3, 1, 2]


def test_a_dead_process_is_one_line():
    with pytest.raises(Missing, match="a worker process died before its work was done: is there memory enough for 2"):
        list(Processes(2).map(os._exit, [9]))
