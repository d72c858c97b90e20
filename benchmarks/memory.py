"""How much memory a study of a hosted model takes, by how long it is.

    uv run python benchmarks/memory.py [--trials 210,2100] [--connections 10]

Every study is played in a process of its own, against a server in another that answers at once and whose model never
opens the box: trials of 20 steps. The peak is that of the resident set, libraries included; beside it stands what the
process took before the first trial.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import time
from tempfile import TemporaryDirectory

from makespan import MODEL, serving

from lockprobe.agents.llm.model import HostedModel
from lockprobe.agents.model_access import Access
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal, load
from lockprobe.studies.running.runner import Limits, run


def resident() -> float:
    """The largest resident set so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def played(trials: int, connections: int) -> str:
    """One row of the table, of this process."""
    planned = study(StudyOptions(agent=[f"llm:{MODEL}"], p=[0.3], trials=trials, repetitions=1))
    HostedModel(MODEL)
    before, wall, processor = resident(), time.perf_counter(), time.process_time()
    with TemporaryDirectory() as directory:
        with Journal.open(directory, planned) as journal:
            run(planned, journal, limits=Limits(access=Access(connections=connections)))
        peak, wall, processor = resident(), time.perf_counter() - wall, time.process_time() - processor
        steps = sum(len(trial.steps) for trial in load(directory))
    cost = 1000 * processor / steps
    return f"| {trials} | {steps} | {before:.0f} | {peak:.0f} | {steps / wall:.0f} | {cost:.2f} |"


def main() -> None:
    """Print the table, row by row."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--trials", default="210,2100")
    asked.add_argument("--connections", type=int, default=10)
    asked.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    given = asked.parse_args()
    if given.here:
        print(played(int(given.trials), given.connections))
        return
    print("| trials | requests | MB before | MB at most | requests a second | CPU ms a request |")
    print("|---|---|---|---|---|---|", flush=True)
    for trials in given.trials.split(","):
        with serving(0.0) as url:
            environment = os.environ | {"FAKE_BASE_URL": url, "FAKE_API_KEY": "none"}
            again = [sys.executable, __file__, "--here", "--trials", trials, "--connections", str(given.connections)]
            subprocess.run(again, env=environment, check=True)


if __name__ == "__main__":
    main()
