"""What one driver costs on a cluster: its processor time per 1 000 trials, and how many processors it can feed.

    uv run --extra cluster python benchmarks/cluster.py [--trials 2000] [--address HOST:PORT]

Without an address it starts three nodes on this machine: a head without processors, and two with one each. Strategies
are the worst case, because their trials take milliseconds; a driver that spends d seconds on a trial feeds s / d
processors whose trials take s seconds. The records have to be those of one process, or it stops.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from loopback_cluster import loopback_cluster

from lockprobe.foundation.cluster import Cluster
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal, read_timings
from lockprobe.studies.running.runner import Limits, run


def processor_seconds() -> float:
    """Processor time of this process with all its threads."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def played(directory: Path, agent: str, plant: str, trials: int, limits: Limits) -> tuple[float, float, bytes]:
    """Seconds, processor seconds of this process, and the records in the order of their keys."""
    planned = study("flips", agent=[agent], p=[0, 0.4], trials=trials // 2, repetitions=1, plant=plant)
    began, used = time.perf_counter(), processor_seconds()
    with Journal.open(directory, planned) as journal:
        run(planned, journal, limits=limits)
    seconds, cost = time.perf_counter() - began, processor_seconds() - used
    return seconds, cost, b"".join(sorted((directory / "trials.jsonl").read_bytes().splitlines(keepends=True)))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=2000)
    parser.add_argument("--address")
    given = parser.parse_args()
    there = loopback_cluster(nodes=2) if given.address is None else nullcontext(SimpleNamespace(address=given.address))
    with there as found, Cluster.connect(found.address) as cluster, tempfile.TemporaryDirectory() as base:
        while not sum(node.processors for node in cluster.nodes):
            time.sleep(0.5)
        print("agent  plant  trials  one process, s  cluster, s  driver, s per 1 000 trials  a trial, ms  feeds")
        for agent, plant, trials in (("human-inspired", "symbolic", given.trials), ("viewer", "fast-twin", 40)):
            name = agent + plant
            alone = played(Path(base) / f"{name}-alone", agent, plant, trials, Limits())
            far = played(Path(base) / f"{name}-far", agent, plant, trials, Limits(cluster=cluster))
            if alone[2] != far[2]:
                raise SystemExit("the records differ")
            mean = sum(one.seconds for one in read_timings(Path(base) / f"{name}-far")) / trials
            per_trial = far[1] / trials
            print(
                f"{agent}  {plant}  {trials}  {alone[0]:.1f}  {far[0]:.1f}  {1000 * per_trial:.2f}  {1000 * mean:.1f}  "
                f"{mean / per_trial:.0f} processors"
            )


if __name__ == "__main__":
    main()
