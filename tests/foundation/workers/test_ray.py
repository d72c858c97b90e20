"""A real Ray cluster on this machine: three nodes, of which one is killed while trials are played."""

import os
import secrets
import signal
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path

import pytest
from stored import records

from lockprobe.foundation.workers import Cluster
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.executor import Observer
from lockprobe.studies.running.runner import Limits, run
from lockprobe.trial.trial_json import trial_to_json

COMMON = ("--block", "--include-log-monitor=false", "--object-store-memory=80000000", "--disable-usage-stats")
RAY = (sys.executable, "-m", "ray.scripts.scripts", "start", *COMMON)


@dataclass
class Loopback:
    """A running cluster.

    Attributes:
        address: Of its head.
        nodes: The processes of ``ray start``, each the leader of its group; the head is not among them.
    """

    address: str
    nodes: list[subprocess.Popen] = field(default_factory=list)

    def add(self):
        """One more node with one processor."""
        node = _started(f"--address={self.address}", "--num-cpus=1")
        self.nodes.append(node)
        return node


@contextmanager
def loopback_cluster(nodes=2):
    """Start a cluster with a token of its own, which this process and its children find in their environment."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    port = port if not 10002 <= port <= 19999 else 20011  # Ray refuses the ports of its workers
    before = {name: os.environ.get(name) for name in ("RAY_AUTH_MODE", "RAY_AUTH_TOKEN")}
    os.environ |= {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    made = Loopback(f"127.0.0.1:{port}")
    head = _started("--head", f"--port={port}", "--num-cpus=0", "--include-dashboard=false")
    try:
        for _ in range(nodes):
            made.add()
        yield made
    finally:
        for process in (*made.nodes, head):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


def _started(*options, seconds=90.0):
    """Starts a node, and waits until it says that it is up: two that start at once take each other's ports."""
    with tempfile.NamedTemporaryFile("w+") as said:
        process = subprocess.Popen(
            [*RAY, *options], start_new_session=True, cwd=Path("/"), stdout=said, stderr=subprocess.STDOUT
        )
        end = time.monotonic() + seconds
        while "will now block" not in (text := Path(said.name).read_text("utf-8")):
            if process.poll() is not None or time.monotonic() > end:
                process.kill()
                raise RuntimeError(f"a node did not start: {text[-2000:]}")
            time.sleep(0.1)
    return process


pytestmark = pytest.mark.skipif(find_spec("ray") is None, reason="ray is not installed")  # importing it comes later


class Killer(Observer):
    """Kills a process group after some trials."""

    def __init__(self, process, after):
        self.process, self.left = process, after

    def trial(self, trial, seconds):
        self.left -= 1
        if self.left == 0:
            os.killpg(self.process.pid, signal.SIGKILL)


def lines(directory):
    return sorted(trial_to_json(trial) for trial in load(directory))


def test_a_study_on_three_nodes_is_the_study_of_one_process(tmp_path):
    planned = study(
        "flips", agent=["human-inspired", "random"], condition=["tremble?p=0.2", "nudge"], trials=150, repetitions=1
    )
    with Journal.open(tmp_path / "here", planned) as journal:
        run(planned, journal)
    with (
        loopback_cluster(nodes=2) as loopback,
        Cluster.connect(loopback.address) as cluster,
        Journal.open(tmp_path / "there", planned) as journal,
    ):
        run(planned, journal, limits=Limits(cluster=cluster), observer=Killer(loopback.nodes[0], 5))
    assert lines(tmp_path / "there") == lines(tmp_path / "here")
    assert len(records(tmp_path / "there")) == planned.size
