"""What sending requests to OpenAI's client unchanged saves: processor time per call, with and without, in one run.

    uv run python benchmarks/openai_fast_path.py [--trials 20] [--rounds 5]

Both ways play the same study against a server in a process of its own that answers at once and whose model never opens
the box: trials of 20 steps. They take turns; the best round of each counts.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from tempfile import TemporaryDirectory

from makespan import MODEL, serving

from lockprobe.agents.llm import connect
from lockprobe.agents.model_access import Access
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal, load
from lockprobe.studies.running.runner import Limits, run

WAYS: dict[str, Callable[[object], None]] = {
    "as the client does": lambda client: None,
    "unchanged": connect.use_fast_path,
}


def milliseconds(way: str, trials: int) -> float:
    """Processor time per call of one study."""
    connect.use_fast_path = WAYS[way]
    planned = study(StudyOptions(agent=[f"llm:{MODEL}"], p=[0.3], trials=trials, repetitions=1))
    with TemporaryDirectory() as directory:
        began = time.process_time()
        with Journal.open(directory, planned) as journal:
            run(planned, journal, limits=Limits(access=Access(connections=10)))
        spent = time.process_time() - began
        calls = sum(len(trial.steps) for trial in load(directory))
    assert calls == 20 * trials
    return 1000 * spent / calls


def main() -> None:
    """Print the table."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--trials", type=int, default=20)
    asked.add_argument("--rounds", type=int, default=5)
    given = asked.parse_args()
    with serving(0.0) as url:
        os.environ |= {"FAKE_BASE_URL": url, "FAKE_API_KEY": "none"}
        rounds = [{way: milliseconds(way, given.trials) for way in WAYS} for _ in range(given.rounds)]
    print("| requests are sent | CPU ms a call |\n|---|---|")
    for way in WAYS:
        print(f"| {way} | {min(one[way] for one in rounds):.2f} |")


if __name__ == "__main__":
    main()
