"""Trials, step by step: one told two ways, which is to be watched first.

The trials that a page steps through stand in it as JSON that no browser runs; the script is our own text and is named
by its hash in the page's content policy. What agents wrote is shown as text and never as markup. Of a large study it is
a sample: the first trials of every agent under every condition, so that each stands beside the trials of equal luck.
"""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import Any

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.terminal_text import printable
from lockprobe.interventions.words import CORRECTION
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import primary_lines
from lockprobe.report.prose import condition_words
from lockprobe.report.rows import Fact, Results, who
from lockprobe.report.section import Part, Section, Template
from lockprobe.statistics.loops import cover
from lockprobe.statistics.modalities import spoken
from lockprobe.statistics.outcomes import ended
from lockprobe.trial.record import Trial
from lockprobe.trial.source import CAMERA, VERDICT, outcomes_by, source_of


def _first(numbers: OpenedStudy) -> Iterator[Fact]:
    """The trial to watch first: the first of the first agent that was solved, if one was."""
    own = [one for one in numbers.trials if one.group in numbers.subjects[:1] and one.ending != "error"]
    if own:
        yield Fact(about="trials", name="first", text=min(own, key=lambda one: not one.solved).key)


def _show_trials(found: Results) -> Iterator[Part]:
    several = any(len(own) > 1 for own in grouped(found.cells, lambda cell: (cell.agent, cell.modality)).values())
    heading = "One trial, told two ways" if several else "One trial, step by step"
    yield Part(heading, "", [Template("explorer", {"heading": heading})])


_WORDS, _ALL_WORDS = 160, 600_000
"""Characters of what an agent says about the box in one step, and of all such texts; beyond it, there are none."""

_STEPS = 60_000
"""Steps of trials that a page holds, about 0.6 MB; of more, it holds a sample."""


def explorer_data(trials: Sequence[Trial], found: Results) -> str:
    """The trials as JSON that may stand within a script element: it holds no ``<``.

    The joints of each box have the letters from A on, in its order. The page begins with the first effect that was
    detected.

    Args:
        trials: Those of a study; broken ones are left out, and of many, those of later blocks.
        found: Its results.
    """
    counted = ended(trials)
    steps = Counter[tuple[int, int]]()
    for trial in counted:
        steps[trial.trial, trial.repetition] += len(trial.steps)
    blocks = sorted(steps)  # the first whole ones, as many as a page holds, and at least one
    kept = {*blocks[: max(1, bisect_right(list(accumulate(map(steps.__getitem__, blocks))), _STEPS))]}
    shown = [trial for trial in counted if (trial.trial, trial.repetition) in kept]
    agents = list(dict.fromkeys((trial.group, trial.modality) for trial in shown))
    several = len({modality for _, modality in agents}) > 1
    conditions = list(dict.fromkeys(trial.condition for trial in shown))
    joints = {str(box.get("name")): [joint.get("name") for joint in box.get("joints", [])] for box in found.boxes}
    for trial in shown:
        own = joints.setdefault(trial.box, [])
        own += [joint for joint in trial.joints if joint not in own]
    places, called = {name: place for place, name in enumerate(joints)}, condition_words(found)
    people = list(dict.fromkeys(trial.player for trial in shown if trial.player))
    words = sum(len(step.decision.hypothesis[:_WORDS]) for trial in shown for step in trial.steps) <= _ALL_WORDS
    lines = primary_lines(found)
    lines.sort(key=lambda line: (line.second is None, not (line.change and line.change.detected)))
    start = [
        (agents.index((line.agent, line.modality)), *map(conditions.index, line.conditions))
        for line in lines[:1]
        if (line.agent, line.modality) in agents and {*line.conditions} <= {*conditions}
    ]
    data = {
        "agents": [_text(who(agent, spoken(modality) if several else "")) for agent, modality in agents],
        "conditions": [_text(called.get(condition, condition)) for condition in conditions],
        "boxes": [{"name": _text(name), "joints": [_text(str(one)) for one in own]} for name, own in joints.items()],
        **_there(budget=int(found.study.get("max_steps", 0)), start=start[0] if start else ()),
        "trials": [
            {
                "a": agents.index((trial.group, trial.modality)),
                "c": conditions.index(trial.condition),
                "r": trial.repetition,
                "n": trial.trial,
                **_there(b=places[trial.box], person=people.index(trial.player) + 1 if trial.player else 0),
                **_course(trial, joints[trial.box], words=words),
            }
            for trial in shown
        ],
        **_there(of=len(counted) if len(shown) < len(counted) else 0),
    }
    return json.dumps(data, separators=(",", ":"), ensure_ascii=True).replace("<", "\\u003c")


def _there(**values: Any) -> dict[str, Any]:
    """What is not empty."""
    return {name: value for name, value in values.items() if value}


def _text(said: str) -> str:
    """A text on one line, without characters that hide or reorder others."""
    return printable(re.sub(r"\s", " ", said))


_MARKS = {None: "-", True: "1", False: "0", "moved": "1", "blocked": "0"}
"""An outcome as a character."""


def _course(trial: Trial, names: Sequence[str], *, words: bool) -> dict[str, Any]:
    """What happened in a trial, a character a step: letters of joints, 1 for moved, 0 for blocked, - for nothing.

    Reports that are true and claims that repeat the report are left out.
    """
    steps = trial.steps
    letters: dict[str | None, str] = {None: "-"} | {name: chr(ord("A") + i) for i, name in enumerate(names)}
    did = "".join([letters[step.joint] for step in steps])
    chosen = "".join([letters[step.chosen] for step in steps])
    moved = "".join([_MARKS[step.moved] for step in steps])
    told = "".join([_MARKS[step.told_moved] for step in steps])
    claims = "".join([_MARKS[step.decision.claimed] for step in steps])
    back = ["0"] * len(steps)  # where a report corrects the one before it, and differs from it
    if any(CORRECTION in step.told for step in steps):
        statements = ({one.strip() for one in step.told.split(f"{CORRECTION} ")} for step in steps)
        back = [str(int(len(one) > 1)) for one in statements]
    loops = [" "] * len(steps)  # within an action loop the letter of what is repeated, elsewhere a blank
    repeated = dict[str, str]()
    for start, length in cover(did).intervals:
        letter = repeated.setdefault(did[start : start + length], "abcdefghijklmnopqrstuvwxyz"[len(repeated) % 26])
        loops[start : start + length] = letter * length
    sensed = {}
    if any(step.sensed for step in steps):  # what arm and camera took each step for, if it differs from the truth
        truth = [step.moved for step in steps]
        for name in (VERDICT, CAMERA):
            if any(name in step.sensed for step in steps) and (found := outcomes_by(name, trial)) != truth:
                sensed[name] = "".join([_MARKS[one] for one in found])
    said = [_text(step.decision.hypothesis[:_WORDS]) for step in steps] if words else []
    return {
        "solved": int(trial.solved),
        "did": did,
        "moved": moved,
        **_there(
            told=told if told != moved else "",
            said=claims if claims[1:] != told[:-1] else "",
            back="".join(back) if "1" in back else "",
            loop="".join(loops) if repeated else "",
            chosen=chosen if chosen.strip("-") else "",
            words=said if any(said) else [],
            **sensed,
            source=(source_of(trial.modality) or "") if sensed else "",
        ),
    }


SECTIONS = (Section("trials", "Trials", _first, _show_trials),)
