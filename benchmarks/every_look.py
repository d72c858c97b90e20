"""How often a study that is looked at after every block ever says something false, and what it costs to stop early.

    OMP_NUM_THREADS=1 python benchmarks/every_look.py [--parts false,why,coverage,calls] [--studies 1000] [--workers 2]
        [--seed 1] [--json FILE]

``false`` and ``why`` count the studies of known truth in which a false statement is made at any of their looks, 200
blocks long (``looked_at.py``). ``coverage`` counts those in which some interval of a sequence leaves out the truth.
``calls`` compares the blocks until a study is decided with fixed designs of equal power (``until_calls.py``). With
``--json`` the rates of the first three are written as ``lockprobe audit`` has them, without other parts of its file.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from looked_at import BLOCKS, WHY, Asked, false_of, groups
from until_calls import DOSES, LUCKS, PAIRS, Job, Truth, decided, same_as_paired, table
from why_rules import MECHANISMS, PATTERNS, Case, worlds

from lockprobe.foundation.parallel import Pool, Processes
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.audit.rates import EveryLookRate
from lockprobe.simulation.power.why import mechanism_of
from lockprobe.statistics.sequential.contrasts import Numbers, at_every_look
from lockprobe.statistics.sequential.shares import share_at_every_look

COVERED = "an interval leaves out the true value: {}"


def false_rates(parts: Sequence[str], studies: int, seed: int, pool: int, workers: Pool) -> list[EveryLookRate]:
    """The rates of false statements, in all worlds of these parts."""
    jobs = [*_jobs(studies, seed)] if "false" in parts else []
    if "why" in parts:
        jobs += _why_jobs(studies, seed, pool, workers)
    said, played = Counter[tuple[str, str, int]](), Counter[tuple[str, str]]()
    for job, found in zip(jobs, workers.map(false_of, jobs), strict=True):
        played[job.says, job.world] += job.studies
        said.update({(job.says, job.world, agents): count for agents, count in found.items()})
        if job.end == studies:
            for (says, world, agents), count in said.items():
                if (says, world) == (job.says, job.world):
                    print(f"{says} | {world} | {agents} | {count} of {studies}", flush=True)
    return [
        EveryLookRate(says=says, world=world, agents=agents, studies=played[says, world], said=count)
        for (says, world, agents), count in said.items()
    ]


def _jobs(studies: int, seed: int) -> Iterator[Asked]:
    for says, found in groups().items():
        for group in found:
            for world in group.worlds:
                for first in range(0, studies, group.size):
                    yield Asked(says, world, seed, first, min(first + group.size, studies))


def _why_jobs(studies: int, seed: int, pool: int, workers: Pool) -> Iterator[Asked]:
    patterns = [
        Case(name=name, mechanism=mechanism_of(shares), total=round(shares[1] - shares[0], 9), source=np.array(shares))
        for name, shares in PATTERNS.items()
    ]
    for case in (*patterns, *worlds(list(MECHANISMS), pool, workers)):
        for first in range(0, studies, 50):
            yield Asked(WHY, case.name, seed, first, min(first + 50, studies), case)


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a confidence sequence is asked to cover.

    Attributes:
        of: The quantity.
        name: What is true.
        values: The numbers that a block can give.
        chances: Their probabilities.
        means: Means that are judged together.
    """

    of: str
    name: str
    values: tuple[float, ...]
    chances: tuple[float, ...]
    means: int = 1


def _sequences() -> Iterator[Quantity]:
    for share in (0.02, 0.2, 0.5, 0.98):
        yield Quantity("success", f"{share:.0%} solved", (0.0, 1.0), (1 - share, share))
    for name, less, more, means in (
        ("no effect", 0.2, 0.2, 1),
        ("no effect, one of 4 doses", 0.2, 0.2, 4),
        ("+10 points", 0.1, 0.2, 1),
        ("+9.5 points", 0.005, 0.1, 1),
        ("+40 points", 0.05, 0.45, 1),
    ):
        yield Quantity("difference", name, (-1.0, 0.0, 1.0), (less, 1 - less - more, more), means)
    for name, chances in (("none", (0.1, 0.2, 0.4, 0.2, 0.1)), ("-15 points", (0.2, 0.3, 0.3, 0.1, 0.1))):
        yield Quantity("mean over blocks", name, (-1.0, -0.5, 0.0, 0.5, 1.0), chances)


@dataclass(frozen=True, slots=True)
class _Covered:
    asked: Quantity
    seed: int
    studies: int


def left_out(job: _Covered) -> int:
    """In how many studies some interval of the sequence leaves out the truth; of several means, that of the first."""
    one, missed = job.asked, 0
    rng = generator(job.seed, "every look", "coverage", one.of, one.name)
    truth = float(np.dot(one.values, one.chances))
    for _ in range(job.studies):
        drawn = rng.choice(one.values, p=one.chances, size=(one.means, BLOCKS))
        if one.of == "success":
            found = share_at_every_look(drawn[0] > 0)
            missed += not found.low <= truth <= found.high
            continue
        # Intervals lie within those before, so that the last one covers only if all do.
        judged = at_every_look([Numbers(values=own, block=np.arange(BLOCKS)) for own in drawn])
        missed += not judged[0].low <= truth <= judged[0].high
    return missed


def coverage(studies: int, seed: int, workers: Pool) -> list[EveryLookRate]:
    """How often sequences leave out what they estimate."""
    jobs = [_Covered(one, seed, studies) for one in _sequences()]
    return [
        EveryLookRate(says=COVERED.format(job.asked.of), world=job.asked.name, agents=1, studies=studies, said=missed)
        for job, missed in zip(jobs, workers.map(left_out, jobs), strict=True)
    ]


def worst(rates: Sequence[EveryLookRate]) -> dict[str, Any]:
    """The highest rate of each statement and number of agents, as ``lockprobe audit`` has it."""
    groups_: dict[tuple[str, int], list[EveryLookRate]] = {}
    for one in rates:
        groups_.setdefault((one.says, one.agents), []).append(one)
    rows = []
    for own in groups_.values():
        highest = max(own, key=lambda one: one.rate)
        derived = {"worlds": len(own), "rate": highest.rate, "error": highest.error, "valid": highest.valid}
        rows.append(asdict(highest) | derived)
    return {"blocks": BLOCKS, "rates": rows}


def rates_table(found: dict[str, Any]) -> str:
    """The table of the highest rates."""
    lines = ["| said falsely at any look | agents | worlds | worst world | of studies |", "|---|---|---|---|---|"]
    for row in found["rates"]:
        share = f"{row['said']} of {row['studies']}: {row['rate']:.3f} ± {row['error']:.3f}"
        share += "" if row["valid"] else " !"
        lines.append(f"| {row['says']} | {row['agents']} | {row['worlds']} | {row['world']} | {share} |")
    return "\n".join(lines)


def calls_table(studies: int, seed: int, workers: Pool) -> str:
    """The table of blocks until studies are decided."""
    same_as_paired(np.random.default_rng(seed))
    jobs = [
        Job(Truth(first, second, luck, doses), studies, seed)
        for first, second in PAIRS
        for doses in DOSES
        for luck in LUCKS
    ]
    return table([*workers.map(decided, jobs)])


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", default="false,why,coverage,calls")
    parser.add_argument("--studies", type=int, default=1000)
    parser.add_argument("--pool", type=int, default=1000, help="blocks played of each world of the study of controls")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    workers, parts = Processes(asked.workers), asked.parts.split(",")
    rates = false_rates(parts, asked.studies, asked.seed, asked.pool, workers)
    if "coverage" in parts:
        rates += coverage(asked.studies, asked.seed, workers)
    if rates:
        print(f"\n{rates_table(worst(rates))}\n")
    if asked.json:
        asked.json.write_text(json.dumps({"seed": asked.seed} | worst(rates), indent=1) + "\n", encoding="utf-8")
    if "calls" in parts:
        print(calls_table(asked.studies, asked.seed, workers))


if __name__ == "__main__":
    main()
