"""Suites: fixed, versioned sets of studies, each at one level of difficulty, whose scores people can quote.

A suite never changes once it is published; another set gets another number. ``suite-1`` has four boxes of the paper's
size, four joints: a box with a distractor, the default chain, a chain whose first joint has to be closed again, and
Chinese rings. A uniformly random agent solves 57, 39, 23 and 1.6 % of trials within 20 steps (exact); the shortest
plans have 3, 4, 5 and 8 steps. The layout of the panel is random in every trial, so that places tell nothing. Half of
the trials have true reports, half a flip rate of 0.4, at which the paper reports the highest success (Sec. 3.2). The
choice of boxes and numbers of trials is ours.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue, UnknownName
from lockprobe.foundation.inputs import parse_json, read_input
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.atomic_file import write_file, writing
from lockprobe.foundation.storage.links import refuse_links
from lockprobe.interventions.conditions import flips
from lockprobe.interventions.flip import DEFAULT
from lockprobe.studies.file_names import SCORES, SETTINGS, is_suite
from lockprobe.studies.options import paper
from lockprobe.studies.options.agent_names import named_agents
from lockprobe.studies.study import LIMITS, Study
from lockprobe.studies.until import MOST, Until
from lockprobe.trial.record import STATES

__all__ = [
    "SUITES",
    "Suite",
    "begin_suite",
    "read_suite",
    "suite_directories",
    "suite_studies",
    "suite_study",
]

_PICTURES = "-pictures"
"""Suffix of the names of directories whose agents read pictures."""

_LARGEST = 2**24
"""Bytes of the file."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Suite:
    """A fixed set of studies.

    Attributes:
        name: Its name with its version.
        boxes: One box for each level, from easy to hard.
        judged: The boxes on which an ideal observer judges actions, because its prior holds them.
        p: Flip rates: the truth, and the rate of false reports.
        trials: Trials of a level and flip rate, for agents that read reports.
        looks: Trials of a level, flip rate and modality, for agents that read pictures; the total is equal.
        seed: Seed of the first level; each further level has the next seed, so that levels are independent samples.
        until: When each of its studies stops; ``trials`` and ``looks`` are then the most. None if all are played.
    """

    name: str
    boxes: tuple[str, ...]
    judged: tuple[str, ...]
    p: tuple[float, float]
    trials: int
    looks: int
    seed: int
    until: Until | None = None

    def until_decided(self, until: Until, most: int = MOST) -> Suite:
        """The suite whose studies stop when they are decided; ``most``: trials of a level and condition at most."""
        return replace(self, until=until, trials=most, looks=most)

    @property
    def stopping(self) -> dict[str, object]:
        """When its studies stop, as JSON holds it; empty if all trials are played."""
        return {} if self.until is None else {"until": str(self.until), "most": self.trials}

    @property
    def said(self) -> str:
        """Its name, and when its studies stop."""
        return self.name if self.until is None else f"{self.name} until {self.until} (at most {self.trials} trials)"

    @property
    def size(self) -> int:
        """Trials that an agent plays."""
        return len(self.boxes) * len(self.p) * self.trials


SUITES: Mapping[str, Suite] = {
    "suite-1": Suite(
        name="suite-1",
        boxes=("fork", "chain-4", "reset", "gray-code-4"),
        judged=("chain-4",),
        p=(0.0, 0.4),
        trials=36,
        looks=12,
        seed=1,
    )
}
"""The suites by name."""


def suite_studies(suite: Suite, agents: Sequence[str]) -> dict[str, Study]:
    """The studies of a suite by the name of their directory, level by level.

    Agents that read pictures play separate studies, in the paper's three modalities.

    Args:
        suite: The suite.
        agents: Agents, each as ``SPEC`` or ``NAME=SPEC``.

    Raises:
        UnknownName: If there is no such agent.
        BadValue: If there is no agent, people are among them, or an agent is listed twice.
    """
    agents, names = named_agents(agents)
    if PEOPLE in agents:
        raise BadValue("agent", PEOPLE, f"an agent that runs by itself: people do not play {suite.name}")
    if not agents:
        raise BadValue("agent", list(agents), "at least one")
    looks = {agent: resolve(agent).senses == "pictures" for agent in agents}
    groups = [("", [one for one in agents if not looks[one]]), (_PICTURES, [one for one in agents if looks[one]])]
    return {
        (directory := f"{name}{ending}"): suite_study(suite, directory, players, names)
        for name in suite.boxes
        for ending, players in groups
        if players
    }


def suite_study(suite: Suite, directory: str, agents: Sequence[str], names: Mapping[str, str] | None = None) -> Study:
    """One study of a suite, by the name of its directory; the agents are not looked up. ``names`` as of a study."""
    name, pictures = directory.removesuffix(_PICTURES), directory.endswith(_PICTURES)
    return Study(
        name=f"{suite.name}-{name}",
        agents=tuple(agents),
        box=box(name),
        conditions=flips(suite.p, DEFAULT, paper.MODALITIES if pictures else [STATES]),
        repetitions=1,
        trials=suite.looks if pictures else suite.trials,
        max_steps=paper.MAX_STEPS,
        until=suite.until,
        seed=suite.seed + suite.boxes.index(name),
        plant=paper.ROBOT if pictures else "symbolic",
        layout="shuffled",
        names=names or {},
    )


def read_suite(directory: Path) -> Suite:
    """The suite that is played in a directory.

    Raises:
        BadFile: If it holds no suite, or one that this release does not know.
    """
    path = directory / SCORES
    found = parse_json(read_input(path, _LARGEST), path)
    name = found.get("suite") if isinstance(found, dict) else None
    if not isinstance(name, str) or name not in SUITES:
        raise BadFile(path, str(UnknownName("suite", str(name)[:60], SUITES)))
    assert isinstance(found, dict)
    return _stopping(SUITES[name], found, path)


def _stopping(suite: Suite, found: Mapping[str, Any], path: Path) -> Suite:
    """The suite as its file has it: all trials, or until its studies are decided."""
    until, most = found.get("until"), found.get("most")
    if until is None and most is None:
        return suite
    if not isinstance(until, str) or type(most) is not int or not 1 <= most <= LIMITS["trials"]:
        raise BadFile(path, 'expected "until" and "most", as `lockprobe run suite-1 --until` writes them')
    try:
        return suite.until_decided(Until.parse(until), most)
    except BadValue as error:
        raise BadFile(path, str(error)) from None


def begin_suite(directory: Path, suite: Suite) -> None:
    """Create the directory of a suite, unless it exists. Idempotent.

    Raises:
        BadFile: If it holds a study or another suite, or cannot be written.
    """
    if (directory / SETTINGS).exists():
        raise BadFile(directory, f"it holds a study; {suite.name} needs a directory that has none")
    if is_suite(directory):
        if (there := read_suite(directory)) != suite:
            both = "repeat its settings to resume it, or give another --out"
            raise BadFile(directory, f"it holds {there.said}, not {suite.said}: {both}")
        return
    refuse_links(directory)
    with writing(directory):
        directory.mkdir(parents=True, exist_ok=True)
        write_file(directory / SCORES, json.dumps({"suite": suite.name, **suite.stopping}) + "\n")


def suite_directories(directory: Path, suite: Suite) -> list[str]:
    """The names of the directories of its studies that are there, level by level."""
    names = [f"{name}{ending}" for name in suite.boxes for ending in ("", _PICTURES)]
    return [name for name in names if (directory / name / SETTINGS).exists()]
