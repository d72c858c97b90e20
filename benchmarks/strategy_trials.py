"""What a trial of a strategy costs that is played and kept, against a plain loop that writes the same lines.

    uv run python benchmarks/strategy_trials.py [--trials 300] [--rounds 30]

The plain loop is ordinary Python for one box and one kind of noise: an agent in a few lines, flips, one line of JSON
with its checksum, with the fields and the lengths of a record. It checks nothing. Lockprobe's side is what ``lockprobe
run`` does from the first trial to the last, in one process; ``run_trial`` plays the same trials and keeps nothing. They
take turns; the best round of each counts, in processor time, and for two processes in seconds.
"""

from __future__ import annotations

import argparse
import asyncio
import io
import json
import random
import time
import zlib
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import DEFAULT_BOX, find_box
from lockprobe.cli.run_study import Progress
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.store import read
from lockprobe.studies.running.runner import Limits, run
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.studies.study import Study

AGENTS = ("random", "human-inspired")
P, BUDGET, SEED = 0.2, 20, 1
BOX = find_box(DEFAULT_BOX)
TARGET = BOX.target_index
RECORDS = "trials.jsonl"
"""What the plain loop writes."""

FLIP = {"channel": "OutcomeFlip", "p": P, "inverts": "outcome", "others": "fresh", "keep": 0.0, "part": "both"}
FLIP |= {"only": "any", "at": "", "while": "always"}
BEFORE = {"study": "flips", "agent": "random", "facts": {}, "box": BOX.name, "condition": f"flip?p={P}"}
BEFORE |= {"modality": "symbolic?tell=state", "repetition": 1, "seed": SEED, "budget": BUDGET, "target": BOX.target}
BEFORE |= {"channels": [FLIP, {"channel": "TextChannel", "tell": "state", "form": "words", "places": False}]}
BEFORE |= {"joints": [joint.name for joint in BOX.joints], "opening": "At 1: none."}
AFTER = {"specs": [f"flip?p={P}"], "doses": {"flip.p": P}}
"""The fields of a record that all trials have alike, before and after its steps."""


def at_random(luck: random.Random, failed: set[int], told: list[bool]) -> int:
    """Any joint."""
    return int(luck.random() * 4)


def human_inspired(luck: random.Random, failed: set[int], told: list[bool]) -> int:
    """The target, or what has neither failed since the last move nor is open, or what has not failed."""
    if TARGET not in failed:
        return TARGET
    untried = [joint for joint in range(4) if joint not in failed]
    among = [joint for joint in untried if not told[joint]] or untried or range(4)
    return among[int(luck.random() * len(among))]


def by_hand(agent: str, trials: int, directory: Path) -> float:
    """Play and write trials of an agent whose reports are flipped; seconds of processor time."""
    choice = at_random if agent == "random" else human_inspired
    began = time.process_time()
    names = [joint.name for joint in BOX.joints]
    clauses = [BOX.interlock.get(name, ({},)) for name in names]
    needs = [[[(names.index(other), at) for other, at in one.items()] for one in of] for of in clauses]
    with (directory / RECORDS).open("w") as file:
        for trial in range(1, trials + 1):
            luck = random.Random(f"{SEED}/{trial}")
            labels = luck.sample("ABCD", 4)
            listing = luck.sample(labels, 4)
            state, told, failed, solved, changed, steps = [0] * 4, [0] * 4, set(), False, 0, []
            for number in range(1, BUDGET + 1):
                joint, before = choice(luck, failed, told), "".join(map(str, state))
                moved = any(all(state[other] == at for other, at in clause) for clause in needs[joint])
                said = moved ^ (luck.random() < P)
                state[joint] ^= moved
                told = [*state[:joint], told[joint] ^ said, *state[joint + 1 :]]
                failed = set() if said else failed | {joint}
                changed += said != moved
                there = ", ".join(label for label in listing if told[labels.index(label)])
                step = {"step": number, "state": before, "joint": names[joint], "moved": moved, "told_moved": said}
                step["told_state"] = "".join(map(str, told))
                step["told"] = f"You attempted {labels[joint]}. At 1: {there or 'none'}."
                steps.append(step | {"decision": {"joint": labels[joint]}})
                if solved := moved and names[joint] == BOX.target:
                    break
            key = {"key": f"flips/random/flip?p={P}/rep=1/trial={trial}"}
            record = key | BEFORE | {"trial": trial, "labels": labels, "listing": listing, "steps": steps}
            record |= {"ending": "solved" if solved else "budget"} | AFTER
            record |= {"changed": {f"flip?p={P}": changed}, "changed_steps": changed, "identity": "0123456789ab"}
            line = json.dumps(record, separators=(",", ":"))[:-1]
            file.write(f'{line},"crc":"{zlib.crc32(line.encode()):08x}"}}\n')
    return time.process_time() - began


def planned(agent: str, trials: int) -> Study:
    """The same trials as a study."""
    asked = StudyOptions(agent=[agent], p=[P], trials=trials, repetitions=1, seed=SEED, max_steps=BUDGET)
    return study(asked)


def alone(agent: str, trials: int, directory: Path) -> float:
    """Play them and keep nothing."""
    plans, player = list(planned(agent, trials).plans(agent)), resolve(agent).make()

    async def played() -> None:
        for plan in plans:
            await play_timed(plan, player)

    began = time.process_time()
    asyncio.run(played())
    return time.process_time() - began


def kept(agent: str, trials: int, directory: Path, workers: int = 1) -> float:
    """Play and keep them; seconds from the first trial to the last, of processor time where one process plays."""
    clock = time.process_time if workers == 1 else time.perf_counter
    of = planned(agent, trials)
    with Journal.open(directory, of) as journal, redirect_stdout(io.StringIO()):
        began = clock()
        run(of, journal, limits=Limits(workers=workers), observer=Progress(of, journal))
        return clock() - began


def steps_in(directory: Path) -> float:
    """Steps a trial of the records in a directory."""
    if (directory / RECORDS).exists():
        lines = (directory / RECORDS).read_bytes().splitlines()
        return sum(line.count(b'"step":') for line in lines) / len(lines)
    with read(directory) as store:
        return float(store.one("select avg(steps) from trial")[0])


def main() -> None:
    """Print the table."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--trials", type=int, default=300)
    asked.add_argument("--rounds", type=int, default=30)
    asked.add_argument("--workers", type=int, default=1, help="processes of the last row, which takes over after 2 s")
    given = asked.parse_args()
    ways: dict[str, Callable[..., float]] = {
        "plain loop": by_hand,
        "`run_trial`": alone,
        "kept": partial(kept, workers=given.workers),
    }
    spent: dict[tuple[str, str], float] = {}
    steps: dict[tuple[str, str], float] = {}
    for _ in range(given.rounds):
        for agent, way in product(AGENTS, ways):
            with TemporaryDirectory() as there:
                took = 1000 * ways[way](agent, given.trials, Path(there)) / given.trials
                spent[agent, way] = min(took, spent.get((agent, way), took))
                if way != "`run_trial`":
                    steps[agent, way] = steps_in(Path(there))
    print("| agent | way | steps a trial | ms a trial | µs a step | times the plain loop |\n|---|---|---|---|---|---|")
    for (agent, way), took in spent.items():
        plain = spent[agent, "plain loop"] / steps[agent, "plain loop"]
        played = steps[agent, "plain loop" if way == "plain loop" else "kept"]
        each = f"{1000 * took / played:.1f} | {took / played / plain:.1f}"
        print(f"| `{agent}` | {way} | {played:.1f} | {took:.3f} | {each} |")


if __name__ == "__main__":
    main()
