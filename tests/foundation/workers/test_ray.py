"""A real Ray cluster on this machine: three nodes, of which one is killed while trials are played."""

import os
import signal
from importlib.util import find_spec

import pytest
from loopback_cluster import loopback_cluster
from stored import records, timings

from lockprobe.foundation.workers import Cluster
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.observer import Observer
from lockprobe.studies.running.runner import Limits, run
from lockprobe.trial.trial_json import trial_to_json

pytestmark = pytest.mark.skipif(find_spec("ray") is None, reason="ray is not installed")  # importing it comes later


class Killer(Observer):
    """Kills a process group after some trials."""

    def __init__(self, process, after):
        self.process, self.left = process, after

    def trial(self, trial, timing):
        self.left -= 1
        if self.left == 0:
            os.killpg(self.process.pid, signal.SIGKILL)


def lines(directory):
    return sorted(trial_to_json(trial) for trial in load(directory))


def test_a_study_on_three_nodes_is_the_study_of_one_process(tmp_path):
    planned = study("flips", agent=["human-inspired", "random"], p=[0, 0.4], trials=150, repetitions=1)
    with Journal.open(tmp_path / "here", planned) as journal:
        run(planned, journal)
    with (
        loopback_cluster(nodes=2) as loopback,
        Cluster.connect(loopback.address) as cluster,
        Journal.open(tmp_path / "there", planned) as journal,
    ):
        run(planned, journal, limits=Limits(cluster=cluster), observer=Killer(loopback.nodes[0], 5))
        assert list(cluster.map(abs, [-2, 1])) == [2, 1]
    assert lines(tmp_path / "there") == lines(tmp_path / "here")
    assert len(records(tmp_path / "there")) == planned.size
    assert {timing.cpu for timing in timings(tmp_path / "there")} == {
        timing.cpu for timing in timings(tmp_path / "here")
    }
