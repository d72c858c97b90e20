"""Ctrl-C interrupts a wait of the main thread, and means afterwards what it meant before."""

import signal
from concurrent.futures import ThreadPoolExecutor

import pytest

from lockprobe.foundation.interrupts import interruptible


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
