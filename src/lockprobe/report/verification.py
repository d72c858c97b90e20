"""Verification of a finished study from its records alone: settings, checksums, luck, truth, reports and results.

What a record says of the box and of the reports has to follow from its actions, from the rules of the box and from the
random streams of its seed. So every trial is played again with the recorded choices. Strategies that ship are asked
again too. No code of a user or of another package runs, and no model is asked.
"""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.agents.catalogue import recomputes, resolve
from lockprobe.errors import LockprobeError, ModelFault, UserMistake
from lockprobe.people.step_times import times_of_steps
from lockprobe.plan import Plan
from lockprobe.protocols import Agent
from lockprobe.record import Decision, Fact, Situation, Step, Trial
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.results import results
from lockprobe.storage.jsonl import has_checksum, whole_lines
from lockprobe.studies.branch import FORKS
from lockprobe.studies.call_log import read_calls
from lockprobe.studies.directory import RECORDS
from lockprobe.studies.play import play_timed
from lockprobe.studies.yoking import bound
from lockprobe.trial_json import trial_to_json

__all__ = ["Check", "as_written", "check_file", "verify"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One thing that was checked.

    Attributes:
        name: Its name.
        holds: Whether it holds.
        said: What was found, in one line.
        failed: What fails: keys of trials, or fields.
    """

    name: str
    holds: bool
    said: str
    failed: tuple[str, ...] = ()


def verify(directory: Path | str, *, tell: Callable[[int, int], None] = lambda done, of: None) -> tuple[Check, ...]:
    """Recompute a study from its records, and hold what lies in its directory against that.

    What models and people answered cannot be recomputed: it is taken from the records.

    Args:
        directory: The directory of a study.
        tell: Called with the number of trials played again, and of all.

    Returns:
        The checks in order. After settings or records that cannot be read there are no others.
    """
    directory = Path(directory)
    try:
        lines = sum(1 for _ in whole_lines(directory / RECORDS))
        opened = open_study(directory)
        times_of_steps(opened.study, opened.trials, opened.diaries, directory)  # diaries and records agree
        calls = len(list(read_calls(directory)))
    except LockprobeError as error:
        return (Check(name="records", holds=False, said=str(error)),)
    bare = [f"line {number}" for number, line in whole_lines(directory / RECORDS) if not has_checksum(line)]
    return (
        Check(
            name="records",
            holds=not bare,
            said=f"{len(bare)} lines without a checksum" if bare else f"{lines} lines and {calls} calls, unchanged",
            failed=tuple(bare),
        ),
        _settings(opened),
        _complete(opened),
        *_replayed(opened, tell),
        _results(directory),
    )


def _settings(opened: OpenedStudy) -> Check:
    """Whether all records are of this study: its seed, box, budget, conditions and panels."""
    foreign = opened.foreign + opened.journal.foreign
    said = f"all {len(opened.trials)} trials are of seed {opened.study.seed} and these settings"
    if foreign:
        first = f"; {opened.journal.first_foreign}" if opened.journal.first_foreign else ""
        said = f"{foreign} records are of another seed or of other settings{first}"
    return Check(name="settings", holds=not foreign, said=said)


def _complete(opened: OpenedStudy) -> Check:
    """Whether every planned trial of agents is there; participants owe none."""
    there = {trial.key for trial in opened.trials if not trial.owed_again}
    missing = [
        plan.key for agent in opened.study.run_agents for plan in opened.study.plans(agent) if plan.key not in there
    ]
    said = f"{len(missing)} planned trials are missing" if missing else "every planned trial is there"
    if opened.study.invited:
        played = sum(bool(trial.player) for trial in opened.trials)
        said += f"; of people {played} of {opened.study.invited}, who owe none"
    return Check(name="complete", holds=not missing, said=said, failed=tuple(missing))


def _replayed(opened: OpenedStudy, tell: Callable[[int, int], None]) -> Iterator[Check]:
    """Whether truth and reports follow from the choices, and choices from the agents that ship."""
    wrong, other, asked = list[str](), list[str](), 0
    by_key = {trial.key: trial for trial in opened.trials}
    for done, trial in enumerate(opened.trials, 1):
        plan, again = _plan(opened, trial, by_key), None
        if recomputes(trial.agent):
            asked += 1
            again = replace(asyncio.run(_played(plan, resolve(plan.agent).make())), replays=trial.replays)
        if again is None or trial_to_json(again) != trial_to_json(trial):
            other += [trial.key] if again else []
            why = _differs(trial, asyncio.run(_played(plan, _Recorded(trial))))
            wrong += [f"{trial.key}: {why}"] if why else []
        tell(done, len(opened.trials))
    said = f"{len(wrong)} trials do not follow" if wrong else f"all {len(opened.trials)} trials follow"
    yield Check(
        name="luck",
        holds=not wrong,
        said=f"{said} from their choices, the box and the seed",
        failed=tuple(wrong),
    )
    rest = len(opened.trials) - asked
    taken = f"; the choices of {rest} trials of models, people or your own agents cannot be recomputed" if rest else ""
    said = (
        f"{len(other)} of {asked} trials of strategies differ"
        if other
        else f"{asked} trials of strategies are the same"
    )
    yield Check(name="choices", holds=not other, said=f"{said} when they are asked again{taken}", failed=tuple(other))


def _plan(opened: OpenedStudy, trial: Trial, trials: Mapping[str, Trial]) -> Plan:
    condition = opened.study.condition_of(trial)
    assert condition is not None  # only trials that the settings ask for are opened
    plan = opened.study.plan(trial.agent, condition, trial.repetition, trial.trial)
    return bound(plan, opened.study, trials) or plan


class _Recorded:
    """An agent that chooses what is on record; at the end of a broken record it breaks too."""

    def __init__(self, trial: Trial) -> None:
        self._decisions = iter([step.decision for step in trial.steps])
        self.facts: Mapping[str, Fact] = trial.facts

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """The next choice on record."""
        for decision in self._decisions:
            return decision
        raise ModelFault("the record ends here")


async def _played(plan: Plan, agent: Agent) -> Trial:
    return (await play_timed(plan, agent, lambda key, step: None))[0]


def _differs(trial: Trial, again: Trial) -> str | None:
    """What of a trial does not follow from its choices; None if all does. Broken trials count up to their break."""
    for before, now in zip(trial.steps, again.steps, strict=False):
        if before != now:
            changed = [one.name for one in fields(Step) if getattr(before, one.name) != getattr(now, one.name)]
            return f"step {before.step}, {', '.join(changed)}"
    compared = ["joints", "labels", "listing", "opening", "opening_pictures"]
    compared += ["ending", "steps"] if trial.ending != "error" else []
    return next((name for name in compared if getattr(trial, name) != getattr(again, name)), None)


def _results(directory: Path) -> Check:
    """Whether ``results.json`` is what the records give; forks that were played after it are said to be."""
    path, forks = directory / "results.json", directory / FORKS / RECORDS
    check = check_file("results", path, lambda: as_written(results(directory).plain(), path))
    of_forks = check.failed and all(re.match(r"forks(_said)?\b", name) for name in check.failed)
    if of_forks and forks.is_file() and forks.stat().st_mtime > path.stat().st_mtime:
        return replace(check, said=f"forks were played after {path.name} was written: lockprobe report first")
    return check


def as_written(content: dict[str, Any], path: Path) -> dict[str, Any]:
    """The results with the sections that the file says are missing: drawing, which can fail too, is not done again."""
    written = json.loads(path.read_text("utf-8"))
    missing = written.get("sections_left_out", []) if isinstance(written, dict) else []
    content = {name: value for name, value in content.items() if name != "sections_left_out"}
    return content | ({"sections_left_out": missing} if missing else {})


def check_file(name: str, path: Path, compute: Callable[[], Mapping[str, Any]]) -> Check:
    """Whether a file of results, if there is one, holds what is computed from the records."""
    try:
        written = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        return Check(name=name, holds=True, said=f"there is no {path.name} to compare")
    except ValueError as error:
        return Check(name=name, holds=False, said=f"{path.name} is damaged ({error})")
    try:
        found = compute()
    except UserMistake as error:
        return Check(name=name, holds=False, said=str(error))
    if isinstance(written, dict) and written.get("lockprobe") != found["lockprobe"]:
        release = written.get("lockprobe")
        return Check(name=name, holds=False, said=f"{path.name} is of release {release}: lockprobe report first")
    different = tuple(_different(written, found))
    said = f"{len(different)} values of {path.name} differ" if different else f"{path.name} is what the records give"
    return Check(name=name, holds=not different, said=said, failed=different)


def _different(written: Any, found: Any, where: str = "") -> Iterator[str]:
    """The places at which two JSON values differ."""
    if isinstance(written, Mapping) and isinstance(found, Mapping):
        for name in dict.fromkeys([*written, *found]):
            yield from _different(written.get(name), found.get(name), f"{where}.{name}" if where else name)
    elif _listed(written) and _listed(found) and len(written) == len(found):
        for i, (one, other) in enumerate(zip(written, found, strict=True)):
            yield from _different(one, other, f"{where}[{i}]")
    elif written != found:
        yield where


def _listed(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str)
