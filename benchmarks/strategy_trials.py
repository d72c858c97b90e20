"""What a trial of a strategy costs that is played and kept, against a plain loop that writes the same lines.

    uv run python benchmarks/strategy_trials.py [--trials 300] [--rounds 30]

The plain loop is ordinary Python for one agent, one box and one kind of noise: a random agent, flips, one line of JSON
with its checksum, with the fields and the lengths of a record. It checks nothing. Lockprobe's side is what ``lockprobe
run`` does from the first trial to the last, in one process. They take turns; the best round of each counts, in
processor time.
"""

from __future__ import annotations

import argparse
import io
import json
import random
import time
import zlib
from contextlib import redirect_stdout
from functools import partial
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

from lockprobe.boxes.families import DEFAULT_BOX, find_box
from lockprobe.cli.live_report import LiveReport
from lockprobe.cli.progress import Progress
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.trial_rows import read_timings
from lockprobe.studies.running.runner import run

AGENTS = ("random", "human-inspired", "cognitive:careful")
P, BUDGET, SEED = 0.2, 20, 1
BOX = find_box(DEFAULT_BOX)
RECORDS = "trials.jsonl"
"""What the plain loop writes."""

FLIP = {"channel": "OutcomeFlip", "p": P, "inverts": "outcome", "others": "fresh", "keep": 0.0, "part": "both"}
FLIP |= {"only": "any", "from": None, "until": None, "at": "", "while": "always"}
BEFORE = {"study": "flips", "agent": "random", "facts": {}, "box": BOX.name, "condition": f"flip?p={P}"}
BEFORE |= {"modality": "symbolic?tell=state", "repetition": 1, "seed": SEED, "budget": BUDGET, "target": BOX.target}
BEFORE |= {"channels": [FLIP, {"channel": "TextChannel", "tell": "state", "form": "words", "places": False}]}
BEFORE |= {"joints": [joint.name for joint in BOX.joints], "opening": "At 1: none."}
AFTER = {"specs": [f"flip?p={P}"], "doses": {"flip.p": P}}
"""The fields of a record that all trials have alike, before and after its steps."""


def by_hand(trials: int, directory: Path) -> float:
    """Play and write trials of a random agent whose reports are flipped; seconds of processor time."""
    began = time.process_time()
    names = [joint.name for joint in BOX.joints]
    clauses = [BOX.interlock.get(name, ({},)) for name in names]
    needs = [[[(names.index(other), at) for other, at in one.items()] for one in of] for of in clauses]
    with (directory / RECORDS).open("w") as file:
        for trial in range(1, trials + 1):
            luck = random.Random(f"{SEED}/{trial}")
            labels = luck.sample("ABCD", 4)
            listing = luck.sample(labels, 4)
            state, told, solved, changed, steps = [0] * 4, [0] * 4, False, 0, []
            for number in range(1, BUDGET + 1):
                joint, before = int(luck.random() * 4), "".join(map(str, state))
                moved = any(all(state[other] == at for other, at in clause) for clause in needs[joint])
                said = moved ^ (luck.random() < P)
                state[joint] ^= moved
                told = [*state[:joint], told[joint] ^ said, *state[joint + 1 :]]
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


def by_lockprobe(agent: str, trials: int, directory: Path) -> float:
    """Play and keep the same study; seconds of processor time from the first trial to the last."""
    planned = study(StudyOptions(agent=[agent], p=[P], trials=trials, repetitions=1, seed=SEED, max_steps=BUDGET))
    with Journal.open(directory, planned) as journal, redirect_stdout(io.StringIO()):
        began = time.process_time()
        run(planned, journal, observer=LiveReport(Progress(report=False), None))
        return time.process_time() - began


def steps_in(directory: Path) -> float:
    """Steps a trial of the records in a directory."""
    if (directory / RECORDS).exists():
        return fmean(line.count(b'"step":') for line in (directory / RECORDS).read_bytes().splitlines())
    return fmean(timing.steps for timing in read_timings(directory))


def main() -> None:
    """Print the table."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--trials", type=int, default=300)
    asked.add_argument("--rounds", type=int, default=30)
    given = asked.parse_args()
    ways = ("by hand", *AGENTS)
    spent: dict[str, list[float]] = {way: [] for way in ways}
    steps: dict[str, float] = {}
    for _ in range(given.rounds):
        for way in ways:
            with TemporaryDirectory() as there:
                took = (by_hand if way == "by hand" else partial(by_lockprobe, way))(given.trials, Path(there))
                spent[way].append(1000 * took / given.trials)
                steps[way] = steps_in(Path(there))
    hand = min(spent["by hand"])
    print("| way | agent | steps a trial | ms a trial | ratio of trials | ratio of steps |\n|---|---|---|---|---|---|")
    for way in ways:
        took = min(spent[way])
        named = ("plain loop", "random") if way == "by hand" else ("`lockprobe run`", way)
        each = took / steps[way] / (hand / steps["by hand"])
        print(f"| {named[0]} | `{named[1]}` | {steps[way]:.1f} | {took:.3f} | {took / hand:.1f} | {each:.1f} |")


if __name__ == "__main__":
    main()
