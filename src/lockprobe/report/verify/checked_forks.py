"""Forks played again and held against the trials of which they are forks, their calls and their next choices."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Mapping
from pathlib import Path

from lockprobe.agents.catalogue import is_strategy, resolve
from lockprobe.agents.policy import Policy
from lockprobe.foundation.errors import UserMistake
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.verify.check import Check, check_of
from lockprobe.report.verify.checked_replies import CallEvidence, replies_check
from lockprobe.report.verify.replayed_trials import Replay, ReplayedTrial
from lockprobe.studies.branch import FORKS, fork_plan
from lockprobe.studies.next_choice import next_choice
from lockprobe.studies.options.settings import read_study
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_name import ForkName


def fork_checks(opened: OpenedStudy, evidence: CallEvidence) -> Iterator[Check]:
    """Whether forks follow from the records of their trials; nothing without forks.

    Args:
        opened: The study with its forks.
        evidence: The calls of the study, which forks share.

    Raises:
        BadFile: If a file of the forks is damaged.
    """
    directory = opened.directory / FORKS
    if not opened.forks:
        return
    own, trials = CallEvidence.of(directory), {trial.key: trial for trial in opened.trials}
    again = []
    with asyncio.Runner() as runner:
        replay = Replay(runner)
        for fork in opened.forks:
            planned = _planned(opened, fork, trials)
            if isinstance(planned, str):
                again.append(ReplayedTrial(key=fork.key, kind="own", luck=planned))
            else:
                name, plan = planned
                again.append(replay(plan, fork, own.kept.get(fork.key, ()), evidence.kept.get(name.parent, ())))
    failed = [
        *_another_study(opened, directory),
        *(  # replies of hosted models have a check of their own
            f"{one.key}: {one.luck or one.choices}"
            for one in again
            if one.luck or (one.choices and one.kind != "hosted")
        ),
        *_other_choices(opened, trials),
    ]
    holds = f"all {len(again)} forks follow from their trials, their choices and the seed"
    yield check_of("forks", failed, holds, "forks do not follow from their trials, their choices and the seed")
    yield from replies_check(directory, opened.forks, own, again, {}, "fork replies")


def _planned(opened: OpenedStudy, fork: Trial, trials: Mapping[str, Trial]) -> tuple[ForkName, Plan] | str:
    """The name and the plan of a fork, or why it has none."""
    name = fork.fork
    if name is None or name.parent not in trials:
        return "it is a fork of no trial on record"
    try:
        return name, fork_plan(opened.study, trials[name.parent], name)
    except (UserMistake, ValueError, StopIteration) as error:  # an unknown arm; a trial that is none of its condition
        return f"its trial cannot be forked so ({str(error) or 'its record is another one'})"


def _another_study(opened: OpenedStudy, directory: Path) -> Iterator[str]:
    there = read_study(directory)
    if [there.record_identity(one) for one in there.conditions] != [
        opened.study.record_identity(one) for one in opened.study.conditions
    ]:
        yield f"{FORKS}/study.json: the settings of another study"


def _other_choices(opened: OpenedStudy, trials: Mapping[str, Trial]) -> Iterator[str]:
    """Forks whose probabilities of the next choice are not those of their strategy."""
    on_record = {fork.key: fork for fork in opened.forks}
    for key, chances in opened.choices.items():
        fork = on_record.get(key)
        planned = _planned(opened, fork, trials) if fork else "no fork on record has it"
        if fork is None or isinstance(planned, str):
            yield f"{key}: a next choice, but {planned}"
            continue
        name, plan = planned
        policy = resolve(fork.agent).make() if is_strategy(fork.agent) else None
        if not isinstance(policy, Policy) or asyncio.run(next_choice(plan, policy, name.at)) != chances:
            yield f"{key}: another next choice than its strategy has"
