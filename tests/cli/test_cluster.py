"""``--cluster`` as it is typed."""

from contextlib import nullcontext

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


@pytest.fixture
def connected(monkeypatch):
    """The addresses to which commands connect."""
    found = []
    monkeypatch.setattr(Cluster, "connect", lambda address: (found.append(address), nullcontext(Here()))[1])
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
    assert lockprobe(*RUN, tmp_path / "S", "--cluster", "auto", "--estimate")[0] == 0
    assert connected == ["head:6399"]
