"""``--cluster`` as it is typed."""

from contextlib import contextmanager

import pytest

from lockprobe.foundation.workers import Cluster


class Here:
    """A cluster that is this process."""

    nodes = (("head", 0), ("one\x1b", 2))

    def processors(self):
        return 2

    def each(self, begin, jobs, *, at_once):
        work = begin()
        return ((job, work(job)) for job in jobs)

    def map(self, work, jobs):
        return map(work, jobs)


@pytest.fixture
def connected(monkeypatch):
    """The addresses to which commands connect."""
    found = []

    @contextmanager
    def connect(address):
        found.append(address)
        yield Here()

    monkeypatch.setattr(Cluster, "connect", connect)
    return found


RUN = ("run", "flips", "--agent", "human-inspired", "--p", "0,0.4", "--trials", "2", "--no-report", "--out")


def test_a_study_is_played_on_it(lockprobe, connected, tmp_path):
    status, _, told = lockprobe(*RUN, tmp_path / "there", "--cluster", "head:6399")
    assert (status, connected) == (0, ["head:6399"])
    assert told.startswith("Cluster: processors of one? 2\n")
    assert lockprobe(*RUN, tmp_path / "here")[0] == 0
    here, there = (
        lockprobe("export", tmp_path / name, "--table", "records", "--format", "jsonl") for name in ("here", "there")
    )
    assert here == there


def test_an_estimate_needs_none(lockprobe, connected, tmp_path):
    assert lockprobe(*RUN, tmp_path / "S", "--cluster", "auto", "--estimate")[0] == 0
    assert connected == []
