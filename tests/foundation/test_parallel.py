"""The same work on many jobs."""

import os

import pytest

from lockprobe.foundation.errors import Missing
from lockprobe.foundation.parallel import THIS_PROCESS, Processes


def test_results_come_in_the_order_of_the_jobs():
    assert list(THIS_PROCESS.map(abs, [-3, 1, -2])) == [3, 1, 2]
    assert list(Processes(2).map(abs, [-3, 1, -2])) == [3, 1, 2]


def test_a_dead_process_is_one_line():
    with pytest.raises(Missing, match="a worker process died before its work was done: is there memory enough for 2"):
        list(Processes(2).map(os._exit, [9]))
