"""What the short study finds: ``python benchmarks/first_study.py [--studies 40]``.

The first command plays 300 trials at each flip rate with every strategy and learner. This plays it with other seeds and
counts the courses of success that the report states for the learner and for the human-inspired strategy.
"""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

import lockprobe
from lockprobe.statistics.proportions import proportion
from lockprobe.studies.options.paper import LEARNER

AGENTS = (LEARNER, "human-inspired")


def courses(seed: int) -> dict[str, str]:
    """Agent -> what the report of one study says of its success over the flip rate: higher at some rate, lower."""
    with TemporaryDirectory() as directory:
        study = Path(directory) / "study"
        lockprobe.run_study(lockprobe.study(agent=list(AGENTS), seed=seed), study)
        (said,) = (
            one.text for one in lockprobe.results(study).findings if (one.section, one.kind) == ("success", "courses")
        )
    clauses = (clause.partition(" for ") for clause in said.rstrip(".").partition(": ")[2].split("; "))
    return {agent: kind for kind, _, agents in clauses for agent in agents.split(", ")}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=40)
    studies = parser.parse_args().studies
    counts = Counter((agent, kind) for seed in range(1, studies + 1) for agent, kind in courses(seed).items())
    print(f"{'agent':30} {'course':22} studies, share [95 % interval]")
    for (agent, kind), count in sorted(counts.items()):
        share = proportion(count, studies)
        print(f"{agent:30} {kind:22} {count} of {studies}, {share.value:.3f} [{share.low:.3f}, {share.high:.3f}]")


if __name__ == "__main__":
    main()
