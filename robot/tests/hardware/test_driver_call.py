"""Calls into drivers: they return, or there is a fault that says why."""

import threading
import time

import pytest
from lockprobe_robot.hardware.driver_call import DriverThread, call_driver

from lockprobe.foundation.errors import BadValue, PlantFault


def test_what_a_driver_raises_is_a_fault_in_one_line_and_what_lockprobe_raises_stays():
    with pytest.raises(PlantFault, match="^the camera: ZeroDivisionError: division by zero$"):
        call_driver("the camera", lambda: 1 / 0)

    def mistake():
        raise BadValue("x", 1, "2")

    for call in (lambda: call_driver("it", mistake), lambda: DriverThread().call("it", mistake, 5)):
        with pytest.raises(BadValue):
            call()


def test_calls_are_made_in_one_thread_that_keeps_nobody_alive():
    thread = DriverThread()
    first, second = (thread.call("it", threading.current_thread, 5) for _ in range(2))
    assert first is second
    assert first.daemon
    assert first is not threading.current_thread()


def test_a_call_that_hangs_is_given_up_and_none_is_made_after_it():
    thread, release = DriverThread(), threading.Event()
    began = time.monotonic()
    with pytest.raises(PlantFault, match="^the arm: no answer within 0.05 s$"):
        thread.call("the arm", release.wait, 0.05)
    with pytest.raises(PlantFault, match="an earlier call hangs"):
        thread.call("the arm", lambda: 1, 5)
    assert time.monotonic() - began < 2
    release.set()
