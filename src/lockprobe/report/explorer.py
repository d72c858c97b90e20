"""The trial explorer of a page: trials of a study as compact data, and the script that steps through them.

Of a large study it holds a sample: the first trials of every agent under every condition, so that each stands beside
the trials of equal luck.

The data stand in the page as JSON that no browser runs, the script is our own text and is named by its hash in the
page's content policy. What agents wrote is shown as text and never as markup.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from bisect import bisect_right
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from itertools import accumulate
from typing import Any

from lockprobe.foundation.terminal_text import printable
from lockprobe.report.examples import loop_letters
from lockprobe.trial.record import Step, Trial
from lockprobe.trial.source import camera_outcomes, source_of, verdict_outcomes

_WORDS = 160
"""Characters of what an agent says about the box in one step."""

_ALL_WORDS = 600_000
"""Characters of all such texts; beyond it, the explorer shows none."""


@cache
def script() -> str:
    """The program of the explorer."""
    return files("lockprobe.report").joinpath("templates/explorer.js").read_text(encoding="utf-8")


@cache
def script_hash() -> str:
    """Its hash as a source of a content security policy."""
    return f"sha256-{base64.b64encode(hashlib.sha256(script().encode()).digest()).decode()}"


_STEPS = 80_000
"""Steps of trials that a page holds, about 3 MB; of more, it holds a sample."""


def explorer_data(trials: Sequence[Trial], box: Mapping[str, Any]) -> str:
    """The trials as JSON that may stand within a script element: it holds no ``<``.

    Args:
        trials: Those of a study; broken ones are left out, and of many, those of later blocks.
        box: The box as in the settings of the study.
    """
    ended = [trial for trial in trials if trial.ending != "error"]
    shown = _sample(ended)
    agents = list(dict.fromkeys((trial.group, trial.modality) for trial in shown))
    several = len({modality for _, modality in agents}) > 1
    conditions = list(dict.fromkeys(trial.condition for trial in shown))
    names = list(dict.fromkeys(joint for trial in shown for joint in trial.joints))
    kinds = {joint.get("name"): joint.get("kind") for joint in box.get("joints", [])}
    people = list(dict.fromkeys(trial.player for trial in shown if trial.player))
    words = sum(len(step.decision.hypothesis[:_WORDS]) for trial in shown for step in trial.steps) <= _ALL_WORDS
    data = {
        "agents": [_text(f"{agent}, {modality}" if several else agent) for agent, modality in agents],
        "conditions": [_text(condition) for condition in conditions],
        "joints": [_text(name) for name in names],
        "turning": [int(kinds.get(name) == "revolute") for name in names],
        "trials": [
            {
                "a": agents.index((trial.group, trial.modality)),
                "c": conditions.index(trial.condition),
                "r": trial.repetition,
                "n": trial.trial,
                **({"person": people.index(trial.player) + 1} if trial.player else {}),
                **_course(trial, names, words=words),
            }
            for trial in shown
        ],
        **({"of": len(ended)} if len(shown) < len(ended) else {}),
    }
    return json.dumps(data, separators=(",", ":"), ensure_ascii=True).replace("<", "\\u003c")


def _sample(trials: Sequence[Trial]) -> Sequence[Trial]:
    """Trials of whole blocks, in their order: those of the first ones, as many as a page holds, and at least one."""
    steps = Counter[tuple[int, int]]()
    for trial in trials:
        steps[_block(trial)] += len(trial.steps)
    blocks = sorted(steps)
    room = bisect_right(list(accumulate(steps[block] for block in blocks)), _STEPS)
    kept = set(blocks[: max(1, room)])
    return [trial for trial in trials if _block(trial) in kept]


def _block(trial: Trial) -> tuple[int, int]:
    return trial.trial, trial.repetition


def _text(said: str) -> str:
    """A text on one line, without characters that hide or reorder others."""
    return printable(re.sub(r"\s", " ", said))


def _course(trial: Trial, names: Sequence[str], *, words: bool) -> dict[str, Any]:
    """What happened in a trial: joints by their index in ``names``, bit strings in its panel order."""
    steps, after = trial.steps, _after(trial)
    said = [_text(step.decision.hypothesis[:_WORDS]) for step in steps] if words else []
    chosen = [-1 if step.chosen is None else names.index(step.chosen) for step in steps]
    return {
        "goal": names.index(trial.target),
        "solved": int(trial.solved),
        "panel": [names.index(joint) for joint in trial.joints],
        "did": [names.index(step.joint) for step in steps],
        "moved": "".join(str(int(step.moved)) for step in steps),
        "told": "".join("-" if step.told_moved is None else str(int(step.told_moved)) for step in steps),
        "state": [*(step.state for step in steps), *after[-1:]],
        "shown": [_told_state(step, state) for step, state in zip(steps, after, strict=True)],
        "said": "".join({"moved": "1", "blocked": "0"}.get(step.decision.claimed or "", "-") for step in steps),
        "loop": loop_letters(trial.actions),
        **({"chosen": chosen} if any(one >= 0 for one in chosen) else {}),
        **({"words": said} if any(said) else {}),
        **_sensed(trial),
    }


def _sensed(trial: Trial) -> dict[str, str]:
    """What arm and camera took each step for, of those that differ from the truth; ``-`` is undecided."""
    truth = [step.moved for step in trial.steps]
    found = {
        name: "".join("-" if moved is None else str(int(moved)) for moved in outcomes)
        for name, outcomes in (("verdict", verdict_outcomes(trial)), ("camera", camera_outcomes(trial)))
        if any(name in step.sensed for step in trial.steps) and outcomes != truth
    }
    source = source_of(trial.modality)
    return found | ({"source": source.of} if found and source is not None else {})


def _after(trial: Trial) -> list[str]:
    """The true configuration after each step; after the last one it follows from its outcome."""
    later = [step.state for step in trial.steps[1:]]
    for step in trial.steps[-1:]:
        place = trial.joints.index(step.joint)
        bit = str(int(step.state[place] == "0")) if step.moved else step.state[place]
        later.append(step.state[:place] + bit + step.state[place + 1 :])
    return later


def _told_state(step: Step, after: str) -> str:
    """The configuration as told or pictured, or nothing where none was."""
    if step.told_state is not None:
        return "" if step.told_state == after else step.told_state
    return "" if step.pictures else "-"
